//! What elements remember in the fast form: side by side in the blocks while ticks are processed, and in the state for whoever reads it.

use super::blocks::{Blocks, SLOTS};
use super::element_order::Order;
use super::engine::Engine;
use crate::fem::{Answer, DEPTH, LANES, Memory, Potential, Recall};
use crate::mesh::ElementId;
use std::ops::Range;

impl<const D: usize> Blocks<D> {
    /// Takes over what the elements remember.
    pub fn load_history(&mut self, order: &Order, memory: &[Memory<D>]) {
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

    /// Hands on what the elements of some slots remember.
    fn store_history(&self, slots: Range<usize>, order: &Order, memory: &mut [Memory<D>]) {
        for slot in slots {
            if let (Some(rows), Some(element)) = (self.rows(slot), order.element(slot)) {
                self.lanes.recall(rows, slot % LANES, &mut memory[history_range(element, self.memories)]);
            }
        }
    }

    /// What the elements of the batch of a slot remember, if they do.
    fn rows(&self, slot: usize) -> Option<&[Recall]> {
        let (rows, batch) = (self.lanes.rows(), slot / LANES);
        (rows > 0).then(|| &self.memory[batch * rows..(batch + 1) * rows])
    }

    /// What viscosity has added to U′ of the elements of a patch when it was swept last, Pa.
    fn viscous(&self, order: &Order, elements: &[ElementId]) -> [f64; DEPTH] {
        let of = |element: &ElementId| {
            let slot = order.slot(*element);
            self.rows(slot).map_or(0.0, |rows| self.lanes.viscous(rows, slot % LANES))
        };
        std::array::from_fn(|k| elements.get(k).map_or(0.0, of))
    }
}

/// Where the memories of an element are among those of all, so many of each.
fn history_range(element: ElementId, memories: usize) -> Range<usize> {
    element.index() * memories..(element.index() + 1) * memories
}

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Lets the state know what the elements remember.
    pub(super) fn store_history(&mut self) {
        let Some(blocks) = &mut self.blocks else { return };
        let n_slots = self.order.n_slots();
        for i in 0..blocks.all.len() {
            if std::mem::take(&mut blocks.all[i].has_unsaved_history) {
                let slots = i * SLOTS..n_slots.min((i + 1) * SLOTS);
                blocks.store_history(slots, &self.order, &mut self.state.memory);
            }
        }
    }

    /// What the elements of a group answered that was swept at this tick, once more, element by element.
    pub(super) fn reevaluate_group(&mut self, group: usize, elements: &mut Vec<(ElementId, Answer<D>)>) {
        let Some(blocks) = &self.blocks else { return };
        blocks.store_history(self.order.slots(group), &self.order, &mut self.state.memory);
        for patch in self.order.patches(group) {
            let own = self.gel.potential.patches().of(*patch as usize);
            let (mut answers, viscous) = ([Answer::default(); DEPTH], blocks.viscous(&self.order, own));
            let remembered = (self.state.memory.as_slice(), &viscous);
            self.gel.potential.again(*patch as usize, &self.state.position, remembered, &mut answers);
            elements.extend(own.iter().copied().zip(answers));
        }
    }
}
