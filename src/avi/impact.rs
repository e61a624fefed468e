//! The contact phase: which nodes touch, and the impulses of one tick (numerics 2.3, A7).

use super::StepError;
use super::engine::Engine;
use crate::algebra::{Vector, Vector3, embed, restrict};
use crate::contact::{BodyState, Exchange, Law, impulse, reversal};
use crate::element::Potential;
use crate::geometry::{Gap, SignedDistance};
use crate::mesh::{ElementId, NodeId};
use crate::state::Tick;

/// A point of the surface inside the body at this tick: a node, or the middle of a facet.
#[derive(Debug, Clone)]
pub(super) struct Touch<const D: usize> {
    /// The nodes that carry it in equal parts; the first `n_nodes` count.
    pub nodes: [NodeId; 3],
    pub n_nodes: usize,
    /// h, m.
    pub size: f64,
    /// φ, m.
    pub distance: f64,
    /// n out of the body, in the world.
    pub normal: Vector3,
    /// x, m.
    pub point: Vector3,
    /// K = Σ w² n·P n/m + 1/M + (r×n)·I⁻¹(r×n) with w = 1/`n_nodes`, 1/kg.
    pub compliance: f64,
    /// u⁻, relative normal velocity before the tick, m/s.
    pub before: f64,
    /// b, velocity that removes standing penetration, m/s.
    pub bias: f64,
    /// J so far, N·s.
    pub impulse: f64,
}

impl<const D: usize> Touch<D> {
    pub fn nodes(&self) -> &[NodeId] {
        &self.nodes[..self.n_nodes]
    }

    /// w, the part of each node.
    pub fn share(&self) -> f64 {
        1.0 / self.n_nodes as f64
    }
}

