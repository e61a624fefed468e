//! Broad phase of contact: finds the active surface nodes near a body at a tick, and their gaps.

use super::engine::Engine;
use super::facet::distance_lower_bound;
use super::gel::SurfaceNode;
use super::neighbour_list::least;
use crate::contact::{BodyState, RigidBody};
use crate::fem::Potential;
use crate::geometry::{Gap, SignedDistance as _};
use crate::math::embed;
use crate::mesh::{ElementId, NodeId};
use crate::state::Tick;

/// Fraction of the allowed facet depth below which a facet needs no query; it is below 1 by more than rounding.
const DEPTH_FRACTION: f64 = 0.999;

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Queries φ and n of the active surface nodes to the active bodies, where a body may be within reach.
    pub(super) fn query_gaps(&mut self, tick: Tick) {
        for surface in self.scratch.reached.drain(..) {
            self.scratch.place[surface as usize] = u32::MAX;
        }
        self.watch.go_on(self.grid.time(tick), &self.scratch.was);
        self.placed = true;
        let horizon = self.horizon() * self.grid.time(1);
        let reach = self.watch.reach(&self.bodies, horizon);
        self.find_queried_nodes(reach);
        self.query_node_gaps(reach);
        self.collect_neighbours();
        self.find_contact_limits();
    }

    /// Finds the active surface nodes that need a query, ascending.
    fn find_queried_nodes(&mut self, reach: f64) {
        let (gel, watch, reached) = (&self.gel, &mut self.watch, &mut self.scratch.reached);
        if let Some(blocks) = &self.blocks {
            return watch.append_queries(&gel.surface, reach, |node| blocks.fires(node.index()), reached);
        }
        let active = self.scratch.active.reference_nodes().iter().filter_map(|a| gel.surface.of[*a as usize]);
        reached.extend(active.filter(|node| watch.needs_query(*node, gel.surface.nodes[*node as usize].size, reach)));
        reached.sort_unstable();
    }

    /// Queries the gaps of these nodes to each active body, and lists the nodes close to a body.
    fn query_node_gaps(&mut self, reach: f64) {
        let (scratch, n) = (&mut self.scratch, self.bodies.len());
        scratch.gaps.clear();
        scratch.close.clear();
        for (index, surface) in scratch.reached.iter().enumerate() {
            let SurfaceNode { node, size, .. } = self.gel.surface.nodes[*surface as usize];
            let point = embed(&self.state.position[node.index()]);
            let bodies = self.bodies.iter().zip(&scratch.was);
            scratch.gaps.extend(bodies.map(|(rigid, body)| body.active.then(|| rigid.gap(body, &point))));
            let nearest =
                scratch.gaps[index * n..].iter().flatten().map(|gap| gap.distance).fold(f64::INFINITY, f64::min);
            self.watch.set_gap(*surface, nearest);
            if nearest < size.max(reach) {
                scratch.close.push(*surface);
            }
            scratch.place[*surface as usize] = index as u32;
        }
    }

    /// Collects the nodes and groups around each surface node that a body comes close to, once per node.
    fn collect_neighbours(&mut self) {
        let (gel, order, scratch) = (&self.gel, &self.order, &mut self.scratch);
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
    pub(super) fn update_facet_bounds(&mut self) {
        let (gel, n) = (self.gel.clone(), self.bodies.len());
        for (index, surface) in self.scratch.reached.iter().enumerate() {
            if self.watch.needs_facet_query(*surface) {
                let node = gel.surface.nodes[*surface as usize].node;
                let gaps = self.scratch.gaps[index * n..][..n].iter().flatten();
                let nearest = gaps.map(|gap| gap.distance).fold(f64::INFINITY, f64::min);
                let around = gel.surface.around.of(node).iter();
                let clearance = around.map(|facet| self.facet_clearance(*facet, nearest)).fold(f64::INFINITY, least);
                self.watch.set_facet_bound(*surface, clearance);
            }
        }
    }

    /// Returns how far anything may travel before a facet with a body at distance d from a corner needs a query, m.
    ///
    /// For blunt bodies it is the travel until the facet can reach the allowed depth, as the least φ on it falls by
    /// at most the travel s. For other bodies a facet needs no query while d exceeds twice its length l, as no corner
    /// is then nearer than d − l ≥ l. d falls by at most s, and l grows by at most 2s.
    fn facet_clearance(&self, facet: ElementId, distance: f64) -> f64 {
        if !self.bodies.iter().all(|body| body.shape.is_blunt()) {
            return (distance - 2.0 * self.longest_edge(facet)) / 5.0;
        }
        let corners = self.facet_corners(facet);
        let sizes = self.gel.surface.facets[facet.index()][..D].iter().filter_map(|node| self.surface_size(*node));
        let size = sizes.fold(f64::INFINITY, f64::min);
        let depth = |(rigid, at): (&RigidBody, &BodyState)| {
            let allowed = self.face_depth() * size.min(rigid.shape.inner_radius());
            distance_lower_bound::<D>(&corners, |x| rigid.gap(at, x)) + DEPTH_FRACTION * allowed
        };
        let active = self.bodies.iter().zip(&self.scratch.was).filter(|(_, at)| at.active);
        active.map(depth).fold(f64::INFINITY, least)
    }

    /// Returns h of a surface node, m.
    fn surface_size(&self, node: NodeId) -> Option<f64> {
        let surface = self.gel.surface.of[node.index()]?;
        Some(self.gel.surface.nodes[surface as usize].size)
    }

    /// Returns φ and n of a queried node, by its index among the queried nodes.
    pub(super) fn gap_at(&self, index: usize, body: usize) -> Option<Gap> {
        self.scratch.gaps[index * self.bodies.len() + body]
    }
}

/// Returns the distinct items in ascending order.
fn distinct<T: Ord>(all: impl Iterator<Item = T>) -> Vec<T> {
    let mut all: Vec<T> = all.collect();
    all.sort_unstable();
    all.dedup();
    all.shrink_to_fit();
    all
}
