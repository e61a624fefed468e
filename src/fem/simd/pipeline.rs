//! Software-pipelined SIMD element loop over groups of patches.
//!
//! Several batches pass each stage (strain, pressure, force) together: a single group is one long dependency chain,
//! from the positions through ln J to the forces, whose latency the other batches hide.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::{ElementBatch, LANES, LaneArray, load_lanes, on, sum_lanes};
use super::layout::{BatchLaw, ElementBatches, GroupKicks, GroupResponse, ReportPower, SweepInput, SweepOutput};
use super::node_cache::{NodeAccess, NodeCache, NodeRows};
use super::transpose::{gather, scatter};
use crate::constitutive::NeoHookean;
use crate::fem::GroupKick;
use crate::fem::history::HistoryLanes;
use crate::fem::inversion_time::{FORESEEN, RadialSums, TURNED, closing_rate};
use crate::fem::law::element_law::{
    ElementDeformation, ElementLaw, LawInput, VolumetricSlopes, evaluate_elements, evaluate_volumetric,
};
use crate::fem::{Dissipation, Section, max_patch_size};
use crate::math::Number;
use fearless_simd::{Level, Simd, SimdBase, SimdSplit, f64x8};
use std::any::Any;

/// Safety factor of a bound against rounding.
const ROUNDING: f64 = 1.001;

/// Batches per pipeline stage: one group of patches of four elements, several groups of smaller patches.
///
/// One batch: 15.2 ns per tetrahedron; four: 14.1; 8 and 16 are no faster than four.
const BATCHES_PER_STAGE: usize = 4;

/// Groups in the pipeline; the batches of the g-th group begin at g times the batches of a group.
struct Pipeline<const D: usize, V> {
    /// Index and kick of each group.
    groups: [(usize, GroupKick); BATCHES_PER_STAGE],
    n_groups: usize,
    strains: [ElementDeformation<D, V>; BATCHES_PER_STAGE],
    slopes: [VolumetricSlopes<V>; BATCHES_PER_STAGE],
    /// Mask of each group: 1 in the lanes of strained patches, else 0.
    strained: [V; BATCHES_PER_STAGE],
    /// Volumetric energy of each group, J.
    energy: [V; BATCHES_PER_STAGE],
}

/// Output of the force stage for one group.
struct GroupOutput<'a> {
    /// Request for the power of the group.
    power: ReportPower,
    /// κ of each slot, N/m.
    stiffness: &'a mut [f64],
    /// History variables.
    memory: &'a mut [HistoryLanes],
}

impl<const D: usize, V: Number> Pipeline<D, V> {
    #[inline(always)]
    fn new(zero: V) -> Self {
        Self {
            groups: [(0, GroupKick::NONE); BATCHES_PER_STAGE],
            n_groups: 0,
            strains: [ElementDeformation::at_rest(zero); BATCHES_PER_STAGE],
            slopes: [VolumetricSlopes { slope: zero, curvature: zero }; BATCHES_PER_STAGE],
            strained: [zero; BATCHES_PER_STAGE],
            energy: [zero; BATCHES_PER_STAGE],
        }
    }

    /// Fills the pipeline with the next active groups of `N` batches each; returns the first group not considered.
    #[inline(always)]
    fn fill<const N: usize>(&mut self, first: usize, end: usize, kicks: GroupKicks<'_>) -> usize {
        const { assert!(N <= BATCHES_PER_STAGE, "a group goes through the stages as a whole") };
        let mut next = first;
        self.n_groups = 0;
        while next < end && self.n_groups < BATCHES_PER_STAGE / N {
            let kick = match kicks {
                GroupKicks::Same(kick) => Some(kick),
                GroupKicks::Each(kick) => kick(next),
            };
            if let Some(kick) = kick {
                self.groups[self.n_groups] = (next, kick);
                self.n_groups += 1;
            }
            next += 1;
        }
        next
    }
}

