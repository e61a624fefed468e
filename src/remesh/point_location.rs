//! Point location: a binary bounding volume hierarchy along a Morton curve; its cost is independent of the mesh
//! grading.

use super::barycentric::{DeformedElement, ElementLocation};
use crate::geometry::{BoundingBox, Bvh, morton_order};
use crate::math::Vector;
use crate::mesh::{ElementId, Simplex};

/// Distance outside an element, relative to its size, up to which a point counts as inside.
const ROUNDING: f64 = 1e-9;
/// Elements per leaf.
const LEAF: usize = 4;

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
    tree: Bvh<D>,
}

impl<'a, const D: usize> ElementLocator<'a, D> {
    /// Builds the tree over elements.
    pub fn new(cells: &'a [DeformedElement<D>]) -> Self {
        let middle = |cell: &DeformedElement<D>| cell.corners[..=D].iter().sum::<Vector<D>>() / (D + 1) as f64;
        let boxes: Vec<BoundingBox<D>> = cells.iter().map(DeformedElement::bounds).collect();
        let mut tree = Bvh::packed(&boxes, morton_order(&cells.iter().map(middle).collect::<Vec<_>>()), LEAF, 2);
        let order = tree.renumber();
        let own = order.iter().map(|cell| boxes[*cell as usize]).collect();
        Self { cells, order, own, tree }
    }

    /// Visits the elements whose box overlaps a box, in the order of the curve.
    pub fn near(&self, wanted: &BoundingBox<D>, mut visit: impl FnMut(usize)) {
        self.tree.any(wanted, |at| {
            if self.own[at].meets(wanted) {
                visit(self.order[at] as usize);
            }
            false
        });
    }

    /// The place nearest to a point, of equal ones the first along the curve; none if there is no element.
    pub fn nearest(&self, p: &Vector<D>) -> Option<ElementLocation> {
        let mut inside = None;
        self.tree.any(&BoundingBox { low: *p, high: *p }, |at| {
            let cell = self.order[at] as usize;
            inside = self.cells[cell].place(p, cell);
            inside.is_some()
        });
        inside.or_else(|| self.nearest_outside(p))
    }

    fn nearest_outside(&self, p: &Vector<D>) -> Option<ElementLocation> {
        let mut best: Option<ElementLocation> = None;
        self.tree.branch_and_bound(
            f64::INFINITY,
            |bounds| bounds.distance_squared(p),
            |at| {
                let cell = self.order[at] as usize;
                let place = self.cells[cell].nearest(p, cell);
                best.insert(best.filter(|best| best.distance <= place.distance).unwrap_or(place)).distance
            },
        );
        best
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
