//! Block of elements for the SIMD form: 1024 slots with local node numbers.

use super::DiscreteGel;
use super::active_set::RUN;
use super::partial_block::GroupStar;
use crate::fem::{Dissipation, MAX_NODES, Potential};
use crate::mesh::{ElementId, NodeId};
use crate::state::Tick;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

/// Activity of a block at a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum BlockActivity {
    /// No group is active.
    #[default]
    Nothing,
    /// Some groups are active.
    Some,
    /// All groups are active.
    All,
}

/// Validity of the stored part of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum SweepCache {
    /// The part is not computed yet.
    #[default]
    Empty,
    /// The part has Σ κ of all elements and the impulses of the last sweep.
    Swept,
    /// The part is that of a full sweep at rest.
    AtRest,
}

/// Block of slots with local node numbers.
#[derive(Debug, Default)]
pub(super) struct ElementBlock {
    /// Nodes in ascending order; the index is the local number.
    pub nodes: Vec<NodeId>,
    /// Index of the first entry of its part.
    pub first: usize,
    /// Number of elements.
    pub n_elements: u64,
    /// Least and greatest step of its groups, ticks.
    pub steps: (Tick, Tick),
    /// Bitwise union of the steps of its groups, ticks: with bins each step is one bit.
    pub lengths: Tick,
    /// Activity at this tick, and the number of elements of the active groups.
    pub activity: BlockActivity,
    pub n_active_elements: u64,
    /// Node stars of the active groups where some are active, keyed by the longest active step.
    pub active_stars: BTreeMap<Tick, GroupStar>,
    /// Longest step of an active group where some are active, ticks.
    pub longest_active: Tick,
    /// Validity of its part.
    pub cache: SweepCache,
    /// True if a node of the block has moved or moves.
    pub awake: AtomicBool,
    /// True if a node of the block was active at this tick through another block.
    pub has_active_nodes: bool,
    /// True if a group of the block may raise its step.
    pub may_raise_step: bool,
    /// True if history variables in the block are newer than those of the state.
    pub has_unsaved_history: bool,
    /// Report of the sweep at this tick; `None` if the block was not swept.
    pub report: Option<BlockReport>,
    /// Energy stored by the groups active at the last sweep, and their dissipation since the previous tick of each.
    pub dissipation: Dissipation,
    /// Group whose response accumulates the power of all groups without their own power; `None` if each has its own.
    pub power_accumulator: Option<usize>,
}

/// Report of the sweep of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BlockReport {
    /// Number of elements evaluated that are not all at rest.
    pub updates: u64,
    /// Least J.
    pub least_jacobian: f64,
    /// True if an element of an active group inverts within its step.
    pub closes: bool,
    /// First group with an element inverted for the second tick in a row, or with an energy that is not a number.
    pub failed_group: Option<usize>,
}

impl Default for BlockReport {
    fn default() -> Self {
        Self { updates: 0, least_jacobian: 1.0, closes: false, failed_group: None }
    }
}

/// Mark of the last visit to a node: the block, counted from 1, and the local number there.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct VisitMark {
    pub block: u32,
    pub number: u16,
}

impl ElementBlock {
    pub fn new<const D: usize, P: Potential<D>>(
        gel: &DiscreteGel<D, P>,
        slots: &[Option<ElementId>],
        local: &mut [[u16; MAX_NODES]],
        block: u32,
        marks: &mut [VisitMark],
    ) -> Self {
        let elements = || slots.iter().flatten();
        let mut nodes: Vec<NodeId> = vec![];
        for node in elements().flat_map(|element| gel.potential.nodes(*element)) {
            if std::mem::replace(&mut marks[node.index()].block, block) != block {
                nodes.push(*node);
            }
        }
        nodes.sort_unstable();
        nodes.shrink_to_fit();
        nodes.iter().zip(0..).for_each(|(node, number)| marks[node.index()].number = number);
        for (slot, local) in slots.iter().zip(local) {
            let own = slot.map(|element| gel.potential.nodes(element)).unwrap_or_default();
            for (local, node) in local.iter_mut().zip(own) {
                *local = marks[node.index()].number;
            }
        }
        let n_elements = elements().count() as u64;
        Self { n_elements, awake: AtomicBool::new(true), may_raise_step: true, nodes, ..Self::default() }
    }

    /// Returns the chunks of nodes that contain its nodes.
    pub fn runs(&self) -> Vec<u32> {
        let mut runs: Vec<u32> = self.nodes.iter().map(|node| (node.index() / RUN) as u32).collect();
        runs.dedup();
        runs
    }

    /// Returns true if a node of the block has moved or moves.
    pub fn is_moving(&self) -> bool {
        self.awake.load(Ordering::Relaxed)
    }

    /// Returns true if the block must be swept at this tick; a block at rest need not after one full sweep at rest.
    pub fn needs_sweep(&self) -> bool {
        self.activity != BlockActivity::Nothing && (self.is_moving() || self.cache != SweepCache::AtRest)
    }

    /// Returns the number of elements to sweep at this tick.
    pub fn elements_to_sweep(&self) -> u64 {
        if self.needs_sweep() { self.n_active_elements } else { 0 }
    }

    /// Returns true if its part contributes impulses at this tick.
    pub fn contributes(&self) -> bool {
        self.activity != BlockActivity::Nothing && self.is_moving()
    }

    /// Returns true if all steps hold unless a node finds a new limit: all groups have begun, and no step is about to rise.
    pub fn may_hold_steps(&self) -> bool {
        self.contributes() && !self.may_raise_step && self.steps.0 > 0
    }

    /// Returns the node star of the active groups where some are active.
    ///
    /// # Panics
    /// Where none or all are active, or before the active groups are found and swept.
    pub fn active_star(&self) -> &GroupStar {
        let around = self.active_stars.get(&self.longest_active).expect("active groups are found first");
        debug_assert!(!around.nodes.is_empty(), "a sweep comes first");
        around
    }

    /// Returns the local numbers of its active nodes.
    pub fn active_nodes(&self) -> impl Iterator<Item = usize> + '_ {
        let all = if self.activity == BlockActivity::All { 0..self.nodes.len() } else { 0..0 };
        let some = if self.activity == BlockActivity::Some { self.active_star().nodes.as_slice() } else { &[] };
        all.chain(some.iter().map(|number| usize::from(*number)))
    }
}
