//! Free flight of a rigid body through air: straight, without drag and gravity, turning by Euler's equations.

use ballistic_gel::contact::BodyState;
use ballistic_gel::math::Vector3;
use ballistic_gel::output::ExitedBody;
use nalgebra::UnitQuaternion;

/// Greatest difference of the attitude from that with half the step, rad. The midpoint rule is of second order, so that
/// the error is a third of it.
const TURN_TOLERANCE: f64 = 1e-5;
/// Rotation in a step of the first trial, rad.
const FIRST_TURN: f64 = 0.05;
/// Most steps of a flight.
const MOST_STEPS: f64 = 1e7;
/// Distance to a plane at which a body touches it, m.
const TOUCHING: f64 = 1e-9;
/// Most advances of a body towards a plane: 1100 bring one to it that descends at 2 % of the greatest speed of its surface.
const MOST_ADVANCES: usize = 10_000;

/// Returns the state of a body in free flight at a time, s; the attitude in steps so short that halving them changes it by
/// less than [`TURN_TOLERANCE`].
pub fn state_in_flight(body: &ExitedBody, time: f64) -> BodyState {
    let ExitedBody { rigid, state: start } = body;
    let end = start.at(rigid, time);
    if !rigid.needs_orientation_steps(start) {
        return end;
    }
    let duration = time - start.time;
    let turned = |steps: f64| {
        let times = (1..=steps as u32).map(|step| start.time + duration * f64::from(step) / steps);
        times.fold(*start, |at, time| at.at(rigid, time)).orientation
    };
    let mut steps = (spin_bound(body) * duration.abs() / FIRST_TURN).ceil().clamp(1.0, MOST_STEPS);
    let mut orientation = turned(steps);
    while steps < MOST_STEPS {
        steps *= 2.0;
        let finer = turned(steps);
        let change = finer.angle_to(&orientation);
        orientation = finer;
        if change < TURN_TOLERANCE {
            break;
        }
    }
    BodyState { orientation, ..end }
}

/// Returns the time at which the lowest point of a body in free flight meets a horizontal plane, s, or the time of its state
/// if it is there already; `None` for a body that does not fly down to it.
///
/// Conservative advancement (Mirtich 1996): no point of the body descends faster than its centre and the rim of its
/// bounding sphere together.
pub fn arrival_time(body: &ExitedBody, plane: f64) -> Option<f64> {
    let ExitedBody { rigid, state: start } = body;
    if start.velocity.z >= 0.0 {
        return None;
    }
    let fastest = spin_bound(body) * bounding_radius(body) - start.velocity.z;
    let mut now = body.clone();
    for _ in 0..MOST_ADVANCES {
        let way = -rigid.depth(&now.state) - plane;
        if way <= TOUCHING {
            return Some(now.state.time);
        }
        now.state = state_in_flight(&now, now.state.time + way / fastest);
    }
    None
}

/// Returns an upper bound of the angular velocity, rad/s.
fn spin_bound(body: &ExitedBody) -> f64 {
    body.state.angular_momentum.norm() * body.rigid.greatest_inverse_inertia()
}

/// Returns the radius of a sphere about the centre of mass that holds the body, m: the diagonal of its bounding box.
fn bounding_radius(body: &ExitedBody) -> f64 {
    let upright = BodyState { orientation: UnitQuaternion::identity(), ..body.state };
    let reach = |axis: Vector3| body.rigid.reach(&upright, &axis).max(body.rigid.reach(&upright, &-axis));
    Vector3::from([Vector3::x(), Vector3::y(), Vector3::z()].map(reach)).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballistic_gel::contact::FreeDirections;
    use ballistic_gel::scene;
    use ballistic_gel::simulation::free_body;

    /// Bullet of the built-in scene with this angular velocity, rad/s, 10 mm above the plane z = 0 of the scene.
    fn bullet(spin: Vector3) -> ExitedBody {
        let scene = scene::read(scene::builtin("bullet-yaw").unwrap()).unwrap();
        let (mut rigid, state) = free_body(&scene, 0);
        rigid.freedom = FreeDirections::SPATIAL;
        let mut state = BodyState { velocity: Vector3::new(3.0, -2.0, -200.0), ..state };
        state.position.z = 0.03;
        state.angular_momentum = rigid.angular_momentum(&state, &spin);
        ExitedBody { rigid, state }
    }

    #[test]
    fn a_spinning_bullet_turns_by_a_tenth_of_a_degree_at_most_beside_the_motion_of_a_symmetric_top() {
        let body = bullet(Vector3::new(900.0, -500.0, 12e3));
        let ExitedBody { rigid, state } = &body;
        let time = 0.015;
        // R(t) = exp(t L/I₁) R₀ exp(t ω₃ (1 − I₃/I₁) e₃) of a body with I₁ = I₂.
        let (across, along) = (rigid.inertia[(0, 0)], rigid.inertia[(2, 2)]);
        let spin = state.orientation.inverse_transform_vector(&rigid.angular_velocity(state));
        let precession = UnitQuaternion::from_scaled_axis(state.angular_momentum * (time / across));
        let own = UnitQuaternion::from_scaled_axis(Vector3::z() * (time * spin.z * (1.0 - along / across)));
        let exact = precession * state.orientation * own;
        let flown = state_in_flight(&body, time);
        let error = flown.orientation.angle_to(&exact).to_degrees();
        assert!(error < 1e-3, "{error} degrees");
        assert_eq!(flown.angular_momentum, state.angular_momentum);
        assert!((rigid.kinetic_energy(&flown) / rigid.kinetic_energy(state) - 1.0).abs() < 1e-6);
        assert_eq!(flown.position, state.position + state.velocity * time);
    }

    #[test]
    fn a_body_arrives_at_a_plane_with_its_lowest_point() {
        for spin in [Vector3::zeros(), Vector3::new(5e3, -3e3, 100.0)] {
            let body = bullet(spin);
            let time = arrival_time(&body, -0.5).unwrap();
            let depth = body.rigid.depth(&state_in_flight(&body, time));
            assert!((depth - 0.5).abs() < 1e-6, "{depth} m with {spin}");
        }
        let mut rising = bullet(Vector3::zeros());
        rising.state.velocity.z = 1.0;
        assert_eq!(arrival_time(&rising, -0.5), None);
    }
}
