//! Handover between meshes: the end of one mesh and the beginning of the next, at one tick (numerics A12).

use super::distortion::DistortionLimits;
use super::engine::{BalanceReference, Engine, UnusableStep};
use super::exit::ExitRule;
use super::step_size::nodal_limit;
use super::substep::MeshPhase;
use super::{DiscreteGel, StepError, SteppingSchedule, TickGrid, WorkerPool};
use crate::contact::{BodyState, ImpulseExchange, RigidBody};
use crate::fem::{HistoryVariables, Potential};
use crate::ledger::Ledger;
use crate::math::{Vector, Vector3, embed};
use crate::mesh::{ElementId, NodeId};
use crate::state::{MOST_TICKS, MeshInstance, RunRecord, SurfaceStretch, Tick};
use std::sync::Arc;

/// Least age of a mesh, in its finest steps, unless a step collapses (A12).
const MIN_AGE: Tick = 4;

/// Data that one mesh hands over to the next.
pub(super) struct Carryover<const D: usize> {
    pub tick: Tick,
    pub grid: Option<TickGrid>,
    pub ledger: Ledger,
    pub record: RunRecord,
    pub start: Option<BalanceReference>,
    /// History variables of the elements, unless they are fresh.
    pub memory: Option<Vec<HistoryVariables<D>>>,
    /// Stable steps of the elements of the new mesh, s, if they are known.
    pub steps: Option<Vec<f64>>,
}

