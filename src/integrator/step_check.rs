//! Check of the steps: which active groups may change theirs at a tick (SIMD form).

use super::active_set::ActiveSet;
use super::blocks::ElementBlocks;
use super::element_block::BlockActivity;
use super::element_loop::closes;
use super::model::DiscreteModel;
use super::step_limits::StepLimits;
use super::step_monitor::RAISE_MARGIN;
use super::substep::TickContext;
use super::workspace::{ContactLimit, NodeStar};
use crate::contact::ContactDetection;
use crate::fem::{GroupResponse, Potential};
use crate::state::GroupClock;

/// Check of the steps: reads limits, clocks and contact, and writes what the blocks watch.
pub(super) struct StepCheck<'a, const D: usize, P> {
    pub model: &'a DiscreteModel<D, P>,
    pub moment: TickContext,
    pub active: &'a ActiveSet,
    pub node_limits: &'a [f64],
    pub stiffness: &'a [f64],
    pub clocks: &'a [GroupClock],
    pub responses: &'a [GroupResponse],
    pub contact: &'a ContactDetection,
    pub contact_limits: &'a [ContactLimit],
    pub surface_stars: &'a [NodeStar],
    pub can_be_distorted: bool,
    pub blocks: &'a mut ElementBlocks<D>,
    /// Stable limits by local number in one block, s.
    pub block_limits: &'a mut Vec<f64>,
    /// Groups found.
    pub groups: &'a mut Vec<u32>,
}

impl<const D: usize, P: Potential<D>> StepCheck<'_, D, P> {
    /// Collects the active groups whose step may change, ascending: those with a limit below or far above the step,
    /// with a hold count, or near a body.
    pub fn find_groups(mut self) {
        self.groups.clear();
        for block in 0..self.blocks.all.len() {
            self.check_block(block);
        }
        if self.can_be_distorted {
            self.add_inverting_groups();
        }
        self.add_groups_near_contact();
        self.groups.sort_unstable();
        self.groups.dedup();
    }

    /// Adds the active groups of a watched block whose step may change. The front of a block none of whose steps may
    /// change now is set up to watch for limits that could change one.
    fn check_block(&mut self, i: usize) {
        let (block, monitor) = (&self.blocks.all[i], &mut self.blocks.monitors[i]);
        let is_watched = monitor.contributes || block.has_active_nodes || block.may_raise_step;
        if block.activity == BlockActivity::Nothing || !is_watched || monitor.holds_steps() {
            return;
        }
        // Inactive groups of a block at rest are not checked.
        let must_wait = block.may_raise_step && block.activity == BlockActivity::Some && !monitor.contributes;
        self.collect_limits(i);
        let may_raise_step = self.collect_changeable_groups(i) || must_wait;
        let groups = self.blocks.groups_of(i);
        let ElementBlocks { all, monitors, lanes, .. } = &mut *self.blocks;
        all[i].may_raise_step = may_raise_step;
        if !may_raise_step {
            let (n_nodes, grid) = (all[i].nodes.len(), self.model.grid);
            monitors[i].watch(n_nodes, groups, lanes, self.clocks, grid, self.block_limits);
        }
    }

    /// Collects the limits of the nodes of a block that can have changed, s; infinite for the others. In an awake
    /// block all nodes of active groups are active. In a block at rest only nodes that are active through another
    /// block can have changed, unless the block may raise a step.
    fn collect_limits(&mut self, i: usize) {
        let Self { model, active, node_limits, stiffness, ref blocks, ref mut block_limits, .. } = *self;
        let block = &blocks.all[i];
        block_limits.clear();
        if block.may_raise_step && !blocks.monitors[i].contributes {
            let limits = StepLimits { model, active, node_limits, blocks: Some(blocks), stiffness };
            block_limits.extend(block.nodes.iter().map(|node| limits.of_node(*node)));
            return;
        }
        block_limits.resize(block.nodes.len(), f64::INFINITY);
        for number in block.active_nodes() {
            let a = block.nodes[number].index();
            if active.has(a) {
                block_limits[number] = node_limits[a];
            }
        }
    }

    /// Adds the active groups of a block whose step may change; returns true if there are any, or if an inactive
    /// group has a hold count.
    fn collect_changeable_groups(&mut self, block: usize) -> bool {
        let (all, before) = (self.blocks.groups_of(block), self.groups.len());
        for group in all.clone() {
            if self.may_step_change(group) {
                self.groups.push(group as u32);
            }
        }
        self.groups.len() > before || self.clocks[all].iter().any(|clock| clock.calm > 0)
    }

    /// Returns true if a group is active and its step may change.
    fn may_step_change(&self, group: usize) -> bool {
        let clock = &self.clocks[group];
        if !self.moment.kind.is_active(clock.step, self.moment.tick) {
            return false;
        }
        let mut limit = f64::INFINITY;
        self.blocks.lanes.nodes(group, |number| limit = limit.min(self.block_limits[usize::from(number)]));
        let (limit, step) = (self.model.grid.ticks(limit), clock.step as f64);
        clock.step == 0 || limit < step || clock.calm > 0 || (limit.is_finite() && limit >= RAISE_MARGIN * step)
    }

    /// Adds the active groups in which an element would invert within the present step, if the gel is remeshed. On a
    /// mesh that stays, the kick of a whole step throws an inverted element back. In short steps it is found inverted
    /// twice in a row, which ends the run: the ball of 20 m/s on cells of 2.5 mm stopped so after 0.9 ms.
    fn add_inverting_groups(&mut self) {
        let Self { model, moment, clocks, responses, blocks, groups, .. } = self;
        let closing = |i: &usize| blocks.all[*i].report.is_some_and(|report| report.closes);
        for i in (0..blocks.all.len()).filter(closing) {
            let is_concerned = |group: &usize| {
                let step = clocks[*group].step;
                moment.is_active(step) && closes(&responses[*group], model.grid.time(step))
            };
            groups.extend(blocks.groups_of(i).filter(is_concerned).map(|group| group as u32));
        }
    }

    /// Adds the active groups around the nodes close to a body whose step contact shortens, or whose hold count it
    /// resets.
    fn add_groups_near_contact(&mut self) {
        let Self { moment, clocks, contact, contact_limits, surface_stars, groups, .. } = self;
        for surface in &contact.close {
            let Some(index) = contact.index_of(*surface) else { continue };
            let nearness = &contact_limits[index];
            let is_concerned = |group: &u32| {
                let clock = &clocks[*group as usize];
                let is_active = moment.kind.is_active(clock.step, moment.tick);
                is_active && (nearness.limit < clock.step as f64 || nearness.is_near && clock.calm > 0)
            };
            groups.extend(surface_stars[*surface as usize].groups.iter().copied().filter(is_concerned));
        }
    }
}
