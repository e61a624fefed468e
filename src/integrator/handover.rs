//! The end of one mesh and the beginning of the next, at one tick (numerics A12).

use super::distortion::Wear;
use super::engine::{Engine, NoStep, Start};
use super::exit::ExitRule;
use super::step_size::nodal_limit;
use super::substep::Phase;
use super::{Gel, Kind, Pool, StepError, TickGrid};
use crate::contact::{Body, BodyState, Exchange};
use crate::fem::{Memory, Potential};
use crate::ledger::Ledger;
use crate::math::{Vector, Vector3, embed};
use crate::mesh::{ElementId, NodeId};
use crate::state::{Birth, MOST_TICKS, Record, Stretch, Tick};
use std::sync::Arc;

/// What ends a mesh.
#[derive(Debug, Clone, Default)]
pub(super) struct Ends {
    /// When it is worn; `None` if it never is.
    pub wear: Option<Wear>,
    /// Ticks at or after which it ends whether it is worn or not, ascending.
    at: Vec<Tick>,
    /// Rule of exits, which may end the integration of the gel; `None` where its shape has no back face.
    pub exits: Option<ExitRule>,
}

/// How far an engine has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reached {
    /// To the end that was asked for.
    End,
    /// To a tick at which its mesh is worn or due, and it has ended there: positions and velocities are those of this instant.
    Worn,
}

/// A mesh lasts at least so many of its finest steps unless a step collapses (A12).
const SHORTEST_LIFE: Tick = 4;

/// What goes on from one mesh to the next.
pub(super) struct Passage<const D: usize> {
    pub tick: Tick,
    pub grid: Option<TickGrid>,
    pub ledger: Ledger,
    pub record: Record,
    pub start: Option<Start>,
    /// What the elements remember, if not nothing.
    pub memory: Option<Vec<Memory<D>>>,
    /// Their stable steps when the mesh was new, s, if they are known.
    pub steps: Option<Vec<f64>>,
}

