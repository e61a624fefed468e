//! The three-phase tick: drift the nodes that fire, kick them by their patches, then one contact solve (numerics 1.6).

use super::impact::Touch;
use super::schedule::{Calendar, Kind};
use super::{Gel, Pool, StepError, TickGrid};
use crate::algebra::{Vector, embed};
use crate::contact::{Body, BodyState, Exchange, Freedom, Law};
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

/// Angle that a tumbling body may turn by in one step of its orientation, rad: at 0.05 the axis of a rod that spins at
/// 20 000 rad/s and nods by 25° is off by 0.005° after a millisecond; at the steps of a coarse gel (1.2) it was 2.5°.
const TURN: f64 = 0.05;
/// Longest step of the orientation, ticks: a body under torque must not stay at its first angular velocity for ever.
const LONGEST_TURN: f64 = 4096.0;

/// A gel and rigid bodies in time.
#[derive(Debug)]
pub struct Engine<const D: usize, P> {
    pub(super) gel: Arc<Gel<D, P>>,
    pub(super) bodies: Vec<Body>,
    pub(super) rules: Rules,
    pub(super) grid: TickGrid,
    pub(super) state: State<D>,
    pub(super) scratch: Scratch<D>,
    pool: Option<Pool>,
    calendar: Calendar,
    now: Option<Tick>,
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

/// What one tick works with; no result depends on what an earlier one left.
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
    /// The surface nodes among them, ascending.
    pub reached: Vec<u32>,
    /// φ and n of those to each active body, by surface node and body.
    pub gaps: Vec<Option<Gap>>,
    /// The bodies at this tick before its impulses …
    pub was: Vec<BodyState>,
    /// … and with those so far.
    pub now: Vec<BodyState>,
    /// Forces on the nodes of the firing patches, `stride` each.
    pub forces: Vec<Vector<D>>,
    /// What the firing patches answered.
    pub answers: Vec<Evaluation>,
    /// Length of the kick of the firing patches, s.
    pub weights: Vec<f64>,
    /// Points of the surface inside a body.
    pub touches: Vec<Touch<D>>,
}

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// A gel at the given positions and velocities, and bodies, at time 0.
    ///
    /// # Panics
    /// If there is no body, or the gel has no patches or their stiffness is not positive.
    #[must_use]
    pub fn new(
        gel: Gel<D, P>,
        bodies: Vec<(Body, BodyState)>,
        rules: Rules,
        nodes: Vec<(Vector<D>, Vector<D>)>,
    ) -> Self {
        let (position, velocity): (Vec<_>, Vec<_>) = nodes.into_iter().unzip();
        let clocks = gel.clocks(&position);
        let tick = vec![0; position.len()];
        assert!(!bodies.is_empty(), "there is a body, if only one that touches nothing");
        let (bodies, at): (Vec<_>, Vec<_>) = bodies.into_iter().unzip();
        let (ledger, record) = (Ledger::default(), Record::new(bodies.len()));
        let state = State { position, velocity, tick, clocks, bodies: at, ledger, record };
        let steps = super::pace::stable_steps(&gel, &state.clocks, rules.cfl);
        let grid = TickGrid::new(&steps);
        let start = Start::of(&gel, &bodies, &state);
        let calendar = Calendar::new(rules.schedule, &state.clocks);
        let scratch = Scratch::new(state.position.len(), gel.surface.nodes.len() * bodies.len());
        let gel = Arc::new(gel);
        Self { gel, bodies, rules, grid, state, scratch, pool: None, calendar, now: None, start }
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

    /// The bodies: what does not change.
    #[must_use]
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// The directions that the dimension leaves to every body.
    pub(super) fn freedom(&self) -> Freedom {
        self.bodies[0].freedom
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

    /// Whether a state can be one of this engine.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self, state: &State<D>) -> Result<(), &'static str> {
        state.check_invariants((self.gel.mass.len(), self.gel.potential.len(), self.bodies.len()))?;
        let fits = |clock: &Clock| self.rules.schedule != Kind::Bins || clock.step == 0 || clock.step.is_power_of_two();
        if state.clocks.iter().all(fits) { Ok(()) } else { Err("a step is none of the bins") }
    }

    /// Continues from another state of the same gel.
    ///
    /// # Panics
    /// If the state does not pass [`Engine::check`].
    pub fn restore(&mut self, state: State<D>) {
        assert_eq!(self.check(&state), Ok(()), "a state belongs to its engine");
        self.calendar = Calendar::new(self.rules.schedule, &state.clocks);
        let begun = state.clocks.iter().any(|clock| clock.step > 0);
        self.now = begun.then(|| state.clocks.iter().map(|clock| clock.last).max().unwrap_or(0));
        self.state = state;
    }

    /// Replaces a body's state or wrench at its own time, an event; what changed is booked by the caller.
    pub fn set_body(&mut self, body: usize, state: &BodyState) {
        self.state.bodies[body] = *state;
    }

    /// The books, for what is done to a body from outside.
    pub fn ledger_mut(&mut self) -> &mut Ledger {
        &mut self.state.ledger
    }

    /// Moves a body to time `t` as an event and books what the wrench gave.
    pub fn rebase_body(&mut self, body: usize, t: f64) {
        let (fixed, state) = (&self.bodies[body], &mut self.state.bodies[body]);
        let next = state.at(fixed, t);
        state.passage(fixed, &next).post(&mut self.state.ledger);
        *state = next;
    }

    /// Processes all ticks up to time `t`, s, and adds what each body received to its `exchange`.
    ///
    /// # Panics
    /// Unless every body has its exchange.
    ///
    /// # Errors
    /// [`StepError`] when the mesh or the numbers fail.
    pub fn advance_to(&mut self, t: f64, exchanges: &mut [Exchange]) -> Result<(), StepError> {
        assert_eq!(exchanges.len(), self.bodies.len(), "every body has its exchange");
        let end = self.grid.last_tick(t);
        while let Some(tick) = self.next_event().filter(|tick| *tick <= end) {
            for body in 0..self.bodies.len() {
                if self.next_turn(body) == Some(tick) {
                    self.rebase_body(body, self.grid.time(tick));
                }
            }
            let due = self.calendar.take(tick).to_vec();
            if !due.is_empty() {
                self.tick(tick, &due, (t, exchanges))?;
            }
            self.now = Some(tick);
        }
        Ok(())
    }

    fn next_event(&self) -> Option<Tick> {
        let patches = self.now.map_or(Some(0), |now| self.calendar.next(now));
        let turns = (0..self.bodies.len()).filter_map(|body| self.next_turn(body));
        patches.into_iter().chain(turns).min()
    }

    /// The next tick at which the orientation of a body that tumbles is stepped: the first multiple of its period after
    /// the body's last event that has not been processed. The period is the longest power of two of ticks in which the
    /// body turns by no more than [`TURN`].
    fn next_turn(&self, body: usize) -> Option<Tick> {
        let now = self.now?;
        let (fixed, body) = (&self.bodies[body], &self.state.bodies[body]);
        if !fixed.tumbles(body) {
            return None;
        }
        let rate = fixed.angular_velocity(body).norm();
        let longest = self.grid.ticks(TURN / rate).clamp(1.0, LONGEST_TURN);
        let period = super::grid::floor_power_of_two(longest) as Tick;
        let last = (self.grid.ticks(body.time).floor() as Tick).max(now);
        Some((last / period + 1) * period)
    }

    fn tick(&mut self, tick: Tick, due: &[ElementId], (t, exchanges): (f64, &mut [Exchange])) -> Result<(), StepError> {
        let time = self.grid.time(tick);
        self.drift(tick, due);
        self.evaluate(due);
        self.check_elements(due, time)?;
        self.place_bodies(time);
        self.measure_gaps();
        self.measure_limits(due, tick);
        self.check_steps(due, time)?;
        let was: Vec<Clock> = due.iter().map(|patch| self.state.clocks[patch.index()]).collect();
        self.set_clocks(due, tick);
        self.find_touches(tick);
        self.kick_and_strike(due);
        self.book(due, &was, tick);
        self.book_contact();
        self.receive(time, (t, exchanges));
        self.reschedule(due, &was, tick);
        self.check_leaks(time)
    }

    fn place_bodies(&mut self, time: f64) {
        let scratch = &mut self.scratch;
        scratch.was.clear();
        scratch.was.extend(self.bodies.iter().zip(&self.state.bodies).map(|(body, last)| last.at(body, time)));
        scratch.now.clone_from(&scratch.was);
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

    /// An element that is inverted for the second tick in a row, or whose energy is not a number, ends the run; nothing but
    /// the drift has happened then.
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
    fn new(n_nodes: usize, n_gaps: usize) -> Self {
        Self {
            stamp: vec![0; n_nodes],
            before: vec![Vector::zeros(); n_nodes],
            limit: vec![0.0; n_nodes],
            gaps: vec![None; n_gaps],
            ..Self::default()
        }
    }
}
