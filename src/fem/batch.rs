//! What eight elements side by side are whatever their gel is made of.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::MAX_NODES;
use fearless_simd::{Select, Simd, SimdBase, SimdSplit, f64x8};
use prefetch_index::prefetch_index;

/// Patches side by side.
pub const LANES: usize = 8;
/// A number of each.
pub(super) type Wide = [f64; LANES];

/// The k-th elements of eight patches.
#[derive(Debug, Clone, Default)]
#[repr(align(64))]
pub struct Batch {
    /// w, rest volume, m³; 0 in an empty lane.
    pub(super) volume: Wide,
    /// 1 over the determinant of the edges at rest, 1/mᴰ; 0 in an empty lane.
    pub(super) scale: Wide,
    /// Where the rows of the nodes begin within the block.
    pub(super) nodes: [[u16; LANES]; MAX_NODES],
}

impl Batch {
    /// The lanes that have an element.
    pub(super) fn filled(&self) -> impl Iterator<Item = usize> + '_ {
        (0..LANES).filter(|lane| self.volume[*lane] > 0.0)
    }

    /// Asks for it before it is needed.
    #[inline(always)]
    pub(super) fn fetch(&self) {
        fetch(&self.volume);
        fetch(&self.scale);
        prefetch_index(self.nodes.as_slice(), 0);
    }

    /// 1/(3R̄) from w = 2πR̄A and the scale 1/(2A), 1/m; 0 in an empty lane.
    #[inline(always)]
    pub(super) fn hoop<S: Simd>(&self, simd: S) -> f64x8<S> {
        let volume = wide(simd, &self.volume) * wide(simd, &self.scale) * 3.0;
        let filled = volume.simd_gt(f64x8::splat(simd, 0.0));
        let ring = f64x8::splat(simd, std::f64::consts::PI) / volume;
        filled.select(ring, f64x8::splat(simd, 0.0))
    }
}

/// An operation on the widest of the vector units that a level has and that are told apart: AVX-512, AVX2, and what every machine has.
/// `dispatch!` would tell SSE4.2 apart, too: a copy more of every kernel, no faster.
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

/// Asks for these numbers before they are needed, so that they are in the nearest cache then.
#[inline(always)]
pub(super) fn fetch(eight: &Wide) {
    prefetch_index(eight, 0);
}

/// As one vector.
#[inline(always)]
pub(super) fn wide<S: Simd>(simd: S, eight: &Wide) -> f64x8<S> {
    f64x8::from_slice(simd, eight)
}

/// a b + c, rounded once.
#[inline(always)]
pub(super) fn fused<S: Simd>(a: f64x8<S>, b: f64x8<S>, c: f64x8<S>) -> f64x8<S> {
    a.simd.mul_add_precise_f64x8(a, b, c)
}

/// cof F.
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

/// det F.
#[inline(always)]
pub(super) fn determinant<const D: usize, S: Simd>(f: &[[f64x8<S>; D]; D]) -> f64x8<S> {
    if D == 2 {
        return fused(f[0][0], f[1][1], -(f[0][1] * f[1][0]));
    }
    let last = f[0][2 % D] * cofactor(f, 0, 2 % D);
    fused(f[0][0], cofactor(f, 0, 0), fused(f[0][1], cofactor(f, 0, 1), last))
}

/// ∂ det F/∂F_ij.
#[inline(always)]
fn cofactor<const D: usize, S: Simd>(f: &[[f64x8<S>; D]; D], i: usize, j: usize) -> f64x8<S> {
    let (k, l, m, n) = ((i + 1) % D, (i + 2) % D, (j + 1) % D, (j + 2) % D);
    match (D, i == j) {
        (2, true) => f[k][m],
        (2, false) => -f[k][m],
        _ => fused(f[k][m], f[l][n], -(f[k][n] * f[l][m])),
    }
}

/// Σ over the lanes: halves first.
#[inline(always)]
pub(super) fn sum<S: Simd>(eight: f64x8<S>) -> f64 {
    let (low, high) = eight.split();
    let (low, high) = (low + high).split();
    let [a, b] = (low + high).into();
    a + b
}
