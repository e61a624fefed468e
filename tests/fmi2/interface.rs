//! Parameters of the gel, and scenes with inputs that an FMU lacks.

use super::host::{ERROR, Host, OK, coarse};
use ballistic_gel::fmi2::abi::fmi2ExitInitializationMode;
use ballistic_gel::scene;

/// Message of a refused initialization.
fn refusal(mut host: Host) -> String {
    host.enter();
    // SAFETY: a live component.
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, ERROR);
    host.one_line()
}

#[test]
fn another_scene_with_an_input_that_is_missing_is_refused_with_the_way_to_get_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.toml");
    let fragment = "\n[[fragment]]\nshape.sphere.radius = 0.012\nmass = 1e-3\nposition = [0.03, 0.0, 0.02]\n";
    std::fs::write(&path, coarse() + fragment).unwrap();
    let mut host = Host::with(&coarse());
    assert_eq!(host.set_text("scene", &path), OK);
    let line = refusal(host);
    let expected =
        format!("it needs the input fragment[1].position[1], which this FMU lacks; gelfmu pack '{}'", path.display());
    assert!(line.contains(&expected), "{line}");
    let mut host = Host::with(&(coarse() + fragment));
    std::fs::write(&path, coarse()).unwrap();
    assert_eq!(host.set_text("scene", &path), OK);
    host.start();
}

#[test]
fn an_axisymmetric_fmu_takes_no_spatial_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.toml");
    std::fs::write(&path, coarse()).unwrap();
    let mut host = Host::with(scene::builtin("fbi-bb").unwrap());
    assert_eq!(host.set_text("scene", &path), OK);
    assert!(refusal(host).contains("it needs the input projectile.position[1]"));
}

#[test]
fn strength_preset_and_friction_override_the_scene() {
    let velocity = |set: &dyn Fn(&mut Host)| {
        let mut host = Host::with(scene::builtin("fbi-bb").unwrap());
        set(&mut host);
        host.start();
        host.steps(0.0, 1e-5, 10);
        host.get("projectile.predicted_velocity[3]")
    };
    let plain = velocity(&|_| ());
    let weaker = velocity(&|host| assert_eq!(host.set("gel.strength_scale", 0.5), OK));
    let rough = velocity(&|host| assert_eq!(host.set("contact.friction", 0.5), OK));
    let stronger = velocity(&|host| assert_eq!(host.set_integer("gel.preset", 2), OK));
    assert!(weaker < plain && plain < rough && plain < stronger, "{weaker} {plain} {rough} {stronger}");
}

#[test]
fn every_choice_of_a_preset_starts_and_the_size_of_the_elements_is_a_parameter() {
    let elements = |name: &str, value: f64| {
        let mut host = Host::with(scene::builtin("fbi-bb").unwrap());
        let status = if name == "gel.preset" { host.set_integer(name, value as i32) } else { host.set(name, value) };
        assert_eq!(status, OK, "{name} = {value}");
        host.start();
        host.integer("cost.elements")
    };
    let [first, second, third] = [1.0, 2.0, 3.0].map(|preset| elements("gel.preset", preset));
    assert!(first == second && second == third);
    assert!(elements("mesh.size", 2e-3) < first);
}

#[test]
fn a_sensor_of_another_scene_needs_no_input() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.toml");
    std::fs::write(&path, coarse() + "\n[[sensor]]\nposition = [0.0, 0.0, -0.01]\n").unwrap();
    let mut host = Host::with(&coarse());
    assert_eq!(host.set_text("scene", &path), OK);
    host.start();
}
