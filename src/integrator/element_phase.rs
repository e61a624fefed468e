//! Forces of a tick: evaluates the active elements at their drifted nodes and finds those that fail.

use super::active_set::ActiveSet;
use super::blocks::{ElementBlocks, MIN_SHARED_ELEMENTS};
use super::element_loop::{ElementLoopInput, is_failure};
use super::element_order::ElementLayout;
use super::{StepError, WorkerPool};
use crate::fem::GroupResponse;
use crate::mesh::ElementId;
use crate::state::GroupClock;

/// Element phase of the SIMD form: reads the nodes and clocks, writes stiffness, responses and active nodes.
pub(super) struct ElementPhase<'a, const D: usize> {
    pub input: ElementLoopInput<'a, D>,
    pub pool: Option<&'a WorkerPool>,
    pub blocks: &'a mut ElementBlocks<D>,
    pub stiffness: &'a mut [f64],
    pub responses: &'a mut [GroupResponse],
    pub active_nodes: &'a mut ActiveSet,
}

impl<const D: usize> ElementPhase<'_, D> {
    /// Evaluates the forces of the active elements at their drifted nodes.
    pub fn evaluate(self) {
        let n_elements = self.blocks.find_active(&self.input);
        let pool = self.pool.filter(|_| n_elements > MIN_SHARED_ELEMENTS);
        self.blocks.sweep(&self.input, self.stiffness, self.responses, pool);
        self.blocks.find_active_nodes(self.active_nodes);
    }
}

/// Results of the element phase, in which failed elements are found.
pub(super) struct ElementResults<'a, const D: usize> {
    pub layout: &'a ElementLayout,
    pub clocks: &'a [GroupClock],
    pub responses: &'a [GroupResponse],
    pub blocks: Option<&'a ElementBlocks<D>>,
    /// Active groups of the reference form.
    pub active_groups: &'a [u32],
}

impl<const D: usize> ElementResults<'_, D> {
    /// Finds the failed element of this tick, if any: one that is inverted for the second tick in a row or whose energy
    /// is not a number.
    pub fn find_failure(&self, time: f64) -> Option<StepError> {
        let fails = |group: &usize| is_failure(&self.clocks[*group], &self.responses[*group]);
        let failed = match self.blocks {
            Some(blocks) => blocks.all.iter().filter_map(|block| block.report?.failed_group).max_by_key(|group| {
                // An energy that is not a number is reported before an inverted element.
                (!self.responses[*group].energy.is_finite(), std::cmp::Reverse(*group))
            }),
            None => self.active_groups.iter().map(|group| *group as usize).find(fails),
        };
        failed.map(|group| self.describe_failure(group, time))
    }

    /// Describes the failure of a group: which element, inverted or not finite.
    fn describe_failure(&self, group: usize, time: f64) -> StepError {
        let (response, clock, slots) = (&self.responses[group], &self.clocks[group], self.layout.slots(group));
        let twice = response.inverted & clock.inverted;
        if response.energy.is_finite() {
            let slot = slots.start + twice.trailing_zeros() as usize;
            let element = self.layout.element(slot).map_or(0, ElementId::index);
            return StepError::Inverted { element, time, jacobian: response.least_jacobian };
        }
        let element = self.layout.elements(slots).next().map_or(0, ElementId::index);
        StepError::NotFinite { element, time }
    }
}
