//! Each body has its own share of every rule: checks, derivatives, masses, domes.

use super::bodies::{BALL, DOME, set_flag, step};
use super::coupling::{directional, rate, set_rate};
use super::host::{ERROR, Host, OK, coarse};
use ballistic_gel::fmi2::abi::*;
use ballistic_gel::scene;

/// A heavier ball on the other side, that is no homogeneous one.
const HEAVY: &str = "\n[[fragment]]\nshape.sphere.radius = 0.012\nmass = 0.05\nposition = [-0.03, 0.01, 0.013]\n\
     velocity = [1, 0, -7]\ninertia = [2e-6, 3e-6, 4e-6, 1e-7, 2e-7, 3e-7]\n";
/// A sphere that is held above the gel, and waits.
const POST: &str =
    "\n[[fragment]]\nshape.sphere.radius = 0.01\nfixed = true\nactive = false\nposition = [0, 0, 0.015]\n";

fn with(fragments: &[&str]) -> Host {
    let mut host = Host::with(&(coarse() + &fragments.concat()));
    host.start();
    host
}

/// A dome of 6 mm height alone on the gel: the projectile is far away.
fn dome() -> Host {
    let mut host =
        Host::with(&(coarse() + &DOME.replace("height = 0.0", "height = 0.006").replace(", 0.0]", ", 0.008]")));
    assert_eq!(host.set("projectile.initial_position[3]", 0.05), OK);
    host.start();
    host
}

fn bulge(host: &mut Host, size: [f64; 2], rates: [f64; 2]) {
    for (name, value) in
        [("height", size[0]), ("radius", size[1]), ("height_rate", rates[0]), ("radius_rate", rates[1])]
    {
        assert_eq!(host.set(&format!("fragment[1].bulge_{name}"), value), OK);
    }
}

fn bulge_impulses(host: &mut Host) -> [f64; 2] {
    ["height", "radius"].map(|name| host.get(&format!("fragment[1].contact.bulge_{name}_impulse")))
}

/// The step is refused with these words.
fn refused(host: &mut Host, from: f64, words: &[&str]) {
    assert_eq!(step(host, from), ERROR, "{words:?}");
    let said = host.one_line();
    assert!(words.iter().all(|word| said.contains(word)), "{said}");
}

#[test]
fn height_and_radius_have_impulses_of_their_own_that_work_with_their_rates() {
    for rates in [[8.0, 0.0], [0.0, 30.0], [6.0, 15.0]] {
        let (mut host, mut work, mut size) = (dome(), 0.0, [0.006, 0.03]);
        for k in 0..12 {
            // First it goes into the gel.
            let rates = if k < 5 { [10.0, 0.0] } else { rates };
            bulge(&mut host, size, rates);
            host.steps(f64::from(k) * 1e-4, 1e-4, 1);
            size = [size[0] + rates[0] * 1e-4, size[1] + rates[1] * 1e-4];
            let impulses = bulge_impulses(&mut host);
            work -= rates[0] * impulses[0] + rates[1] * impulses[1];
        }
        let [height, radius] = bulge_impulses(&mut host);
        assert!(height < 0.0 && (height - radius).abs() > 1e-3 * height.abs(), "{rates:?}: {height} {radius}");
        let external = host.get("energy.external");
        assert!(work.abs() > 1e-6 && (external / work - 1.0).abs() < 1e-9, "{rates:?}: {external}, expected {work}");
    }
}

#[test]
fn input_derivatives_of_the_rates_of_a_dome_act_within_the_step() {
    let (h, rates) = (4e-4, [20.0, 10.0]);
    for (name, accelerations) in [("height", [2e4, 0.0]), ("radius", [0.0, 3e4])] {
        let rate_name = format!("fragment[1].bulge_{name}_rate");
        let acceleration = accelerations[0] + accelerations[1];
        let run = |n: u32, acceleration: f64| {
            let mut host = dome();
            let mut sum = [0.0; 2];
            for k in 0..n {
                let t = h * f64::from(k) / f64::from(n);
                let at = |i: usize, from: f64| from + t * (rates[i] + 0.5 * t * accelerations[i]);
                let speed = |i: usize| rates[i] + t * accelerations[i];
                bulge(&mut host, [at(0, 0.006), at(1, 0.04)], [speed(0), speed(1)]);
                set_rate(&host, &rate_name, acceleration);
                host.steps(t, h / f64::from(n), 1);
                let impulses = bulge_impulses(&mut host);
                sum = [sum[0] + impulses[0], sum[1] + impulses[1]];
            }
            (sum, host.get("fragment[1].depth"))
        };
        let (once, in_parts, without) = (run(1, acceleration), run(4, acceleration), run(1, 0.0));
        for i in 0..2 {
            assert!((once.0[i] / in_parts.0[i] - 1.0).abs() < 1e-6, "{name}: {once:?} {in_parts:?}");
            assert!((once.0[i] / without.0[i] - 1.0).abs() > 1e-3, "{name}: {once:?} {without:?}");
        }
        let depth = |with: f64| 0.006 - 0.008 + h * (rates[0] + 0.5 * h * with);
        assert!((once.1 - depth(accelerations[0])).abs() < 1e-15 && (without.1 - depth(0.0)).abs() < 1e-15);
    }
}

