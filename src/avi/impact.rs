//! The contact phase: which nodes touch, and the impulses of one tick (numerics 2.3, A7).

use super::engine::Engine;
use super::{StepError, SurfaceNode};
use crate::algebra::{Vector, Vector3, embed, restrict};
use crate::contact::{BodyState, Exchange, Law, impulse, reversal};
use crate::element::Potential;
use crate::geometry::{Gap, SignedDistance};
use crate::mesh::{ElementId, NodeId};
use crate::state::Tick;

/// A surface node inside the body at this tick.
#[derive(Debug, Clone)]
pub(super) struct Touch<const D: usize> {
    pub node: NodeId,
    /// h, m.
    pub size: f64,
    /// φ, m.
    pub distance: f64,
    /// n out of the body: in the world, and in the gel's free directions.
    pub normal: Vector3,
    pub free_normal: Vector<D>,
    /// x, m.
    pub point: Vector3,
    /// K = 1/m + 1/M + (r×n)·I⁻¹(r×n), 1/kg.
    pub compliance: f64,
    /// u⁻, relative normal velocity before the tick, m/s.
    pub before: f64,
    /// b, velocity that removes standing penetration, m/s.
    pub bias: f64,
    /// J so far, N·s.
    pub impulse: f64,
}

/// A leak is a facet whose middle is deeper in the body than this, in element sizes or radii of the body, whichever is
/// less (A11).
const LEAK: f64 = 0.25;
/// Sweeps over the touching nodes of a tick, and the approach, relative to the fastest, that ends them (A7).
const SWEEPS: usize = 10;
const SETTLED: f64 = 1e-12;
/// A node counts as inside up to this distance above the surface, in element sizes. A node that rests on a moving body at
/// a distance of exactly zero is otherwise found inside or outside by rounding, and each miss costs an impact: the
/// rebound of a mass that starts touching a bar was 2.3 % off. Rounding is ten thousand times smaller.
const TOUCH: f64 = 1e-9;
/// Removal of penetration is at most this fraction of the greatest approach speed seen (numerics 2.5).
const BIAS_CAP: f64 = 0.1;
/// Penetration that is left standing, in element sizes. Without it nodes are pushed off and fall back for ever: on
/// `sphere-block` the removal then pumps 4.7 % of the impact energy through the contact; at 0.005 it is 0.09 % (0.18 % on
/// Kuhn tetrahedra), at 0.01 0.05 % (0.09 %), with a mean standing penetration of 0.006 to 0.007 where 0.01 is allowed (A7).
const SLOP: f64 = 0.01;

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

    /// The active nodes inside the body, ascending.
    pub(super) fn find_touches(&mut self, body: &BodyState) {
        let mut touches = std::mem::take(&mut self.scratch.touches);
        touches.clear();
        for surface in &self.scratch.reached {
            let (surface, gap) = (self.gel.surface.nodes[*surface as usize], self.scratch.gaps[*surface as usize]);
            if let Some(gap) = gap.filter(|gap| gap.distance <= TOUCH * surface.size) {
                touches.extend(self.touch(&surface, &gap, body));
            }
        }
        let record = &mut self.state.record;
        record.approach = touches.iter().map(|touch| -touch.before).fold(record.approach, f64::max);
        for touch in &mut touches {
            touch.bias = self.bias(touch);
        }
        self.scratch.touches = touches;
    }

    /// A node inside the body; `None` if neither can move.
    fn touch(&self, surface: &SurfaceNode, gap: &Gap, body: &BodyState) -> Option<Touch<D>> {
        let node = surface.node;
        let point = embed(&self.state.position[node.index()]);
        let free_normal = restrict::<D>(&gap.normal).component_mul(&self.gel.free[node.index()]);
        let own = free_normal.norm_squared() / self.gel.mass[node.index()];
        let compliance = own + self.body.compliance(body, &(point - body.position), &gap.normal);
        let mut touch = Touch {
            node,
            size: surface.size,
            distance: gap.distance,
            normal: gap.normal,
            free_normal,
            point,
            compliance,
            before: 0.0,
            bias: 0.0,
            impulse: 0.0,
        };
        touch.before = self.approach(&touch, body);
        (compliance > 0.0).then_some(touch)
    }

    /// u = n·(v_a − V(x_a)), m/s.
    pub(super) fn approach(&self, touch: &Touch<D>, body: &BodyState) -> f64 {
        let gel = embed(&self.state.velocity[touch.node.index()]);
        touch.normal.dot(&(gel - self.body.velocity_at(body, &touch.point)))
    }

    /// What the removal of standing penetration adds to the restituted velocity −e u⁻: the target is the greater of
    /// −e u⁻ and β |φ|/Δt until the node's next tick, capped.
    fn bias(&self, touch: &Touch<D>) -> f64 {
        let Law::Moreau { bias, restitution } = self.rules.law else { return 0.0 };
        let step = self.grid.time(self.shortest_around(touch.node) as Tick);
        let standing = (-touch.distance - SLOP * touch.size).max(0.0);
        let removal = (bias * standing / step).min(BIAS_CAP * self.state.record.approach);
        if removal > 0.0 { (removal + restitution * touch.before).max(0.0) } else { 0.0 }
    }

    /// J n on the node and −J n on the body, at the same point.
    fn strike(&mut self, touch: usize, j: f64, body: &mut BodyState) {
        let touch = &mut self.scratch.touches[touch];
        touch.impulse += j;
        let node = touch.node.index();
        self.state.velocity[node] += touch.free_normal * (j / self.gel.mass[node]);
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
            if self.gel.potential.nodes(patch).contains(&touch.node) {
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
            let standing = &mut self.state.record.standing;
            *standing = (standing.0 - touch.distance / touch.size, standing.1 + 1);
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
                let mut facets = surface.around.of(near.node).iter().map(|id| &surface.facets[id.index()][..D]);
                facets.try_for_each(|corners| self.check_facet(corners, near.size, (body, time)))?;
            }
        }
        Ok(())
    }

    fn check_facet(&self, corners: &[NodeId], size: f64, (body, time): (&BodyState, f64)) -> Result<(), StepError> {
        let middle = corners.iter().map(|node| embed(&self.position_at(*node, time))).sum::<Vector3>() / D as f64;
        let depth = -self.body.gap(body, &middle).distance;
        if depth <= LEAK * size.min(self.body.shape.inner_radius()) {
            return Ok(());
        }
        Err(StepError::Leak { element: self.element_behind(corners).index(), time, depth, at: middle.into() })
    }

    /// The element that has all nodes of a facet.
    fn element_behind(&self, corners: &[NodeId]) -> ElementId {
        let has_all = |patch: &&ElementId| corners.iter().all(|node| self.gel.potential.nodes(**patch).contains(node));
        self.gel.star.of(corners[0]).iter().find(has_all).copied().unwrap_or_default()
    }
}
