//! Contact solver: finds the contact points of one tick and solves for their impulses (numerics 2.3, A7).

use super::bodies::{depth_in_gel, rebase_body};
use super::broad_phase::{gap_at, update_facet_bounds};
use super::facet::{DeepestPoint, find_deepest_point};
use super::neighbour_list::STRETCH;
use super::step_size::shortest_step_around;
use super::substep::MeshPhase;
use super::symmetry_contact::{correct_symmetry_contacts, find_symmetry_contacts};
use super::system::DiscreteSystem;
use super::tip_in_facet::{TipPenetration, find_tip_contact};
use crate::contact::{BodyMotion, BodyState, ImpulseExchange, ImpulseLaw, RigidBody, impulse, reversal};
use crate::fem::Potential;
use crate::geometry::{Gap, SignedDistance};
use crate::math::{Vector, Vector3, embed, ordered_sum, restrict};
use crate::mesh::{ElementId, NodeId};
use crate::state::Tick;

/// Contact point of the surface inside a body at this tick: a node, or a point of a facet.
#[derive(Debug, Clone)]
pub(super) struct ContactPoint<const D: usize> {
    /// Index of the body.
    pub body: usize,
    /// Nodes that carry the contact point; the first `n_nodes` count.
    pub nodes: [NodeId; 3],
    /// w, weight of each carrying node.
    pub weights: [f64; 3],
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
    /// ∂x/∂h and ∂x/∂a, normal velocity of a dome's surface per rate of its height and base radius.
    pub growth: Vector<2>,
    /// Velocity of the body's surface point due to the growth of a dome, m/s.
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
}

/// Depth at which a facet is stopped at its deepest point, in the smaller of element size and inner radius of the
/// body. A body sharper than the mesh, or one over which the surface is stretched, must not slip between nodes. Nodes
/// alone carry shallower contact, because holding all facets at the surface would lift their nodes off a curved body.
///
/// At 0.2 the depth of `sphere-block` falls from 14.166 to 14.149 mm (14.5 when converged); from 0.3 on it does not
/// change a bit. Larger values stretch the surface further: at 0.4 the ball of 20 m/s inverts cells of 3.57 mm, which
/// at 0.3 bring it through and back. A blunt ogive on cells of half its radius gets 8 % more impulse at 0.3 than on
/// fine ones, 2 % at 0.4.
const FACE_DEPTH: f64 = 0.3;
/// Facet depth, as [`FACE_DEPTH`], of a remeshed gel in space with history variables. The surface is drawn over the
/// body and remeshing splits the facets; facets split deep in the body have to be pushed out. The energy that this
/// adds in the first 0.3 ms of `fbi-bb-3d`, relative to that of the shot, is 6.5 % at 0.3, 1.6 % at 0.1, 0.9 % at
/// 0.06 and 0.7 % at 0.02. A facet stopped late also turns about the stopped point. At 0.3 the nose of `bullet-yaw`,
/// with cells of 0.39 mm, leaks after 6 mm; at 0.06 it does not.
///
/// Twice [`SLOP`], to let nodes carry flat contact. The slop of the nodes is equal: at 0.03 contact pushed out the
/// nodes of split facets, by 0.8 % of the energy of `fbi-bb-3d`; at 0.06 by 0.15 %.
const DRAWN_DEPTH: f64 = 2.0 * SLOP;
/// Maximum number of Gauss–Seidel sweeps over the contact points of a tick, and the residual, relative to the
/// greatest approach speed, that ends them (A7). A few sweeps settle a body heavier than the nodes it meets at once.
/// A body of a hundredth of their mass needs hundreds: after ten it kept 2 % of its approach.
const MAX_SWEEPS: usize = 400;
const RESIDUAL_TOLERANCE: f64 = 1e-12;
/// Tolerance above the surface within which a node counts as inside, in element sizes. For a node that rests on a
/// moving body at a distance of exactly zero, rounding would decide, and each miss costs an impact. The rebound of a
/// mass that starts in touch with a bar was 2.3 % off. Rounding is ten thousand times smaller.
pub(super) const TOUCH_TOLERANCE: f64 = 1e-9;
/// Upper bound of the bias velocity, as a fraction of the greatest approach speed so far (numerics 2.5).
const BIAS_CAP: f64 = 0.1;
/// Penetration slop: the depth that the bias velocity leaves standing, in element sizes. Removing all penetration
/// pushes nodes off that fall back for ever, and pumps energy through the contact. On `sphere-block` the gain is
/// 4.7 % of the impact energy at 0, 0.05 % at 0.01 and nothing at 0.03. Under an oblique ball on a coarse mesh it is
/// 0.4 % at 0.01 and nothing at 0.03. The mean standing penetration does not grow with the slop: it is 0.005 to 0.008
/// where 0.01 is allowed (A7), because approaching nodes are found at that depth.
pub(super) const SLOP: f64 = 0.03;

