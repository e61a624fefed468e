//! The impulse between a node and a free body: restitution, momentum, angular momentum and energy, for offset hits on a
//! rod with I = ML²/12.

use super::noise::Noise;
use super::row::{Row, below};
use ballistic_gel::contact::{BodyMotion, BodyState, FreeDirections, RigidBody, impulse};
use ballistic_gel::geometry::{ShapeGeometry, Sphere};
use ballistic_gel::math::{Tensor3, Vector3};
use nalgebra::{UnitQuaternion, Vector4};
use std::sync::OnceLock;

/// A mass point before the hit, on the surface of the body.
struct Point {
    mass: f64,
    velocity: Vector3,
    position: Vector3,
    normal: Vector3,
}

/// Defects of one hit: restitution, momentum, angular momentum and energy, relative to what was there.
type Defects = Vector4<f64>;

/// A thin rod along its own z, its mass and length.
fn rod(noise: &mut Noise) -> (RigidBody, BodyState, f64) {
    let (mass, length, radius) = (noise.between(0.1, 10.0), noise.between(0.5, 2.0), 0.02);
    let across = mass * length * length / 12.0;
    let inertia = Tensor3::from_diagonal(&Vector3::new(across, across, 0.5 * mass * radius * radius));
    // The hits are given; nothing asks where its surface is.
    let shape = ShapeGeometry::Sphere(Sphere { radius });
    let body = RigidBody::new(shape, BodyMotion::Free, FreeDirections::SPATIAL, mass, inertia);
    let mut state = BodyState::at_start(vector(noise), vector(noise));
    state.orientation = UnitQuaternion::from_scaled_axis(vector(noise));
    state.angular_momentum = body.angular_momentum(&state, &vector(noise));
    (body, state, length)
}

fn vector(noise: &mut Noise) -> Vector3 {
    Vector3::from_fn(|_, _| noise.next())
}

/// A point on the mantle of the rod, off its middle, that approaches it.
fn point(noise: &mut Noise, (body, state, length): &(RigidBody, BodyState, f64)) -> Point {
    let along = Vector3::new(0.02, 0.0, 0.45 * length * noise.next());
    let position = state.position + state.orientation.transform_vector(&along);
    let normal =
        body.gap(state, &(position + state.orientation.transform_vector(&Vector3::new(1e-3, 0.0, 0.0)))).normal;
    let velocity = body.velocity_at(state, &position) + vector(noise) - normal * 2.0;
    Point { mass: noise.between(1e-3, 1.0), velocity, position, normal }
}

fn hit(noise: &mut Noise) -> Defects {
    let rod = rod(noise);
    let (node, e) = (point(noise, &rod), noise.between(0.0, 1.0));
    let (body, before, _) = rod;
    let compliance = 1.0 / node.mass + body.compliance(&before, &(node.position - before.position), &node.normal);
    let approach = node.normal.dot(&(node.velocity - body.velocity_at(&before, &node.position)));
    let j = impulse(approach, -e * approach, compliance);
    let mut after = before;
    body.strike(&mut after, &node.position, &(node.normal * -j));
    let rebound = node.velocity + node.normal * (j / node.mass);
    let momentum = |v: &Vector3, state: &BodyState| v * node.mass + body.momentum(state);
    let turning =
        |v: &Vector3, state: &BodyState| node.position.cross(v) * node.mass + body.total_angular_momentum(state);
    let kinetic = |v: &Vector3, state: &BodyState| 0.5 * node.mass * v.norm_squared() + body.kinetic_energy(state);
    let (v0, v1) = (&node.velocity, &rebound);
    let separation = node.normal.dot(&(rebound - body.velocity_at(&after, &node.position)));
    let lost = -(1.0 - e * e) / 2.0 * approach * approach / compliance;
    let scale = node.mass * v0.norm() + body.mass * before.velocity.norm();
    let turning_scale = node.mass * node.position.norm() * v0.norm()
        + before.position.norm() * body.mass * before.velocity.norm()
        + before.angular_momentum.norm();
    Defects::new(
        (separation + e * approach).abs() / approach.abs(),
        (momentum(v1, &after) - momentum(v0, &before)).norm() / scale,
        (turning(v1, &after) - turning(v0, &before)).norm() / turning_scale,
        (kinetic(v1, &after) - kinetic(v0, &before) - lost).abs() / kinetic(v0, &before),
    )
}

/// The rows of this part, computed once.
pub fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let mut noise = Noise::new(8);
        let hits: Vec<Defects> = (0..1000).map(|_| hit(&mut noise)).collect();
        let worst = hits.iter().fold(Defects::zeros(), |worst, hit| worst.sup(hit));
        let row = |what: &str, i: usize, limit: f64| {
            let expected = format!("0 within {limit:.0e}");
            Row::new(("V8", what), &expected, below(worst[i]), worst[i] < limit)
        };
        vec![
            row("1000 offset hits on a free rod, any e: |u⁺ + e u⁻|/|u⁻|", 0, 1e-14),
            row("same: change of momentum, relative", 1, 1e-15),
            row("same: change of angular momentum, relative", 2, 1e-15),
            row("same: change of energy against −(1 − e²)/2 u²/K, relative", 3, 1e-14),
        ]
    })
}

#[test]
fn a_hit_obeys_restitution_and_conserves_momenta() {
    Row::check(rows());
}
