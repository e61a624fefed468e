//! Cross-section of the gel in space: closed loops of the cut surface, and the voids that they bound.

use crate::scene::GelSymmetry;
use nalgebra::Vector2;
use std::collections::BTreeMap;

/// Directed segment of a cross-section: the cut of a facet, with the gel on its left.
pub(super) type SectionSegment = [Vector2<f64>; 2];

/// Closed loops of the surface of the gel at one depth.
pub(super) struct CrossSection {
    loops: Vec<Vec<Vector2<f64>>>,
}

/// Wall of a void: a loop with the gel outside.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct VoidWall {
    points: Vec<Vector2<f64>>,
    /// Area of the void without the gel that lies loose in it, m².
    pub(super) area: f64,
}

impl CrossSection {
    /// Chains the segments of the computed part, completed by its mirror images; the origin lies in the planes of
    /// symmetry.
    pub(super) fn of(symmetry: GelSymmetry, segments: &[SectionSegment]) -> Self {
        Self { loops: closed_loops(&mirrored(symmetry, segments)) }
    }

    /// Returns the wall of the void around the origin; `None` if no loop of the surface encloses the origin.
    pub(super) fn void_around_origin(&self) -> Option<VoidWall> {
        let around = self.voids().filter(|points| encloses(points, &Vector2::zeros()));
        around.max_by(|a, b| signed_area(a).total_cmp(&signed_area(b))).map(|wall| self.wall(wall))
    }

    /// Returns the wall of the greatest void that overlaps the void of a neighbouring depth; `None` if there is none.
    pub(super) fn void_beside(&self, neighbour: &VoidWall) -> Option<VoidWall> {
        let overlaps = |points: &&Vec<Vector2<f64>>| {
            points.iter().any(|point| encloses(&neighbour.points, point))
                || neighbour.points.iter().any(|point| encloses(points, point))
        };
        let beside = self.voids().filter(overlaps);
        beside.min_by(|a, b| signed_area(a).total_cmp(&signed_area(b))).map(|wall| self.wall(wall))
    }

    /// Returns the loops with the gel outside.
    fn voids(&self) -> impl Iterator<Item = &Vec<Vector2<f64>>> {
        self.loops.iter().filter(|points| signed_area(points) < 0.0)
    }

    fn wall(&self, wall: &Vec<Vector2<f64>>) -> VoidWall {
        let is_loose = |points: &&Vec<Vector2<f64>>| !std::ptr::eq(*points, wall) && encloses(wall, &points[0]);
        let loose: f64 = self.loops.iter().filter(is_loose).map(|points| signed_area(points)).sum();
        VoidWall { points: wall.clone(), area: (-signed_area(wall) - loose).max(0.0) }
    }
}

impl VoidWall {
    /// Returns the mean of the corners.
    pub(super) fn middle(&self) -> Vector2<f64> {
        self.points.iter().sum::<Vector2<f64>>() / self.points.len() as f64
    }
}

/// Returns the segments of the computed part and of its mirror images, without the segments in the planes of symmetry.
fn mirrored(symmetry: GelSymmetry, segments: &[SectionSegment]) -> Vec<SectionSegment> {
    let mut all = segments.to_vec();
    for &axis in symmetry.mirrored() {
        all.retain(|[a, b]| a[axis] != 0.0 || b[axis] != 0.0);
        let image = |mut point: Vector2<f64>| {
            point[axis] = -point[axis];
            point
        };
        let images: Vec<SectionSegment> = all.iter().map(|[a, b]| [image(*b), image(*a)]).collect();
        all.extend(images);
    }
    all
}

/// Returns the bits of a point; neighbouring facets cut their common edge in the same bits.
fn point_key(point: &Vector2<f64>) -> [u64; 2] {
    // The sum turns −0 into 0.
    [(point.x + 0.0).to_bits(), (point.y + 0.0).to_bits()]
}

