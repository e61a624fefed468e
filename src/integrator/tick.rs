//! One tick of the integrator: drift, forces, kick, step sizes, contact, energy balance (numerics 1.6).
//!
//! A tick ends one step of every active group and begins the next. In the leapfrog (Störmer–Verlet) scheme the kick of
//! an active group therefore has two halves, both with the forces at this tick: the trailing half belongs to the step
//! that ends, the leading half to the step that begins. Groups that are not active neither move nor push.

use super::StepError;
use super::blocks::ElementBlocks;
use super::element_loop::{ElementLoopInput, MIN_SHARED_ELEMENTS, is_failure};
use super::engine::Engine;
use super::handover::AdvanceOutcome;
use super::neighbour_list::STRETCH;
use super::node_loop::KickSums;
use super::schedule::SteppingSchedule;
use super::substep::{MeshPhase, TickContext};
use crate::contact::{BodyState, ImpulseExchange};
use crate::fem::Potential;
use crate::mesh::ElementId;
use crate::state::Tick;

/// Reason why the engine has stopped advancing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AdvanceOutcome {
    /// The requested end time is reached.
    End,
    /// The mesh was distorted or due and has ended at a tick: positions and velocities are those of this instant.
    Worn,
}

/// Largest angle that a tumbling body turns by in one step of its orientation, rad. At 0.05 the axis of a rod that
/// spins at 20 000 rad/s and nods by 25° is off by 0.005° after a millisecond; at the steps of a coarse gel (1.2) by
/// 2.5°.
const MAX_TURN: f64 = 0.05;
/// Longest step of the orientation, ticks. It bounds how long a body under torque keeps its angular velocity.
const MAX_TURN_PERIOD: f64 = 4096.0;

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Processes all ticks up to time `t`, s, or until the mesh must be replaced, and adds the impulse and work that
    /// each body received to its `exchange`.
    ///
    /// # Panics
    /// Unless every body has its exchange.
    ///
    /// # Errors
    /// [`StepError`] when the mesh or the numbers fail.
    pub fn advance_to(&mut self, t: f64, exchanges: &mut [ImpulseExchange]) -> Result<AdvanceOutcome, StepError> {
        assert_eq!(exchanges.len(), self.bodies.len(), "every body has its exchange");
        // The whole loop runs on the pool, so that its threads are entered once and not at every tick.
        let shares = !self.is_at_rest() && self.is_worth_sharing() && self.has_tick_until(t);
        let reached = match self.pool.clone().filter(|_| shares) {
            Some(pool) => pool.lead(|| self.process_ticks(t, exchanges)),
            None => self.process_ticks(t, exchanges),
        };
        self.store_history();
        reached
    }

    /// Returns true if a group is active at some tick up to time `t`, s.
    fn has_tick_until(&self, t: f64) -> bool {
        let next = self.state.now.map_or(Some(self.origin), |now| self.next_tick(now));
        next.is_some_and(|next| next <= self.grid.last_tick(t))
    }

    /// Returns true if the moving blocks have enough elements to share a full tick among threads.
    pub(super) fn is_worth_sharing(&self) -> bool {
        let Some(blocks) = &self.blocks else { return false };
        let awake = blocks.all.iter().filter(|block| block.is_moving()).map(|block| block.n_elements).sum::<u64>();
        awake > MIN_SHARED_ELEMENTS
    }

    /// Processes all events up to time `t`, s, or until the mesh ends.
    fn process_ticks(&mut self, t: f64, exchanges: &mut [ImpulseExchange]) -> Result<AdvanceOutcome, StepError> {
        let end = self.grid.last_tick(t);
        if self.is_at_rest() {
            return self.fly(end);
        }
        while let Some(tick) = self.next_event(end).filter(|tick| *tick <= end) {
            self.step_orientations(tick)?;
            let due = self.is_due(tick);
            if due && self.is_over(tick) {
                self.close(tick, (t, exchanges))?;
                return Ok(AdvanceOutcome::Worn);
            }
            self.phase = if self.state.now.is_none() { MeshPhase::First } else { MeshPhase::Between };
            let done = if due { self.process_tick(tick, t, exchanges) } else { Ok(()) };
            self.state.now = Some(tick);
            done?;
            if due && self.find_exits() {
                return self.fly(end);
            }
        }
        // Skipped ticks count as processed.
        if let (Some(now), SteppingSchedule::Bins) = (self.state.now, self.rules.schedule) {
            self.state.now = Some(now.max(end / self.steps.0 * self.steps.0));
        }
        Ok(AdvanceOutcome::End)
    }

    /// Advances the orientation of every body whose orientation step ends at this tick.
    fn step_orientations(&mut self, tick: Tick) -> Result<(), StepError> {
        for body in 0..self.bodies.len() {
            if self.next_orientation_step(body) == Some(tick) {
                self.rebase_body(body, self.grid.time(tick));
                self.check_spin(body, &self.state.bodies[body])?;
            }
        }
        Ok(())
    }

    /// Returns the next tick at which a group is active or an orientation is stepped.
    fn next_event(&mut self, end: Tick) -> Option<Tick> {
        let elements = match self.state.now {
            None => Some(self.origin),
            Some(now) => {
                let from = self.skip_quiet_ticks(now, end);
                self.next_tick(from)
            }
        };
        let turns = (0..self.bodies.len()).filter_map(|body| self.next_orientation_step(body));
        elements.into_iter().chain(turns).min()
    }

    /// Returns the next tick at which a group is active.
    fn next_tick(&self, now: Tick) -> Option<Tick> {
        match self.rules.schedule {
            SteppingSchedule::Bins => Some((now / self.steps.0 + 1) * self.steps.0),
            SteppingSchedule::Global => self.state.alarms.first().map(|alarm| alarm.next),
            SteppingSchedule::Queue => self.queue.next_tick(),
        }
    }

    /// Returns true if groups are active at an event; the other events are orientation steps of bodies.
    fn is_due(&self, tick: Tick) -> bool {
        match self.rules.schedule {
            _ if self.state.now.is_none() => true,
            SteppingSchedule::Bins => tick.is_multiple_of(self.steps.0),
            SteppingSchedule::Queue | SteppingSchedule::Global => self.next_tick(tick) == Some(tick),
        }
    }

    /// Returns the tick after which the next one is searched: `now`, or later while the gel is at rest and no body can
    /// come near. Ticks in between change nothing and are skipped.
    fn skip_quiet_ticks(&mut self, now: Tick, end: Tick) -> Tick {
        let still = |blocks: &ElementBlocks<D>| blocks.all.iter().all(|block| !block.is_moving() && !block.restless);
        if self.rules.schedule != SteppingSchedule::Bins || self.is_loaded() || !self.blocks.as_ref().is_some_and(still)
        {
            self.quiet_until = None;
            return now;
        }
        if !self.placed {
            self.place_bodies_in_list();
        }
        let quiet_until = self.quiet_until.unwrap_or_else(|| {
            let reach = self.watch.reach(&self.bodies, self.horizon() * self.grid.time(1));
            let within = |i: usize| STRETCH * self.gel.surface.nodes[i].size + reach;
            self.grid.last_tick(self.watch.time() + self.watch.quiet_time(&self.bodies, within))
        });
        self.quiet_until = Some(quiet_until);
        if quiet_until <= now {
            self.quiet_until = None;
        }
        // A scheduled remesh takes place also while the gel is at rest.
        let last = self.next_remesh_tick().map_or(end, |due| end.min(due.saturating_sub(1)));
        now.max(quiet_until.min(last))
    }

    /// Moves the bodies of the neighbour list to their last event.
    fn place_bodies_in_list(&mut self) {
        let events = self.state.bodies.iter().map(|body| body.time);
        let time = events.fold(self.watch.time(), f64::max);
        self.place_bodies(time);
        self.watch.go_on(time, &self.scratch.was);
        self.placed = true;
    }

    /// Returns the next tick at which the orientation of a tumbling body is stepped; `None` for other bodies.
    ///
    /// It is the first multiple of a period after the body's last event that has not been processed. The period is the
    /// longest power of two of ticks in which the body turns by at most [`MAX_TURN`].
    pub(super) fn next_orientation_step(&self, body: usize) -> Option<Tick> {
        let now = self.state.now?;
        let (fixed, body) = (&self.bodies[body], &self.state.bodies[body]);
        if !fixed.needs_orientation_steps(body) {
            return None;
        }
        let rate = fixed.angular_velocity(body).norm();
        let longest = self.grid.ticks(MAX_TURN / rate).clamp(1.0, MAX_TURN_PERIOD);
        let period = super::grid::floor_power_of_two(longest) as Tick;
        let last = (self.grid.ticks(body.time).floor() as Tick).max(now);
        Some((last / period + 1) * period)
    }

    /// Processes one tick, phase by phase: drift and forces, kick, step sizes, contact, energy balance.
    ///
    /// The step sizes follow the kick, because the stable limit of a node is summed in the same pass as its forces. The
    /// leading half of the kick takes the planned step; where the step changes, the contact phase first corrects it.
    fn process_tick(&mut self, tick: Tick, t: f64, exchanges: &mut [ImpulseExchange]) -> Result<(), StepError> {
        let time = self.grid.time(tick);
        self.drift_and_evaluate(tick)?;
        let sums = self.kick_by_planned_steps(tick);
        let collapsed = self.choose_steps(tick, &sums);
        let work = self.solve_contact(tick, &sums);
        self.balance_energy(tick, work);
        self.receive(time, (t, exchanges));
        self.requeue_groups();
        self.check_tick(time, collapsed)
    }

    /// Drift and forces: moves the active nodes to this tick with their velocities and evaluates the active elements
    /// there; then finds the pressure loads and the bodies at this time. The SIMD form drifts the copies of the nodes in
    /// the blocks, and the kick pass stores the positions.
    fn drift_and_evaluate(&mut self, tick: Tick) -> Result<(), StepError> {
        let time = self.grid.time(tick);
        self.answer(tick);
        if let Err(error) = self.check_elements(time) {
            self.drift_active(tick);
            return Err(error);
        }
        self.find_loads(tick);
        self.place_bodies(time);
        Ok(())
    }

    /// Kick: trailing half of the step that ends and leading half of the planned next step, in the pass that also
    /// finds the stable limits of the nodes. The reference form finds the limits only and kicks when the steps are
    /// known.
    fn kick_by_planned_steps(&mut self, tick: Tick) -> KickSums {
        if self.blocks.is_some() { self.update_nodes(tick) } else { self.measure_limits() }
    }

    /// Step sizes: sets the next step of each active group from the stable limits and the contact gaps; returns the
    /// error of the first group whose stable step is shorter than a tick.
    fn choose_steps(&mut self, tick: Tick, sums: &KickSums) -> Option<StepError> {
        self.count_global_steps(sums.limit, tick);
        self.query_gaps(tick);
        let groups = self.groups_to_check(tick);
        let collapsed = self.set_clocks(&groups, tick);
        self.scratch.due = groups;
        collapsed
    }

    /// Contact: finds the contact points, completes the kick for the chosen steps and applies the contact impulses;
    /// returns the work of the kicks less the change of the carried kick work, J.
    fn solve_contact(&mut self, tick: Tick, sums: &KickSums) -> f64 {
        self.find_contact_points(tick);
        self.complete_kicks(tick, sums)
    }

    /// Energy balance: posts the integration residual of the active groups and the work of loads and contact to the
    /// ledger.
    fn balance_energy(&mut self, tick: Tick, work: f64) {
        self.post_residual(tick, work);
        self.post_contact_work();
    }

    /// Checks the result of a tick: collapsed steps, spinning bodies, leaks of the contact surface.
    fn check_tick(&mut self, time: f64, collapsed: Option<StepError>) -> Result<(), StepError> {
        match collapsed {
            // A remesh resolves it, as it does inverted elements.
            Some(StepError::StepCollapsed { .. }) if self.can_be_distorted() => {}
            Some(error) => return Err(error),
            None => {}
        }
        self.scratch.now.iter().enumerate().try_for_each(|(body, at)| self.check_spin(body, at))?;
        self.check_stretch(time)
    }

    /// Fails if an active body turns by more than [`MAX_TURN`] in one tick: the gel surface near it would be stepped
    /// at every tick, a thousand times an element step, without following the body.
    pub(super) fn check_spin(&self, body: usize, at: &BodyState) -> Result<(), StepError> {
        let rate = self.bodies[body].angular_velocity(at).norm();
        let turn = rate * self.grid.time(1);
        let follows = turn <= MAX_TURN || !at.active;
        if follows { Ok(()) } else { Err(StepError::Spun { body, time: at.time, rate, turn, most: MAX_TURN }) }
    }

    /// Evaluates the forces of the active elements at their drifted nodes, by blocks or by the reference form.
    pub(super) fn answer(&mut self, tick: Tick) {
        let moment = self.tick_context(tick);
        let Some(blocks) = &mut self.blocks else {
            self.find_active_groups(tick);
            self.set_trailing_weights(tick);
            self.drift_group_nodes(tick);
            return self.evaluate_forces(tick);
        };
        let input = ElementLoopInput {
            moment,
            grid: self.grid,
            position: &self.state.position,
            velocity: &self.state.velocity,
            rest: self.gel.potential.rest(),
            last: &self.last,
            clocks: &self.state.clocks,
            order: &self.order,
        };
        let n_elements = blocks.find_active(&input);
        let (stiffness, answers) = (self.state.stiffness.as_mut_slice(), self.scratch.answers.as_mut_slice());
        let pool = self.pool.as_deref().filter(|_| n_elements > MIN_SHARED_ELEMENTS);
        blocks.sweep(&input, stiffness, answers, pool);
        self.find_active();
    }

    /// Lists the active groups in ascending order (reference form).
    fn find_active_groups(&mut self, tick: Tick) {
        let moment = self.tick_context(tick);
        let due = &mut self.scratch.due;
        due.clear();
        if self.rules.schedule == SteppingSchedule::Queue && tick > 0 {
            self.queue.pop_at(tick, due);
            return;
        }
        let active = self.state.clocks.iter().zip(0..).filter(|(clock, _)| moment.fires(clock.step));
        due.extend(active.map(|(_, group)| group));
    }

    /// Completes the kicks of a tick and solves contact, by blocks or by the reference form; returns the work of the
    /// kicks less the change of the carried kick work, J.
    pub(super) fn complete_kicks(&mut self, tick: Tick, sums: &KickSums) -> f64 {
        if self.blocks.is_some() {
            return self.kick_fast(tick, sums);
        }
        self.add_leading_weights(tick);
        self.kick_and_solve_contact(tick);
        self.note_speeds();
        self.kick_work()
    }

    /// Adds the leading half of the next step to the kick weight of each active group, s (reference form).
    fn add_leading_weights(&mut self, tick: Tick) {
        for i in 0..self.scratch.due.len() {
            let ahead = self.grid.time(self.ahead(self.scratch.due[i] as usize, tick));
            self.scratch.weights[i] += 0.5 * ahead;
        }
    }

    /// Returns the fraction of a kick that belongs to the next step.
    pub(super) fn leading_share(&self) -> f64 {
        self.tick_context(0).leading_share()
    }

    /// Returns the context of a tick: its place in the life of the mesh.
    pub(super) fn tick_context(&self, tick: Tick) -> TickContext {
        TickContext { tick, origin: self.origin, kind: self.rules.schedule, phase: self.phase }
    }

    /// Returns the ticks from this tick until a group that is active now is active again.
    pub(super) fn ahead(&self, group: usize, tick: Tick) -> Tick {
        match self.rules.schedule {
            SteppingSchedule::Queue => self.state.alarms[group].next - tick,
            SteppingSchedule::Bins | SteppingSchedule::Global => {
                self.tick_context(tick).ahead(self.state.clocks[group].step)
            }
        }
    }

    /// Sets the kick weight of each active group to the trailing half of its last step, s (reference form).
    fn set_trailing_weights(&mut self, tick: Tick) {
        let owed = self.scratch.due.iter().map(|group| self.owed(*group as usize, tick));
        let owed: Vec<f64> = owed.collect();
        self.scratch.weights.clear();
        self.scratch.weights.extend(owed);
    }

    /// Moves the bodies to a time, s, as they are before the impulses of the tick.
    pub(super) fn place_bodies(&mut self, time: f64) {
        let scratch = &mut self.scratch;
        scratch.was.clear();
        scratch.was.extend(self.bodies.iter().zip(&self.state.bodies).map(|(body, last)| last.at(body, time)));
        scratch.now.clone_from(&scratch.was);
    }

    /// Fails if an element is inverted for the second tick in a row or its energy is not a number; only the drift has
    /// taken place then. With remeshing an inverted element is tolerated: it ends its mesh as soon as the mesh may
    /// end.
    fn check_elements(&self, time: f64) -> Result<(), StepError> {
        match self.find_failure(time) {
            Some(StepError::Inverted { .. }) if self.can_be_distorted() => Ok(()),
            failure => failure.map_or(Ok(()), Err),
        }
    }

    /// Finds the failed element of this tick, if any.
    pub(super) fn find_failure(&self, time: f64) -> Option<StepError> {
        let fails = |group: &usize| is_failure(&self.state.clocks[*group], &self.scratch.answers[*group]);
        let failed = match &self.blocks {
            Some(blocks) => blocks.all.iter().filter_map(|block| block.report?.failed_group).max_by_key(|group| {
                // An energy that is not a number is reported before an inverted element.
                (!self.scratch.answers[*group].energy.is_finite(), std::cmp::Reverse(*group))
            }),
            None => self.scratch.due.iter().map(|group| *group as usize).find(fails),
        };
        failed.map(|group| self.describe_failure(group, time))
    }

    /// Describes the failure of a group: which element, inverted or not finite.
    fn describe_failure(&self, group: usize, time: f64) -> StepError {
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

    /// Returns the active groups to the event queue and updates the range of steps if steps changed.
    fn requeue_groups(&mut self) {
        if self.rules.schedule == SteppingSchedule::Queue {
            for group in &self.scratch.due {
                self.queue.push(*group, self.state.alarms[*group as usize].next);
            }
        }
        if !self.scratch.changed.is_empty() {
            self.update_step_range();
        }
    }

    /// Returns true if an element was active at this tick; valid after the clocks were set.
    pub(super) fn was_active(&self, element: ElementId, tick: Tick) -> bool {
        let group = self.order.group(element);
        match self.rules.schedule {
            SteppingSchedule::Queue => self.state.alarms[group].last == tick,
            _ => self.tick_context(tick).fires(self.state.clocks[group].step),
        }
    }
}
