//! Barycentric coordinates of a triangle or tetrahedron in its deformed configuration.

use crate::geometry::BoundingBox;
use crate::math::{Tensor, Vector, cofactor, det};
use crate::mesh::Simplex;

/// Element in its deformed configuration, with the gradients of its barycentric coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DeformedElement<const D: usize> {
    /// Corners, m; a triangle repeats its third corner.
    pub corners: [Vector<D>; 4],
    /// Gradients of the barycentric coordinates of all corners but the first, 1/m; zero if the element is not upright.
    gradients: [Vector<D>; 3],
    /// True if the element is positively oriented and its measure is a valid divisor.
    pub is_upright: bool,
}

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

/// Edges of a tetrahedron; the first three are those of a triangle.
const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
/// Faces of a tetrahedron.
const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];

/// Edges of an element, by its corners.
pub(super) fn edges<const D: usize>() -> &'static [[usize; 2]] {
    if D == 2 { &EDGES[..3] } else { &EDGES }
}

/// Builds elements in their deformed configuration.
pub(super) fn cells<'a, const D: usize>(
    x: &[Vector<D>],
    elements: impl Iterator<Item = &'a Simplex>,
) -> Vec<DeformedElement<D>> {
    elements.map(|nodes| DeformedElement::of(x, nodes)).collect()
}

/// Interpolates corner values with barycentric weights.
pub(super) fn interpolate<const D: usize>(values: &[Vector<D>; 4], weights: &[f64; 4]) -> Vector<D> {
    (1..=D).fold(values[0] * weights[0], |sum, a| sum + values[a] * weights[a])
}

impl<const D: usize> DeformedElement<D> {
    /// Builds the element from node positions.
    pub fn of(x: &[Vector<D>], nodes: &Simplex) -> Self {
        let corners = std::array::from_fn(|a: usize| x[nodes[a.min(D)].index()]);
        let sides = Tensor::<D>::from_fn(|i, j| corners[j + 1][i] - corners[0][i]);
        let measure = det(&sides);
        let is_upright = measure > 0.0 && measure.recip().is_finite();
        let inverse = if is_upright { measure.recip() } else { 0.0 };
        let cofactor = cofactor(&sides);
        let gradient = |a: usize| if a < D { cofactor.column(a) * inverse } else { Vector::zeros() };
        Self { corners, gradients: std::array::from_fn(gradient), is_upright }
    }

    /// Bounding box.
    pub fn bounds(&self) -> BoundingBox<D> {
        BoundingBox::around(&self.corners[..=D])
    }

    /// Barycentric coordinates of a point: x = Σ λ_a x_a, Σ λ_a = 1; negative beyond a side.
    pub fn weights(&self, p: &Vector<D>) -> [f64; 4] {
        let r = p - self.corners[0];
        let mut weights = [1.0, 0.0, 0.0, 0.0];
        for a in 0..D {
            weights[a + 1] = self.gradients[a].dot(&r);
            weights[0] -= weights[a + 1];
        }
        weights
    }

    /// Barycentric coordinates of the corners of another element. None if one side separates the elements, or if this
    /// one is not upright.
    pub fn weights_of(&self, other: &Self) -> Option<[[f64; 4]; 4]> {
        let mut weights = [[1.0, 0.0, 0.0, 0.0]; 4];
        for (a, gradient) in self.gradients[..D].iter().enumerate() {
            let mut is_apart = true;
            for (weights, corner) in weights.iter_mut().zip(&other.corners[..=D]) {
                let weight = gradient.dot(&(corner - self.corners[0]));
                weights[a + 1] = weight;
                weights[0] -= weight;
                is_apart &= weight <= 0.0;
            }
            if is_apart {
                return None;
            }
        }
        let is_apart = weights[..=D].iter().all(|weights| weights[0] <= 0.0);
        (!is_apart).then_some(weights)
    }

    /// Returns true if one side separates this element from another, up to `part` of the height over that side.
    pub fn is_beside(&self, other: &Self, part: f64) -> bool {
        let mut most = [f64::MIN; 4];
        for corner in &other.corners[..=D] {
            for (most, weight) in most.iter_mut().zip(&self.weights(corner)[..=D]) {
                *most = most.max(*weight);
            }
        }
        most[..=D].iter().any(|weight| *weight <= part)
    }

    /// Squared longest edge, m².
    pub fn longest_edge_squared(&self) -> f64 {
        let square = |[a, b]: &[usize; 2]| (self.corners[*b] - self.corners[*a]).norm_squared();
        edges::<D>().iter().map(square).fold(0.0, f64::max)
    }

    /// Location of a point in this element, called `cell`; none if the point lies outside.
    pub fn place(&self, p: &Vector<D>, cell: usize) -> Option<ElementLocation> {
        let weights = self.weights(p);
        let is_inside = self.is_upright && weights.iter().all(|w| *w >= 0.0);
        is_inside.then_some(ElementLocation { cell, weights, distance: 0.0 })
    }

