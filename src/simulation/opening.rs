//! Radius of the void in the gel around a vertical line, depth by depth.

use super::cross_section::{CrossSection, SectionSegment, VoidWall, crosses_ray};
use crate::math::Vector3;
use crate::scene::{Dimension, GelSymmetry};
use nalgebra::Vector2;
use std::f64::consts::PI;

/// Intersection of a facet of the gel surface with a horizontal plane, relative to the line.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SurfacePiece {
    /// Ends; in space in the direction that has the gel on its left.
    ends: SectionSegment,
    /// True for a facet with a downward normal: part of the back face, or of a column of gel driven out of the back
    /// face.
    faces_down: bool,
}

/// Dimension and symmetry of the computed gel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GelSection {
    /// Dimension of the scene.
    pub dimension: Dimension,
    /// Symmetry that reduces the computed part of the gel.
    pub symmetry: GelSymmetry,
}

/// Equally spaced depths below z = 0; the first depth is one interval.
#[derive(Debug, Clone, Copy)]
pub struct DepthGrid {
    /// Number of depths.
    pub n: usize,
    /// Number of depths per metre.
    pub per_metre: f64,
}

/// Vertical component of the unit normal that separates the back face from the cavity wall (45°). A wall with a
/// flatter normal flares out towards an exit hole; a steeper normal belongs to the back face around the hole.
const BACK_FACE: f64 = -std::f64::consts::FRAC_1_SQRT_2;

/// Computes the radius of the void at each depth, m: 0 where the line runs through gel, `None` where gel does not
/// enclose the void.
///
/// The radius is the least radius of the gel in an axisymmetric scene, half of the width in a plane scene, and in space
/// the radius √(A/π) of the circle with the area A of the void's cross-section. A void is enclosed if gel lies in every
/// direction across the line. In space the void is followed where a projectile that turned over has left the line: where
/// gel lies on the line, the void is the one that overlaps the void above. The outer surface of the gel is no cavity wall. At the back, the depths whose void ends at a downward facet are therefore
/// left out, up to the first void that ends at a cavity wall.
///
/// `facets` are the corners of the surface as they are seen from the block, outward oriented; a plane or axisymmetric
/// facet has two.
#[must_use]
pub fn void_radii(
    gel: GelSection,
    facets: impl Iterator<Item = [Vector3; 3]>,
    line: &Vector3,
    at: DepthGrid,
) -> Vec<Option<f64>> {
    let n_corners = if gel.dimension == Dimension::Spatial { 3 } else { 2 };
    let mut depths: Vec<Vec<SurfacePiece>> = vec![vec![]; at.n];
    for facet in facets {
        let corners = facet.map(|corner| corner - line);
        add_intersections(&corners[..n_corners], line.z, at.per_metre, &mut depths);
    }
    let mut above = None;
    let mut voids: Vec<Option<VoidOpening>> =
        depths.iter().map(|pieces| void_at_depth(gel, pieces, &mut above)).collect();
    let is_open_outside = |opening: &Option<VoidOpening>| opening.is_none_or(|opening| opening.faces_down);
    let inside = voids.iter().rposition(|opening| !is_open_outside(opening)).map_or(0, |last| last + 1);
    voids[inside..].fill(None);
    voids.iter().map(|opening| opening.map(|opening| opening.radius)).collect()
}

/// Void around the line at a depth.
#[derive(Debug, Clone, Copy, PartialEq)]
struct VoidOpening {
    /// Radius of the void, m.
    radius: f64,
    /// True if the nearest surface faces down.
    faces_down: bool,
}

