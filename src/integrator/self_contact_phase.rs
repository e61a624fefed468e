//! Self-contact of a tick: the contacts of the gel with itself, and the nodes that they strike between their ticks.

use super::model::DiscreteModel;
use super::substep::{GroupTicks, MeshPhase};
use super::surface_at_tick::SurfaceAtTick;
use super::tick_nodes::TickNodes;
use super::workspace::PassiveNode;
use crate::contact::{
    FacetProximity, NodePlaces, SelfContact, SeparationList, SurfaceMotion, SurfaceStars, look_at_facet,
};
use crate::fem::Potential;
use crate::math::Vector;
use crate::mesh::NodeId;
use crate::state::Tick;

/// Part of the travel up to contact that a node and a facet are each left to travel unseen; it is below a half by more
/// than rounding.
const QUIET_PART: f64 = 0.499;

/// Self-contact phase: reads the surface and the clocks, and writes the contacts of the gel with itself.
pub(super) struct SelfContactPhase<'a, const D: usize, P> {
    pub surface: SurfaceAtTick<'a, D, P>,
    pub ticks: GroupTicks<'a>,
    /// Travel of each batch of nodes so far, m.
    pub batch_travel: &'a [f64],
    /// Travel of the fastest node so far, m.
    pub node_travel: f64,
    pub separation: &'a mut Option<Box<SeparationList<D>>>,
    pub contacts: &'a mut Vec<SelfContact<D>>,
    pub passive_nodes: &'a mut Vec<PassiveNode<D>>,
}

/// Nodes at a time, s.
struct SurfaceNodes<'a, const D: usize> {
    nodes: TickNodes<'a, D>,
    time: f64,
}

impl<const D: usize> NodePlaces<D> for SurfaceNodes<'_, D> {
    #[inline]
    fn place(&self, node: NodeId) -> Vector<D> {
        self.nodes.position_at(node, self.time)
    }
}

impl<const D: usize, P: Potential<D>> SelfContactPhase<'_, D, P> {
    /// Finds the contacts of the gel with itself, by node and facet, whether their nodes are active or not: an impulse
    /// may change the velocity of a node of another contact.
    pub fn find_self_contacts(mut self) {
        let Self { surface, ticks, batch_travel: travel, node_travel, separation, contacts, .. } = &mut self;
        let gel = &surface.model.gel;
        let nodes = || SurfaceNodes { nodes: surface.nodes, time: surface.time() };
        let motion = || SurfaceMotion { surface: &gel.surface, travel, nodes: nodes() };
        let stars =
            || SurfaceStars::new(&gel.surface, |node| gel.star.of(node), |element| gel.potential.nodes(element));
        if separation.is_none() && gel.meets_itself {
            **separation = Some(Box::new(SeparationList::new(&motion(), stars())));
        }
        let Some(list) = separation else { return };
        contacts.clear();
        list.update(&motion());
        let time_ahead = |nodes: &[NodeId]| time_ahead(surface, ticks, nodes);
        for close in list.close().iter_mut().filter(|close| close.may_be_in_reach(*node_travel)) {
            match look_at_facet(surface, close.node, close.facet, time_ahead) {
                FacetProximity::Contact(contact) => contacts.push(contact),
                FacetProximity::Apart(distance) => close.quiet_until = *node_travel + QUIET_PART * distance,
                FacetProximity::Aside => {}
            }
        }
        contacts.sort_unstable_by_key(SelfContact::key);
        self.find_passive_nodes();
    }

    /// Finds the nodes of the contacts that do not move at this tick.
    fn find_passive_nodes(self) {
        let Self { surface, ticks, contacts, passive_nodes: passive, .. } = self;
        let DiscreteModel { gel, layout, .. } = surface.model;
        let last_tick_around = |node: NodeId| {
            let groups = gel.star.of(node).iter().map(|element| layout.group(*element));
            groups.map(|group| ticks.last(group)).fold(ticks.moment.origin, Tick::max)
        };
        passive.clear();
        let carriers = contacts.iter().flat_map(SelfContact::carriers).map(|(node, _)| node);
        passive.extend(carriers.filter(|node| !surface.nodes.active.has(node.index())).map(|node| PassiveNode {
            node,
            before: surface.nodes.velocity[node.index()],
            last: last_tick_around(node),
        }));
        passive.sort_unstable_by_key(|passive| passive.node);
        passive.dedup_by_key(|passive| passive.node);
    }
}

/// Returns the time until the next tick of any of these nodes, s; infinite at the last tick of a mesh.
fn time_ahead<const D: usize, P: Potential<D>>(
    surface: &SurfaceAtTick<'_, D, P>,
    ticks: &GroupTicks<'_>,
    nodes: &[NodeId],
) -> f64 {
    if ticks.moment.phase == MeshPhase::Last {
        return f64::INFINITY;
    }
    nodes.iter().map(|node| surface.time_to_next_tick(ticks, *node)).fold(f64::INFINITY, f64::min)
}
