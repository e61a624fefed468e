//! Self-contact of a tick: the contacts of the gel with itself, and the nodes that they strike between their ticks.

use super::SteppingSchedule;
use super::contact_phase::{SurfaceAtTick, time_to_next_tick};
use super::substep::MeshPhase;
use super::system::DiscreteSystem;
use super::workspace::PassiveNode;
use crate::contact::{
    FacetProximity, NodePlaces, SelfContact, SeparationList, SurfaceMotion, SurfaceStars, SurfaceView, look_at_facet,
};
use crate::fem::Potential;
use crate::math::Vector;
use crate::mesh::NodeId;
use crate::state::Tick;

/// Part of the travel up to contact that a node and a facet are each left to travel unseen; it is below a half by more
/// than rounding.
const QUIET_PART: f64 = 0.499;

/// Returns the separation list of the surface with its nodes where they are at a time, s, if the gel can meet itself.
fn separation_list<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    time: f64,
) -> Option<Box<SeparationList<D>>> {
    let gel = &system.model.gel;
    let stars = || SurfaceStars::new(&gel.surface, |node| gel.star.of(node), |element| gel.potential.nodes(element));
    let (travel, nodes) = (system.batch_travel.travel(), SurfaceNodes { system, time });
    let at = SurfaceMotion { surface: &gel.surface, travel, nodes };
    gel.meets_itself.then(|| Box::new(SeparationList::new(&at, stars())))
}

/// Nodes of a system at a time, s.
struct SurfaceNodes<'a, const D: usize, P> {
    system: &'a DiscreteSystem<D, P>,
    time: f64,
}

impl<const D: usize, P: Potential<D>> NodePlaces<D> for SurfaceNodes<'_, D, P> {
    #[inline]
    fn place(&self, node: NodeId) -> Vector<D> {
        self.system.position_at(node, self.time)
    }
}

/// Finds the contacts of the gel with itself, by node and facet, whether their nodes are active or not: an impulse may
/// change the velocity of a node of another contact.
pub(super) fn find_self_contacts<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    let time = system.model.grid.time(tick);
    let Some(mut list) = system.separation.take().or_else(|| separation_list(system, time)) else { return };
    let mut contacts = std::mem::take(&mut system.workspace.self_contacts);
    contacts.clear();
    let surface = SurfaceAtTick::of(system);
    let (travel, nodes) = (system.batch_travel.travel(), SurfaceNodes { system, time });
    list.update(&SurfaceMotion { surface: surface.surface(), travel, nodes });
    let (travel, time_ahead) =
        (system.contact.neighbours.node_travel(), |nodes: &[NodeId]| time_ahead(system, nodes, tick));
    for close in list.close().iter_mut().filter(|close| close.may_be_in_reach(travel)) {
        match look_at_facet(&surface, close.node, close.facet, time_ahead) {
            FacetProximity::Contact(contact) => contacts.push(contact),
            FacetProximity::Apart(distance) => close.quiet_until = travel + QUIET_PART * distance,
            FacetProximity::Aside => {}
        }
    }
    contacts.sort_unstable_by_key(SelfContact::key);
    system.separation = Some(list);
    system.workspace.self_contacts = contacts;
    find_passive_nodes(system, tick);
}

/// Returns the time until the next tick of any of these nodes, s; infinite at the last tick of a mesh.
fn time_ahead<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, nodes: &[NodeId], tick: Tick) -> f64 {
    if system.clock.phase == MeshPhase::Last {
        return f64::INFINITY;
    }
    nodes.iter().map(|node| time_to_next_tick(system, *node, tick)).fold(f64::INFINITY, f64::min)
}

/// Finds the nodes of the contacts that do not move at this tick.
fn find_passive_nodes<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    let mut passive = std::mem::take(&mut system.workspace.passive_nodes);
    passive.clear();
    let carriers = system.workspace.self_contacts.iter().flat_map(SelfContact::carriers).map(|(node, _)| node);
    passive.extend(carriers.filter(|node| !system.workspace.active_nodes.has(node.index())).map(|node| PassiveNode {
        node,
        before: system.state.velocity[node.index()],
        last: last_tick_around(system, node, tick),
    }));
    passive.sort_unstable_by_key(|passive| passive.node);
    passive.dedup_by_key(|passive| passive.node);
    system.workspace.passive_nodes = passive;
}

/// Returns the last tick of the groups at a node.
fn last_tick_around<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, node: NodeId, tick: Tick) -> Tick {
    let last = |group: usize| match system.model.settings.schedule {
        SteppingSchedule::Bins => tick & !system.state.clocks[group].step.saturating_sub(1),
        SteppingSchedule::Queue => system.state.alarms[group].last,
        SteppingSchedule::Global => tick,
    };
    let groups = system.model.gel.star.of(node).iter().map(|element| system.model.layout.group(*element));
    groups.map(last).fold(system.clock.origin, Tick::max)
}

/// Moves the passive nodes that the contacts have struck onto the paths that lead through their places at this tick with
/// their new velocities: the state holds each node as it is at its last tick.
pub(super) fn rebase_passive_nodes<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    for i in 0..system.workspace.passive_nodes.len() {
        let PassiveNode { node, before, last } = system.workspace.passive_nodes[i];
        let (a, passed) = (node.index(), system.model.grid.time(tick - last));
        let change = system.state.velocity[a] - before;
        if change != Vector::<D>::zeros() {
            system.state.position[a] -= change * passed;
            system.clock.last_ticks[a] = last;
            system.note_speed(a);
        }
    }
}
