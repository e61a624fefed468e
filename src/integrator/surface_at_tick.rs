//! Surface of the gel at a tick, as contact sees it.

use super::DiscreteGel;
use super::model::DiscreteModel;
use super::substep::GroupTicks;
use super::tick_nodes::TickNodes;
use crate::contact::{BodyState, ContactSurface, SurfaceView, TickBodies};
use crate::fem::Potential;
use crate::math::Vector;
use crate::mesh::NodeId;

/// Surface of the gel at a tick, as contact sees it.
pub(super) struct SurfaceAtTick<'a, const D: usize, P> {
    pub model: &'a DiscreteModel<D, P>,
    pub nodes: TickNodes<'a, D>,
    /// Bodies before the impulses of the tick.
    pub bodies: &'a [BodyState],
}

impl<'a, const D: usize, P> SurfaceAtTick<'a, D, P> {
    /// Returns the bodies before the impulses of the tick.
    pub fn bodies(&self) -> TickBodies<'a> {
        TickBodies { rigid: &self.model.bodies, at: self.bodies }
    }

    /// Returns the time of the tick, s.
    #[inline]
    pub fn time(&self) -> f64 {
        self.bodies[0].time
    }
}

impl<const D: usize, P: Potential<D>> SurfaceAtTick<'_, D, P> {
    /// Returns the time until the next tick of a node, s.
    pub fn time_to_next_tick(&self, ticks: &GroupTicks<'_>, node: NodeId) -> f64 {
        let DiscreteModel { gel, layout, grid, .. } = self.model;
        let groups = gel.star.of(node).iter().map(|element| layout.group(*element));
        let ahead = groups.map(|group| ticks.ahead(group)).filter(|ahead| *ahead > 0);
        ahead.min().map_or(f64::INFINITY, |ahead| grid.time(ahead))
    }
}

impl<const D: usize, P: Potential<D>> SurfaceView<D> for SurfaceAtTick<'_, D, P> {
    type Masses = DiscreteGel<D, P>;

    #[inline]
    fn masses(&self) -> &DiscreteGel<D, P> {
        &self.model.gel
    }

    #[inline]
    fn surface(&self) -> &ContactSurface {
        &self.model.gel.surface
    }

    #[inline]
    fn position(&self, node: NodeId) -> Vector<D> {
        self.nodes.position[node.index()]
    }

    #[inline]
    fn drifted(&self, node: NodeId) -> Vector<D> {
        self.nodes.position_at(node, self.time())
    }

    #[inline]
    fn velocity(&self, node: NodeId) -> Vector<D> {
        self.nodes.velocity[node.index()]
    }

    #[inline]
    fn velocity_before(&self, node: NodeId) -> Vector<D> {
        self.nodes.velocity_before(node)
    }
}
