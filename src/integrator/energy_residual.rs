//! Energy residuals of the steps, and the update of the clocks of active groups (numerics A6).

use super::blocks::ElementBlocks;
use super::element_block::{ElementBlock, StepResidual};
use super::element_loop::count_for_share;
use super::pool::{SplitWork, share_work};
use super::substep::{MeshPhase, TickContext};
use super::{TickGrid, WorkerPool};
use crate::fem::GroupResponse;
use crate::state::GroupClock;

/// Update of the clocks of some consecutive blocks from the responses of their groups.
struct ClockUpdate<'a> {
    blocks: &'a mut [ElementBlock],
    clocks: &'a mut [GroupClock],
    responses: &'a [GroupResponse],
    /// Groups per block.
    groups: usize,
}

impl SplitWork for ClockUpdate<'_> {
    /// Splits by the number of elements to sweep.
    fn split_at_part(self, part: usize, of: usize) -> (Self, Self) {
        let Self { blocks, clocks, responses, groups } = self;
        let middle = count_for_share(blocks, part as f64 / of as f64);
        let at = clocks.len().min(middle * groups);
        let (blocks, more_blocks) = blocks.split_at_mut(middle);
        let (clocks, more_clocks) = clocks.split_at_mut(at);
        let (responses, more_responses) = responses.split_at(at);
        let more = Self { blocks: more_blocks, clocks: more_clocks, responses: more_responses, groups };
        (Self { blocks, clocks, responses, groups }, more)
    }
}

/// Input of the clock update: the tick and the responses of all groups.
#[derive(Clone, Copy)]
pub(super) struct ClockInput<'a> {
    pub grid: TickGrid,
    pub moment: TickContext,
    pub responses: &'a [GroupResponse],
}

/// Number of element updates above which the clock update is shared, 0.25 ns each: 169 200 elements take 41 µs on
/// one thread and 30 on two spinning ones.
const MIN_SHARED_UPDATES: u64 = 50_000;

impl<const D: usize> ElementBlocks<D> {
    /// Takes the responses of all active groups into their clocks, block by block; the sum does not depend on the
    /// threads.
    pub fn update_clocks(
        &mut self,
        input: ClockInput<'_>,
        clocks: &mut [GroupClock],
        pool: Option<&WorkerPool>,
    ) -> StepResidual {
        let ClockInput { grid, moment, responses } = input;
        let updates = self.all.iter().filter_map(|block| block.report).map(|report| report.updates).sum::<u64>();
        let pool = pool.filter(|_| updates > MIN_SHARED_UPDATES);
        let ahead = |clock: &GroupClock| grid.time(moment.ahead(clock.step));
        // A block at rest at the first tick of a mesh was swept once and not again.
        let answered = |block: &ElementBlock| block.report.is_some() || moment.phase == MeshPhase::First;
        let n_blocks = self.all.len();
        let work = ClockUpdate { blocks: &mut self.all, clocks, responses, groups: self.groups };
        share_work(pool, n_blocks, work, |update| {
            let of_blocks = update.clocks.chunks_mut(update.groups).zip(update.responses.chunks(update.groups));
            let swept = update.blocks.iter_mut().zip(of_blocks).filter(|(block, _)| answered(block));
            for (block, (clocks, responses)) in swept {
                // One pass with a local sum; a sum in the block would be written and read again for each group.
                let mut residual = 0.0;
                for (clock, response) in
                    clocks.iter_mut().zip(responses).filter(|(clock, _)| moment.is_active(clock.step))
                {
                    residual += update_clock(clock, response, ahead(clock));
                }
                block.step_residual = StepResidual { residual, dissipation: block.dissipation };
            }
        });
        let swept = self.all.iter().filter(|block| answered(block));
        swept.fold(StepResidual::default(), |sum, block| sum.merge(&block.step_residual))
    }
}

/// Takes a response into a clock; returns the change of V and A, J. Zeros lose their sign, because a block at rest
/// that is swept again, as after a restart, may find the other one.
pub(super) fn update_clock(clock: &mut GroupClock, response: &GroupResponse, step: f64) -> f64 {
    let ahead = 0.5 * step * response.power;
    let residual = response.energy - clock.energy + clock.ahead - ahead;
    (clock.energy, clock.ahead) = (response.energy + 0.0, ahead + 0.0);
    (clock.inverted, clock.crushed) = (response.inverted, response.crushed);
    residual
}
