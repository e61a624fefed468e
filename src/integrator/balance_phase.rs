//! Energy balance of a tick: the integration residual of the groups and the work of the pressures (A6).

use super::blocks::ElementBlocks;
use super::energy_residual::update_clock;
use super::model::DiscreteModel;
use super::substep::{GroupTicks, TickContext};
use super::workspace::{FacetLoad, ImpulseNode, PressureSource, StepChange};
use crate::fem::{GroupResponse, Potential};
use crate::ledger::EnergyAccounts;
use crate::math::Vector;
use crate::mesh::NodeId;
use crate::state::{GroupAlarm, GroupClock, RunRecord};

/// Balance phase: reads responses, velocities and loads, and writes the clocks of the groups and the ledger.
pub(super) struct BalancePhase<'a, const D: usize, P> {
    pub model: &'a DiscreteModel<D, P>,
    pub moment: TickContext,
    pub alarms: &'a [GroupAlarm],
    /// Active groups of the reference form.
    pub active_groups: &'a [u32],
    pub responses: &'a [GroupResponse],
    pub changed_steps: &'a [StepChange],
    pub velocity: &'a [Vector<D>],
    /// Velocities of the active nodes before the kicks, m/s.
    pub before: &'a [Vector<D>],
    pub facet_loads: &'a [FacetLoad<D>],
    pub impulse_nodes: &'a [ImpulseNode<D>],
    pub blocks: Option<&'a mut ElementBlocks<D>>,
    pub clocks: &'a mut [GroupClock],
    pub energy: &'a mut EnergyAccounts,
    pub record: &'a mut RunRecord,
}

impl<const D: usize, P: Potential<D>> BalancePhase<'_, D, P> {
    /// Posts the integration residual of the active groups, Σ ΔV + Σ A of the last tick + W − Σ A of this one,
    /// where A is the leading-half work. It is zero for the exact motion and of second order in the step. Then posts the
    /// work of the pressures.
    pub fn post(mut self, work: f64) {
        let residual = if self.blocks.is_some() { self.update_block_clocks() } else { self.update_group_clocks() };
        self.energy.integration += residual + work;
        self.post_load_work();
    }

    /// Updates the clocks of the active groups (reference form); returns the residual, J.
    fn update_group_clocks(&mut self) -> f64 {
        let mut residual = 0.0;
        for group in self.active_groups.iter().map(|group| *group as usize) {
            let ticks = GroupTicks { moment: self.moment, clocks: self.clocks, alarms: self.alarms };
            let (ahead, response) = (ticks.ahead(group), &self.responses[group]);
            residual += update_clock(&mut self.clocks[group], response, self.model.grid.time(ahead));
            self.record.min_jacobian = self.record.min_jacobian.min(response.least_jacobian);
            self.record.updates += self.model.layout.elements(self.model.layout.slots(group)).count() as u64;
        }
        residual
    }

    /// Updates the clocks and step ranges of the active blocks; returns the residual, J.
    fn update_block_clocks(&mut self) -> f64 {
        let Some(blocks) = &mut self.blocks else { return 0.0 };
        let (grid, groups_per_block) = (self.model.grid, blocks.groups);
        let (residual, dissipation) = blocks.update_clocks(grid, self.moment, self.clocks, self.responses);
        self.energy.book_dissipation(&dissipation);
        for report in blocks.all.iter().filter_map(|block| block.report) {
            self.record.updates += report.updates;
            self.record.min_jacobian = self.record.min_jacobian.min(report.least_jacobian);
        }
        let block_of = |change: &StepChange| change.group as usize / groups_per_block;
        for changed in self.changed_steps.chunk_by(|a, b| block_of(a) == block_of(b)) {
            let block = block_of(&changed[0]);
            blocks.update_steps(block, self.clocks, grid);
            blocks.all[block].may_raise_step = true;
        }
        residual
    }

    /// Posts the work of the pressures, Σ J·(v⁻ + v⁺)/2, once all velocities of the tick are known.
    fn post_load_work(self) {
        let work = |(node, impulse): (NodeId, Vector<D>)| {
            let velocity_sum = self.velocity_before(node) + self.velocity[node.index()];
            0.5 * impulse.component_mul(&self.model.gel.free(node.index())).dot(&velocity_sum)
        };
        let of_source = |source: PressureSource| -> f64 {
            let own = self.facet_loads.iter().filter(|load| load.source == source);
            own.flat_map(FacetLoad::impulses).map(work).sum()
        };
        let [load, air] = [PressureSource::Face, PressureSource::Cavity].map(of_source);
        self.energy.load += load;
        self.energy.air += air;
    }

    /// Returns the velocity of a node of a loaded facet before the kicks of this tick, m/s. In the block form a node
    /// that was still is not active.
    fn velocity_before(&self, node: NodeId) -> Vector<D> {
        match self.impulse_nodes.binary_search_by_key(&node, |impulse_node| impulse_node.node) {
            Ok(at) if self.blocks.is_some() => self.impulse_nodes[at].before,
            _ => self.before[node.index()],
        }
    }
}
