//! Contact point: a place of the surface inside a body, and what its impulse does.

use super::surface::{NodalMasses, SurfaceView};
use super::tolerance::BIAS_CAP;
use super::{BodyState, ImpulseLaw, RigidBody};
use crate::geometry::Gap;
use crate::math::{Vector, Vector3, embed, restrict};
use crate::mesh::NodeId;

/// Bodies at a tick, before its impulses.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TickBodies<'a> {
    /// Constant properties.
    pub rigid: &'a [RigidBody],
    /// States at this tick.
    pub at: &'a [BodyState],
}

impl<'a> TickBodies<'a> {
    /// Returns a body and its state.
    pub fn get(self, body: usize) -> (&'a RigidBody, &'a BodyState) {
        (&self.rigid[body], &self.at[body])
    }

    /// Iterates over the active bodies and their states.
    pub fn active(self) -> impl Iterator<Item = (&'a RigidBody, &'a BodyState)> {
        self.rigid.iter().zip(self.at).filter(|(_, at)| at.active)
    }
}

/// Contact point of the surface inside a body at this tick: a node, or a point of a facet.
#[derive(Debug, Clone)]
pub(crate) struct ContactPoint<const D: usize> {
    /// Index of the body.
    pub body: usize,
    /// Nodes that carry the contact point; the first `n_nodes` count.
    pub nodes: [NodeId; 3],
    /// w, weight of each carrying node.
    pub weights: [f64; 3],
    /// P w/m, change of the velocity of each carrying node per impulse in its free directions, 1/kg.
    mobility: [Vector<D>; 3],
    pub n_nodes: usize,
    /// h, m.
    pub size: f64,
    /// φ, signed distance, m.
    pub distance: f64,
    /// n, normal out of the body in the world frame.
    pub normal: Vector3,
    /// x, position, m.
    pub point: Vector3,
    /// K = Σ w² n·P n/m + 1/M + (r×n)·I⁻¹(r×n), 1/kg.
    pub compliance: f64,
    /// Normal velocity of the surface per rate of each coordinate of the shape: height and base radius of a dome, or
    /// opening of an expanding body.
    pub growth: Vector<2>,
    /// Velocity of the body's surface point due to the motion of its shape, m/s.
    pub swell: Vector3,
    /// Relative velocity before the tick, m/s; u⁻ is its normal part.
    pub before: Vector3,
    /// ½ a Δt, half of the speed that the body's acceleration towards the point adds until the point's next tick,
    /// m/s.
    pub lead: f64,
    /// b, bias velocity that removes standing penetration, m/s.
    pub bias: f64,
    /// J, accumulated normal impulse, N·s.
    pub impulse: f64,
    /// Jₜ, accumulated friction impulse, N·s.
    pub drag: Vector3,
}

impl<const D: usize> ContactPoint<D> {
    /// Creates a contact point with all fields zero.
    fn empty() -> Self {
        let (zero, growth) = (Vector3::zeros(), Vector::<2>::zeros());
        Self {
            body: 0,
            nodes: [NodeId(0); 3],
            weights: [0.0; 3],
            mobility: [Vector::<D>::zeros(); 3],
            n_nodes: 0,
            size: 0.0,
            distance: 0.0,
            normal: zero,
            point: zero,
            compliance: 0.0,
            growth,
            swell: zero,
            before: zero,
            lead: 0.0,
            bias: 0.0,
            impulse: 0.0,
            drag: zero,
        }
    }

    /// Returns the nodes that carry the contact point.
    pub fn nodes(&self) -> &[NodeId] {
        &self.nodes[..self.n_nodes]
    }

    /// Returns u⁻, the relative normal velocity before the tick, m/s.
    pub fn approach(&self) -> f64 {
        self.normal.dot(&self.before)
    }

    /// Returns J n + Jₜ, the total impulse on the gel, N·s.
    pub fn push(&self) -> Vector3 {
        self.normal * self.impulse + self.drag
    }

