use super::{Tensor, Vector};

/// Most Jacobi sweeps; the tensors of the tests, with eigenvalues up to twelve decades apart, need five.
const MAX_SWEEPS: usize = 12;
/// Squared relative size of an off-diagonal entry too small to change a digit of the diagonal: (2⁻⁵⁵)².
const SETTLED: f64 = 1.0 / (1_u128 << 110) as f64;

/// Returns the eigenvalues of a symmetric tensor, unordered, and its eigenvectors as columns.
///
/// Cyclic Jacobi method (Golub and Van Loan, Matrix Computations, 8.5): sums, products, quotients and square roots
/// only, so the same bits on every platform; a diagonal tensor is returned unchanged.
#[must_use]
pub fn spectral<const D: usize>(symmetric: &Tensor<D>) -> (Vector<D>, Tensor<D>) {
    let (mut a, mut vectors) = (*symmetric, Tensor::<D>::identity());
    for _ in 0..MAX_SWEEPS {
        let mut is_settled = true;
        for p in 0..D {
            for q in p + 1..D {
                let off = a[(p, q)];
                if off * off > SETTLED * (a[(p, p)] * a[(q, q)]).abs() {
                    is_settled = false;
                    rotate(&mut a, &mut vectors, p, q);
                }
            }
        }
        if is_settled {
            break;
        }
    }
    (a.diagonal(), vectors)
}

/// Applies the Jacobi rotation that zeroes the entry (p, q).
fn rotate<const D: usize>(a: &mut Tensor<D>, vectors: &mut Tensor<D>, p: usize, q: usize) {
    let off = a[(p, q)];
    let theta = 0.5 * (a[(q, q)] - a[(p, p)]) / off;
    let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;
    let turned = |x: f64, y: f64| (cosine * x - sine * y, sine * x + cosine * y);
    a[(p, p)] -= tangent * off;
    a[(q, q)] += tangent * off;
    (a[(p, q)], a[(q, p)]) = (0.0, 0.0);
    for k in 0..D {
        (vectors[(k, p)], vectors[(k, q)]) = turned(vectors[(k, p)], vectors[(k, q)]);
        if k != p && k != q {
            (a[(k, p)], a[(k, q)]) = turned(a[(k, p)], a[(k, q)]);
            (a[(p, k)], a[(q, k)]) = (a[(k, p)], a[(k, q)]);
        }
    }
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
