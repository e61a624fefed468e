//! Parameters, inputs, outputs and derivatives in their meaning.

use super::host::{ERROR, Host, OK, coarse, reference};
use ballistic_gel::fmi2::abi::*;
use ballistic_gel::scene;
use std::ffi::c_int;

pub fn directional(host: &Host, unknown: &str, known: &str) -> f64 {
    let (unknown, known, seed, mut value) = (reference(unknown), reference(known), 1.0, f64::NAN);
    let (unknown, known) = (&raw const unknown, &raw const known);
    let status = unsafe { fmi2GetDirectionalDerivative(host.c, unknown, 1, known, 1, &raw const seed, &raw mut value) };
    assert_eq!(status, OK);
    value
}

pub fn rate(host: &Host, name: &str) -> f64 {
    let (vr, order, mut value) = (reference(name), 1, f64::NAN);
    let (vr, order) = (&raw const vr, &raw const order);
    assert_eq!(unsafe { fmi2GetRealOutputDerivatives(host.c, vr, 1, order, &raw mut value) }, OK);
    value
}

pub fn set_rate(host: &Host, name: &str, value: f64) {
    let (vr, order): (u32, c_int) = (reference(name), 1);
    let at = (&raw const vr, &raw const order, &raw const value);
    assert_eq!(unsafe { fmi2SetRealInputDerivatives(host.c, at.0, 1, at.1, at.2) }, OK);
}

#[test]
fn two_interleaved_instances_do_not_meet() {
    let mut alone = Host::started();
    alone.steps(0.0, 1e-4, 6);
    let (mut one, mut two) = (Host::started(), Host::with(&coarse().replace("-5.0]", "-3.0]")));
    two.start();
    for k in 0..6 {
        one.steps(f64::from(k) * 1e-4, 1e-4, 1);
        two.steps(f64::from(k) * 1e-4, 1e-4, 1);
    }
    assert_eq!(one.bytes(), alone.bytes());
    assert_ne!(two.digest(), alone.digest());
}

#[test]
fn a_reset_instance_runs_like_a_fresh_one() {
    let mut host = Host::with(&coarse());
    assert_eq!(host.set("gel.shear_modulus", 3e4), OK);
    host.start();
    host.steps(0.0, 1e-4, 3);
    assert_eq!(unsafe { fmi2Reset(host.c) }, OK);
    host.start();
    host.steps(0.0, 1e-4, 3);
    let mut fresh = Host::started();
    fresh.steps(0.0, 1e-4, 3);
    assert_eq!(host.bytes(), fresh.bytes());
}

#[test]
fn outputs_can_be_read_in_initialization_mode_and_follow_the_parameters() {
    let mut host = Host::with(&coarse());
    host.enter();
    assert_eq!(host.get("projectile.predicted_velocity[3]"), -5.0);
    assert_eq!(host.set("projectile.initial_velocity[3]", -4.0), OK);
    assert_eq!(host.get("projectile.predicted_velocity[3]"), -4.0);
    assert_eq!(host.get("projectile.velocity[3]"), -4.0, "an input that was not set starts with the scene");
    assert_eq!(host.get("projectile.effective_mass"), 0.033);
    let sphere = 0.4 * 0.033 * 0.01 * 0.01;
    assert!((host.get("projectile.effective_inertia[2]") / sphere - 1.0).abs() < 1e-12);
}

#[test]
fn an_override_equal_to_its_start_leaves_another_scene_alone() {
    let mut host = Host::with(&coarse());
    let other = host.path("other.toml");
    std::fs::write(&other, coarse().replace("density = 1030.0", "density = 900.0")).unwrap();
    assert_eq!(host.set_text("scene", &other), OK);
    assert_eq!(host.set("gel.density", 1030.0), OK);
    assert_eq!(host.set("projectile.radius", 0.011), OK);
    assert_eq!(host.set("projectile.initial_position[3]", 0.011), OK);
    host.enter();
    assert_eq!(host.get("gel.density"), 900.0, "the first thing that is read");
    assert_eq!(host.get("projectile.radius"), 0.011);
    assert_eq!(host.get("projectile.position[3]"), 0.011);
}