/// Finds the contact points of a tick, body by body: the active nodes inside it, ascending, then the active
/// facets that a tip pierces or that are deep inside it.
pub(super) fn find_contact_points<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    find_symmetry_contacts(system, tick);
    find_facet_candidates(system);
    let mut touches = std::mem::take(&mut system.workspace.touches);
    touches.clear();
    for body in 0..system.model.bodies.len() {
        collect_contacts(system, body, tick, &mut touches);
    }
    for touch in &touches {
        let contact = &mut system.state.record.contacts[touch.body];
        contact.approach = contact.approach.max(-touch.approach());
    }
    // At the last tick of a mesh there is no step ahead.
    for touch in touches.iter_mut().filter(|_| system.clock.phase != MeshPhase::Last) {
        let step = system.model.grid.time(shortest_step_around(system, touch.nodes[0]) as Tick);
        touch.lead = lead_velocity(system, touch, step);
        touch.bias = bias_velocity(system, touch, step);
    }
    system.workspace.touches = touches;
}

/// Adds the contact points of one body: its nodes, then its facets.
fn collect_contacts<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    body: usize,
    tick: Tick,
    touches: &mut Vec<ContactPoint<D>>,
) {
    for (index, surface) in system.workspace.reached.iter().enumerate() {
        let at = system.model.gel.surface.nodes[*surface as usize];
        let Some(gap) = gap_at(system, index, body).filter(|gap| gap.distance <= TOUCH_TOLERANCE * at.size) else {
            continue;
        };
        let point = embed(&system.state.position[at.node.index()]);
        touches.extend(new_contact(system, &[at.node], [1.0, 0.0, 0.0], at.size, point, &gap, body));
    }
    for (_, facet, (_, size)) in system.workspace.facets.iter().filter(|(of, ..)| *of == body as u32) {
        if system.was_active(system.model.gel.behind[facet.index()], tick) {
            touches.extend(facet_contact(system, *facet, *size, body));
        }
    }
}

/// Finds the facets between the active nodes and a body, each once, with the least and the greatest size of those
/// nodes.
fn find_facet_candidates<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    update_facet_bounds(system);
    let mut facets = std::mem::take(&mut system.workspace.facets);
    let mut found = std::mem::take(&mut system.workspace.found);
    facets.clear();
    for body in 0..system.model.bodies.len() {
        found.clear();
        for (index, reached) in system.workspace.reached.iter().enumerate() {
            let at = system.model.gel.surface.nodes[*reached as usize];
            let near = |gap: &Gap| gap.distance < STRETCH * at.size && system.neighbours.needs_facet_query(*reached);
            let Some(gap) = gap_at(system, index, body).filter(near) else { continue };
            found.extend(
                system.model.gel.surface.around.of(at.node).iter().map(|facet| (*facet, gap.distance, at.size)),
            );
        }
        found.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        for same_facet in found
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|same_facet| same_facet[0].1 < longest_edge(system, same_facet[0].0))
        {
            let sizes = same_facet.iter().map(|(_, _, size)| *size);
            let sizes = sizes.fold((f64::INFINITY, 0.0_f64), |(least, most), size| (least.min(size), most.max(size)));
            facets.push((body as u32, same_facet[0].0, sizes));
        }
    }
    (system.workspace.facets, system.workspace.found) = (facets, found);
}

/// Returns a body and its state at this tick before the contact impulses.
pub(super) fn body_at_tick<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    body: usize,
) -> (&RigidBody, &BodyState) {
    (&system.model.bodies[body], &system.workspace.was[body])
}

/// Returns the contact point of a facet at a tip of the body or where the facet is deepest.
fn facet_contact<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    facet: ElementId,
    size: f64,
    body: usize,
) -> Option<ContactPoint<D>> {
    let corners = &system.model.gel.surface.facets[facet.index()][..D];
    // The facet is only stopped, its penetration is not removed. Removal at a pointed tip pumps energy, up to
    // 26 % of the impact energy (a sharp ogive of 10 mm on cells of 6.7 mm).
    let without_depth = |gap: Gap| Gap { distance: 0.0, ..gap };
    let (rigid, at) = body_at_tick(system, body);
    if let Some(TipPenetration { point, weights, gap, .. }) = find_tip_contact(system, facet, size, rigid, at) {
        return new_contact(system, corners, weights, size, point, &without_depth(gap), body);
    }
    let allowed = face_depth(system) * size.min(rigid.shape.inner_radius());
    let DeepestPoint { point, weights, gap } =
        find_deepest_point::<D>(&facet_corners(system, facet), allowed, |p| rigid.gap(at, p))?;
    new_contact(system, corners, weights, size, point, &without_depth(gap), body)
}

