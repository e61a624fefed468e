//! How wide the gel is open around a vertical line, depth by depth.

use crate::math::Vector3;
use crate::scene::{Dimension, Symmetry};
use crate::simulation::Frame;
use nalgebra::Vector2;
use std::f64::consts::TAU;

/// A section of the surface of the gel at a depth, seen from the line.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SurfacePiece {
    ends: [Vector2<f64>; 2],
    /// Tells that the facet faces down: it is part of the back face, or of a column of gel that is driven out of it.
    faces_down: bool,
}

/// What is computed of the gel whose openings are looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GelSection {
    /// Space that the gel lives in.
    pub(super) dimension: Dimension,
    /// Part of it that is computed.
    pub(super) symmetry: Symmetry,
}

/// Equally spaced depths, the first of them one distance below z = 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Depths {
    /// How many.
    pub(super) n: usize,
    /// How many there are in a metre.
    pub(super) per_metre: f64,
}

/// Steepest slope of a back face, as the vertical part of its normal: a wall of the cavity that faces down by less flares out
/// towards an exit hole, one that faces down by more is what is left around the hole (45°).
const BACK_FACE: f64 = -std::f64::consts::FRAC_1_SQRT_2;
/// Directions in which gel must lie around a line in space, in all of a circle.
const DIRECTIONS: u32 = 64;

/// Radius of the opening at some depths, m: 0 where the line runs through gel, none where the void around the line is not enclosed
/// by gel.
///
/// Along the axis it is the least radius of the gel, in the plane half of the width, in space the distance of the surface. A void is
/// enclosed if there is gel in every direction across the line. The outer side of the gel is no wall of a cavity: at the back, all depths
/// up to the first are left out whose void ends at a surface that faces down.
pub(super) fn openings(gel: GelSection, frame: &Frame, line: &Vector3, at: Depths) -> Vec<Option<f64>> {
    let mut depths: Vec<Vec<SurfacePiece>> = vec![vec![]; at.n];
    for nodes in &frame.cells.facets {
        let corners = nodes.map(|node| frame.points[node as usize] - line);
        cut(&corners[..frame.dimension], line.z, at.per_metre, &mut depths);
    }
    let mut openings: Vec<Option<Opening>> = depths.iter().map(|pieces| opening(gel, pieces)).collect();
    let is_outside = |opening: &Option<Opening>| opening.is_none_or(|opening| opening.faces_down);
    let inside = openings.iter().rposition(|opening| !is_outside(opening)).map_or(0, |last| last + 1);
    openings[inside..].fill(None);
    openings.iter().map(|opening| opening.map(|opening| opening.radius)).collect()
}

/// The void around the line at a depth.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Opening {
    /// Its radius, m.
    radius: f64,
    /// Tells that it ends at a surface that faces down.
    faces_down: bool,
}

/// The void at a depth; none if it is not enclosed by gel.
fn opening(gel: GelSection, pieces: &[SurfacePiece]) -> Option<Opening> {
    if is_inside(pieces) {
        return Some(Opening { radius: 0.0, faces_down: false });
    }
    match gel.dimension {
        Dimension::Planar => half_width(pieces),
        Dimension::Axisymmetric => nearest(pieces),
        Dimension::Spatial => nearest(pieces).filter(|_| is_enclosed(gel.symmetry, pieces)),
    }
}

/// Adds what a facet, given from a point at this height, is at each depth that it crosses.
fn cut(corners: &[Vector3], height: f64, per_metre: f64, depths: &mut [Vec<SurfacePiece>]) {
    let down = |corner: &Vector3| -(corner.z + height) * per_metre;
    let (least, most) =
        corners.iter().map(down).fold((f64::INFINITY, 0.0f64), |(least, most), k| (least.min(k), most.max(k)));
    let first = least.max(1.0).ceil() as usize;
    let faces_down = normal(corners).z < BACK_FACE;
    for k in first..=(most as usize).min(depths.len()) {
        let z = -(k as f64 / per_metre) - height;
        let sides = corners.iter().zip(corners.iter().cycle().skip(1)).take(if corners.len() == 2 { 1 } else { 3 });
        let mut ends = sides.filter_map(|(a, b)| crossing(a, b, z));
        if let Some(a) = ends.next() {
            depths[k - 1].push(SurfacePiece { ends: [a, ends.next().unwrap_or(a)], faces_down });
        }
    }
}

