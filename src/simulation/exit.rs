//! Perforation of the gel: exits, the end of a run after them, and bodies that return to a gel at rest.

use super::end_watch::EndSample;
use super::kinematics::StepInputs;
use super::observe::ExitReport;
use super::run::Simulation;
use crate::contact::{BodyMotion, BodyState, RigidBody};
use crate::math::Vector3;
use crate::scene::{CouplingMode, GelBox};

/// Fraction of the exit speed of the projectile below which another body counts as at rest in the gel.
const RESTING_SPEED: f64 = 0.01;
/// Speed below which another body counts as at rest beside a projectile that rests, m/s: it moves by 0.1 mm in 1 ms.
const SLOW: f64 = 0.1;
/// Straight segments in which the path of a body over a step is checked.
const PATH_SEGMENTS: u32 = 16;

/// Returns true if a body meets the box of the gel between two points of its path.
fn meets_box(gel: &GelBox, body: &RigidBody, from: &BodyState, to: &BodyState) -> bool {
    (0..3).all(|axis| {
        let mut out = Vector3::zeros();
        out[axis] = 1.0;
        let least = |at: &BodyState| at.position[axis] - body.reach(at, &-out);
        let most = |at: &BodyState| at.position[axis] + body.reach(at, &out);
        least(from).min(least(to)) < gel.upper[axis] && most(from).max(most(to)) > gel.lower[axis]
    })
}

impl Simulation {
    /// Exit of a body at the back face of the gel, which moves with the block; `None` for a body that has not left
    /// there.
    #[must_use]
    pub fn exit(&self, body: usize) -> Option<ExitReport> {
        self.model.record().contacts[body].exit.map(|exit| ExitReport {
            time: exit.time,
            velocity: exit.velocity,
            residual_energy: exit.residual_energy,
        })
    }

    /// Energy that a body has given to the gel, J, up to its exit if it has left; in the inertial frame in which the
    /// gel was at rest at the start.
    #[must_use]
    pub fn energy_deposited(&self, body: usize) -> f64 {
        let (contact, start) = (&self.model.record().contacts[body], &self.model.block_frame().initial_velocity);
        contact.exit.map_or_else(|| contact.energy_given(start), |exit| exit.energy_deposited) + 0.0
    }

    /// Returns true if the run is over by the exit or, with `scene.stop_at_rest`, by the rest of the projectile.
    ///
    /// By the exit: `scene.stop_after_exit` has passed since, the cavity has turned (`scene.await_cavity`), and every
    /// other body has left the gel or come to rest.
    /// `gelfmu run` ends at the first communication point after that. Where all bodies have left, the gel is at rest
    /// from a tick on, so that the state does not depend on that point.
    #[must_use]
    pub fn is_over(&self) -> bool {
        let rests = self.constants.end_rules.stops_at_rest && self.watch.rests();
        let Some(exit) = self.exit(0).filter(|_| !self.is_at_rest()) else { return self.is_at_rest() || rests };
        let is_away = |body: &usize| !self.now(*body).active || self.model.is_away(*body, &self.now(*body));
        let is_still = |body: usize| self.seen(body).velocity.norm() < RESTING_SPEED * exit.velocity.norm();
        let mut inside = (1..self.n_bodies()).filter(|body| !is_away(body)).peekable();
        let is_late = self.time - exit.time >= self.constants.end_rules.rest_after(&self.watch) && is_away(&0);
        is_late && inside.peek().is_some() && inside.all(is_still)
    }

    /// Returns the time of the next look of the watch over the end, s; `None` if there is nothing to wait for.
    pub(super) fn next_look(&self) -> Option<f64> {
        self.constants.end_rules.next_look(self.time, &self.watch).filter(|_| !self.is_at_rest())
    }

