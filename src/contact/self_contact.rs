//! Self-contact: a surface node of the gel meets a facet of the gel's own surface (method 2.10).

use super::detection::facet_corners;
use super::facet::outward_normal;
use super::facet_foot::FacetFoot;
use super::impulse;
use super::point::free_part;
use super::surface::{ContactSurface, NodalMasses, SurfaceView};
use super::tolerance::TOUCH_TOLERANCE;
use crate::math::{Vector, Vector3, embed, restrict};
use crate::mesh::{ElementId, NodeId};

/// Height over a facet up to which a node may reach it within a step, in element sizes: at less than a third of the
/// speed of sound it comes no further.
const CONTACT_HEIGHT: f64 = 0.3;
/// Depth behind a facet up to which a node has passed through it, in element sizes; a deeper node belongs to the other
/// side of a thin part.
const CONTACT_DEPTH: f64 = 0.3;
/// Distance of the foot beside a facet within which it counts as on the facet, in element sizes. Without it a node
/// slips through the crease between two facets.
const FACET_MARGIN: f64 = 0.05;
/// Distance of a node and a facet in contact, in element sizes: no more than √(0.3² + 0.05²).
pub(super) const CONTACT_REACH: f64 = 0.305;

/// Contact of a surface node with a facet that it may pass through until the next tick of one of their nodes.
#[derive(Debug, Clone)]
pub(crate) struct SelfContact<const D: usize> {
    /// Surface node, then the corners of the facet; the first `D` + 1 count.
    pub nodes: [NodeId; 4],
    /// s, signed weights of the nodes: 1 for the node, −w for the corners.
    weights: [f64; 4],
    /// n, unit normal of the facet.
    normal: Vector<D>,
    /// K = Σ s² n·P n/m, 1/kg.
    compliance: f64,
    /// −g/Δt, the velocity that brings the node to the facet, m/s; zero for a node behind it, which is only stopped.
    min_velocity: f64,
    /// u⁻ = n·Σ s v, the velocity of the node away from the facet before the tick, m/s.
    pub before: f64,
    /// J, accumulated impulse away from the facet, N·s.
    pub impulse: f64,
    /// Number of the facet, for the order of contacts.
    facet: ElementId,
}

/// Outcome of a look at a node and a facet.
#[derive(Debug)]
pub(crate) enum FacetProximity<const D: usize> {
    /// The node may pass through the facet.
    Contact(SelfContact<D>),
    /// The facet is out of reach, by this distance, m.
    Apart(f64),
    /// The facet is near, but the node is not before or just behind it.
    Aside,
}

/// Returns h of a node and a facet, the least of their nodes, m.
#[inline]
pub(super) fn contact_size<const D: usize>(surface: &ContactSurface, node: NodeId, facet: ElementId) -> f64 {
    let corners = surface.facets[facet.index()][..D].iter();
    corners.chain([&node]).filter_map(|node| surface.size(*node)).fold(f64::INFINITY, f64::min)
}

/// Looks whether a node may pass through a facet that faces it until their next tick.
///
/// `time_ahead` returns the time to the next tick of any of their nodes, s; infinite at the last tick of a mesh, where a
/// node at the facet is held there.
pub(crate) fn look_at_facet<const D: usize>(
    surface: &impl SurfaceView<D>,
    node: NodeId,
    facet: ElementId,
    time_ahead: impl Fn(&[NodeId]) -> f64,
) -> FacetProximity<D> {
    let (corners, point) = (facet_corners(surface, facet), embed(&surface.drifted(node)));
    let (size, foot) = (contact_size::<D>(surface.surface(), node, facet), FacetFoot::new::<D>(&corners, &point));
    if foot.distance > CONTACT_REACH * size {
        return FacetProximity::Apart(foot.distance - CONTACT_REACH * size);
    }
    let aside = (foot.distance * foot.distance - foot.height * foot.height).max(0.0).sqrt();
    let is_over = aside <= FACET_MARGIN * size && (-CONTACT_DEPTH..=CONTACT_HEIGHT).contains(&(foot.height / size));
    if !is_over || outward_direction(surface, node).dot(&foot.normal) >= 0.0 {
        return FacetProximity::Aside;
    }
    let mut nodes = [node; 4];
    nodes[1..=D].copy_from_slice(&surface.surface().facets[facet.index()][..D]);
    let ahead = time_ahead(&nodes[..=D]);
    let min_velocity = if ahead.is_finite() {
        -foot.height.max(0.0) / ahead
    } else if foot.height <= TOUCH_TOLERANCE * size {
        0.0
    } else {
        return FacetProximity::Aside;
    };
    let contact = SelfContact::new(surface, nodes, facet, &foot, min_velocity);
    contact.map_or(FacetProximity::Aside, FacetProximity::Contact)
}

