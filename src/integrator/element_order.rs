//! Layout of the elements in slots, and the grouping of patches that step together.
//!
//! Patches of equal steps are adjacent, eight to a group for the SIMD lanes; a group has one clock. In the queue,
//! as in the paper, every patch is a group of its own. Within a block, patches of nearly equal limits are adjacent:
//! the first patch of a group whose limit falls below the step shortens the step of the others.

use crate::fem::{Potential, max_patch_size};
use crate::mesh::ElementId;
use std::ops::Range;

/// Slots of a block: some 400 nodes and their sums take 40 kB of cache, and a node is in two blocks.
pub(super) const SLOTS: usize = 1024;

/// Layout of the elements: the k-th element of the patch in lane l of a group is at slot (group · depth + k) ·
/// lanes + l.
#[derive(Debug)]
pub(super) struct ElementLayout {
    /// Patches per group, one per SIMD lane.
    lanes: usize,
    /// Slots per patch.
    depth: usize,
    /// Patches in the order of the layout.
    patches: Vec<u32>,
    /// Element at each slot; [`EMPTY_SLOT`] where a patch is smaller or missing.
    slots: Vec<u32>,
    /// Slot of each element.
    slot_of: Vec<u32>,
}

/// Marker of an empty slot.
const EMPTY_SLOT: u32 = u32::MAX;

/// Sort key of a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct SortKey {
    /// Class: patches of one class are adjacent, in blocks by their numbers.
    pub class: u64,
    /// Order within the class and block; ties by number.
    pub within: u64,
}

impl ElementLayout {
    /// Builds the layout with patches sorted by their keys.
    pub fn new<const D: usize, P: Potential<D>>(potential: &P, lanes: usize, key: impl Fn(usize) -> SortKey) -> Self {
        let all = potential.patches();
        let depth = if all.largest() > 1 { max_patch_size(D) } else { 1 };
        assert!(all.largest() <= depth, "a patch has at most {depth} elements");
        let keys: Vec<SortKey> = (0..all.len()).map(key).collect();
        let mut patches: Vec<u32> = (0..keys.len() as u32).collect();
        patches.sort_by_key(|patch| keys[*patch as usize].class);
        for block in patches.chunks_mut(SLOTS / depth) {
            block.sort_by_key(|patch| keys[*patch as usize]);
        }
        let groups = patches.len().div_ceil(lanes);
        let mut slots = vec![EMPTY_SLOT; groups * lanes * depth];
        let mut slot_of = vec![0; potential.len()];
        for (at, patch) in patches.iter().enumerate() {
            for (k, element) in all.of(*patch as usize).iter().enumerate() {
                let slot = (at / lanes * depth + k) * lanes + at % lanes;
                slots[slot] = element.0;
                slot_of[element.index()] = slot as u32;
            }
        }
        Self { lanes, depth, patches, slots, slot_of }
    }

    /// Returns the slots per patch.
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// Returns the slots per group.
    pub fn width(&self) -> usize {
        self.lanes * self.depth
    }

    /// Returns the number of slots.
    pub fn n_slots(&self) -> usize {
        self.slots.len()
    }

    /// Returns the number of groups.
    pub fn n_groups(&self) -> usize {
        self.slots.len() / self.width()
    }

    /// Returns the slot of an element.
    #[inline]
    pub fn slot(&self, element: ElementId) -> usize {
        self.slot_of[element.index()] as usize
    }

    /// Returns the group of an element.
    #[inline]
    pub fn group(&self, element: ElementId) -> usize {
        self.slot(element) / self.width()
    }

    /// Returns the element at a slot.
    pub fn element(&self, slot: usize) -> Option<ElementId> {
        Some(self.slots[slot]).filter(|element| *element != EMPTY_SLOT).map(ElementId)
    }

    /// Returns the patches of a group.
    pub fn patches(&self, group: usize) -> &[u32] {
        &self.patches[group * self.lanes..self.patches.len().min((group + 1) * self.lanes)]
    }

    /// Returns the slots of a group.
    pub fn slots(&self, group: usize) -> Range<usize> {
        group * self.width()..(group + 1) * self.width()
    }

    /// Returns the elements in a range of slots.
    pub fn elements(&self, slots: Range<usize>) -> impl Iterator<Item = ElementId> + '_ {
        self.slots[slots].iter().filter(|element| **element != EMPTY_SLOT).map(|element| ElementId(*element))
    }

    /// Returns element values by slot; 0 at empty slots.
    pub fn by_slot(&self, by_element: &[f64]) -> Vec<f64> {
        (0..self.n_slots()).map(|slot| self.element(slot).map_or(0.0, |element| by_element[element.index()])).collect()
    }

    /// Returns the memory held, bytes.
    pub fn bytes(&self) -> usize {
        4 * (self.patches.len() + self.slots.len() + self.slot_of.len())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{DiscreteGel, test_cube};
    use super::*;
    use crate::fem::{LANES, Simplices};
    use crate::mesh::ElementPatches;

    /// Checks the layout of the patches of a gel with some keys.
    fn check_layout(gel: &DiscreteGel<3, Simplices<3>>) {
        let n = gel.potential.patches().len() as u64;
        let keys: Vec<SortKey> = (0..n).map(|i| SortKey { class: i * i % 5, within: i * 7 % 11 }).collect();
        let order = ElementLayout::new(&gel.potential, LANES, |patch| keys[patch]);
        let classes: Vec<u64> = order.patches.iter().map(|patch| keys[*patch as usize].class).collect();
        assert!(order.n_slots() > 2 * SLOTS && classes.is_sorted());
        let by_key = |block: &[u32]| block.is_sorted_by_key(|patch| (keys[*patch as usize], *patch));
        assert!(order.patches.chunks(SLOTS / order.depth()).all(by_key));
        let two = order.patches.chunks(2 * SLOTS / order.depth());
        assert!(!two.into_iter().all(by_key), "keys within are those of a block");
    }

    #[test]
    fn patches_are_sorted_by_class_and_within_a_block_by_key() {
        let mesh = test_cube::mixed();
        check_layout(&test_cube::gel(&mesh));
        check_layout(&test_cube::gel_in(&mesh, ElementPatches::grouped(&mesh)));
    }
}
