//! Parameters of the gel, and scenes with ports that an FMU lacks.

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
fn another_scene_with_a_port_that_is_missing_is_refused_with_the_way_to_get_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.toml");
    let fragment = "\n[[fragment]]\nshape.sphere.radius = 0.012\nmass = 1e-3\nposition = [0.03, 0.0, 0.02]\n";
    std::fs::write(&path, coarse() + fragment).unwrap();
    let mut host = Host::with(&coarse());
    assert_eq!(host.set_text("scene", &path), OK);
    let line = refusal(host);
    let expected = format!("it needs the port fragment[1].position[1], which this FMU lacks; gelfmu pack {path:?}");
    assert!(line.contains(&expected), "{line}");
    let mut host = Host::with(&(coarse() + fragment));
    std::fs::write(&path, coarse()).unwrap();
    assert_eq!(host.set_text("scene", &path), OK);
    host.start();
}

#[test]
fn a_planar_fmu_takes_no_spatial_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.toml");
    std::fs::write(&path, coarse()).unwrap();
    let mut host = Host::with(scene::builtin("fbi-bb").unwrap());
    assert_eq!(host.set_text("scene", &path), OK);
    assert!(refusal(host).contains("it needs the port projectile.position[1]"));
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
