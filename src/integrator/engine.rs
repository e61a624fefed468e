//! Engine: a gel and rigid bodies in time, as the rooms above see them.

use super::assemble::{Carryover, assemble, use_reference_form};
use super::events::{AdvanceOutcome, process_ticks};
use super::report::BalanceReference;
use super::settings::{IntegratorSettings, UnusableStep};
use super::system::DiscreteSystem;
use super::{
    BalanceTotals, BlockLayout, BlockMotion, DiscreteGel, DistortionLimits, ExitRule, GelFrame, StepError, TickGrid,
    WorkerPool, admissible, derived, energy_correction, handover, layout_stats, mesh_end, report,
};
use crate::contact::{BodyState, ImpulseExchange, RigidBody};
use crate::fem::{ElementBatches, ElementStates, HistoryVariables, Potential};
use crate::ledger::Ledger;
use crate::math::Vector;
use crate::mesh::{ElementId, NodeId};
use crate::state::{DynamicState, MeshInstance, SurfaceStretch, Tick};
use std::sync::Arc;

/// Integrator of a gel and rigid bodies in time.
#[derive(Debug)]
pub struct Engine<const D: usize, P> {
    pub(super) system: DiscreteSystem<D, P>,
    /// Energy and momentum at the start, the reference of the balances.
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
        settings: IntegratorSettings,
        nodes: Vec<(Vector<D>, Vector<D>)>,
    ) -> Self {
        Self::try_new(gel, bodies, settings, nodes).unwrap_or_else(|error| panic!("{error}"))
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
        settings: IntegratorSettings,
        nodes: Vec<(Vector<D>, Vector<D>)>,
    ) -> Result<Self, UnusableStep> {
        let carryover = Carryover::at_start(bodies.len());
        let (system, _) = assemble(gel, settings, bodies, nodes, carryover)?;
        let start = BalanceReference::of(&system.model.gel, &system.model.bodies, &system.state);
        Ok(Self { system, start })
    }

    /// Selects the reference form of every phase, which processes one element after the other.
    #[must_use]
    pub fn with_reference_form(mut self) -> Self {
        use_reference_form(&mut self.system);
        self
    }

    /// Disables the skipping of blocks at rest; results do not depend on it.
    #[must_use]
    pub fn with_sweeps_at_rest(mut self) -> Self {
        if let Some(blocks) = &mut self.system.blocks {
            blocks.never_rest = true;
        }
        self
    }

    /// Selects a SIMD level other than the widest of the machine; results do not depend on it.
    #[must_use]
    pub fn with_simd_level(mut self, level: fearless_simd::Level) -> Self {
        if let Some(blocks) = &mut self.system.blocks {
            blocks.level = level;
        }
        self
    }

    /// Shares elements and nodes among the threads of a pool; results do not depend on it.
    #[must_use]
    pub fn with_pool(mut self, pool: Option<Arc<WorkerPool>>) -> Self {
        self.system.pool = pool;
        self
    }

    /// Returns the thread pool.
    #[must_use]
    pub fn pool(&self) -> Option<Arc<WorkerPool>> {
        self.system.pool.clone()
    }

    /// Takes the thread pool out, for another engine.
    pub fn take_pool(&mut self) -> Option<Arc<WorkerPool>> {
        self.system.pool.take()
    }

    /// Returns the state.
    #[must_use]
    pub fn state(&self) -> &DynamicState<D> {
        &self.system.state
    }

    /// Returns the constant properties of the bodies.
    #[must_use]
    pub fn bodies(&self) -> &[RigidBody] {
        &self.system.model.bodies
    }

    /// Returns the gel, the constant part of the model.
    #[must_use]
    pub fn gel(&self) -> &DiscreteGel<D, P> {
        &self.system.model.gel
    }

    /// Returns the grid of ticks.
    #[must_use]
    pub fn grid(&self) -> &TickGrid {
        &self.system.model.grid
    }

    /// Checks that a state can belong to this engine.
    ///
    /// # Errors
    /// The contradiction found.
    pub fn check(&self, state: &DynamicState<D>) -> Result<(), &'static str> {
        admissible::check(&self.system, state)
    }

    /// Checks that a state can have reached time `t`, s: at most its longest step after its last tick, and so its
    /// bodies.
    ///
    /// # Errors
    /// The contradiction found.
    pub fn check_time(&self, state: &DynamicState<D>, t: f64) -> Result<(), &'static str> {
        admissible::check_time(&self.system, state, t)
    }

    /// Continues from another state of the same gel.
    ///
    /// # Errors
    /// The contradiction that [`Engine::check`] finds; nothing is changed then.
    pub fn restore(&mut self, state: &DynamicState<D>) -> Result<(), &'static str> {
        self.check(state)?;
        self.system.state.clone_from(state);
        derived::derive_from_state(&mut self.system);
        Ok(())
    }

    /// Processes all ticks up to time `t`, s, or until the mesh must be replaced, and adds the impulse and work that
    /// each body received to its `exchange`.
    ///
    /// # Panics
    /// Unless every body has its exchange.
    ///
    /// # Errors
    /// [`StepError`] when the mesh or the numbers fail.
    pub fn advance_to(&mut self, t: f64, exchanges: &mut [ImpulseExchange]) -> Result<AdvanceOutcome, StepError> {
        self.advance_part(t, t, exchanges)
    }

    /// Processes the ticks up to time `until`, s, of an exchange that ends at time `end`, s; see
    /// [`Engine::advance_to`].
    ///
    /// # Panics
    /// Unless every body has its exchange.
    ///
    /// # Errors
    /// [`StepError`] when the mesh or the numbers fail.
    pub fn advance_part(
        &mut self,
        until: f64,
        end: f64,
        exchanges: &mut [ImpulseExchange],
    ) -> Result<AdvanceOutcome, StepError> {
        let system = &mut self.system;
        assert_eq!(exchanges.len(), system.model.bodies.len(), "every body has its exchange");
        // The whole loop runs on the pool, so that its threads are entered once and not at every tick.
        let shares = !system.is_at_rest() && system.is_worth_sharing() && super::events::has_tick_until(system, until);
        let reached = match system.pool.clone().filter(|_| shares) {
            Some(pool) => pool.run(|| process_ticks(system, until, end, exchanges)),
            None => process_ticks(system, until, end, exchanges),
        };
        if let Some(blocks) = &mut system.blocks {
            blocks.store_unsaved_history(&system.model.layout, &mut system.state.memory);
        }
        reached
    }

    /// Replaces a body's state or wrench at its own time, as an event; the caller posts the change to the ledger.
    pub fn set_body(&mut self, body: usize, state: &BodyState) {
        self.system.state.bodies[body] = *state;
        (self.system.clock.quiet_until, self.system.contact.knows_bodies) = (None, false);
    }

    /// Moves a body to time `t`, s, as an event and posts the work of its wrench.
    pub fn rebase_body(&mut self, body: usize, t: f64) {
        self.system.rebase_body(body, t);
    }

    /// Returns the ledger, to post changes of a body from outside.
    pub fn ledger_mut(&mut self) -> &mut Ledger {
        &mut self.system.state.ledger
    }

    /// Returns the position of a node drifted to time `t`, m.
    #[must_use]
    pub fn position_at(&self, node: NodeId, t: f64) -> Vector<D> {
        self.system.position_at(node, t)
    }

    /// Returns the last tick that was processed.
    #[must_use]
    pub fn last_tick(&self) -> Tick {
        self.system.last_tick()
    }

    /// Returns the time of the last tick, s.
    #[must_use]
    pub fn now(&self) -> f64 {
        self.system.now()
    }

    /// Returns true if the gel is no longer integrated.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.system.is_at_rest()
    }

    /// Returns the time of the gel at a time, s: that of its last tick once it is at rest.
    #[must_use]
    pub fn time_in_gel(&self, t: f64) -> f64 {
        self.system.time_in_gel(t)
    }

    /// Sets the exit rule of the gel.
    pub fn set_exits(&mut self, exits: Option<ExitRule>) {
        self.system.clock.ends.exits = exits;
    }

    /// Sets the time from the exit of the projectile until the gel is put to rest, s; infinite if it never is.
    pub fn set_rest_after(&mut self, time: f64) {
        if let Some(rule) = &mut self.system.clock.ends.exits {
            rule.rest_after = time;
        }
    }

    /// Sets the frame of the block, in which exits and depths are measured; without it that is the world.
    pub fn set_frame(&mut self, frame: GelFrame) {
        self.system.model.frame = frame;
    }

    /// Returns the frame of the block.
    #[must_use]
    pub fn frame(&self) -> &GelFrame {
        &self.system.model.frame
    }

    /// Returns the rigid motion of the block at a time, s, not before the last tick.
    #[must_use]
    pub fn block_motion(&self, t: f64) -> BlockMotion {
        self.system.block_motion(t)
    }

    /// Returns true if a body at this state no longer meets the gel.
    #[must_use]
    pub fn is_body_away(&self, body: usize, at: &BodyState) -> bool {
        self.system.body_exit(body, at).is_away()
    }

    /// Sets the distortion limits of the mesh, if any. The queue ignores them.
    pub fn set_distortion_limits(&mut self, limits: Option<DistortionLimits>) {
        self.system.clock.ends.distortion = limits;
        self.system.contact.neighbours.clear_parts();
    }

    /// Sets the times, s, ascending, at which the mesh ends, distorted or not. It ends at the first tick from a time
    /// on at which all steps end and the mesh is 4 of its finest steps old. The queue ignores the times.
    pub fn set_remesh_times(&mut self, times: &[f64]) {
        self.system.clock.ends.at = times.iter().map(|time| self.grid().first_tick(*time)).collect();
    }

    /// Returns the failure at the last tick of an ended mesh, if any; the run ends with it unless another mesh
    /// follows.
    #[must_use]
    pub fn failure(&self) -> Option<&StepError> {
        self.system.clock.failure.as_ref()
    }

    /// Returns the step collapse or leak that has ended a young mesh: the next one would fare no better. Age counts
    /// the finest step at its start.
    #[must_use]
    pub fn early_failure(&self) -> Option<&StepError> {
        mesh_end::early_failure(&self.system)
    }

    /// Iterates over the stiffest elements around the nodes whose stable step is shorter than a tick.
    pub fn stepless(&self) -> impl Iterator<Item = ElementId> + '_ {
        mesh_end::stepless(&self.system)
    }

    /// Creates an engine that continues with another gel from the end of this one, with its nodes at these positions
    /// and velocities. The changes of energy, momentum and angular momentum are booked. `birth` is the new mesh and
    /// is given the steps with which it begins. The thread pool stays here.
    ///
    /// # Errors
    /// [`UnusableStep`] if a step of the new mesh is no valid step.
    pub fn continue_on_mesh(
        &self,
        gel: DiscreteGel<D, P>,
        memory: Option<Vec<HistoryVariables<D>>>,
        nodes: Vec<(Vector<D>, Vector<D>)>,
        birth: Option<MeshInstance<D>>,
    ) -> Result<Self, UnusableStep> {
        let system = handover::continue_on_mesh(&self.system, gel, memory, nodes, birth)?;
        Ok(Self { system, start: self.start })
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
        let system = handover::system_on_mesh(&self.system, gel, position, birth)?;
        Ok(Self { system, start: self.start })
    }

    /// Counts a remesh.
    pub fn count_remesh(&mut self) {
        self.system.state.record.stretch = SurfaceStretch::Little;
        self.system.state.record.remeshes += 1;
    }

    /// Counts eroded mass, kg.
    pub fn count_eroded_mass(&mut self, mass: f64) {
        self.system.state.record.eroded_mass += mass;
    }

    /// Gives an energy, J, to the motion of the free nodes of these elements, each with its mass, kg, and books it as
    /// `remesh`.
    pub fn return_energy(&mut self, made: &[(ElementId, f64)], energy: f64) {
        energy_correction::return_energy(&mut self.system, made, energy);
    }

    /// Returns energies, momenta and closures at time `t`, s.
    #[must_use]
    pub fn totals(&self, t: f64) -> BalanceTotals {
        report::totals(&self.system, &self.start, t)
    }

    /// Returns the present step of each patch, s; before the first tick the stable one.
    #[must_use]
    pub fn steps(&self) -> Vec<f64> {
        report::steps(&self.system)
    }

    /// Returns the stable step of each element by itself, not rounded to the steps of the schedule, s (method 1.3).
    #[must_use]
    pub fn stable_steps(&self) -> Vec<f64> {
        report::element_stable_steps(&self.system)
    }

    /// Returns the greatest frequency that is stable with this step, 1/s: 2 CFL over the step.
    #[must_use]
    pub fn frequency_of_step(&self, step: f64) -> f64 {
        2.0 * self.system.model.settings.cfl / step
    }

    /// Returns the elements whose own frequency exceeds a limit, 1/s: the square root of (D + 1) κ/m for their masses m,
    /// kg.
    #[must_use]
    pub fn elements_above(&self, frequency: f64, mass: impl Fn(usize) -> f64) -> Vec<ElementId> {
        let system = &self.system;
        let stiffness = |element| system.state.stiffness[system.model.layout.slot(element)];
        let is_above =
            |element: &ElementId| (D + 1) as f64 * stiffness(*element) > frequency * frequency * mass(element.index());
        (0..system.model.gel.potential.len() as u32).map(ElementId).filter(is_above).collect()
    }

    /// Returns the present step of an element, ticks.
    #[must_use]
    pub fn step_of(&self, element: ElementId) -> Tick {
        self.system.state.clocks[self.system.model.layout.group(element)].step
    }

    /// Evaluates the elements with the nodes at their positions at time `t`, s.
    #[must_use]
    pub fn measure_at(&self, t: f64) -> ElementStates {
        report::measure_at(&self.system, t)
    }

    /// Returns the bytes that a gel of this size takes in the engine: elements, nodes, state and derived data.
    #[must_use]
    pub fn bytes(&self) -> usize {
        report::bytes(&self.system)
    }

    /// Returns the number of element updates that one global stable step of the assembled system would have cost up
    /// to time `t`, s.
    #[must_use]
    pub fn synchronous_updates(&self, t: f64) -> f64 {
        let (reference, ticks) = (self.system.state.record.synchronous, self.grid().ticks(self.time_in_gel(t)));
        report::synchronous_until(reference, ticks, self.gel().potential.len())
    }

    /// Returns the blocks of the SIMD form, in order; empty for the reference form.
    #[must_use]
    pub fn block_layouts(&self) -> Vec<BlockLayout<'_>> {
        layout_stats::block_layouts(self.system.blocks.as_ref())
    }

    /// Returns the elements of the blocks in SIMD layout.
    #[must_use]
    pub fn lanes(&self) -> Option<&ElementBatches<D>> {
        self.system.blocks.as_ref().map(|blocks| &blocks.lanes)
    }
}
