//! The three-phase tick: drift the nodes that fire, kick them by their elements, then one contact solve (numerics 1.6).

use super::blocks::Blocks;
use super::gel::Measured;
use super::impact::{STRETCH, Touch};
use super::kick::Carrier;
use super::nodes::{Active, NodeSums};
use super::order::Order;
use super::pace::{Change, Nearness};
use super::reference::Answers;
use super::schedule::{Kind, Queue};
use super::sweep::Sweep;
use super::watch::Watch;
use super::{Gel, Pool, StepError, TickGrid};
use crate::algebra::{Vector, embed};
use crate::contact::{Body, BodyState, Exchange, Freedom, Law};
use crate::element::{GroupAnswer, LANES, Potential};
use crate::geometry::Gap;
use crate::ledger::Ledger;
use crate::mesh::{ElementId, NodeId};
use crate::state::{Alarm, Clock, Record, Sizes, State, Tick};
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

/// A stable step that is no number.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the stable step of an element is {step:e} s: stiffness and mass are too far apart, or there is no element")]
pub struct NoStep {
    /// The step, s.
    pub step: f64,
}

/// A gel and rigid bodies in time.
#[derive(Debug)]
pub struct Engine<const D: usize, P> {
    pub(super) gel: Arc<Gel<D, P>>,
    pub(super) order: Arc<Order>,
    pub(super) bodies: Vec<Body>,
    pub(super) rules: Rules,
    pub(super) grid: TickGrid,
    pub(super) state: State<D>,
    /// Last tick of each node; of one that is still, some tick.
    pub(super) last: Vec<Tick>,
    /// The fast form, if the potential has lanes and the schedule and the law allow it.
    pub(super) blocks: Option<Blocks<D>>,
    pub(super) watch: Watch,
    pub(super) scratch: Scratch<D>,
    pub(super) pool: Option<Pool>,
    queue: Queue,
    /// Least and greatest step of any group, ticks.
    steps: (Tick, Tick),
    /// Up to which tick nothing happens, when the gel is still.
    quiet: Option<Tick>,
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
    /// Nodes of what fires.
    pub active: Active,
    /// The groups that fire, ascending; of the fast form those whose step may change.
    pub due: Vec<u32>,
    /// v at the start of the tick, by node, of the reference form.
    pub before: Vec<Vector<D>>,
    /// CFL · 2/√λ_a, s, by node, of the active ones.
    pub limit: Vec<f64>,
    /// The same by number within one block.
    pub limits: Vec<f64>,
    /// The active nodes of the surface that may be near a body, ascending.
    pub reached: Vec<u32>,
    /// Their places among these, by node of the surface.
    pub place: Vec<u32>,
    /// The nodes of those that a body may meet before their next tick or that are an element's size from one.
    pub close: Vec<NodeId>,
    /// What contact allows around each that was looked at.
    pub nearness: Vec<Nearness>,
    /// Facets that reach to a body, with the least size of their nodes near it, body by body.
    pub facets: Vec<(u32, ElementId, f64)>,
    /// The facets around those nodes, with the distance of a body and the size there.
    pub found: Vec<(ElementId, f64, f64)>,
    /// φ and n of the nodes that were looked at to each active body.
    pub gaps: Vec<Option<Gap>>,
    /// The bodies at this tick before its impulses …
    pub was: Vec<BodyState>,
    /// … and with those so far.
    pub now: Vec<BodyState>,
    /// What the groups answered, of those that fire.
    pub answers: Vec<GroupAnswer>,
    /// What their elements answered, in the reference form.
    pub reference: Answers<D>,
    /// Length of the kick of the firing groups, s, in the reference form.
    pub weights: Vec<f64>,
    /// Groups whose step changed.
    pub changed: Vec<Change>,
    /// Points of the surface inside a body.
    pub touches: Vec<Touch<D>>,
    /// The nodes that carry them.
    pub carriers: Vec<Carrier<D>>,
    /// Sums over runs of nodes, and residuals of blocks.
    pub sums: Vec<NodeSums>,
    pub residuals: Vec<f64>,
}

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// A gel at the given positions and velocities, and bodies, at time 0.
    ///
    /// # Panics
    /// If there is no body, or the gel has no elements or their stiffness is not positive.
    #[must_use]
    pub fn new(
        gel: Gel<D, P>,
        bodies: Vec<(Body, BodyState)>,
        rules: Rules,
        nodes: Vec<(Vector<D>, Vector<D>)>,
    ) -> Self {
        Self::try_new(gel, bodies, rules, nodes).unwrap_or_else(|error| panic!("{error}"))
    }

    /// The same where the steps may be no numbers.
    ///
    /// # Errors
    /// [`NoStep`] if they are none.
    ///
    /// # Panics
    /// If there is no body or no element.
    pub fn try_new(
        gel: Gel<D, P>,
        bodies: Vec<(Body, BodyState)>,
        rules: Rules,
        nodes: Vec<(Vector<D>, Vector<D>)>,
    ) -> Result<Self, NoStep> {
        assert!(!bodies.is_empty(), "there is a body, if only one that touches nothing");
        let (position, velocity): (Vec<_>, Vec<_>) = nodes.into_iter().unzip();
        let (bodies, at): (Vec<_>, Vec<_>) = bodies.into_iter().unzip();
        let measured = gel.measure(&position);
        let steps = super::pace::stable_steps(&gel, &measured.stiffness, rules.cfl);
        // Any NaN must come out: `f64::min` would drop it.
        let least = |least: f64, step: &f64| if least.is_nan() || *step >= least { least } else { *step };
        let step = steps.iter().fold(f64::INFINITY, least);
        if !step.is_normal() {
            return Err(NoStep { step });
        }
        let grid = TickGrid::new(&steps);
        let order = order(&gel, &rules, |element| grid.ticks(steps[element.index()]));
        let state = State {
            stiffness: order.by_slot(&measured.stiffness),
            clocks: clocks(&gel, &order, &measured),
            alarms: vec![Alarm::default(); rules.schedule.alarms(order.n_groups())],
            now: None,
            bodies: at,
            ledger: Ledger::default(),
            record: Record::new(bodies.len()),
            position,
            velocity,
        };
        let (n_nodes, n_groups) = (state.position.len(), order.n_groups());
        let scratch = Scratch::new(n_nodes, gel.surface.nodes.len(), n_groups);
        let gel = Arc::new(gel);
        let fast = rules.law != Law::Reversal && rules.schedule != Kind::Queue;
        let blocks = fast.then(|| Blocks::new(&gel, &order)).flatten();
        let watch = Watch::new(&gel.surface, |node| embed(&state.position[node]));
        let start = Start::of(&gel, &bodies, &state);
        let mut engine = Self {
            last: vec![0; n_nodes],
            order: Arc::new(order),
            pool: None,
            queue: Queue::default(),
            steps: (0, 0),
            quiet: None,
            gel,
            bodies,
            rules,
            grid,
            state,
            blocks,
            watch,
            scratch,
            start,
        };
        engine.derive();
        Ok(engine)
    }

    /// The same with the reference form of every phase: one element after the other.
    #[must_use]
    pub fn by_reference(mut self) -> Self {
        self.blocks = None;
        self
    }

    /// The same on the vector units of another level than the widest of the machine; results do not depend on it.
    #[must_use]
    pub fn on_level(mut self, level: fearless_simd::Level) -> Self {
        if let Some(blocks) = &mut self.blocks {
            blocks.level = level;
        }
        self
    }

    /// Lets elements and nodes be shared by these threads; results do not depend on it.
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
        state.check_invariants(&Sizes {
            nodes: self.gel.mass.len(),
            slots: self.order.n_slots(),
            groups: self.order.n_groups(),
            alarms: self.rules.schedule.alarms(self.order.n_groups()),
            bodies: self.bodies.len(),
        })?;
        let fits = |clock: &Clock| self.rules.schedule != Kind::Bins || clock.step == 0 || clock.step.is_power_of_two();
        if state.clocks.iter().all(fits) { Ok(()) } else { Err("a step is none of the bins") }
    }

    /// Continues from another state of the same gel.
    ///
    /// # Panics
    /// If the state does not pass [`Engine::check`].
    pub fn restore(&mut self, state: &State<D>) {
        assert_eq!(self.check(state), Ok(()), "a state belongs to its engine");
        self.state.clone_from(state);
        self.derive();
    }

    /// Finds what is derived from the state: events, the last ticks of the nodes, what is awake, the greatest speed.
    fn derive(&mut self) {
        let state = &self.state;
        let queued = self.rules.schedule == Kind::Queue && state.now.is_some();
        self.queue = Queue::new(if queued { &state.alarms } else { &[] });
        self.quiet = None;
        let now = state.now.unwrap_or(0);
        let last = |group: usize| match self.rules.schedule {
            Kind::Bins => now & !state.clocks[group].step.saturating_sub(1),
            Kind::Queue => state.alarms[group].last,
            Kind::Global => state.alarms[0].last,
        };
        self.last.fill(0);
        for group in 0..state.clocks.len() {
            for element in self.order.elements(self.order.slots(group)) {
                for node in self.gel.potential.nodes(element) {
                    let node = &mut self.last[node.index()];
                    *node = last(group).max(*node);
                }
            }
        }
        if let Some(blocks) = &mut self.blocks {
            blocks.restart(&state.clocks);
        }
        let fastest = state.velocity.iter().map(Vector::<D>::norm_squared).fold(0.0, f64::max);
        self.watch.reset(fastest.sqrt());
        self.find_steps();
    }

    fn find_steps(&mut self) {
        let steps = self.state.clocks.iter().map(|clock| clock.step);
        self.steps = steps.fold((Tick::MAX, 0), |(least, most), step| (least.min(step), most.max(step)));
    }

    /// The longest step of a group, ticks.
    pub(super) fn longest_step(&self) -> Tick {
        self.steps.1
    }

    /// Replaces a body's state or wrench at its own time, an event; what changed is booked by the caller.
    pub fn set_body(&mut self, body: usize, state: &BodyState) {
        self.state.bodies[body] = *state;
        self.quiet = None;
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
        while let Some(tick) = self.next_event(end).filter(|tick| *tick <= end) {
            for body in 0..self.bodies.len() {
                if self.next_turn(body) == Some(tick) {
                    self.rebase_body(body, self.grid.time(tick));
                }
            }
            let due = self.is_due(tick);
            let done = if due { self.tick(tick, (t, exchanges)) } else { Ok(()) };
            self.state.now = Some(tick);
            done?;
        }
        // Ticks that were skipped have been processed, too.
        if let (Some(now), Kind::Bins) = (self.state.now, self.rules.schedule) {
            self.state.now = Some(now.max(end / self.steps.0 * self.steps.0));
        }
        Ok(())
    }

    fn next_event(&mut self, end: Tick) -> Option<Tick> {
        let elements = match self.state.now {
            None => Some(0),
            Some(now) => {
                let from = self.skip(now, end);
                self.next_tick(from)
            }
        };
        let turns = (0..self.bodies.len()).filter_map(|body| self.next_turn(body));
        elements.into_iter().chain(turns).min()
    }

    /// The next tick at which a group fires.
    fn next_tick(&self, now: Tick) -> Option<Tick> {
        match self.rules.schedule {
            Kind::Bins => Some((now / self.steps.0 + 1) * self.steps.0),
            Kind::Global => self.state.alarms.first().map(|alarm| alarm.next),
            Kind::Queue => self.queue.next(),
        }
    }

    /// Whether groups fire at an event.
    fn is_due(&self, tick: Tick) -> bool {
        match self.rules.schedule {
            _ if self.state.now.is_none() => true,
            Kind::Bins => tick.is_multiple_of(self.steps.0),
            Kind::Queue | Kind::Global => self.next_tick(tick) == Some(tick),
        }
    }

    /// From which tick on to look for the next one: later than now while the gel is still and no body can be near. All groups
    /// are then where they were, whatever fires.
    fn skip(&mut self, now: Tick, end: Tick) -> Tick {
        let still = |blocks: &Blocks<D>| blocks.blocks.iter().all(|block| !block.is_awake());
        if self.rules.schedule != Kind::Bins || !self.blocks.as_ref().is_some_and(still) {
            self.quiet = None;
            return now;
        }
        let quiet = self.quiet.unwrap_or_else(|| {
            let reach = self.watch.reach(&self.bodies, self.horizon() * self.grid.time(1));
            let within = |i: usize| STRETCH * self.gel.surface.nodes[i].size + reach;
            self.grid.last_tick(self.watch.time() + self.watch.quiet(&self.bodies, within))
        });
        self.quiet = Some(quiet);
        if quiet <= now {
            self.quiet = None;
        }
        now.max(quiet.min(end))
    }

    /// The next tick at which the orientation of a body that tumbles is stepped: the first multiple of its period after
    /// the body's last event that has not been processed. The period is the longest power of two of ticks in which the
    /// body turns by no more than [`TURN`].
    fn next_turn(&self, body: usize) -> Option<Tick> {
        let now = self.state.now?;
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

    fn tick(&mut self, tick: Tick, (t, exchanges): (f64, &mut [Exchange])) -> Result<(), StepError> {
        let time = self.grid.time(tick);
        self.answer(tick);
        self.check_elements(time)?;
        self.place_bodies(time);
        let limit = if self.blocks.is_some() { self.drift_and_limit(tick) } else { self.measure_limits() };
        self.count_synchronous(limit, tick);
        self.look_around(tick);
        let groups = self.attentive(tick);
        let collapsed = self.set_clocks(&groups, tick);
        self.scratch.due = groups;
        self.find_touches(tick);
        let work = self.kick_all(tick);
        self.book(tick, work);
        self.book_contact();
        self.receive(time, (t, exchanges));
        self.reschedule();
        match collapsed {
            Some(error) => Err(error),
            None => self.check_leaks(time),
        }
    }

    /// What the elements that fire answer, in either form.
    fn answer(&mut self, tick: Tick) {
        let Some(blocks) = &mut self.blocks else {
            self.find_due(tick);
            self.find_steps_behind(tick);
            self.drift(tick);
            return self.evaluate();
        };
        let sweep = Sweep {
            tick,
            grid: &self.grid,
            kind: self.rules.schedule,
            position: &self.state.position,
            velocity: &self.state.velocity,
            rest: self.gel.potential.rest(),
            last: &self.last,
            clocks: &self.state.clocks,
            order: &self.order,
        };
        let elements = blocks.find_due(&sweep);
        let found = (self.state.stiffness.as_mut_slice(), self.scratch.answers.as_mut_slice());
        blocks.sweep(&sweep, found, (self.pool.as_ref(), elements));
        self.find_active();
    }

    /// The groups that fire, ascending.
    fn find_due(&mut self, tick: Tick) {
        let due = &mut self.scratch.due;
        due.clear();
        if self.rules.schedule == Kind::Queue && tick > 0 {
            self.queue.take(tick, due);
            return;
        }
        let fires = |clock: &Clock| tick == 0 || self.rules.schedule.fires(clock.step, tick);
        due.extend((0..).zip(&self.state.clocks).filter(|(_, clock)| fires(clock)).map(|(group, _)| group));
    }

    fn kick_all(&mut self, tick: Tick) -> f64 {
        if self.blocks.is_some() {
            return self.kick_fast(tick);
        }
        self.find_weights(tick);
        self.kick_and_strike();
        self.note_speeds();
        self.work()
    }

    /// The length of the kick of each firing group: half of the step behind and half of the step ahead.
    fn find_weights(&mut self, tick: Tick) {
        let ahead = |group: usize| match self.rules.schedule {
            Kind::Queue => self.state.alarms[group].next - tick,
            Kind::Bins | Kind::Global => self.state.clocks[group].step,
        };
        for (weight, group) in self.scratch.weights.iter_mut().zip(&self.scratch.due) {
            *weight = 0.5 * (*weight + self.grid.time(ahead(*group as usize)));
        }
    }

    /// The length of the step behind each firing group, s.
    fn find_steps_behind(&mut self, tick: Tick) {
        let behind = |group: &u32| match self.rules.schedule {
            Kind::Queue => tick - self.state.alarms[*group as usize].last,
            Kind::Bins | Kind::Global => self.state.clocks[*group as usize].step,
        };
        let steps = self.scratch.due.iter().map(|group| self.grid.time(behind(group)));
        self.scratch.weights.clear();
        self.scratch.weights.extend(steps);
    }

    fn place_bodies(&mut self, time: f64) {
        let scratch = &mut self.scratch;
        scratch.was.clear();
        scratch.was.extend(self.bodies.iter().zip(&self.state.bodies).map(|(body, last)| last.at(body, time)));
        scratch.now.clone_from(&scratch.was);
    }

    /// An element that is inverted for the second tick in a row, or whose energy is not a number, ends the run; nothing but
    /// the drift has happened then.
    fn check_elements(&self, time: f64) -> Result<(), StepError> {
        let fails = |group: &usize| {
            let (answer, clock) = (&self.scratch.answers[*group], &self.state.clocks[*group]);
            !answer.energy.is_finite() || answer.inverted & clock.inverted != 0
        };
        let failed = match &self.blocks {
            Some(blocks) => blocks.blocks.iter().find_map(|block| block.report.failed),
            None => self.scratch.due.iter().map(|group| *group as usize).find(fails),
        };
        failed.map_or(Ok(()), |group| Err(self.failure(group, time)))
    }

    /// Which element of a group fails, and how.
    fn failure(&self, group: usize, time: f64) -> StepError {
        let (answer, clock) = (&self.scratch.answers[group], &self.state.clocks[group]);
        let first = self.order.slots(group).start;
        let twice = answer.inverted & clock.inverted;
        if answer.energy.is_finite() {
            let slot = first + twice.trailing_zeros() as usize;
            let element = self.order.element(slot).map_or(0, ElementId::index);
            return StepError::Inverted { element, time, jacobian: answer.least_jacobian };
        }
        let element = self.order.elements(self.order.slots(group)).next().map_or(0, ElementId::index);
        StepError::NotFinite { element, time }
    }

    /// Puts what has fired back in.
    fn reschedule(&mut self) {
        if self.rules.schedule == Kind::Queue {
            for group in &self.scratch.due {
                self.queue.put(*group, self.state.alarms[*group as usize].next);
            }
        }
        if !self.scratch.changed.is_empty() {
            self.find_steps();
        }
    }

    /// Whether an element has fired at this tick, after the clocks were set.
    pub(super) fn has_fired(&self, element: ElementId, tick: Tick) -> bool {
        let group = self.order.group(element);
        match self.rules.schedule {
            Kind::Queue => self.state.alarms[group].last == tick,
            kind => kind.fires(self.state.clocks[group].step, tick),
        }
    }

    /// Position of a node drifted to time `t`, m.
    #[must_use]
    pub fn position_at(&self, node: NodeId, t: f64) -> Vector<D> {
        let a = node.index();
        self.state.position[a] + self.state.velocity[a] * (t - self.grid.time(self.last[a]))
    }

    /// World position and velocity of a node that is active at this tick.
    pub(super) fn world(&self, node: NodeId) -> (crate::algebra::Vector3, crate::algebra::Vector3) {
        (embed(&self.state.position[node.index()]), embed(&self.state.velocity[node.index()]))
    }
}