#[test]
fn derivatives_are_those_of_the_last_step() {
    let mut host = Host::started();
    host.set("projectile.external_force[3]", -2.0);
    host.steps(0.0, 1e-4, 5);
    let force = host.get("contact.force[3]");
    assert!(force > 0.0);
    assert_eq!(rate(&host, "projectile.predicted_position[3]"), host.get("projectile.predicted_velocity[3]"));
    assert_eq!(rate(&host, "projectile.predicted_velocity[3]"), (force - 2.0) / 0.033);
    assert_eq!(rate(&host, "contact.total_impulse[3]"), force);
    assert_eq!(rate(&host, "projectile.depth"), 0.0);
}

#[test]
fn derivatives_come_from_what_acted_and_not_from_what_is_set_for_the_next_step() {
    let mut host = Host::started();
    host.set("projectile.external_force[3]", -2.0);
    set_rate(&host, "projectile.external_force[3]", 1e3);
    host.steps(0.0, 1e-4, 1);
    let acceleration = rate(&host, "projectile.predicted_velocity[3]");
    let expected = (host.get("contact.force[3]") - 2.0 + 1e3 * 1e-4) / 0.033;
    assert!((acceleration / expected - 1.0).abs() < 1e-12, "{acceleration}, expected {expected}");
    host.set("projectile.external_force[3]", 50.0);
    assert_eq!(rate(&host, "projectile.predicted_velocity[3]"), acceleration);
    let bytes = host.bytes();
    let mut other = Host::with(&coarse());
    assert_eq!(other.restore(&bytes), OK);
    assert_eq!(rate(&other, "projectile.predicted_velocity[3]"), acceleration);
}

/// The kinematic inputs, and what the coarse scene starts with.
const MOTION: [(&str, &[f64]); 4] = [
    ("position", &[0.0, 0.0, 0.010]),
    ("velocity", &[0.0, 0.0, -5.0]),
    ("orientation", &[1.0, 0.0, 0.0, 0.0]),
    ("angular_velocity", &[0.0, 0.0, 0.0]),
];

/// An instance in a coupling mode with these parts of the start given and the rest of the motion set to 0.
fn with_motion(mode: c_int, given: &[&str]) -> Host {
    let mut host = Host::with(&coarse());
    assert_eq!(host.set_integer("coupling.mode", mode), OK);
    host.start();
    for (name, start) in MOTION {
        for (i, value) in start.iter().enumerate() {
            let value = if given.contains(&name) { *value } else { 0.0 };
            assert_eq!(host.set(&format!("projectile.{name}[{}]", i + 1), value), OK);
        }
    }
    host
}

#[test]
fn an_importer_that_sets_every_input_to_zero_before_the_first_step_starts_as_the_scene_says() {
    for mode in [1, 3] {
        let mut own = with_motion(mode, &["position", "velocity", "orientation"]);
        let mut unset = with_motion(mode, &[]);
        let mut unturned = with_motion(mode, &["position", "velocity"]);
        for host in [&mut own, &mut unset, &mut unturned] {
            host.steps(0.0, 1e-4, 1);
        }
        let expected = own.digest();
        assert_eq!([unset.digest(), unturned.digest()], [expected; 2], "mode {mode}");
        assert_eq!(unsafe { fmi2DoStep(unset.c, 1e-4, 1e-4, 0) }, ERROR);
        let line = unset.one_line();
        assert!(line.starts_with("projectile.orientation = [0.0, 0.0, 0.0, 0.0] of norm 0"), "{line}");
    }
}

#[test]
fn a_prescribed_acceleration_is_the_derivative_of_the_velocity() {
    let mut host = Host::with(&coarse());
    assert_eq!(host.set_integer("coupling.mode", 1), OK);
    host.start();
    set_rate(&host, "projectile.velocity[3]", 250.0);
    host.steps(0.0, 1e-4, 1);
    assert!(host.get("contact.force[3]") > 0.0);
    assert_eq!(rate(&host, "projectile.predicted_velocity[3]"), 250.0);
}

