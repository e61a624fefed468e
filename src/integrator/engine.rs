//! The engine: a gel and rigid bodies in time; the stored state and the quantities derived from it.

use super::blocks::ElementBlocks;
use super::element_order::ElementLayout;
use super::handover::{Carryover, EndConditions};
use super::neighbour_list::{NeighbourList, least};
use super::node_loop::RUN;
use super::schedule::{EventQueue, SteppingSchedule};
use super::sort_keys::element_layout;
use super::substep::MeshPhase;
use super::workspace::Workspace;
use super::{DiscreteGel, StepError, TickGrid, WorkerPool};
use crate::contact::{BodyState, FreeDirections, ImpulseLaw, RigidBody};
use crate::fem::{ElementStates, Potential};
use crate::ledger::Ledger;
use crate::math::{Vector, Vector3, embed};
use crate::mesh::{ElementId, NodeId};
use crate::state::{DynamicState, GroupAlarm, GroupClock, MOST_TICKS, StateSizes, Tick};
use std::sync::Arc;

/// Error: a stable step is unusable, because it is not a number, is shorter than a tick or exceeds [`MOST_TICKS`]
/// ticks.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "the stable step of an element is {step:e} s: the ratio of stiffness to mass is out of range, or there is no \
     element"

/// Integrator of a gel and rigid bodies in time.
#[derive(Debug)]
pub struct Engine<const D: usize, P> {
    pub(super) gel: Arc<DiscreteGel<D, P>>,
    pub(super) order: Arc<ElementLayout>,
    pub(super) bodies: Vec<RigidBody>,
    pub(super) rules: IntegratorSettings,
    pub(super) grid: TickGrid,
    pub(super) state: DynamicState<D>,
    /// Last tick of each node; arbitrary for a node at rest.
    pub(super) last: Vec<Tick>,
    /// Blocks of elements for the SIMD form; `None` if the potential, the schedule or the contact law needs the
    /// reference form.
    pub(super) blocks: Option<ElementBlocks<D>>,
    pub(super) watch: NeighbourList,
    pub(super) scratch: Workspace<D>,
    pub(super) pool: Option<Arc<WorkerPool>>,
    pub(super) queue: EventQueue,
    /// Least and greatest step of any group, ticks.
    pub(super) steps: (Tick, Tick),
    /// Shortest and longest stable step of an element on the new mesh, ticks.
    pub(super) first: (f64, f64),
    /// Conditions that end the mesh.
    pub(super) ends: EndConditions,
    /// Failure at the last tick of the mesh; it ends the run unless another mesh is found.
    pub(super) failure: Option<StepError>,
    /// First tick of this mesh.
    pub(super) origin: Tick,
    /// Place of the current tick in the life of the mesh.
    pub(super) phase: MeshPhase,
    /// True if the neighbour list knows the last event of every body.
    pub(super) placed: bool,
    /// Tick up to which nothing happens, while the gel is at rest.
    pub(super) quiet_until: Option<Tick>,
    start: BalanceReference,
}

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Builds the engine at time 0 from a gel, bodies, and the positions and velocities of the nodes.
    ///
    /// # Panics
    /// If there is no body, or the gel has no elements or their stiffness is not positive.
    #[must_use]
    pub fn new(
        gel: DiscreteGel<D, P>,
        bodies: Vec<(RigidBody, BodyState)>,
        rules: IntegratorSettings,
        nodes: Vec<(Vector<D>, Vector<D>)>,
    ) -> Self {
        Self::try_new(gel, bodies, rules, nodes).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Builds the engine like [`Engine::new`], with an error for unusable steps.
    ///
    /// # Errors
    /// [`UnusableStep`] if a stable step is unusable.
    ///
    /// # Panics
    /// If there is no body or no element.
    pub fn try_new(
        gel: DiscreteGel<D, P>,
        bodies: Vec<(RigidBody, BodyState)>,
        rules: IntegratorSettings,
        nodes: Vec<(Vector<D>, Vector<D>)>,
    ) -> Result<Self, UnusableStep> {
        let passage = Carryover::begin(bodies.len());
        Self::assemble((gel, rules), bodies, nodes, passage).map(|(engine, _)| engine)
    }

    /// Builds the engine at the start or where another mesh has ended; also returns the stable step of each element
    /// on the new mesh, s.
    pub(super) fn assemble(
        (gel, rules): (DiscreteGel<D, P>, IntegratorSettings),
        bodies: Vec<(RigidBody, BodyState)>,
        nodes: Vec<(Vector<D>, Vector<D>)>,
        passage: Carryover<D>,
    ) -> Result<(Self, Vec<f64>), UnusableStep> {
        assert!(!bodies.is_empty(), "there is a body, if only one that touches nothing");
        let (position, velocity): (Vec<_>, Vec<_>) = nodes.into_iter().unzip();
        let (bodies, at): (Vec<_>, Vec<_>) = bodies.into_iter().unzip();
        let Carryover { tick: origin, grid, ledger, mut record, start, memory, steps } = passage;
        let memory = memory.unwrap_or_else(|| gel.fresh_memory());
        let measured = gel.measure(&position, &memory);
        let steps = steps.unwrap_or_else(|| super::step_size::stable_steps(&gel, &measured.stiffness, rules.cfl));
        let (grid, step) = tick_grid(&steps, grid)?;
        record.synchronous = (step, origin, record.synchronous.2);
        let order = element_layout(&gel, &rules, |element| grid.ticks(steps[element.index()]));
        let state = DynamicState {
            excess: vec![0.0; position.len()],
            stiffness: order.by_slot(&measured.stiffness),
            clocks: initial_clocks(&gel, &order, &measured),
            alarms: vec![GroupAlarm::default(); rules.schedule.n_alarms(order.n_groups())],
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
        let watch = NeighbourList::new(&gel.surface, (0.0, vec![]), |node| embed(&state.position[node]));
        let start = start.unwrap_or_else(|| BalanceReference::of(&gel, &bodies, &state));
        let mut engine = Self {
            blocks: element_blocks(&gel, &order, &rules),
            last: vec![origin; state.position.len()],
            order: Arc::new(order),
            pool: None,
            queue: EventQueue::default(),
            steps: (0, 0),
            ends: EndConditions::default(),
            failure: None,
            origin,
            phase: MeshPhase::First,
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
        engine.derive_from_state();
        Ok((engine, steps))
    }

    /// Selects the reference form of every phase, which processes one element after the other.
    #[must_use]
    pub fn with_reference_form(mut self) -> Self {
        self.blocks = None;
        self.scratch.sums.clear();
        self.derive_from_state();
        self
    }

    /// Disables the skipping of blocks at rest; results do not depend on it.
    #[must_use]
    pub fn with_sweeps_at_rest(mut self) -> Self {
        if let Some(blocks) = &mut self.blocks {
            blocks.never_rest = true;
        }
        self
    }

    /// Selects a SIMD level other than the widest of the machine; results do not depend on it.
    #[must_use]
    pub fn with_simd_level(mut self, level: fearless_simd::Level) -> Self {
        if let Some(blocks) = &mut self.blocks {
            blocks.level = level;
        }
        self
    }

    /// Shares elements and nodes among the threads of a pool; results do not depend on it.
    #[must_use]
    pub fn with_pool(mut self, pool: Option<Arc<WorkerPool>>) -> Self {
        self.pool = pool;
        self
    }

    /// Returns the state.
    #[must_use]
    pub fn state(&self) -> &DynamicState<D> {
        &self.state
    }

    /// Returns the constant properties of the bodies.
    #[must_use]
    pub fn bodies(&self) -> &[RigidBody] {
        &self.bodies
    }

    /// Returns the directions of motion that the dimension leaves to every body.
    pub(super) fn freedom(&self) -> FreeDirections {
        self.bodies[0].freedom
    }

    /// Returns the gel, the constant part of the model.
    #[must_use]
    pub fn gel(&self) -> &DiscreteGel<D, P> {
        &self.gel
    }

    /// Returns the grid of ticks.
    #[must_use]
    pub fn grid(&self) -> &TickGrid {
        &self.grid
    }

    /// Returns the initial energy and momentum.
    pub(super) fn start(&self) -> &BalanceReference {
        &self.start
    }

    /// Checks that a state can belong to this engine.
    ///
    /// # Errors
    /// The contradiction found.
    pub fn check(&self, state: &DynamicState<D>) -> Result<(), &'static str> {
        state.check_invariants(&StateSizes {
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
            return Err("it belongs to another mesh");
        }
        if !self.bodies.iter().zip(&state.bodies).all(|(body, its)| body.is_admissible(its)) {
            return Err(
                "a body is off its plane or axis, its quaternion is not of norm 1, or it has a bulge without a dome",
            );
        }
        let begun = state.birth.as_ref().map_or(0, |birth| birth.tick);
        let now = state.now.unwrap_or(begun);
        if begun > now || begun >= MOST_TICKS || state.record.synchronous.1 > now {
            return Err("its ticks are in no order");
        }
        let fits = |clock: &GroupClock| {
            self.rules.schedule != SteppingSchedule::Bins || clock.step == 0 || clock.step.is_power_of_two()
        };
        if state.clocks.iter().all(fits) { Ok(()) } else { Err("a step is none of the bins") }
    }

    /// Checks that a state can have reached time `t`, s: at most its longest step after its last tick, and so its
    /// bodies.
    ///
    /// # Errors
    /// The contradiction found.
    pub fn check_time(&self, state: &DynamicState<D>, t: f64) -> Result<(), &'static str> {
        let longest = state.clocks.iter().map(|clock| clock.step).fold(0, Tick::max).min(MOST_TICKS);
        let begun = state.birth.as_ref().map_or(0, |birth| birth.tick);
        // A gel at rest has no further ticks, at any time.
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
    /// The contradiction that [`Engine::check`] finds; nothing is changed then.
    pub fn restore(&mut self, state: &DynamicState<D>) -> Result<(), &'static str> {
        self.check(state)?;
        self.state.clone_from(state);
        self.derive_from_state();
        Ok(())
    }

    /// Derives events, last ticks of nodes, moving blocks, neighbour list and step range from the state.
    pub(super) fn derive_from_state(&mut self) {
        let state = &self.state;
        let queued = self.rules.schedule == SteppingSchedule::Queue && state.now.is_some();
        self.queue = EventQueue::new(if queued { &state.alarms } else { &[] });
        self.quiet_until = None;
        if let Some(blocks) = &mut self.blocks {
            let (rest, zero) = (self.gel.potential.rest(), Vector::<D>::zeros());
            let moves = |node: usize| state.velocity[node] != zero || state.position[node] != rest[node];
            blocks.is_prestrained = self.gel.potential.remembers() && self.origin > 0;
            blocks.reset(&state.clocks, self.grid, moves);
            blocks.load_history(&self.order, &state.memory);
        }
        let max_speed = |chunk: &[Vector<D>]| chunk.iter().map(Vector::<D>::norm_squared).fold(0.0, f64::max).sqrt();
        let speeds: Vec<f64> = state.velocity.chunks(RUN).map(max_speed).collect();
        let now = self.grid.time(state.now.unwrap_or(self.origin));
        self.derive_last_ticks();
        let place = |node: usize| embed(&self.position_at(NodeId(node as u32), now));
        self.watch = NeighbourList::new(&self.gel.surface, (now, speeds), place);
        self.placed = false;
        self.update_step_range();
    }

    /// Derives the last tick of each node: the latest tick of the groups at the node.
    fn derive_last_ticks(&mut self) {
        let (state, order, gel, all) = (&self.state, &self.order, &self.gel, &mut self.last);
        let now = state.now.unwrap_or(self.origin);
        let last = |group: usize| match self.rules.schedule {
            SteppingSchedule::Bins => now & !state.clocks[group].step.saturating_sub(1),
            SteppingSchedule::Queue => state.alarms[group].last,
            SteppingSchedule::Global => state.alarms[0].last,
        };
        all.fill(self.origin);
        let mut visit = |tick: Tick, node: &NodeId| all[node.index()] = tick.max(all[node.index()]);
        let of_group = |group: usize| {
            order
                .elements(order.slots(group))
                .flat_map(|element| gel.potential.nodes(element))
                .map(move |node| (group, node))
        };
        let Some(blocks) = &self.blocks else {
            return (0..state.clocks.len()).flat_map(of_group).for_each(|(group, node)| visit(last(group), node));
        };
        // Where all groups of a block have one step, each node is visited once instead of once per element.
        let (uniform, mixed): (Vec<_>, Vec<_>) =
            blocks.all.iter().enumerate().partition(|(_, block)| block.steps.0 == block.steps.1);
        for (i, block) in uniform {
            block.nodes.iter().for_each(|node| visit(last(i * blocks.groups), node));
        }
        let mixed = mixed.iter().flat_map(|(i, _)| blocks.groups_of(*i));
        mixed.flat_map(of_group).for_each(|(group, node)| visit(last(group), node));
    }

    /// Updates the least and the greatest step of any group; blocks store theirs.
    pub(super) fn update_step_range(&mut self) {
        let all = |(least, most): (Tick, Tick), of: (Tick, Tick)| (least.min(of.0), most.max(of.1));
        let none = (Tick::MAX, 0);
        self.steps = match &self.blocks {
            Some(blocks) => blocks.all.iter().map(|block| block.steps).fold(none, all),
            None => self.state.clocks.iter().map(|clock| (clock.step, clock.step)).fold(none, all),
        };
    }

    /// Returns the longest step of a group, ticks.
    pub(super) fn longest_step(&self) -> Tick {
        self.steps.1
    }

    /// Replaces a body's state or wrench at its own time, as an event; the caller posts the change to the ledger.
    pub fn set_body(&mut self, body: usize, state: &BodyState) {
        self.state.bodies[body] = *state;
        (self.quiet_until, self.placed) = (None, false);
    }

    /// Returns the ledger, to post changes of a body from outside.
    pub fn ledger_mut(&mut self) -> &mut Ledger {
        &mut self.state.ledger
    }

    /// Moves a body to time `t`, s, as an event and posts the work of its wrench.
    pub fn rebase_body(&mut self, body: usize, t: f64) {
        let (fixed, state) = (&self.bodies[body], &mut self.state.bodies[body]);
        let next = state.at(fixed, t);
        state.passage(fixed, &next).post(&mut self.state.ledger);
        *state = next;
    }

    /// Returns the position of a node drifted to time `t`, m.
    #[must_use]
    pub fn position_at(&self, node: NodeId, t: f64) -> Vector<D> {
        let a = node.index();
        self.state.position[a] + self.state.velocity[a] * (t - self.grid.time(self.last[a]))
    }

    /// Returns the velocity of a node before the kicks of this tick, m/s.
    pub(super) fn velocity_before(&self, node: NodeId) -> Vector<D> {
        let a = node.index();
        if self.scratch.active.has(a) { self.scratch.before[a] } else { self.state.velocity[a] }
    }
}

/// Builds the blocks of the SIMD form; `None` where only the reference form applies.
fn element_blocks<const D: usize, P: Potential<D>>(
    gel: &DiscreteGel<D, P>,
    order: &ElementLayout,
    rules: &IntegratorSettings,
) -> Option<ElementBlocks<D>> {
    let fast = rules.law != ImpulseLaw::Reversal && rules.schedule != SteppingSchedule::Queue;
    fast.then(|| ElementBlocks::new(gel, order)).flatten()
}

/// Returns the clocks of groups that have not begun, with their initial energies.
fn initial_clocks<const D: usize, P: Potential<D>>(
    gel: &DiscreteGel<D, P>,
    order: &ElementLayout,
    measured: &ElementStates,
) -> Vec<GroupClock> {
    let crushed = |element: &ElementId| gel.potential.is_crushed(measured.jacobian[element.index()]);
    let clock = |group: usize| GroupClock {
        energy: order.patches(group).iter().map(|patch| measured.energy[*patch as usize]).sum::<f64>() + 0.0,
        crushed: order.elements(order.slots(group)).filter(crushed).count() as u32,
        ..GroupClock::default()
    };
    (0..order.n_groups()).map(clock).collect()
}
