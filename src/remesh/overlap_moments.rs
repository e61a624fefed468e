//! Integrals of products of linear functions over an element or an overlap of elements.

/// Integrals over an overlap, with the old density ρ, the new shape functions N and the old ones λ; entries of a fourth
/// corner are 0 in the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OverlapMoments {
    /// ∫ρ N_i N_j, kg.
    pub mass_matrix: [[f64; 4]; 4],
    /// ∫ρ N_i λ_a, kg.
    pub mixed: [[f64; 4]; 4],
    /// ∫ρ λ_a, kg.
    pub corner_mass: [f64; 4],
    /// ∫λ_a, relative to the measure of the old element.
    pub parts: [f64; 4],
}

/// ∫ρ N_i N_j of an element with these corner densities times measure, kg; the fourth entries are 0 in the plane.
pub(super) fn mass_matrix<const D: usize>(heights: &[f64; 4]) -> [[f64; 4]; 4] {
    let mut mass_matrix = [[0.0; 4]; 4];
    if D == 2 {
        let [a, b, c, _] = *heights;
        for (row, corner) in mass_matrix.iter_mut().zip([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]) {
            row[..3].copy_from_slice(&weighted(&[a, b, c], &corner));
        }
    } else {
        for (i, row) in mass_matrix.iter_mut().enumerate() {
            let mut corner = [0.0; 4];
            corner[i] = 1.0;
            *row = weighted(heights, &corner);
        }
    }
    mass_matrix
}

/// ∫ρ N_p f of a simplex of n corners, for a linear density with corner values h (times measure) and a linear f.
///
/// ∫ρ N_p N_q = (1 + δ_pq)(Σh + h_p + h_q)/(n (n + 1)(n + 2)), hence [(Σh + h_p) Σf + Σh f + (Σh + 2h_p) f_p] over the
/// same.
pub(super) fn weighted<const N: usize>(h: &[f64; N], f: &[f64; N]) -> [f64; N] {
    let (h_sum, f_sum): (f64, f64) = (h.iter().sum(), f.iter().sum());
    let both = dot(h, f);
    let by = (N * (N + 1) * (N + 2)) as f64;
    std::array::from_fn(|p| ((h_sum + h[p]) * f_sum + both + (h_sum + 2.0 * h[p]) * f[p]) / by)
}

/// Scalar product.
pub(super) fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    (1..N).fold(a[0] * b[0], |sum, i| sum + a[i] * b[i])
}