impl<const D: usize> ElementBatches<D> {
    /// Sweeps over the groups of a run that have a kick.
    ///
    /// Accumulates Σ length · f and Σ κ at the nodes of the block. Writes κ of each slot, the response of each group
    /// and the history variables of its elements, indexed from the first group of the run.
    ///
    /// # Panics
    /// Unless D is 2 or 3.
    pub fn sweep(&self, level: Level, input: SweepInput<'_>, cache: &mut NodeCache, output: SweepOutput<'_>) {
        // Not generic: the kernels are compiled here once and not in every dependent crate.
        let lanes: &dyn Any = self;
        if let Some(lanes) = lanes.downcast_ref() {
            sweep_plane(lanes, level, input, cache, output);
        } else {
            sweep_space(
                lanes.downcast_ref().expect("the gel has two or three dimensions"),
                level,
                input,
                cache,
                output,
            );
        }
    }

    /// Dispatches on the material, for patches of one or `N` elements.
    #[inline(always)]
    fn sweep_by_law<const N: usize>(
        &self,
        level: Level,
        input: SweepInput<'_>,
        cache: &mut NodeCache,
        output: SweepOutput<'_>,
    ) {
        match self.law() {
            BatchLaw::NeoHookean(gel, rest) => self.sweep_by_depth::<N, _>(level, gel, rest, input, cache, output),
            BatchLaw::TwoNetwork(gel, rest) => self.sweep_by_depth::<N, _>(level, gel, rest, input, cache, output),
        }
    }

    /// Dispatches on the vector unit and the patch depth.
    fn sweep_by_depth<const N: usize, G: ElementLaw<D>>(
        &self,
        level: Level,
        gel: &G,
        rest: &[G::Rest<LaneArray>],
        input: SweepInput<'_>,
        cache: &mut NodeCache,
        output: SweepOutput<'_>,
    ) {
        if self.depth() == 1 {
            on!(level, simd => self.sweep_groups::<1, _, _>(simd, gel, rest, input, cache, output));
        } else {
            on!(level, simd => self.sweep_groups::<N, _, _>(simd, gel, rest, input, cache, output));
        }
    }

    /// Runs all stages for the groups of a run.
    #[inline(always)]
    fn sweep_groups<const N: usize, G: ElementLaw<D>, S: Simd>(
        &self,
        simd: S,
        gel: &G,
        rest: &[G::Rest<LaneArray>],
        input: SweepInput<'_>,
        cache: &mut NodeCache,
        output: SweepOutput<'_>,
    ) {
        // Loops, here and below: a closure is not compiled for the vector unit of its caller.
        let (groups, kicks, power) = input;
        let (stiffness, answers, memory) = output;
        let (mut next, rows) = (groups.start, N * gel.rows());
        let mut nodes = cache.access();
        // Local copies, which no other write can alias.
        let (gel, mut dissipation) = (&{ *gel }, Dissipation::default());
        let mut pipeline = Pipeline::new(f64x8::splat(simd, 0.0));
        while next < groups.end {
            next = pipeline.fill::<N>(next, groups.end, kicks);
            self.strain_groups::<N, G, S>(rest, nodes.motion[0], &mut pipeline);
            self.evaluate_pressures::<N, G, S>(gel, &mut pipeline);
            for g in 0..pipeline.n_groups {
                let at = pipeline.groups[g].0 - groups.start;
                let stiffness = &mut stiffness[at * LANES * N..][..LANES * N];
                let memory = &mut memory[at * rows..][..rows];
                let mut output = GroupOutput { power, stiffness, memory };
                let (answer, lost) = self.evaluate_forces::<N, G, S>(gel, rest, &pipeline, g, &mut nodes, &mut output);
                answers[at] = answer;
                dissipation += lost;
            }
        }
        cache.spent = dissipation;
    }

    /// First stage: the deformation gradient and J of every element.
    #[inline(always)]
    fn strain_groups<const N: usize, G: ElementLaw<D>, S: Simd>(
        &self,
        rest: &[G::Rest<LaneArray>],
        positions: &NodeRows,
        pipeline: &mut Pipeline<D, f64x8<S>>,
    ) {
        for g in 0..pipeline.n_groups {
            let group = pipeline.groups[g].0;
            let (batches, rest) = (self.batches_of::<N>(group), rest_of_group::<N, _>(rest, group));
            let strains = &mut pipeline.strains[g * N..][..N];
            pipeline.strained[g] = self.strain_group::<N, G, S>(group, batches, rest, positions, strains);
        }
    }