#[test]
fn an_input_that_would_move_a_held_projectile_is_refused_by_name() {
    for (mode, input, value) in [
        (1, "projectile.position[1]", 0.05),
        (3, "projectile.velocity[1]", 3.0),
        (2, "projectile.external_force[3]", -1.0),
    ] {
        let mut host = Host::with(scene::builtin("l-beam").unwrap());
        assert_eq!(host.set_integer("coupling.mode", mode), OK);
        host.start();
        let was = host.get(input);
        host.set(input, value);
        assert_eq!(unsafe { fmi2DoStep(host.c, 0.0, 1e-6, 0) }, ERROR, "{input}");
        let text = host.one_line();
        assert!(text.starts_with(&format!("{input} = {value}")) && text.contains("in place"), "{text}");
        host.set(input, was);
        host.steps(0.0, 1e-6, 1);
    }
}

#[test]
fn round_off_out_of_the_plane_is_no_motion() {
    let mut host = Host::with(scene::builtin("ball-square").unwrap());
    assert_eq!(host.set_integer("coupling.mode", 3), OK);
    host.start();
    host.set("projectile.velocity[2]", 1e-14);
    host.set("projectile.orientation[2]", 1e-14);
    host.steps(0.0, 1e-6, 1);
}

#[test]
fn the_contact_force_falls_along_the_contact_with_position_and_velocity() {
    let mut host = Host::started();
    host.steps(0.0, 1e-4, 5);
    let (stiffness, impedance) = (host.get("contact.stiffness"), host.get("contact.impedance"));
    assert!(stiffness > 0.0 && impedance > 0.0);
    let by_position = directional(&host, "contact.linear_force[3]", "projectile.position[3]");
    let by_velocity = directional(&host, "contact.linear_force[3]", "projectile.velocity[3]");
    assert!(by_position < 0.0 && by_position >= -stiffness, "{by_position}");
    assert!((by_position / stiffness - by_velocity / impedance).abs() < 1e-12);
    assert_eq!(directional(&host, "contact.force[3]", "projectile.position[3]"), 0.0);
    assert_eq!(directional(&host, "contact.linear_force[3]", "projectile.external_force[3]"), 0.0);
}

#[test]
fn kinematic_inputs_are_never_read_when_the_fmu_integrates() {
    let mut host = Host::started();
    assert_eq!(host.set("projectile.position[3]", 7.0), OK);
    assert_eq!(host.set("projectile.orientation[1]", 0.5), OK);
    host.steps(0.0, 1e-4, 3);
    let mut other = Host::started();
    other.steps(0.0, 1e-4, 3);
    assert_eq!(host.digest(), other.digest());
}

#[test]
fn a_prescribed_motion_is_followed_with_its_acceleration_for_one_step() {
    let mut host = Host::with(&coarse());
    assert_eq!(host.set_integer("coupling.mode", 1), OK);
    host.start();
    host.set("projectile.velocity[3]", 10.0);
    set_rate(&host, "projectile.velocity[3]", 1e5);
    host.steps(0.0, 1e-4, 1);
    let expected = 0.01 + 10.0 * 1e-4 + 0.5 * 1e5 * 1e-8;
    assert!((host.get("projectile.predicted_position[3]") - expected).abs() < 1e-15);
    host.set("projectile.position[3]", expected);
    host.set("projectile.velocity[3]", 20.0);
    host.steps(1e-4, 1e-4, 1);
    assert!((host.get("projectile.predicted_position[3]") - expected - 20.0 * 1e-4).abs() < 1e-15);
}