/// Chains the segments to closed loops; chains with an end are left out.
fn closed_loops(segments: &[SectionSegment]) -> Vec<Vec<Vector2<f64>>> {
    let mut leaving = BTreeMap::<[u64; 2], Vec<usize>>::new();
    for (i, [start, _]) in segments.iter().enumerate().rev() {
        leaving.entry(point_key(start)).or_default().push(i);
    }
    let mut is_free = vec![true; segments.len()];
    let mut loops = vec![];
    for first in 0..segments.len() {
        let (mut next, mut points) = (is_free[first].then_some(first), vec![]);
        while let Some(segment) = next {
            is_free[segment] = false;
            let [start, end] = segments[segment];
            points.push(start);
            if point_key(&end) == point_key(&points[0]) {
                loops.push(std::mem::take(&mut points));
                break;
            }
            let others = leaving.get_mut(&point_key(&end));
            next = others.and_then(|others| std::iter::from_fn(|| others.pop()).find(|other| is_free[*other]));
        }
    }
    loops
}

/// Returns the area within a loop, m², positive if it runs counter-clockwise: around gel, and not around a void.
#[must_use]
pub fn signed_area(points: &[Vector2<f64>]) -> f64 {
    let ends = points.iter().zip(points.iter().cycle().skip(1));
    0.5 * ends.map(|(a, b)| a.perp(b)).sum::<f64>()
}

/// Returns true if a point lies within a loop: a ray towards +x then crosses the loop an odd number of times.
fn encloses(points: &[Vector2<f64>], point: &Vector2<f64>) -> bool {
    let ends = points.iter().zip(points.iter().cycle().skip(1));
    ends.filter(|(a, b)| crosses_ray(&[*a - point, *b - point])).count() % 2 == 1
}

/// Returns true if a segment crosses the ray from the origin towards +x.
pub(super) fn crosses_ray([a, b]: &SectionSegment) -> bool {
    (a.y > 0.0) != (b.y > 0.0) && a.x - a.y * (b.x - a.x) / (b.y - a.y) > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the closed polygon through points; clockwise around a void.
    fn polygon(points: &[[f64; 2]]) -> Vec<SectionSegment> {
        let at = |[x, y]: [f64; 2]| Vector2::new(x, y);
        (0..points.len()).map(|i| [at(points[i]), at(points[(i + 1) % points.len()])]).collect()
    }

    /// Returns the rectangle between two corners, counter-clockwise, or clockwise around a void.
    fn rectangle([a, b]: [f64; 2], [c, d]: [f64; 2], is_void: bool) -> Vec<SectionSegment> {
        let mut points = [[a, b], [c, b], [c, d], [a, d]];
        if is_void {
            points.reverse();
        }
        polygon(&points)
    }

    fn void_area(symmetry: GelSymmetry, segments: &[SectionSegment]) -> Option<f64> {
        CrossSection::of(symmetry, segments).void_around_origin().map(|wall| wall.area)
    }

    #[test]
    fn the_void_around_the_line_is_counted_without_loose_gel_and_other_voids() {
        let gel = rectangle([-10.0, -10.0], [10.0, 10.0], false);
        let void = rectangle([-1.0, -2.0], [3.0, 2.0], true);
        let (loose, aside) = (rectangle([1.0, 1.0], [2.0, 1.5], false), rectangle([5.0, 5.0], [8.0, 6.0], true));
        let all = [gel.clone(), void, loose, aside.clone()].concat();
        assert!((void_area(GelSymmetry::None, &all).unwrap() - 15.5).abs() < 1e-12);
        assert_eq!(void_area(GelSymmetry::None, &[gel, aside].concat()), None);
        // A wall with a gap encloses nothing.
        assert_eq!(void_area(GelSymmetry::None, &rectangle([-1.0, -1.0], [1.0, 1.0], true)[1..]), None);
    }

    #[test]
    fn mirror_images_close_the_computed_part() {
        // Counted: an L-shaped quarter of a void, which is not star-shaped about the line, with facets in the planes.
        let wall =
            polygon(&[[0.0, 3.0], [1.0, 3.0], [1.0, 1.0], [4.0, 1.0], [4.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]]);
        let quarter = void_area(GelSymmetry::Quarter, &wall).unwrap();
        assert!((quarter - 4.0 * 6.0).abs() < 1e-12, "{quarter}");
        let open = &wall[..4];
        assert!((void_area(GelSymmetry::Quarter, open).unwrap() - 24.0).abs() < 1e-12);
        let half = polygon(&[[-2.0, 0.0], [-2.0, 1.0], [3.0, 1.0], [3.0, 0.0]]);
        assert!((void_area(GelSymmetry::Half, &half[..3]).unwrap() - 10.0).abs() < 1e-12);
        assert_eq!(void_area(GelSymmetry::None, &half[..3]), None);
    }
}