/// Unit normal of a facet out of the gel; zero of one without extent.
fn normal(corners: &[Vector3]) -> Vector3 {
    let along = corners[1] - corners[0];
    let across = if corners.len() == 2 { -Vector3::y() } else { corners[2] - corners[0] };
    along.cross(&across).try_normalize(0.0).unwrap_or_else(Vector3::zeros)
}

/// Where an edge crosses a height; of its two ends one counts as below.
fn crossing(a: &Vector3, b: &Vector3, z: f64) -> Option<Vector2<f64>> {
    let crosses = (a.z > z) != (b.z > z);
    crosses.then(|| (a + (b - a) * ((z - a.z) / (b.z - a.z))).xy())
}

/// Whether the line is in the gel: what goes from it towards +x leaves the gel once more than it enters.
fn is_inside(pieces: &[SurfacePiece]) -> bool {
    let crossed = |SurfacePiece { ends: [a, b], .. }: &&SurfacePiece| {
        if a == b {
            return a.x > 0.0;
        }
        (a.y > 0.0) != (b.y > 0.0) && a.x - a.y * (b.x - a.x) / (b.y - a.y) > 0.0
    };
    pieces.iter().filter(crossed).count() % 2 == 1
}

/// The void up to the nearest piece.
fn nearest(pieces: &[SurfacePiece]) -> Option<Opening> {
    let to = |piece: &SurfacePiece| {
        let [a, b] = piece.ends;
        let along = b - a;
        let share = if a == b { 0.0 } else { (-a.dot(&along) / along.norm_squared()).clamp(0.0, 1.0) };
        Opening { radius: (a + share * along).norm(), faces_down: piece.faces_down }
    };
    pieces.iter().map(to).reduce(|a, b| if b.radius < a.radius { b } else { a })
}

/// Returns true if there is gel in every direction from the line, as far as the gel is computed.
fn is_enclosed(symmetry: Symmetry, pieces: &[SurfacePiece]) -> bool {
    let computed = DIRECTIONS / symmetry.copies() as u32;
    (0..computed).all(|i| {
        // Between the planes of symmetry, in which a direction would run along facets.
        let (sin, cos) = libm::sincos((f64::from(i) + 0.5) * TAU / f64::from(DIRECTIONS));
        let direction = Vector2::new(cos, sin);
        pieces.iter().any(|piece| is_met(&direction, piece))
    })
}

/// Returns true if a ray from the line meets a piece.
fn is_met(direction: &Vector2<f64>, piece: &SurfacePiece) -> bool {
    let [a, b] = piece.ends.map(|end| Vector2::new(direction.dot(&end), direction.perp(&end)));
    (a.y > 0.0) != (b.y > 0.0) && a.x - a.y * (b.x - a.x) / (b.y - a.y) > 0.0
}

/// Half of what is open between gel on the left and gel on the right.
fn half_width(pieces: &[SurfacePiece]) -> Option<Opening> {
    let x = |piece: &&SurfacePiece| piece.ends[0].x;
    let right = pieces.iter().filter(|piece| x(piece) >= 0.0).min_by(|a, b| x(a).total_cmp(&x(b)))?;
    let left = pieces.iter().filter(|piece| x(piece) < 0.0).max_by(|a, b| x(a).total_cmp(&x(b)))?;
    let radius = 0.5 * (right.ends[0].x - left.ends[0].x);
    Some(Opening { radius, faces_down: right.faces_down || left.faces_down })
}

#[cfg(test)]
mod tests {
    use super::{Depths, GelSection, openings};
    use crate::math::Vector3;
    use crate::scene::{Dimension, Symmetry};
    use crate::simulation::{Frame, FrameCells};