/// Returns the void at a depth; `None` if gel does not enclose the void. `above` is the void in space at the depth above,
/// and then at this depth.
fn void_at_depth(gel: GelSection, pieces: &[SurfacePiece], above: &mut Option<VoidWall>) -> Option<VoidOpening> {
    let closed = VoidOpening { radius: 0.0, faces_down: false };
    let is_in_gel = is_line_in_gel(pieces);
    match gel.dimension {
        Dimension::Planar | Dimension::Axisymmetric if is_in_gel => Some(closed),
        Dimension::Planar => half_gap(pieces),
        Dimension::Axisymmetric => nearest_void(pieces, Vector2::zeros()),
        Dimension::Spatial if is_in_gel && above.is_none() => Some(closed),
        Dimension::Spatial => {
            let segments: Vec<SectionSegment> = pieces.iter().map(|piece| piece.ends).collect();
            let section = CrossSection::of(gel.symmetry, &segments);
            let around = if is_in_gel { None } else { section.void_around_origin() };
            let last = above.take();
            *above = around.or_else(|| section.void_beside(&last?));
            let Some(wall) = above else { return is_in_gel.then_some(closed) };
            let radius = (wall.area / PI).sqrt();
            nearest_void(pieces, wall.middle()).map(|nearest| VoidOpening { radius, ..nearest })
        }
    }
}

/// Adds the intersections of a facet with all depths between its corners. The corners are relative to a point at
/// `height`, m.
fn add_intersections(corners: &[Vector3], height: f64, per_metre: f64, depths: &mut [Vec<SurfacePiece>]) {
    let down = |corner: &Vector3| -(corner.z + height) * per_metre;
    let (least, most) =
        corners.iter().map(down).fold((f64::INFINITY, 0.0f64), |(least, most), k| (least.min(k), most.max(k)));
    let first = least.max(1.0).ceil() as usize;
    let faces_down = normal(corners).z < BACK_FACE;
    for k in first..=(most as usize).min(depths.len()) {
        let z = -(k as f64 / per_metre) - height;
        let sides = corners.iter().zip(corners.iter().cycle().skip(1)).take(if corners.len() == 2 { 1 } else { 3 });
        let down = sides.clone().find(|(a, b)| a.z > z && b.z <= z).map(|(a, b)| intersect_edge(a, b, z));
        let up = sides.clone().find(|(a, b)| a.z <= z && b.z > z).map(|(a, b)| intersect_edge(b, a, z));
        if let (Some(start), Some(end)) = (down.or(up), up.or(down)) {
            depths[k - 1].push(SurfacePiece { ends: [start, end], faces_down });
        }
    }
}

/// Returns the outward unit normal of a facet; zero for a degenerate facet.
fn normal(corners: &[Vector3]) -> Vector3 {
    let along = corners[1] - corners[0];
    let across = if corners.len() == 2 { -Vector3::y() } else { corners[2] - corners[0] };
    along.cross(&across).try_normalize(0.0).unwrap_or_else(Vector3::zeros)
}

/// Returns the intersection of an edge with a height. The bits are those of every facet at the edge.
fn intersect_edge(upper: &Vector3, lower: &Vector3, z: f64) -> Vector2<f64> {
    (upper + (lower - upper) * ((z - upper.z) / (lower.z - upper.z))).xy()
}

/// Returns true if the line is inside the gel: a ray towards +x then crosses the surface an odd number of times.
fn is_line_in_gel(pieces: &[SurfacePiece]) -> bool {
    let is_crossed = |SurfacePiece { ends, .. }: &&SurfacePiece| {
        if ends[0] == ends[1] { ends[0].x > 0.0 } else { crosses_ray(ends) }
    };
    pieces.iter().filter(is_crossed).count() % 2 == 1
}

/// Returns the void from a point up to the nearest piece of the surface.
fn nearest_void(pieces: &[SurfacePiece], from: Vector2<f64>) -> Option<VoidOpening> {
    let to = |piece: &SurfacePiece| {
        let [a, b] = piece.ends.map(|end| end - from);
        let along = b - a;
        let share = if a == b { 0.0 } else { (-a.dot(&along) / along.norm_squared()).clamp(0.0, 1.0) };
        VoidOpening { radius: (a + share * along).norm(), faces_down: piece.faces_down }
    };
    pieces.iter().map(to).reduce(|a, b| if b.radius < a.radius { b } else { a })
}