    /// Looks at projectile and cavity for the watch over the end, as they are seen from the block.
    pub(super) fn look(&mut self) {
        let has_left = self.exit(0).is_some();
        if has_left || self.constants.end_rules.stops_at_rest {
            let (time, depth, diameter) = (self.time, self.depth(0), self.cavity_diameter());
            let may_rest = depth > 0.0 && self.may_rest();
            self.watch.add(EndSample { time, depth, diameter, has_left, may_rest });
        }
        self.watch.is_last = self.constants.end_rules.is_last(self.time);
        self.apply_watch();
    }

    /// Lets the gel be put to rest as the watch has found.
    pub(super) fn apply_watch(&mut self) {
        self.model.set_rest_after(self.constants.end_rules.rest_after(&self.watch));
    }

    /// Greatest diameter of the cavity behind the projectile, m, below one width of the projectile; 0 without one.
    fn cavity_diameter(&self) -> f64 {
        let (fixed, seen, displacement) = (self.model.body(0).0, self.seen(0), self.block_motion().displacement);
        let width = [Vector3::x(), -Vector3::x()].map(|side| fixed.reach(&seen, &side)).iter().sum::<f64>();
        let fills = seen.active && fixed.depth(&seen) > 0.0;
        let rear = if fills { -fixed.rear(&seen) } else { f64::INFINITY };
        if let Some(diameter) = self.model.opened_diameter(self.time, width, rear) {
            return diameter;
        }
        let facets = || self.model.facet_corners(self.time).into_iter();
        let facets = || facets().map(|corners| corners.map(|corner| corner - displacement));
        self.constants.end_rules.line.map_or(0.0, |line| line.diameter(facets(), width, rear))
    }

    /// Returns true if the projectile has touched the gel and has not left it, and every other body is away or slow.
    fn may_rest(&self) -> bool {
        let contact = &self.model.record().contacts[0];
        let can_rest = self.model.body(0).0.motion != BodyMotion::Fixed && self.now(0).active;
        let is_done = |body: usize| {
            let now = self.now(body);
            !now.active || self.model.is_away(body, &now) || self.seen(body).velocity.norm() < SLOW
        };
        can_rest && contact.touched.is_some() && contact.exit.is_none() && (1..self.n_bodies()).all(is_done)
    }

    /// Returns true if the gel is no longer integrated: the projectile left it `scene.stop_after_exit` ago, the
    /// cavity has turned if it is awaited, and all other bodies are away.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.model.is_at_rest()
    }

    /// Returns true if these inputs bring an active body back to a gel at rest in a step of this length, s; contact
    /// would not act on it.
    #[must_use]
    pub fn reenters_resting_gel(&self, body: usize, inputs: &StepInputs, duration: f64) -> bool {
        let (fixed, Some(gel)) = (self.model.body(body).0, &self.constants.gel_box) else { return false };
        if !self.is_at_rest() || !inputs.active || fixed.motion == BodyMotion::Fixed {
            return false;
        }
        let start = self.state_at_start(body, inputs);
        let at = |piece: u32| {
            let time = self.time + duration * f64::from(piece) / f64::from(PATH_SEGMENTS);
            self.model.block_motion(time).seen_from(&start.at(fixed, time))
        };
        (0..PATH_SEGMENTS).any(|piece| meets_box(gel, fixed, &at(piece), &at(piece + 1)))
    }

    /// State of a body at the start of a step under these inputs.
    fn state_at_start(&self, body: usize, inputs: &StepInputs) -> BodyState {
        let (now, mass) = (self.now(body), self.model.body(body).0.mass);
        match self.mode {
            CouplingMode::Integrated if now.active => BodyState { wrench: inputs.wrench, ..now },
            CouplingMode::Integrated | CouplingMode::Corrected => {
                BodyState { wrench: inputs.wrench, ..self.state_from_inputs(body, inputs) }
            }
            CouplingMode::Prescribed => {
                let mut given = self.state_from_inputs(body, inputs);
                given.wrench.force = inputs.acceleration * mass;
                given
            }
        }
    }
}