    /// Second stage: J̄ of every patch and the pressures U′.
    #[inline(always)]
    fn evaluate_pressures<const N: usize, G: ElementLaw<D>, S: Simd>(
        &self,
        gel: &G,
        pipeline: &mut Pipeline<D, f64x8<S>>,
    ) {
        for g in 0..pipeline.n_groups {
            let (batches, at) = (self.batches_of::<N>(pipeline.groups[g].0), g * N..(g + 1) * N);
            let (strains, slopes) = (&pipeline.strains[at.clone()], &mut pipeline.slopes[at]);
            let mut volumes = [pipeline.energy[g]; N];
            for k in 0..N {
                volumes[k] = load_lanes(pipeline.energy[g].simd, &batches[k].volume);
            }
            let ratios = self.ratios_of::<N, S>(pipeline.energy[g].simd, pipeline.groups[g].0);
            let layered = ratios.as_ref().map(<[_; N]>::as_slice);
            pipeline.energy[g] = evaluate_volumetric(gel, &volumes, strains, slopes, layered);
        }
    }

    /// Third stage: forces, stiffness bounds, energy and dissipation of the g-th group in the pipeline.
    #[inline(always)]
    fn evaluate_forces<const N: usize, G: ElementLaw<D>, S: Simd>(
        &self,
        gel: &G,
        rest: &[G::Rest<LaneArray>],
        pipeline: &Pipeline<D, f64x8<S>>,
        g: usize,
        nodes: &mut NodeAccess<'_>,
        output: &mut GroupOutput<'_>,
    ) -> (GroupResponse, Dissipation) {
        let ((group, kick), strained, mut energy) = (pipeline.groups[g], pipeline.strained[g], pipeline.energy[g]);
        let (batches, rest) = (self.batches_of::<N>(group), rest_of_group::<N, _>(rest, group));
        let (simd, rows) = (energy.simd, gel.rows());
        let zero = f64x8::splat(simd, 0.0);
        let (mut power, mut lost) = (zero, [zero; 3]);
        let mut answer = GroupResponse { least_jacobian: f64::INFINITY, ..GroupResponse::default() };
        let ratios = self.ratios_of::<N, S>(simd, group);
        for k in 0..N {
            let (strains, slopes) = (&pipeline.strains[g * N + k], &pipeline.slopes[g * N + k]);
            let history = &mut output.memory[k * rows..(k + 1) * rows];
            let volume = load_lanes(simd, &batches[k].volume);
            let scale = load_lanes(simd, &batches[k].scale);
            let input = LawInput { volume, scale, rest: &rest[k], kick, history };
            let ratios = ratios.as_ref().map(|ratios| &ratios[k]);
            let forces = evaluate_elements(gel, self.section(), input, strains, slopes, ratios);
            let (jacobian, volumetric_stiffness) = (strains.jacobian(), volume * slopes.curvature);
            if may_invert::<D, S>(
                forces.stiffness,
                volumetric_stiffness,
                jacobian,
                kick.elapsed,
                nodes.max_squared_speed,
            ) {
                answer.closing = answer.closing.max(max_lane(self.closing_rate(jacobian, &batches[k], nodes.motion)));
            }
            energy = forces.energy.multiply_add(strained, energy);
            for i in 0..3 {
                lost[i] += forces.lost[i];
            }
            if output.power == ReportPower::Told {
                let velocities = gather::<D, S>(simd, &batches[k].nodes, nodes.motion[1]);
                power = forces.power(&velocities).multiply_add(strained, power);
            }
            scatter::<D, S>(&batches[k].nodes, &forces.nodal_kicks(strained * kick.length), nodes.accumulated);
            forces.stiffness.store_slice(&mut output.stiffness[k * LANES..(k + 1) * LANES]);
            record_jacobian(&mut answer, k, jacobian);
        }
        (answer.energy, answer.power) = (sum_lanes(energy), sum_lanes(power));
        let [viscous, bulk, damage] = [sum_lanes(lost[0]), sum_lanes(lost[1]), sum_lanes(lost[2])];
        (answer, Dissipation { energy: answer.energy, viscous, bulk, damage })
    }