impl<const D: usize> Passage<D> {
    /// Nothing: the mesh is the first one.
    pub fn begin(n_bodies: usize) -> Self {
        Self {
            tick: 0,
            grid: None,
            ledger: Ledger::default(),
            record: Record::new(n_bodies),
            start: None,
            memory: None,
            steps: None,
        }
    }
}

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// The last tick that was processed.
    #[must_use]
    pub fn last_tick(&self) -> Tick {
        self.state.now.unwrap_or(self.origin)
    }

    /// What failed at the last tick of a mesh that has ended, if anything did: without another mesh the run ends with it.
    #[must_use]
    pub fn failure(&self) -> Option<&StepError> {
        self.failure.as_ref()
    }

    /// Its time, s.
    #[must_use]
    pub fn now(&self) -> f64 {
        self.grid.time(self.last_tick())
    }

    /// From when on the mesh is worn, if ever. A queue never is.
    pub fn set_wear(&mut self, wear: Option<Wear>) {
        self.ends.wear = wear;
        self.watch.forget_parts();
    }

    /// Whether the mesh can be worn at all.
    pub(super) fn can_wear(&self) -> bool {
        self.ends.wear.is_some() && self.rules.schedule != Kind::Queue
    }

    /// Times, s, at which the mesh ends whether it is worn or not, ascending: each at the first tick at or after it where all steps
    /// end, and where the mesh is 4 of the finest old. A queue knows none.
    pub fn set_exchanges(&mut self, times: &[f64]) {
        self.ends.at = times.iter().map(|time| self.grid.first_tick(*time)).collect();
    }

    /// The next tick at or after which this mesh ends.
    pub(super) fn next_exchange(&self) -> Option<Tick> {
        self.ends.at.iter().copied().find(|due| *due > self.origin)
    }

    /// Whether the mesh ends at this tick: at once if it is worn, but on time only where all steps end, so that none is cut short.
    pub(super) fn is_over(&mut self, tick: Tick) -> bool {
        if self.state.now.is_none() || self.rules.schedule == Kind::Queue {
            return false;
        }
        let age = (tick - self.origin) / self.steps.0;
        let is_due = || self.next_exchange().is_some_and(|due| due <= tick);
        let is_whole = self.rules.schedule.fires(self.steps.1, tick);
        age >= SHORTEST_LIFE && (is_whole && is_due() || self.is_worn(tick, age))
            || self.has_collapsed()
            || self.leaks()
    }

    /// A step of less than a tick, or a leak, that has ended a mesh so young that the next one would fare no better, by the finest step that
    /// it began with.
    #[must_use]
    pub fn early_failure(&self) -> Option<&StepError> {
        let is_young = ((self.last_tick() - self.origin) as f64) < SHORTEST_LIFE as f64 * self.first.0;
        let ends_at_once =
            |failure: &&StepError| matches!(failure, StepError::StepCollapsed { .. } | StepError::Leak { .. });
        self.failure.as_ref().filter(|failure| is_young && ends_at_once(failure))
    }

    /// Whether the surface leaked at the last tick.
    fn leaks(&self) -> bool {
        self.can_wear() && self.state.record.stretch == Stretch::Leaking
    }

    /// Whether the stable step of a group is shorter than a tick, by the stiffness that its nodes had at their last ticks: before a tick,
    /// element by element; [`Self::find_collapse`] has it after the sweep, block by block. Their roundings may differ by where they tell
    /// a tick apart, and either then ends the mesh.
    fn has_collapsed(&self) -> bool {
        let known = (self.state.stiffness.as_slice(), &*self.order);
        let is_short = |node: &NodeId| self.grid.ticks(self.rules.cfl * nodal_limit(&self.gel, known, *node)) < 1.0;
        let mut elements = self.finest_groups().flat_map(|group| self.order.elements(self.order.slots(group)));
        self.can_wear() && elements.any(|element| self.gel.potential.nodes(element).iter().any(is_short))
    }

    /// The first group whose stable step is shorter than a tick.
    fn find_collapse(&self, tick: Tick) -> Option<StepError> {
        let mut limits = self.finest_groups().map(|group| (group, self.group_limit(group)));
        let collapsed = limits.find(|(_, limit)| *limit < 1.0).filter(|_| self.can_wear());
        collapsed.map(|(group, limit)| self.collapse(group, limit, tick))
    }

    /// The stiffest element around each node whose stable step is shorter than a tick.
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

    /// Where the corners of the first of these are, m.
    fn stepless_corners(&self) -> Vec<Vector3> {
        let nodes = self.stepless().next().map_or(&[][..], |element| self.gel.potential.nodes(element));
        nodes.iter().map(|node| embed(&self.state.position[node.index()])).collect()
    }

    /// The groups whose step is a tick: no step is shorter, whatever is stable.
    fn finest_groups(&self) -> impl Iterator<Item = usize> + '_ {
        let least = if self.steps.0 == 1 { self.state.clocks.as_slice() } else { &[] };
        least.iter().enumerate().filter(|(_, clock)| clock.step == 1).map(|(group, _)| group)
    }

    /// The last tick of this mesh: every group fires, its kick that of half of the step behind, and what stands on a body is held
    /// there: without it such nodes would enter it with half a kick, gain that energy, and lose it in contact at the next tick.
    pub(super) fn close(&mut self, tick: Tick, (t, exchanges): (f64, &mut [Exchange])) -> Result<(), StepError> {
        let time = self.grid.time(tick);
        self.phase = Phase::Last;
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
        let sums = if self.blocks.is_some() { self.advance_nodes(tick) } else { self.measure_limits() };
        self.count_synchronous(sums.limit, tick);
        self.failure = self.failure.take().or_else(|| self.find_collapse(tick));
        self.look_around(tick);
        self.find_touches(tick);
        let work = self.kick_all(tick, &sums);
        self.book(tick, work);
        self.book_contact();
        self.receive(time, (t, exchanges));
        self.failure = self.failure.take().or_else(|| self.find_leak(time).1);
        let length = self.state.record.synchronous.0;
        self.state.record.synchronous = (length, tick, self.synchronous_until(tick as f64));
        self.state.now = Some(tick);
        Ok(())
    }

    /// An engine that goes on with another gel, its nodes at these positions and velocities, from where this one has ended; what
    /// energy, momentum and angular momentum change by is booked. `birth` is its mesh, and is told the steps with which it begins.
    ///
    /// # Errors
    /// [`NoStep`] if a step of the new mesh is none of a run; this engine keeps all it has then.
    pub fn renewed(
        &mut self,
        (gel, memory): (Gel<D, P>, Option<Vec<Memory<D>>>),
        nodes: Vec<(Vector<D>, Vector<D>)>,
        birth: Option<Birth<D>>,
    ) -> Result<Self, NoStep> {
        // With what elements remember: one that has flowed far is none the stiffer for it.
        let (mut new, steps) = self.followed((gel, memory), nodes, (self.last_tick(), None))?;
        let (was, now) =
            (Start::of(&self.gel, &self.bodies, &self.state), Start::of(&new.gel, &new.bodies, &new.state));
        let ledger = &mut new.state.ledger;
        ledger.energy.remesh += now.energy - was.energy;
        ledger.momentum.remesh += now.momentum - was.momentum;
        ledger.angular_momentum.remesh += now.angular_momentum - was.angular_momentum;
        new.state.birth = birth.map(|birth| Arc::new(Birth { steps, ..birth }));
        new.pool = self.pool.take();
        Ok(new)
    }

    /// An engine of a mesh that this run has, had or will have, made so for a state of it to be restored; without threads.
    /// `birth` is the mesh, unless it is that of the start.
    ///
    /// # Errors
    /// [`NoStep`] as [`Self::renewed`].
    pub fn on_mesh(
        &self,
        gel: Gel<D, P>,
        position: &[Vector<D>],
        birth: Option<Arc<Birth<D>>>,
    ) -> Result<Self, NoStep> {
        let nodes = position.iter().map(|x| (*x, Vector::<D>::zeros())).collect();
        // What its elements remembered when it was new nobody knows any more, but for the steps that this gave them.
        let began = birth.as_ref().map_or((0, None), |birth| (birth.tick, Some(birth.steps.clone())));
        let (mut other, _) = self.followed((gel, None), nodes, began)?;
        other.state.birth = birth;
        Ok(other)
    }

    /// Counts an exchange of the mesh.
    pub fn count_exchange(&mut self) {
        self.state.record.stretch = Stretch::Little;
        self.state.record.remeshes += 1;
    }

    /// Counts mass that has broken off, kg.
    pub fn count_drops(&mut self, mass: f64) {
        self.state.record.splashed += mass;
    }

    /// Its threads, for another engine.
    pub fn take_pool(&mut self) -> Option<Arc<Pool>> {
        self.pool.take()
    }

    fn followed(
        &self,
        (gel, memory): (Gel<D, P>, Option<Vec<Memory<D>>>),
        nodes: Vec<(Vector<D>, Vector<D>)>,
        (tick, steps): (Tick, Option<Vec<f64>>),
    ) -> Result<(Self, Vec<f64>), NoStep> {
        let bodies: Vec<(Body, BodyState)> =
            self.bodies.iter().cloned().zip(self.state.bodies.iter().copied()).collect();
        let passage = Passage {
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
            new = new.by_reference();
        }
        if let (Some(new), Some(old)) = (&mut new.blocks, &self.blocks) {
            (new.level, new.never_rest) = (old.level, old.never_rest);
        }
        let (least, most) = new.first;
        if least < 1.0 {
            return Err(NoStep { step: new.grid.length(least), corners: new.stepless_corners() });
        }
        if most > MOST_TICKS as f64 {
            return Err(NoStep { step: new.grid.length(most), corners: vec![] });
        }
        Ok((new, steps))
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_cube;
    use super::*;

    #[test]
    fn a_mesh_that_begins_with_steps_of_no_run_is_refused() {
        let mesh = test_cube::mesh(&[0.0, 0.5, 1.0]);
        let engine = test_cube::engine(test_cube::gel(&mesh));
        let tick = engine.grid.length(1.0);
        let begins = |first: f64| {
            let mut steps = vec![1024.0 * tick; mesh.elements.len()];
            steps[0] = first;
            let (mass, corner_mass) = (engine.gel.mass.clone(), vec![[1.0; 4]; mesh.elements.len()]);
            let (mesh, position) = (mesh.clone(), mesh.rest.clone());
            let birth = Birth { tick: 7, mesh, position, mass, corner_mass, references: vec![], steps };
            let gel = test_cube::gel(&birth.mesh);
            engine.on_mesh(gel, &birth.position.clone(), Some(Arc::new(birth))).map(|other| other.origin)
        };
        assert_eq!(begins(tick).ok(), Some(7));
        for forged in [0.9 * tick, 1e-300, 1e300] {
            let found = begins(forged).expect_err("a step of no run");
            assert!((found.step / forged - 1.0).abs() < 1e-12, "{forged}: {found:?}");
        }
    }
}