/// Returns the direction out of the gel at a node, of any length: the sum of the normals of its facets, by area.
fn outward_direction<const D: usize>(surface: &impl SurfaceView<D>, node: NodeId) -> Vector3 {
    let around = surface.surface().around.of(node).iter();
    around.map(|facet| outward_normal::<D>(&facet_corners(surface, *facet))).sum()
}

/// Corrects all impulses between nodes and facets once; returns the greatest change of a velocity, m/s.
pub(super) fn correct_self_contacts<const D: usize>(
    contacts: &mut [SelfContact<D>],
    masses: &impl NodalMasses<D>,
    velocity: &mut [Vector<D>],
) -> f64 {
    contacts.iter_mut().map(|contact| contact.correct(masses, velocity)).fold(0.0, f64::max)
}

impl<const D: usize> SelfContact<D> {
    /// Creates the contact of a node with a facet; `None` if none of their nodes can move.
    fn new(
        surface: &impl SurfaceView<D>,
        nodes: [NodeId; 4],
        facet: ElementId,
        foot: &FacetFoot,
        min_velocity: f64,
    ) -> Option<Self> {
        let [a, b, c] = foot.weights;
        let mut contact = Self {
            nodes,
            weights: [1.0, -a, -b, -c],
            normal: restrict(&foot.normal),
            compliance: 0.0,
            min_velocity,
            before: 0.0,
            impulse: 0.0,
            facet,
        };
        let masses = surface.masses();
        let own =
            |(node, s): (NodeId, f64)| s * s * free_part(masses, node, &foot.normal).norm_squared() / masses.mass(node);
        contact.compliance = contact.carriers().map(own).sum();
        contact.before = contact.separation_velocity(|node| surface.velocity_before(node));
        (contact.compliance > 0.0).then_some(contact)
    }

    /// Returns the key of the order of contacts: by node, then by facet.
    pub fn key(&self) -> (NodeId, ElementId) {
        (self.nodes[0], self.facet)
    }

    /// Iterates over the nodes and their signed weights.
    pub fn carriers(&self) -> impl Iterator<Item = (NodeId, f64)> + '_ {
        self.nodes[..=D].iter().copied().zip(self.weights)
    }

    /// Returns J n, the impulse on the node, N·s.
    pub fn push(&self) -> Vector<D> {
        self.normal * self.impulse
    }

    /// Returns u = n·Σ s v, the velocity of the node away from the facet, m/s.
    pub fn separation_velocity(&self, velocity: impl Fn(NodeId) -> Vector<D>) -> f64 {
        self.carriers().map(|(node, s)| s * self.normal.dot(&velocity(node))).sum()
    }

    /// Corrects the impulse once; returns the change of velocity, m/s.
    fn correct(&mut self, masses: &impl NodalMasses<D>, velocity: &mut [Vector<D>]) -> f64 {
        let (compliance, accumulated) = (self.compliance, self.impulse);
        let free = self.separation_velocity(|node| velocity[node.index()]) - compliance * accumulated;
        let change = impulse(free, self.min_velocity, compliance) - accumulated;
        if change.abs() <= f64::EPSILON * accumulated {
            return 0.0;
        }
        self.impulse += change;
        for (node, s) in self.carriers() {
            let push = self.normal.component_mul(&masses.free(node)) * (s * change / masses.mass(node));
            velocity[node.index()] += push;
        }
        compliance * change.abs()
    }
}
