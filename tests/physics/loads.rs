//! Pressures on faces of the gel, damping, and the cavity that is blown up.

use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, MeshFrame, Simulation};
use std::f64::consts::PI;

const PLANAR: &str = "dimension = \"planar\"\n[gel]\nshape.block.size = [0.04, 0.02]\nthickness = 0.5";
const RING: &str =
    "dimension = \"axisymmetric\"\n[gel]\nshape.cylinder = { radius = 0.02, height = 0.02, bore = 0.005 }";
const SOLID: &str = "dimension = \"spatial\"\n[gel]\nshape.block.size = [0.02, 0.03, 0.02]";

/// A gel that no body meets.
fn text(space: &str, rest: &str) -> String {
    let [space, gel] = space.split_once("[gel]").map(|(a, b)| [a, b]).expect("a gel");
    format!(
        "[scene]\nname = \"loaded\"\nend_time = 0.02\ncommunication_step = 1e-4\n{space}[gel]{gel}\nmaterial = \"neo-hookean\"\n\
         density = 1000.0\nshear_modulus = 20e3\nbulk_modulus = 100e3\n[projectile]\nshape.half-space.normal = [0.0, 0.0, -1.0]\n\
         fixed = true\nactive = false\nposition = [0.0, 0.0, 1.0]\n[mesh]\nsize = 2.5e-3\n{rest}"
    )
}

fn read(space: &str, rest: &str) -> Scene {
    scene::read(&text(space, rest)).unwrap_or_else(|error| panic!("{error}"))
}

/// A run to `end` in so many steps.
fn run(scene: &Scene, (threads, steps): (usize, u32), end: f64) -> Simulation {
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, threads).expect("a scene that can be built");
    go(&mut simulation, steps, end);
    simulation
}

fn go(simulation: &mut Simulation, steps: u32, end: f64) {
    let begun = simulation.time();
    for i in 1..=steps {
        let inputs = simulation.inputs();
        let time = begun + (end - begun) * f64::from(i) / f64::from(steps);
        simulation.step(&inputs, time).expect("a gel that bears it");
    }
}

/// Every section with loads on several faces, one of them in a box, and a damping.
fn loaded(schedule: &str) -> [Scene; 3] {
    let boxed = "[[load]]\non = \"z_max\"\nwithin = { low = [-0.006, -1, -1], high = [0.021, 1, 1] }\npressure = 3e3\n\
                 table = [[0, 0], [4e-3, 1], [9e-3, -0.5]]\n";
    let with = |face: &str| {
        format!(
            "{boxed}[[load]]\non = \"{face}\"\npressure = 2e3\nramp = 1e-3\n[integrator]\nschedule = \"{schedule}\"\ndamping = 20.0\n"
        )
    };
    [read(PLANAR, &with("x_min")), read(RING, &with("inner")), read(SOLID, &with("y_max"))]
}

#[test]
fn books_close_under_loads_and_damping_in_every_space_and_schedule() {
    let all = ["bins", "global", "queue"].into_iter();
    for (schedule, scene) in all.flat_map(|schedule| loaded(schedule).map(|scene| (schedule, scene))) {
        let seen = run(&scene, (1, 7), 0.01).observe();
        let energy = seen.energy;
        let name = format!("{:?} {:?}", scene.scene.dimension, scene.integrator.schedule);
        assert!(energy.load > 0.0 && energy.damping < 0.0 && energy.kinetic > 0.0, "{name}: {energy:?}");
        assert!(energy.energy_error < 1e-12, "{name}: {energy:?}");
        assert!(seen.momentum_error < 1e-13 && seen.angular_momentum_error < 1e-13, "{name}: {seen:?}");
        // Elements of a queue sample the velocities of their common nodes at different instants.
        let residual = if schedule == "queue" { 0.05 } else { 2e-3 };
        assert!(energy.integration.abs() < residual * energy.load, "{name}: {energy:?}");
    }
}

#[test]
fn loads_and_damping_leave_no_trace_of_steps_threads_or_restarts() {
    for scene in loaded("bins") {
        let [whole, sliced] = [(1, 1), (3, 41)].map(|how| run(&scene, how, 0.01));
        assert_eq!(whole.digest(), sliced.digest());
        let half = run(&scene, (1, 1), 0.004);
        let mut other = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
        other.restore(&half.save()).expect("a state of the same scene");
        go(&mut other, 3, 0.01);
        assert_eq!(other.digest(), whole.digest());
    }
}

