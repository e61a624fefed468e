//! Coulomb's friction between gel and projectile.

use ballistic_gel::math::Vector3;
use ballistic_gel::scene::{self, Override};
use ballistic_gel::simulation::{CouplingMode, Observation, Simulation};

fn run(name: &str, changes: &[&str], end: f64) -> Observation {
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
    let scene = scene::read(&scene::resolve(scene::builtin(name).unwrap(), &changes).unwrap()).unwrap();
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
    let inputs = simulation.inputs();
    simulation.step(&inputs, end).unwrap();
    simulation.observe()
}

fn closes(seen: &Observation) {
    let errors = (seen.energy.energy_error, seen.momentum_error, seen.angular_momentum_error);
    assert!(errors.0 < 1e-10 && errors.1 < 1e-12 && errors.2 < 1e-12, "{errors:?}");
}

/// An L-beam thrown along a wall slides all the time: what it gives along is μ of what it gives across, but for the
/// square of the slope at which its corner widens sideways, (0.03/40)²/2.
#[test]
fn a_sliding_contact_takes_mu_of_the_normal_impulse() {
    let seen = run("l-beam", &["mesh.size=25e-3", "gel.velocity=[40.0, 0.0, -0.7]", "contact.friction=0.1"], 0.06);
    let total = seen.projectile().contact.total_impulse;
    assert!(total.z < 0.0 && (total.x / total.z.abs() / 0.1 - 1.0).abs() < 1e-5, "{total}");
    assert!(seen.energy.friction < 0.0);
    closes(&seen);
}

#[test]
fn friction_stops_a_slow_beam_and_never_drives_it() {
    let along = |friction: &str| {
        let seen = run("l-beam", &["mesh.size=25e-3", "gel.velocity=[0.05, 0.0, -0.7]", friction], 0.06);
        closes(&seen);
        (seen.projectile().contact.total_impulse.x, seen.energy.friction)
    };
    let (none, no_work) = along("contact.friction=0");
    let (some, work) = along("contact.friction=0.5");
    assert!(none.abs() < 1e-9 && no_work == 0.0);
    assert!(some > 0.0 && work < 0.0);
}

/// A ball that spins about x as it strikes is turned back and driven along y, by equal and opposite impulses.
#[test]
fn a_spinning_ball_is_braked_and_driven_sideways() {
    let keys = ["mesh.size=0.01", "projectile.angular_velocity=[500.0, 0.0, 0.0]", "contact.friction=0.3"];
    let seen = run("sphere-block", &keys, 8e-3);
    closes(&seen);
    assert!(
        seen.projectile().kinematics.angular_velocity.x < 499.0,
        "{}",
        seen.projectile().kinematics.angular_velocity
    );
    // The lowest point of the ball moves along +y with that spin: friction drives the ball along −y.
    assert!(seen.projectile().kinematics.velocity.y < -1e-3, "{}", seen.projectile().kinematics.velocity);
    assert!(seen.energy.friction < 0.0);
    let impulse: Vector3 = seen.projectile().contact.total_impulse;
    assert!(impulse.y.abs() <= 0.3 * impulse.z);
}

#[test]
fn without_friction_the_ball_keeps_its_spin() {
    let seen = run("sphere-block", &["mesh.size=0.01", "projectile.angular_velocity=[500.0, 0.0, 0.0]"], 8e-3);
    assert!((seen.projectile().kinematics.angular_velocity - Vector3::new(500.0, 0.0, 0.0)).norm() < 1e-9);
}