    /// Iterates over the carrying nodes and their weights.
    pub fn carriers(&self) -> impl Iterator<Item = (NodeId, f64)> + '_ {
        self.nodes().iter().copied().zip(self.weights)
    }

    /// Iterates over the carrying nodes and the changes of their velocities by an impulse on the gel, m/s.
    pub(super) fn velocity_changes(&self, impulse: &Vector3) -> impl Iterator<Item = (NodeId, Vector<D>)> + '_ {
        let impulse = restrict::<D>(impulse);
        self.nodes().iter().zip(&self.mobility).map(move |(node, mobility)| (*node, impulse.component_mul(mobility)))
    }

    /// Creates the contact point of these nodes; `None` if neither they nor the body can move.
    pub(super) fn new(
        surface: &impl SurfaceView<D>,
        bodies: TickBodies<'_>,
        carriers: &ContactCarriers<'_>,
        gap: &Gap,
        body: usize,
    ) -> Option<Self> {
        let ContactCarriers { nodes: own, weights, size, point } = *carriers;
        let mut nodes = [own[0]; 3];
        nodes[..own.len()].copy_from_slice(own);
        let (rigid, at) = bodies.get(body);
        let growth = rigid.growth(at, &point);
        let speed = at.shape_motion.map_or(0.0, |shape| growth.dot(&shape.rate()));
        let mut touch = Self {
            body,
            nodes,
            weights,
            n_nodes: own.len(),
            size,
            distance: gap.distance,
            normal: gap.normal,
            point,
            growth,
            swell: gap.normal * speed,
            ..Self::empty()
        };
        for (mobility, (node, w)) in touch.mobility.iter_mut().zip(own.iter().zip(weights)) {
            *mobility = surface.masses().free(*node) * (w / surface.masses().mass(*node));
        }
        touch.compliance = touch.compliance_along(surface.masses(), rigid, at, &gap.normal);
        touch.before = touch.relative_velocity(&rigid.velocity_at(at, &point), |node| surface.velocity_before(node));
        (touch.compliance > 0.0).then_some(touch)
    }

    /// Returns the compliance K along a unit vector, 1/kg.
    pub(super) fn compliance_along(
        &self,
        masses: &impl NodalMasses<D>,
        rigid: &RigidBody,
        at: &BodyState,
        direction: &Vector3,
    ) -> f64 {
        let own =
            |(node, w): (NodeId, f64)| w * w * free_part(masses, node, direction).norm_squared() / masses.mass(node);
        self.carriers().map(own).sum::<f64>() + rigid.compliance(at, &(self.point - at.position), direction)
    }

    /// Returns the relative velocity Σ w v_a − V(x) for given velocities of the body at the contact point and of the
    /// nodes, m/s.
    pub(crate) fn relative_velocity(&self, body_velocity: &Vector3, velocity: impl Fn(NodeId) -> Vector<D>) -> Vector3 {
        let gel: Vector3 = self.carriers().map(|(node, w)| embed(&velocity(node)) * w).sum();
        gel - body_velocity - self.swell
    }

    /// Returns the lead velocity ½ a Δt of a body that accelerates towards the contact point, m/s.
    ///
    /// The body accelerates continuously, the node only at its ticks. A node stopped relative to the velocity at its
    /// tick would be overrun by ½ a Δt² in each step: a pressed ball sank through a standing node at ½ a Δt. The
    /// solver therefore stops the mean velocity of the interval ahead, as the half-step velocities of the gel are
    /// means.
    pub(crate) fn lead_velocity(&self, rigid: &RigidBody, at: &BodyState, step: f64) -> f64 {
        let pull = rigid.freedom.translation(&at.wrench.force) / rigid.mass;
        let swelling = at.shape_motion.map_or(0.0, |shape| self.growth.dot(&shape.acceleration()));
        (0.5 * step * (self.normal.dot(&pull) + swelling)).max(0.0)
    }

    /// Returns the bias velocity that the removal of standing penetration adds to the restituted velocity −e u⁻, m/s.
    /// The target velocity is the greater of −e u⁻ and β |φ|/Δt until the next tick, capped by the greatest approach
    /// speed so far.
    pub(crate) fn bias_velocity(&self, law: ImpulseLaw, slop: f64, greatest_approach: f64, step: f64) -> f64 {
        let ImpulseLaw::Moreau { bias, restitution, .. } = law else { return 0.0 };
        let standing = (-self.distance - slop * self.size).max(0.0);
        let removal = (bias * standing / step).min(BIAS_CAP * greatest_approach);
        if removal > 0.0 { (removal + restitution * self.approach()).max(0.0) } else { 0.0 }
    }
}

/// Carriers of a contact point: one surface node, or the corners of a facet.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContactCarriers<'a> {
    pub nodes: &'a [NodeId],
    /// w, weight of each node.
    pub weights: [f64; 3],
    /// h, m.
    pub size: f64,
    /// x, position, m.
    pub point: Vector3,
}

/// Returns P v, the part of a world vector in the free directions of a node.
pub(super) fn free_part<const D: usize>(masses: &impl NodalMasses<D>, node: NodeId, v: &Vector3) -> Vector<D> {
    restrict::<D>(v).component_mul(&masses.free(node))
}
