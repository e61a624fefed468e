//! Tensors as arrays of rows over [`Number`]: one tensor, or eight in vector lanes.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::{Number, Tensor};

/// Returns the rows of a tensor.
#[inline]
pub fn rows<const D: usize>(a: &Tensor<D>) -> [[f64; D]; D] {
    std::array::from_fn(|i| std::array::from_fn(|j| a[(i, j)]))
}

/// Returns the determinant.
#[inline(always)]
pub fn det<const D: usize, V: Number>(a: &[[V; D]; D]) -> V {
    if D == 2 {
        return a[0][0] * a[1][1] - a[0][1] * a[1][0];
    }
    let (first, second, third) = (a[0], a[1], a[2 % D]);
    first[0] * (second[1] * third[2 % D] - second[2 % D] * third[1])
        - first[1] * (second[0] * third[2 % D] - second[2 % D] * third[0])
        + first[2 % D] * (second[0] * third[1] - second[1] * third[0])
}

/// Returns the cofactor ∂ det A/∂A_ij.
#[inline(always)]
pub fn cofactor<const D: usize, V: Number>(a: &[[V; D]; D], i: usize, j: usize) -> V {
    let (k, l, m, n) = ((i + 1) % D, (i + 2) % D, (j + 1) % D, (j + 2) % D);
    match (D, i == j) {
        (2, true) => a[k][m],
        (2, false) => -a[k][m],
        _ => a[k][m] * a[l][n] - a[k][n] * a[l][m],
    }
}

/// Returns the determinant with fused multiply-adds.
#[inline(always)]
pub fn fused_det<const D: usize, V: Number>(a: &[[V; D]; D]) -> V {
    if D == 2 {
        return a[0][0].multiply_add(a[1][1], -(a[0][1] * a[1][0]));
    }
    let last = a[0][2 % D] * fused_cofactor(a, 0, 2 % D);
    a[0][0].multiply_add(fused_cofactor(a, 0, 0), a[0][1].multiply_add(fused_cofactor(a, 0, 1), last))
}

/// Returns the cofactor tensor with fused multiply-adds.
#[inline(always)]
pub fn fused_cofactors<const D: usize, V: Number>(a: &[[V; D]; D]) -> [[V; D]; D] {
    let mut all = *a;
    for i in 0..D {
        for j in 0..D {
            all[i][j] = fused_cofactor(a, i, j);
        }
    }
    all
}

/// Returns the cofactor ∂ det A/∂A_ij with a fused multiply-add.
#[inline(always)]
fn fused_cofactor<const D: usize, V: Number>(a: &[[V; D]; D], i: usize, j: usize) -> V {
    let (k, l, m, n) = ((i + 1) % D, (i + 2) % D, (j + 1) % D, (j + 2) % D);
    match (D, i == j) {
        (2, true) => a[k][m],
        (2, false) => -a[k][m],
        _ => a[k][m].multiply_add(a[l][n], -(a[k][n] * a[l][m])),
    }
}

/// Returns |A|², the sum of the squared components.
#[inline(always)]
pub fn norm_squared<const D: usize, V: Number>(a: &[[V; D]; D]) -> V {
    let mut sum = a[0][0].constant(0.0);
    for i in 0..D {
        for j in 0..D {
            sum = sum + a[i][j] * a[i][j];
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tensor_times_its_transposed_cofactor_is_its_determinant() {
        let a = Tensor::<3>::new(1.1, 0.2, -0.3, 0.4, 0.9, 0.1, -0.2, 0.3, 1.3);
        let (all, fused) = (rows(&a), fused_cofactors(&rows(&a)));
        assert!((det(&all) - a.determinant()).abs() < 1e-15 && (fused_det(&all) - det(&all)).abs() < 1e-15);
        let cofactors = Tensor::<3>::from_fn(|i, j| cofactor(&all, i, j));
        assert!((a * cofactors.transpose() - Tensor::<3>::identity() * det(&all)).norm() < 1e-15);
        assert!((Tensor::<3>::from_fn(|i, j| fused[i][j]) - cofactors).norm() < 1e-15);
    }
}
