//! Bounding volume hierarchy of axis-aligned boxes: the one search tree over triangles, edges, points and elements.
//!
//! Answers come in an order that depends on the items alone, so that sums and the first of equal answers are
//! reproducible.

use super::bounds::{BoundingBox, morton_order};
use crate::math::Vector;
use std::ops::Range;

/// Greatest number of children of a node.
const FAN: usize = 8;

/// Bounding volume hierarchy over items, given by their boxes.
#[derive(Debug, Clone)]
pub(crate) struct Bvh<const D: usize> {
    /// Nodes, the root first; the children of a node are consecutive.
    nodes: Vec<BvhNode<D>>,
    /// Items, leaf by leaf.
    items: Vec<u32>,
}

/// Node of the hierarchy.
#[derive(Debug, Clone, Copy)]
struct BvhNode<const D: usize> {
    bounds: BoundingBox<D>,
    /// Range of the items of a leaf, or of the children.
    start: u32,
    end: u32,
    is_leaf: bool,
}

impl<const D: usize> Bvh<D> {
    /// Builds the hierarchy over boxes, packed along the Morton curve of their centres.
    pub fn new(boxes: &[BoundingBox<D>]) -> Self {
        let centres: Vec<Vector<D>> = boxes.iter().map(|b| 0.5 * (b.low + b.high)).collect();
        Self::packed(boxes, morton_order(&centres), 1, FAN)
    }

    /// Builds the hierarchy over points.
    pub fn points(points: impl IntoIterator<Item = Vector<D>>) -> Self {
        Self::new(&points.into_iter().map(|p| BoundingBox { low: p, high: p }).collect::<Vec<_>>())
    }

    /// Builds the hierarchy over line segments.
    pub fn segments(segments: &[[usize; 2]], x: &[Vector<D>]) -> Self {
        Self::new(&segments.iter().map(|s| BoundingBox::around(s.iter().map(|&i| &x[i]))).collect::<Vec<_>>())
    }

    /// Packs boxes in a given order: full leaves of `leaf` items, full nodes of `fan` children.
    ///
    /// # Panics
    /// If `fan` is above the greatest number of children.
    pub fn packed(boxes: &[BoundingBox<D>], order: Vec<u32>, leaf: usize, fan: usize) -> Self {
        assert!((2..=FAN).contains(&fan), "a node has 2 to {FAN} children");
        Self::build(boxes, order, leaf, &mut |items| {
            let mut each = leaf;
            while each * fan < items.len() {
                each *= fan;
            }
            (0..items.len()).step_by(each).collect()
        })
    }

    /// Builds a binary hierarchy: items are halved at the median of `middle` along the longest side of their box.
    pub fn halved(boxes: &[BoundingBox<D>], leaf: usize, middle: impl Fn(u32, usize) -> f64) -> Self {
        Self::build(boxes, (0..boxes.len() as u32).collect(), leaf, &mut |items| {
            let span = items.iter().fold(BoundingBox::NONE, |all, i| all.joined(&boxes[*i as usize]));
            let (axis, half) = ((span.high - span.low).imax(), items.len() / 2);
            items.select_nth_unstable_by(half, |a, b| middle(*a, axis).total_cmp(&middle(*b, axis)).then(a.cmp(b)));
            vec![0, half]
        })
    }

    /// Builds the hierarchy. `split` orders the items of a node and returns where those of each child start.
    fn build(
        boxes: &[BoundingBox<D>],
        items: Vec<u32>,
        leaf: usize,
        split: &mut impl FnMut(&mut [u32]) -> Vec<usize>,
    ) -> Self {
        let mut tree = Self { nodes: vec![], items };
        if !boxes.is_empty() {
            tree.nodes.push(BvhNode { bounds: BoundingBox::NONE, start: 0, end: 0, is_leaf: true });
            tree.nodes[0] = tree.divide(boxes, 0..boxes.len(), leaf, split);
        }
        tree
    }

    /// Builds the node over a range of items; its children are stored before it is returned.
    fn divide(
        &mut self,
        boxes: &[BoundingBox<D>],
        range: Range<usize>,
        leaf: usize,
        split: &mut impl FnMut(&mut [u32]) -> Vec<usize>,
    ) -> BvhNode<D> {
        let mut node =
            BvhNode { bounds: BoundingBox::NONE, start: range.start as u32, end: range.end as u32, is_leaf: true };
        if range.len() <= leaf {
            let own = self.items[range].iter().map(|i| &boxes[*i as usize]);
            node.bounds = own.fold(BoundingBox::NONE, |all, one| all.joined(one));
            return node;
        }
        let starts = split(&mut self.items[range.clone()]);
        let first = self.nodes.len();
        self.nodes.resize(first + starts.len(), node);
        for (child, start) in starts.iter().enumerate() {
            let end = starts.get(child + 1).map_or(range.end, |next| range.start + next);
            let below = self.divide(boxes, range.start + start..end, leaf, split);
            node.bounds = node.bounds.joined(&below.bounds);
            self.nodes[first + child] = below;
        }
        (node.start, node.end, node.is_leaf) = (first as u32, (first + starts.len()) as u32, false);
        node
    }

