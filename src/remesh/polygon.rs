//! Overlap of a new triangle and an old one: convex polygon clipping.

use super::overlap_moments::{OverlapMoments, dot, weighted};

/// Vertex of an overlap, as barycentric coordinates in both triangles: every linear field of either is available there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct PolygonVertex {
    /// λ of all corners of the old triangle.
    old: [f64; 3],
    /// N of the first two corners of the new triangle.
    new: [f64; 2],
}

/// Greatest number of vertices. Rounding may bend a polygon of n vertices so that a cut leaves k + 2 min(k, n − k) of
/// them: 4 after the first of three cuts, 6 after the second and 9 after the third.
const MOST: usize = 9;

/// Convex polygon.
#[derive(Debug, Clone, Copy, Default)]
struct OverlapPolygon {
    corners: [PolygonVertex; MOST],
    n_corners: usize,
}

/// Clips new triangles against old ones.
#[derive(Debug, Clone, Default)]
pub(super) struct PolygonClipper {
    /// Overlap of the two triangles.
    common: OverlapPolygon,
    /// Polygon before the last cut.
    uncut: OverlapPolygon,
}

impl PolygonClipper {
    /// Integrals over the overlap of an old triangle and a new one with these barycentric coordinates; none if they do
    /// not overlap.
    ///
    /// `heights` are the densities at the corners of the old triangle times its area, kg. The new triangle is clipped
    /// along the sides of the old one, λ_a = 0, one after the other (Sutherland–Hodgman).
    pub fn moments(&mut self, weights: &[[f64; 4]; 4], heights: &[f64; 4]) -> Option<OverlapMoments> {
        let weights = [0, 1, 2].map(|i| first(&weights[i]));
        let heights = first(heights);
        self.common.n_corners = 0;
        for (old, new) in weights.into_iter().zip([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]) {
            self.common.push(PolygonVertex { old, new });
        }
        for side in (0..3).filter(|side| weights.iter().any(|w| w[*side] < 0.0)) {
            std::mem::swap(&mut self.common, &mut self.uncut);
            self.uncut.cut(side, &mut self.common);
        }
        (self.common.n_corners > 2).then(|| self.common.moments(&heights))
    }
}

impl OverlapPolygon {
    fn push(&mut self, corner: PolygonVertex) {
        self.corners[self.n_corners] = corner;
        self.n_corners += 1;
    }

    fn corners(&self) -> &[PolygonVertex] {
        &self.corners[..self.n_corners]
    }

    /// Clips to the half-plane where the weight of a corner of the old triangle is not negative.
    fn cut(&self, side: usize, part: &mut Self) {
        part.n_corners = 0;
        let Some(mut last) = self.corners().last() else { return };
        for next in self.corners() {
            match (last.old[side] >= 0.0, next.old[side] >= 0.0) {
                (true, false) => part.push(last.towards(next, side)),
                (false, true) => part.push(next.towards(last, side)),
                (true, true) | (false, false) => {}
            }
            if next.old[side] >= 0.0 {
                part.push(*next);
            }
            last = next;
        }
    }

    fn moments(&self, heights: &[f64; 3]) -> OverlapMoments {
        let mut sums = PolygonIntegrals::default();
        let corners = self.corners();
        for pair in corners[1..].windows(2) {
            let triangle = [&corners[0], &pair[0], &pair[1]];
            let part = share(triangle);
            let density = triangle.map(|corner| part * dot(&corner.old, heights));
            sums.add(triangle, &density);
            for (a, sum) in sums.parts.iter_mut().enumerate() {
                *sum += part / 3.0 * triangle.iter().map(|corner| corner.old[a]).sum::<f64>();
            }
        }
        sums.moments()
    }
}

impl PolygonVertex {
    /// Intersection of a side with the segment to a vertex beyond it.
    fn towards(&self, beyond: &Self, side: usize) -> Self {
        let t = self.old[side] / (self.old[side] - beyond.old[side]);
        let mut met = Self {
            old: std::array::from_fn(|i| self.old[i] + t * (beyond.old[i] - self.old[i])),
            new: std::array::from_fn(|i| self.new[i] + t * (beyond.new[i] - self.new[i])),
        };
        met.old[side] = 0.0;
        met
    }
}

/// Independent integrals; the others follow because the shape functions of a triangle sum to 1.
#[derive(Default)]
struct PolygonIntegrals {
    /// ∫ρ.
    one: f64,
    /// ∫ρ N_i, i < 2.
    new: [f64; 2],
    /// ∫ρ λ_a, a > 0.
    old: [f64; 2],
    /// ∫ρ N_i N_j, of 00, 01 and 11.
    both_new: [f64; 3],
    /// ∫ρ N_i λ_a, i < 2, a > 0.
    mixed: [[f64; 2]; 2],
    /// ∫λ_a, relative to the area.
    parts: [f64; 3],
}

impl PolygonIntegrals {
    /// Adds the integrals over a triangle, with density times area at its corners.
    fn add(&mut self, triangle: [&PolygonVertex; 3], density: &[f64; 3]) {
        let old = [1, 2].map(|a| triangle.map(|corner| corner.old[a]));
        let new = [0, 1].map(|i| triangle.map(|corner| corner.new[i]));
        let weighted = new.map(|f| weighted(density, &f));
        let sum: f64 = density.iter().sum();
        let plain = density.map(|h| (sum + h) / 12.0);
        self.one += sum / 3.0;
        for i in 0..2 {
            self.new[i] += dot(&plain, &new[i]);
            self.old[i] += dot(&plain, &old[i]);
            self.both_new[2 * i] += dot(&weighted[i], &new[i]);
            for (sum, old) in self.mixed[i].iter_mut().zip(&old) {
                *sum += dot(&weighted[i], old);
            }
        }
        self.both_new[1] += dot(&weighted[0], &new[1]);
    }