    fn section(dimension: Dimension) -> GelSection {
        GelSection { dimension, symmetry: Symmetry::None }
    }

    /// The first `n` millimetres.
    fn millimetres(n: usize) -> Depths {
        Depths { n, per_metre: 1e3 }
    }

    /// A surface of these facets.
    fn frame(dimension: usize, facets: &[&[[f64; 3]]]) -> Frame {
        let corners = facets.iter().flat_map(|facet| facet.iter().map(|corner| Vector3::from(*corner)));
        let facet = |i: usize| [0, 1, 2 * (dimension - 2)].map(|k| (dimension * i + k) as u32);
        Frame {
            time: 0.0,
            dimension,
            mass: 1.0,
            points: corners.collect(),
            velocities: vec![],
            displacements: vec![],
            cells: FrameCells {
                nodes: vec![],
                step: vec![],
                jacobian: vec![],
                energy_density: vec![],
                facets: (0..facets.len()).map(facet).collect(),
            },
            bodies: vec![],
        }
    }

    /// A wall at x that goes down to a depth, m.
    fn wall(x: f64, depth: f64) -> [[f64; 3]; 2] {
        [[x, 0.0, 0.001], [x, 0.0, -depth]]
    }

    #[test]
    fn about_an_axis_it_is_the_least_radius_and_zero_where_there_is_gel_on_the_axis() {
        let cone = [[0.004, 0.0, 0.0], [0.0, 0.0, -0.004]];
        let found = openings(
            section(Dimension::Axisymmetric),
            &frame(2, &[&cone, &wall(0.01, 0.1)]),
            &Vector3::zeros(),
            millimetres(5),
        );
        for (found, expected) in found.iter().zip([0.003, 0.002, 0.001, 0.0, 0.0]) {
            assert!((found.unwrap() - expected).abs() < 1e-15, "{found:?}, {expected}");
        }
    }

    #[test]
    fn in_the_plane_it_is_half_of_what_is_open() {
        let walls = [wall(-0.02, 0.1), wall(-0.001, 0.0025), wall(0.006, 0.0025), wall(0.02, 0.1)];
        let walls: Vec<&[[f64; 3]]> = walls.iter().map(|wall| &wall[..]).collect();
        let line = Vector3::new(0.002, 0.0, 0.01);
        let found = openings(section(Dimension::Planar), &frame(2, &walls), &line, millimetres(4));
        assert!((found[0].unwrap() - 0.0035).abs() < 1e-15, "{found:?}");
        assert_eq!((found[2], found[3]), (Some(0.0), Some(0.0)));
        let sides = frame(2, &[&wall(0.02, 0.1), &wall(0.03, 0.1)]);
        let one_side = openings(section(Dimension::Planar), &sides, &line, millimetres(1));
        assert_eq!(one_side, [None]);
    }

    /// The four sides of a shaft of this half width about the z axis, down to a depth, m.
    fn shaft(a: f64, depth: f64) -> Vec<[[f64; 3]; 3]> {
        let corners = [[a, a], [-a, a], [-a, -a], [a, -a]];
        let sides = (0..4).map(|i| (corners[i], corners[(i + 1) % 4]));
        let at = |[x, y]: [f64; 2], z: f64| [x, y, z];
        sides
            .flat_map(|(p, q)| [[at(p, 0.0), at(q, 0.0), at(p, -depth)], [at(q, 0.0), at(q, -depth), at(p, -depth)]])
            .collect()
    }

    #[test]
    fn in_space_it_is_the_distance_of_the_nearest_surface() {
        let surface: Vec<[[f64; 3]; 3]> = shaft(0.02, 0.1).into_iter().chain(shaft(0.005, 0.0035)).collect();
        let facets: Vec<&[[f64; 3]]> = surface.iter().map(|facet| &facet[..]).collect();
        let line = Vector3::new(0.001, 0.0005, 0.0);
        let found = openings(section(Dimension::Spatial), &frame(3, &facets), &line, millimetres(4));
        for opening in &found[..3] {
            assert!((opening.unwrap() - 0.004).abs() < 1e-15, "{found:?}");
        }
        assert_eq!(found[3], Some(0.0));
    }