/// Returns half of the gap between the gel on the left and the gel on the right.
fn half_gap(pieces: &[SurfacePiece]) -> Option<VoidOpening> {
    let x = |piece: &&SurfacePiece| piece.ends[0].x;
    let right = pieces.iter().filter(|piece| x(piece) >= 0.0).min_by(|a, b| x(a).total_cmp(&x(b)))?;
    let left = pieces.iter().filter(|piece| x(piece) < 0.0).max_by(|a, b| x(a).total_cmp(&x(b)))?;
    let radius = 0.5 * (right.ends[0].x - left.ends[0].x);
    Some(VoidOpening { radius, faces_down: right.faces_down || left.faces_down })
}

#[cfg(test)]
mod tests {
    use super::{DepthGrid, GelSection, PI, void_radii};
    use crate::math::Vector3;
    use crate::scene::{Dimension, GelSymmetry};

    fn section(dimension: Dimension) -> GelSection {
        GelSection { dimension, symmetry: GelSymmetry::None }
    }

    /// Returns the first `n` depths in millimetres.
    fn millimetres(n: usize) -> DepthGrid {
        DepthGrid { n, per_metre: 1e3 }
    }

    /// Returns the corners of facets as the gel has them: a third one that a flat facet does not use.
    fn facets<const N: usize>(facets: &[[[f64; 3]; N]]) -> std::vec::IntoIter<[Vector3; 3]> {
        let corners = |facet: &[[f64; 3]; N]| std::array::from_fn(|i| Vector3::from(facet[i.min(N - 1)]));
        facets.iter().map(corners).collect::<Vec<_>>().into_iter()
    }

    /// Returns a wall at x from above the entry down to a depth, m.
    fn wall(x: f64, depth: f64) -> [[f64; 3]; 2] {
        [[x, 0.0, 0.001], [x, 0.0, -depth]]
    }

