//! Symmetry contact of the gel with its mirror image: no surface node passes the axis of revolution or a plane of
//! symmetry (numerics 2.9).

use super::SurfaceNode;
use super::contact_solver::TOUCH_TOLERANCE;
use super::kick_sums::ConstraintReaction;
use super::neighbour_list::STRETCH;
use super::substep::MeshPhase;
use super::system::DiscreteSystem;
use crate::contact::impulse;
use crate::fem::Potential;
use crate::math::{Vector, embed};
use crate::mesh::NodeId;
use crate::state::Tick;

/// Symmetry contact of a surface node that may reach its mirror image until its next tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct SymmetryContact {
    /// Surface node.
    pub node: NodeId,
    /// Axis normal to the plane of symmetry.
    axis: usize,
    /// −x/Δt, the velocity that brings the node to the plane, m/s; zero for a node beyond the plane, which is only
    /// stopped.
    min_velocity: f64,
    /// u⁻, velocity of the node away from the plane before the tick, m/s.
    before: f64,
    /// J, accumulated impulse away from the plane, N·s.
    impulse: f64,
}

/// Finds the active surface nodes that may reach their image, ascending: those nearer to it than their size, or
/// than twice their path to their next tick.
pub(super) fn find_symmetry_contacts<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    let mut meetings = std::mem::take(&mut system.workspace.meetings);
    meetings.clear();
    if !system.model.gel.mirrored.is_empty() {
        let (active, surface) = (&system.workspace.active, &system.model.gel.surface);
        if let Some(few) = active.listed_nodes() {
            let reached = few.iter().filter_map(|node| surface.of[*node as usize]);
            reached.for_each(|at| meetings.extend(symmetry_contacts_of(system, &surface.nodes[at as usize], tick)));
            meetings.sort_unstable_by_key(|meeting| (meeting.node, meeting.axis));
        } else {
            // Surface nodes are stored in ascending order.
            let reached = surface.nodes.iter().filter(|at| active.has(at.node.index()));
            reached.for_each(|at| meetings.extend(symmetry_contacts_of(system, at, tick)));
        }
    }
    system.workspace.meetings = meetings;
}

/// Iterates over the symmetry contacts of a surface node, one per plane that it may reach.
fn symmetry_contacts_of<'a, const D: usize, P: Potential<D>>(
    system: &'a DiscreteSystem<D, P>,
    at: &SurfaceNode,
    tick: Tick,
) -> impl Iterator<Item = SymmetryContact> + use<'a, D, P> {
    let SurfaceNode { node, size, .. } = *at;
    let a = node.index();
    let (x, v) = (system.state.position[a], system.state.velocity[a]);
    // At the last tick of a mesh there is no step ahead: a node at the plane is held there.
    let is_last = system.clock.phase == MeshPhase::Last;
    let may_reach_image = move |axis: usize| {
        x[axis] < size
            || x[axis] < STRETCH * size && x[axis] < 2.0 * v[axis].abs() * time_to_next_tick(system, node, tick)
    };
    let is_candidate =
        move |axis: usize| if is_last { x[axis] < TOUCH_TOLERANCE * size } else { may_reach_image(axis) };
    let has_contact = move |axis: &usize| !system.model.gel.held(a)[*axis] && is_candidate(*axis);
    let meeting = move |axis: usize| {
        let min_velocity = if is_last { 0.0 } else { (-x[axis] / time_to_next_tick(system, node, tick)).min(0.0) };
        SymmetryContact { node, axis, min_velocity, before: system.velocity_before(node)[axis], impulse: 0.0 }
    };
    system.model.gel.mirrored.iter().copied().filter(has_contact).map(meeting)
}

/// Returns the time until the next tick of a node, s.
fn time_to_next_tick<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, node: NodeId, tick: Tick) -> f64 {
    let groups = system.model.gel.star.of(node).iter().map(|element| system.model.layout.group(*element));
    let ahead = groups.map(|group| system.ahead(group, tick)).filter(|ahead| *ahead > 0);
    ahead.min().map_or(f64::INFINITY, |ahead| system.model.grid.time(ahead))
}

/// Corrects all impulses between nodes and their images once; returns the greatest change of a velocity, m/s.
pub(super) fn correct_symmetry_contacts<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) -> f64 {
    (0..system.workspace.meetings.len()).map(|i| correct_symmetry_impulse(system, i)).fold(0.0, f64::max)
}

/// Corrects the impulse between a node and its image once; returns the change of velocity, m/s. The image has the
/// same mass and the mirrored velocity, so its impulse is that of a wall at rest.
fn correct_symmetry_impulse<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, i: usize) -> f64 {
    let SymmetryContact { node, axis, min_velocity, impulse: accumulated, .. } = system.workspace.meetings[i];
    let (a, compliance) = (node.index(), 1.0 / system.model.gel.mass[node.index()]);
    let free = system.state.velocity[a][axis] - compliance * accumulated;
    let change = impulse(free, min_velocity, compliance) - accumulated;
    if change.abs() <= f64::EPSILON * accumulated {
        return 0.0;
    }
    system.workspace.meetings[i].impulse += change;
    system.state.velocity[a][axis] += compliance * change;
    compliance * change.abs()
}

/// Posts the work of the symmetry contacts, Σ J (u⁻ + u⁺)/2, and their momentum, which the plane's restraint
/// gives.
pub(super) fn book_symmetry_contacts<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let mut taken = ConstraintReaction::default();
    for SymmetryContact { node, axis, before, impulse, .. } in &system.workspace.meetings {
        let a = node.index();
        system.state.ledger.energy.contact += 0.5 * impulse * (before + system.state.velocity[a][*axis]);
        let push = embed(&Vector::<D>::from_fn(|i, _| if i == *axis { *impulse } else { 0.0 }));
        taken.add_reaction(system.freedom(), (embed(&system.state.position[a]), push));
    }
    taken.post(&mut system.state.ledger);
}