    /// Returns the closing rates of eight elements at their J, 1/s.
    #[inline(always)]
    fn closing_rate<S: Simd>(
        &self,
        jacobian: f64x8<S>,
        batch: &ElementBatch,
        [positions, velocities]: [&NodeRows; 2],
    ) -> f64x8<S> {
        let simd = jacobian.simd;
        let x = gather::<D, S>(simd, &batch.nodes, positions);
        let v = gather::<D, S>(simd, &batch.nodes, velocities);
        let zero = f64x8::splat(simd, 0.0);
        let (mut edges, mut rates) = ([[zero; D]; D], [[zero; D]; D]);
        for i in 0..D {
            for a in 0..D {
                (edges[i][a], rates[i][a]) = (x[a + 1][i] - x[0][i], v[a + 1][i] - v[0][i]);
            }
        }
        let radial = RadialSums { radii: x[0][0] + x[1][0] + x[2][0], rates: v[0][0] + v[1][0] + v[2][0] };
        let ring = if self.section() == Section::Axisymmetric { Some(radial) } else { None };
        closing_rate(jacobian, &edges, &rates, ring)
    }
}

/// Returns the rest data of the batches of a group.
#[inline(always)]
fn rest_of_group<const N: usize, R>(rest: &[R], group: usize) -> &[R; N] {
    rest[group * N..].first_chunk().expect("a group is whole")
}

#[inline(never)]
fn sweep_plane(
    lanes: &ElementBatches<2>,
    level: Level,
    input: SweepInput<'_>,
    cache: &mut NodeCache,
    output: SweepOutput<'_>,
) {
    lanes.sweep_by_law::<{ max_patch_size(2) }>(level, input, cache, output);
}

#[inline(never)]
fn sweep_space(
    lanes: &ElementBatches<3>,
    level: Level,
    input: SweepInput<'_>,
    cache: &mut NodeCache,
    output: SweepOutput<'_>,
) {
    lanes.sweep_by_law::<{ max_patch_size(3) }>(level, input, cache, output);
}

/// Returns true if one of eight elements may reach the margin [`TURNED`] within [`FORESEEN`] steps of `step`, s.
///
/// Arguments are κ, N/m, w U″, J, and the greatest |v|² of the nodes, m²/s²; the bound follows from
/// |J′| ≤ (Σ |∂J/∂x_a|² Σ |v_a|²)^½ and κ ≥ w U″ Σ |∂J/∂x_a|². The step is 0, and the check always done, on a new mesh.
#[inline(always)]
fn may_invert<const D: usize, S: Simd>(
    stiffness: f64x8<S>,
    volumetric_stiffness: f64x8<S>,
    jacobian: f64x8<S>,
    step: f64,
    max_squared_speed: f64,
) -> bool {
    let within = FORESEEN * step;
    let most = (D + 1) as f64 * max_squared_speed * within * within * ROUNDING;
    let from = jacobian + TURNED;
    step == 0.0 || (stiffness * most - volumetric_stiffness * from * from).any_positive()
}

/// Returns the greatest lane.
#[inline(always)]
fn max_lane<S: Simd>(eight: f64x8<S>) -> f64 {
    let (low, high) = eight.split();
    let (low, high) = low.max(high).split();
    let [a, b] = low.max(high).into();
    if a > b { a } else { b }
}

/// Records the least J and the inverted and crushed elements of the k-th batch.
#[inline(always)]
fn record_jacobian<S: Simd>(answer: &mut GroupResponse, k: usize, jacobian: f64x8<S>) {
    let simd = jacobian.simd;
    let inverted = simd.to_bitmask_mask64x8(jacobian.simd_le(f64x8::splat(simd, 0.0))) as u32;
    let crushed = simd.to_bitmask_mask64x8(jacobian.simd_lt(f64x8::splat(simd, NeoHookean::FLOOR)));
    let least = -max_lane(-jacobian);
    answer.least_jacobian = if least < answer.least_jacobian { least } else { answer.least_jacobian };
    answer.inverted |= inverted << (k * LANES);
    answer.crushed += crushed.count_ones();
}
