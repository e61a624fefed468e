//! Step monitor of a block: which stable limits of its nodes can change a step.

use super::TickGrid;
use super::element_block::ElementBlock;
use crate::fem::ElementBatches;
use crate::state::GroupClock;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Factor by which the stable step must exceed a step before that step may be doubled.
pub(super) const RAISE_MARGIN: f64 = 4.0;

/// Monitor of the stable limits in a block: it tells which limits of nodes can change a step.
#[derive(Debug, Default)]
pub(super) struct StepMonitor {
    /// True if the part of the block contributes impulses at this tick.
    pub contributes: bool,
    /// Limits of any node that change no step of the block, s: from the first on and below the second.
    hold_range: (f64, f64),
    /// Limits of each node that change no step, s, at least as wide; empty where all groups have one step and no
    /// limit has left the range of the block.
    node_hold_ranges: Vec<(f64, f64)>,
    /// True if a node has found a limit that may change a step.
    is_check_requested: AtomicBool,
}

impl StepMonitor {
    /// Finds the limits, s, of each node that leave the steps of these groups unchanged; unknown `limits` are
    /// infinite.
    ///
    /// A limit below a step shortens the step, at any node. No step is raised while one node of the group has a
    /// limit below [`RAISE_MARGIN`] steps. If such a limit is known, only the node with the least one is watched;
    /// otherwise all are.
    pub fn watch<const D: usize>(
        &mut self,
        n_nodes: usize,
        groups: Range<usize>,
        lanes: &ElementBatches<D>,
        clocks: &[GroupClock],
        grid: TickGrid,
        limits: &[f64],
    ) {
        self.node_hold_ranges.clear();
        self.node_hold_ranges.resize(n_nodes, (0.0, f64::INFINITY));
        for group in groups {
            let step = grid.time(clocks[group].step);
            let (mut least, raised) = ((f64::INFINITY, 0), RAISE_MARGIN * step);
            lanes.nodes(group, |number| {
                let number = usize::from(number);
                self.node_hold_ranges[number].0 = self.node_hold_ranges[number].0.max(step);
                let limit = limits.get(number).copied().unwrap_or(f64::INFINITY);
                least = if limit < least.0 { (limit, number) } else { least };
            });
            let mut bound =
                |number: usize| self.node_hold_ranges[number].1 = self.node_hold_ranges[number].1.min(raised);
            if least.0 < raised { bound(least.1) } else { lanes.nodes(group, |number| bound(usize::from(number))) }
        }
    }

    /// Sets the limits of any node that change no step, from the least and greatest step of the block, s.
    pub fn hold(&mut self, least: f64, most: f64) {
        self.hold_range = (most, RAISE_MARGIN * least);
        self.node_hold_ranges.clear();
    }

    /// Returns the memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + 16 * self.node_hold_ranges.capacity()
    }

    /// Prepares the monitor at the start of the node loop of a tick.
    pub fn prepare(&mut self, block: &ElementBlock) {
        self.contributes = block.contributes();
        *self.is_check_requested.get_mut() = !block.may_hold_steps();
    }

    /// Returns true if limits in this range, s, at any nodes leave all steps unchanged.
    #[inline]
    pub fn holds_for_all(&self, least: f64, most: f64) -> bool {
        self.hold_range.0 <= least && most < self.hold_range.1
    }

    /// Returns true if this limit, s, of a node, by its local number, leaves all steps unchanged.
    #[inline]
    pub fn holds_at(&self, number: usize, limit: f64) -> bool {
        // The range of the block is the narrower one and is tried first.
        self.holds_for_all(limit, limit)
            || self.node_hold_ranges.get(number).is_some_and(|own| own.0 <= limit && limit < own.1)
    }

    /// Requests a check of the steps of the block.
    pub fn request_check(&self) {
        self.is_check_requested.store(true, Ordering::Relaxed);
    }

    /// Returns true if no limit may change a step.
    pub fn holds_steps(&mut self) -> bool {
        !*self.is_check_requested.get_mut()
    }
}