#[test]
fn a_radius_that_shrinks_to_nothing_within_the_step_is_refused() {
    let mut host = dome();
    set_rate(&host, "fragment[1].bulge_radius_rate", -8e6);
    let found = "with a base radius of -0.02 m at the end of the step: expected a base radius above 0 m";
    assert_eq!(host.set("fragment[1].bulge_radius", 0.02), OK);
    refused(&mut host, 0.0, &["fragment[1].bulge_height = 0.006 m", found]);
    set_rate(&host, "fragment[1].bulge_radius_rate", 0.0);
    assert_eq!(host.set("fragment[1].bulge_radius", 0.005), OK);
    refused(&mut host, 0.0, &["0.006 m, with a base radius of 0.005 m at the start", "at most a hemisphere"]);
}

#[test]
fn a_bulge_input_is_refused_for_a_body_that_is_no_dome() {
    let mut host = with(&[BALL]);
    for (name, body) in [("bulge_height_rate", "projectile"), ("bulge_radius_rate", "fragment[1]")] {
        let name = format!("{body}.{name}");
        set_rate(&host, &name, 1.0);
        refused(&mut host, 0.0, &[&format!("derivative of {name} = "), "the shape of the body is no dome"]);
        set_rate(&host, &name, 0.0);
        assert_eq!(host.set(&name, 2.0), OK);
        refused(&mut host, 0.0, &[&format!("{name} = 2"), "the shape of the body is no dome"]);
        assert_eq!(host.set(&name, 0.0), OK);
    }
    assert_eq!(step(&host, 0.0), OK);
}

#[test]
fn an_input_that_would_move_a_held_fragment_is_refused_by_name() {
    for (mode, input, value) in [(2, "external_force[3]", -1.0), (1, "position[1]", 0.01), (3, "velocity[2]", 3.0)] {
        let mut host = Host::with(&(coarse() + BALL + DOME));
        assert_eq!(host.set_integer("coupling.mode", mode), OK);
        host.start();
        let input = format!("fragment[2].{input}");
        let was = host.get(&input);
        assert_eq!(host.set(&input, value), OK);
        refused(&mut host, 0.0, &[&format!("{input} = {value}"), "fragment[2].fixed = true"]);
        assert_eq!(host.set(&input, was), OK);
        assert_eq!(step(&host, 0.0), OK);
    }
}

#[test]
fn a_fragment_stays_in_the_plane_of_the_scene() {
    let disc = "\n[[fragment]]\nshape.sphere.radius = 0.01\nmass = 1.0\nposition = [0.0, 0.0, 0.5]\n";
    let mut host = Host::with(&(scene::builtin("ball-square").unwrap().to_owned() + disc));
    host.start();
    let mut moved = |name: &str, allowed: bool| {
        assert_eq!(host.set(name, 1.0), OK);
        if !allowed {
            assert_eq!(unsafe { fmi2DoStep(host.c, 0.0, 1e-6, 0) }, ERROR);
            let said = host.one_line();
            assert!(said.starts_with(&format!("{name} = 1")) && said.contains("the scene is planar"), "{said}");
            assert_eq!(host.set(name, 0.0), OK);
        }
    };
    moved("fragment[1].external_force[2]", false);
    moved("fragment[1].external_torque[1]", false);
    moved("fragment[1].external_force[1]", true);
    host.steps(0.0, 1e-6, 1);
}

#[test]
fn the_directional_derivative_is_that_of_the_own_contact_and_none_across_bodies() {
    let mut host = with(&[BALL, HEAVY]);
    host.steps(0.0, 1e-4, 8);
    let mut seen = vec![];
    for body in ["", "fragment[1].", "fragment[2]."] {
        let own = if body.is_empty() { "projectile." } else { body };
        let trace = |input: &str| {
            let of = |i: u8| (format!("{body}contact.linear_force[{i}]"), format!("{own}{input}[{i}]"));
            (1..=3).map(of).map(|(force, by)| directional(&host, &force, &by)).sum::<f64>()
        };
        let (by_position, by_velocity) = (trace("position"), trace("velocity"));
        let stiffness = host.get(&format!("{body}contact.stiffness"));
        let impedance = host.get(&format!("{body}contact.impedance"));
        assert!(stiffness > 0.0 && impedance > 0.0, "{body}");
        assert!((by_position / stiffness + 1.0).abs() < 1e-12 && (by_velocity / impedance + 1.0).abs() < 1e-12);
        seen.push(stiffness);
    }
    assert!(seen[0] != seen[1] && seen[1] != seen[2] && seen[0] != seen[2], "{seen:?}");
    for (force, by) in [("", "fragment[1]"), ("fragment[1].", "projectile"), ("fragment[2].", "fragment[1]")] {
        let (force, by) = (format!("{force}contact.linear_force[3]"), format!("{by}.position[3]"));
        assert_eq!(directional(&host, &force, &by), 0.0, "{force} by {by}");
    }
}