/// Returns the depth at which a facet is stopped, in the smaller of element size and inner radius of the body.
pub(super) fn face_depth<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>) -> f64 {
    if is_drawn(system) { DRAWN_DEPTH } else { FACE_DEPTH }
}

/// Returns the penetration slop of a node, in element sizes; on a drawn surface it equals the facet depth.
fn node_slop<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>) -> f64 {
    if is_drawn(system) { DRAWN_DEPTH } else { SLOP }
}

/// Returns true if the surface is drawn over the body throughout the run: a gel in space with history variables that is
/// remeshed.
fn is_drawn<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>) -> bool {
    D == 3 && system.can_be_distorted() && system.model.gel.potential.remembers()
}

/// Returns the positions of the corners of a facet at this tick, m.
pub(super) fn facet_corners<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    facet: ElementId,
) -> [Vector3; 3] {
    let time = system.workspace.was[0].time;
    system.model.gel.surface.facets[facet.index()].map(|node| embed(&system.position_at(node, time)))
}

/// Returns the length of the longest edge of a facet at this tick, m.
pub(super) fn longest_edge<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, facet: ElementId) -> f64 {
    let corners = facet_corners(system, facet);
    (0..D).map(|i| (corners[(i + 1) % D] - corners[i]).norm()).fold(0.0, f64::max)
}

/// Creates the contact point that these nodes carry; `None` if neither they nor the body can move.
fn new_contact<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    carriers: &[NodeId],
    weights: [f64; 3],
    size: f64,
    point: Vector3,
    gap: &Gap,
    body: usize,
) -> Option<ContactPoint<D>> {
    let mut nodes = [carriers[0]; 3];
    nodes[..carriers.len()].copy_from_slice(carriers);
    let (rigid, at) = body_at_tick(system, body);
    let growth = rigid.growth(at, &point);
    let speed = at.bulge.map_or(0.0, |bulge| growth.dot(&bulge.rate));
    let mut touch = ContactPoint {
        body,
        nodes,
        weights,
        n_nodes: carriers.len(),
        size,
        distance: gap.distance,
        normal: gap.normal,
        point,
        growth,
        swell: gap.normal * speed,
        ..ContactPoint::empty()
    };
    touch.compliance = compliance(system, &touch, &gap.normal);
    touch.before = relative_velocity(system, &touch, |node| system.velocity_before(node));
    (touch.compliance > 0.0).then_some(touch)
}

/// Returns the compliance K along a unit vector, 1/kg.
fn compliance<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    touch: &ContactPoint<D>,
    direction: &Vector3,
) -> f64 {
    let own = |(node, w): (NodeId, f64)| {
        w * w * free_part(system, node, direction).norm_squared() / system.model.gel.mass[node.index()]
    };
    let (rigid, at) = body_at_tick(system, touch.body);
    touch.carriers().map(own).sum::<f64>() + rigid.compliance(at, &(touch.point - at.position), direction)
}

/// Returns P v, the part of a world vector in the free directions of a node.
fn free_part<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, node: NodeId, v: &Vector3) -> Vector<D> {
    restrict::<D>(v).component_mul(&system.model.gel.free(node.index()))
}

/// Returns the relative velocity Σ w v_a − V(x) with the impulses so far, m/s.
pub(super) fn relative<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    touch: &ContactPoint<D>,
) -> Vector3 {
    relative_velocity(system, touch, |node| system.state.velocity[node.index()])
}

/// Returns the relative velocity Σ w v_a − V(x) for given velocities of the nodes, m/s.
fn relative_velocity<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    touch: &ContactPoint<D>,
    velocity: impl Fn(NodeId) -> Vector<D>,
) -> Vector3 {
    let gel: Vector3 = touch.carriers().map(|(node, w)| embed(&velocity(node)) * w).sum();
    let (rigid, now) = (&system.model.bodies[touch.body], &system.workspace.now[touch.body]);
    gel - rigid.velocity_at(now, &touch.point) - touch.swell
}

