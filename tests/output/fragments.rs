//! The dent of the stage with two fragments beside the ball: a bulging back face, and a splinter that waits.

use super::stage;
use ballistic_gel::math::{Vector, Vector3};
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{
    BodyKinematics, BodyPose, BodyReport, ContactReport, DomeMotion, ImpulseExchange, MeshFrame, Observation,
    ShapeMotion,
};
use std::f64::consts::FRAC_1_SQRT_2;

/// The scene of the stage with a dome, and a splinter of half the ball's radius.
pub fn scene() -> Scene {
    let mut scene = stage::scene("spatial");
    let mut dome = scene.projectile.clone();
    dome.shape =
        toml::from_str::<toml::Table>("dome = { height = 0.006, radius = 0.016 }").unwrap().try_into().unwrap();
    (dome.fixed, dome.mass, dome.position) = (true, None, [0.0; 3]);
    let mut splinter = scene.projectile.clone();
    splinter.shape = toml::from_str::<toml::Table>("sphere = { radius = 0.005 }").unwrap().try_into().unwrap();
    (splinter.active, splinter.position) = (false, [0.03, 0.0, 0.02]);
    scene.fragment = vec![dome, splinter];
    scene
}

fn bulge(time: f64) -> ShapeMotion {
    let size = Vector::<2>::new(0.006 + 0.4 * time, 0.016 + 0.2 * time);
    ShapeMotion::Bulge(DomeMotion { size, rate: Vector::<2>::new(0.4, 0.2), acceleration: Vector::<2>::zeros() })
}

fn at_rest(position: [f64; 3]) -> BodyKinematics {
    let [velocity, angular_velocity] = [Vector3::zeros(); 2];
    BodyKinematics { position: position.into(), velocity, orientation: [1.0, 0.0, 0.0, 0.0], angular_velocity }
}

fn dome(time: f64) -> BodyReport {
    let exchange = ImpulseExchange {
        duration: 2e-4,
        impulse: Vector3::new(1e-4, 2e-4, 3e-4),
        shape_impulse: Vector::<2>::new(-4e-4, -5e-4),
        ..ImpulseExchange::default()
    };
    let contact = ContactReport {
        total_impulse: Vector3::new(0.03, 0.0, 0.04),
        peak_force: 12.5,
        peak_depth: (0.0125, 0.008),
        ..ContactReport::default()
    };
    let shape_motion = Some(bulge(time));
    let (kinematics, depth) = (at_rest([0.0; 3]), 0.006 + 0.4 * time);
    BodyReport { kinematics, active: true, shape_motion, depth, exchange, contact, exit: None, energy_deposited: 0.0 }
}

fn splinter() -> BodyReport {
    let kinematics = BodyKinematics {
        velocity: Vector3::new(3.0, 0.0, -4.0),
        orientation: [FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2, 0.0],
        angular_velocity: Vector3::new(7.0, 8.0, 9.0),
        ..at_rest([0.03, 0.0, 0.02])
    };
    let (exchange, contact) = (ImpulseExchange::default(), ContactReport::default());
    let (shape_motion, exit, depth) = (None, None, -0.015);
    BodyReport { kinematics, active: false, shape_motion, depth, exchange, contact, exit, energy_deposited: 0.0 }
}

/// What an observer sees at `time`, s.
pub fn observation(scene: &Scene, time: f64) -> Observation {
    let mut observation = stage::observation(scene, time);
    observation.bodies.extend([dome(time), splinter()]);
    observation
}

/// The dented mesh at `time`, s; the dome is drawn, the splinter only if it is `there`.
pub fn frame(scene: &Scene, time: f64, there: bool) -> MeshFrame {
    let mut frame = stage::frame(scene, time);
    let place =
        |body: &BodyReport, active| BodyPose { kinematics: body.kinematics, shape_motion: body.shape_motion, active };
    frame.bodies.extend([place(&dome(time), true), place(&splinter(), there)]);
    frame
}
