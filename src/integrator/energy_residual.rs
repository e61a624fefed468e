//! Energy residual of the steps of element groups, r_K = ΔV + A_last + W − A_now (`docs/method/ledger.md`).
//!
//! V is the stored energy of a group at its last tick, A the work of its last kick in the half of the step ahead. W, the
//! work of the kicks, is summed at the nodes and not here.

use super::TickGrid;
use super::blocks::ElementBlocks;
use super::substep::{MeshPhase, TickContext};
use crate::fem::{Dissipation, GroupResponse};
use crate::state::GroupClock;

impl<const D: usize> ElementBlocks<D> {
    /// Updates the clocks of the active groups from their responses at this tick. Returns Σ (r_K − W), J, and the
    /// dissipation of these groups, both summed block by block.
    pub fn update_clocks(
        &self,
        grid: TickGrid,
        moment: TickContext,
        clocks: &mut [GroupClock],
        responses: &[GroupResponse],
    ) -> (f64, Dissipation) {
        let (mut residual, mut dissipation) = (0.0, Dissipation::default());
        let of_blocks = clocks.chunks_mut(self.groups).zip(responses.chunks(self.groups));
        // A block at rest at the first tick of a mesh was swept once and not again.
        let is_first = moment.phase == MeshPhase::First;
        let swept = self.all.iter().zip(of_blocks).filter(|(block, _)| is_first || block.report.is_some());
        for (block, (clocks, responses)) in swept {
            let active = clocks.iter_mut().zip(responses).filter(|(clock, _)| moment.is_active(clock.step));
            let mut own = 0.0;
            for (clock, response) in active {
                own += update_clock(clock, response, grid.time(moment.ahead(clock.step)));
            }
            residual += own;
            dissipation += block.dissipation;
        }
        (residual, dissipation)
    }
}

/// Updates a clock from the response of its group and the length of its step ahead, s. Returns r_K − W, J.
///
/// Zeros lose their sign: a block at rest that is swept again, as after a restart, may find the other one.
pub(super) fn update_clock(clock: &mut GroupClock, response: &GroupResponse, ahead: f64) -> f64 {
    let work_ahead = 0.5 * ahead * response.power;
    let residual = response.energy - clock.energy + clock.ahead - work_ahead;
    (clock.energy, clock.ahead) = (response.energy + 0.0, work_ahead + 0.0);
    (clock.inverted, clock.crushed) = (response.inverted, response.crushed);
    residual
}
