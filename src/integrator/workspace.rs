//! What one tick works with.

use super::contact_solver::Touch;
use super::kick::ImpulseNode;
use super::load::{Pushed, Stiffer};
use super::node_loop::{ActiveSet, KickSums};
use super::reference::GroupResponses;
use super::step_size::{Change, Nearness};
use super::symmetry_contact::Meeting;
use crate::contact::BodyState;
use crate::fem::GroupAnswer;
use crate::geometry::Gap;
use crate::math::Vector;
use crate::mesh::{ElementId, NodeId};

/// What one tick works with; no result depends on what an earlier one left.
#[derive(Debug, Default)]
pub(super) struct Workspace<const D: usize> {
    /// Nodes of what fires, but for blocks at rest.
    pub active: ActiveSet,
    /// The groups that fire, ascending; of the fast form those whose step may change.
    pub due: Vec<u32>,
    /// v at the start of the tick, by node, of the active ones.
    pub before: Vec<Vector<D>>,
    /// What damping adds to it, as a part of it, by node, of the active ones.
    pub fade: Vec<f64>,
    /// CFL · 2/√λ_a, s, by node, of the active ones.
    pub limit: Vec<f64>,
    /// The same by number within one block.
    pub limits: Vec<f64>,
    /// The active nodes of the surface that may be near a body, ascending.
    pub reached: Vec<u32>,
    /// Their places among these, by node of the surface.
    pub place: Vec<u32>,
    /// Those of them that a body may meet before their next tick or that are an element's size from one.
    pub close: Vec<u32>,
    /// What contact allows around each that was looked at.
    pub nearness: Vec<Nearness>,
    /// What is around each node of the surface that a body was close to, by node of the surface.
    pub beside: Vec<NodeStar>,
    /// Facets that reach to a body, with the least and the greatest size of their nodes near it, body by body.
    pub facets: Vec<(u32, ElementId, (f64, f64))>,
    /// The facets around those nodes, with the distance of a body and the size there.
    pub found: Vec<(ElementId, f64, f64)>,
    /// φ and n of the nodes that were looked at to each active body.
    pub gaps: Vec<Option<Gap>>,
    /// The bodies at this tick before its impulses …
    pub was: Vec<BodyState>,
    /// … and with those so far.
    pub now: Vec<BodyState>,
    /// What the groups answered, of those that fire.
    pub answers: Vec<GroupAnswer>,
    /// What their elements answered, in the reference form.
    pub reference: GroupResponses<D>,
    /// Length of the kick of the firing groups, s, in the reference form.
    pub weights: Vec<f64>,
    /// Groups whose step changed.
    pub changed: Vec<Change>,
    /// Points of the surface inside a body.
    pub touches: Vec<Touch<D>>,
    /// Nodes of the surface that have come to their image.
    pub meetings: Vec<Meeting>,
    /// The nodes that carry either.
    pub carriers: Vec<ImpulseNode<D>>,
    /// What pressures do to the facets of what fires.
    pub pushed: Vec<Pushed<D>>,
    /// What they make of the stiffness of the elements behind these.
    pub stiffer: Vec<Stiffer>,
    /// Blocks in which that has changed.
    pub stiffened: Vec<usize>,
    /// Sums over runs of nodes.
    pub sums: Vec<KickSums>,
}

/// What is around a node, each once.
#[derive(Debug, Clone, Default)]
pub(super) struct NodeStar {
    /// The nodes of its elements.
    pub nodes: Vec<NodeId>,
    /// The groups of its elements.
    pub groups: Vec<u32>,
}

impl<const D: usize> Workspace<D> {
    pub fn new(n_nodes: usize, n_surface: usize, n_groups: usize) -> Self {
        Self {
            active: ActiveSet::new(n_nodes),
            before: vec![Vector::<D>::zeros(); n_nodes],
            fade: vec![0.0; n_nodes],
            limit: vec![0.0; n_nodes],
            place: vec![u32::MAX; n_surface],
            beside: vec![NodeStar::default(); n_surface],
            answers: vec![GroupAnswer::default(); n_groups],
            ..Self::default()
        }
    }
}