    /// Numbers the items anew, leaf by leaf, and returns the former number of each.
    pub fn renumber(&mut self) -> Vec<u32> {
        let identity = (0..self.items.len() as u32).collect();
        std::mem::replace(&mut self.items, identity)
    }

    /// Visits the items of all leaves that overlap `area`, leaf by leaf, until one satisfies `is_sought`. Returns true
    /// if one does.
    pub fn any(&self, area: &BoundingBox<D>, mut is_sought: impl FnMut(usize) -> bool) -> bool {
        self.nodes.first().is_some_and(|root| self.descend(root, area, &mut is_sought))
    }

    fn descend(&self, node: &BvhNode<D>, area: &BoundingBox<D>, is_sought: &mut impl FnMut(usize) -> bool) -> bool {
        node.bounds.meets(area)
            && if node.is_leaf {
                self.items[node.range()].iter().any(|item| is_sought(*item as usize))
            } else {
                self.nodes[node.range()].iter().any(|child| self.descend(child, area, is_sought))
            }
    }

    /// Finds the item nearest to a point and its distance, m; none if there are no items. `distance` is that of an
    /// item, at least the distance of its box. Ties are resolved deterministically.
    pub fn nearest(&self, point: &Vector<D>, distance: impl Fn(usize) -> f64) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        self.branch_and_bound(
            f64::INFINITY,
            |bounds| bounds.distance_squared(point),
            |item| {
                let found = distance(item);
                if best.is_none_or(|(_, least)| found < least) {
                    best = Some((item, found));
                }
                // Boxes exactly as far as the nearest item are visited, too.
                best.map_or(f64::INFINITY, |(_, least)| (least * least).next_up())
            },
        );
        best
    }

    /// Visits items in the order of the bounds of their boxes, nearest first, by branch and bound. `bound` is a lower
    /// bound of the value of all items in a box. `visit` returns the least value found so far, at first `least`:
    /// boxes whose bound is not below it are passed over.
    pub fn branch_and_bound(
        &self,
        mut least: f64,
        bound: impl Fn(&BoundingBox<D>) -> f64,
        mut visit: impl FnMut(usize) -> f64,
    ) {
        if let Some(root) = self.nodes.first() {
            self.approach(root, &mut least, &bound, &mut visit);
        }
    }

    fn approach(
        &self,
        node: &BvhNode<D>,
        least: &mut f64,
        bound: &impl Fn(&BoundingBox<D>) -> f64,
        visit: &mut impl FnMut(usize) -> f64,
    ) {
        if node.is_leaf {
            for item in &self.items[node.range()] {
                *least = visit(*item as usize);
            }
            return;
        }
        let mut sorted = [(0.0, 0); FAN];
        for (n, child) in node.range().enumerate() {
            let (own, mut at) = (bound(&self.nodes[child].bounds), n);
            while at > 0 && own < sorted[at - 1].0 {
                sorted[at] = sorted[at - 1];
                at -= 1;
            }
            sorted[at] = (own, child);
        }
        for (own, child) in &sorted[..node.range().len()] {
            if *own < *least {
                self.approach(&self.nodes[*child], least, bound, visit);
            }
        }
    }
}

impl<const D: usize> BvhNode<D> {
    fn range(&self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_what_a_walk_through_all_points_finds() {
        let points: Vec<Vector<2>> =
            (0..500).map(|i| Vector::<2>::new(f64::from(i * i % 97), f64::from(i * 7 % 61))).collect();
        let near = Bvh::points(points.iter().copied());
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
        let near = Bvh::points(points.iter().copied());
        for i in 0..60 {
            let sought = Vector::<2>::new(f64::from(i) * 2.5 - 20.0, f64::from(i * 5 % 83) + 0.3);
            let found = near.nearest(&sought, |i| (points[i] - sought).norm()).unwrap();
            let least = points.iter().map(|p| (p - sought).norm()).fold(f64::MAX, f64::min);
            assert_eq!(found.1, least);
        }
    }

    #[test]
    fn a_tree_of_nothing_finds_nothing() {
        assert_eq!(Bvh::<2>::new(&[]).nearest(&Vector::<2>::zeros(), |_| 0.0), None);
        assert!(!Bvh::<2>::new(&[]).any(&BoundingBox::about(&Vector::<2>::zeros(), 1.0), |_| true));
    }
}
