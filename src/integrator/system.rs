//! Semi-discrete system: a gel and rigid bodies, their state, and the quantities derived from it.
//!
//! Each phase of a tick sees the parts of it in its view. The model is constant, the state is stored; clock, blocks and
//! contact are derived from the state, and the workspace is of one tick.

use super::blocks::ElementBlocks;
use super::bodies::rebase_body;
use super::clock::MeshClock;
use super::gel_frame::BlockMotion;
use super::model::DiscreteModel;
use super::substep::TickContext;
use super::workspace::Workspace;
use super::{SteppingSchedule, WorkerPool};
use crate::contact::{BatchTravel, ContactDetection, SeparationList};
use crate::fem::Potential;
use crate::math::Vector;
use crate::mesh::NodeId;
use crate::state::{DynamicState, Tick};
use std::sync::Arc;

/// System of a gel and rigid bodies at a tick.
#[derive(Debug)]
pub(super) struct DiscreteSystem<const D: usize, P> {
    pub model: DiscreteModel<D, P>,
    pub state: DynamicState<D>,
    pub clock: MeshClock,
    /// Blocks of elements for the SIMD form; `None` if the potential, the schedule or the contact law needs the
    /// reference form.
    pub blocks: Option<ElementBlocks<D>>,
    pub contact: ContactDetection,
    /// Travel of the nodes by batches, if the gel can meet itself.
    pub batch_travel: BatchTravel,
    /// Separation list of the surface, once the gel can have met itself.
    pub separation: Option<Box<SeparationList<D>>>,
    pub workspace: Workspace<D>,
    pub pool: Option<Arc<WorkerPool>>,
}

impl<const D: usize, P: Potential<D>> DiscreteSystem<D, P> {
    /// Returns the rigid motion of the block at a time, s, not before the last impulse.
    pub fn block_motion(&self, time: f64) -> BlockMotion {
        self.model.frame.motion(&self.state.record.outside, time)
    }

    /// Returns true if the gel is no longer integrated.
    pub fn is_at_rest(&self) -> bool {
        self.state.record.at_rest
    }

    /// Returns the last tick that was processed.
    pub fn last_tick(&self) -> Tick {
        self.state.now.unwrap_or(self.clock.origin)
    }

    /// Returns the context of a tick: its place in the life of the mesh.
    pub fn tick_context(&self, tick: Tick) -> TickContext {
        TickContext { tick, origin: self.clock.origin, kind: self.model.settings.schedule, phase: self.clock.phase }
    }

    /// Returns the longest step of a group, ticks.
    pub fn longest_step(&self) -> Tick {
        self.clock.step_range.1
    }

    /// Returns the longest step that any group can have after this tick, ticks.
    pub fn horizon(&self) -> f64 {
        if self.state.now.is_none() { self.clock.initial_steps.1 } else { 2.0 * self.longest_step() as f64 }
    }

    /// Returns true if the mesh can end by distortion.
    pub fn can_be_distorted(&self) -> bool {
        self.clock.ends.distortion.is_some() && self.model.settings.schedule != SteppingSchedule::Queue
    }

    /// Returns true if any pressure acts on the gel.
    pub fn is_loaded(&self) -> bool {
        !self.model.gel.loads.facets.is_empty()
    }

    /// Returns true if a full tick has enough moving elements to be shared among threads.
    pub fn is_worth_sharing(&self) -> bool {
        self.blocks.as_ref().is_some_and(ElementBlocks::are_worth_sharing)
    }

    /// Returns the time of the last tick, s.
    pub fn now(&self) -> f64 {
        self.model.grid.time(self.last_tick())
    }

    /// Returns the time of the gel at a time, s: that of its last tick once it is at rest.
    pub fn time_in_gel(&self, t: f64) -> f64 {
        if self.is_at_rest() { t.min(self.now()) } else { t }
    }

    /// Returns the position of a node drifted to time `t`, m.
    #[inline]
    pub fn position_at(&self, node: NodeId, t: f64) -> Vector<D> {
        let last = self.model.grid.time(self.clock.last_ticks[node.index()]);
        self.state.drifted(node.index(), t - last)
    }

    /// Moves a body to time `t`, s, as an event and posts the work of its wrench.
    pub fn rebase_body(&mut self, body: usize, t: f64) {
        let Self { model, state, .. } = self;
        rebase_body(&model.bodies[body], &mut state.bodies[body], &mut state.ledger, t);
    }
}