/// The middle of a facet is stopped at this depth, in element sizes or radii of the body, whichever is less: a body
/// sharper than the mesh, or one over which the surface is stretched, must not slip between nodes. Shallower, nodes carry
/// the contact alone, because holding the middles of all facets at the surface would lift their nodes off a curved body:
/// at 0.1 the depth of `sphere-block` falls from 14.16 to 13.92 mm (14.5 when converged), from 0.2 on it does not change.
const FACE_DEPTH: f64 = 0.2;
/// A leak is a facet whose middle is deeper in the body than this all the same, in the same measure (A11).
const LEAK: f64 = 0.5;
/// Sweeps over the touching nodes of a tick, and the approach, relative to the fastest, that ends them (A7).
const SWEEPS: usize = 10;
const SETTLED: f64 = 1e-12;
/// A node counts as inside up to this distance above the surface, in element sizes. A node that rests on a moving body at
/// a distance of exactly zero is otherwise found inside or outside by rounding, and each miss costs an impact: the
/// rebound of a mass that starts touching a bar was 2.3 % off. Rounding is ten thousand times smaller.
const TOUCH: f64 = 1e-9;
/// Removal of penetration is at most this fraction of the greatest approach speed seen (numerics 2.5).
const BIAS_CAP: f64 = 0.1;
/// Penetration that is left standing, in element sizes. Removing all of it pushes nodes off that fall back for ever, and
/// pumps energy through the contact: 4.7 % of the impact energy on `sphere-block` at 0, 0.05 % at 0.01, nothing at 0.03;
/// under an oblique ball on a coarse mesh 0.4 % at 0.01, nothing at 0.03. What stands in the mean does not grow with it:
/// 0.005 to 0.008 where 0.01 is allowed (A7), because nodes that approach are found when they are that deep.
const SLOP: f64 = 0.03;

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// φ and n of the active surface nodes.
    pub(super) fn measure_gaps(&mut self, body: &BodyState) {
        let scratch = &mut self.scratch;
        for surface in scratch.reached.drain(..) {
            scratch.gaps[surface as usize] = None;
        }
        let surface_of = |node: &NodeId| self.gel.surface.of[node.index()];
        scratch.reached.extend(scratch.active.iter().filter_map(surface_of));
        scratch.reached.sort_unstable();
        for surface in &scratch.reached {
            let node = self.gel.surface.nodes[*surface as usize].node;
            let gap = self.body.gap(body, &embed(&self.state.position[node.index()]));
            scratch.gaps[*surface as usize] = Some(gap);
        }
    }

    /// The active nodes inside the body, ascending, then the firing facets whose middle is deep inside.
    pub(super) fn find_touches(&mut self, body: &BodyState, tick: Tick) {
        let mut touches = std::mem::take(&mut self.scratch.touches);
        touches.clear();
        let surface = &self.gel.surface;
        let mut facets = vec![];
        for reached in &self.scratch.reached {
            let (at, gap) = (surface.nodes[*reached as usize], self.scratch.gaps[*reached as usize]);
            let Some(gap) = gap.filter(|gap| gap.distance < at.size) else { continue };
            if gap.distance <= TOUCH * at.size {
                let point = embed(&self.state.position[at.node.index()]);
                touches.extend(self.touch(&[at.node], (at.size, point), &gap, body));
            }
            let fires = |facet: &&ElementId| self.state.clocks[self.gel.behind[facet.index()].index()].last == tick;
            facets.extend(surface.around.of(at.node).iter().filter(fires).map(|facet| (*facet, at.size)));
        }
        facets.sort_unstable_by_key(|(facet, _)| *facet);
        facets.dedup_by_key(|(facet, _)| *facet);
        touches.extend(facets.into_iter().filter_map(|(facet, size)| self.touching_facet(facet, size, body)));
        let record = &mut self.state.record;
        record.approach = touches.iter().map(|touch| -touch.before).fold(record.approach, f64::max);
        for touch in &mut touches {
            touch.bias = self.bias(touch);
        }
        self.scratch.touches = touches;
    }

    fn touching_facet(&self, facet: ElementId, size: f64, body: &BodyState) -> Option<Touch<D>> {
        let middle = self.middle(facet, body.time);
        let gap = self.body.gap(body, &middle);
        let deep = -gap.distance > FACE_DEPTH * size.min(self.body.shape.inner_radius());
        let corners = &self.gel.surface.facets[facet.index()][..D];
        if deep { self.touch(corners, (size, middle), &gap, body) } else { None }
    }

    /// A point inside the body that these nodes carry in equal parts; `None` if neither they nor the body can move.
    fn touch(
        &self,
        carriers: &[NodeId],
        (size, point): (f64, Vector3),
        gap: &Gap,
        body: &BodyState,
    ) -> Option<Touch<D>> {
        let mut nodes = [carriers[0]; 3];
        nodes[..carriers.len()].copy_from_slice(carriers);
        let (distance, normal) = (gap.distance, gap.normal);
        let compliance = self.body.compliance(body, &(point - body.position), &normal);
        let n_nodes = carriers.len();
        let (before, bias, impulse) = (0.0, 0.0, 0.0);
        let mut touch = Touch { nodes, n_nodes, size, distance, normal, point, compliance, before, bias, impulse };
        let own = |node: &NodeId| self.free_normal(*node, &normal).norm_squared() / self.gel.mass[node.index()];
        touch.compliance += touch.share() * touch.share() * carriers.iter().map(own).sum::<f64>();
        touch.before = self.approach(&touch, body);
        (touch.compliance > 0.0).then_some(touch)
    }

    /// P n, the normal in the free directions of a node.
    fn free_normal(&self, node: NodeId, normal: &Vector3) -> Vector<D> {
        restrict::<D>(normal).component_mul(&self.gel.free[node.index()])
    }

    /// u = n·(Σ w v_a − V(x)), m/s.
    pub(super) fn approach(&self, touch: &Touch<D>, body: &BodyState) -> f64 {
        let gel: Vector3 = touch.nodes().iter().map(|node| embed(&self.state.velocity[node.index()])).sum();
        touch.normal.dot(&(gel * touch.share() - self.body.velocity_at(body, &touch.point)))
    }

    /// What the removal of standing penetration adds to the restituted velocity −e u⁻: the target is the greater of
    /// −e u⁻ and β |φ|/Δt until the node's next tick, capped. Middles of facets are only stopped.
    fn bias(&self, touch: &Touch<D>) -> f64 {
        let (Law::Moreau { bias, restitution }, [node]) = (self.rules.law, touch.nodes()) else { return 0.0 };
        let step = self.grid.time(self.shortest_around(*node) as Tick);
        let standing = (-touch.distance - SLOP * touch.size).max(0.0);
        let removal = (bias * standing / step).min(BIAS_CAP * self.state.record.approach);
        if removal > 0.0 { (removal + restitution * touch.before).max(0.0) } else { 0.0 }
    }

    /// w J n on each carrier and −J n on the body, at the point that they carry.
    fn strike(&mut self, touch: usize, j: f64, body: &mut BodyState) {
        self.scratch.touches[touch].impulse += j;
        let touch = &self.scratch.touches[touch];
        for node in touch.nodes() {
            let push = self.free_normal(*node, &touch.normal) * (j * touch.share() / self.gel.mass[node.index()]);
            self.state.velocity[node.index()] += push;
        }
        self.body.strike(body, &touch.point, &(touch.normal * -j));
    }

    /// Moreau's law for all touching nodes in ascending order, swept until no approach is left; the projected
    /// Gauss–Seidel method on the accumulated impulses.
    pub(super) fn solve(&mut self, restitution: f64, body: &mut BodyState) {
        for _ in 0..SWEEPS {
            let mut residual: f64 = 0.0;
            for i in 0..self.scratch.touches.len() {
                let touch = &self.scratch.touches[i];
                let (rebound, so_far) = (touch.bias - restitution * touch.before, touch.impulse);
                let free = self.approach(touch, body) - touch.compliance * so_far;
                let change = impulse(free, rebound, touch.compliance) - so_far;
                residual = residual.max(change.abs() * touch.compliance);
                if change != 0.0 {
                    self.strike(i, change, body);
                }
            }
            if residual <= SETTLED * self.state.record.approach {
                break;
            }
        }
    }

    /// The paper's law for the nodes of one patch that has just been kicked.
    pub(super) fn reverse(&mut self, patch: ElementId, body: &mut BodyState) {
        for i in 0..self.scratch.touches.len() {
            let touch = &self.scratch.touches[i];
            if touch.nodes().iter().all(|node| self.gel.potential.nodes(patch).contains(node)) {
                let j = reversal(self.approach(touch, body), touch.compliance);
                if j > 0.0 {
                    self.strike(i, j, body);
                }
            }
        }
    }

    /// Makes the impulses an event of the body, and tells the importer and the record what it received.
    pub(super) fn receive(
        &mut self,
        (was, now): (&BodyState, &BodyState),
        time: f64,
        (end, exchange): (f64, &mut Exchange),
    ) {
        let touches = std::mem::take(&mut self.scratch.touches);
        let mut impulse = Vector3::zeros();
        let struck = touches.iter().any(|touch| touch.impulse > 0.0);
        for touch in touches.iter().filter(|touch| touch.impulse > 0.0) {
            let given = self.body.freedom.translation(&(touch.normal * -touch.impulse));
            let arm = touch.point - was.position;
            let wall = (self.body.velocity_at(was, &touch.point) + self.body.velocity_at(now, &touch.point)) / 2.0;
            exchange.angular_impulse += self.body.freedom.rotation(&arm.cross(&given));
            exchange.energy_residual -= given.dot(&wall);
            impulse += given;
            if touch.n_nodes == 1 {
                let standing = &mut self.state.record.standing;
                *standing = (standing.0 - touch.distance / touch.size, standing.1 + 1);
            }
        }
        self.scratch.touches = touches;
        if !struck {
            return;
        }
        exchange.impulse += impulse;
        exchange.impulse_moment += impulse * (end - time);
        self.rebase_body(time);
        self.state.body = *now;
        self.record_impulse(impulse, time);
    }

    fn record_impulse(&mut self, impulse: Vector3, time: f64) {
        let depth = self.body.depth(&self.state.body);
        let width = self.rules.force_window;
        let record = &mut self.state.record;
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

    /// The middles of the facets around nodes near the body must not be deep inside it (A11).
    pub(super) fn check_leaks(&self, body: &BodyState, time: f64) -> Result<(), StepError> {
        let surface = &self.gel.surface;
        for reached in &self.scratch.reached {
            let (near, gap) = (surface.nodes[*reached as usize], self.scratch.gaps[*reached as usize]);
            if gap.is_some_and(|gap| gap.distance < near.size) {
                let mut facets = surface.around.of(near.node).iter();
                facets.try_for_each(|facet| self.check_facet(*facet, near.size, (body, time)))?;
            }
        }
        Ok(())
    }

    fn check_facet(&self, facet: ElementId, size: f64, (body, time): (&BodyState, f64)) -> Result<(), StepError> {
        let middle = self.middle(facet, time);
        let depth = -self.body.gap(body, &middle).distance;
        if depth <= LEAK * size.min(self.body.shape.inner_radius()) {
            return Ok(());
        }
        Err(StepError::Leak { element: self.gel.behind[facet.index()].index(), time, depth, at: middle.into() })
    }

    /// The middle of a facet at time `t`, m.
    fn middle(&self, facet: ElementId, t: f64) -> Vector3 {
        let corners = &self.gel.surface.facets[facet.index()][..D];
        corners.iter().map(|node| embed(&self.position_at(*node, t))).sum::<Vector3>() / D as f64
    }
}
