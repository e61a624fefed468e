//! How wide the gel is open around a vertical line, depth by depth.

use crate::algebra::Vector3;
use crate::scene::Dimension;
use crate::simulation::Frame;

/// A piece of the surface of the gel at a depth, seen from the line.
type Piece = [nalgebra::Vector2<f64>; 2];

/// Equally spaced depths, the first of them one distance below z = 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Depths {
    /// How many.
    pub(super) n: usize,
    /// How many there are in a metre.
    pub(super) per_metre: f64,
}

/// Radius of the opening at some depths, m: 0 where the line runs through gel, none where there is no gel
/// around it.
///
/// Along the axis it is the least radius of the gel, in the plane half of the width, in space the distance of the surface.
pub(super) fn openings(dimension: Dimension, frame: &Frame, line: &Vector3, at: Depths) -> Vec<Option<f64>> {
    let mut depths: Vec<Vec<Piece>> = vec![vec![]; at.n];
    for nodes in &frame.cells.facets {
        let corners = nodes.map(|node| frame.points[node as usize] - line);
        cut(&corners[..frame.dimension], line.z, at.per_metre, &mut depths);
    }
    let opening = match dimension {
        Dimension::Planar => half_width,
        Dimension::Axisymmetric | Dimension::Spatial => distance,
    };
    depths.iter().map(|pieces| if is_inside(pieces) { Some(0.0) } else { opening(pieces) }).collect()
}

/// Adds what a facet, given from a point at this height, is at each depth that it crosses.
fn cut(corners: &[Vector3], height: f64, per_metre: f64, depths: &mut [Vec<Piece>]) {
    let down = |corner: &Vector3| -(corner.z + height) * per_metre;
    let (least, most) =
        corners.iter().map(down).fold((f64::INFINITY, 0.0f64), |(least, most), k| (least.min(k), most.max(k)));
    let first = least.max(1.0).ceil() as usize;
    for k in first..=(most as usize).min(depths.len()) {
        let z = -(k as f64 / per_metre) - height;
        let sides = corners.iter().zip(corners.iter().cycle().skip(1)).take(if corners.len() == 2 { 1 } else { 3 });
        let mut ends = sides.filter_map(|(a, b)| crossing(a, b, z));
        if let Some(a) = ends.next() {
            depths[k - 1].push([a, ends.next().unwrap_or(a)]);
        }
    }
}

/// Where an edge crosses a height; of its two ends one counts as below.
fn crossing(a: &Vector3, b: &Vector3, z: f64) -> Option<nalgebra::Vector2<f64>> {
    let crosses = (a.z > z) != (b.z > z);
    crosses.then(|| (a + (b - a) * ((z - a.z) / (b.z - a.z))).xy())
}

/// Whether the line is in the gel: what goes from it towards +x leaves the gel once more than it enters.
fn is_inside(pieces: &[Piece]) -> bool {
    let crossed = |[a, b]: &&Piece| {
        if a == b {
            return a.x > 0.0;
        }
        (a.y > 0.0) != (b.y > 0.0) && a.x - a.y * (b.x - a.x) / (b.y - a.y) > 0.0
    };
    pieces.iter().filter(crossed).count() % 2 == 1
}

/// From the line to the nearest piece.
fn distance(pieces: &[Piece]) -> Option<f64> {
    let to = |[a, b]: &Piece| {
        let along = b - a;
        let share = if a == b { 0.0 } else { (-a.dot(&along) / along.norm_squared()).clamp(0.0, 1.0) };
        (a + share * along).norm()
    };
    pieces.iter().map(to).reduce(f64::min)
}

/// Half of what is open between gel on the left and gel on the right.
fn half_width(pieces: &[Piece]) -> Option<f64> {
    let right = pieces.iter().map(|[a, _]| a.x).filter(|x| *x >= 0.0).reduce(f64::min);
    let left = pieces.iter().map(|[a, _]| a.x).filter(|x| *x < 0.0).reduce(f64::max);
    right.zip(left).map(|(right, left)| 0.5 * (right - left))
}

#[cfg(test)]
mod tests {
    use super::{Depths, openings};
    use crate::algebra::Vector3;
    use crate::scene::Dimension;
    use crate::simulation::{Frame, FrameCells};

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
        let found =
            openings(Dimension::Axisymmetric, &frame(2, &[&cone, &wall(0.01, 0.1)]), &Vector3::zeros(), millimetres(5));
        for (found, expected) in found.iter().zip([0.003, 0.002, 0.001, 0.0, 0.0]) {
            assert!((found.unwrap() - expected).abs() < 1e-15, "{found:?}, {expected}");
        }
    }

    #[test]
    fn in_the_plane_it_is_half_of_what_is_open() {
        let walls = [wall(-0.02, 0.1), wall(-0.001, 0.0025), wall(0.006, 0.0025), wall(0.02, 0.1)];
        let walls: Vec<&[[f64; 3]]> = walls.iter().map(|wall| &wall[..]).collect();
        let line = Vector3::new(0.002, 0.0, 0.01);
        let found = openings(Dimension::Planar, &frame(2, &walls), &line, millimetres(4));
        assert!((found[0].unwrap() - 0.0035).abs() < 1e-15, "{found:?}");
        assert_eq!((found[2], found[3]), (Some(0.0), Some(0.0)));
        let one_side =
            openings(Dimension::Planar, &frame(2, &[&wall(0.02, 0.1), &wall(0.03, 0.1)]), &line, millimetres(1));
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
        let found = openings(Dimension::Spatial, &frame(3, &facets), &Vector3::new(0.001, 0.0005, 0.0), millimetres(4));
        for opening in &found[..3] {
            assert!((opening.unwrap() - 0.004).abs() < 1e-15, "{found:?}");
        }
        assert_eq!(found[3], Some(0.0));
    }
}
