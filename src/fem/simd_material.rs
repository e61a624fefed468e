//! What a material does with eight strained elements side by side.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::{Batch, LANES, fused};
use super::history::{Recall, Remembering};
use super::layout::Kick;
use super::node_cache::Rows;
use super::rest_geometry::Shape;
use super::transpose::gather;
use super::{MAX_NODES, Section};
use crate::constitutive::Volume;
use crate::math::Number;
use fearless_simd::{Simd, SimdBase, f64x8};

/// Eight elements: what they are, what their law knows of them at rest, their kick, and what they remember.
pub(super) type Eight<'a, R> = (&'a Batch, &'a R, Kick, &'a mut [Recall]);

/// A material in lanes.
pub(super) trait Solid<const D: usize>: Remembering<D> + Copy {
    /// What it knows of eight elements at rest.
    type Rest: Undeformed<D>;
    /// Whether elements can be strained where their nodes are at rest.
    const REMEMBERS: bool;
    /// Of eight elements; of lanes that have none all is 0.
    fn rest<S: Simd>(&self, shape: &Shape<D, f64x8<S>>) -> Self::Rest;
    /// What a change of their volume stores.
    fn volume(&self) -> impl Volume;
    /// What the elements do; what they remember goes on.
    fn pull<S: Simd>(
        &self,
        section: Section,
        of: Eight<'_, Self::Rest>,
        now: (&Strains<D, f64x8<S>>, &Slopes<f64x8<S>>),
    ) -> Pull<D, f64x8<S>>;
}

/// What a material in lanes knows of eight elements at rest.
pub(super) trait Undeformed<const D: usize>: Clone + Default {
    /// Asks for it before it is needed.
    fn fetch(&self);
    /// Takes the edges, as columns, for what the law goes by, of elements that are strained (1) or at rest (0), with the scale of their
    /// batch; what makes its determinant that of F.
    fn deform<S: Simd>(&self, of: (f64x8<S>, f64x8<S>), edges: &mut [[f64x8<S>; D]; D]) -> f64x8<S>;
}

/// What eight elements do.
#[derive(Clone, Copy)]
pub(super) struct Pull<const D: usize, V> {
    /// Forces on their nodes but the first, which is given the reaction, without what a ring adds, N.
    pub forces: [[V; D]; D],
    /// What a ring adds to all of them along r, N.
    pub around: V,
    /// κ, N/m.
    pub stiffness: V,
    /// What they store, but for the volumetric part, J.
    pub energy: V,
    /// What they have lost, as a [`super::GroupAnswer`] has it, J.
    pub lost: [V; 3],
}

/// F, or what the law goes by instead, λ, 1/(3R̄) and det F of eight elements; 1 where they pull, 0 where all is at rest.
#[derive(Clone, Copy)]
pub(super) struct Strains<const D: usize, V> {
    pub f: [[V; D]; D],
    pub out: V,
    pub hoop: V,
    pub inner: V,
    pub strained: V,
}

/// U′ and max(U″, 0) of eight elements with their shares of their patches'.
#[derive(Clone, Copy)]
pub(super) struct Slopes<V> {
    pub slope: V,
    pub curvature: V,
}

impl<const D: usize, V: Number> Strains<D, V> {
    #[inline(always)]
    pub fn at_rest(zero: V) -> Self {
        let (none, one) = ([[zero; D]; D], zero + 1.0);
        Self { f: none, out: one, hoop: zero, inner: one, strained: zero }
    }

    /// J.
    #[inline(always)]
    pub fn jacobian(&self) -> V {
        if D == 2 { self.inner * self.out } else { self.inner }
    }
}

impl<const D: usize, S: Simd> Pull<D, f64x8<S>> {
    /// weight · f and κ at every node.
    #[inline(always)]
    pub fn kicks(&self, weight: f64x8<S>) -> [[f64x8<S>; 4]; MAX_NODES] {
        let zero = f64x8::splat(weight.simd, 0.0);
        let mut kicks = [[zero, zero, zero, self.stiffness]; MAX_NODES];
        for i in 0..D {
            for a in 0..D {
                kicks[a + 1][i] = self.forces[a][i] * weight;
                kicks[0][i] -= kicks[a + 1][i];
            }
        }
        if D == 2 {
            let around = self.around * weight;
            for a in 0..=D {
                kicks[a][0] += around;
            }
        }
        kicks
    }

    /// Σ f·v, W.
    #[inline(always)]
    pub fn power(&self, nodes: &[[u16; LANES]; MAX_NODES], velocities: &Rows) -> f64x8<S> {
        let simd = self.around.simd;
        let v = gather::<D, S>(simd, nodes, velocities);
        let mut power = if D == 2 { self.around * (v[0][0] + v[1][0] + v[2][0]) } else { f64x8::splat(simd, 0.0) };
        for i in 0..D {
            for a in 0..D {
                power = fused(self.forces[a][i], v[a + 1][i] - v[0][i], power);
            }
        }
        power
    }
}
