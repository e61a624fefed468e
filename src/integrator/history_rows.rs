//! History variables in the SIMD form: rows in the blocks while ticks are processed, copied to the state for its
//! readers.

use super::blocks::ElementBlocks;
use super::element_order::{ElementLayout, SLOTS};
use super::system::DiscreteSystem;
use crate::fem::{DEPTH, ElementResponse, HistoryLanes, HistoryVariables, LANES, Potential};
use crate::mesh::ElementId;
use std::ops::Range;

impl<const D: usize> ElementBlocks<D> {
    /// Loads the history variables of all elements from the state.
    pub fn load_history(&mut self, order: &ElementLayout, memory: &[HistoryVariables<D>]) {
        let Self { lanes, memory: batches, memories, .. } = self;
        for (batch, rows) in batches.chunks_exact_mut(lanes.rows().max(1)).enumerate() {
            for lane in 0..LANES {
                if let Some(element) = order.element(batch * LANES + lane) {
                    lanes.remember(rows, lane, &memory[history_range(element, *memories)]);
                }
            }
        }
        self.all.iter_mut().for_each(|block| block.has_unsaved_history = false);
    }

    /// Stores the history variables of the elements in some slots.
    fn store_history(&self, slots: Range<usize>, order: &ElementLayout, memory: &mut [HistoryVariables<D>]) {
        for slot in slots {
            if let (Some(rows), Some(element)) = (self.rows(slot), order.element(slot)) {
                self.lanes.recall(rows, slot % LANES, &mut memory[history_range(element, self.memories)]);
            }
        }
    }

    /// Returns the history rows of the batch of a slot, for elements with history.
    fn rows(&self, slot: usize) -> Option<&[HistoryLanes]> {
        let (rows, batch) = (self.lanes.rows(), slot / LANES);
        (rows > 0).then(|| &self.memory[batch * rows..(batch + 1) * rows])
    }

    /// Returns the viscous part of U′ of the elements of a patch at their last sweep, Pa.
    fn viscous(&self, order: &ElementLayout, elements: &[ElementId]) -> [f64; DEPTH] {
        let of = |element: &ElementId| {
            let slot = order.slot(*element);
            self.rows(slot).map_or(0.0, |rows| self.lanes.viscous(rows, slot % LANES))
        };
        std::array::from_fn(|k| elements.get(k).map_or(0.0, of))
    }
}

/// Returns the range of an element's history variables among those of all elements.
fn history_range(element: ElementId, memories: usize) -> Range<usize> {
    element.index() * memories..(element.index() + 1) * memories
}

/// Stores the history variables of the blocks in the state.
pub(super) fn store_history<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let Some(blocks) = &mut system.blocks else { return };
    let n_slots = system.model.layout.n_slots();
    for i in 0..blocks.all.len() {
        if std::mem::take(&mut blocks.all[i].has_unsaved_history) {
            let slots = i * SLOTS..n_slots.min((i + 1) * SLOTS);
            blocks.store_history(slots, &system.model.layout, &mut system.state.memory);
        }
    }
}

/// Evaluates the elements of a group again that was swept at this tick, and appends each element's response.
pub(super) fn reevaluate_group<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    group: usize,
    elements: &mut Vec<(ElementId, ElementResponse<D>)>,
) {
    let Some(blocks) = &system.blocks else { return };
    blocks.store_history(system.model.layout.slots(group), &system.model.layout, &mut system.state.memory);
    for patch in system.model.layout.patches(group) {
        let own = system.model.gel.potential.patches().of(*patch as usize);
        let (mut responses, viscous) = ([ElementResponse::default(); DEPTH], blocks.viscous(&system.model.layout, own));
        let (x, memory) = (&system.state.position, &system.state.memory);
        system.model.gel.potential.again(*patch as usize, x, memory, &viscous, &mut responses);
        elements.extend(own.iter().copied().zip(responses));
    }
}