impl<const D: usize> Carryover<D> {
    /// Creates the empty handover to the first mesh.
    pub fn begin(n_bodies: usize) -> Self {
        Self {
            tick: 0,
            grid: None,
            ledger: Ledger::default(),
            record: RunRecord::new(n_bodies),
            start: None,
            memory: None,
            steps: None,
        }
    }
}

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Returns the last tick that was processed.
    #[must_use]
    pub fn last_tick(&self) -> Tick {
        self.state.now.unwrap_or(self.origin)
    }

    /// Returns the failure at the last tick of an ended mesh, if any; the run ends with it unless another mesh
    /// follows.
    #[must_use]
    pub fn failure(&self) -> Option<&StepError> {
        self.failure.as_ref()
    }

    /// Returns the time of the last tick, s.
    #[must_use]
    pub fn now(&self) -> f64 {
        self.grid.time(self.last_tick())
    }

    /// Sets the distortion limits of the mesh, if any. The queue ignores them.
    pub fn set_distortion_limits(&mut self, wear: Option<DistortionLimits>) {
        self.ends.wear = wear;
        self.watch.clear_parts();
    }

    /// Returns true if the mesh can end by distortion.
    pub(super) fn can_be_distorted(&self) -> bool {
        self.ends.wear.is_some() && self.rules.schedule != SteppingSchedule::Queue
    }

    /// Sets the times, s, ascending, at which the mesh ends, distorted or not. It ends at the first tick from a time
    /// on at which all steps end and the mesh is 4 of its finest steps old. The queue ignores the times.
    pub fn set_remesh_times(&mut self, times: &[f64]) {
        self.ends.at = times.iter().map(|time| self.grid.first_tick(*time)).collect();
    }

    /// Returns the next tick at or after which this mesh ends.
    pub(super) fn next_remesh_tick(&self) -> Option<Tick> {
        self.ends.at.iter().copied().find(|due| *due > self.origin)
    }

    /// Returns true if the mesh ends at this tick: at once if distorted, but on time only where all steps end, to cut
    /// no step short.
    pub(super) fn is_over(&mut self, tick: Tick) -> bool {
        if self.state.now.is_none() || self.rules.schedule == SteppingSchedule::Queue {
            return false;
        }
        let age = (tick - self.origin) / self.steps.0;
        let is_due = || self.next_remesh_tick().is_some_and(|due| due <= tick);
        let is_whole = self.rules.schedule.fires(self.steps.1, tick);
        age >= MIN_AGE && (is_whole && is_due() || self.is_distorted(tick, age))
            || self.has_collapsed()
            || self.has_leaked()
    }

    /// Returns the step collapse or leak that has ended a young mesh: the next one would fare no better. Age counts
    /// the finest step at its start.
    #[must_use]
    pub fn early_failure(&self) -> Option<&StepError> {
        let is_young = ((self.last_tick() - self.origin) as f64) < MIN_AGE as f64 * self.first.0;
        let ends_at_once =
            |failure: &&StepError| matches!(failure, StepError::StepCollapsed { .. } | StepError::Leak { .. });
        self.failure.as_ref().filter(|failure| is_young && ends_at_once(failure))
    }

    /// Returns true if the surface leaked at the last tick.
    fn has_leaked(&self) -> bool {
        self.can_be_distorted() && self.state.record.stretch == SurfaceStretch::Leaking
    }

    /// Returns true if the stable step of a group is shorter than a tick, by the stiffness at the last ticks of its
    /// nodes. It tests element by element before a tick; [`Self::find_collapse`] tests block by block after the
    /// sweep. Roundings may differ between the two, and either ends the mesh.
    fn has_collapsed(&self) -> bool {
        let known = (self.state.stiffness.as_slice(), &*self.order);
        let is_short = |node: &NodeId| self.grid.ticks(self.rules.cfl * nodal_limit(&self.gel, known, *node)) < 1.0;
        let mut elements = self.finest_groups().flat_map(|group| self.order.elements(self.order.slots(group)));
        self.can_be_distorted() && elements.any(|element| self.gel.potential.nodes(element).iter().any(is_short))
    }

    /// Finds the first group whose stable step is shorter than a tick.
    fn find_collapse(&self, tick: Tick) -> Option<StepError> {
        let mut limits = self.finest_groups().map(|group| (group, self.group_limit(group)));
        let collapsed = limits.find(|(_, limit)| *limit < 1.0).filter(|_| self.can_be_distorted());
        collapsed.map(|(group, limit)| self.collapse_error(group, limit, tick))
    }

    /// Iterates over the stiffest elements around the nodes whose stable step is shorter than a tick.
    pub fn stepless(&self) -> impl Iterator<Item = ElementId> + '_ {
        let known = (self.state.stiffness.as_slice(), &*self.order);
        let is_short =
            move |node: &NodeId| self.grid.ticks(self.rules.cfl * nodal_limit(&self.gel, known, *node)) < 1.0;
        let stiffness = |element: &ElementId| self.state.stiffness[self.order.slot(*element)];
        let stiffest = move |node: NodeId| {
            self.gel.star.of(node).iter().copied().max_by(|a, b| stiffness(a).total_cmp(&stiffness(b)))
        };
        (0..self.gel.mass.len() as u32).map(NodeId).filter(is_short).filter_map(stiffest)
    }

    /// Returns the positions of the corners of the first such element, m.
    fn stepless_corners(&self) -> Vec<Vector3> {
        let nodes = self.stepless().next().map_or(&[][..], |element| self.gel.potential.nodes(element));
        nodes.iter().map(|node| embed(&self.state.position[node.index()])).collect()
    }

    /// Iterates over the groups with a step of one tick, the shortest possible step.
    fn finest_groups(&self) -> impl Iterator<Item = usize> + '_ {
        let least = if self.steps.0 == 1 { self.state.clocks.as_slice() } else { &[] };
        least.iter().enumerate().filter(|(_, clock)| clock.step == 1).map(|(group, _)| group)
    }

    /// Processes the last tick of this mesh: every group is active with the trailing half of its kick, and nodes on a
    /// body are held there. Otherwise they would enter the body with half a kick, gain that energy, and lose it in
    /// contact at the next tick.
    pub(super) fn close(&mut self, tick: Tick, (t, exchanges): (f64, &mut [ImpulseExchange])) -> Result<(), StepError> {
        let time = self.grid.time(tick);
        self.phase = MeshPhase::Last;
        self.answer(tick);
        self.failure = self.find_failure(time);
        if let Some(error @ StepError::NotFinite { .. }) = &self.failure {
            let error = error.clone();
            self.drift_active(tick);
            self.state.now = Some(tick);
            return Err(error);
        }
        self.find_loads(tick);
        self.place_bodies(time);
        self.scratch.changed.clear();
        let sums = if self.blocks.is_some() { self.update_nodes(tick) } else { self.measure_limits() };
        self.count_global_steps(sums.limit, tick);
        self.failure = self.failure.take().or_else(|| self.find_collapse(tick));
        self.query_gaps(tick);
        self.find_contact_points(tick);
        let work = self.complete_kicks(tick, &sums);
        self.post_residual(tick, work);
        self.post_contact_work();
        self.receive(time, (t, exchanges));
        self.failure = self.failure.take().or_else(|| self.find_stretch(time).leak);
        let length = self.state.record.synchronous.0;
        self.state.record.synchronous = (length, tick, self.synchronous_until(tick as f64));
        self.state.now = Some(tick);
        Ok(())
    }

    /// Creates an engine that continues with another gel from the end of this one, with its nodes at these positions
    /// and velocities. The changes of energy, momentum and angular momentum are booked. `birth` is the new mesh and
    /// is given the steps with which it begins.
    ///
    /// # Errors
    /// [`UnusableStep`] if a step of the new mesh is no valid step; this engine then keeps all its data.
    pub fn continue_on_mesh(
        &mut self,
        (gel, memory): (DiscreteGel<D, P>, Option<Vec<HistoryVariables<D>>>),
        nodes: Vec<(Vector<D>, Vector<D>)>,
        birth: Option<MeshInstance<D>>,
    ) -> Result<Self, UnusableStep> {
        // Steps with the history variables: elements that have flowed far are none the stiffer for it.
        let (mut new, steps) = self.new_engine(gel, memory, nodes, self.last_tick(), None)?;
        let (was, now) = (
            BalanceReference::of(&self.gel, &self.bodies, &self.state),
            BalanceReference::of(&new.gel, &new.bodies, &new.state),
        );
        let ledger = &mut new.state.ledger;
        ledger.energy.remesh += now.energy - was.energy;
        ledger.momentum.remesh += now.momentum - was.momentum;
        ledger.angular_momentum.remesh += now.angular_momentum - was.angular_momentum;
        new.state.birth = birth.map(|birth| Arc::new(MeshInstance { steps, ..birth }));
        new.pool = self.pool.take();
        Ok(new)
    }

    /// Creates an engine on a mesh of this run, past or future, into which a state of that mesh is to be restored;
    /// without threads. `birth` is the mesh, unless it is the first one.
    ///
    /// # Errors
    /// [`UnusableStep`] as [`Self::continue_on_mesh`].
    pub fn engine_on_mesh(
        &self,
        gel: DiscreteGel<D, P>,
        position: &[Vector<D>],
        birth: Option<Arc<MeshInstance<D>>>,
    ) -> Result<Self, UnusableStep> {
        let nodes = position.iter().map(|x| (*x, Vector::<D>::zeros())).collect();
        // The history variables of the new mesh are lost, apart from the steps that followed from them.
        let (tick, steps) = birth.as_ref().map_or((0, None), |birth| (birth.tick, Some(birth.steps.clone())));
        let (mut other, _) = self.new_engine(gel, None, nodes, tick, steps)?;
        other.state.birth = birth;
        Ok(other)
    }

    /// Counts a remesh.
    pub fn count_remesh(&mut self) {
        self.state.record.stretch = SurfaceStretch::Little;
        self.state.record.remeshes += 1;
    }

    /// Counts eroded mass, kg.
    pub fn count_eroded_mass(&mut self, mass: f64) {
        self.state.record.eroded_mass += mass;
    }

    /// Takes the thread pool out, for another engine.
    pub fn take_pool(&mut self) -> Option<Arc<WorkerPool>> {
        self.pool.take()
    }

    /// Creates an engine with another gel from `tick` on; also returns the stable steps of its elements, s.
    fn new_engine(
        &self,
        gel: DiscreteGel<D, P>,
        memory: Option<Vec<HistoryVariables<D>>>,
        nodes: Vec<(Vector<D>, Vector<D>)>,
        tick: Tick,
        steps: Option<Vec<f64>>,
    ) -> Result<(Self, Vec<f64>), UnusableStep> {
        let bodies: Vec<(RigidBody, BodyState)> =
            self.bodies.iter().cloned().zip(self.state.bodies.iter().copied()).collect();
        let passage = Carryover {
            tick,
            grid: Some(self.grid),
            ledger: self.state.ledger,
            record: self.state.record.clone(),
            start: Some(*self.start()),
            memory,
            steps,
        };
        let (mut new, steps) = Self::assemble((gel, self.rules), bodies, nodes, passage)?;
        new.ends.clone_from(&self.ends);
        if self.blocks.is_none() {
            new = new.with_reference_form();
        }
        if let (Some(new), Some(old)) = (&mut new.blocks, &self.blocks) {
            (new.level, new.never_rest) = (old.level, old.never_rest);
        }
        let (least, most) = new.first;
        if least < 1.0 {
            return Err(UnusableStep { step: new.grid.length(least), corners: new.stepless_corners() });
        }
        if most > MOST_TICKS as f64 {
            return Err(UnusableStep { step: new.grid.length(most), corners: vec![] });
        }
        Ok((new, steps))
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_cube;
    use super::*;

    #[test]
    fn a_mesh_with_invalid_stable_steps_is_refused() {
        let mesh = test_cube::mesh(&[0.0, 0.5, 1.0]);
        let engine = test_cube::engine(test_cube::gel(&mesh));
        let tick = engine.grid.length(1.0);
        let begins = |first: f64| {
            let mut steps = vec![1024.0 * tick; mesh.elements.len()];
            steps[0] = first;
            let (mass, corner_mass) = (engine.gel.mass.clone(), vec![[1.0; 4]; mesh.elements.len()]);
            let (mesh, position) = (mesh.clone(), mesh.rest.clone());
            let birth = MeshInstance { tick: 7, mesh, position, mass, corner_mass, references: vec![], steps };
            let gel = test_cube::gel(&birth.mesh);
            engine.engine_on_mesh(gel, &birth.position.clone(), Some(Arc::new(birth))).map(|other| other.origin)
        };
        assert_eq!(begins(tick).ok(), Some(7));
        for forged in [0.9 * tick, 1e-300, 1e300] {
            let found = begins(forged).expect_err("a step of no run");
            assert!((found.step / forged - 1.0).abs() < 1e-12, "{forged}: {found:?}");
        }
    }
}