    /// The section of a gel of 50 mm radius and 12 mm depth about the axis, its surface run through with the gel on the left, from the
    /// entry down a hole of 5 mm radius to the back face, which has sunk around the hole.
    fn dished(hole: &[[f64; 2]]) -> Vec<[[f64; 3]; 2]> {
        let rest = [[0.048, -0.011], [0.05, -0.012], [0.05, 0.0], [0.005, 0.0]];
        let points: Vec<[f64; 3]> =
            [[0.005, 0.0]].iter().chain(hole).chain(&rest).map(|[x, z]| [*x, 0.0, *z]).collect();
        points.windows(2).map(|ends| [ends[0], ends[1]]).collect()
    }

    #[test]
    fn what_is_open_below_the_back_face_is_no_cavity() {
        let open = |hole: &[[f64; 2]]| {
            let facets = dished(hole);
            let facets: Vec<&[[f64; 3]]> = facets.iter().map(|facet| &facet[..]).collect();
            openings(section(Dimension::Axisymmetric), &frame(2, &facets), &Vector3::zeros(), millimetres(14))
        };
        // A hole straight through: the back face around it, up to 48 mm off the line, is none of its wall.
        let found = open(&[[0.005, -0.0095]]);
        assert_eq!(found[9..], [None; 5], "{found:?}");
        assert!(found[..9].iter().all(|radius| (radius.unwrap() - 0.005).abs() < 1e-15), "{found:?}");
        // A hole that flares out by less than 45° is wall down to its edge.
        let found = open(&[[0.005, -0.006], [0.008, -0.01]]);
        assert!((found[7].unwrap() - 0.0065).abs() < 1e-15 && found[9].is_some(), "{found:?}");
        assert_eq!(found[10..], [None; 4], "{found:?}");
    }

    #[test]
    fn a_void_that_is_open_to_the_side_is_no_cavity() {
        let wall = |[x, y]: [f64; 2], [u, v]: [f64; 2]| [[x, y, 0.001], [u, v, 0.001], [x, y, -0.01]];
        let back = |[x, y]: [f64; 2], [u, v]: [f64; 2]| [[u, v, 0.001], [u, v, -0.01], [x, y, -0.01]];
        let around = |corners: &[[f64; 2]]| -> Vec<[[f64; 3]; 3]> {
            let outer: Vec<[f64; 2]> = corners.iter().map(|[x, y]| [5.0 * x, 5.0 * y]).collect();
            let sides = corners.windows(2).chain(outer.windows(2));
            sides.flat_map(|ends| [wall(ends[0], ends[1]), back(ends[0], ends[1])]).collect()
        };
        let open = |symmetry: Symmetry, corners: &[[f64; 2]]| {
            let walls = around(corners);
            let facets: Vec<&[[f64; 3]]> = walls.iter().map(|facet| &facet[..]).collect();
            let gel = GelSection { dimension: Dimension::Spatial, symmetry };
            openings(gel, &frame(3, &facets), &Vector3::zeros(), millimetres(5))
        };
        let half = [[0.004, 0.0], [0.004, 0.006], [-0.004, 0.006], [-0.004, 0.0]];
        let whole = [&half[..], &[[-0.004, -0.006], [0.004, -0.006], [0.004, 0.0]]].concat();
        for (symmetry, corners) in
            [(Symmetry::None, &whole[..]), (Symmetry::Half, &half), (Symmetry::Quarter, &half[..3])]
        {
            let found = open(symmetry, corners);
            assert!(found.iter().all(|radius| (radius.unwrap() - 0.004).abs() < 1e-15), "{symmetry:?}: {found:?}");
        }
        // Open towards −y, as beside four columns of which one is missing.
        assert_eq!(open(Symmetry::None, &half), [None; 5]);
    }
}
