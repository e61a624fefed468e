//! Contact solver: Moreau's law with Coulomb friction by projected Gauss–Seidel sweeps (method 2.3, A7).

use super::point::ContactPoint;
use super::self_contact::{SelfContact, correct_self_contacts};
use super::solver_body::SolverBody;
use super::surface::NodalMasses;
use super::symmetry::{SymmetryContact, correct_symmetry_contacts};
use super::{BodyMotion, BodyState, RigidBody, impulse, reversal};
use crate::math::{Vector, Vector3, ordered_sum};
use crate::mesh::NodeId;

/// Maximum number of Gauss–Seidel sweeps over the contact points of a tick (A7). A few sweeps settle a body heavier than the nodes it meets at once.
/// A body of a hundredth of their mass needs hundreds: after ten it kept 2 % of its approach.
const MAX_SWEEPS: usize = 400;

/// Residual, relative to the greatest approach speed, that ends the sweeps (A7).
const RESIDUAL_TOLERANCE: f64 = 1e-12;

/// Contact problem of a tick: the contact points, and the velocities that their impulses change.
pub(crate) struct ContactProblem<'a, const D: usize, M> {
    pub masses: &'a M,
    /// Velocities of the nodes, m/s.
    pub velocity: &'a mut [Vector<D>],
    pub bodies: &'a [RigidBody],
    /// Bodies before the impulses.
    pub was: &'a [BodyState],
    /// Bodies with the impulses so far.
    pub now: &'a mut [BodyState],
    pub points: &'a mut [ContactPoint<D>],
    pub symmetry: &'a mut [SymmetryContact],
    pub own: &'a mut [SelfContact<D>],
}

