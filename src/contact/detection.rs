//! Broad phase of contact: finds the active surface nodes near a body at a tick, and their gaps.

use super::SurfaceNode;
use super::contact_solver::{face_depth, facet_corners, longest_edge};
use super::facet::distance_lower_bound;
use super::neighbour_list::least;
use super::step_size::find_contact_limits;
use super::system::DiscreteSystem;
use crate::contact::{BodyState, RigidBody};
use crate::fem::Potential;
use crate::geometry::{Gap, SignedDistance as _};
use crate::math::embed;
use crate::mesh::{ElementId, NodeId};
use crate::state::Tick;

/// Fraction of the allowed facet depth below which a facet needs no query; it is below 1 by more than rounding.
const DEPTH_FRACTION: f64 = 0.999;

/// Queries φ and n of the active surface nodes to the active bodies, where a body may be within reach.
pub(super) fn query_gaps<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    for surface in system.workspace.reached.drain(..) {
        system.workspace.place[surface as usize] = u32::MAX;
    }
    system.neighbours.go_on(system.model.grid.time(tick), &system.workspace.was);
    system.clock.knows_bodies = true;
    let horizon = system.horizon() * system.model.grid.time(1);
    let reach = system.neighbours.reach(&system.model.bodies, horizon);
    find_queried_nodes(system, reach);
    query_node_gaps(system, reach);
    collect_neighbours(system);
    find_contact_limits(system);
}

/// Finds the active surface nodes that need a query, ascending.
fn find_queried_nodes<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, reach: f64) {
    let (gel, watch, reached) = (&system.model.gel, &mut system.neighbours, &mut system.workspace.reached);
    if let Some(blocks) = &system.blocks {
        return watch.append_queries(&gel.surface, reach, |node| blocks.fires(node.index()), reached);
    }
    let active = system.workspace.active.reference_nodes().iter().filter_map(|a| gel.surface.of[*a as usize]);
    reached.extend(active.filter(|node| watch.needs_query(*node, gel.surface.nodes[*node as usize].size, reach)));
    reached.sort_unstable();
}

/// Queries the gaps of these nodes to each active body, and lists the nodes close to a body.
fn query_node_gaps<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, reach: f64) {
    let (scratch, n) = (&mut system.workspace, system.model.bodies.len());
    scratch.gaps.clear();
    scratch.close.clear();
    for (index, surface) in scratch.reached.iter().enumerate() {
        let SurfaceNode { node, size, .. } = system.model.gel.surface.nodes[*surface as usize];
        let point = embed(&system.state.position[node.index()]);
        let bodies = system.model.bodies.iter().zip(&scratch.was);
        scratch.gaps.extend(bodies.map(|(rigid, body)| body.active.then(|| rigid.gap(body, &point))));
        let nearest = scratch.gaps[index * n..].iter().flatten().map(|gap| gap.distance).fold(f64::INFINITY, f64::min);
        system.neighbours.set_gap(*surface, nearest);
        if nearest < size.max(reach) {
            scratch.close.push(*surface);
        }
        scratch.place[*surface as usize] = index as u32;
    }
}

/// Collects the nodes and groups around each surface node that a body comes close to, once per node.
fn collect_neighbours<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let (gel, order, scratch) = (&system.model.gel, &system.model.layout, &mut system.workspace);
    for surface in &scratch.close {
        let beside = &mut scratch.beside[*surface as usize];
        if beside.nodes.is_empty() {
            let around = || gel.star.of(gel.surface.nodes[*surface as usize].node).iter();
            beside.nodes = distinct(around().flat_map(|element| gel.potential.nodes(*element)).copied());
            beside.groups = distinct(around().map(|element| order.group(*element) as u32));
        }
    }
}

/// Updates around the queried nodes how far anything may travel before their facets need a query.
pub(super) fn update_facet_bounds<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let (gel, n) = (system.model.gel.clone(), system.model.bodies.len());
    for (index, surface) in system.workspace.reached.iter().enumerate() {
        if system.neighbours.needs_facet_query(*surface) {
            let node = gel.surface.nodes[*surface as usize].node;
            let gaps = system.workspace.gaps[index * n..][..n].iter().flatten();
            let nearest = gaps.map(|gap| gap.distance).fold(f64::INFINITY, f64::min);
            let around = gel.surface.around.of(node).iter();
            let clearance = around.map(|facet| facet_clearance(system, *facet, nearest)).fold(f64::INFINITY, least);
            system.neighbours.set_facet_bound(*surface, clearance);
        }
    }
}

/// Returns how far anything may travel before a facet with a body at distance d from a corner needs a query, m.
///
/// For blunt bodies it is the travel until the facet can reach the allowed depth, as the least φ on it falls by
/// at most the travel s. For other bodies a facet needs no query while d exceeds twice its length l, as no corner
/// is then nearer than d − l ≥ l. d falls by at most s, and l grows by at most 2s.
fn facet_clearance<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    facet: ElementId,
    distance: f64,
) -> f64 {
    if !system.model.bodies.iter().all(|body| body.shape.is_blunt()) {
        return (distance - 2.0 * longest_edge(system, facet)) / 5.0;
    }
    let corners = facet_corners(system, facet);
    let sizes =
        system.model.gel.surface.facets[facet.index()][..D].iter().filter_map(|node| surface_size(system, *node));
    let size = sizes.fold(f64::INFINITY, f64::min);
    let depth = |(rigid, at): (&RigidBody, &BodyState)| {
        let allowed = face_depth(system) * size.min(rigid.shape.inner_radius());
        distance_lower_bound::<D>(&corners, |x| rigid.gap(at, x)) + DEPTH_FRACTION * allowed
    };
    let active = system.model.bodies.iter().zip(&system.workspace.was).filter(|(_, at)| at.active);
    active.map(depth).fold(f64::INFINITY, least)
}

/// Returns h of a surface node, m.
fn surface_size<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, node: NodeId) -> Option<f64> {
    let surface = system.model.gel.surface.of[node.index()]?;
    Some(system.model.gel.surface.nodes[surface as usize].size)
}

/// Returns φ and n of a queried node, by its index among the queried nodes.
pub(super) fn gap_at<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    index: usize,
    body: usize,
) -> Option<Gap> {
    system.workspace.gaps[index * system.model.bodies.len() + body]
}

/// Returns the distinct items in ascending order.
fn distinct<T: Ord>(all: impl Iterator<Item = T>) -> Vec<T> {
    let mut all: Vec<T> = all.collect();
    all.sort_unstable();
    all.dedup();
    all.shrink_to_fit();
    all
}
