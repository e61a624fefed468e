//! The three-phase tick: drift the nodes that fire, kick them by their patches, then one contact solve (numerics 1.6).

use super::impact::Touch;
use super::schedule::{Calendar, Kind};
use super::{Gel, Pool, StepError, TickGrid};
use crate::algebra::{Vector, embed};
use crate::contact::{Body, BodyState, Exchange, Law};
use crate::element::{Evaluation, Potential};
use crate::geometry::Gap;
use crate::ledger::Ledger;
use crate::mesh::{ElementId, NodeId};
use crate::state::{Clock, Record, State, Tick};
use std::sync::Arc;

/// How the engine steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Which patches step together.
    pub schedule: Kind,
    /// Fraction of the stable step that a patch takes.
    pub cfl: f64,
    /// Impulse law.
    pub law: Law,
    /// Width of the window of the peak force, s.
    pub force_window: f64,
}

/// A gel and a rigid body in time.
#[derive(Debug)]
pub struct Engine<const D: usize, P> {
    pub(super) gel: Arc<Gel<D, P>>,
    pub(super) body: Body,
    pub(super) rules: Rules,
    pub(super) grid: TickGrid,
    pub(super) state: State<D>,
    pub(super) scratch: Scratch<D>,
    pool: Option<Pool>,
    calendar: Calendar,
    now: Option<Tick>,
    rotation: Tick,
    start: Start,
}

/// What the books are balanced against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Start {
    pub energy: f64,
    pub momentum: crate::algebra::Vector3,
    pub angular_momentum: crate::algebra::Vector3,
    /// Σ m|v| and Σ |x × mv|, scales of momentum and angular momentum.
    pub scale: (f64, f64),
}