/// Pressures that come and go on faces that are held, one of them rising with the depth; and one that pushes after a while, so
/// that a wave comes.
fn held_under_load(space: &str, face: &str, more: &str) -> Scene {
    let held = format!("{space}\nsupports.z_min = \"fixed\"\nsupports.{face} = \"fixed\"");
    read(
        &held,
        &format!(
            "[[load]]\non = \"z_min\"\npressure = 4e5\ntable = [[0, 0], [1.3e-3, 1], [1.5e-3, 0], [2.1e-3, 0], [2.5e-3, 2], [4.8e-3, 0]]\n\
             [[load]]\non = \"{face}\"\npressure = 2e5\ndepth = 0.013\nramp = 3.1e-3\n\
             [[load]]\non = \"z_max\"\npressure = 3e3\ntable = [[2e-3, 0], [3e-3, 1]]\n{more}"
        ),
    )
}

/// As long as no wave has come to a face that is held, nothing of it moves, but the pressures on it make it stiffer.
#[test]
fn loads_on_faces_that_are_held_leave_no_trace_of_restarts() {
    let remeshed = "[remesh]\ntimes = [1.1e-3, 2.3e-3]\n";
    for (space, face) in [(PLANAR, "x_max"), (RING, "side"), (SOLID, "y_max")] {
        for more in ["", "[integrator]\nschedule = \"global\"\n", remeshed] {
            let scene = held_under_load(space, face, more);
            let whole = run(&scene, (1, 1), 6e-3);
            let mut saved = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
            for time in [0.2e-3, 0.7e-3, 1.2e-3, 1.49e-3, 1.9e-3, 2.2e-3, 2.6e-3, 3.5e-3, 4.7e-3] {
                go(&mut saved, 1, time);
                let mut other = Simulation::new(&scene, CouplingMode::Integrated, 2).unwrap();
                other.restore(&saved.save()).expect("a state of the same scene");
                go(&mut other, 1, 6e-3);
                assert_eq!(other.digest(), whole.digest(), "{space} {more} saved at {time} s");
            }
        }
    }
}

/// A pressure on a face that is held, so great that at this time, s, a step falls to less than a tick though nothing is crushed; it is
/// there for less than a tick, or `then` stays.
fn struck(time: f64, then: &str, more: &str) -> Scene {
    let held = format!("{PLANAR}\nsupports.z_min = \"fixed\"");
    let table = format!("[[0, 0], [{}, 0], [{time}, 1], [{}, {then}]]", time - 1e-9, time + 1e-9);
    read(&held, &format!("[[load]]\non = \"z_min\"\npressure = 1e14\ntable = {table}\n{more}"))
}

#[test]
fn a_step_that_collapses_ends_a_mesh_and_the_run_only_where_no_other_helps() {
    // All steps are the same, and end at this multiple of them.
    let stroke = 32.0 * run(&struck(1.0, "0", ""), (1, 1), 1e-4).observe().cost.smallest_step;
    let (end, between) = (1.5 * stroke, stroke + 2e-9);
    let scene = struck(stroke, "0", "[remesh]\n");
    let whole = run(&scene, (1, 1), end);
    assert_eq!((whole.remeshes(), whole.failed_remeshings().len()), (1, 0));
    assert_eq!(run(&scene, (2, 37), end).digest(), whole.digest());
    for time in [stroke - 2e-9, stroke, between, stroke + 1e-5] {
        let mut other = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
        other.restore(&run(&scene, (1, 1), time).save()).expect("a state of the same scene");
        go(&mut other, 2, end);
        assert_eq!(other.digest(), whole.digest(), "saved at {time} s");
    }
    let steps = run(&scene, (1, 1), between).observe().cost;
    assert!(steps.remeshes == 0 && steps.smallest_step < 1e-3 * steps.largest_step, "{steps:?}");
    for scene in [struck(stroke, "1", "[remesh]\n"), struck(stroke, "0", "")] {
        let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
        let error = simulation.step(&simulation.inputs(), end).expect_err("a step that stays too short");
        assert!(error.to_string().contains("below a thousandth"), "{error}");
    }
}