#[test]
fn the_residual_of_a_prescribed_step_is_the_energy_that_the_importer_gains_beyond_the_work_of_the_contact() {
    let mut host = Host::with(&coarse());
    assert_eq!(host.set_integer("coupling.mode", 1), OK);
    host.start();
    host.steps(0.0, 5e-4, 1);
    let (impulse, mass) = (host.get("contact.impulse[3]"), host.get("projectile.effective_mass"));
    assert!(impulse > 0.0);
    let (before, after): (f64, f64) = (-5.0, -5.0 + impulse / mass);
    let gained = 0.5 * mass * (after.powi(2) - before.powi(2)) - impulse * before;
    let residual = host.get("coupling.energy_residual");
    assert!((residual / gained - 1.0).abs() < 1e-9, "{residual}, gained {gained}");
}

#[test]
fn an_orientation_far_from_norm_one_is_an_error_where_it_is_read() {
    let mut host = Host::with(&coarse());
    assert_eq!(host.set_integer("coupling.mode", 3), OK);
    host.start();
    host.set("projectile.orientation[2]", 0.5);
    assert_eq!(unsafe { fmi2DoStep(host.c, 0.0, 1e-5, 0) }, ERROR);
    assert!(host.one_line().contains("projectile.orientation"));
    host.set("projectile.orientation[2]", 0.0);
    host.steps(0.0, 1e-5, 1);
}

#[test]
fn motion_off_the_axis_is_an_error_in_an_axisymmetric_scene() {
    let mut host = Host::with(scene::builtin("ball-bounce").unwrap());
    host.start();
    host.set("projectile.external_force[1]", 1.0);
    assert_eq!(unsafe { fmi2DoStep(host.c, 0.0, 1e-6, 0) }, ERROR);
    let text = host.one_line();
    assert!(text.starts_with("projectile.external_force[1] = 1") && text.contains("axisymmetric"), "{text}");
}

#[test]
fn a_scene_can_name_its_coupling_mode_and_a_parameter_beats_it() {
    let scene = coarse() + "[coupling]\nmode = \"corrected\"\n";
    let speed = |mode: Option<c_int>| {
        let mut host = Host::with(&scene);
        if let Some(mode) = mode {
            assert_eq!(host.set_integer("coupling.mode", mode), OK);
        }
        host.start();
        assert_eq!(host.integer("coupling.mode"), mode.unwrap_or(3));
        assert_eq!(host.set("projectile.velocity[3]", -2.0), OK);
        assert_eq!(host.set("projectile.position[3]", 0.05), OK);
        host.steps(0.0, 1e-4, 1);
        host.get("projectile.predicted_velocity[3]")
    };
    assert_eq!((speed(None), speed(Some(1))), (-2.0, -2.0));
    assert!(speed(Some(2)) < -4.5, "integrated: the kinematic inputs are not read");
    let mut host = Host::with(&scene);
    assert_eq!(host.set_integer("coupling.mode", 4), ERROR);
    assert!(host.one_line().contains("expected one of 1 (prescribed), 2 (integrated), 3 (corrected)"));
}

#[test]
fn a_body_that_nobody_moves_goes_on_as_it_does_in_every_mode() {
    let fragment =
        "[[fragment]]\nshape.sphere.radius = 0.01\nmass = 0.02\nposition = [0.03, 0.0, 0.011]\nvelocity = [0, 0, -4]\n";
    let scene = coarse() + fragment;
    let mut ends = vec![];
    for mode in [1, 2, 3] {
        let mut host = Host::with(&scene);
        assert_eq!(host.set_integer("coupling.mode", mode), OK);
        host.start();
        host.steps(0.0, 1e-4, 10);
        ends.push(["projectile", "fragment[1]"].map(|body| {
            (host.get(&format!("{body}.predicted_position[3]")), host.get(&format!("{body}.predicted_velocity[3]")))
        }));
    }
    let [prescribed, integrated, corrected] = [0, 1, 2].map(|i| ends[i]);
    assert!((prescribed[0].0 - (0.01 - 5e-3)).abs() < 1e-15 && prescribed[0].1 == -5.0, "straight on: {prescribed:?}");
    assert!(integrated[0].1 > -5.0 && integrated[1].1 > -4.0);
    for (a, b) in corrected.iter().zip(integrated) {
        assert!((a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).abs() < 1e-9, "{corrected:?} {integrated:?}");
    }
}
