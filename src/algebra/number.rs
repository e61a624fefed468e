//! One source for one number and for eight of them side by side.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use fearless_simd::{Bytes, Simd, SimdBase, SimdFloat, f64x8, u64x8};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number, or several side by side: only operations that are exact or correctly rounded, so that all give the same
/// bits.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// The same constant everywhere.
    #[must_use]
    fn constant(self, value: f64) -> Self;
    /// |x|.
    #[must_use]
    fn absolute(self) -> Self;
    /// √x.
    #[must_use]
    fn root(self) -> Self;
    /// The greater of two; the second if one is not a number.
    #[must_use]
    fn at_least(self, other: f64) -> Self;
    /// The smaller of two; the second if one is not a number.
    #[must_use]
    fn at_most(self, other: f64) -> Self;
    /// The greater of two.
    #[must_use]
    fn or_greater(self, other: Self) -> Self;
    /// k and m ∈ [1/√2, √2) of a positive normal number x = 2ᵏ m.
    #[must_use]
    fn octave(self) -> (Self, Self);
}

const SQRT_HALF: u64 = 0x3FE6_A09E_667F_3BCD;
/// Added to k so that it is positive, and the bits of 2⁵², whose last bits are then k: no vector unit before AVX-512 turns
/// 64-bit integers into floating point.
const OFFSET: u64 = 2048;
const TWO_52: u64 = 0x4330_0000_0000_0000;
const OFFSET_AND_TWO_52: f64 = 4_503_599_627_370_496.0 + 2048.0;

impl Number for f64 {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn absolute(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn at_least(self, other: f64) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn at_most(self, other: f64) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn or_greater(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn octave(self) -> (Self, Self) {
        let bits = self.to_bits();
        let shifted = bits.wrapping_sub(SQRT_HALF).wrapping_add(OFFSET << 52) >> 52;
        let m = f64::from_bits(bits.wrapping_sub(shifted.wrapping_sub(OFFSET) << 52));
        (f64::from_bits(TWO_52 | shifted) - OFFSET_AND_TWO_52, m)
    }
}

impl<S: Simd> Number for f64x8<S> {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        self.simd.splat_f64x8(value)
    }

    #[inline(always)]
    fn absolute(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn at_least(self, other: f64) -> Self {
        self.max(self.constant(other))
    }

    #[inline(always)]
    fn at_most(self, other: f64) -> Self {
        self.min(self.constant(other))
    }

    #[inline(always)]
    fn or_greater(self, other: Self) -> Self {
        self.max(other)
    }

    #[inline(always)]
    fn octave(self) -> (Self, Self) {
        let simd = self.simd;
        let all = |bits: u64| simd.splat_u64x8(bits);
        let bits: u64x8<S> = self.bitcast();
        let shifted = simd.shr_u64x8(bits - all(SQRT_HALF.wrapping_sub(OFFSET << 52)), 52);
        let m: Self = (bits - simd.shl_u64x8(shifted - all(OFFSET), 52)).bitcast();
        let k: Self = (shifted | all(TWO_52)).bitcast();
        (k - OFFSET_AND_TWO_52, m)
    }
}

/// Natural logarithm of a positive normal number, within 1 ulp of the exact value.
///
/// x = 2ᵏ m with m ∈ [1/√2, √2); ln m = 2 artanh s = 2 Σ s²ⁿ⁺¹/(2n+1) with s = (m − 1)/(m + 1), |s| < 0.172. The
/// series is cut where its next term is below 2⁻⁵⁶. Written out so that element kernels call no libm (numerics A9).
#[must_use]
#[inline(always)]
pub fn ln<T: Number>(x: T) -> T {
    const LN2_HIGH: f64 = f64::from_bits(0x3FE6_2E42_FEE0_0000);
    const LN2_LOW: f64 = f64::from_bits(0x3DEA_39EF_3579_3C76);
    let (k, m) = x.octave();
    let f = m - 1.0;
    let s = f / (m + 1.0);
    let z = s * s;
    // Every other term by itself: two short chains, not a long one that all would wait for.
    let w = z * z;
    let (mut even, mut odd) = (x.constant(2.0 / 23.0), x.constant(2.0 / 21.0));
    for at in [19.0, 15.0, 11.0, 7.0, 3.0] {
        even = even * w + 2.0 / at;
    }
    for at in [17.0, 13.0, 9.0, 5.0] {
        odd = odd * w + 2.0 / at;
    }
    let tail = even + odd * z;
    let half = f * 0.5 * f;
    // 2s = f − s f and s f = f²/2 − s f²/2: the leading term f stays exact.
    k * LN2_HIGH - ((half - (s * (half + z * tail) + k * LN2_LOW)) - f)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

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
    fn eight_logarithms_have_the_bits_of_one() {
        let mut x = [1e-7, 0.2, 0.707, 0.708, 1.0, 1.41, 1.42, 37.0];
        for _ in 0..2000 {
            let eight: [f64; 8] = dispatch!(Level::new(), simd => ln(f64x8::from_slice(simd, &x)).into());
            assert_eq!(eight, x.map(ln::<f64>));
            x = x.map(|x| x * 1.007_7);
        }
    }
}