/// Pressure on a cube of this stretch in all directions, Pa.
fn hydrostatic(stretch: f64) -> f64 {
    let [mu, lambda] = [20e3, 100e3 - 2.0 / 3.0 * 20e3];
    let j = stretch.powi(3);
    -(mu * (stretch * stretch - 1.0) + lambda * j.ln()) / j
}

#[test]
fn a_pressure_all_around_compresses_as_the_material_says() {
    let pressure = hydrostatic(0.95);
    let rest = format!("[[load]]\npressure = {pressure}\nramp = 5e-3\n[integrator]\ndamping = 600.0\n");
    for space in [SOLID, RING.replace(", bore = 0.005", "").as_str()] {
        let frame = run(&read(space, &rest), (1, 1), 0.08).frame();
        let extent = |of: &dyn Fn(usize) -> f64| {
            let all = (0..frame.points.len()).map(of);
            all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
        };
        for axis in [0, 2] {
            let stretch =
                extent(&|i| frame.points[i][axis]) / extent(&|i| frame.points[i][axis] - frame.displacements[i][axis]);
            assert!((stretch - 0.95).abs() < 1e-5, "{space} {axis}: {stretch}");
        }
    }
}

/// Where the centre of mass of a planar frame is along x, m: elements count as they were at rest.
fn centre(frame: &MeshFrame) -> f64 {
    let of = |(nodes, jacobian): (&[u32; 4], &f64)| {
        let [a, b, c] = [0, 1, 2].map(|k| frame.points[nodes[k] as usize]);
        let weight = (b - a).cross(&(c - a)).norm() / jacobian;
        (weight * (a.x + b.x + c.x) / 3.0, weight)
    };
    let all = frame.cells.nodes.iter().zip(&frame.cells.jacobian).map(of);
    let (moment, weight) = all.fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    moment / weight
}

#[test]
fn a_load_that_rises_with_the_depth_pushes_as_much_as_its_integral() {
    let (pressure, depth, time) = (200.0, 0.01, 2e-3);
    let scene = read(PLANAR, &format!("[[load]]\non = \"x_min\"\npressure = {pressure}\ndepth = {depth}\n"));
    let [whole, sliced] = [(1, 1), (2, 23)].map(|how| run(&scene, how, time));
    assert_eq!(whole.digest(), sliced.digest());
    let (force, mass) = (pressure * 0.5 * (0.02 - 0.5 * depth), 1000.0 * 0.04 * 0.02 * 0.5);
    let ratio = centre(&whole.frame()) / (0.5 * force / mass * time * time);
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
    let seen = whole.observe();
    assert!(seen.energy.energy_error < 1e-12 && seen.momentum_error < 1e-13, "{seen:?}");
}

#[test]
fn speeds_fade_as_the_damping_says_and_the_books_know_where_to() {
    for schedule in ["bins", "global", "queue"] {
        let rest = format!("[integrator]\nschedule = \"{schedule}\"\ndamping = 100.0\n");
        let planar = PLANAR.to_owned() + "\nvelocity = [1.0, 0.0, 2.0]";
        let simulation = run(&read(&planar, &rest), (1, 3), 0.02);
        let (frame, seen) = (simulation.frame(), simulation.observe());
        let still = 100.0 * seen.cost.largest_step;
        let expected = (-100.0_f64 * 0.02).exp();
        for velocity in &frame.velocities {
            assert!(
                velocity.x >= expected * (1.0 - 1e-9) && velocity.x <= expected * (1.0 + 1.1 * still),
                "{velocity}"
            );
            assert!((velocity.z - 2.0 * velocity.x).abs() < 1e-3 * expected, "{velocity}");
        }
        let mass = 1000.0 * 0.04 * 0.02 * 0.5;
        assert!((seen.energy.initial - 0.5 * mass * 5.0).abs() < 1e-9);
        let part = -seen.energy.damping / seen.energy.initial;
        assert!((part - (1.0 - expected * expected)).abs() < 3.0 * expected * expected * still, "{part}");
        assert!(seen.energy.energy_error < 1e-13 && seen.momentum_error < 1e-13, "{seen:?}");
    }
}

