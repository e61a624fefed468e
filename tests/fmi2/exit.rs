//! The exit of a projectile at the back of the gel: its variables, and a gel at rest.

use super::host::{ERROR, Host, OK, WARNING, coarse, reference};
use ballistic_gel::fmi2::abi::*;
use ballistic_gel::scene::{self, Override};

/// The ball of the calibration shot through 12 mm of its gel, on coarse cells.
fn thin() -> Host {
    Host::with(&thin_scene())
}

fn thin_scene() -> String {
    let changes = [
        "scene.end_time=1e-3",
        "scene.stop_after_exit=5e-5",
        "scene.await_cavity=false",
        "gel.shape.cylinder={radius=0.03,height=0.012}",
        "gel.supports.z_min=free",
        "mesh.size=7e-4",
        "remesh.smallest=3.5e-4",
    ];
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
    scene::resolve(scene::builtin("fbi-bb").unwrap(), &changes).unwrap()
}

fn boolean(host: &Host, name: &str) -> bool {
    let mut value = 7;
    // SAFETY: one reference and one value.
    assert_eq!(unsafe { fmi2GetBoolean(host.c, &reference(name), 1, &raw mut value) }, OK);
    value != 0
}

#[test]
fn a_projectile_that_perforates_the_gel_says_so_and_flies_on_at_no_cost() {
    let mut host = thin();
    host.start();
    let told = |host: &mut Host| {
        ["exit_velocity[3]", "exit_time", "residual_energy"].map(|name| host.get(&format!("projectile.{name}")))
    };
    assert!(!boolean(&host, "projectile.perforated") && !boolean(&host, "scene.is_over"));
    assert_eq!(told(&mut host), [0.0; 3]);
    host.steps(0.0, 1e-4, 4);
    assert!(boolean(&host, "projectile.perforated") && boolean(&host, "scene.is_over"));
    let [velocity, time, residual] = told(&mut host);
    assert!(velocity < -60.0 && time > 9e-5 && time < 2e-4, "{velocity} m/s at {time} s");
    assert!((residual / (0.5 * 0.343e-3 * velocity * velocity) - 1.0).abs() < 1e-12);
    let given = host.get("projectile.energy_deposited");
    assert!(((given + residual) / (0.5 * 0.343e-3 * 179.8 * 179.8) - 1.0).abs() < 1e-10, "{given} J");
    let (updates, depth) = (host.get("cost.element_updates"), host.get("projectile.depth"));
    host.steps(4e-4, 1e-3, 9);
    assert_eq!(host.get("cost.element_updates"), updates);
    // Depths are those in the block, which flies on as well.
    let flown = -9e-3 * (host.get("projectile.predicted_velocity[3]") - host.get("block.velocity[3]"));
    assert!((host.get("projectile.depth") - depth - flown).abs() < 1e-9);
}

#[test]
fn a_step_that_brings_a_body_back_to_a_gel_at_rest_is_refused_and_another_is_taken() {
    let mut host = thin();
    host.start();
    host.steps(0.0, 1e-4, 4);
    let before = host.digest();
    assert_eq!(host.set("projectile.external_force[3]", 1e3), OK);
    // SAFETY: a live component.
    assert_eq!(unsafe { fmi2DoStep(host.c, 4e-4, 1e-3, 0) }, ERROR);
    let line = host.one_line();
    assert!(line.starts_with("projectile.position = ") && line.contains("scene.stop_after_exit"), "{line}");
    assert_eq!(host.digest(), before, "a refused step changes nothing");
    assert_eq!(host.set("projectile.external_force[3]", 0.0), OK);
    host.steps(4e-4, 1e-3, 1);
}

#[test]
fn a_corrected_body_that_is_put_back_to_a_gel_at_rest_is_refused() {
    let mut host = thin();
    assert_eq!(host.set_integer("coupling.mode", 3), OK);
    host.start();
    host.steps(0.0, 1e-4, 4);
    for (name, value) in [("position[3]", 0.01), ("velocity[3]", -10.0)] {
        assert_eq!(host.set(&format!("projectile.{name}"), value), OK);
    }
    // SAFETY: a live component.
    assert_eq!(unsafe { fmi2DoStep(host.c, 4e-4, 1e-3, 0) }, ERROR);
    assert!(host.one_line().contains("scene.stop_after_exit"));
}

#[test]
fn warnings_are_logged_when_initialization_ends_and_at_termination() {
    let mut host = Host::with(&coarse().replace("mass = 0.033", "mass = 33.0"));
    host.start();
    let (status, category, text) = host.lines().pop().unwrap();
    assert_eq!((status, category.as_str()), (WARNING, "logStatusWarning"));
    assert!(text.starts_with("projectile.mass gives a density of 7878"), "{text}");
    // A block on rollers that is perforated.
    let changes =
        ["gel.supports.z_min=roller", "scene.end_time=1e-3"].map(|change| change.parse::<Override>().unwrap());
    let mut host = Host::with(&scene::resolve(&thin_scene(), &changes).unwrap());
    host.start();
    assert_eq!(host.lines(), []);
    host.steps(0.0, 1e-4, 3);
    // SAFETY: a live component.
    assert_eq!(unsafe { fmi2Terminate(host.c) }, OK);
    let lines = host.lines();
    assert!(lines.iter().any(|(_, _, text)| text.contains("gel.supports.z_min = \"roller\"")), "{lines:?}");
}