impl<const D: usize, M: NodalMasses<D>> ContactProblem<'_, D, M> {
    /// Solves Moreau's law with Coulomb friction at all contact points, symmetry contacts and self-contacts: projected
    /// Gauss–Seidel sweeps on the accumulated impulses until nothing changes, relative to the greatest approach speed so
    /// far, m/s. Returns true if they converged.
    #[must_use]
    pub fn solve(mut self, restitution: f64, friction: f64, greatest_approach: f64) -> bool {
        let greatest_approach = self.own.iter().map(|contact| -contact.before).fold(greatest_approach, f64::max);
        let states = self.bodies.iter().zip(&*self.now);
        let mut bodies: Vec<SolverBody> = states.map(|(rigid, state)| SolverBody::new(rigid, state)).collect();
        let mut has_converged = false;
        for _ in 0..MAX_SWEEPS {
            let mut residual: f64 = 0.0;
            for i in 0..self.points.len() {
                let body = &mut bodies[self.points[i].body];
                residual = residual.max(self.correct_normal_impulse(i, body, restitution));
                if friction > 0.0 {
                    residual = residual.max(self.correct_friction_impulse(i, body, friction));
                }
            }
            residual = residual.max(self.correct_gel_contacts());
            has_converged = residual <= RESIDUAL_TOLERANCE * greatest_approach;
            if has_converged {
                break;
            }
        }
        self.sum_body_impulses();
        has_converged
    }

    /// Applies the paper's reversal law at the contact points of these nodes, those of an element after its kick.
    pub fn reverse(&mut self, nodes: &[NodeId]) {
        for i in 0..self.points.len() {
            if self.points[i].nodes().iter().all(|node| nodes.contains(node)) {
                let touch = &self.points[i];
                let (rigid, body) = (&self.bodies[touch.body], touch.body);
                let relative = self.relative(touch, &rigid.velocity_at(&self.now[body], &touch.point));
                let j = reversal(touch.normal.dot(&relative), touch.compliance);
                let (push, point) = (touch.normal * j, touch.point);
                self.points[i].impulse += j;
                self.push_nodes(i, &push);
                rigid.strike(&mut self.now[body], &point, &-push);
            }
        }
    }

    /// Corrects the impulses of the gel with its images and with itself once; returns the greatest change of a velocity,
    /// m/s.
    pub fn correct_gel_contacts(&mut self) -> f64 {
        let symmetry = correct_symmetry_contacts(self.symmetry, self.masses, self.velocity);
        symmetry.max(correct_self_contacts(self.own, self.masses, self.velocity))
    }

    /// Returns the relative velocity Σ w v_a − V(x) with the impulses so far, m/s.
    fn relative(&self, touch: &ContactPoint<D>, body_velocity: &Vector3) -> Vector3 {
        touch.relative_velocity(body_velocity, |node| self.velocity[node.index()])
    }

    /// Applies w times the impulse to each carrying node and minus the impulse to the body, at the contact point.
    fn apply_impulse(&mut self, point: usize, body: &mut SolverBody<'_>, impulse: &Vector3) {
        self.push_nodes(point, impulse);
        body.strike(&self.points[point].point, &-impulse);
    }

    /// Applies w times the impulse to each carrying node.
    fn push_nodes(&mut self, point: usize, impulse: &Vector3) {
        for (node, change) in self.points[point].velocity_changes(impulse) {
            self.velocity[node.index()] += change;
        }
    }

    /// Corrects one normal impulse; returns the change of velocity, m/s.
    fn correct_normal_impulse(&mut self, i: usize, body: &mut SolverBody<'_>, restitution: f64) -> f64 {
        let touch = &self.points[i];
        let rebound = touch.bias + touch.lead - restitution * (touch.approach() + touch.lead);
        let accumulated = touch.impulse;
        let relative = self.relative(touch, &body.velocity_at(&touch.point));
        let free = touch.normal.dot(&relative) - touch.compliance * accumulated;
        let change = impulse(free, rebound, touch.compliance) - accumulated;
        if change == 0.0 {
            return 0.0;
        }
        let (push, velocity_change) = (touch.normal * change, change.abs() * touch.compliance);
        self.points[i].impulse += change;
        self.apply_impulse(i, body, &push);
        velocity_change
    }

    /// Corrects one friction impulse: the impulse that would stop the sliding, cut to |Jₜ| ≤ μ J; returns the change
    /// of velocity, m/s.
    fn correct_friction_impulse(&mut self, i: usize, body: &mut SolverBody<'_>, friction: f64) -> f64 {
        let touch = &self.points[i];
        let relative = self.relative(touch, &body.velocity_at(&touch.point));
        let sliding = relative - touch.normal * touch.normal.dot(&relative);
        let Some(direction) = sliding.try_normalize(0.0) else { return 0.0 };
        let (rigid, at) = (&self.bodies[touch.body], &self.was[touch.body]);
        let compliance = touch.compliance_along(self.masses, rigid, at, &direction);
        if compliance == 0.0 {
            return 0.0;
        }
        let (limit, sticking) = (friction * touch.impulse, touch.drag - sliding / compliance);
        let drag = if sticking.norm() > limit { sticking.normalize() * limit } else { sticking };
        let change = drag - touch.drag;
        self.points[i].drag = drag;
        self.apply_impulse(i, body, &change);
        change.norm() * compliance
    }

    /// Sets the velocity of each free body from the sum of its contact impulses. Applied one by one over all sweeps,
    /// they would round its momentum thousands of times a tick.
    fn sum_body_impulses(&mut self) {
        for (body, rigid) in self.bodies.iter().enumerate().filter(|(_, body)| body.motion == BodyMotion::Free) {
            let points = &*self.points;
            if points.iter().all(|touch| touch.body != body) {
                continue;
            }
            let (was, now) = (&self.was[body], &mut self.now[body]);
            let push = |i: usize| if points[i].body == body { -points[i].push() } else { Vector3::zeros() };
            let arm = |i: usize| points[i].point - was.position;
            let linear = ordered_sum(points.len(), Vector3::zeros(), push);
            let turning = ordered_sum(points.len(), Vector3::zeros(), |i| arm(i).cross(&push(i)));
            now.velocity = was.velocity + rigid.freedom.translation(&linear) / rigid.mass;
            now.angular_momentum = was.angular_momentum + rigid.freedom.rotation(&turning);
        }
    }
}
