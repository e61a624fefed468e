//! The engine: a gel and rigid bodies in time, what is stored and what is derived from it.

use super::blocks::Blocks;
use super::element_order::Order;
use super::handover::{Ends, Passage};
use super::neighbour_list::{Watch, least};
use super::node_loop::RUN;
use super::schedule::{EventQueue, Kind};
use super::sort_keys::element_layout;
use super::substep::Phase;
use super::workspace::Workspace;
use super::{Gel, Pool, StepError, TickGrid};
use crate::contact::{Body, BodyState, Freedom, Law};
use crate::fem::{Measured, Potential};
use crate::ledger::Ledger;
use crate::math::{Vector, Vector3, embed};
use crate::mesh::{ElementId, NodeId};
use crate::state::{Alarm, Clock, MOST_TICKS, Sizes, State, Tick};
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
    /// α, by which nodes lose speed as exp(−αt), 1/s.
    pub damping: f64,
}

/// A stable step that is none of a run: no number, shorter than a tick, or of more ticks than there are ([`MOST_TICKS`]).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the stable step of an element is {step:e} s: stiffness and mass are too far apart, or there is no element")]
pub struct NoStep {
    /// The step, s.
    pub step: f64,
    /// Where the corners of the stiffest element around a node are whose step is shorter than a tick, m; none if that is not why.
    pub corners: Vec<Vector3>,
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
    pub(super) scratch: Workspace<D>,
    pub(super) pool: Option<Arc<Pool>>,
    pub(super) queue: EventQueue,
    /// Least and greatest step of any group, ticks.
    pub(super) steps: (Tick, Tick),
    /// Shortest and longest stable step of an element when the mesh was new, ticks.
    pub(super) first: (f64, f64),
    /// What ends the mesh.
    pub(super) ends: Ends,
    /// What failed at the last tick of the mesh: the run ends with it if no other mesh is found.
    pub(super) failure: Option<StepError>,
    /// The first tick of this mesh.
    pub(super) origin: Tick,
    /// Where the tick is that is processed.
    pub(super) phase: Phase,
    /// Whether the gap clocks know of the last event of every body.
    pub(super) placed: bool,
    /// Up to which tick nothing happens, when the gel is still.
    pub(super) quiet_until: Option<Tick>,
    start: Start,
}

