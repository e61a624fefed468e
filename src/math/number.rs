//! Real numbers and vectors of eight: one generic source for scalar and SIMD kernels.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat, f64x8, u64x8};
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Real number or SIMD vector of reals, with exact or correctly rounded operations only: all forms give the same bits.
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
    /// Number of each lane, as it is stored: one or eight.
    type Lanes: Copy + Default + Debug;
    /// Loads the stored numbers of all lanes.
    #[must_use]
    fn load(self, lanes: &Self::Lanes) -> Self;
    /// Returns the numbers of all lanes to be stored.
    #[must_use]
    fn store(self) -> Self::Lanes;
    /// Returns a constant in every lane.
    #[must_use]
    fn constant(self, value: f64) -> Self;
    /// Returns self · factor + sum, rounded once (fused multiply-add).
    #[must_use]
    fn multiply_add(self, factor: Self, sum: Self) -> Self;
    /// Returns |x|.
    #[must_use]
    fn absolute(self) -> Self;
    /// Returns √x.
    #[must_use]
    fn root(self) -> Self;
    /// Returns the maximum with a constant; the constant if either is not a number.
    #[must_use]
    fn at_least(self, other: f64) -> Self;
    /// Returns the minimum with a constant; the constant if either is not a number.
    #[must_use]
    fn at_most(self, other: f64) -> Self;
    /// Returns the maximum of two numbers.
    #[must_use]
    fn or_greater(self, other: Self) -> Self;
    /// Selects `first` in the lanes where `self` is positive, else `second`.
    #[must_use]
    fn choose(self, first: Self, second: Self) -> Self;
    /// Returns true if a lane is positive.
    #[must_use]
    fn any_positive(self) -> bool;
    /// Splits a positive normal number x = 2ᵏ m into k and m ∈ [1/√2, √2).
    #[must_use]
    fn octave(self) -> (Self, Self);
    /// Returns 2ᵏ of an integer k, |k| ≤ 1022.
    #[must_use]
    fn power_of_two(self) -> Self;
}

/// Bits of 1/√2.
const SQRT_HALF: u64 = 0x3FE6_A09E_667F_3BCD;
/// Offset that makes k positive.
const OFFSET: u64 = 2048;
/// Bits of 2⁵²; or-ing k into its last bits converts k to floating point, as no vector unit before AVX-512 converts
/// 64-bit integers.
const TWO_52: u64 = 0x4330_0000_0000_0000;
/// 2⁵² plus [`OFFSET`], subtracted after the conversion of k.
const OFFSET_AND_TWO_52: f64 = 4_503_599_627_370_496.0 + 2048.0;
/// 2⁵² plus the exponent bias 1023: the last bits of the sum with k are the exponent bits of 2ᵏ.
const TWO_52_AND_BIAS: f64 = 4_503_599_627_370_496.0 + 1023.0;
/// 1.5 · 2⁵²: adding and subtracting it rounds to an integer.
const WHOLE: f64 = 6_755_399_441_055_744.0;

impl Number for f64 {
    type Lanes = Self;

    #[inline(always)]
    fn load(self, lanes: &Self) -> Self {
        *lanes
    }

    #[inline(always)]
    fn store(self) -> Self {
        self
    }

    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn multiply_add(self, factor: Self, sum: Self) -> Self {
        self.mul_add(factor, sum)
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

    #[inline(always)]
    fn choose(self, first: Self, second: Self) -> Self {
        if self > 0.0 { first } else { second }
    }

    #[inline(always)]
    fn any_positive(self) -> bool {
        self > 0.0
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        f64::from_bits((self + TWO_52_AND_BIAS).to_bits() << 52)
    }
}

impl<S: Simd> Number for f64x8<S> {
    type Lanes = [f64; 8];

    #[inline(always)]
    fn load(self, lanes: &[f64; 8]) -> Self {
        Self::from_slice(self.simd, lanes)
    }

    #[inline(always)]
    fn store(self) -> [f64; 8] {
        self.into()
    }

    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        self.simd.splat_f64x8(value)
    }

