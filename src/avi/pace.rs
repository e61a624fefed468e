//! Which step a patch takes: the assembled nodal rule, the ratchet, and contact (numerics 1.3, 1.4, A7, A8).

use super::engine::Engine;
use super::{Gel, StepError};
use crate::algebra::Vector3;
use crate::element::Potential;
use crate::geometry::Gap;
use crate::mesh::{ElementId, NodeId};
use crate::state::{Clock, Tick};

/// A step may be raised when the limit is so many times longer …
const RAISE_MARGIN: f64 = 4.0;
/// … at so many own ticks in a row. Raising sooner pumps energy: per-update adaptation drifted by up to +18000 % in 400
/// wave transits, this rule by at most 1.2 % (numerics 1.4).
const RAISE_PATIENCE: u32 = 64;
/// A surface node may be found so deep at its next tick, in element sizes (numerics A7).
const DEPTH: f64 = 0.1;
/// Once deeper than that, it may go this much deeper, in element sizes.
const FURTHER: f64 = 0.05;
/// Probes along a path before what was proved so far is taken.
const PROBES: usize = 16;

/// CFL · min over the nodes a of each patch of 2/√λ_a, s, with λ_a = Σ_{K∋a} κ_K/m_a.
///
/// λ_a bounds the spectrum of the *assembled* system (1.3c): K = Σ K_K ≤ Σ κ_K 1_K = diag(λ_a m_a).
pub(super) fn stable_steps<const D: usize, P: Potential<D>>(gel: &Gel<D, P>, clocks: &[Clock], cfl: f64) -> Vec<f64> {
    let limits: Vec<f64> = (0..gel.mass.len()).map(|a| nodal_limit(gel, clocks, NodeId(a as u32))).collect();
    (0..clocks.len()).map(|p| cfl * patch_limit(gel, &limits, ElementId(p as u32))).collect()
}

/// 2/√λ_a, s, summed over the patches of the node in ascending order (A8).
fn nodal_limit<const D: usize, P: Potential<D>>(gel: &Gel<D, P>, clocks: &[Clock], node: NodeId) -> f64 {
    let stiffness: f64 = gel.star.of(node).iter().map(|patch| clocks[patch.index()].stiffness).sum();
    2.0 / (stiffness / gel.mass[node.index()]).sqrt()
}

