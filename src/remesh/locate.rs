//! Which triangles are near: boxes in a binary tree along a Morton curve, so that grading does no harm.

use super::Triangle;
use super::bounds::{Bounds, along_curve};
use crate::algebra::Vector;

/// Triangles per leaf.
const LEAF: usize = 4;

/// A place in a triangle: x = Σ weights x_a.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    /// Which of the triangles.
    pub triangle: usize,
    /// Weights of its corners, none negative, of sum 1.
    pub weights: [f64; 3],
    /// Squared distance from the point that was asked for, m².
    pub distance: f64,
}

/// A search tree over triangles.
pub(super) struct Locator<'a> {
    triangles: &'a [Triangle],
    /// The triangles along the curve.
    order: Vec<u32>,
    /// Box of every node of the tree: node k has the children 2k and 2k + 1, and the leaves stand last.
    boxes: Vec<Bounds>,
}

impl<'a> Locator<'a> {
    /// Of these triangles.
    pub fn new(triangles: &'a [Triangle]) -> Self {
        let order =
            along_curve(&triangles.iter().map(|t| t.corners.iter().sum::<Vector<2>>() / 3.0).collect::<Vec<_>>());
        let leaves = order.len().div_ceil(LEAF).next_power_of_two();
        let mut boxes = vec![Bounds::NONE; 2 * leaves];
        for (leaf, members) in order.chunks(LEAF).enumerate() {
            boxes[leaves + leaf] =
                members.iter().fold(Bounds::NONE, |b, t| b.joined(&Bounds::around(&triangles[*t as usize].corners)));
        }
        for node in (1..leaves).rev() {
            boxes[node] = boxes[2 * node].joined(&boxes[2 * node + 1]);
        }
        Self { triangles, order, boxes }
    }

    /// Visits the triangles whose leaf meets a box, in the order of the curve.
    pub fn near(&self, wanted: &Bounds, mut visit: impl FnMut(usize)) {
        let all = self.walk(wanted, |t| {
            visit(t);
            None::<()>
        });
        debug_assert!(all.is_none(), "nothing ends the walk");
    }

    /// The place nearest to a point, of equal ones the first along the curve; none if there is no triangle.
    pub fn nearest(&self, p: &Vector<2>) -> Option<Place> {
        let here = Bounds { low: *p, high: *p };
        self.walk(&here, |t| self.triangles[t].place(p, t)).or_else(|| self.nearest_outside(p))
    }

    /// Visits the triangles whose leaf meets a box, in the order of the curve, until one gives an answer.
    fn walk<T>(&self, wanted: &Bounds, mut visit: impl FnMut(usize) -> Option<T>) -> Option<T> {
        let mut stack = [1_usize; usize::BITS as usize];
        let mut open = 1;
        while open > 0 {
            open -= 1;
            let node = stack[open];
            if !self.boxes[node].meets(wanted) {
                continue;
            }
            if let Some(members) = self.members(node) {
                let answer = members.iter().find_map(|t| visit(*t as usize));
                if answer.is_some() {
                    return answer;
                }
            } else {
                stack[open] = 2 * node + 1;
                stack[open + 1] = 2 * node;
                open += 2;
            }
        }
        None
    }

    fn nearest_outside(&self, p: &Vector<2>) -> Option<Place> {
        let mut best: Option<Place> = None;
        let mut stack = vec![1_usize];
        while let Some(node) = stack.pop() {
            if best.is_some_and(|best| self.boxes[node].distance_squared(p) >= best.distance) {
                continue;
            }
            if let Some(members) = self.members(node) {
                for t in members {
                    let place = self.triangles[*t as usize].nearest(p, *t as usize);
                    best = Some(best.filter(|best| best.distance <= place.distance).unwrap_or(place));
                }
            } else {
                let [first, second] = [2 * node, 2 * node + 1];
                let swap = self.boxes[second].distance_squared(p) < self.boxes[first].distance_squared(p);
                stack.extend(if swap { [first, second] } else { [second, first] });
            }
        }
        best
    }

    /// The triangles of a leaf; none for a node that is not one.
    fn members(&self, node: usize) -> Option<&[u32]> {
        let leaf = node.checked_sub(self.boxes.len() / 2)?;
        let end = self.order.len();
        Some(&self.order[(leaf * LEAF).min(end)..((leaf + 1) * LEAF).min(end)])
    }
}

#[cfg(test)]
mod tests {
    use super::super::bodies::{Random, jittered_square};
    use super::*;
    use crate::mesh::Mesh;

    fn triangles(mesh: &Mesh<2>) -> Vec<Triangle> {
        mesh.elements.iter().map(|e| Triangle::of(&mesh.rest, e)).collect()
    }

    #[test]
    fn near_finds_every_triangle_whose_box_meets_the_wanted_one() {
        let mut random = Random::new(3);
        let all = triangles(&jittered_square(9, &mut random));
        let locator = Locator::new(&all);
        for _ in 0..200 {
            let [a, b] = [(); 2].map(|()| Vector::<2>::new(random.next(), random.next()));
            let wanted = Bounds::around(&[a, a + (b - a) * 0.2]);
            let mut found = vec![];
            locator.near(&wanted, |t| found.push(t));
            for (t, triangle) in all.iter().enumerate() {
                let times = found.iter().filter(|&&f| f == t).count();
                let meets = Bounds::around(&triangle.corners).meets(&wanted);
                assert!(times == 1 || (times == 0 && !meets), "triangle {t} found {times} times");
            }
        }
    }

    #[test]
    fn the_nearest_place_is_the_nearest_of_all() {
        let mut random = Random::new(5);
        let all = triangles(&jittered_square(7, &mut random));
        let locator = Locator::new(&all);
        for _ in 0..300 {
            let p = Vector::<2>::new(3.0 * random.next() - 1.0, 3.0 * random.next() - 1.0);
            let place = locator.nearest(&p).unwrap();
            let least = all.iter().map(|t| t.nearest(&p, 0).distance).fold(f64::INFINITY, f64::min);
            assert_eq!(place.distance, least);
            let inside = (0.0..=1.0).contains(&p[0]) && (0.0..=1.0).contains(&p[1]);
            assert_eq!(inside, place.distance < 1e-24, "{p}");
        }
        assert!(Locator::new(&[]).nearest(&Vector::<2>::zeros()).is_none());
    }
}
