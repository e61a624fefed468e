//! Motion of a rigid body between events, in closed form from the last event (method A4).

use super::{BodyMotion, BodyState, RigidBody, Wrench};
use crate::ledger::Ledger;
use crate::math::Vector3;
use nalgebra::{Quaternion, UnitQuaternion};

/// Work and impulse of the wrench between two events of a body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WrenchWork {
    /// Work of the wrench, J.
    pub work: f64,
    /// Energy error of the orientation step, J.
    pub defect: f64,
    /// Change of the energy of rotation by the change of the inertia of an expanding body, J.
    pub expansion: f64,
    /// Momentum given by the wrench, N·s.
    pub momentum: Vector3,
    /// Angular momentum about the origin given by the wrench, N·m·s.
    pub angular_momentum: Vector3,
}

impl WrenchWork {
    /// Posts the work and the impulses to the ledger.
    pub fn post(&self, ledger: &mut Ledger) {
        ledger.energy.external += self.work;
        ledger.energy.integration += self.defect;
        ledger.energy.expansion += self.expansion;
        ledger.momentum.external += self.momentum;
        ledger.angular_momentum.external += self.angular_momentum;
    }
}

impl BodyState {
    /// Returns the state of the body at time `t`, as if that were an event.
    ///
    /// x = x₀ + v₀h + Fh²/2M + Ḟh³/6M, v = v₀ + (Fh + Ḟh²/2)/M, L = L₀ + Th + Ṫh²/2; the orientation by the midpoint
    /// rule with the exact L (second order; exact for a sphere without torque), at constant ω if prescribed.
    #[must_use]
    pub fn at(&self, body: &RigidBody, t: f64) -> Self {
        let h = t - self.time;
        let mut next = Self { time: t, ..*self };
        if h == 0.0 || !self.active {
            return next;
        }
        next.shape_motion = self.shape_motion.map(|shape| shape.after(h));
        if body.motion == BodyMotion::Fixed {
            return next;
        }
        let Wrench { force, torque, force_rate, torque_rate } = self.wrench;
        next.position += h * (self.velocity + h / body.mass * (force / 2.0 + h * force_rate / 6.0));
        next.velocity += h / body.mass * (force + h * force_rate / 2.0);
        next.wrench = Wrench { force: force + h * force_rate, torque: torque + h * torque_rate, ..self.wrench };
        match body.motion {
            BodyMotion::Prescribed => {
                let spin = body.angular_velocity(self);
                next.orientation = rotate(&self.orientation, &(spin * h));
                next.angular_momentum = body.angular_momentum(&next, &spin);
            }
            BodyMotion::Free | BodyMotion::Fixed => self.step_orientation(body, &mut next),
        }
        next
    }

    /// Steps angular momentum and orientation by the midpoint rule.
    fn step_orientation(&self, body: &RigidBody, next: &mut Self) {
        let h = next.time - self.time;
        let Wrench { torque, torque_rate, .. } = self.wrench;
        let momentum = |s: f64| self.angular_momentum + s * (torque + s / 2.0 * torque_rate);
        next.angular_momentum = momentum(h);
        if next.angular_momentum == Vector3::zeros() && self.angular_momentum == Vector3::zeros() {
            return;
        }
        let start = body.angular_velocity(self);
        let mut middle = *self;
        middle.orientation = rotate(&self.orientation, &(start * (h / 2.0)));
        middle.shape_motion = self.shape_motion.map(|shape| shape.after(h / 2.0));
        let spin = body.spin(&middle, &momentum(h / 2.0));
        next.orientation = rotate(&self.orientation, &(spin * h));
    }

    /// Returns the work and impulse of the wrench between this event and `next`, each from its own formula.
    #[must_use]
    pub fn passage(&self, body: &RigidBody, next: &Self) -> WrenchWork {
        let h = next.time - self.time;
        if body.motion == BodyMotion::Fixed || h == 0.0 || !self.active {
            return WrenchWork::default();
        }
        let (l0, l1) = (self.angular_momentum, next.angular_momentum);
        // ω₁ with the inertia at the first event: the change of the inertia is an account of its own.
        let unchanged = BodyState { shape_motion: self.shape_motion, ..*next };
        let (w0, w1) = (body.angular_velocity(self), body.angular_velocity(&unchanged));
        let expansion = (body.angular_velocity(next) - w1).dot(&l1) / 2.0;
        // ½(L₁·ω₁ − L₀·ω₀) = ΔL·(ω₀ + ω₁)/2 + (L₀·ω₁ − L₁·ω₀)/2: the work of the torque and what the midpoint rule adds.
        let turning = (l1 - l0).dot(&(w0 + w1)) / 2.0;
        let defect = (l0.dot(&w1) - l1.dot(&w0)) / 2.0;
        let Wrench { force, torque, force_rate, torque_rate } = self.wrench;
        let momentum = h * (force + h / 2.0 * force_rate);
        let angular = match body.motion {
            BodyMotion::Free => h * (torque + h / 2.0 * torque_rate),
            BodyMotion::Prescribed | BodyMotion::Fixed => l1 - l0,
        };
        WrenchWork {
            work: self.force_work(body, h) + turning,
            defect,
            expansion,
            momentum,
            angular_momentum: angular + self.moment_of_force(body, h),
        }
    }

    /// Returns ∫ F·v ds, J, with v(s) = v₀ + (Fs + Ḟs²/2)/M and F(s) = F + Ḟs.
    fn force_work(&self, body: &RigidBody, h: f64) -> f64 {
        let (f, rate, v, m) = (self.wrench.force, self.wrench.force_rate, self.velocity, body.mass);
        let linear = f.dot(&f) / m + rate.dot(&v);
        h * (f.dot(&v) + h * (linear / 2.0 + h * (f.dot(&rate) / (2.0 * m) + h * rate.dot(&rate) / (8.0 * m))))
    }

