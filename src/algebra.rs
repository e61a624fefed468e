//! Small dense algebra over nalgebra types, for `D` ∈ {2, 3}.
//!
//! The world is three-dimensional; a planar or axisymmetric gel lives in the x–z plane. [`embed`] and [`restrict`] go
//! between the two. Everything here gives the same bits on every platform: no libm call, no fused multiply-add.

/// A vector of the gel's space.
pub type Vector<const D: usize> = nalgebra::SVector<f64, D>;
/// A second-order tensor of the gel's space.
pub type Tensor<const D: usize> = nalgebra::SMatrix<f64, D, D>;
/// A vector of the world.
pub type Vector3 = nalgebra::Vector3<f64>;
/// A tensor of the world.
pub type Tensor3 = nalgebra::Matrix3<f64>;

/// Determinant.
#[must_use]
#[inline]
pub fn det<const D: usize>(a: &Tensor<D>) -> f64 {
    match D {
        2 => a[(0, 0)] * a[(1, 1)] - a[(0, 1)] * a[(1, 0)],
        3 => {
            a[(0, 0)] * (a[(1, 1)] * a[(2, 2)] - a[(1, 2)] * a[(2, 1)])
                - a[(0, 1)] * (a[(1, 0)] * a[(2, 2)] - a[(1, 2)] * a[(2, 0)])
                + a[(0, 2)] * (a[(1, 0)] * a[(2, 1)] - a[(1, 1)] * a[(2, 0)])
        }
        _ => unreachable!("the gel has two or three dimensions"),
    }
}

/// Cofactor tensor, cof A = ∂det A/∂A = det(A) A⁻ᵀ, defined also where det A = 0.
#[must_use]
#[inline]
pub fn cofactor<const D: usize>(a: &Tensor<D>) -> Tensor<D> {
    let mut c = Tensor::<D>::zeros();
    match D {
        2 => {
            c[(0, 0)] = a[(1, 1)];
            c[(0, 1)] = -a[(1, 0)];
            c[(1, 0)] = -a[(0, 1)];
            c[(1, 1)] = a[(0, 0)];
        }
        3 => {
            for i in 0..3 {
                for j in 0..3 {
                    let (k, l, m, n) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
                    c[(i, j)] = a[(k, m)] * a[(l, n)] - a[(k, n)] * a[(l, m)];
                }
            }
        }
        _ => unreachable!("the gel has two or three dimensions"),
    }
    c
}

/// The world vector of a gel vector: (x, z) ↦ (x, 0, z), and the identity in three dimensions.
#[must_use]
#[inline]
pub fn embed<const D: usize>(v: &Vector<D>) -> Vector3 {
    Vector3::new(v[0], if D == 3 { v[1] } else { 0.0 }, v[D - 1])
}

/// The gel vector of a world vector: (x, y, z) ↦ (x, z), and the identity in three dimensions.
#[must_use]
#[inline]
pub fn restrict<const D: usize>(v: &Vector3) -> Vector<D> {
    Vector::<D>::from_fn(|i, _| if i == D - 1 { v[2] } else { v[i] })
}

/// √(a² + b²) from exact operations only, so that it has the same bits on every platform.
#[must_use]
#[inline]
pub fn hypotenuse(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

/// Sum that depends on the order of the terms only: blocks of 1024, then pairwise over the blocks (numerics A9).
#[must_use]
pub fn ordered_sum<T>(n: usize, zero: T, term: impl Fn(usize) -> T) -> T
where
    T: Copy + std::ops::Add<Output = T>,
{
    const BLOCK: usize = 1024;
    let mut sums: Vec<T> = (0..n.div_ceil(BLOCK))
        .map(|b| (b * BLOCK..n.min((b + 1) * BLOCK)).fold(zero, |sum, i| sum + term(i)))
        .collect();
    while sums.len() > 1 {
        sums = sums.chunks(2).map(|pair| pair.iter().copied().reduce(|a, b| a + b).unwrap_or(zero)).collect();
    }
    sums.first().copied().unwrap_or(zero)
}

/// Natural logarithm of a positive normal number, within 1 ulp of the exact value.
///
/// x = 2ᵏ m with m ∈ [1/√2, √2); ln m = 2 artanh s = 2 Σ s²ⁿ⁺¹/(2n+1) with s = (m − 1)/(m + 1), |s| < 0.172. The
/// series is cut where its next term is below 2⁻⁵⁶. Written out so that element kernels call no libm (numerics A9).
#[must_use]
#[inline(always)]
pub fn ln(x: f64) -> f64 {
    const SQRT_HALF_BITS: u64 = 0x3FE6_A09E_667F_3BCD;
    const LN2_HIGH: f64 = f64::from_bits(0x3FE6_2E42_FEE0_0000);
    const LN2_LOW: f64 = f64::from_bits(0x3DEA_39EF_3579_3C76);
    /// Added to k so that it is positive, and the bits of 2⁵², whose last bits are then k: no vector unit before AVX-512
    /// turns 64-bit integers into floating point.
    const OFFSET: u64 = 2048;
    const TWO_52: u64 = 0x4330_0000_0000_0000;
    let shifted = x.to_bits().wrapping_sub(SQRT_HALF_BITS).wrapping_add(OFFSET << 52) >> 52;
    let m = f64::from_bits(x.to_bits().wrapping_sub(shifted.wrapping_sub(OFFSET) << 52));
    let k = f64::from_bits(TWO_52 | shifted) - (f64::from_bits(TWO_52) + OFFSET as f64);
    let f = m - 1.0;
    let s = f / (m + 1.0);
    let z = s * s;
    let mut tail = 2.0 / 23.0;
    for odd in [21.0, 19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        tail = tail * z + 2.0 / odd;
    }
    let half = 0.5 * f * f;
    // 2s = f − s f and s f = f²/2 − s f²/2: the leading term f stays exact.
    k * LN2_HIGH - ((half - (s * (half + z * tail) + k * LN2_LOW)) - f)
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
    fn logarithm_agrees_with_libm_within_an_ulp() {
        let mut x = 1e-6;
        while x < 1e6 {
            let (own, exact) = (ln(x), libm::log(x));
            assert!((own - exact).abs() <= 1.5 * f64::EPSILON * exact.abs().max(1e-16), "ln({x}) = {own}, not {exact}");
            x *= 1.000_37;
        }
        assert_eq!(ln(1.0), 0.0);
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
