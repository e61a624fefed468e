//! Random choices that a seed repeats.

use std::ffi::c_int;

/// SplitMix64: every seed gives another sequence, the same on every machine.
#[derive(Debug, Clone)]
pub struct Random(pub u64);

/// Numbers that programs do not expect.
const STRANGE: [f64; 22] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    1.0 + f64::EPSILON,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    -5e-324,
    1e-300,
    1e300,
    1e-15,
    1e15,
    1e-9,
    1e9,
    9_007_199_254_740_993.0,
    1e-3,
];

impl Random {
    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number below `n`, which is not 0.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// The same as the C interface has it.
    pub fn integer(&mut self, n: usize) -> c_int {
        c_int::try_from(self.below(n)).unwrap_or(c_int::MAX)
    }

    /// True once in `n` times.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// One of them.
    pub fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len())]
    }

    /// A number: strange, any bits, or of an ordinary size.
    pub fn real(&mut self) -> f64 {
        match self.below(4) {
            0 => *self.pick(&STRANGE),
            1 => f64::from_bits(self.bits()),
            _ => self.factor() * if self.once_in(2) { 1.0 } else { -1.0 },
        }
    }

    /// A positive number around 1, of any order of magnitude now and then.
    pub fn factor(&mut self) -> f64 {
        let decades = if self.once_in(4) { 12.0 } else { 1.0 };
        let unit = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        10_f64.powf(decades * (2.0 * unit - 1.0))
    }
}