/// What one tick works with; nothing in it outlives the tick.
#[derive(Debug, Default)]
pub(super) struct Scratch<const D: usize> {
    /// Nodes of the patches that fire.
    pub active: Vec<NodeId>,
    /// The last event a node was active in, by node.
    stamp: Vec<u64>,
    event: u64,
    /// v at the start of the tick, by node.
    pub before: Vec<Vector<D>>,
    /// 2/√λ_a, s, by node.
    pub limit: Vec<f64>,
    /// φ and n at this tick, by surface node.
    pub gaps: Vec<Option<Gap>>,
    /// Forces on the nodes of the firing patches, `stride` each.
    pub forces: Vec<Vector<D>>,
    /// What the firing patches answered.
    pub answers: Vec<Evaluation>,
    /// Length of the kick of the firing patches, s.
    pub weights: Vec<f64>,
    /// Nodes within reach of the body.
    pub touches: Vec<Touch<D>>,
}

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// A gel at the given positions and velocities, and a body, at time 0.
    ///
    /// # Panics
    /// If the gel has no patches or their stiffness is not positive.
    #[must_use]
    pub fn new(
        gel: Gel<D, P>,
        (body, at): (Body, BodyState),
        rules: Rules,
        nodes: Vec<(Vector<D>, Vector<D>)>,
    ) -> Self {
        let (position, velocity): (Vec<_>, Vec<_>) = nodes.into_iter().unzip();
        let clocks: Vec<Clock> = (0..gel.potential.len())
            .map(|p| {
                let mut forces = [Vector::<D>::zeros(); crate::element::MAX_NODES];
                let at_rest =
                    gel.potential.evaluate(ElementId(p as u32), &position, &mut forces[..gel.potential.stride()]);
                Clock {
                    stiffness: at_rest.stiffness,
                    energy: at_rest.energy,
                    jacobian: at_rest.jacobian,
                    ..Clock::default()
                }
            })
            .collect();
        let tick = vec![0; position.len()];
        let (ledger, record) = (Ledger::default(), Record::default());
        let state = State { position, velocity, tick, clocks, body: at, ledger, record };
        let steps = super::pace::stable_steps(&gel, &state.clocks, rules.cfl);
        let grid = TickGrid::new(&steps);
        let smallest = steps.iter().copied().fold(f64::INFINITY, f64::min);
        let rotation = super::grid::floor_power_of_two(grid.ticks(smallest)) as Tick;
        let start = Start::of(&gel, &body, &state);
        let calendar = Calendar::new(rules.schedule, &state.clocks);
        let scratch = Scratch::new(state.position.len(), gel.surface.nodes.len());
        let gel = Arc::new(gel);
        Self { gel, body, rules, grid, state, scratch, pool: None, calendar, now: None, rotation, start }
    }

    /// Lets the element phase use these threads; results do not depend on it.
    #[must_use]
    pub fn with_pool(mut self, pool: Option<Pool>) -> Self {
        self.pool = pool;
        self
    }

    /// The state.
    #[must_use]
    pub fn state(&self) -> &State<D> {
        &self.state
    }

    /// The body: what does not change.
    #[must_use]
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// The gel: what does not change.
    #[must_use]
    pub fn gel(&self) -> &Gel<D, P> {
        &self.gel
    }

    /// The grid of ticks.
    #[must_use]
    pub fn grid(&self) -> &TickGrid {
        &self.grid
    }

    pub(super) fn start(&self) -> &Start {
        &self.start
    }

    /// Continues from another state of the same gel.
    ///
    /// # Panics
    /// If the state has other numbers of nodes or patches.
    pub fn restore(&mut self, state: State<D>) {
        assert_eq!(state.position.len(), self.state.position.len(), "a state belongs to its mesh");
        assert_eq!(state.clocks.len(), self.state.clocks.len(), "a state belongs to its mesh");
        self.calendar = Calendar::new(self.rules.schedule, &state.clocks);
        let begun = state.clocks.iter().any(|clock| clock.step > 0);
        self.now = begun.then(|| state.clocks.iter().map(|clock| clock.last).max().unwrap_or(0));
        self.state = state;
    }

    /// Replaces the body's state or wrench at its own time, an event; what changed is booked by the caller.
    pub fn set_body(&mut self, state: BodyState) {
        self.state.body = state;
    }

    /// The books, for what is done to the body from outside.
    pub fn ledger_mut(&mut self) -> &mut Ledger {
        &mut self.state.ledger
    }

    /// Moves the body to time `t` as an event and books what the wrench gave.
    pub fn rebase_body(&mut self, t: f64) {
        let next = self.state.body.at(&self.body, t);
        let passage = self.state.body.passage(&self.body, &next);
        let ledger = &mut self.state.ledger;
        ledger.energy.external += passage.work;
        ledger.energy.integration += passage.defect;
        ledger.momentum.external += passage.momentum;
        ledger.angular_momentum.external += passage.angular_momentum;
        self.state.body = next;
    }

    /// Processes all ticks up to time `t`, s, and adds what the body received to `exchange`.
    ///
    /// # Errors
    /// [`StepError`] when the mesh or the numbers fail.
    pub fn advance_to(&mut self, t: f64, exchange: &mut Exchange) -> Result<(), StepError> {
        let end = self.grid.last_tick(t);
        while let Some(tick) = self.next_event().filter(|tick| *tick <= end) {
            if self.rotation_is_due() == Some(tick) {
                self.rebase_body(self.grid.time(tick));
            }
            let due = self.calendar.take(tick).to_vec();
            if !due.is_empty() {
                self.tick(tick, &due, (t, exchange))?;
            }
            self.now = Some(tick);
        }
        Ok(())
    }

    fn next_event(&self) -> Option<Tick> {
        let patches = self.now.map_or(Some(0), |now| self.calendar.next(now));
        [patches, self.rotation_is_due()].into_iter().flatten().min()
    }

    /// The first tick of the rotation's own grid after the last event of a body that tumbles.
    fn rotation_is_due(&self) -> Option<Tick> {
        let tumbles = self.now.is_some() && self.body.tumbles(&self.state.body);
        let period = self.grid.time(self.rotation);
        tumbles.then(|| ((self.state.body.time / period).floor() as Tick + 1) * self.rotation)
    }

    fn tick(&mut self, tick: Tick, due: &[ElementId], (t, exchange): (f64, &mut Exchange)) -> Result<(), StepError> {
        let time = self.grid.time(tick);
        self.drift(tick, due);
        self.evaluate(due);
        self.check_elements(due, time)?;
        let body = self.state.body.at(&self.body, time);
        self.measure_gaps(&body);
        self.measure_limits(due, tick);
        self.check_steps(due, time)?;
        let was: Vec<Clock> = due.iter().map(|patch| self.state.clocks[patch.index()]).collect();
        self.set_clocks(due, tick, &body);
        self.find_touches(&body);
        let struck = self.kick_and_strike(due, &body);
        self.book(due, &was, tick);
        self.book_contact(&body, &struck);
        self.receive((&body, &struck), time, (t, exchange));
        self.reschedule(due, &was, tick);
        self.check_leaks(&body, time)
    }

    fn drift(&mut self, tick: Tick, due: &[ElementId]) {
        let scratch = &mut self.scratch;
        scratch.active.clear();
        scratch.event += 1;
        for node in due.iter().flat_map(|patch| self.gel.potential.nodes(*patch)) {
            if scratch.stamp[node.index()] == scratch.event {
                continue;
            }
            scratch.stamp[node.index()] = scratch.event;
            scratch.active.push(*node);
            let (a, velocity) = (node.index(), self.state.velocity[node.index()]);
            self.state.position[a] += velocity * self.grid.time(tick - self.state.tick[a]);
            self.state.tick[a] = tick;
            scratch.before[a] = velocity;
        }
    }

    fn evaluate(&mut self, due: &[ElementId]) {
        let (forces, answers) = (&mut self.scratch.forces, &mut self.scratch.answers);
        super::forces::evaluate(
            &self.gel.potential,
            (&self.state.position, due),
            (forces, answers),
            self.pool.as_ref(),
        );
    }

    /// An element that is inverted for the second tick in a row, or whose energy is not a number, ends the run before
    /// anything is changed.
    fn check_elements(&self, due: &[ElementId], time: f64) -> Result<(), StepError> {
        for (patch, answer) in due.iter().zip(&self.scratch.answers) {
            let element = patch.index();
            if !(answer.energy.is_finite() && answer.stiffness.is_finite()) {
                return Err(StepError::NotFinite { element, time });
            }
            if answer.jacobian <= 0.0 && self.state.clocks[element].inverted {
                return Err(StepError::Inverted { element, time, jacobian: answer.jacobian });
            }
        }
        Ok(())
    }

    fn reschedule(&mut self, due: &[ElementId], was: &[Clock], tick: Tick) {
        if tick == 0 {
            self.calendar = Calendar::new(self.rules.schedule, &self.state.clocks);
            return;
        }
        for (patch, was) in due.iter().zip(was) {
            self.calendar.put_back(*patch, was, &self.state.clocks[patch.index()]);
        }
    }

    /// Position of a node drifted to time `t`, m.
    #[must_use]
    pub fn position_at(&self, node: NodeId, t: f64) -> Vector<D> {
        let a = node.index();
        self.state.position[a] + self.state.velocity[a] * (t - self.grid.time(self.state.tick[a]))
    }

    /// World position and velocity of a node that is active at this tick.
    pub(super) fn world(&self, node: NodeId) -> (crate::algebra::Vector3, crate::algebra::Vector3) {
        (embed(&self.state.position[node.index()]), embed(&self.state.velocity[node.index()]))
    }
}

impl<const D: usize> Scratch<D> {
    fn new(n_nodes: usize, n_surface: usize) -> Self {
        Self {
            stamp: vec![0; n_nodes],
            before: vec![Vector::zeros(); n_nodes],
            limit: vec![0.0; n_nodes],
            gaps: vec![None; n_surface],
            ..Self::default()
        }
    }
}
