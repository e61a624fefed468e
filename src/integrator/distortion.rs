//! Distortion monitor: decides when a mesh is distorted, with travel bounds that skip elements whose nodes have not
//! moved far enough.

use super::blocks::ElementBlock;
use super::engine::Engine;
use super::node_loop::RUN;
use super::substep::{MeshPhase, TickContext};
use crate::fem::{MAX_NODES, Potential, ReferenceShape};
use crate::math::Vector;
use crate::mesh::{NodeId, Simplex, is_worse, travel_bound};
use crate::state::{SurfaceStretch, Tick};

/// Age below which only a heavily distorted mesh ends, in its finest steps (A12), and the fraction of the limits that
/// applies until then.
const YOUNG_AGE: Tick = 50;
const YOUNG_FRACTION: f64 = 0.7;
/// Least age at which a stretched facet ends a mesh, in its finest steps: at a sharp corner no mesh helps.
const MIN_STRETCHED_AGE: Tick = 200;
/// Corners of an element.
const CORNERS: Simplex = [NodeId(0), NodeId(1), NodeId(2), NodeId(3)];

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Returns true if the mesh is distorted at this tick, at an age in its finest steps. Elements are skipped until
    /// their nodes have moved far enough.
    pub(super) fn is_distorted(&mut self, tick: Tick, age: Tick) -> bool {
        if self.ends.wear.is_none() {
            return false;
        }
        if self.state.record.stretch >= SurfaceStretch::Worn && age >= MIN_STRETCHED_AGE {
            return true;
        }
        if self.watch.n_parts() == 0 {
            self.divide_mesh();
        }
        let fraction = if age < YOUNG_AGE { YOUNG_FRACTION } else { 1.0 };
        (0..self.watch.n_parts()).any(|block| self.is_block_distorted(block, tick, fraction))
    }

    /// Returns true if an element of a block exceeds a fraction of its limits after half of its step; the reference
    /// form has one block. In the second half, neighbours with shorter steps can invert an element before its kick.
    /// In the first half, the end of the mesh would take back part of the leading half kick by the changed forces of
    /// the element.
    fn is_block_distorted(&mut self, block: usize, tick: Tick, fraction: f64) -> bool {
        let groups = match &self.blocks {
            // A block at rest where it was made is not distorted.
            Some(blocks) if !blocks.all[block].is_moving() => return false,
            Some(blocks) => blocks.groups_of(block),
            None => 0..self.state.clocks.len(),
        };
        let (time, end) = (self.grid.time(tick), TickContext { phase: MeshPhase::Last, ..self.tick_context(tick) });
        let travel = self.watch.part_travel(block, time);
        if !self.watch.may_part_be_distorted(block, travel) {
            return false;
        }
        for group in groups.clone() {
            let is_owed = end.owed(self.state.clocks[group].step) >= 0.0;
            if is_owed && self.watch.may_group_be_distorted(group, travel) {
                let Some(bound) = self.group_travel_bound(group, time, fraction) else { return true };
                self.watch.set_group_bound(group, travel + bound);
            }
        }
        self.watch.set_part_bound(block, groups);
        false
    }

    /// Gives each block a travel bound of its own; in the reference form the whole mesh has one.
    fn divide_mesh(&mut self) {
        let all = || vec![(0..self.state.position.len().div_ceil(RUN) as u32).collect()];
        let parts = self.blocks.as_ref().map_or_else(all, |blocks| blocks.all.iter().map(ElementBlock::runs).collect());
        self.watch.set_parts(parts, self.state.clocks.len());
    }

    /// Returns the travel of its nodes at which an element of a group can be distorted, m; `None` if an element
    /// exceeds this fraction of its limits.
    fn group_travel_bound(&self, group: usize, time: f64, fraction: f64) -> Option<f64> {
        let wear = self.ends.wear.as_ref()?;
        let mut least = f64::INFINITY;
        for element in self.order.elements(self.order.slots(group)) {
            let (e, nodes) = (element.index(), self.gel.potential.nodes(element));
            let mut now = [Vector::<D>::zeros(); MAX_NODES];
            now.iter_mut().zip(nodes).for_each(|(corner, node)| *corner = self.position_at(*node, time));
            let measure = self.gel.potential.measure(&now);
            if measure < fraction * wear.least[e] || is_worse(&now, &CORNERS, fraction * wear.quality[e]) {
                return None;
            }
            let rings = self.gel.potential.measures_rings();
            let radius = if rings { ReferenceShape::of(&now, &CORNERS).radius } else { f64::INFINITY };
            least = least.min(travel_bound(&now, &CORNERS, (wear.quality[e], wear.least[e] / measure), radius));
        }
        Some(least)
    }
}
