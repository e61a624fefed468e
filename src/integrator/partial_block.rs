//! Node stars in partly active blocks: the nodes of the active groups and all elements at these nodes.

use super::element_order::ElementLayout;
use crate::fem::{ElementBatches, MOST_LOCAL_NODES};
use std::ops::Range;

/// Star of some groups of a block: their nodes, and the elements at these nodes.
#[derive(Debug, Default)]
pub(super) struct GroupStar {
    /// Groups in ascending order.
    pub groups: Vec<u32>,
    /// Number of elements of the groups.
    pub n_elements: u64,
    /// Nodes of the groups, ascending; empty until they are found.
    pub nodes: Vec<u16>,
    /// Slots of all elements of the block at each node, node by node in sweep order, and the end of each node's list.
    pub slots: Vec<u16>,
    pub ends: Vec<u16>,
}

impl GroupStar {
    /// Builds the star of these groups, without nodes.
    pub fn of_groups(order: &ElementLayout, groups: impl Iterator<Item = usize>) -> Self {
        let groups: Vec<u32> = groups.map(|group| group as u32).collect();
        let of_group = |group: &u32| order.elements(order.slots(*group as usize)).count() as u64;
        Self { n_elements: groups.iter().map(of_group).sum(), groups, ..Self::default() }
    }

    /// Finds the nodes of the groups and the elements at them among all groups of the block.
    pub fn find_nodes<const D: usize>(&mut self, lanes: &ElementBatches<D>, all: Range<usize>) {
        let (mut is_touched, mut index) = ([false; MOST_LOCAL_NODES], [0_u16; MOST_LOCAL_NODES]);
        for group in &self.groups {
            lanes.nodes(*group as usize, |node| is_touched[usize::from(node)] = true);
        }
        self.nodes = (0..).zip(&is_touched).filter(|(_, touched)| **touched).map(|(node, _)| node).collect();
        // Every corner is counted and stored, those at other nodes in one extra list: a branch would be
        // mispredicted half of the time.
        let elsewhere = self.nodes.len();
        index.fill(elsewhere as u16);
        self.nodes.iter().zip(0..).for_each(|(node, i)| index[usize::from(*node)] = i);
        let mut next = vec![0_u16; elsewhere + 2];
        lanes.corners(all.clone(), |corner| next[usize::from(index[usize::from(corner.node)]) + 1] += 1);
        (1..next.len()).for_each(|i| next[i] += next[i - 1]);
        self.slots = vec![0; usize::from(next[elsewhere + 1])];
        lanes.corners(all, |corner| {
            let next = &mut next[usize::from(index[usize::from(corner.node)])];
            self.slots[usize::from(*next)] = corner.slot;
            *next += 1;
        });
        next.truncate(elsewhere);
        self.slots.truncate(next.last().map_or(0, |end| usize::from(*end)));
        self.slots.shrink_to_fit();
        self.ends = next;
    }

    /// Returns the memory held, bytes.
    pub fn bytes(&self) -> usize {
        4 * self.groups.capacity() + 2 * (self.nodes.capacity() + self.ends.capacity() + self.slots.capacity())
    }
}
