//! Small dense algebra over nalgebra types, for `D` ∈ {2, 3}.
//!
//! The world is three-dimensional; a planar or axisymmetric gel lives in the x–z plane. [`embed`] and [`restrict`] go
//! between the two. Everything here gives the same bits on every platform: no libm call, and fused multiply-adds only
//! where the source says so.

pub(crate) mod array;
mod number;
mod ordered_map;
mod shared_work;
mod spectral;
mod symmetric_tensor;

pub use number::{Number, exp, exp_less_one, ln, power};
pub(crate) use ordered_map::{map_chunks_in_order, map_in_order, map_in_order_with};
pub(crate) use shared_work::{SharedWork, shared_cpu_time};
pub(crate) use spectral::diagonalise;
pub use spectral::spectral;
pub(crate) use symmetric_tensor::{SymmetricTensor, isochoric_mean};

/// Vector of the gel's space.
pub type Vector<const D: usize> = nalgebra::SVector<f64, D>;
/// Second-order tensor of the gel's space.
pub type Tensor<const D: usize> = nalgebra::SMatrix<f64, D, D>;
/// Vector of the world.
pub type Vector3 = nalgebra::Vector3<f64>;
/// Tensor of the world.
pub type Tensor3 = nalgebra::Matrix3<f64>;

/// Relative tolerance of a comparison of squares or squared tangents: closer values have no reliable order.
pub(crate) const CLOSE: f64 = 1e-9;

/// Returns the determinant.
#[must_use]
#[inline]
pub fn det<const D: usize>(a: &Tensor<D>) -> f64 {
    array::det(&array::rows(a))
}

/// Returns the cofactor tensor, cof A = ∂det A/∂A = det(A) A⁻ᵀ, defined also where det A = 0.
#[must_use]
#[inline]
pub fn cofactor<const D: usize>(a: &Tensor<D>) -> Tensor<D> {
    let rows = array::rows(a);
    Tensor::<D>::from_fn(|i, j| array::cofactor(&rows, i, j))
}

/// Embeds a gel vector in the world: (x, z) ↦ (x, 0, z), and the identity in three dimensions.
#[must_use]
#[inline]
pub fn embed<const D: usize>(v: &Vector<D>) -> Vector3 {
    Vector3::new(v[0], if D == 3 { v[1] } else { 0.0 }, v[D - 1])
}

/// Restricts a world vector to the gel's space: (x, y, z) ↦ (x, z), and the identity in three dimensions.
#[must_use]
#[inline]
pub fn restrict<const D: usize>(v: &Vector3) -> Vector<D> {
    Vector::<D>::from_fn(|i, _| if i == D - 1 { v[2] } else { v[i] })
}

/// Returns √(a² + b²) from exact operations only: the same bits on every platform.
#[must_use]
#[inline]
pub fn hypotenuse(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

/// Returns ∛x of x ≥ 0 from exact operations only, within a few roundings: the same bits on every platform.
///
/// Newton iterations start from a third of the exponent, within a factor 2⅔ of the root.
#[must_use]
pub fn cube_root(x: f64) -> f64 {
    if x <= 0.0 || !x.is_finite() {
        return x.max(0.0);
    }
    let mut root = f64::from_bits(x.to_bits() / 3 + (682_u64 << 52));
    for _ in 0..6 {
        root -= (root - x / (root * root)) / 3.0;
    }
    root
}

/// Terms of a block of an ordered sum.
pub const SUM_BLOCK: usize = 1024;

/// Returns a sum whose bits depend on the order of the terms only: blocks of 1024, then pairwise over the blocks
/// (method A9).
#[must_use]
pub fn ordered_sum<T>(n: usize, zero: T, term: impl Fn(usize) -> T) -> T
where
    T: Copy + std::ops::Add<Output = T>,
{
    if n <= SUM_BLOCK {
        return (0..n).fold(zero, |sum, i| sum + term(i));
    }
    let mut sums: Vec<T> = (0..n.div_ceil(SUM_BLOCK))
        .map(|b| (b * SUM_BLOCK..n.min((b + 1) * SUM_BLOCK)).fold(zero, |sum, i| sum + term(i)))
        .collect();
    while sums.len() > 1 {
        sums = sums.chunks(2).map(|pair| pair.iter().copied().reduce(|a, b| a + b).unwrap_or(zero)).collect();
    }
    sums.first().copied().unwrap_or(zero)
}

/// Returns the lesser of two numbers, or NaN if one is NaN; `f64::min` would drop it.
#[inline]
#[must_use]
pub fn least(a: f64, b: f64) -> f64 {
    if a.is_nan() || b >= a { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cofactor_is_the_derivative_of_the_determinant() {
        let a = Tensor3::new(1.1, 0.2, -0.3, 0.4, 0.9, 0.1, -0.2, 0.3, 1.3);
        let b = nalgebra::Matrix2::new(1.1, 0.2, -0.3, 0.7);
        let step = 1e-6;
        for i in 0..3 {
            for j in 0..3 {
                let mut h = Tensor3::zeros();
                h[(i, j)] = step;
                let slope = (det(&(a + h)) - det(&(a - h))) / (2.0 * step);
                assert!((slope - cofactor(&a)[(i, j)]).abs() < 1e-9);
            }
        }
        assert!((cofactor(&b).transpose() * b - nalgebra::Matrix2::identity() * det(&b)).norm() < 1e-15);
    }

    #[test]
    fn cube_roots_agree_with_libm() {
        let mut x = 1e-30;
        while x < 1e30 {
            let exact = libm::cbrt(x);
            assert!((cube_root(x) - exact).abs() <= 4.0 * f64::EPSILON * exact, "cube root of {x}");
            x *= 1.37;
        }
        assert_eq!([cube_root(0.0), cube_root(8.0), cube_root(-1.0)], [0.0, 2.0, 0.0]);
    }

    #[test]
    fn ordered_sum_adds_every_term_once() {
        for n in [0, 1, 1023, 1024, 1025, 10_000] {
            assert_eq!(ordered_sum(n, 0.0, |i| i as f64), (n * n.saturating_sub(1) / 2) as f64);
        }
    }

    #[test]
    fn embedding_is_undone_by_restriction() {
        let v = Vector::<2>::new(3.0, -4.0);
        assert_eq!(embed(&v), Vector3::new(3.0, 0.0, -4.0));
        assert_eq!(restrict::<2>(&embed(&v)), v);
        assert_eq!(restrict::<3>(&Vector3::new(1.0, 2.0, 3.0)), Vector3::new(1.0, 2.0, 3.0));
    }
}
