//! Point location: a binary bounding box tree along a Morton curve; its cost is independent of the mesh grading.

use super::barycentric::DeformedElement;
use super::bounds::{BoundingBox, morton_order};
use crate::math::Vector;
use crate::mesh::{ElementId, Simplex};

/// Distance outside an element, relative to its size, up to which a point counts as inside.
const ROUNDING: f64 = 1e-9;
/// Elements per leaf.
const LEAF: usize = 4;

/// Location in an element: x = Σ weights x_a.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ElementLocation {
    /// Index of the element.
    pub cell: usize,
    /// Barycentric weights, none negative, of sum 1; a triangle has three.
    pub weights: [f64; 4],
    /// Squared distance from the query point, m².
    pub distance: f64,
}

/// Finds the element nearest to a point, with the barycentric weights there; nodes are at `x`. Of several elements that
/// contain the point the first is taken. None if there is no element.
#[must_use]
pub fn nearest<const D: usize>(x: &[Vector<D>], elements: &[Simplex], p: &Vector<D>) -> Option<(ElementId, [f64; 4])> {
    let places = elements.iter().enumerate().map(|(cell, nodes)| DeformedElement::of(x, nodes).nearest(p, cell));
    let place = places.min_by(|a, b| a.distance.total_cmp(&b.distance))?;
    Some((ElementId(place.cell as u32), place.weights))
}

/// Returns true if a point is in an element of a mesh with its nodes at `x`, up to rounding.
#[must_use]
pub fn is_inside<const D: usize>(x: &[Vector<D>], elements: &[Simplex], p: &Vector<D>) -> bool {
    let Some((element, weights)) = nearest(x, elements, p) else { return false };
    let corners = || elements[element.index()][..=D].iter().map(|node| x[node.index()]);
    let there: Vector<D> = corners().zip(weights).map(|(x, weight)| x * weight).sum();
    let size = corners().map(|x| (x - p).norm()).fold(0.0, f64::max);
    (there - p).norm() <= ROUNDING * size
}

/// Search tree over elements.
pub(super) struct ElementLocator<'a, const D: usize> {
    cells: &'a [DeformedElement<D>],
    /// Elements along the curve.
    order: Vec<u32>,
    /// Boxes of the elements, in the same order.
    own: Vec<BoundingBox<D>>,
    /// Box of every node of the tree: node k has the children 2k and 2k + 1; the leaves come last.
    boxes: Vec<BoundingBox<D>>,
}

impl<'a, const D: usize> ElementLocator<'a, D> {
    /// Builds the tree over elements.
    pub fn new(cells: &'a [DeformedElement<D>]) -> Self {
        let middle = |cell: &DeformedElement<D>| cell.corners[..=D].iter().sum::<Vector<D>>() / (D + 1) as f64;
        let order = morton_order(&cells.iter().map(middle).collect::<Vec<_>>());
        let own: Vec<BoundingBox<D>> = order.iter().map(|cell| cells[*cell as usize].bounds()).collect();
        let leaves = order.len().div_ceil(LEAF).next_power_of_two();
        let mut boxes = vec![BoundingBox::NONE; 2 * leaves];
        for (bounds, members) in boxes[leaves..].iter_mut().zip(own.chunks(LEAF)) {
            *bounds = members.iter().fold(BoundingBox::NONE, |all, member| all.joined(member));
        }
        for node in (1..leaves).rev() {
            boxes[node] = boxes[2 * node].joined(&boxes[2 * node + 1]);
        }
        Self { cells, order, own, boxes }
    }

    /// Visits the elements whose box overlaps a box, in the order of the curve.
    pub fn near(&self, wanted: &BoundingBox<D>, mut visit: impl FnMut(usize)) {
        let all = self.walk(wanted, |at| {
            if self.own[at].meets(wanted) {
                visit(self.order[at] as usize);
            }
            None::<()>
        });
        debug_assert!(all.is_none(), "nothing ends the walk");
    }

