//! The three-phase tick: drift the nodes that fire, kick them by their elements, then one contact solve (numerics 1.6).

use super::StepError;
use super::blocks::Blocks;
use super::element_loop::{SHARED, Sweep, fails};
use super::engine::Engine;
use super::handover::Reached;
use super::neighbour_list::STRETCH;
use super::node_loop::NodeSums;
use super::schedule::Kind;
use super::substep::{Moment, Phase};
use crate::contact::{BodyState, Exchange};
use crate::fem::Potential;
use crate::mesh::ElementId;
use crate::state::Tick;

/// Angle that a tumbling body may turn by in one step of its orientation, rad: at 0.05 the axis of a rod that spins at
/// 20 000 rad/s and nods by 25° is off by 0.005° after a millisecond; at the steps of a coarse gel (1.2) it was 2.5°.
const TURN: f64 = 0.05;
/// Longest step of the orientation, ticks: a body under torque must not stay at its first angular velocity for ever.
const LONGEST_TURN: f64 = 4096.0;

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Processes all ticks up to time `t`, s, or until the mesh is worn or due, and adds what each body received to its `exchange`.
    ///
    /// # Panics
    /// Unless every body has its exchange.
    ///
    /// # Errors
    /// [`StepError`] when the mesh or the numbers fail.
    pub fn advance_to(&mut self, t: f64, exchanges: &mut [Exchange]) -> Result<Reached, StepError> {
        assert_eq!(exchanges.len(), self.bodies.len(), "every body has its exchange");
        // Forked on the pool, work is not handed over from outside at every tick.
        let shares = !self.is_at_rest() && self.is_busy() && self.has_ticks(t);
        let reached = match self.pool.clone().filter(|_| shares) {
            Some(pool) => pool.lead(|| self.process((t, exchanges))),
            None => self.process((t, exchanges)),
        };
        self.recall();
        reached
    }

    /// Whether a group fires up to time `t`, s.
    fn has_ticks(&self, t: f64) -> bool {
        let next = self.state.now.map_or(Some(self.origin), |now| self.next_tick(now));
        next.is_some_and(|next| next <= self.grid.last_tick(t))
    }

    /// Whether a tick at which everything fires is shared among threads.
    pub(super) fn is_busy(&self) -> bool {
        let Some(blocks) = &self.blocks else { return false };
        let awake = blocks.all.iter().filter(|block| block.is_awake()).map(|block| block.n_elements).sum::<u64>();
        awake > SHARED
    }

    /// All ticks up to time `t`, s, or until the mesh ends.
    fn process(&mut self, (t, exchanges): (f64, &mut [Exchange])) -> Result<Reached, StepError> {
        let end = self.grid.last_tick(t);
        if self.is_at_rest() {
            return self.fly(end);
        }
        while let Some(tick) = self.next_event(end).filter(|tick| *tick <= end) {
            for body in 0..self.bodies.len() {
                if self.next_turn(body) == Some(tick) {
                    self.rebase_body(body, self.grid.time(tick));
                    self.check_spin(body, &self.state.bodies[body])?;
                }
            }
            let due = self.is_due(tick);
            if due && self.is_over(tick) {
                self.close(tick, (t, exchanges))?;
                return Ok(Reached::Worn);
            }
            self.phase = if self.state.now.is_none() { Phase::First } else { Phase::Between };
            let done = if due { self.tick(tick, (t, exchanges)) } else { Ok(()) };
            self.state.now = Some(tick);
            done?;
            if due && self.find_exits() {
                return self.fly(end);
            }
        }
        // Ticks that were skipped have been processed, too.
        if let (Some(now), Kind::Bins) = (self.state.now, self.rules.schedule) {
            self.state.now = Some(now.max(end / self.steps.0 * self.steps.0));
        }
        Ok(Reached::End)
    }

    fn next_event(&mut self, end: Tick) -> Option<Tick> {
        let elements = match self.state.now {
            None => Some(self.origin),
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
        let still = |blocks: &Blocks<D>| blocks.all.iter().all(|block| !block.is_awake() && !block.restless);
        if self.rules.schedule != Kind::Bins || self.is_loaded() || !self.blocks.as_ref().is_some_and(still) {
            self.quiet = None;
            return now;
        }
        if !self.placed {
            self.place_watch();
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
        // An exchange of the mesh is no less due where nothing moves.
        let last = self.next_exchange().map_or(end, |due| end.min(due.saturating_sub(1)));
        now.max(quiet.min(last))
    }

    /// Tells the gap clocks where the bodies are at their last event.
    fn place_watch(&mut self) {
        let events = self.state.bodies.iter().map(|body| body.time);
        let time = events.fold(self.watch.time(), f64::max);
        self.place_bodies(time);
        self.watch.go_on(time, &self.scratch.was);
        self.placed = true;
    }

    /// The next tick at which the orientation of a body that tumbles is stepped: the first multiple of its period after
    /// the body's last event that has not been processed. The period is the longest power of two of ticks in which the
    /// body turns by no more than [`TURN`].
    pub(super) fn next_turn(&self, body: usize) -> Option<Tick> {
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
        if let Err(error) = self.check_elements(time) {
            self.drift_active(tick);
            return Err(error);
        }
        self.find_loads(tick);
        self.place_bodies(time);
        let sums = if self.blocks.is_some() { self.advance_nodes(tick) } else { self.measure_limits() };
        self.count_synchronous(sums.limit, tick);
        self.look_around(tick);
        let groups = self.attentive(tick);
        let collapsed = self.set_clocks(&groups, tick);
        self.scratch.due = groups;
        self.find_touches(tick);
        let work = self.kick_all(tick, &sums);
        self.book(tick, work);
        self.book_contact();
        self.receive(time, (t, exchanges));
        self.reschedule();
        match collapsed {
            // As what is inverted.
            Some(StepError::StepCollapsed { .. }) if self.can_wear() => {}
            Some(error) => return Err(error),
            None => {}
        }
        self.scratch.now.iter().enumerate().try_for_each(|(body, at)| self.check_spin(body, at))?;
        self.check_leaks(time)
    }

    /// A body that turns by more than [`TURN`] in a tick ends the run: the surface of the gel near it would be stepped at every
    /// tick, a thousand times an element step, without following it.
    pub(super) fn check_spin(&self, body: usize, at: &BodyState) -> Result<(), StepError> {
        let rate = self.bodies[body].angular_velocity(at).norm();
        let turn = rate * self.grid.time(1);
        let follows = turn <= TURN || !at.active;
        if follows { Ok(()) } else { Err(StepError::Spun { body, time: at.time, rate, turn, most: TURN }) }
    }

    /// What the elements that fire answer, in either form.
    pub(super) fn answer(&mut self, tick: Tick) {
        let moment = self.moment(tick);
        let Some(blocks) = &mut self.blocks else {
            self.find_due(tick);
            self.find_owed(tick);
            self.drift(tick);
            return self.evaluate(tick);
        };
        let sweep = Sweep {
            moment,
            grid: self.grid,
            position: &self.state.position,
            velocity: &self.state.velocity,
            rest: self.gel.potential.rest(),
            last: &self.last,
            clocks: &self.state.clocks,
            order: &self.order,
        };
        let elements = blocks.find_due(&sweep);
        let found = (self.state.stiffness.as_mut_slice(), self.scratch.answers.as_mut_slice());
        blocks.sweep(&sweep, found, (self.pool.as_deref(), elements));
        self.find_active();
    }

    /// The groups that fire, ascending.
    fn find_due(&mut self, tick: Tick) {
        let moment = self.moment(tick);
        let due = &mut self.scratch.due;
        due.clear();
        if self.rules.schedule == Kind::Queue && tick > 0 {
            self.queue.take(tick, due);
            return;
        }
        let firing = self.state.clocks.iter().zip(0..).filter(|(clock, _)| moment.fires(clock.step));
        due.extend(firing.map(|(_, group)| group));
    }

    pub(super) fn kick_all(&mut self, tick: Tick, sums: &NodeSums) -> f64 {
        if self.blocks.is_some() {
            return self.kick_fast(tick, sums);
        }
        self.find_weights(tick);
        self.kick_and_strike(tick);
        self.note_speeds();
        self.work()
    }

    /// The length of the kick of each firing group: half of the step behind and half of the step ahead.
    fn find_weights(&mut self, tick: Tick) {
        for i in 0..self.scratch.due.len() {
            let ahead = self.grid.time(self.ahead(self.scratch.due[i] as usize, tick));
            self.scratch.weights[i] += 0.5 * ahead;
        }
    }

    /// The part of a kick that belongs to the step ahead.
    pub(super) fn share_ahead(&self) -> f64 {
        self.moment(0).share_ahead()
    }

    /// A tick in the life of the mesh.
    pub(super) fn moment(&self, tick: Tick) -> Moment {
        Moment { tick, origin: self.origin, kind: self.rules.schedule, phase: self.phase }
    }

    /// How long a group that fires at this tick will wait, ticks.
    pub(super) fn ahead(&self, group: usize, tick: Tick) -> Tick {
        match self.rules.schedule {
            Kind::Queue => self.state.alarms[group].next - tick,
            Kind::Bins | Kind::Global => self.moment(tick).ahead(self.state.clocks[group].step),
        }
    }

    /// The part of the kick of each firing group that belongs to the step behind, s.
    fn find_owed(&mut self, tick: Tick) {
        let owed = self.scratch.due.iter().map(|group| self.owed(*group as usize, tick));
        let owed: Vec<f64> = owed.collect();
        self.scratch.weights.clear();
        self.scratch.weights.extend(owed);
    }

    pub(super) fn place_bodies(&mut self, time: f64) {
        let scratch = &mut self.scratch;
        scratch.was.clear();
        scratch.was.extend(self.bodies.iter().zip(&self.state.bodies).map(|(body, last)| last.at(body, time)));
        scratch.now.clone_from(&scratch.was);
    }

    /// An element that is inverted for the second tick in a row, or whose energy is not a number, ends the run; nothing but
    /// the drift has happened then. Where meshes are exchanged, what is inverted ends its mesh as soon as that may end.
    fn check_elements(&self, time: f64) -> Result<(), StepError> {
        match self.find_failure(time) {
            Some(StepError::Inverted { .. }) if self.can_wear() => Ok(()),
            failure => failure.map_or(Ok(()), Err),
        }
    }

    /// What fails at this tick.
    pub(super) fn find_failure(&self, time: f64) -> Option<StepError> {
        let fails = |group: &usize| fails(&self.state.clocks[*group], &self.scratch.answers[*group]);
        let failed = match &self.blocks {
            Some(blocks) => blocks.all.iter().filter_map(|block| block.report?.failed).max_by_key(|group| {
                // What is no number is worse than what is inverted.
                (!self.scratch.answers[*group].energy.is_finite(), std::cmp::Reverse(*group))
            }),
            None => self.scratch.due.iter().map(|group| *group as usize).find(fails),
        };
        failed.map(|group| self.diagnosis(group, time))
    }

    /// Which element of a group fails, and how.
    fn diagnosis(&self, group: usize, time: f64) -> StepError {
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
            _ => self.moment(tick).fires(self.state.clocks[group].step),
        }
    }
}
