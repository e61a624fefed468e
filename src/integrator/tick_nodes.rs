//! Nodes at a tick, as the phases read them.

use super::TickGrid;
use super::active_set::ActiveSet;
use crate::math::Vector;
use crate::mesh::NodeId;
use crate::state::Tick;

/// Nodes at a tick: their paths from their last ticks on, and their velocities before the kicks of this one.
#[derive(Debug, Clone, Copy)]
pub(super) struct TickNodes<'a, const D: usize> {
    pub grid: TickGrid,
    /// Position of each node at its last tick, m.
    pub position: &'a [Vector<D>],
    /// Present velocities, m/s.
    pub velocity: &'a [Vector<D>],
    pub last_ticks: &'a [Tick],
    pub active: &'a ActiveSet,
    /// Velocities of the active nodes before the kicks, m/s.
    pub before: &'a [Vector<D>],
}

impl<const D: usize> TickNodes<'_, D> {
    /// Returns the position of a node drifted to time `t`, m.
    #[inline]
    pub fn position_at(&self, node: NodeId, t: f64) -> Vector<D> {
        let a = node.index();
        self.position[a] + self.velocity[a] * (t - self.grid.time(self.last_ticks[a]))
    }

    /// Returns the velocity of a node before the kicks of this tick, m/s.
    #[inline]
    pub fn velocity_before(&self, node: NodeId) -> Vector<D> {
        let a = node.index();
        if self.active.has(a) { self.before[a] } else { self.velocity[a] }
    }
}
