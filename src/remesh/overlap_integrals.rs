//! What a new element and an old one have in common: the exact integrals over that.

use super::barycentric::Cell;
use super::polygon::Polygons;
use super::polyhedron::Polyhedra;

/// Integrals over an overlap, of the old density ρ, the new shape functions N and the old ones λ; those of a fourth corner
/// are 0 in the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moments {
    /// ∫ρ N_i N_j, kg.
    pub inertia: [[f64; 4]; 4],
    /// ∫ρ N_i λ_a, kg.
    pub mixed: [[f64; 4]; 4],
    /// ∫ρ λ_a, kg.
    pub corner_mass: [f64; 4],
    /// ∫λ_a, as parts of the measure of the old element.
    pub parts: [f64; 4],
}

/// Cuts elements along one another.
#[derive(Debug, Clone, Default)]
pub(super) struct Cutter {
    polygons: Polygons,
    polyhedra: Polyhedra,
}

impl Cutter {
    /// The integrals over what an upright old element and a new one have in common; none if that is nothing.
    ///
    /// The density has the values `heights`, kg, at the corners of the old element, times its measure.
    pub fn moments<const D: usize>(&mut self, old: &Cell<D>, heights: &[f64; 4], new: &Cell<D>) -> Option<Moments> {
        let in_old = old.weights_of(new)?;
        if D == 2 {
            return self.polygons.moments(&in_old, heights);
        }
        self.polyhedra.moments(&in_old, &new.weights_of(old)?, heights)
    }
}

/// ∫ρ N_i N_j of an element whose density has these values at its corners, times its measure, kg; 0 of a fourth corner in
/// the plane.
pub(super) fn inertia<const D: usize>(heights: &[f64; 4]) -> [[f64; 4]; 4] {
    let mut inertia = [[0.0; 4]; 4];
    if D == 2 {
        let [a, b, c, _] = *heights;
        for (row, corner) in inertia.iter_mut().zip([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]) {
            row[..3].copy_from_slice(&weighted(&[a, b, c], &corner));
        }
    } else {
        for (i, row) in inertia.iter_mut().enumerate() {
            let mut corner = [0.0; 4];
            corner[i] = 1.0;
            *row = weighted(heights, &corner);
        }
    }
    inertia
}

/// ∫ρ N_p f of a simplex of n corners, of a linear density with the values h at the corners, times measure, and a linear f.
///
/// ∫ρ N_p N_q = (1 + δ_pq)(Σh + h_p + h_q)/(n (n + 1)(n + 2)), hence [(Σh + h_p) Σf + Σh f + (Σh + 2h_p) f_p] by the same.
pub(super) fn weighted<const N: usize>(h: &[f64; N], f: &[f64; N]) -> [f64; N] {
    let (h_sum, f_sum): (f64, f64) = (h.iter().sum(), f.iter().sum());
    let both = dot(h, f);
    let by = (N * (N + 1) * (N + 2)) as f64;
    std::array::from_fn(|p| ((h_sum + h[p]) * f_sum + both + (h_sum + 2.0 * h[p]) * f[p]) / by)
}

/// The sum of products.
pub(super) fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    (1..N).fold(a[0] * b[0], |sum, i| sum + a[i] * b[i])
}