/// What the books are balanced against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Start {
    pub energy: f64,
    pub momentum: Vector3,
    pub angular_momentum: Vector3,
    /// Σ m|v| and Σ |x × mv|, scales of momentum and angular momentum.
    pub scale: (f64, f64),
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
        let passage = Passage::begin(bodies.len());
        Self::assemble((gel, rules), bodies, nodes, passage).map(|(engine, _)| engine)
    }

    /// At the start, or where another mesh has ended; and the stable steps of the elements when the mesh is new, s.
    pub(super) fn assemble(
        (gel, rules): (Gel<D, P>, Rules),
        bodies: Vec<(Body, BodyState)>,
        nodes: Vec<(Vector<D>, Vector<D>)>,
        passage: Passage<D>,
    ) -> Result<(Self, Vec<f64>), NoStep> {
        assert!(!bodies.is_empty(), "there is a body, if only one that touches nothing");
        let (position, velocity): (Vec<_>, Vec<_>) = nodes.into_iter().unzip();
        let (bodies, at): (Vec<_>, Vec<_>) = bodies.into_iter().unzip();
        let Passage { tick: origin, grid, ledger, mut record, start, memory, steps } = passage;
        let memory = memory.unwrap_or_else(|| gel.fresh_memory());
        let measured = gel.measure(&position, &memory);
        let steps = steps.unwrap_or_else(|| super::step_size::stable_steps(&gel, &measured.stiffness, rules.cfl));
        let (grid, step) = tick_grid(&steps, grid)?;
        record.synchronous = (step, origin, record.synchronous.2);
        let order = element_layout(&gel, &rules, |element| grid.ticks(steps[element.index()]));
        let state = State {
            excess: vec![0.0; position.len()],
            stiffness: order.by_slot(&measured.stiffness),
            clocks: initial_clocks(&gel, &order, &measured),
            alarms: vec![Alarm::default(); rules.schedule.n_alarms(order.n_groups())],
            birth: None,
            now: None,
            bodies: at,
            memory,
            ledger,
            record,
            position,
            velocity,
        };
        let scratch = Workspace::new(state.position.len(), gel.surface.nodes.len(), order.n_groups());
        let gel = Arc::new(gel);
        let watch = Watch::new(&gel.surface, (0.0, vec![]), |node| embed(&state.position[node]));
        let start = start.unwrap_or_else(|| Start::of(&gel, &bodies, &state));
        let mut engine = Self {
            blocks: element_blocks(&gel, &order, &rules),
            last: vec![origin; state.position.len()],
            order: Arc::new(order),
            pool: None,
            queue: EventQueue::default(),
            steps: (0, 0),
            ends: Ends::default(),
            failure: None,
            origin,
            phase: Phase::First,
            quiet_until: None,
            placed: false,
            first: (step, grid.ticks(steps.iter().copied().fold(0.0, f64::max))),
            gel,
            bodies,
            rules,
            grid,
            state,
            watch,
            scratch,
            start,
        };
        engine.derive();
        Ok((engine, steps))
    }

    /// The same with the reference form of every phase: one element after the other.
    #[must_use]
    pub fn by_reference(mut self) -> Self {
        self.blocks = None;
        self.scratch.sums.clear();
        self.derive();
        self
    }

    /// The same with what is at rest computed as well; results do not depend on it.
    #[must_use]
    pub fn without_rest(mut self) -> Self {
        if let Some(blocks) = &mut self.blocks {
            blocks.never_rest = true;
        }
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
    pub fn with_pool(mut self, pool: Option<Arc<Pool>>) -> Self {
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
            alarms: self.rules.schedule.n_alarms(self.order.n_groups()),
            memories: self.gel.n_memories(),
            bodies: self.bodies.len(),
            born: state.birth.as_ref().map_or(0, |birth| birth.mesh.elements.len()),
            references: state.birth.as_ref().map_or(0, |birth| birth.references.len()),
        })?;
        if state.birth != self.state.birth {
            return Err("it is of another mesh");
        }
        if !self.bodies.iter().zip(&state.bodies).all(|(body, its)| body.admits(its)) {
            return Err("a body has left its plane or axis, or is no longer what it was");
        }
        let begun = state.birth.as_ref().map_or(0, |birth| birth.tick);
        let now = state.now.unwrap_or(begun);
        if begun > now || begun >= MOST_TICKS || state.record.synchronous.1 > now {
            return Err("its ticks are in no order");
        }
        let fits = |clock: &Clock| self.rules.schedule != Kind::Bins || clock.step == 0 || clock.step.is_power_of_two();
        if state.clocks.iter().all(fits) { Ok(()) } else { Err("a step is none of the bins") }
    }

    /// Whether a state can have come to time `t`, s: at most its longest step beyond its last tick, and its bodies as far.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check_time(&self, state: &State<D>, t: f64) -> Result<(), &'static str> {
        let longest = state.clocks.iter().map(|clock| clock.step).fold(0, Tick::max).min(MOST_TICKS);
        let begun = state.birth.as_ref().map_or(0, |birth| birth.tick);
        // A gel at rest has no further ticks, whatever time it is.
        let last = if state.record.at_rest { MOST_TICKS } else { state.now.unwrap_or(begun).min(MOST_TICKS) };
        let latest = self.grid.time(last + longest);
        let past = |time: f64| (0.0..=latest).contains(&time);
        if !past(t) || !state.bodies.iter().all(|body| past(body.time)) {
            return Err("its times and ticks contradict each other");
        }
        let numbers = self.bodies.iter().zip(&state.bodies).all(|(fixed, body)| body.at(fixed, t).is_valid());
        if numbers { Ok(()) } else { Err("a body moves beyond all numbers") }
    }

    /// Continues from another state of the same gel.
    ///
    /// # Errors
    /// What is wrong, as [`Engine::check`] finds it; nothing is changed then.
    pub fn restore(&mut self, state: &State<D>) -> Result<(), &'static str> {
        self.check(state)?;
        self.state.clone_from(state);
        self.derive();
        Ok(())
    }

    /// Finds what is derived from the state: events, the last ticks of the nodes, what is awake, the greatest speeds.
    pub(super) fn derive(&mut self) {
        let state = &self.state;
        let queued = self.rules.schedule == Kind::Queue && state.now.is_some();
        self.queue = EventQueue::new(if queued { &state.alarms } else { &[] });
        self.quiet_until = None;
        if let Some(blocks) = &mut self.blocks {
            let (rest, zero) = (self.gel.potential.rest(), Vector::<D>::zeros());
            let moves = |node: usize| state.velocity[node] != zero || state.position[node] != rest[node];
            blocks.is_prestrained = self.gel.potential.remembers() && self.origin > 0;
            blocks.reset(&state.clocks, self.grid, moves);
            blocks.load_history(&self.order, &state.memory);
        }
        let speed = |run: &[Vector<D>]| run.iter().map(Vector::<D>::norm_squared).fold(0.0, f64::max).sqrt();
        let speeds: Vec<f64> = state.velocity.chunks(RUN).map(speed).collect();
        let now = self.grid.time(state.now.unwrap_or(self.origin));
        self.derive_last_ticks();
        let place = |node: usize| embed(&self.position_at(NodeId(node as u32), now));
        self.watch = Watch::new(&self.gel.surface, (now, speeds), place);
        self.placed = false;
        self.update_step_range();
    }

    /// The last tick of each node: the latest of the groups around it.
    fn derive_last_ticks(&mut self) {
        let (state, order, gel, all) = (&self.state, &self.order, &self.gel, &mut self.last);
        let now = state.now.unwrap_or(self.origin);
        let last = |group: usize| match self.rules.schedule {
            Kind::Bins => now & !state.clocks[group].step.saturating_sub(1),
            Kind::Queue => state.alarms[group].last,
            Kind::Global => state.alarms[0].last,
        };
        all.fill(self.origin);
        let mut see = |tick: Tick, node: &NodeId| all[node.index()] = tick.max(all[node.index()]);
        let of_group = |group: usize| {
            order
                .elements(order.slots(group))
                .flat_map(|element| gel.potential.nodes(element))
                .map(move |node| (group, node))
        };
        let Some(blocks) = &self.blocks else {
            return (0..state.clocks.len()).flat_map(of_group).for_each(|(group, node)| see(last(group), node));
        };
        // Where all groups are of one step, each node is seen once and not with every element.
        let (even, mixed): (Vec<_>, Vec<_>) =
            blocks.all.iter().enumerate().partition(|(_, block)| block.steps.0 == block.steps.1);
        for (i, block) in even {
            block.nodes.iter().for_each(|node| see(last(i * blocks.groups), node));
        }
        let mixed = mixed.iter().flat_map(|(i, _)| blocks.groups_of(*i));
        mixed.flat_map(of_group).for_each(|(group, node)| see(last(group), node));
    }

    /// The least and the greatest step of any group, which blocks know of theirs.
    pub(super) fn update_step_range(&mut self) {
        let all = |(least, most): (Tick, Tick), of: (Tick, Tick)| (least.min(of.0), most.max(of.1));
        let none = (Tick::MAX, 0);
        self.steps = match &self.blocks {
            Some(blocks) => blocks.all.iter().map(|block| block.steps).fold(none, all),
            None => self.state.clocks.iter().map(|clock| (clock.step, clock.step)).fold(none, all),
        };
    }

    /// The longest step of a group, ticks.
    pub(super) fn longest_step(&self) -> Tick {
        self.steps.1
    }

    /// Replaces a body's state or wrench at its own time, an event; what changed is booked by the caller.
    pub fn set_body(&mut self, body: usize, state: &BodyState) {
        self.state.bodies[body] = *state;
        (self.quiet_until, self.placed) = (None, false);
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

    /// Position of a node drifted to time `t`, m.
    #[must_use]
    pub fn position_at(&self, node: NodeId, t: f64) -> Vector<D> {
        let a = node.index();
        self.state.position[a] + self.state.velocity[a] * (t - self.grid.time(self.last[a]))
    }

    /// Velocity of a node before the kicks of this tick, m/s.
    pub(super) fn velocity_before(&self, node: NodeId) -> Vector<D> {
        let a = node.index();
        if self.scratch.active.has(a) { self.scratch.before[a] } else { self.state.velocity[a] }
    }
}