    /// Closest point of this element, called `cell`, to a point.
    pub fn nearest(&self, p: &Vector<D>, cell: usize) -> ElementLocation {
        if let Some(inside) = self.place(p, cell) {
            return inside;
        }
        let faces = if D == 2 { &[] } else { &FACES[..] };
        let on_faces = faces.iter().filter_map(|face| self.nearest_of_face(*face, p));
        let on_edges = edges::<D>().iter().map(|edge| self.nearest_of_edge(*edge, p));
        let none = ([0.0; 4], f64::INFINITY);
        let (weights, distance) =
            on_faces.chain(on_edges).fold(none, |best, next| if next.1 < best.1 { next } else { best });
        ElementLocation { cell, weights, distance }
    }

    fn nearest_of_edge(&self, [a, b]: [usize; 2], p: &Vector<D>) -> ([f64; 4], f64) {
        let along = self.corners[b] - self.corners[a];
        let length = along.norm_squared();
        let s = if length > 0.0 { ((p - self.corners[a]).dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
        let mut weights = [0.0; 4];
        (weights[a], weights[b]) = (1.0 - s, s);
        (weights, (self.corners[a] + along * s - p).norm_squared())
    }

    /// Foot of the perpendicular on a face; none if it is not inside the face.
    fn nearest_of_face(&self, [a, b, c]: [usize; 3], p: &Vector<D>) -> Option<([f64; 4], f64)> {
        let (u, v) = (self.corners[b] - self.corners[a], self.corners[c] - self.corners[a]);
        let r = p - self.corners[a];
        let (uu, uv, vv) = (u.norm_squared(), u.dot(&v), v.norm_squared());
        let (ru, rv) = (r.dot(&u), r.dot(&v));
        let area = uu * vv - uv * uv;
        let (s, t) = ((ru * vv - rv * uv) / area, (rv * uu - ru * uv) / area);
        let mut weights = [0.0; 4];
        (weights[a], weights[b], weights[c]) = (1.0 - s - t, s, t);
        let is_inside = area > 0.0 && weights.iter().all(|w| *w >= 0.0);
        is_inside.then(|| (weights, (u * s + v * t - r).norm_squared()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::NodeId;

    #[test]
    fn the_nearest_place_of_a_triangle_is_inside_or_on_a_side_or_a_corner() {
        let x = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]].map(Vector::<2>::from);
        let triangle = DeformedElement::of(&x, &[0, 1, 2, 0].map(NodeId));
        for (p, [a, b, c], distance) in [
            ([0.5, 1.0], [0.25, 0.25, 0.5], 0.0),
            ([1.0, -3.0], [0.5, 0.5, 0.0], 9.0),
            ([2.0, 2.0], [0.0, 0.5, 0.5], 2.0),
            ([-1.0, -1.0], [1.0, 0.0, 0.0], 2.0),
        ] {
            let place = triangle.nearest(&Vector::<2>::from(p), 7);
            assert_eq!(place, ElementLocation { cell: 7, weights: [a, b, c, 0.0], distance });
        }
    }

    #[test]
    fn the_nearest_place_of_a_tetrahedron_is_inside_or_on_a_face_or_an_edge_or_a_corner() {
        let x = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]].map(Vector::<3>::from);
        let tetrahedron = DeformedElement::of(&x, &[0, 1, 2, 3].map(NodeId));
        for (p, weights, distance) in [
            ([0.5, 0.5, 0.25], [0.375, 0.25, 0.25, 0.125], 0.0),
            ([0.5, 1.0, -3.0], [0.25, 0.25, 0.5, 0.0], 9.0),
            ([1.0, -3.0, -4.0], [0.5, 0.5, 0.0, 0.0], 25.0),
            ([2.0, 2.0, 0.0], [0.0, 0.5, 0.5, 0.0], 2.0),
            ([-1.0, -1.0, 3.0], [0.0, 0.0, 0.0, 1.0], 3.0),
        ] {
            let place = tetrahedron.nearest(&Vector::<3>::from(p), 7);
            assert_eq!(place, ElementLocation { cell: 7, weights, distance });
        }
        let beyond = tetrahedron.nearest(&Vector::<3>::repeat(1.0), 0);
        assert!((beyond.distance - 1.0 / 3.0).abs() < 1e-15 && beyond.weights[0].abs() < 1e-15);
    }

    #[test]
    fn elements_without_measure_have_a_nearest_place_too() {
        let x = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]].map(Vector::<2>::from);
        let place = DeformedElement::of(&x, &[0, 1, 2, 0].map(NodeId)).nearest(&Vector::<2>::new(1.5, 1.0), 0);
        assert_eq!(place.distance, 1.0);
        let x = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 0.0]].map(Vector::<3>::from);
        let place = DeformedElement::of(&x, &[0, 1, 2, 3].map(NodeId)).nearest(&Vector::<3>::new(0.5, 0.5, 2.0), 0);
        assert_eq!(place.distance, 4.0);
    }
}
