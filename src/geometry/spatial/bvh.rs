//! Packed bounding box hierarchy (R-tree) along a Morton curve.

use super::bounds::{BoundingBox, morton_order};
use crate::math::Vector;

/// Fan-out of the hierarchy.
const FAN: usize = 8;

/// Packed hierarchy of rectangles or boxes.
#[derive(Debug, Clone)]
pub(super) struct BoxTree<const D: usize> {
    /// Indices of the items along the curve.
    order: Vec<u32>,
    /// Boxes along the curve, then those of the upper levels up to a single one.
    levels: Vec<Vec<BoundingBox<D>>>,
}

impl<const D: usize> BoxTree<D> {
    /// Builds the hierarchy over boxes.
    pub fn new(boxes: &[BoundingBox<D>]) -> Self {
        let middle: Vec<Vector<D>> = boxes.iter().map(|b| 0.5 * (b.low + b.high)).collect();
        let order = morton_order(&middle);
        let mut levels = vec![order.iter().map(|&i| boxes[i as usize]).collect::<Vec<_>>()];
        while let Some(below) = levels.last().filter(|below| below.len() > 1) {
            let above =
                below.chunks(FAN).map(|some| some.iter().fold(BoundingBox::NONE, |all, b| all.joined(b))).collect();
            levels.push(above);
        }
        Self { order, levels }
    }

    /// Builds the hierarchy over points.
    pub fn points(points: impl IntoIterator<Item = Vector<D>>) -> Self {
        Self::new(&points.into_iter().map(|p| BoundingBox { low: p, high: p }).collect::<Vec<_>>())
    }

    /// Builds the hierarchy over line segments.
    pub fn segments(segments: &[[usize; 2]], x: &[Vector<D>]) -> Self {
        Self::new(&segments.iter().map(|s| BoundingBox::around(s.iter().map(|&i| &x[i]))).collect::<Vec<_>>())
    }

    /// Returns true if an item whose box overlaps `area` satisfies `is_sought`; the search stops at the first.
    pub fn any(&self, area: &BoundingBox<D>, mut is_sought: impl FnMut(usize) -> bool) -> bool {
        self.descend((self.levels.len() - 1, 0), area, &mut is_sought)
    }

    /// Finds the item nearest to a point and its distance, m; none if the tree is empty. `distance` is that of an item,
    /// at least the distance of its box. Ties are resolved deterministically.
    pub fn nearest(&self, point: &Vector<D>, distance: impl Fn(usize) -> f64) -> Option<(usize, f64)> {
        let mut best = None;
        self.approach((self.levels.len() - 1, 0), (point, &distance), &mut best);
        best
    }

    fn approach(
        &self,
        (level, first): (usize, usize),
        sought: (&Vector<D>, &impl Fn(usize) -> f64),
        best: &mut Option<(usize, f64)>,
    ) {
        let (point, distance) = sought;
        let boxes = &self.levels[level];
        let mut open: Vec<(f64, usize)> =
            (first..boxes.len().min(first + FAN)).map(|i| (boxes[i].distance_squared(point), i)).collect();
        open.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (squared, i) in open {
            if best.is_some_and(|(_, least)| squared > least * least) {
                return;
            }
            if level > 0 {
                self.approach((level - 1, i * FAN), sought, best);
                continue;
            }
            let (item, found) = (self.order[i] as usize, distance(self.order[i] as usize));
            if best.is_none_or(|(_, least)| found < least) {
                *best = Some((item, found));
            }
        }
    }

    fn descend(
        &self,
        (level, first): (usize, usize),
        area: &BoundingBox<D>,
        is_sought: &mut impl FnMut(usize) -> bool,
    ) -> bool {
        let boxes = &self.levels[level];
        for (i, bounds) in boxes.iter().enumerate().skip(first).take(FAN) {
            let found = bounds.meets(area)
                && if level == 0 {
                    is_sought(self.order[i] as usize)
                } else {
                    self.descend((level - 1, i * FAN), area, is_sought)
                };
            if found {
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_what_a_walk_through_all_points_finds() {
        let points: Vec<Vector<2>> =
            (0..500).map(|i| Vector::<2>::new(f64::from(i * i % 97), f64::from(i * 7 % 61))).collect();
        let near = BoxTree::points(points.iter().copied());
        for i in 0..40 {
            let area =
                BoundingBox::about(&Vector::<2>::new(f64::from(i) * 2.5, f64::from(i * 5 % 61)), f64::from(i % 9));
            let mut found = vec![];
            assert!(!near.any(&area, |i| {
                found.push(i);
                false
            }));
            found.sort_unstable();
            let inside = |p: &Vector<2>| area.meets(&BoundingBox { low: *p, high: *p });
            let walked: Vec<usize> = (0..points.len()).filter(|&i| inside(&points[i])).collect();
            assert_eq!(found, walked);
        }
    }

    #[test]
    fn the_nearest_is_what_a_walk_through_all_points_finds() {
        let points: Vec<Vector<2>> =
            (0..500).map(|i| Vector::<2>::new(f64::from(i * i % 97), f64::from(i * 7 % 61))).collect();
        let near = BoxTree::points(points.iter().copied());
        for i in 0..60 {
            let sought = Vector::<2>::new(f64::from(i) * 2.5 - 20.0, f64::from(i * 5 % 83) + 0.3);
            let found = near.nearest(&sought, |i| (points[i] - sought).norm()).unwrap();
            let least = points.iter().map(|p| (p - sought).norm()).fold(f64::MAX, f64::min);
            assert_eq!(found.1, least);
        }
    }

    #[test]
    fn a_tree_of_nothing_finds_nothing() {
        assert_eq!(BoxTree::<2>::new(&[]).nearest(&Vector::<2>::zeros(), |_| 0.0), None);
        assert!(!BoxTree::<2>::new(&[]).any(&BoundingBox::about(&Vector::<2>::zeros(), 1.0), |_| true));
    }
}