    /// The place nearest to a point, of equal ones the first along the curve; none if there is no element.
    pub fn nearest(&self, p: &Vector<D>) -> Option<ElementLocation> {
        let here = BoundingBox { low: *p, high: *p };
        let place = |at: usize| {
            let cell = self.order[at] as usize;
            self.cells[cell].place(p, cell)
        };
        self.walk(&here, place).or_else(|| self.nearest_outside(p))
    }

    /// Visits the elements whose leaf meets a box, by their place along the curve, until one gives an answer.
    fn walk<T>(&self, wanted: &BoundingBox<D>, mut visit: impl FnMut(usize) -> Option<T>) -> Option<T> {
        let mut stack = [1_usize; usize::BITS as usize];
        let mut open = 1;
        while open > 0 {
            open -= 1;
            let node = stack[open];
            if !self.boxes[node].meets(wanted) {
                continue;
            }
            if let Some(members) = self.members(node) {
                let answer = members.into_iter().find_map(&mut visit);
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

    fn nearest_outside(&self, p: &Vector<D>) -> Option<ElementLocation> {
        let mut best: Option<ElementLocation> = None;
        let mut stack = vec![1_usize];
        while let Some(node) = stack.pop() {
            if best.is_some_and(|best| self.boxes[node].distance_squared(p) >= best.distance) {
                continue;
            }
            if let Some(members) = self.members(node) {
                for cell in self.order[members].iter().map(|cell| *cell as usize) {
                    let place = self.cells[cell].nearest(p, cell);
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

    /// Range of a leaf's elements along the curve; none for an inner node.
    fn members(&self, node: usize) -> Option<std::ops::Range<usize>> {
        let leaf = node.checked_sub(self.boxes.len() / 2)?;
        let end = self.order.len();
        Some((leaf * LEAF).min(end)..((leaf + 1) * LEAF).min(end))
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_bodies::{TestRandom, jittered_square};
    use super::*;
    use crate::mesh::Mesh;

    fn triangles(mesh: &Mesh<2>) -> Vec<DeformedElement<2>> {
        mesh.elements.iter().map(|e| DeformedElement::of(&mesh.rest, e)).collect()
    }

    #[test]
    fn near_finds_every_triangle_whose_box_meets_the_wanted_one() {
        let mut random = TestRandom::new(3);
        let all = triangles(&jittered_square(9, &mut random));
        let locator = ElementLocator::new(&all);
        for _ in 0..200 {
            let [a, b] = [(); 2].map(|()| Vector::<2>::new(random.next(), random.next()));
            let wanted = BoundingBox::around(&[a, a + (b - a) * 0.2]);
            let mut found = vec![];
            locator.near(&wanted, |t| found.push(t));
            for (t, triangle) in all.iter().enumerate() {
                let times = found.iter().filter(|&&f| f == t).count();
                assert!(times == usize::from(triangle.bounds().meets(&wanted)), "triangle {t} found {times} times");
            }
        }
    }

    #[test]
    fn the_nearest_place_is_the_nearest_of_all() {
        let mut random = TestRandom::new(5);
        let all = triangles(&jittered_square(7, &mut random));
        let locator = ElementLocator::new(&all);
        for _ in 0..300 {
            let p = Vector::<2>::new(3.0 * random.next() - 1.0, 3.0 * random.next() - 1.0);
            let place = locator.nearest(&p).unwrap();
            let least = all.iter().map(|t| t.nearest(&p, 0).distance).fold(f64::INFINITY, f64::min);
            assert_eq!(place.distance, least);
            let inside = (0.0..=1.0).contains(&p[0]) && (0.0..=1.0).contains(&p[1]);
            assert_eq!(inside, place.distance < 1e-24, "{p}");
        }
        assert!(ElementLocator::<2>::new(&[]).nearest(&Vector::<2>::zeros()).is_none());
    }
}
