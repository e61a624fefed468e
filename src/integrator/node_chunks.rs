//! Nodal data in chunks, the unit in which threads share them and sums are formed.

use super::active_set::{NODE_BATCH, RUN};
use super::kick_sums::KickSums;
use super::pool::SplitWork;
use crate::math::Vector;
use crate::state::Tick;

/// Nodal data from a first chunk on, and the sums of each chunk.
pub(super) struct NodeChunks<'a, const D: usize> {
    /// First node.
    pub first: usize,
    pub position: &'a mut [Vector<D>],
    pub velocity: &'a mut [Vector<D>],
    /// Velocities before the kicks of the tick, m/s.
    pub before: &'a mut [Vector<D>],
    /// Last ticks.
    pub last: &'a mut [Tick],
    /// Stable limits, s.
    pub limit: &'a mut [f64],
    /// Carried kick work Q = ½ p·(v⁺ − v⁻) of the last kicks (A6), J.
    pub excess: &'a mut [f64],
    /// Relative changes of velocity by damping.
    pub decay: &'a mut [f64],
    /// Bounds of the speeds of the batches, m/s.
    pub speeds: &'a mut [f64],
    pub sums: &'a mut [KickSums],
}

impl<const D: usize> SplitWork for NodeChunks<'_, D> {
    /// Splits by the number of chunks.
    fn split_at_part(self, part: usize, of: usize) -> (Self, Self) {
        let chunks = self.sums.len() * part / of;
        let at = self.position.len().min(chunks * RUN);
        let (position, more_position) = self.position.split_at_mut(at);
        let (velocity, more_velocity) = self.velocity.split_at_mut(at);
        let (before, more_before) = self.before.split_at_mut(at);
        let (last, more_last) = self.last.split_at_mut(at);
        let (limit, more_limit) = self.limit.split_at_mut(at);
        let (excess, more_excess) = self.excess.split_at_mut(at);
        let (decay, more_decay) = self.decay.split_at_mut(at);
        let (speeds, more_speeds) = self.speeds.split_at_mut(at.div_ceil(NODE_BATCH));
        let (sums, more_sums) = self.sums.split_at_mut(chunks);
        let more = Self {
            first: self.first + at,
            position: more_position,
            velocity: more_velocity,
            before: more_before,
            last: more_last,
            limit: more_limit,
            excess: more_excess,
            decay: more_decay,
            speeds: more_speeds,
            sums: more_sums,
        };
        (Self { first: self.first, position, velocity, before, last, limit, excess, decay, speeds, sums }, more)
    }
}
