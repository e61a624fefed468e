//! Model: what does not change while a mesh lasts.

use super::element_order::ElementLayout;
use super::{DiscreteGel, GelFrame, IntegratorSettings, TickGrid};
use crate::contact::{FreeDirections, RigidBody};
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
}
