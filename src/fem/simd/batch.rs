//! Batches of eight elements, one per vector lane, and their elementary vector operations.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::MAX_NODES;
use fearless_simd::{Select, Simd, SimdBase, SimdSplit, f64x8};
use prefetch_index::prefetch_index;

/// Vector lanes, one patch in each.
pub const LANES: usize = 8;
/// One number per lane.
pub(super) type LaneArray = [f64; LANES];

/// Rest geometry and nodes of the k-th elements of eight patches.
#[derive(Debug, Clone, Default)]
#[repr(align(64))]
pub struct ElementBatch {
    /// Rest volume w, m³; 0 in an empty lane.
    pub(super) volume: LaneArray,
    /// Inverse determinant of the rest edges, 1/mᴰ; 0 in an empty lane.
    pub(super) scale: LaneArray,
    /// First number of the row of each node in the node cache.
    pub(super) nodes: [[u16; LANES]; MAX_NODES],
}

impl ElementBatch {
    /// Iterates over the lanes with an element.
    pub(super) fn filled_lanes(&self) -> impl Iterator<Item = usize> + '_ {
        (0..LANES).filter(|lane| self.volume[*lane] > 0.0)
    }

    /// Prefetches the batch into the cache.
    #[inline(always)]
    pub(super) fn prefetch(&self) {
        prefetch(&self.volume);
        prefetch(&self.scale);
        prefetch_index(self.nodes.as_slice(), 0);
    }

    /// Returns the hoop gradient 1/(3R̄), 1/m, from w = 2πR̄A and the scale 1/(2A); 0 in an empty lane.
    #[inline(always)]
    pub(super) fn hoop<S: Simd>(&self, simd: S) -> f64x8<S> {
        let volume = load_lanes(simd, &self.volume) * load_lanes(simd, &self.scale) * 3.0;
        let filled = volume.simd_gt(f64x8::splat(simd, 0.0));
        let ring = f64x8::splat(simd, std::f64::consts::PI) / volume;
        filled.select(ring, f64x8::splat(simd, 0.0))
    }
}

/// Runs an operation with the widest vector unit of a level: AVX-512, AVX2 or the baseline of the architecture.
///
/// `dispatch!` would add SSE4.2: one more copy of every kernel, no faster.
macro_rules! on {
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

/// Prefetches eight numbers into the nearest cache.
#[inline(always)]
pub(super) fn prefetch(eight: &LaneArray) {
    prefetch_index(eight, 0);
}

/// Loads eight numbers as one vector.
#[inline(always)]
pub(super) fn load_lanes<S: Simd>(simd: S, eight: &LaneArray) -> f64x8<S> {
    f64x8::from_slice(simd, eight)
}

/// Returns a b + c, rounded once (fused multiply-add).
#[inline(always)]
pub(super) fn multiply_add<S: Simd>(a: f64x8<S>, b: f64x8<S>, c: f64x8<S>) -> f64x8<S> {
    a.simd.mul_add_precise_f64x8(a, b, c)
}

/// Returns cof F.
#[inline(always)]
pub(super) fn cofactors<const D: usize, S: Simd>(f: &[[f64x8<S>; D]; D]) -> [[f64x8<S>; D]; D] {
    let mut all = *f;
    for i in 0..D {
        for j in 0..D {
            all[i][j] = cofactor(f, i, j);
        }
    }
    all
}

/// Returns det F.
#[inline(always)]
pub(super) fn determinant<const D: usize, S: Simd>(f: &[[f64x8<S>; D]; D]) -> f64x8<S> {
    if D == 2 {
        return multiply_add(f[0][0], f[1][1], -(f[0][1] * f[1][0]));
    }
    let last = f[0][2 % D] * cofactor(f, 0, 2 % D);
    multiply_add(f[0][0], cofactor(f, 0, 0), multiply_add(f[0][1], cofactor(f, 0, 1), last))
}

/// Returns the cofactor ∂ det F/∂F_ij.
#[inline(always)]
fn cofactor<const D: usize, S: Simd>(f: &[[f64x8<S>; D]; D], i: usize, j: usize) -> f64x8<S> {
    let (k, l, m, n) = ((i + 1) % D, (i + 2) % D, (j + 1) % D, (j + 2) % D);
    match (D, i == j) {
        (2, true) => f[k][m],
        (2, false) => -f[k][m],
        _ => multiply_add(f[k][m], f[l][n], -(f[k][n] * f[l][m])),
    }
}

/// Returns the sum over the lanes, halves first.
#[inline(always)]
pub(super) fn sum_lanes<S: Simd>(eight: f64x8<S>) -> f64 {
    let (low, high) = eight.split();
    let (low, high) = (low + high).split();
    let [a, b] = (low + high).into();
    a + b
}
