//! Batches of eight elements, one per vector lane, and their elementary vector operations.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use crate::fem::MAX_NODES;
use fearless_simd::{Simd, SimdBase, SimdSplit, f64x8};

/// Vector lanes, one patch in each.
pub const LANES: usize = 8;
/// One number per lane.
pub(crate) type LaneArray = [f64; LANES];

/// Rest geometry and nodes of the k-th elements of eight patches.
#[derive(Debug, Clone, Default)]
#[repr(align(64))]
pub struct ElementBatch {
    /// Rest volume w, m³; 0 in an empty lane.
    pub(crate) volume: LaneArray,
    /// Inverse determinant of the rest edges, 1/mᴰ; 0 in an empty lane.
    pub(crate) scale: LaneArray,
    /// First number of the row of each node in the node cache.
    pub(super) nodes: [[u16; LANES]; MAX_NODES],
}

impl ElementBatch {
    /// Iterates over the lanes with an element.
    pub(super) fn filled_lanes(&self) -> impl Iterator<Item = usize> + '_ {
        (0..LANES).filter(|lane| self.volume[*lane] > 0.0)
    }
}

/// Runs an operation with the widest vector unit of a level: AVX-512, AVX2 or the baseline of the architecture; with
/// `narrow` at most AVX2, for what is not worth one more copy of the kernels.
///
/// `dispatch!` would add SSE4.2: one more copy of every kernel, no faster.
macro_rules! on {
    (narrow $level:expr, $simd:ident => $operation:expr) => {{
        let level: fearless_simd::Level = $level;
        #[cfg(target_arch = "x86_64")]
        {
            if let Some($simd) = level.as_avx2() {
                on!(@unit $simd => $operation)
            } else {
                let $simd = level.as_sse2().expect("every such machine has that");
                on!(@unit $simd => $operation)
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            fearless_simd::dispatch!(level, $simd => $operation)
        }
    }};
    ($level:expr, $simd:ident => $operation:expr) => {{
        let level: fearless_simd::Level = $level;
        #[cfg(target_arch = "x86_64")]
        {
            if let Some($simd) = level.as_avx512() {
                on!(@unit $simd => $operation)
            } else if let Some($simd) = level.as_avx2() {
                on!(@unit $simd => $operation)
            } else {
                let $simd = level.as_sse2().expect("every such machine has that");
                on!(@unit $simd => $operation)
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            fearless_simd::dispatch!(level, $simd => $operation)
        }
    }};
    (@unit $simd:ident => $operation:expr) => {
        fearless_simd::Simd::vectorize(
            $simd,
            #[inline(always)]
            || $operation,
        )
    };
}
pub(crate) use on;

/// Loads eight numbers as one vector.
#[inline(always)]
pub(crate) fn load_lanes<S: Simd>(simd: S, eight: &LaneArray) -> f64x8<S> {
    f64x8::from_slice(simd, eight)
}

/// Returns the sum over the lanes, halves first.
#[inline(always)]
pub(super) fn sum_lanes<S: Simd>(eight: f64x8<S>) -> f64 {
    let (low, high) = eight.split();
    let (low, high) = (low + high).split();
    let [a, b] = (low + high).into();
    a + b
}
