//! Stable limits of the steps by the assembled nodal rule, and the collapse of a step (method 1.3, A8, A11).

use super::StepError;
use super::active_set::ActiveSet;
use super::blocks::ElementBlocks;
use super::model::DiscreteModel;
use super::stability::{nodal_limit, nodal_step_limit};
use crate::fem::{GroupResponse, Potential};
use crate::mesh::{ElementId, NodeId};
use crate::state::Tick;

/// Stable limits of all nodes at a tick.
pub(super) struct StepLimits<'a, const D: usize, P> {
    pub model: &'a DiscreteModel<D, P>,
    pub active: &'a ActiveSet,
    /// Limits of the active nodes, s.
    pub node_limits: &'a [f64],
    /// Blocks, with Σ κ of the other nodes; `None` in the reference form.
    pub blocks: Option<&'a ElementBlocks<D>>,
    /// κ by slot, N/m.
    pub stiffness: &'a [f64],
}

impl<const D: usize, P: Potential<D>> StepLimits<'_, D, P> {
    /// Returns CFL · 2/√λ_a of any node, s, from Σ κ of the last sweep of each block around it, as the active nodes
    /// have it.
    pub fn of_node(&self, node: NodeId) -> f64 {
        if self.active.has(node.index()) {
            return self.node_limits[node.index()];
        }
        let DiscreteModel { gel, layout, settings, .. } = self.model;
        let Some(blocks) = self.blocks else {
            return settings.cfl * nodal_limit(gel, self.stiffness, layout, node);
        };
        let parts = blocks.node_copies(node.index()).iter().map(|spot| blocks.parts[spot.at as usize][3]);
        settings.cfl * nodal_step_limit(parts.sum(), gel.mass[node.index()])
    }

    /// Returns the least limit of these nodes, s.
    pub fn least<'n>(&self, nodes: impl IntoIterator<Item = &'n NodeId>) -> f64 {
        nodes.into_iter().map(|node| self.of_node(*node)).fold(f64::INFINITY, f64::min)
    }

    /// Returns the stable step of a group, ticks.
    pub fn of_group(&self, group: usize) -> f64 {
        let DiscreteModel { gel, layout, grid, .. } = self.model;
        let elements = layout.elements(layout.slots(group));
        grid.ticks(self.least(elements.flat_map(|element| gel.potential.nodes(element))))
    }

    /// Finds the first of these groups whose stable step is shorter than a tick.
    pub fn find_collapse(
        &self,
        groups: impl Iterator<Item = usize>,
        responses: &[GroupResponse],
        tick: Tick,
    ) -> Option<StepError> {
        let mut limits = groups.map(|group| (group, self.of_group(group)));
        let collapsed = limits.find(|(_, limit)| *limit < 1.0);
        collapsed.map(|(group, limit)| self.collapse_error(group, limit, &responses[group], tick))
    }

    /// Returns the step collapse of a group, at the element with the least limit.
    pub fn collapse_error(&self, group: usize, limit: f64, response: &GroupResponse, tick: Tick) -> StepError {
        let DiscreteModel { gel, layout, grid, .. } = self.model;
        let own = |element: &ElementId| self.least(gel.potential.nodes(*element));
        let elements = layout.elements(layout.slots(group));
        let element = elements.min_by(|a, b| own(a).total_cmp(&own(b))).map_or(0, ElementId::index);
        let (step, time) = (limit * grid.time(1), grid.time(tick));
        StepError::StepCollapsed { element, time, step, jacobian: response.least_jacobian }
    }
}