#[test]
fn output_derivatives_are_those_of_the_own_wrench_and_mass() {
    let mut host = with(&[BALL, HEAVY]);
    let bodies = [("projectile", 0.033, -2.0), ("fragment[1]", 0.02, 3.0), ("fragment[2]", 0.05, -5.0)];
    for (body, _, force) in bodies {
        assert_eq!(host.set(&format!("{body}.external_force[3]"), force), OK);
    }
    host.steps(0.0, 1e-4, 8);
    for (body, mass, force) in bodies {
        let contact = if body == "projectile" { "contact".to_owned() } else { format!("{body}.contact") };
        let push = host.get(&format!("{contact}.force[3]"));
        assert!(push > 0.1, "{body} {push}");
        let velocity = format!("{body}.predicted_velocity[3]");
        assert_eq!(rate(&host, &velocity), (push + force) / mass, "{body}");
        assert_eq!(rate(&host, &format!("{body}.predicted_position[3]")), host.get(&velocity));
        assert_eq!(rate(&host, &format!("{contact}.total_impulse[3]")), push);
    }
}

#[test]
fn each_body_has_its_own_mass_and_inertia() {
    let mut host = with(&[BALL, HEAVY, DOME]);
    let sphere = |mass: f64| [0.4 * mass * 1e-4, 0.4 * mass * 1e-4, 0.4 * mass * 1e-4, 0.0, 0.0, 0.0];
    for (body, mass, inertia) in [
        ("projectile", 0.033, sphere(0.033)),
        ("fragment[1]", 0.02, sphere(0.02)),
        ("fragment[2]", 0.05, [2e-6, 3e-6, 4e-6, 1e-7, 2e-7, 3e-7]),
        ("fragment[3]", 0.0, [0.0; 6]),
    ] {
        assert_eq!(host.get(&format!("{body}.effective_mass")), mass);
        for (i, expected) in inertia.iter().enumerate() {
            let found = host.get(&format!("{body}.effective_inertia[{}]", i + 1));
            assert!((found - expected).abs() <= 1e-12 * expected, "{body} {i}: {found}");
        }
    }
}

#[test]
fn a_held_body_comes_and_goes_where_the_scene_has_it_and_nowhere_else() {
    let mut host = with(&[POST]);
    host.steps(0.0, 1e-4, 1);
    set_flag(&host, "fragment[1].active", true);
    assert_eq!(host.set("fragment[1].position[1]", 0.02), OK);
    refused(&mut host, 1e-4, &["fragment[1].position[1] = 0.02", "fragment[1].fixed = true"]);
    assert_eq!(host.set("fragment[1].position[1]", 0.0), OK);
    host.steps(1e-4, 1e-4, 1);
    set_flag(&host, "fragment[1].active", false);
    host.steps(2e-4, 1e-4, 1);
    assert_eq!(host.get("fragment[1].predicted_position[3]"), 0.015);
}

#[test]
fn a_held_dome_that_comes_inside_the_gel_is_refused_and_one_outside_pushes_until_it_goes() {
    let mut host = Host::with(&(coarse() + &DOME.replace("height = 0.0", "height = 0.008") + "active = false\n"));
    assert_eq!(host.set("projectile.initial_position[3]", 0.05), OK);
    host.start();
    host.steps(0.0, 1e-4, 1);
    set_flag(&host, "fragment[1].active", true);
    refused(&mut host, 1e-4, &["fragment[1].active = true", "expected a place outside the gel"]);
    bulge(&mut host, [0.0, 0.02], [10.0, 0.0]);
    host.steps(1e-4, 1e-4, 1);
    bulge(&mut host, [1e-3, 0.02], [10.0, 0.0]);
    host.steps(2e-4, 1e-4, 1);
    assert!(host.get("fragment[1].contact.force[3]") > 0.0);
    set_flag(&host, "fragment[1].active", false);
    host.steps(3e-4, 1e-4, 1);
    assert_eq!(host.get("fragment[1].contact.force[3]"), 0.0);
}

#[test]
fn a_bulge_without_height_is_flat_whatever_its_base_radius() {
    let mut forces = vec![];
    for radius in [0.0, 1e-300, 0.02, 5.0] {
        let mut host = with(&[DOME]);
        for k in 0..4 {
            bulge(&mut host, [0.0, radius], [0.0, 0.0]);
            host.steps(f64::from(k) * 1e-4, 1e-4, 1);
        }
        forces.push(host.get("contact.total_impulse[3]"));
    }
    assert!(forces[0] > 0.0 && forces.iter().all(|force| *force == forces[0]), "{forces:?}");
    let mut host = with(&[DOME]);
    bulge(&mut host, [0.001, 0.0], [0.0, 0.0]);
    refused(&mut host, 0.0, &["fragment[1].bulge_height = ", "a base radius above 0 m"]);
}
