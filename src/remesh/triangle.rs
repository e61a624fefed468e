//! A triangle of the plane and the weights of points in it.

use super::locate::Place;
use crate::algebra::Vector;
use crate::mesh::Simplex;

/// A triangle where it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Triangle {
    /// Its corners, m.
    pub corners: [Vector<2>; 3],
    /// Gradients of the weights of the second and the third corner, 1/m; zero if it is not upright.
    gradients: [Vector<2>; 2],
    /// Whether it is positively oriented and has an area that can be divided by.
    pub is_upright: bool,
}

impl Triangle {
    /// The triangle of an element.
    pub fn of(x: &[Vector<2>], nodes: &Simplex) -> Self {
        let corners: [Vector<2>; 3] = std::array::from_fn(|a| x[nodes[a].index()]);
        let [u, v] = [corners[1] - corners[0], corners[2] - corners[0]];
        let is_upright = u.perp(&v) > 0.0 && u.perp(&v).recip().is_finite();
        let inverse = if is_upright { u.perp(&v).recip() } else { 0.0 };
        let gradients = [Vector::<2>::new(v[1], -v[0]) * inverse, Vector::<2>::new(-u[1], u[0]) * inverse];
        Self { corners, gradients, is_upright }
    }

    /// Weights of a point: x = Σ λ_a x_a, Σ λ_a = 1; negative beyond a side.
    pub fn weights(&self, p: &Vector<2>) -> [f64; 3] {
        let r = p - self.corners[0];
        let [b, c] = self.gradients.map(|gradient| gradient.dot(&r));
        [1.0 - b - c, b, c]
    }

    /// Square of the longest side, m².
    pub fn longest_side_squared(&self) -> f64 {
        let [a, b, c] = self.corners;
        (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared())
    }

    /// The place of a point in this triangle, called `triangle`; none if it lies outside.
    pub fn place(&self, p: &Vector<2>, triangle: usize) -> Option<Place> {
        let weights = self.weights(p);
        let is_inside = self.is_upright && weights.iter().all(|w| *w >= 0.0);
        is_inside.then_some(Place { triangle, weights, distance: 0.0 })
    }

    /// The place of this triangle, called `triangle`, that is nearest to a point.
    pub fn nearest(&self, p: &Vector<2>, triangle: usize) -> Place {
        if let Some(inside) = self.place(p, triangle) {
            return inside;
        }
        let sides = [[0, 1], [1, 2], [2, 0]].map(|side| self.nearest_of_side(side, p));
        let (weights, distance) =
            sides.into_iter().fold(sides[0], |best, side| if side.1 < best.1 { side } else { best });
        Place { triangle, weights, distance }
    }

    fn nearest_of_side(&self, [a, b]: [usize; 2], p: &Vector<2>) -> ([f64; 3], f64) {
        let along = self.corners[b] - self.corners[a];
        let length = along.norm_squared();
        let s = if length > 0.0 { ((p - self.corners[a]).dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
        let mut weights = [0.0; 3];
        (weights[a], weights[b]) = (1.0 - s, s);
        (weights, (self.corners[a] + along * s - p).norm_squared())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::NodeId;

    #[test]
    fn the_nearest_place_of_a_triangle_is_inside_or_on_a_side_or_a_corner() {
        let x = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]].map(Vector::<2>::from);
        let triangle = Triangle::of(&x, &[0, 1, 2, 0].map(NodeId));
        for (p, weights, distance) in [
            ([0.5, 1.0], [0.25, 0.25, 0.5], 0.0),
            ([1.0, -3.0], [0.5, 0.5, 0.0], 9.0),
            ([2.0, 2.0], [0.0, 0.5, 0.5], 2.0),
            ([-1.0, -1.0], [1.0, 0.0, 0.0], 2.0),
        ] {
            let place = triangle.nearest(&Vector::<2>::from(p), 7);
            assert_eq!(place, Place { triangle: 7, weights, distance });
        }
    }

    #[test]
    fn a_triangle_without_area_has_a_nearest_place_too() {
        let x = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]].map(Vector::<2>::from);
        let place = Triangle::of(&x, &[0, 1, 2, 0].map(NodeId)).nearest(&Vector::<2>::new(1.5, 1.0), 0);
        assert_eq!(place.distance, 1.0);
    }
}
