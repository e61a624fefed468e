#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::{Number, Tensor, Vector, array};

/// Most Jacobi sweeps; the tensors of the tests, with eigenvalues up to twelve decades apart, need five.
const MAX_SWEEPS: usize = 12;
/// Squared relative size of an off-diagonal entry too small to change a digit of the diagonal: (2⁻⁵⁵)².
const SETTLED: f64 = 1.0 / (1_u128 << 110) as f64;

/// Returns the eigenvalues of a symmetric tensor, unordered, and its eigenvectors as columns.
#[must_use]
pub fn spectral<const D: usize>(symmetric: &Tensor<D>) -> (Vector<D>, Tensor<D>) {
    let (values, vectors) = diagonalise(array::rows(symmetric));
    (values.into(), Tensor::<D>::from_fn(|i, j| vectors[i][j]))
}

/// Returns the eigenvalues of a symmetric tensor, unordered, and its eigenvectors as columns.
///
/// Cyclic Jacobi method (Golub and Van Loan, Matrix Computations, 8.5): sums, products, quotients and square roots
/// only, so the same bits on every platform; a diagonal tensor is returned unchanged.
#[inline(always)]
pub fn diagonalise<const D: usize, V: Number>(mut a: [[V; D]; D]) -> ([V; D], [[V; D]; D]) {
    let mut vectors = [[a[0][0].constant(0.0); D]; D];
    for i in 0..D {
        vectors[i][i] = a[0][0].constant(1.0);
    }
    for _ in 0..MAX_SWEEPS {
        let mut is_settled = true;
        for p in 0..D {
            for q in p + 1..D {
                let excess = a[p][q] * a[p][q] - (a[p][p] * a[q][q]).absolute() * SETTLED;
                if excess.any_positive() {
                    is_settled = false;
                    rotate(&mut a, &mut vectors, [p, q], excess);
                }
            }
        }
        if is_settled {
            break;
        }
    }
    (std::array::from_fn(|i| a[i][i]), vectors)
}

/// Applies the Jacobi rotation that zeroes the entry (p, q) where `excess` is positive.
#[inline(always)]
fn rotate<const D: usize, V: Number>(a: &mut [[V; D]; D], vectors: &mut [[V; D]; D], [p, q]: [usize; 2], excess: V) {
    let (off, zero) = (a[p][q], excess.constant(0.0));
    let theta = (a[q][q] - a[p][p]) * 0.5 / off;
    let sign = (-theta).choose(zero - 1.0, zero + 1.0);
    let tangent = excess.choose(sign / (theta.absolute() + (theta * theta + 1.0).root()), zero);
    let cosine = excess.constant(1.0) / (tangent * tangent + 1.0).root();
    let sine = tangent * cosine;
    a[p][p] = a[p][p] - tangent * off;
    a[q][q] = a[q][q] + tangent * off;
    a[p][q] = excess.choose(zero, off);
    a[q][p] = a[p][q];
    for k in 0..D {
        (vectors[k][p], vectors[k][q]) = turn(vectors[k][p], vectors[k][q], cosine, sine);
        if k != p && k != q {
            (a[k][p], a[k][q]) = turn(a[k][p], a[k][q], cosine, sine);
            (a[p][k], a[q][k]) = (a[k][p], a[k][q]);
        }
    }
}

/// Rotates a pair of components.
#[inline(always)]
fn turn<V: Number>(x: V, y: V, cosine: V, sine: V) -> (V, V) {
    (cosine * x - sine * y, sine * x + cosine * y)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns QᵀΛQ of a rotation that is neither small nor along an axis.
    fn turned(values: [f64; 3], angle: f64) -> Tensor<3> {
        let axis = nalgebra::Unit::new_normalize(Vector::<3>::new(1.0, -2.0, 0.5));
        let q = nalgebra::Rotation3::from_axis_angle(&axis, angle).into_inner();
        let a = q.transpose() * Tensor::<3>::from_diagonal(&values.into()) * q;
        (a + a.transpose()) * 0.5
    }

    #[test]
    fn eigenvalues_and_eigenvectors_reconstruct_the_tensor() {
        let sets = [
            [1.0, 1.0, 1.0],
            [1.0, 1.0 + 1e-15, 2.0],
            [1.0, 1.0 + 1e-8, 1.0 - 1e-8],
            [4.0, 0.25, 1.0],
            [1e6, 1.0, 1e-6],
            [3.0, 3.0, 1e-9],
            [2.0, 0.0, 0.0],
        ];
        for values in sets {
            for angle in [0.0, 1e-9, 0.3, 0.7, 1.1, 3.0] {
                let a = turned(values, angle);
                let (found, vectors) = spectral(&a);
                let size = a.norm();
                let again = vectors * Tensor::<3>::from_diagonal(&found) * vectors.transpose();
                assert!((again - a).norm() < 8.0 * f64::EPSILON * size, "{values:?} at {angle}");
                assert!((vectors.transpose() * vectors - Tensor::<3>::identity()).norm() < 16.0 * f64::EPSILON);
                let mut found: Vec<f64> = found.iter().copied().collect();
                let mut exact = values;
                found.sort_by(f64::total_cmp);
                exact.sort_by(f64::total_cmp);
                let off = found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < 8.0 * f64::EPSILON * size, "{found:?}, not {exact:?}");
            }
        }
    }

    #[test]
    fn a_plane_tensor_needs_one_rotation_and_a_diagonal_one_none() {
        let (values, vectors) = spectral(&Tensor::<2>::new(2.0, 1.0, 1.0, 2.0));
        assert!(
            (values - Vector::<2>::new(1.0, 3.0)).norm() < 1e-15
                && (vectors[(0, 0)].abs() - 0.5_f64.sqrt()).abs() < 1e-15
        );
        let diagonal = Tensor::<3>::from_diagonal(&Vector::<3>::new(3.0, -1.0, 2.0));
        assert_eq!(spectral(&diagonal), (diagonal.diagonal(), Tensor::<3>::identity()));
    }
}