/// Returns the lead velocity ½ a Δt of a body that accelerates towards the contact point, m/s.
///
/// The body accelerates continuously, the node only at its ticks. A node stopped relative to the velocity at its
/// tick would be overrun by ½ a Δt² in each step: a pressed ball sank through a standing node at ½ a Δt. The
/// solver therefore stops the mean velocity of the interval ahead, as the half-step velocities of the gel are
/// means.
fn lead_velocity<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    touch: &ContactPoint<D>,
    step: f64,
) -> f64 {
    let (rigid, at) = body_at_tick(system, touch.body);
    let pull = rigid.freedom.translation(&at.wrench.force) / rigid.mass;
    let swelling = at.bulge.map_or(0.0, |bulge| touch.growth.dot(&bulge.acceleration));
    (0.5 * step * (touch.normal.dot(&pull) + swelling)).max(0.0)
}

/// Returns the bias velocity that the removal of standing penetration adds to the restituted velocity −e u⁻, m/s.
/// The target velocity is the greater of −e u⁻ and β |φ|/Δt until the next tick, capped.
fn bias_velocity<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    touch: &ContactPoint<D>,
    step: f64,
) -> f64 {
    let ImpulseLaw::Moreau { bias, restitution, .. } = system.model.settings.law else { return 0.0 };
    let standing = (-touch.distance - node_slop(system) * touch.size).max(0.0);
    let removal = (bias * standing / step).min(BIAS_CAP * system.state.record.contacts[touch.body].approach);
    if removal > 0.0 { (removal + restitution * touch.approach()).max(0.0) } else { 0.0 }
}

/// Applies w times the impulse to each carrying node and minus the impulse to the body, at the contact point.
fn apply_impulse<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, touch: usize, impulse: &Vector3) {
    let touch = &system.workspace.touches[touch];
    for (node, w) in touch.carriers() {
        let push = free_part(system, node, impulse) * (w / system.model.gel.mass[node.index()]);
        system.state.velocity[node.index()] += push;
    }
    let (body, point) = (touch.body, touch.point);
    system.model.bodies[body].strike(&mut system.workspace.now[body], &point, &-impulse);
}

/// Solves Moreau's law with Coulomb friction at all contact points and symmetry contacts: projected Gauss–Seidel
/// sweeps on the accumulated impulses until nothing changes.
pub(super) fn solve<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    restitution: f64,
    friction: f64,
) {
    let greatest_approach = system.state.record.contacts.iter().map(|contact| contact.approach).fold(0.0, f64::max);
    for _ in 0..MAX_SWEEPS {
        let mut residual: f64 = 0.0;
        for i in 0..system.workspace.touches.len() {
            residual = residual.max(correct_normal_impulse(system, i, restitution));
            if friction > 0.0 {
                residual = residual.max(correct_friction_impulse(system, i, friction));
            }
        }
        residual = residual.max(correct_symmetry_contacts(system));
        if residual <= RESIDUAL_TOLERANCE * greatest_approach {
            break;
        }
    }
    sum_body_impulses(system);
}

/// Sets the velocity of each free body from the sum of its contact impulses. Applied one by one over all sweeps,
/// they would round its momentum thousands of times a tick.
fn sum_body_impulses<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    for (body, rigid) in system.model.bodies.iter().enumerate().filter(|(_, body)| body.motion == BodyMotion::Free) {
        let touches = &system.workspace.touches;
        if touches.iter().all(|touch| touch.body != body) {
            continue;
        }
        let (was, now) = (&system.workspace.was[body], &mut system.workspace.now[body]);
        let push = |i: usize| if touches[i].body == body { -touches[i].push() } else { Vector3::zeros() };
        let arm = |i: usize| touches[i].point - was.position;
        let linear = ordered_sum(touches.len(), Vector3::zeros(), push);
        let turning = ordered_sum(touches.len(), Vector3::zeros(), |i| arm(i).cross(&push(i)));
        now.velocity = was.velocity + rigid.freedom.translation(&linear) / rigid.mass;
        now.angular_momentum = was.angular_momentum + rigid.freedom.rotation(&turning);
    }
}

/// Corrects one normal impulse; returns the change of velocity, m/s.
fn correct_normal_impulse<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    i: usize,
    restitution: f64,
) -> f64 {
    let touch = &system.workspace.touches[i];
    let rebound = touch.bias + touch.lead - restitution * (touch.approach() + touch.lead);
    let accumulated = touch.impulse;
    let free = touch.normal.dot(&relative(system, touch)) - touch.compliance * accumulated;
    let change = impulse(free, rebound, touch.compliance) - accumulated;
    if change == 0.0 {
        return 0.0;
    }
    let (push, velocity_change) = (touch.normal * change, change.abs() * touch.compliance);
    system.workspace.touches[i].impulse += change;
    apply_impulse(system, i, &push);
    velocity_change
}

