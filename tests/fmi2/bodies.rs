//! Fragments beside the projectile: their own ports, their flags, and domes.

use super::host::{ERROR, Host, OK, coarse, reference};
use ballistic_gel::fmi2::abi::*;
use std::ffi::c_int;

pub const BALL: &str =
    "\n[[fragment]]\nshape.sphere.radius = 0.01\nmass = 0.02\nposition = [0.03, 0.0, 0.011]\nvelocity = [0, 0, -4]\n";
pub const DOME: &str =
    "\n[[fragment]]\nshape.dome = { height = 0.0, radius = 0.02 }\nfixed = true\nposition = [0.0, 0.0, 0.0]\n";

fn two(fragment: &str) -> Host {
    Host::with(&(coarse() + fragment))
}

pub fn set_flag(host: &Host, name: &str, value: bool) {
    let (vr, value) = (reference(name), c_int::from(value));
    // SAFETY: one reference and one value.
    assert_eq!(unsafe { fmi2SetBoolean(host.c, &raw const vr, 1, &raw const value) }, OK);
}

fn flag(host: &Host, name: &str) -> bool {
    let (vr, mut value) = (reference(name), -1);
    // SAFETY: one reference and one value.
    assert_eq!(unsafe { fmi2GetBoolean(host.c, &raw const vr, 1, &raw mut value) }, OK);
    value != 0
}

pub fn step(host: &Host, from: f64) -> c_int {
    // SAFETY: a live component.
    unsafe { fmi2DoStep(host.c, from, 1e-4, 0) }
}

#[test]
fn a_fragment_has_parameters_inputs_and_outputs_of_its_own() {
    let mut host = two(BALL);
    assert_eq!(host.set("fragment[1].mass", 0.01), OK);
    assert_eq!(host.set("fragment[1].initial_velocity[3]", -3.0), OK);
    host.start();
    assert_eq!(host.get("fragment[1].effective_mass"), 0.01);
    assert_eq!(host.get("fragment[1].predicted_velocity[3]"), -3.0);
    assert_eq!(host.get("projectile.effective_mass"), 0.033);
    assert_eq!(host.set("fragment[1].external_force[1]", 2.0), OK);
    host.steps(0.0, 1e-4, 10);
    let momentum = |host: &mut Host, axis: u8| {
        let body = |host: &mut Host, name: &str, mass: f64, was: f64| {
            mass * (host.get(&format!("{name}.predicted_velocity[{axis}]")) - was)
        };
        (body(host, "projectile", 0.033, -5.0), body(host, "fragment[1]", 0.01, -3.0))
    };
    let (ball, fragment) = momentum(&mut host, 3);
    assert!((ball - host.get("contact.total_impulse[3]")).abs() < 1e-15);
    assert!((fragment - host.get("fragment[1].contact.total_impulse[3]")).abs() < 1e-15 && fragment > 1e-3);
    assert!((host.get("fragment[1].predicted_velocity[1]") - 0.2).abs() < 0.05, "the force acts on it alone");
    assert!(host.get("projectile.predicted_velocity[1]").abs() < 1e-3);
}

#[test]
fn a_fragment_is_made_active_where_its_inputs_put_it() {
    let mut host = two(&(BALL.to_owned() + "active = false\n"));
    host.start();
    assert!(!flag(&host, "fragment[1].active"));
    host.steps(0.0, 1e-4, 2);
    assert_eq!(host.get("fragment[1].predicted_position[3]"), 0.011);
    for (name, value) in [("position[3]", 0.02), ("velocity[3]", -7.0)] {
        assert_eq!(host.set(&format!("fragment[1].{name}"), value), OK);
    }
    set_flag(&host, "fragment[1].active", true);
    host.steps(2e-4, 1e-4, 1);
    assert!((host.get("fragment[1].predicted_position[3]") - 0.0193).abs() < 1e-15);
    // From then on the inputs are not read: the fragment flies by itself.
    host.steps(3e-4, 1e-4, 1);
    assert!((host.get("fragment[1].predicted_position[3]") - 0.0186).abs() < 1e-15);
    set_flag(&host, "fragment[1].active", false);
    host.steps(4e-4, 1e-4, 1);
    assert_eq!(host.set("fragment[1].position[3]", 0.005), OK);
    set_flag(&host, "fragment[1].active", true);
    assert_eq!(step(&host, 5e-4), ERROR);
    let said = host.one_line();
    assert!(said.contains("fragment[1].active = true: expected a place outside the gel"), "{said}");
    set_flag(&host, "fragment[1].active", false);
    assert_eq!(step(&host, 5e-4), OK, "a refused step changes nothing");
}