fn patch_limit<const D: usize, P: Potential<D>>(gel: &Gel<D, P>, limits: &[f64], patch: ElementId) -> f64 {
    gel.potential.nodes(patch).iter().map(|node| limits[node.index()]).fold(f64::INFINITY, f64::min)
}

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Stores κ of the firing patches and gathers 2/√λ_a of the active nodes afresh.
    pub(super) fn measure_limits(&mut self, due: &[ElementId], tick: Tick) {
        for (patch, answer) in due.iter().zip(&self.scratch.answers) {
            self.state.clocks[patch.index()].stiffness = answer.stiffness;
        }
        for node in &self.scratch.active {
            self.scratch.limit[node.index()] = nodal_limit(&self.gel, &self.state.clocks, *node);
        }
        let smallest = self.scratch.active.iter().map(|a| self.scratch.limit[a.index()]).fold(f64::INFINITY, f64::min);
        self.count_synchronous(self.grid.ticks(self.rules.cfl * smallest), tick);
    }

    /// One global stable step would be the smallest nodal limit seen so far; what it would have cost up to `tick`.
    fn count_synchronous(&mut self, limit: f64, tick: Tick) {
        let (length, counted, updates) = self.state.record.synchronous;
        if limit < length {
            let cost = (tick - counted) as f64 / length * self.gel.potential.len() as f64;
            self.state.record.synchronous = (limit, tick, updates + cost);
        }
    }

    fn limit_in_ticks(&self, patch: ElementId) -> f64 {
        self.grid.ticks(self.rules.cfl * patch_limit(&self.gel, &self.scratch.limit, patch))
    }

    /// A stable step of less than a tick is a thousandth of the smallest one at the start: the mesh has failed (A11).
    pub(super) fn check_steps(&self, due: &[ElementId], time: f64) -> Result<(), StepError> {
        for (patch, answer) in due.iter().zip(&self.scratch.answers) {
            let limit = self.limit_in_ticks(*patch);
            if limit < 1.0 {
                let step = limit * self.grid.time(1);
                return Err(StepError::StepCollapsed { element: patch.index(), time, step, jacobian: answer.jacobian });
            }
        }
        Ok(())
    }

    /// Chooses the next tick of each firing patch, in ascending order, and the length of its kick: half of the step
    /// behind and half of the step ahead.
    pub(super) fn set_clocks(&mut self, due: &[ElementId], tick: Tick) {
        self.scratch.weights.clear();
        for patch in due {
            let was = self.state.clocks[patch.index()];
            let (step, calm) = self.ratchet(*patch, &was, tick);
            let (step, near) = self.contact_step(*patch, step);
            let clock = &mut self.state.clocks[patch.index()];
            clock.step = step;
            clock.calm = if near { 0 } else { calm };
            clock.last = tick;
            // In the queue, patches near contact wait for the common multiples of their steps, so that they fire together.
            clock.next = if near { (tick / step + 1) * step } else { tick + step };
            self.scratch.weights.push(0.5 * self.grid.time(clock.next - was.last));
        }
    }

    /// Down at once; up, doubled, only when aligned and after a long calm.
    fn ratchet(&self, patch: ElementId, clock: &Clock, tick: Tick) -> (Tick, u32) {
        let limit = self.limit_in_ticks(patch);
        let allowed = self.rules.schedule.step(limit);
        if clock.step == 0 || allowed < clock.step {
            return (allowed, 0);
        }
        if limit < RAISE_MARGIN * clock.step as f64 {
            return (clock.step, 0);
        }
        let calm = clock.calm.saturating_add(1);
        let aligned = self.rules.schedule == super::Kind::Queue || tick.is_multiple_of(2 * clock.step);
        if calm >= RAISE_PATIENCE && aligned { (2 * clock.step, 0) } else { (clock.step, calm) }
    }

    /// The step with contact: no surface node may run deeper into a body than [`DEPTH`] allows, and patches within an
    /// element's size of a body take the shortest step around. Also whether the patch is that near.
    fn contact_step(&self, patch: ElementId, step: Tick) -> (Tick, bool) {
        let mut limit = step as f64;
        let mut near = false;
        for node in self.gel.potential.nodes(patch) {
            let Some(surface) = self.gel.surface.of[node.index()] else { continue };
            let size = self.gel.surface.nodes[surface as usize].size;
            for (body, gap) in self.gaps_of(surface).iter().enumerate() {
                let Some(gap) = gap else { continue };
                limit = limit.min(self.path_limit((*node, size), gap, (limit, body)));
                if gap.distance < size {
                    near = true;
                    limit = limit.min(self.shortest_around(*node));
                }
            }
        }
        let limit = limit.max(1.0);
        let kind = if near { super::Kind::Bins } else { self.rules.schedule };
        (if near || limit < step as f64 { kind.step(limit) } else { step }, near)
    }

    /// The shortest step among the patches of a node that have one, ticks.
    pub(super) fn shortest_around(&self, node: NodeId) -> f64 {
        let steps = self.gel.star.of(node).iter().map(|patch| self.state.clocks[patch.index()].step);
        steps.filter(|step| *step > 0).map(|step| step as f64).fold(f64::INFINITY, f64::min)
    }

    /// For how long the relative path of a node is proved to stay above the allowed depth, ticks; at most `horizon`.
    ///
    /// The node is taken to go straight on, the body to be accelerated by the wrench at most by a, and its surface to grow at
    /// most with w. φ is 1-Lipschitz: from the point of the straight path at s the way is free for
    /// (φ + allowed − ½as² − ws)/(|v| + as_end + w), as ½a(s + δ)² − ½as² ≤ as_end δ.
    fn path_limit(&self, (node, size): (NodeId, f64), gap: &Gap, (horizon, body): (f64, usize)) -> f64 {
        let (x, v) = self.world(node);
        let (fixed, body) = (&self.bodies[body], &self.scratch.was[body]);
        let relative: Vector3 = v - fixed.velocity_at(body, &x);
        let end = horizon * self.grid.time(1);
        let (growth, swelling) = body.bulge.map_or((0.0, 0.0), |bulge| (bulge.speed(), bulge.pull()));
        let pull = 0.5 * (body.wrench.force.norm() / fixed.mass + swelling);
        let speed = relative.norm() + 2.0 * pull * end + growth;
        let allowed = (DEPTH * size).max(FURTHER * size - gap.distance);
        let (mut proved, mut distance) = (0.0, gap.distance);
        for _ in 0..PROBES {
            let room = distance + allowed - (pull * proved + growth) * proved;
            if room <= 0.0 {
                break;
            }
            proved += room / speed;
            if proved >= end || speed == 0.0 {
                return horizon;
            }
            distance = fixed.gap(body, &(x + relative * proved)).distance;
        }
        self.grid.ticks(proved)
    }
}