/// The fast form, if there can be one.
fn element_blocks<const D: usize, P: Potential<D>>(gel: &Gel<D, P>, order: &Order, rules: &Rules) -> Option<Blocks<D>> {
    let fast = rules.law != Law::Reversal && rules.schedule != Kind::Queue;
    fast.then(|| Blocks::new(gel, order)).flatten()
}

/// The grid of these stable steps, unless there is one, and the shortest of them, ticks.
pub(super) fn tick_grid(steps: &[f64], grid: Option<TickGrid>) -> Result<(TickGrid, f64), NoStep> {
    let step = steps.iter().copied().fold(f64::INFINITY, least);
    if !step.is_normal() {
        return Err(NoStep { step, corners: vec![] });
    }
    let grid = grid.unwrap_or_else(|| TickGrid::new(steps));
    Ok((grid, grid.ticks(step)))
}

/// Clocks that have not begun, with the energies there are.
fn initial_clocks<const D: usize, P: Potential<D>>(gel: &Gel<D, P>, order: &Order, measured: &Measured) -> Vec<Clock> {
    let crushed = |element: &ElementId| gel.potential.is_crushed(measured.jacobian[element.index()]);
    let clock = |group: usize| Clock {
        energy: order.patches(group).iter().map(|patch| measured.energy[*patch as usize]).sum::<f64>() + 0.0,
        crushed: order.elements(order.slots(group)).filter(crushed).count() as u32,
        ..Clock::default()
    };
    (0..order.n_groups()).map(clock).collect()
}