#[test]
fn the_bulge_of_a_dome_follows_its_inputs_in_every_mode() {
    for mode in 1..=3 {
        let mut host = two(DOME);
        assert_eq!(host.set_integer("coupling.mode", mode), OK);
        assert_eq!(host.set("projectile.initial_position[3]", 0.05), OK);
        host.start();
        let mut impulse = 0.0;
        for k in 0..10 {
            let t = f64::from(k) * 1e-4;
            assert_eq!(host.set("fragment[1].bulge_height", 4.0 * t), OK);
            assert_eq!(host.set("fragment[1].bulge_height_rate", 4.0), OK);
            host.steps(t, 1e-4, 1);
            impulse += host.get("fragment[1].contact.bulge_height_impulse");
        }
        assert!((host.get("fragment[1].depth") - 4e-3).abs() < 1e-12);
        let work = host.get("energy.external");
        if mode == 2 {
            assert!(work > 0.0 && (work + 4.0 * impulse).abs() < 1e-12 * work, "{work} {impulse}");
        }
        assert!(impulse < 0.0 && host.get("fragment[1].contact.total_impulse[3]") > 0.0);
    }
}

#[test]
fn an_invalid_bulge_input_is_refused_by_name() {
    let mut host = two(DOME);
    host.start();
    assert_eq!(host.set("fragment[1].bulge_height_rate", 250.0), OK);
    assert_eq!(step(&host, 0.0), ERROR);
    let expected =
        "fragment[1].bulge_height = 0.025 m, with a base radius of 0.02 m at the end of the step: expected a height";
    let said = host.one_line();
    assert!(said.contains(expected), "{said}");
    assert_eq!(host.set("fragment[1].bulge_height_rate", 0.0), OK);
    assert_eq!(host.set("projectile.bulge_height", 0.01), OK);
    assert_eq!(step(&host, 0.0), ERROR);
    let said = host.one_line();
    assert!(said.contains("projectile.bulge_height = 0.01: expected 0: the shape of the body is no dome"), "{said}");
    assert_eq!(host.set("projectile.bulge_height", 0.0), OK);
    assert_eq!(step(&host, 0.0), OK);
}

#[test]
fn a_fragment_that_is_not_in_the_scene_is_named() {
    let mut host = two(BALL);
    host.start();
    let (vr, mut value) = (reference("fragment[2].depth"), 0.0);
    // SAFETY: one reference and one value.
    assert_eq!(unsafe { fmi2GetReal(host.c, &raw const vr, 1, &raw mut value) }, ERROR);
    let said = host.one_line();
    assert!(
        said.contains("fragment[2].depth: there is no such fragment; [[fragment]] tables in the scene: 1"),
        "{said}"
    );
    assert_eq!(host.set("fragment[2].external_force[1]", 1.0), OK);
    assert_eq!(step(&host, 0.0), ERROR);
    let said = host.one_line();
    assert!(said.contains("fragment[2].external_force[1]"), "{said}");
}

#[test]
fn a_state_with_fragments_goes_on_in_another_instance() {
    let mut host = two(BALL);
    host.start();
    host.steps(0.0, 1e-4, 5);
    set_flag(&host, "projectile.active", false);
    host.steps(5e-4, 1e-4, 2);
    let bytes = host.bytes();
    let mut other = Host::with("this is no scene");
    assert_eq!(other.restore(&bytes), OK, "{:?}", other.lines());
    for it in [&mut host, &mut other] {
        it.steps(7e-4, 1e-4, 3);
        assert!(!flag(it, "projectile.active"));
    }
    assert_eq!(other.bytes(), host.bytes());
}