    fn moments(&self) -> OverlapMoments {
        let [aa, ab, bb] = self.both_new;
        let [a, b] = self.new;
        let [ac, bc] = [a - aa - ab, b - ab - bb];
        let cc = self.one - a - b - ac - bc;
        let corner_mass = completed(self.one, self.old);
        let mixed = [completed(a, self.mixed[0]), completed(b, self.mixed[1])];
        let last = std::array::from_fn(|i| corner_mass[i] - mixed[0][i] - mixed[1][i]);
        let none = [0.0; 4];
        OverlapMoments {
            mass_matrix: [[aa, ab, ac, 0.0], [ab, bb, bc, 0.0], [ac, bc, cc, 0.0], none],
            mixed: [padded(mixed[0]), padded(mixed[1]), padded(last), none],
            corner_mass: padded(corner_mass),
            parts: padded(self.parts),
        }
    }
}

/// Completes three parts of a whole from the last two.
fn completed(whole: f64, [b, c]: [f64; 2]) -> [f64; 3] {
    [whole - b - c, b, c]
}

/// First three of four values.
fn first([a, b, c, _]: &[f64; 4]) -> [f64; 3] {
    [*a, *b, *c]
}

/// Pads three values with a zero for the fourth corner.
fn padded([a, b, c]: [f64; 3]) -> [f64; 4] {
    [a, b, c, 0.0]
}

/// Area of a triangle relative to the old one.
fn share(triangle: [&PolygonVertex; 3]) -> f64 {
    let [a, b, c] = triangle.map(|corner| corner.old);
    let [u, v] = [b, c].map(|other| [other[1] - a[1], other[2] - a[2]]);
    u[0] * v[1] - u[1] * v[0]
}

#[cfg(test)]
mod tests {
    use super::super::barycentric::DeformedElement;
    use super::super::overlap_integrals::OverlapIntegrator;
    use super::super::overlap_moments::mass_matrix;
    use super::*;
    use crate::math::Vector;
    use crate::mesh::NodeId;

    fn triangle(corners: [[f64; 2]; 3]) -> DeformedElement<2> {
        DeformedElement::of(&corners.map(Vector::<2>::from), &[0, 1, 2, 0].map(NodeId))
    }

    /// Integrals by summation over the cells of a fine grid.
    fn summed(old: &DeformedElement<2>, heights: &[f64; 4], new: &DeformedElement<2>) -> [[[f64; 3]; 3]; 2] {
        const N: usize = 600;
        let cell = 4.0 / N as f64;
        let mut sums = [[[0.0; 3]; 3]; 2];
        for (i, j) in (0..N * N).map(|k| (k % N, k / N)) {
            let p = Vector::<2>::new((i as f64 + 0.5) * cell - 1.0, (j as f64 + 0.5) * cell - 1.0);
            let [lambda, n] = [old.weights(&p), new.weights(&p)];
            if lambda[..3].iter().chain(&n[..3]).all(|w| *w > 0.0) {
                let [u, v] = [1, 2].map(|a| old.corners[a] - old.corners[0]);
                let mass = dot(&lambda, heights) * cell * cell / (0.5 * u.perp(&v));
                for (a, b) in (0..9).map(|k| (k / 3, k % 3)) {
                    sums[0][a][b] += mass * n[a] * n[b];
                    sums[1][a][b] += mass * n[a] * lambda[b];
                }
            }
        }
        sums
    }

    #[test]
    fn moments_of_overlaps_are_those_of_a_fine_grid() {
        let old = triangle([[0.0, 0.0], [2.0, 0.1], [0.4, 1.9]]);
        let heights = [1.0, 3.0, 0.5, 0.0];
        for new in [
            [[0.3, 0.3], [0.9, 0.4], [0.5, 0.8]],
            [[-0.9, -0.8], [2.9, -0.7], [0.3, 2.9]],
            [[-0.5, 1.1], [1.2, -0.7], [1.9, 1.7]],
            [[-0.5, 0.5], [0.8, 0.2], [0.2, 1.0]],
        ] {
            let new = triangle(new);
            let found = OverlapIntegrator::default().moments(&old, &heights, &new).unwrap();
            let [mass_matrix, mixed] = summed(&old, &heights, &new);
            for (a, b) in (0..9).map(|k| (k / 3, k % 3)) {
                assert!((found.mass_matrix[a][b] - mass_matrix[a][b]).abs() < 2e-3, "{found:?} {mass_matrix:?}");
                assert!((found.mixed[a][b] - mixed[a][b]).abs() < 2e-3, "{found:?} {mixed:?}");
            }
        }
        let apart = triangle([[2.0, 2.0], [2.5, 2.0], [2.0, 2.5]]);
        assert!(OverlapIntegrator::default().moments(&old, &heights, &apart).is_none());
    }

    #[test]
    fn the_inertia_of_a_whole_triangle_is_that_of_its_overlap_with_itself() {
        let old = triangle([[0.0, 0.0], [2.0, 0.1], [0.4, 1.9]]);
        let heights = [1.0, 3.0, 0.5, 0.0];
        let found = OverlapIntegrator::default().moments(&old, &heights, &old).unwrap();
        for (a, b) in (0..9).map(|k| (k / 3, k % 3)) {
            assert!((found.mass_matrix[a][b] - mass_matrix::<2>(&heights)[a][b]).abs() < 1e-15);
            assert!((found.mixed[a][b] - found.mass_matrix[a][b]).abs() < 1e-15);
        }
        assert!((found.corner_mass.iter().sum::<f64>() - 1.5).abs() < 1e-15);
    }
}
