//! Model: what does not change while a mesh lasts.

use super::element_order::ElementLayout;
use super::gel_frame::{BlockMotion, GelFrame};
use super::{DiscreteGel, IntegratorSettings, TickGrid};
use crate::contact::{FreeDirections, RigidBody};
use crate::state::OutsideImpulse;
use std::sync::Arc;

/// Model: what does not change while the mesh lasts.
#[derive(Debug)]
pub(super) struct DiscreteModel<const D: usize, P> {
    /// Gel with its masses, elements and surface.
    pub gel: Arc<DiscreteGel<D, P>>,
    /// Layout of the elements in slots and groups.
    pub layout: Arc<ElementLayout>,
    /// Constant properties of the bodies.
    pub bodies: Vec<RigidBody>,
    /// Frame of the block.
    pub frame: GelFrame,
    pub settings: IntegratorSettings,
    pub grid: TickGrid,
}

impl<const D: usize, P> DiscreteModel<D, P> {
    /// Returns the directions of motion that the dimension leaves to every body.
    pub fn freedom(&self) -> FreeDirections {
        self.bodies[0].freedom
    }

    /// Returns the rigid motion of the block at a time, s, after these impulses.
    pub fn block_motion(&self, outside: &OutsideImpulse, time: f64) -> BlockMotion {
        self.frame.motion(outside, time)
    }
}
