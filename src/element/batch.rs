//! What eight elements side by side are at rest.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::MAX_NODES;
use crate::algebra::{Tensor, Vector, det};
use fearless_simd::{Select, Simd, SimdBase, f64x8};

/// Patches side by side.
pub const LANES: usize = 8;
/// A number of each.
pub(super) type Wide = [f64; LANES];

/// The k-th elements of eight patches.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub struct Batch<const D: usize> {
    /// w μ |∇N_a|² at rest for a = 1..=D, N/m.
    diagonal: [Wide; D],
    /// w μ ∇N_a·∇N_b, N/m: in space without 1, without 2 and without 3; in the plane that of 1 and 2 alone.
    mixed: [Wide; D],
    /// w, rest volume, m³; 0 in an empty lane.
    pub(super) volume: Wide,
    /// What makes the determinant of the edges det F: 1 over that at rest, 1/mᴰ; 0 in an empty lane.
    pub(super) scale: Wide,
    /// w Σ_a |∇N_a|², without the share of a ring, m.
    pub(super) spread: Wide,
    /// Numbers of the nodes within the block.
    pub(super) nodes: [[u16; LANES]; MAX_NODES],
}

impl<const D: usize> Batch<D> {
    /// Nothing in any lane.
    pub(super) fn empty() -> Self {
        let none = [0.0; LANES];
        let (diagonal, mixed, nodes) = ([none; D], [none; D], [[0; LANES]; MAX_NODES]);
        Self { diagonal, mixed, volume: none, scale: none, spread: none, nodes }
    }

    /// w μ ∇N_a·∇N_b for a, b from 0 as edges are counted.
    #[inline(always)]
    pub(super) fn metric(&self, a: usize, b: usize) -> &Wide {
        match (a == b, D) {
            (true, _) => &self.diagonal[a],
            (false, 3) => &self.mixed[3 - a - b],
            (false, _) => &self.mixed[0],
        }
    }

    /// Puts an element into a lane: ∇N_a for a = 1..=D, w, μ, and the numbers of its nodes.
    pub(super) fn put(
        &mut self,
        lane: usize,
        ((gradients, volume), shear): ((&[Vector<D>], f64), f64),
        nodes: [u16; MAX_NODES],
    ) {
        let shape = volume * shear;
        for (diagonal, gradient) in self.diagonal.iter_mut().zip(gradients) {
            diagonal[lane] = shape * gradient.norm_squared();
        }
        let pairs: &[(usize, usize)] = if D == 3 { &[(1, 2), (0, 2), (0, 1)] } else { &[(0, 1)] };
        for (mixed, (a, b)) in self.mixed.iter_mut().zip(pairs) {
            mixed[lane] = shape * gradients[*a].dot(&gradients[*b]);
        }
        let first: Vector<D> = gradients.iter().sum();
        self.volume[lane] = volume;
        self.scale[lane] = det(&Tensor::<D>::from_columns(gradients));
        self.spread[lane] = volume * gradients.iter().chain([&first]).map(Vector::<D>::norm_squared).sum::<f64>();
        for (wide, node) in self.nodes.iter_mut().zip(nodes) {
            wide[lane] = node;
        }
    }

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