/// Corrects one friction impulse: the impulse that would stop the sliding, cut to |Jₜ| ≤ μ J; returns the change
/// of velocity, m/s.
fn correct_friction_impulse<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    i: usize,
    friction: f64,
) -> f64 {
    let touch = &system.workspace.touches[i];
    let relative = relative(system, touch);
    let sliding = relative - touch.normal * touch.normal.dot(&relative);
    let Some(direction) = sliding.try_normalize(0.0) else { return 0.0 };
    let compliance = compliance(system, touch, &direction);
    if compliance == 0.0 {
        return 0.0;
    }
    let (limit, sticking) = (friction * touch.impulse, touch.drag - sliding / compliance);
    let drag = if sticking.norm() > limit { sticking.normalize() * limit } else { sticking };
    let change = drag - touch.drag;
    system.workspace.touches[i].drag = drag;
    apply_impulse(system, i, &change);
    change.norm() * compliance
}

/// Applies the paper's reversal law to the nodes of one element after its kick.
pub(super) fn apply_reversal<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, element: ElementId) {
    let gel = system.model.gel.clone();
    let nodes = gel.potential.nodes(element);
    for i in 0..system.workspace.touches.len() {
        let touch = &system.workspace.touches[i];
        if touch.nodes().iter().all(|node| nodes.contains(node)) {
            let j = reversal(touch.normal.dot(&relative(system, touch)), touch.compliance);
            let push = touch.normal * j;
            system.workspace.touches[i].impulse += j;
            apply_impulse(system, i, &push);
        }
    }
}

/// Makes the impulses events of the bodies, and adds them to the exchanges with the importer and to the record.
pub(super) fn receive<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    time: f64,
    (end, exchanges): (f64, &mut [ImpulseExchange]),
) {
    for (body, exchange) in exchanges.iter_mut().enumerate() {
        let Some(impulse) = body_impulse(system, body, exchange) else { continue };
        exchange.impulse += impulse;
        exchange.impulse_moment += impulse * (end - time);
        rebase_body(system, body, time);
        system.state.bodies[body] = system.workspace.now[body];
        record_impulse(system, body, impulse, time);
    }
}

/// Returns the impulse of this tick on a body, N·s, if there is one, and adds the sums over its contact points to
/// the exchange and to the record.
fn body_impulse<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    body: usize,
    exchange: &mut ImpulseExchange,
) -> Option<Vector3> {
    let (rigid, was, now) = (&system.model.bodies[body], &system.workspace.was[body], &system.workspace.now[body]);
    let record = &mut system.state.record.contacts[body];
    let touches = system.workspace.touches.iter().filter(|touch| touch.body == body && touch.impulse > 0.0);
    touches.fold(None, |sum: Option<Vector3>, touch| {
        let body_impulse = rigid.freedom.translation(&-touch.push());
        let arm = touch.point - was.position;
        let mean_velocity = (rigid.velocity_at(was, &touch.point) + rigid.velocity_at(now, &touch.point)) / 2.0;
        exchange.angular_impulse += rigid.freedom.rotation(&arm.cross(&body_impulse));
        // The whole normal impulse, with the part across the axis that a ring of an axisymmetric gel exerts.
        exchange.bulge_impulse -= touch.growth * touch.impulse;
        exchange.energy_residual -= body_impulse.dot(&mean_velocity);
        record.work += body_impulse.dot(&mean_velocity);
        if touch.n_nodes == 1 {
            let depth = -touch.distance / touch.size;
            record.standing = (record.standing.0 + depth, record.standing.1 + 1);
            record.deepest = record.deepest.max(depth);
        }
        Some(sum.unwrap_or_else(Vector3::zeros) + body_impulse)
    })
}

/// Records an impulse on a body: its sum, direction and time, the depth and the window of the peak force.
fn record_impulse<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    body: usize,
    impulse: Vector3,
    time: f64,
) {
    let depth = depth_in_gel(system, system.model.bodies[body].depth(&system.state.bodies[body]));
    let width = system.model.settings.force_window;
    let record = &mut system.state.record.contacts[body];
    record.impulse += impulse;
    record.direction = impulse.try_normalize(0.0).unwrap_or(record.direction);
    record.touched = Some((record.touched.map_or(time, |touched| touched.0), time));
    if depth > record.peak_depth.0 {
        record.peak_depth = (depth, time);
    }
    let window = (time / width) as u64;
    let (number, sum, greatest) = record.window;
    let sum = if window == number { sum + impulse } else { impulse };
    record.window = (window, sum, greatest.max(sum.norm()));
}