impl<const D: usize> Scratch<D> {
    fn new(n_nodes: usize, n_surface: usize, n_groups: usize) -> Self {
        Self {
            active: Active::new(n_nodes),
            limit: vec![0.0; n_nodes],
            place: vec![u32::MAX; n_surface],
            answers: vec![GroupAnswer::default(); n_groups],
            ..Self::default()
        }
    }
}

/// Patches of equal steps beside each other; in the queue each by itself.
fn order<const D: usize, P: Potential<D>>(gel: &Gel<D, P>, rules: &Rules, ticks: impl Fn(ElementId) -> f64) -> Order {
    let step = |patch: usize| {
        let limit =
            gel.potential.patches().of(patch).iter().map(|element| ticks(*element)).fold(f64::INFINITY, f64::min);
        rules.schedule.step(limit.max(1.0))
    };
    match rules.schedule {
        // What touches the surface stands apart: contact shortens the steps of whole groups.
        Kind::Bins => Order::new(&gel.potential, LANES, |patch| 2 * step(patch) + u64::from(is_inner(gel, patch))),
        Kind::Global => Order::new(&gel.potential, LANES, |_| 0),
        Kind::Queue => Order::new(&gel.potential, 1, |_| 0),
    }
}

/// Clocks that have not begun, with the energies there are.
fn clocks<const D: usize, P: Potential<D>>(gel: &Gel<D, P>, order: &Order, measured: &Measured) -> Vec<Clock> {
    let crushed = |element: &ElementId| gel.potential.is_crushed(measured.jacobian[element.index()]);
    let clock = |group: usize| Clock {
        energy: order.patches(group).iter().map(|patch| measured.energy[*patch as usize]).sum(),
        crushed: order.elements(order.slots(group)).filter(crushed).count() as u32,
        ..Clock::default()
    };
    (0..order.n_groups()).map(clock).collect()
}

/// Whether no node of a patch is on the surface.
fn is_inner<const D: usize, P: Potential<D>>(gel: &Gel<D, P>, patch: usize) -> bool {
    let mut nodes = gel.potential.patches().of(patch).iter().flat_map(|element| gel.potential.nodes(*element));
    nodes.all(|node| gel.surface.of[node.index()].is_none())
}