    /// Returns ∫ x × F ds, N·m·s, with x(s) = x₀ + v₀s + Fs²/2M + Ḟs³/6M.
    fn moment_of_force(&self, body: &RigidBody, h: f64) -> Vector3 {
        let (x, v, m) = (self.position, self.velocity, body.mass);
        let (f, rate) = (self.wrench.force, self.wrench.force_rate);
        let linear = x.cross(&rate) + v.cross(&f);
        // s²: v × Ḟ + F × F/2M = v × Ḟ; s³: (F × Ḟ)/2M + (Ḟ × F)/6M = (F × Ḟ)/3M.
        h * (x.cross(&f) + h * (linear / 2.0 + h * (v.cross(&rate) / 3.0 + h * f.cross(&rate) / (12.0 * m))))
    }
}

/// Returns the orientation after a rotation by the world vector `angle`: exp(θ) = (cos |θ|/2, sin |θ|/2 θ/|θ|),
/// renormalised.
#[must_use]
fn rotate(orientation: &UnitQuaternion<f64>, angle: &Vector3) -> UnitQuaternion<f64> {
    let size = angle.norm();
    if size == 0.0 {
        return *orientation;
    }
    let (sin, cos) = libm::sincos(0.5 * size);
    let turn = Quaternion::from_parts(cos, angle * (sin / size));
    let product = turn * orientation.into_inner();
    UnitQuaternion::new_unchecked(product / product.norm())
}

#[cfg(test)]
mod tests {
    use super::super::FreeDirections;
    use super::*;
    use crate::geometry::{ShapeGeometry, Sphere};
    use crate::math::Tensor3;

    fn rod(motion: BodyMotion) -> (RigidBody, BodyState) {
        let inertia = Tensor3::from_diagonal(&Vector3::new(0.5, 0.7, 0.2));
        let shape = ShapeGeometry::Sphere(Sphere { radius: 0.1 });
        let body = RigidBody::new(shape, motion, FreeDirections::SPATIAL, 2.0, inertia);
        let start = BodyState::at_start(Vector3::new(0.1, -0.2, 0.3), Vector3::new(1.0, 2.0, -3.0));
        let state = BodyState { angular_momentum: Vector3::new(0.3, 1.0, 0.2), ..start };
        (body, state)
    }

    fn wrench() -> Wrench {
        Wrench {
            force: Vector3::new(1.0, -2.0, 0.5),
            torque: Vector3::new(0.2, 0.1, -0.3),
            force_rate: Vector3::new(-3.0, 1.0, 2.0),
            torque_rate: Vector3::new(0.5, -0.4, 0.1),
        }
    }

    #[test]
    fn the_work_of_the_wrench_explains_energy_momentum_and_angular_momentum_to_round_off() {
        for motion in [BodyMotion::Free, BodyMotion::Prescribed] {
            let (body, mut state) = rod(motion);
            state.wrench = wrench();
            if motion == BodyMotion::Prescribed {
                (state.wrench.torque, state.wrench.torque_rate) = (Vector3::zeros(), Vector3::zeros());
            }
            let next = state.at(&body, 0.37);
            let passage = state.passage(&body, &next);
            let gained = body.kinetic_energy(&next) - body.kinetic_energy(&state);
            assert!((gained - passage.work - passage.defect).abs() < 1e-13);
            assert!((body.momentum(&next) - body.momentum(&state) - passage.momentum).norm() < 1e-13);
            let turned = body.total_angular_momentum(&next) - body.total_angular_momentum(&state);
            assert!((turned - passage.angular_momentum).norm() < 1e-13);
        }
    }

    #[test]
    fn slicing_a_flight_gives_the_same_translation() {
        let (body, mut state) = rod(BodyMotion::Free);
        state.wrench = wrench();
        let (whole, halves) = (state.at(&body, 0.4), state.at(&body, 0.2).at(&body, 0.4));
        assert!((whole.position - halves.position).norm() < 1e-15);
        assert!((whole.velocity - halves.velocity).norm() < 1e-15);
        assert!((whole.angular_momentum - halves.angular_momentum).norm() < 1e-15);
    }

    #[test]
    fn a_tumbling_rod_turns_with_second_order_and_keeps_its_angular_momentum() {
        let flown = |steps: u32| {
            let (body, mut state) = rod(BodyMotion::Free);
            for i in 1..=steps {
                state = state.at(&body, 2.0 * f64::from(i) / f64::from(steps));
            }
            state
        };
        let exact = flown(20_000);
        let error = |steps| flown(steps).orientation.angle_to(&exact.orientation);
        let order = (error(100) / error(200)).log2();
        assert!((order - 2.0).abs() < 0.1, "order {order}");
        assert_eq!(flown(100).angular_momentum, rod(BodyMotion::Free).1.angular_momentum);
    }

    #[test]
    fn a_sphere_turns_at_a_constant_rate() {
        let (rod, mut state) = rod(BodyMotion::Free);
        let body = RigidBody::new(rod.shape, BodyMotion::Free, rod.freedom, rod.mass, Tensor3::identity() * 0.5);
        state.angular_momentum = Vector3::new(0.0, 0.0, 0.5);
        let turned = state.at(&body, std::f64::consts::FRAC_PI_2);
        assert!((turned.orientation.transform_vector(&Vector3::x()) - Vector3::y()).norm() < 1e-15);
        assert!(!body.needs_orientation_steps(&state));
    }
}
