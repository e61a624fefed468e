//! What eight elements side by side are whatever their gel is made of.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::MAX_NODES;
use fearless_simd::{Select, Simd, SimdBase, f64x8};

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
    /// Numbers of the nodes within the block.
    pub(super) nodes: [[u16; LANES]; MAX_NODES],
}

impl Batch {
    /// The lanes that have an element.
    pub(super) fn filled(&self) -> impl Iterator<Item = usize> + '_ {
        (0..LANES).filter(|lane| self.volume[*lane] > 0.0)
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

/// As one vector.
#[inline(always)]
pub(super) fn wide<S: Simd>(simd: S, eight: &Wide) -> f64x8<S> {
    f64x8::from_slice(simd, eight)
}