    #[inline(always)]
    fn multiply_add(self, factor: Self, sum: Self) -> Self {
        self.simd.mul_add_precise_f64x8(self, factor, sum)
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

    #[inline(always)]
    fn choose(self, first: Self, second: Self) -> Self {
        self.simd_gt(self.constant(0.0)).select(first, second)
    }

    #[inline(always)]
    fn any_positive(self) -> bool {
        self.simd.to_bitmask_mask64x8(self.simd_gt(self.constant(0.0))) != 0
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        let bits: u64x8<S> = (self + TWO_52_AND_BIAS).bitcast();
        self.simd.shl_u64x8(bits, 52).bitcast()
    }
}

/// Leading digits of ln 2, few enough for exact integer multiples.
const LN2_HIGH: f64 = f64::from_bits(0x3FE6_2E42_FEE0_0000);
/// Remainder of ln 2 after [`LN2_HIGH`].
const LN2_LOW: f64 = f64::from_bits(0x3DEA_39EF_3579_3C76);

/// Returns the natural logarithm of a positive normal number, within 1 ulp of the exact value.
///
/// x = 2ᵏ m with m ∈ [1/√2, √2); ln m = 2 artanh s = 2 Σ s²ⁿ⁺¹/(2n+1) with s = (m − 1)/(m + 1), |s| < 0.172. The
/// series is truncated where its next term is below 2⁻⁵⁶. Element kernels thus call no libm (method A9).
#[must_use]
#[inline(always)]
pub fn ln<T: Number>(x: T) -> T {
    let (k, m) = x.octave();
    let f = m - 1.0;
    let s = f / (m + 1.0);
    let z = s * s;
    // Even and odd terms separately: two short dependency chains instead of a long one.
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

/// Returns eˣ within 1 ulp of the exact value; x is clamped to ±700.
#[must_use]
#[inline(always)]
pub fn exp<T: Number>(x: T) -> T {
    let (power, more) = exponential(x);
    // 1 + (r + r² …): the small terms are added first.
    (more + 1.0) * power
}

/// Returns eˣ − 1 within some ulps of the exact value, small x included; x is clamped to ±700.
#[must_use]
#[inline(always)]
pub fn exp_less_one<T: Number>(x: T) -> T {
    let (power, more) = exponential(x);
    more * power + (power - 1.0)
}

/// Returns 2ᵏ and eʳ − 1 with x = k ln 2 + r, |r| ≤ ln 2/2: eˣ = 2ᵏ Σ rⁿ/n!.
///
/// The series is truncated where its next term is below 2⁻⁵⁷.
#[inline(always)]
fn exponential<T: Number>(x: T) -> (T, T) {
    const INVERSE: [f64; 14] = {
        let (mut all, mut n) = ([1.0; 14], 1);
        while n < 14 {
            all[n] = all[n - 1] / n as f64;
            n += 1;
        }
        all
    };
    let x = x.at_least(-700.0).at_most(700.0);
    let k = (x * std::f64::consts::LOG2_E + WHOLE) - WHOLE;
    let r = (x - k * LN2_HIGH) - k * LN2_LOW;
    let w = r * r;
    let (mut even, mut odd) = (x.constant(INVERSE[12]), x.constant(INVERSE[13]));
    for n in [10, 8, 6, 4, 2] {
        even = even * w + INVERSE[n];
        odd = odd * w + INVERSE[n + 1];
    }
    (k.power_of_two(), even * w + odd * w * r + r)
}

/// Returns xᵐ of a positive normal number, within some roundings times |m ln x|.
#[must_use]
#[inline(always)]
pub fn power<T: Number>(x: T, exponent: f64) -> T {
    exp(ln(x) * exponent)
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

    #[test]
    fn exp_agrees_with_libm_within_an_ulp() {
        let mut x = -690.0;
        while x < 690.0 {
            let (own, exact) = (exp(x), libm::exp(x));
            assert!((own - exact).abs() <= 1.5 * f64::EPSILON * exact, "exp({x}) = {own}, not {exact}");
            x += 0.1037;
        }
        assert_eq!([exp(0.0), exp(-0.0), exp(f64::NEG_INFINITY)], [1.0, 1.0, exp(-700.0)]);
    }

    #[test]
    fn exp_less_one_agrees_with_libm_near_zero_too() {
        let mut x = 1e-17;
        while x < 690.0 {
            for x in [x, -x] {
                let (own, exact) = (exp_less_one(x), libm::expm1(x));
                assert!((own - exact).abs() <= 2.5 * f64::EPSILON * exact.abs(), "exp({x}) - 1 = {own}, not {exact}");
            }
            x *= 1.0137;
        }
        assert_eq!(exp_less_one(0.0), 0.0);
    }

    #[test]
    fn powers_agree_with_libm() {
        for exponent in [0.23, 0.95, -2.0 / 3.0] {
            let mut x = 1e-9;
            while x < 1e9 {
                let (own, exact) = (power(x, exponent), libm::pow(x, exponent));
                assert!((own / exact - 1.0).abs() < 32.0 * f64::EPSILON, "{x} to the {exponent} is {exact}, not {own}");
                x *= 1.377;
            }
        }
        assert_eq!(power(1.0, 0.3), 1.0);
    }

    #[test]
    fn eight_exponentials_have_the_bits_of_one() {
        let mut x = [-1e9, -20.0, -0.4, -1e-9, 0.0, 0.3, 3.0, 690.0];
        for _ in 0..2000 {
            let eight: [f64; 8] = dispatch!(Level::new(), simd => exp(f64x8::from_slice(simd, &x)).into());
            assert_eq!(eight, x.map(exp::<f64>));
            x = x.map(|x| x * 0.997_7 + 0.001);
        }
    }

    #[test]
    fn eight_selections_agree_with_scalar_ones() {
        let (x, nan) = ([-1.0, 0.0, -0.0, 1e-300, 2.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY], [f64::NAN; 8]);
        let eight: [f64; 8] = dispatch!(Level::new(), simd => {
            f64x8::from_slice(simd, &x).choose(f64x8::splat(simd, 1.0), f64x8::splat(simd, 2.0)).into()
        });
        assert_eq!(eight, x.map(|x| x.choose(1.0, 2.0)));
        let any = |x: [f64; 8]| dispatch!(Level::new(), simd => f64x8::from_slice(simd, &x).any_positive());
        assert!(any(x) && !any(nan) && !any([0.0; 8]));
    }
}
