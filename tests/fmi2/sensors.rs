//! Sensors as variables: their values, rates and states, and those that the scene does not have.

use super::coupling::rate;
use super::host::{ERROR, Host, coarse, reference};
use ballistic_gel::fmi2::abi::fmi2GetReal;
use ballistic_gel::scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};

const SENSORS: &str = "\n[[sensor]]\nposition = [0.0, 0.0, 0.0]\n[[sensor]]\nposition = [0.003, 0.001, -0.012]\n";

fn values(host: &mut Host, sensor: usize) -> [f64; 7] {
    let of = |name: &str| format!("sensor[{sensor}].{name}");
    let pressure = host.get(&of("pressure"));
    let [ux, uy, uz] = [1, 2, 3].map(|i| host.get(&of(&format!("displacement[{i}]"))));
    let [vx, vy, vz] = [1, 2, 3].map(|i| host.get(&of(&format!("velocity[{i}]"))));
    [pressure, ux, uy, uz, vx, vy, vz]
}

#[test]
fn sensors_give_what_the_library_gives_and_a_displacement_changes_with_its_velocity() {
    let text = coarse() + SENSORS;
    let mut host = Host::with(&text);
    host.start();
    host.steps(0.0, 1e-4, 20);
    let scene = scene::read(&text).unwrap();
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
    for k in 1..=20 {
        let inputs = simulation.inputs();
        simulation.step(&inputs, f64::from(k) * 1e-4).unwrap();
    }
    for (i, sensor) in simulation.sensors().iter().enumerate() {
        let (u, v) = (sensor.displacement, sensor.velocity);
        let found = values(&mut host, i + 1);
        for (found, expected) in found.into_iter().zip([sensor.pressure, u.x, u.y, u.z, v.x, v.y, v.z]) {
            assert!((found - expected).abs() <= 1e-9 * expected.abs(), "sensor {i}: {found} {expected}");
        }
        assert_eq!(rate(&host, &format!("sensor[{}].displacement[3]", i + 1)), found[6]);
        assert_eq!(rate(&host, &format!("sensor[{}].pressure", i + 1)), 0.0);
    }
    assert!(host.get("sensor[2].pressure") != 0.0);
}

#[test]
fn a_state_that_is_restored_has_its_sensors() {
    let mut host = Host::with(&(coarse() + SENSORS));
    host.start();
    host.steps(0.0, 1e-4, 12);
    let (bytes, before) = (host.bytes(), values(&mut host, 2));
    host.steps(12e-4, 1e-4, 5);
    assert_ne!(values(&mut host, 2), before);
    host.restore(&bytes);
    assert_eq!(values(&mut host, 2), before);
}

#[test]
fn a_sensor_that_the_scene_does_not_have_is_refused() {
    let mut host = Host::with(&(coarse() + SENSORS));
    host.start();
    let mut value = 0.0;
    // SAFETY: one reference and one value.
    let status = unsafe { fmi2GetReal(host.c, &reference("sensor[3].pressure"), 1, &raw mut value) };
    assert_eq!(status, ERROR);
    let said = host.one_line();
    assert!(said.contains("sensor[3].pressure: there is no such sensor") && said.contains("scene: 2"), "{said}");
}
