//! When a mesh is worn, and until when that need not be asked.

use super::engine::Engine;
use crate::algebra::Vector;
use crate::element::{MAX_NODES, Potential};
use crate::mesh::{NodeId, Simplex, is_worse, leeway};
use crate::state::Tick;

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
        if self.state.record.stretched && age >= STRETCHED_LIFE {
            return true;
        }
        let part = if age < YOUNG { HALF_WORN } else { 1.0 };
        let mut until = std::mem::take(&mut self.watch.wear);
        until.resize(self.state.clocks.len(), f64::NEG_INFINITY);
        let worn = (0..self.watch.parts())
            .any(|block| self.is_block_worn(block, (self.grid.time(tick), tick), part, &mut until));
        self.watch.wear = until;
        worn
    }

    /// Whether an element of a block that fires, or in the reference form of all that do, is worn to this part of what is allowed.
    fn is_block_worn(&self, block: usize, (time, tick): (f64, Tick), part: f64, until: &mut [f64]) -> bool {
        let groups = match &self.blocks {
            // What is at rest where it was made is not worn.
            Some(blocks) if !blocks.all[block].is_awake() => return false,
            Some(blocks) => blocks.groups_of(block),
            None => 0..self.state.clocks.len(),
        };
        let wandered = self.watch.wandered(block, time);
        let mut fires = groups.filter(|group| self.rules.schedule.fires(self.state.clocks[*group].step, tick));
        fires.any(|group| {
            // What is no number must not hide a group.
            let far = until[group] > wandered;
            !far && self.leeway(group, time, part).is_none_or(|leeway| {
                until[group] = wandered + leeway;
                false
            })
        })
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
            let middle = || now[..=D].iter().map(|x| x[0]).sum::<f64>() / (D + 1) as f64;
            let radius = if rings { middle() } else { f64::INFINITY };
            least = least.min(leeway(&now, &CORNERS, (wear.quality[e], wear.least[e] / measure), radius));
        }
        Some(least)
    }
}
