//! When a mesh is worn, and until when that need not be asked.

use super::blocks::Block;
use super::engine::Engine;
use super::node_loop::RUN;
use super::substep::{Moment, Phase};
use crate::fem::{MAX_NODES, Potential, Reference};
use crate::math::Vector;
use crate::mesh::{NodeId, Simplex, is_worse, leeway};
use crate::state::{Stretch, Tick};

/// When a mesh is worn: as soon as one of its elements is.
#[derive(Debug, Clone, PartialEq)]
pub struct Wear {
    /// Which shape of each element, 1 being the best, is too bad.
    pub quality: Vec<f64>,
    /// To which measure, [`Potential::measure`], each may be compressed.
    pub least: Vec<f64>,
}

/// A mesh lasts so many of its finest steps (A12) unless it wears out fast, to this part of what is allowed.
const YOUNG: Tick = 50;
const HALF_WORN: f64 = 0.7;
/// It lasts so many at least where a facet is stretched over a body: at a sharp corner no mesh helps.
const STRETCHED_LIFE: Tick = 200;
/// The corners of an element.
const CORNERS: Simplex = [NodeId(0), NodeId(1), NodeId(2), NodeId(3)];

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Whether the mesh is worn at this tick, so many finest steps old. What no node has wandered far enough for is not looked at.
    pub(super) fn is_worn(&mut self, tick: Tick, age: Tick) -> bool {
        if self.ends.wear.is_none() {
            return false;
        }
        if self.state.record.stretch >= Stretch::Worn && age >= STRETCHED_LIFE {
            return true;
        }
        if self.watch.parts() == 0 {
            self.divide();
        }
        let part = if age < YOUNG { HALF_WORN } else { 1.0 };
        (0..self.watch.parts()).any(|block| self.is_block_worn(block, tick, part))
    }

    /// Whether an element of a block, in the reference form of all of the mesh, is worn to this part of what is allowed, if half of its step
    /// is behind: within it neighbours of shorter ones can turn it over, and its kick at the end would be by that. Before, the end of the
    /// mesh would take back some of the half kick ahead, by what the element has become since.
    fn is_block_worn(&mut self, block: usize, tick: Tick, part: f64) -> bool {
        let groups = match &self.blocks {
            // What is at rest where it was made is not worn.
            Some(blocks) if !blocks.all[block].is_awake() => return false,
            Some(blocks) => blocks.groups_of(block),
            None => 0..self.state.clocks.len(),
        };
        let (time, end) = (self.grid.time(tick), Moment { phase: Phase::Last, ..self.moment(tick) });
        let wandered = self.watch.wandered(block, time);
        if !self.watch.may_be_worn(block, wandered) {
            return false;
        }
        for group in groups.clone() {
            let is_owed = end.owed(self.state.clocks[group].step) >= 0.0;
            if is_owed && self.watch.may_group_be_worn(group, wandered) {
                let Some(leeway) = self.leeway(group, time, part) else { return true };
                self.watch.note_sound(group, wandered + leeway);
            }
        }
        self.watch.note_part(block, groups);
        false
    }

    /// Has blocks wander by themselves, in the reference form all of the mesh together.
    fn divide(&mut self) {
        let all = || vec![(0..self.state.position.len().div_ceil(RUN) as u32).collect()];
        let parts = self.blocks.as_ref().map_or_else(all, |blocks| blocks.all.iter().map(Block::runs).collect());
        self.watch.divide(parts, self.state.clocks.len());
    }

    /// How far nodes may go before an element of a group can be worn, m; `None` if one is worn to this part of what is allowed.
    fn leeway(&self, group: usize, time: f64, part: f64) -> Option<f64> {
        let wear = self.ends.wear.as_ref()?;
        let mut least = f64::INFINITY;
        for element in self.order.elements(self.order.slots(group)) {
            let (e, nodes) = (element.index(), self.gel.potential.nodes(element));
            let mut now = [Vector::<D>::zeros(); MAX_NODES];
            now.iter_mut().zip(nodes).for_each(|(corner, node)| *corner = self.position_at(*node, time));
            let measure = self.gel.potential.measure(&now);
            if measure < part * wear.least[e] || is_worse(&now, &CORNERS, part * wear.quality[e]) {
                return None;
            }
            let rings = self.gel.potential.measures_rings();
            let radius = if rings { Reference::of(&now, &CORNERS).radius } else { f64::INFINITY };
            least = least.min(leeway(&now, &CORNERS, (wear.quality[e], wear.least[e] / measure), radius));
        }
        Some(least)
    }
}
