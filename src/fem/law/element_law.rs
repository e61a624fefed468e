//! Interface of a material in vector lanes: eight elements at once.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::{ElementBatch, LANES, multiply_add};
use super::history::{HistoryLanes, HistoryLayout};
use super::layout::GroupKick;
use super::node_cache::NodeRows;
use super::rest_geometry::RestGeometry;
use super::transpose::gather;
use super::{MAX_NODES, Section};
use crate::constitutive::VolumetricEnergy;
use crate::math::Number;
use fearless_simd::{Simd, SimdBase, f64x8};

/// Input of a material for eight elements.
pub(super) struct BatchInput<'a, R> {
    /// Rest volumes and nodes.
    pub batch: &'a ElementBatch,
    /// Rest data of the material.
    pub rest: &'a R,
    /// Kick of the group.
    pub kick: GroupKick,
    /// History variables, updated by the evaluation.
    pub history: &'a mut [HistoryLanes],
}

/// Material law in vector lanes.
pub(super) trait SimdMaterial<const D: usize>: HistoryLayout<D> + Copy {
    /// Rest data of eight elements.
    type Rest: RestOperator<D>;
    /// True if elements may be strained at the rest positions of their nodes.
    const HAS_HISTORY: bool;
    /// Computes the rest data of eight elements; 0 in empty lanes.
    fn rest<S: Simd>(&self, shape: &RestGeometry<D, f64x8<S>>) -> Self::Rest;
    /// Returns the volumetric energy law.
    fn volume(&self) -> impl VolumetricEnergy;
    /// Evaluates the elements and updates their history variables.
    fn evaluate<S: Simd>(
        &self,
        section: Section,
        input: BatchInput<'_, Self::Rest>,
        strains: &BatchDeformation<D, f64x8<S>>,
        slopes: &VolumetricSlopes<f64x8<S>>,
    ) -> ElementForces<D, f64x8<S>>;
}

/// Rest data of eight elements, which maps their edges to deformation gradients.
pub(super) trait RestOperator<const D: usize>: Clone + Default {
    /// Prefetches the data into the cache.
    fn prefetch(&self);
    /// Replaces the edges, as columns, by F or the tensor that the material uses instead.
    ///
    /// `strained` is 1 in strained lanes and 0 at rest, `scale` that of the batch. Returns the factor from the
    /// determinant of the tensor to det F.
    fn deform<S: Simd>(&self, strained: f64x8<S>, scale: f64x8<S>, edges: &mut [[f64x8<S>; D]; D]) -> f64x8<S>;
}

/// Forces, stiffness bounds, energy and dissipation of eight elements.
#[derive(Clone, Copy)]
pub(super) struct ElementForces<const D: usize, V> {
    /// Forces on all nodes but the first, which takes the reaction, without the hoop force, N.
    pub forces: [[V; D]; D],
    /// Hoop force of a ring on each node along r, N.
    pub hoop_force: V,
    /// Stiffness bound κ, N/m.
    pub stiffness: V,
    /// Stored energy without the volumetric part, J.
    pub energy: V,
    /// Dissipation by plastic flow, viscosity and damage, J.
    pub lost: [V; 3],
}

/// Deformation of eight elements.
#[derive(Clone, Copy)]
pub(super) struct BatchDeformation<const D: usize, V> {
    /// F, or the tensor that the material uses instead.
    pub f: [[V; D]; D],
    /// Out-of-plane stretch λ.
    pub out: V,
    /// Hoop gradient 1/(3R̄), 1/m.
    pub hoop: V,
    /// det F in the plane or in space, without λ.
    pub det_f: V,
    /// 1 for a strained element, 0 at rest.
    pub strained: V,
}

/// U′ and max(U″, 0) of eight elements, element and patch parts together, Pa.
#[derive(Clone, Copy)]
pub(super) struct VolumetricSlopes<V> {
    pub slope: V,
    pub curvature: V,
}

impl<const D: usize, V: Number> BatchDeformation<D, V> {
    /// Returns the deformation of elements at rest.
    #[inline(always)]
    pub fn at_rest(zero: V) -> Self {
        let (none, one) = ([[zero; D]; D], zero + 1.0);
        Self { f: none, out: one, hoop: zero, det_f: one, strained: zero }
    }

    /// Returns J = λ det F.
    #[inline(always)]
    pub fn jacobian(&self) -> V {
        if D == 2 { self.det_f * self.out } else { self.det_f }
    }
}

impl<const D: usize, S: Simd> ElementForces<D, f64x8<S>> {
    /// Returns weight · f and κ at every node.
    #[inline(always)]
    pub fn nodal_kicks(&self, weight: f64x8<S>) -> [[f64x8<S>; 4]; MAX_NODES] {
        let zero = f64x8::splat(weight.simd, 0.0);
        let mut kicks = [[zero, zero, zero, self.stiffness]; MAX_NODES];
        for i in 0..D {
            for a in 0..D {
                kicks[a + 1][i] = self.forces[a][i] * weight;
                kicks[0][i] -= kicks[a + 1][i];
            }
        }
        if D == 2 {
            let hoop_force = self.hoop_force * weight;
            for a in 0..=D {
                kicks[a][0] += hoop_force;
            }
        }
        kicks
    }

    /// Returns the power Σ f·v, W.
    #[inline(always)]
    pub fn power(&self, nodes: &[[u16; LANES]; MAX_NODES], velocities: &NodeRows) -> f64x8<S> {
        let simd = self.hoop_force.simd;
        let v = gather::<D, S>(simd, nodes, velocities);
        let mut power = if D == 2 { self.hoop_force * (v[0][0] + v[1][0] + v[2][0]) } else { f64x8::splat(simd, 0.0) };
        for i in 0..D {
            for a in 0..D {
                power = multiply_add(self.forces[a][i], v[a + 1][i] - v[0][i], power);
            }
        }
        power
    }
}
