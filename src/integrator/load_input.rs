//! Input of the pressure loads of a tick: the facets where they are, the groups behind them, and the projectile.

use super::LoadedFacet;
use super::model::DiscreteModel;
use super::substep::GroupTicks;
use super::tick_nodes::TickNodes;
use super::workspace::{FacetLoad, PressureSource};
use crate::contact::BodyState;
use crate::fem::Potential;
use crate::math::Vector;

/// Input of the pressure loads of a tick.
pub(super) struct LoadInput<'a, const D: usize, P> {
    pub model: &'a DiscreteModel<D, P>,
    pub nodes: TickNodes<'a, D>,
    pub ticks: GroupTicks<'a>,
    /// Active groups of the reference form, ascending; `None` in the SIMD form.
    pub active_groups: Option<&'a [u32]>,
    /// Projectile at its last event.
    pub projectile: &'a BodyState,
    /// True if the projectile has left the gel.
    pub has_left: bool,
    /// Time of the tick, s.
    pub time: f64,
    /// Height of the entry surface, m: 0 unless the block moves as a whole.
    pub entry: f64,
}

impl<const D: usize, P: Potential<D>> LoadInput<'_, D, P> {
    /// Returns the corners of a facet at this tick, m.
    pub fn corners(&self, loaded: &LoadedFacet) -> [Vector<D>; 3] {
        loaded.facet.map(|node| self.nodes.position_at(node, self.time))
    }

    /// Returns true if the group behind a facet is active at this tick.
    pub fn is_active(&self, loaded: &LoadedFacet) -> bool {
        let group = self.model.layout.group(loaded.behind);
        match self.active_groups {
            Some(active) => active.binary_search(&(group as u32)).is_ok(),
            None => self.ticks.moment.is_active(self.ticks.clocks[group].step),
        }
    }

    /// Returns the load of these forces, N, on a facet, for the trailing half of its kick.
    pub fn load(&self, loaded: &LoadedFacet, forces: [Vector<D>; 3], source: PressureSource) -> FacetLoad<D> {
        let group = self.model.layout.group(loaded.behind);
        let weight = self.model.grid.length(self.ticks.trailing_half(group));
        FacetLoad { nodes: loaded.facet, forces, group, weight, source }
    }
}
