//! Views of the phases: which parts of the system each phase of a tick reads and which it writes.

use super::assembly::StepRule;
use super::element_loop::ElementLoopInput;
use super::element_phase::{ElementPhase, ElementResults};
use super::kick_sums::KickSums;
use super::load::{LoadPhase, LoadedElements};
use super::load_input::LoadInput;
use super::node_chunks::NodeChunks;
use super::node_loop::NodePhase;
use super::node_update::NodeUpdate;
use super::reference::ReferenceElements;
use super::substep::GroupTicks;
use super::system::DiscreteSystem;
use super::tick_nodes::TickNodes;
use crate::fem::Potential;
use crate::state::Tick;

impl<const D: usize, P: Potential<D>> DiscreteSystem<D, P> {
    /// Returns the element phase of a tick; `None` in the reference form.
    pub fn element_phase(&mut self, tick: Tick) -> Option<ElementPhase<'_, D>> {
        let moment = self.tick_context(tick);
        let Self { model, state, clock, blocks, workspace, pool, .. } = self;
        let input = ElementLoopInput {
            moment,
            grid: model.grid,
            position: &state.position,
            velocity: &state.velocity,
            rest: model.gel.potential.rest(),
            last: &clock.last_ticks,
            clocks: &state.clocks,
            order: &model.layout,
        };
        Some(ElementPhase {
            input,
            pool: pool.as_deref(),
            blocks: blocks.as_mut()?,
            stiffness: &mut state.stiffness,
            responses: &mut workspace.responses,
            active_nodes: &mut workspace.active_nodes,
        })
    }

    /// Returns the element phase of a tick in the reference form.
    pub fn reference_elements(&mut self, tick: Tick) -> ReferenceElements<'_, D, P> {
        let moment = self.tick_context(tick);
        let Self { model, state, clock, workspace, .. } = self;
        ReferenceElements {
            model,
            ticks: GroupTicks { moment, clocks: &state.clocks, alarms: &state.alarms },
            queue: &mut clock.queue,
            active_groups: &mut workspace.active_groups,
            active_nodes: &mut workspace.active_nodes,
            kick_lengths: &mut workspace.kick_lengths,
            position: &mut state.position,
            velocity: &state.velocity,
            last_ticks: &mut clock.last_ticks,
            before: &mut workspace.velocities_before,
            decay: &mut workspace.decay,
            stiffness: &mut state.stiffness,
            memory: &mut state.memory,
            energy: &mut state.ledger.energy,
            responses: &mut workspace.responses,
            element_responses: &mut workspace.element_responses,
        }
    }

    /// Returns the results of the element phase.
    pub fn element_results(&self) -> ElementResults<'_, D> {
        ElementResults {
            layout: &self.model.layout,
            clocks: &self.state.clocks,
            responses: &self.workspace.responses,
            blocks: self.blocks.as_ref(),
            active_groups: &self.workspace.active_groups,
        }
    }

    /// Returns the node phase of a tick; `None` in the reference form.
    pub fn node_phase(&mut self, tick: Tick) -> Option<NodePhase<'_, D, P>> {
        let leading_share = self.leading_share();
        let is_shared = self.is_worth_sharing();
        let Self { model, state, clock, blocks, workspace, batch_travel, pool, .. } = self;
        let blocks = blocks.as_ref()?;
        let n_chunks = workspace.active_nodes.n_chunks(state.position.len());
        workspace.chunk_sums.resize(n_chunks, KickSums::default());
        let nodes = NodeChunks {
            first: 0,
            position: &mut state.position,
            velocity: &mut state.velocity,
            before: &mut workspace.velocities_before,
            last: &mut clock.last_ticks,
            limit: &mut workspace.node_limits,
            excess: &mut state.excess,
            decay: &mut workspace.decay,
            speeds: &mut batch_travel.speeds,
            sums: &mut workspace.chunk_sums,
        };
        let (gel, grid, freedom) = (&*model.gel, model.grid, model.freedom());
        Some(NodePhase {
            update: NodeUpdate { gel, grid, freedom, tick, leading_share, damping_rate: model.settings.damping },
            rule: StepRule { mass: &gel.mass, cfl: model.settings.cfl },
            blocks,
            active: &workspace.active_nodes,
            pool: pool.as_deref().filter(|_| is_shared),
            nodes,
        })
    }

    /// Returns the load phase of a tick.
    pub fn load_phase(&mut self, tick: Tick) -> LoadPhase<'_, D, P> {
        let moment = self.tick_context(tick);
        let Self { model, state, clock, blocks, workspace, .. } = self;
        let time = model.grid.time(tick);
        let nodes = TickNodes {
            grid: model.grid,
            position: &state.position,
            velocity: &state.velocity,
            last_ticks: &clock.last_ticks,
            active: &workspace.active_nodes,
            before: &workspace.velocities_before,
        };
        let input = LoadInput {
            model,
            nodes,
            ticks: GroupTicks { moment, clocks: &state.clocks, alarms: &state.alarms },
            active_groups: blocks.is_none().then_some(&workspace.active_groups),
            projectile: &state.bodies[0],
            has_left: state.record.contacts[0].exit.is_some(),
            time,
            entry: model.frame.motion(&state.record.outside, time).displacement.z,
        };
        LoadPhase {
            input,
            stiffness: &state.stiffness,
            gas: &mut state.record.gas,
            facet_loads: &mut workspace.facet_loads,
            load_stiffness: &mut workspace.load_stiffness,
        }
    }

    /// Returns the elements behind the loads of this tick.
    pub fn loaded_elements(&mut self) -> LoadedElements<'_, D, P> {
        LoadedElements {
            gel: &self.model.gel,
            loads: &self.workspace.load_stiffness,
            blocks: self.blocks.as_mut(),
            stiffness: &mut self.state.stiffness,
            stiffened: &mut self.workspace.stiffened_blocks,
        }
    }
}