#[test]
fn loads_go_on_where_they_were_when_the_mesh_is_replaced() {
    let load =
        "[[load]]\non = \"z_min\"\nwithin = { low = [-1, -1, -1], high = [0.0101, 0.0051, 1] }\npressure = 20e3\n";
    let mesh =
        ["", "[remesh]\ntimes = [5e-3, 6e-3, 7e-3]\n", "[remesh]\nmethod = \"immersed\"\ntimes = [5e-3, 6e-3, 7e-3]\n"];
    for space in [PLANAR, RING, SOLID] {
        let made = mesh.iter().filter(|mesh| space != SOLID || !mesh.contains("immersed"));
        let work: Vec<f64> = made
            .map(|mesh| {
                let simulation = run(&read(space, &format!("{load}{mesh}")), (1, 1), 8e-3);
                let seen = simulation.observe();
                assert_eq!(
                    seen.cost.remeshes > 0,
                    !mesh.is_empty(),
                    "{space} {mesh} {:?}",
                    simulation.failed_remeshings()
                );
                assert!(seen.energy.energy_error < 1e-10 && seen.momentum_error < 1e-11, "{space}: {seen:?}");
                let mut other =
                    Simulation::new(&read(space, &format!("{load}{mesh}")), CouplingMode::Integrated, 1).unwrap();
                other.restore(&simulation.save()).expect("a state of the same scene");
                assert_eq!(other.digest(), simulation.digest());
                go(&mut other, 1, 9e-3);
                let mut first = simulation;
                go(&mut first, 1, 9e-3);
                assert_eq!(other.digest(), first.digest());
                seen.energy.load
            })
            .collect();
        println!("{space}: {work:?}");
        assert!(work[1..].iter().all(|other| (other / work[0] - 1.0).abs() < 0.15), "{space}: {work:?}");
    }
}

#[test]
fn a_load_on_nothing_is_refused() {
    let load = "[[load]]\npressure = 1.0\n[[load]]\non = \"z_max\"\nwithin = { low = [1, 1, 1], high = [2, 2, 2] }\npressure = 1.0\n";
    let error = Simulation::new(&read(SOLID, load), CouplingMode::Integrated, 1).err().expect("nothing is there");
    let expected = "load[2]: no facet of the surface of the gel is on that face and, with all its corners, in that box; \
                    widen load[2].within";
    assert_eq!(error.to_string(), expected);
}

/// p/G of `cavity-exact` at a stretch of the cavity.
fn exact(stretch: f64) -> f64 {
    let h = |x: f64| 2.0 / x + 0.5 / x.powi(4);
    h((1.0 + (stretch.powi(3) - 1.0) / 8000.0).cbrt()) - h(stretch)
}

/// Volume of the cavity of a shell, m³.
fn cavity(simulation: &Simulation) -> f64 {
    let frame = simulation.frame();
    let is_inner = |node: &u32| (frame.points[*node as usize] - frame.displacements[*node as usize]).norm() < 0.01;
    let facets = frame.cells.facets.iter().filter(|facet| facet[..2].iter().all(is_inner));
    let part = |facet: &[u32; 3]| {
        let [a, b] = [0, 1].map(|k| frame.points[facet[k] as usize]);
        // The flat face ends in the cavity's rim: none of its edges has two nodes there.
        PI * (b.z - a.z) * (a.x * a.x + a.x * b.x + b.x * b.x) / 3.0
    };
    facets.map(part).sum()
}

#[test]
fn a_cavity_is_blown_up_as_the_closed_form_says_through_a_remeshing() {
    let keys = [("remesh.times", "[0.06]")];
    let keys = keys.map(|(key, value)| Override { key: key.into(), value: value.into() });
    let text = scene::resolve(scene::builtin("cavity-exact").unwrap(), &keys).unwrap();
    let scene = scene::read(&text).unwrap();
    let mut simulation = run(&scene, (1, 1), 1e-4);
    let start = cavity(&simulation);
    for (time, tolerance) in [(0.05, 0.012), (0.07, 0.012)] {
        go(&mut simulation, 1, time);
        let history = scene.load[0].history();
        let pressure =
            history.iter().find(|(t, _)| (t - time).abs() < 1e-9).map(|(_, p)| p / 35e3).expect("a point of the table");
        let stretch = (cavity(&simulation) / start).cbrt();
        let error = pressure / exact(stretch) - 1.0;
        println!("at {time} s: stretch {stretch:.4}, p {pressure:.4}, error {error:+.4}");
        assert!(error.abs() < tolerance, "stretch {stretch}: {error}");
    }
    assert!(simulation.remeshes() >= 1 && simulation.books().energy.energy_error < 1e-10);
}
