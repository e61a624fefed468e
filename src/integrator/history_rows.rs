//! History variables in the SIMD form: rows in the blocks while ticks are processed, copied to the state for its
//! readers.

use super::blocks::ElementBlocks;
use super::element_order::{ElementLayout, SLOTS};
use crate::fem::{DEPTH, HistoryLanes, HistoryVariables, LANES};
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

    /// Stores the history variables that the last ticks have changed in the state.
    pub fn store_unsaved_history(&mut self, order: &ElementLayout, memory: &mut [HistoryVariables<D>]) {
        for i in 0..self.all.len() {
            if std::mem::take(&mut self.all[i].has_unsaved_history) {
                self.store_history(i * SLOTS..order.n_slots().min((i + 1) * SLOTS), order, memory);
            }
        }
    }

    /// Stores the history variables of the elements in some slots.
    pub fn store_history(&self, slots: Range<usize>, order: &ElementLayout, memory: &mut [HistoryVariables<D>]) {
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
    pub fn viscous(&self, order: &ElementLayout, elements: &[ElementId]) -> [f64; DEPTH] {
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
