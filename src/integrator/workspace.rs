//! Workspace of a tick: buffers that are reused from tick to tick.

use super::active_set::ActiveSet;
use super::kick_sums::KickSums;
use crate::contact::{BodyState, ContactPoint, SelfContact, SymmetryContact};
use crate::fem::{ElementResponse, GroupResponse};
use crate::math::Vector;
use crate::mesh::{ElementId, Facet, NodeId};
use crate::state::Tick;
use std::ops::Range;

/// Workspace of a tick; no result depends on the contents from an earlier tick.
#[derive(Debug, Default)]
pub(super) struct Workspace<const D: usize> {
    /// Active nodes, without those of blocks at rest.
    pub active_nodes: ActiveSet,
    /// Active groups, ascending; in the SIMD form only those whose step may change.
    pub active_groups: Vec<u32>,
    /// Velocities of the active nodes at the start of the tick, m/s.
    pub velocities_before: Vec<Vector<D>>,
    /// Relative change of these velocities by damping.
    pub decay: Vec<f64>,
    /// Stable limits CFL · 2/√λ_a of the active nodes, s.
    pub node_limits: Vec<f64>,
    /// Stable limits by local number in one block, s.
    pub block_limits: Vec<f64>,
    /// Contact limit of the steps at each node of the queried nodes.
    pub contact_limits: Vec<ContactLimit>,
    /// Star of each surface node that a body was close to.
    pub surface_stars: Vec<NodeStar>,
    /// Bodies at this tick before its impulses.
    pub bodies_before: Vec<BodyState>,
    /// Bodies at this tick with the impulses applied so far.
    pub bodies_after: Vec<BodyState>,
    /// Responses of the groups; those of active groups are current.
    pub responses: Vec<GroupResponse>,
    /// Responses of the elements of the active groups (reference form).
    pub element_responses: GroupResponses<D>,
    /// Kick lengths of the active groups, s (reference form).
    pub kick_lengths: Vec<f64>,
    /// Groups whose step changed.
    pub changed_steps: Vec<StepChange>,
    /// Contact points: surface points inside a body.
    pub contact_points: Vec<ContactPoint<D>>,
    /// Surface nodes that have met their mirror image.
    pub symmetry_contacts: Vec<SymmetryContact>,
    /// Contacts of the gel with itself.
    pub self_contacts: Vec<SelfContact<D>>,
    /// Nodes of these contacts that are not active.
    pub passive_nodes: Vec<PassiveNode<D>>,
    /// Nodes with impulses of contact or pressure.
    pub impulse_nodes: Vec<ImpulseNode<D>>,
    /// Pressure loads on the facets of active elements.
    pub facet_loads: Vec<FacetLoad<D>>,
    /// Stiffness that the loads add to the elements behind them.
    pub load_stiffness: Vec<LoadStiffness>,
    /// Blocks whose stiffness these loads changed.
    pub stiffened_blocks: Vec<usize>,
    /// Sums over chunks of nodes.
    pub chunk_sums: Vec<KickSums>,
}

/// Star of a node, without duplicates.
#[derive(Debug, Clone, Default)]
pub(super) struct NodeStar {
    /// Nodes of its elements.
    pub nodes: Vec<NodeId>,
    /// Groups of its elements.
    pub groups: Vec<u32>,
}

impl<const D: usize> Workspace<D> {
    pub fn new(n_nodes: usize, n_surface: usize, n_groups: usize) -> Self {
        Self {
            active_nodes: ActiveSet::new(n_nodes),
            velocities_before: vec![Vector::<D>::zeros(); n_nodes],
            decay: vec![0.0; n_nodes],
            node_limits: vec![0.0; n_nodes],
            surface_stars: vec![NodeStar::default(); n_surface],
            responses: vec![GroupResponse::default(); n_groups],
            ..Self::default()
        }
    }
}

/// Node with an impulse of pressure or contact, with its velocities before the element kicks and before that impulse.
#[derive(Debug, Clone, Copy)]
pub(super) struct ImpulseNode<const D: usize> {
    pub node: NodeId,
    pub before: Vector<D>,
    pub kicked: Vector<D>,
}

/// Node that self-contact may strike between its ticks.
#[derive(Debug, Clone, Copy)]
pub(super) struct PassiveNode<const D: usize> {
    pub node: NodeId,
    /// Velocity before the impulses of contact, m/s.
    pub before: Vector<D>,
    /// Last tick of the groups at the node.
    pub last: Tick,
}

/// Pressure load on a facet at a tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct FacetLoad<const D: usize> {
    pub nodes: Facet,
    pub forces: [Vector<D>; 3],
    /// Group of the element behind the facet.
    pub group: usize,
    /// Length of the kick, s: its trailing half, then the whole kick once the next step is known.
    pub weight: f64,
    pub source: PressureSource,
}

/// Source of a pressure, to whose accounts its impulse and work go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PressureSource {
    /// Load on a face.
    Face,
    /// Air in the cavity.
    Cavity,
}

impl<const D: usize> FacetLoad<D> {
    /// Iterates over the nodes and the impulses on them, N·s.
    pub fn impulses(&self) -> impl Iterator<Item = (NodeId, Vector<D>)> + '_ {
        self.nodes[..D].iter().zip(&self.forces).map(|(node, force)| (*node, force * self.weight))
    }
}

/// Load stiffness that a pressure adds to an active element.
#[derive(Debug, Clone, Copy)]
pub(super) struct LoadStiffness {
    /// Index of the loaded facet.
    pub facet: usize,
    /// Slot of the element behind the facet.
    pub slot: usize,
    /// Added stiffness, and the stiffness before this tick's pressures, N/m.
    pub added: f64,
    pub before: f64,
}

/// Responses of the elements of the active groups.
#[derive(Debug)]
pub(super) struct GroupResponses<const D: usize> {
    pub elements: Vec<(ElementId, ElementResponse<D>)>,
    /// Range of elements of each active group.
    pub groups: Vec<Range<usize>>,
}

impl<const D: usize> Default for GroupResponses<D> {
    fn default() -> Self {
        Self { elements: vec![], groups: vec![] }
    }
}

/// Limits that contact sets to the steps around a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ContactLimit {
    /// Longest step without a deep penetration, and near a body the common step of the elements around, ticks.
    pub limit: f64,
    /// True if a body is within an element's size.
    pub is_near: bool,
}

/// Change of the step of a group at this tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StepChange {
    pub group: u32,
    /// Time until the next own tick by the former step, ticks; 0 at the start.
    pub planned: Tick,
    /// Time until the next own tick by the new step, ticks.
    pub ahead: Tick,
}