    #[test]
    fn about_an_axis_it_is_the_least_radius_and_zero_where_there_is_gel_on_the_axis() {
        let cone = [[0.004, 0.0, 0.0], [0.0, 0.0, -0.004]];
        let found = void_radii(
            section(Dimension::Axisymmetric),
            facets(&[cone, wall(0.01, 0.1)]),
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
        let line = Vector3::new(0.002, 0.0, 0.01);
        let found = void_radii(section(Dimension::Planar), facets(&walls), &line, millimetres(4));
        assert!((found[0].unwrap() - 0.0035).abs() < 1e-15, "{found:?}");
        assert_eq!((found[2], found[3]), (Some(0.0), Some(0.0)));
        let sides = facets(&[wall(0.02, 0.1), wall(0.03, 0.1)]);
        let one_side = void_radii(section(Dimension::Planar), sides, &line, millimetres(1));
        assert_eq!(one_side, [None]);
    }

    /// Returns the four sides of a shaft of half width `a` about the z axis, down to a depth, m.
    fn shaft(a: f64, depth: f64) -> Vec<[[f64; 3]; 3]> {
        let corners = [[a, a], [-a, a], [-a, -a], [a, -a]];
        let sides = (0..4).map(|i| (corners[i], corners[(i + 1) % 4]));
        let at = |[x, y]: [f64; 2], z: f64| [x, y, z];
        sides
            .flat_map(|(p, q)| [[at(p, 0.0), at(q, 0.0), at(p, -depth)], [at(q, 0.0), at(q, -depth), at(p, -depth)]])
            .collect()
    }

    #[test]
    fn in_space_it_is_the_circle_of_the_same_area() {
        let outer = shaft(0.02, 0.1).into_iter().map(|[p, q, r]| [q, p, r]);
        let surface: Vec<[[f64; 3]; 3]> = outer.chain(shaft(0.005, 0.0035)).collect();
        let line = Vector3::new(0.001, 0.0005, 0.0);
        let found = void_radii(section(Dimension::Spatial), facets(&surface), &line, millimetres(4));
        for opening in &found[..3] {
            assert!((opening.unwrap() - (0.0001 / PI).sqrt()).abs() < 1e-15, "{found:?}");
        }
        assert_eq!(found[3], Some(0.0));
    }

    #[test]
    fn a_void_that_leaves_the_line_is_followed_and_one_below_its_end_is_not() {
        // A shaft of 10 mm width that leans by 2 mm per mm of depth from 3 mm on, down to 8 mm; another void deeper.
        let lean = |[x, y, z]: [f64; 3]| [x + 2.0 * (-z - 0.003).max(0.0), y, z];
        let outer = shaft(0.05, 0.1).into_iter().map(|[p, q, r]| [q, p, r]);
        let upper = shaft(0.005, 0.003);
        let below = |facet: [[f64; 3]; 3]| facet.map(|[x, y, z]| lean([x, y, z - 0.003]));
        let leaning = shaft(0.005, 0.0052).into_iter().map(below);
        let deeper = shaft(0.002, 0.003).into_iter().map(|facet| facet.map(|[x, y, z]| [x + 0.01, y, z - 0.0102]));
        let surface: Vec<[[f64; 3]; 3]> = outer.chain(upper).chain(leaning).chain(deeper).collect();
        let line = Vector3::new(0.001, 0.0005, 0.0);
        let found = void_radii(section(Dimension::Spatial), facets(&surface), &line, millimetres(12));
        let whole = (0.0001 / PI).sqrt();
        assert!(found[..8].iter().all(|found| (found.unwrap() - whole).abs() < 1e-12), "{found:?}");
        assert_eq!(found[8..], [Some(0.0); 4], "{found:?}");
    }

    /// Returns the section of an axisymmetric gel of 50 mm radius and 12 mm depth with a hole of 5 mm radius. The
    /// surface runs with the gel on the left, from the entry down the hole to the back face, sunk around the hole.
    fn dished(hole: &[[f64; 2]]) -> Vec<[[f64; 3]; 2]> {
        let rest = [[0.048, -0.011], [0.05, -0.012], [0.05, 0.0], [0.005, 0.0]];
        let points: Vec<[f64; 3]> =
            [[0.005, 0.0]].iter().chain(hole).chain(&rest).map(|[x, z]| [*x, 0.0, *z]).collect();
        points.windows(2).map(|ends| [ends[0], ends[1]]).collect()
    }

    #[test]
    fn an_opening_below_the_back_face_is_not_part_of_the_cavity() {
        let open = |hole: &[[f64; 2]]| {
            void_radii(section(Dimension::Axisymmetric), facets(&dished(hole)), &Vector3::zeros(), millimetres(14))
        };
        // A straight hole: the back face around the hole, up to 48 mm off the line, is no part of the cavity wall.
        let found = open(&[[0.005, -0.0095]]);
        assert_eq!(found[9..], [None; 5], "{found:?}");
        assert!(found[..9].iter().all(|radius| (radius.unwrap() - 0.005).abs() < 1e-15), "{found:?}");
        // A hole with a flare below 45° is cavity wall down to its edge.
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
            let outer: Vec<[f64; 2]> = outer.into_iter().rev().collect();
            let sides = corners.windows(2).chain(outer.windows(2));
            sides.flat_map(|ends| [wall(ends[0], ends[1]), back(ends[0], ends[1])]).collect()
        };
        let open = |symmetry: GelSymmetry, corners: &[[f64; 2]]| {
            let gel = GelSection { dimension: Dimension::Spatial, symmetry };
            void_radii(gel, facets(&around(corners)), &Vector3::zeros(), millimetres(5))
        };
        let half = [[0.004, 0.0], [0.004, 0.006], [-0.004, 0.006], [-0.004, 0.0]];
        let whole = [&half[..], &[[-0.004, -0.006], [0.004, -0.006], [0.004, 0.0]]].concat();
        for (symmetry, corners) in
            [(GelSymmetry::None, &whole[..]), (GelSymmetry::Half, &half), (GelSymmetry::Quarter, &half[..3])]
        {
            let found = open(symmetry, corners);
            let radius = (0.008 * 0.012 / PI).sqrt();
            assert!(found.iter().all(|found| (found.unwrap() - radius).abs() < 1e-15), "{symmetry:?}: {found:?}");
        }
        // Open towards −y, the case of one missing wall out of four.
        assert_eq!(open(GelSymmetry::None, &half), [None; 5]);
    }
}
