//! Step size of a patch: the assembled nodal stability rule, hysteresis for longer steps, and limits by contact
//! (numerics 1.3, 1.4, A7, A8).

use super::blocks::{BlockActivity, ElementBlock, StepMonitor};
use super::element_loop::closes;
use super::element_order::ElementLayout;
use super::engine::Engine;
use super::{DiscreteGel, StepError, SteppingSchedule};
use crate::fem::{ElementBatches, FORESEEN, Potential};
use crate::geometry::{Gap, ShapeGeometry};
use crate::math::{Vector3, embed};
use crate::mesh::{ElementId, NodeId};
use crate::state::{GroupAlarm, GroupClock, Tick};

/// Number of a group's own ticks in a row at which [`RAISE_MARGIN`] must hold. Raising sooner pumps energy:
/// per-update adaptation drifted by up to +18000 % in 400 wave transits, this rule by at most 1.2 % (numerics 1.4).
const RAISE_PATIENCE: u32 = 64;
/// Depth up to which a surface node may be found in a body at its next tick, in element sizes (numerics A7).
const MAX_DEPTH: f64 = 0.1;
/// Depth by which a node deeper than [`MAX_DEPTH`] may sink further until its next tick, in element sizes.
const EXTRA_DEPTH: f64 = 0.05;
/// Maximum number of gap queries along a path; the bound proved so far is then taken.
const MAX_QUERIES: usize = 16;

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Updates the cost of one global stable step up to `tick`: its length is the smallest nodal limit so far.
    pub(super) fn count_global_steps(&mut self, limit: f64, tick: Tick) {
        let limit = self.grid.ticks(limit);
        if limit < self.state.record.synchronous.0 {
            self.state.record.synchronous = (limit, tick, self.synchronous_until(tick as f64));
        }
    }

    /// Returns the stable step of a group, ticks.
    pub(super) fn group_limit(&self, group: usize) -> f64 {
        let elements = self.order.elements(self.order.slots(group));
        self.grid.ticks(self.least_limit(elements.flat_map(|element| self.gel.potential.nodes(element))))
    }

    /// Returns the least limit of these nodes, s.
    fn least_limit<'a>(&self, nodes: impl IntoIterator<Item = &'a NodeId>) -> f64 {
        nodes.into_iter().map(|node| self.node_limit(*node)).fold(f64::INFINITY, f64::min)
    }

    /// Collects the active groups whose step may change, ascending: those with a limit below or far above the step,
    /// with a hold count, or near a body.
    pub(super) fn groups_to_check(&mut self, tick: Tick) -> Vec<u32> {
        let mut groups = std::mem::take(&mut self.scratch.due);
        if self.blocks.is_some() {
            groups.clear();
            self.check_blocks(tick, &mut groups);
            self.add_inverting_groups(tick, &mut groups);
            self.add_groups_near_contact(tick, &mut groups);
            groups.sort_unstable();
            groups.dedup();
        }
        groups
    }

    /// Adds the active groups of watched blocks whose step may change.
    fn check_blocks(&mut self, tick: Tick, groups: &mut Vec<u32>) {
        let Some(blocks) = &mut self.blocks else { return };
        let (mut all, mut fronts) = (std::mem::take(&mut blocks.all), std::mem::take(&mut blocks.fronts));
        let mut limits = std::mem::take(&mut self.scratch.limits);
        for (i, (block, front)) in all.iter_mut().zip(&mut fronts).enumerate() {
            let is_watched = front.gives || block.looked_at || block.restless;
            if block.due == BlockActivity::Nothing || !is_watched || front.holds_steps() {
                continue;
            }
            self.collect_limits(block, front.gives, &mut limits);
            // Inactive groups of a block at rest are not checked.
            let must_wait = block.restless && block.due == BlockActivity::Some && !front.gives;
            block.restless = self.collect_changeable_groups(tick, i, &limits, groups) || must_wait;
            if !block.restless {
                self.watch_limits(front, i, block.nodes.len(), &limits);
            }
        }
        self.scratch.limits = limits;
        if let Some(blocks) = &mut self.blocks {
            (blocks.all, blocks.fronts) = (all, fronts);
        }
    }

    /// Sets up the front of a block, none of whose steps may change now, to watch for limits that could change one.
    fn watch_limits(&self, front: &mut StepMonitor, block: usize, n_nodes: usize, limits: &[f64]) {
        let Some(blocks) = &self.blocks else { return };
        front.watch((n_nodes, blocks.groups_of(block), &blocks.lanes), (&self.state.clocks, self.grid), limits);
    }

    /// Adds the active groups of a block whose step may change; returns true if there are any, or if an inactive
    /// group has a hold count.
    fn collect_changeable_groups(&self, tick: Tick, block: usize, limits: &[f64], groups: &mut Vec<u32>) -> bool {
        let Some(blocks) = &self.blocks else { return false };
        let (all, before) = (blocks.groups_of(block), groups.len());
        let is_changeable = |group: &usize| self.may_step_change(tick, *group, &blocks.lanes, limits);
        groups.extend(all.clone().filter(is_changeable).map(|group| group as u32));
        groups.len() > before || self.state.clocks[all].iter().any(|clock| clock.calm > 0)
    }

    /// Returns true if a group is active and its step may change.
    fn may_step_change(&self, tick: Tick, group: usize, lanes: &ElementBatches<D>, limits: &[f64]) -> bool {
        let clock = &self.state.clocks[group];
        if !self.rules.schedule.fires(clock.step, tick) {
            return false;
        }
        let mut limit = f64::INFINITY;
        lanes.nodes(group, |number| limit = limit.min(limits[usize::from(number)]));
        let (limit, step) = (self.grid.ticks(limit), clock.step as f64);
        clock.step == 0 || limit < step || clock.calm > 0 || (limit.is_finite() && limit >= RAISE_MARGIN * step)
    }

    /// Collects the limits of the nodes of a block that can have changed, s; infinite for the others. In an awake
    /// block all nodes of active groups are active. In a block at rest only nodes that are active through another
    /// block can have changed, unless the block may raise a step.
    fn collect_limits(&self, block: &ElementBlock, gives: bool, limits: &mut Vec<f64>) {
        limits.clear();
        if block.restless && !gives {
            limits.extend(block.nodes.iter().map(|node| self.node_limit(*node)));
            return;
        }
        limits.resize(block.nodes.len(), f64::INFINITY);
        for number in block.active_nodes() {
            let a = block.nodes[number].index();
            if self.scratch.active.has(a) {
                limits[number] = self.scratch.limit[a];
            }
        }
    }

    /// Returns CFL · 2/√λ_a of any node, s, from Σ κ of the last sweep of each block around it, as the active nodes
    /// have it.
    fn node_limit(&self, node: NodeId) -> f64 {
        if self.scratch.active.has(node.index()) {
            return self.scratch.limit[node.index()];
        }
        let Some(blocks) = &self.blocks else {
            return self.rules.cfl * nodal_limit(&self.gel, (&self.state.stiffness, &self.order), node);
        };
        let parts = blocks.node_copies(node.index()).iter().map(|spot| blocks.parts[spot.at as usize][3]);
        self.rules.cfl * limit(parts.sum(), self.gel.mass[node.index()])
    }

    /// Adds the active groups in which an element would invert within the present step, if the gel is remeshed. On a
    /// mesh that stays, the kick of a whole step throws an inverted element back. In short steps it is found inverted
    /// twice in a row, which ends the run: the ball of 20 m/s on cells of 2.5 mm stopped so after 0.9 ms.
    fn add_inverting_groups(&self, tick: Tick, groups: &mut Vec<u32>) {
        let Some(blocks) = self.blocks.as_ref().filter(|_| self.can_be_distorted()) else { return };
        let (moment, answers) = (self.tick_context(tick), &self.scratch.answers);
        for (i, _) in
            blocks.all.iter().enumerate().filter(|(_, block)| block.report.is_some_and(|report| report.closes))
        {
            let is_concerned = |group: &usize| {
                let step = self.state.clocks[*group].step;
                moment.fires(step) && closes(&answers[*group], self.grid.time(step))
            };
            groups.extend(blocks.groups_of(i).filter(is_concerned).map(|group| group as u32));
        }
    }

    /// Returns the time until an element of a group inverts at its present rate, ticks; infinite beyond the
    /// look-ahead.
    fn time_to_inversion(&self, group: usize, clock: &GroupClock, tick: Tick) -> f64 {
        let time = self.grid.ticks(1.0 / self.scratch.answers[group].closing);
        let look_ahead = FORESEEN * self.tick_context(tick).elapsed(clock.step) as f64;
        let is_foreseen = self.can_be_distorted() && (clock.step == 0 || time < look_ahead);
        if is_foreseen { time } else { f64::INFINITY }
    }

    /// Adds the active groups around the nodes close to a body whose step contact shortens, or whose hold count it
    /// resets.
    fn add_groups_near_contact(&self, tick: Tick, groups: &mut Vec<u32>) {
        for surface in &self.scratch.close {
            let nearness = &self.scratch.nearness[self.scratch.place[*surface as usize] as usize];
            let is_concerned = |group: &u32| {
                let clock = &self.state.clocks[*group as usize];
                let is_active = self.rules.schedule.fires(clock.step, tick);
                is_active && (nearness.limit < clock.step as f64 || nearness.is_near && clock.calm > 0)
            };
            groups.extend(self.scratch.beside[*surface as usize].groups.iter().copied().filter(is_concerned));
        }
    }

    /// Chooses the next tick of each of these active groups, in ascending order, and lists the changed steps. Returns
    /// the first group whose stable step is less than a tick: that is a thousandth of the smallest at the start, and
    /// the mesh has failed (A11).
    pub(super) fn set_clocks(&mut self, groups: &[u32], tick: Tick) -> Option<StepError> {
        let mut collapsed = None;
        self.scratch.changed.clear();
        for group in groups {
            let (i, was) = (*group as usize, self.state.clocks[*group as usize]);
            let limit = self.group_limit(i);
            if limit < 1.0 && collapsed.is_none() {
                collapsed = Some(self.collapse_error(i, limit, tick));
            }
            let limit = limit.min(self.time_to_inversion(i, &was, tick));
            let (step, calm) = self.apply_hysteresis(limit.max(1.0), &was, tick);
            let (step, is_near) = self.limit_by_contact(i, step);
            let clock = &mut self.state.clocks[i];
            (clock.step, clock.calm) = (step, if is_near { 0 } else { calm });
            let moment = self.tick_context(tick);
            if step != was.step {
                let (planned, ahead) = (moment.ahead(was.step), moment.ahead(step));
                self.scratch.changed.push(StepChange { group: *group, planned, ahead });
            }
            if self.rules.schedule == SteppingSchedule::Queue {
                // In the queue, patches near contact wait for the common multiples of their steps, so that they are
                // active together.
                self.state.alarms[i] =
                    GroupAlarm { last: tick, next: if is_near { (tick / step + 1) * step } else { tick + step } };
            }
        }
        if self.rules.schedule == SteppingSchedule::Global {
            self.equalise_steps(tick);
        }
        collapsed
    }

    /// Sets all steps to the least one, for the global schedule.
    fn equalise_steps(&mut self, tick: Tick) {
        if let Some(StepChange { planned, .. }) = self.scratch.changed.first().copied() {
            let ahead = self.state.clocks.iter().map(|clock| clock.step).filter(|step| *step > 0).min().unwrap_or(1);
            self.state.clocks.iter_mut().for_each(|clock| clock.step = ahead);
            self.scratch.changed.clear();
            let all = 0..self.state.clocks.len() as u32;
            self.scratch.changed.extend(all.map(|group| StepChange { group, planned, ahead }));
        }
        self.state.alarms[0] = GroupAlarm { last: tick, next: tick + self.state.clocks[0].step };
    }

    /// Returns the step collapse of a group, at the element with the least limit.
    pub(super) fn collapse_error(&self, group: usize, limit: f64, tick: Tick) -> StepError {
        let own = |element: &ElementId| self.least_limit(self.gel.potential.nodes(*element));
        let elements = self.order.elements(self.order.slots(group));
        let element = elements.min_by(|a, b| own(a).total_cmp(&own(b))).map_or(0, ElementId::index);
        let (step, time) = (limit * self.grid.time(1), self.grid.time(tick));
        StepError::StepCollapsed { element, time, step, jacobian: self.scratch.answers[group].least_jacobian }
    }

    /// Returns the step and the hold count of a group: shortened at once, doubled only when aligned and after a long
    /// hold.
    fn apply_hysteresis(&self, limit: f64, clock: &GroupClock, tick: Tick) -> (Tick, u32) {
        let allowed = self.rules.schedule.step(limit);
        if clock.step == 0 || allowed < clock.step {
            return (allowed, 0);
        }
        if limit < RAISE_MARGIN * clock.step as f64 || self.rules.schedule == SteppingSchedule::Global {
            return (clock.step, 0);
        }
        let calm = clock.calm.saturating_add(1);
        let is_aligned = self.rules.schedule == SteppingSchedule::Queue || tick.is_multiple_of(2 * clock.step);
        if calm >= RAISE_PATIENCE && is_aligned { (2 * clock.step, 0) } else { (clock.step, calm) }
    }

    /// Limits a step by contact: no surface node may sink deeper into a body than [`MAX_DEPTH`], and patches within
    /// an element's size of a body take the shortest step around. Also returns true if the patch is that near.
    fn limit_by_contact(&self, group: usize, step: Tick) -> (Tick, bool) {
        let mut limit = step as f64;
        let mut is_near = false;
        let elements = self.order.elements(self.order.slots(group));
        for node in elements.flat_map(|element| self.gel.potential.nodes(element)) {
            let Some(surface) = self.gel.surface.of[node.index()] else { continue };
            let Some(nearness) = self.scratch.nearness.get(self.scratch.place[surface as usize] as usize) else {
                continue;
            };
            limit = limit.min(nearness.limit);
            is_near |= nearness.is_near;
        }
        let limit = limit.max(1.0);
        let kind = if is_near && self.rules.schedule == SteppingSchedule::Queue {
            SteppingSchedule::Bins
        } else {
            self.rules.schedule
        };
        (if is_near || limit < step as f64 { kind.step(limit) } else { step }, is_near)
    }

    /// Finds the contact limits of the steps around each node close to a body.
    pub(super) fn find_contact_limits(&mut self) {
        let horizon = self.horizon();
        let mut all = std::mem::take(&mut self.scratch.nearness);
        all.clear();
        for (index, surface) in self.scratch.reached.iter().enumerate() {
            let at = self.gel.surface.nodes[*surface as usize];
            let mut nearness = ContactLimit { limit: f64::INFINITY, is_near: false };
            let gaps = &self.scratch.gaps[index * self.bodies.len()..][..self.bodies.len()];
            for (body, gap) in gaps.iter().enumerate().filter_map(|(body, gap)| Some((body, (*gap)?))) {
                let proved = self.path_limit(at.node, at.size, &gap, horizon, body);
                nearness.limit = if proved < horizon { nearness.limit.min(proved) } else { nearness.limit };
                nearness.is_near |= gap.distance < at.size;
            }
            if nearness.is_near {
                nearness.limit = nearness.limit.min(self.stable_step_around(*surface));
            }
            all.push(nearness);
        }
        self.scratch.nearness = all;
    }

    /// Returns the longest step that any group can have after this tick, ticks.
    pub(super) fn horizon(&self) -> f64 {
        if self.state.now.is_none() { self.first.1 } else { 2.0 * self.longest_step() as f64 }
    }

    /// Returns the shortest stable step of the elements of a surface node, ticks: with this step all of them are
    /// active together.
    ///
    /// It is the stable step and not the present one: a step shortened by contact would spread over the whole contact
    /// area, and its finest cell would set every step. A mesh of 1:8 took 16 % more updates then; the depth differed
    /// by 0.01 %.
    fn stable_step_around(&self, surface: u32) -> f64 {
        self.grid.ticks(self.least_limit(&self.scratch.beside[surface as usize].nodes))
    }

    /// Returns the shortest present step of the elements of a surface node, ticks.
    pub(super) fn shortest_step_around(&self, node: NodeId) -> f64 {
        let cached = self.gel.surface.of[node.index()].map(|surface| &self.scratch.beside[surface as usize].groups);
        let cached = cached.map_or(&[] as &[u32], Vec::as_slice);
        // A corner of a facet that no body is close to has no cached groups.
        let star = if cached.is_empty() { self.gel.star.of(node) } else { &[] };
        let groups =
            cached.iter().map(|group| *group as usize).chain(star.iter().map(|element| self.order.group(*element)));
        let steps = groups.map(|group| self.state.clocks[group].step).filter(|step| *step > 0);
        steps.map(|step| step as f64).fold(f64::INFINITY, f64::min)
    }

    /// Returns how long the relative path of a node is proved to stay above the allowed depth, ticks; at most
    /// `horizon`.
    ///
    /// The node moves straight on, the wrench accelerates the body by at most a, and the body's surface grows at w at
    /// most. φ is 1-Lipschitz. From the point of the straight path at s the way is free for (φ + allowed − ½as² −
    /// ws)/(|v| + as_end + w), as ½a(s + δ)² − ½as² ≤ as_end δ.
    fn path_limit(&self, node: NodeId, size: f64, gap: &Gap, horizon: f64, body: usize) -> f64 {
        let (x, v) = (embed(&self.state.position[node.index()]), embed(&self.velocity_before(node)));
        let (rigid, body) = (&self.bodies[body], &self.scratch.was[body]);
        // A spinning sphere occupies the same place.
        let is_sphere = matches!(rigid.shape, ShapeGeometry::Sphere(_));
        let relative_velocity: Vector3 = v - if is_sphere { body.velocity } else { rigid.velocity_at(body, &x) };
        let end_time = horizon * self.grid.time(1);
        let (growth_speed, growth_acceleration) =
            body.bulge.map_or((0.0, 0.0), |bulge| (bulge.max_speed(), bulge.max_acceleration()));
        let half_acceleration = 0.5 * (body.wrench.force.norm() / rigid.mass + growth_acceleration);
        let speed = relative_velocity.norm() + 2.0 * half_acceleration * end_time + growth_speed;
        let allowed = (MAX_DEPTH * size).max(EXTRA_DEPTH * size - gap.distance);
        let (mut proved, mut distance) = (0.0, gap.distance);
        for _ in 0..MAX_QUERIES {
            let clearance = distance + allowed - (half_acceleration * proved + growth_speed) * proved;
            if clearance <= 0.0 {
                break;
            }
            proved += clearance / speed;
            if proved >= end_time || speed == 0.0 {
                return horizon;
            }
            distance = rigid.gap(body, &(x + relative_velocity * proved)).distance;
        }
        self.grid.ticks(proved)
    }
}
