//! Air in the cavity behind the projectile: its work, its accounts, and that it leaves no trace of slices and restarts.

use ballistic_gel::math::Vector3;
use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, MeshFrame, Simulation};
use std::f64::consts::PI;

const RADIUS: f64 = 2.185e-3;
const THIN_CELLS: &str = "mesh.tree={coarsest=8,core=3e-3,slope=0.15}";
const INFLOW: &str = "gel.cavity={inflow={}}";
/// The ball of the calibration shot in a small gel, on cells of R/3.
const SHOT: [&str; 5] = [
    "scene.end_time=1e-3",
    "gel.shape={cylinder={radius=0.03,height=0.03}}",
    "mesh.size=7e-4",
    "remesh.smallest=3.5e-4",
    "scene.communication_step=1e-5",
];
const IN_THE_PLANE: [&str; 3] =
    ["scene.dimension=planar", "gel.shape={block={size=[0.06,0.03]}}", "gel.thickness=0.01"];
/// A quarter of a block, on cells of R/2.
const IN_SPACE: [&str; 7] = [
    "scene.end_time=1e-3",
    "gel.shape={block={size=[0.03,0.03,0.02]}}",
    "mesh.size=1.1e-3",
    "mesh.tree={coarsest=4,core=3e-3,slope=0.3}",
    "remesh.smallest=5e-4",
    "remesh.erosion_thickness=2e-4",
    "scene.communication_step=1e-5",
];

fn read(name: &str, changes: &[&[&str]]) -> Scene {
    let changes: Vec<Override> = changes.concat().iter().map(|change| change.parse().unwrap()).collect();
    scene::read(&scene::resolve(scene::builtin(name).unwrap(), &changes).unwrap()).unwrap()
}

fn sealed(pressure: f64) -> String {
    format!("gel.cavity={{sealed={{pressure={pressure:?}}}}}")
}

fn run_in(mode: CouplingMode, scene: &Scene, end: f64) -> Simulation {
    let mut simulation = Simulation::new(scene, mode, 1).unwrap();
    advance(&mut simulation, end, 1);
    simulation
}

fn run(scene: &Scene, end: f64) -> Simulation {
    run_in(CouplingMode::Integrated, scene, end)
}

fn advance(simulation: &mut Simulation, end: f64, steps: u32) {
    let start = simulation.time();
    for step in 1..=steps {
        let inputs = simulation.inputs();
        simulation.step(&inputs, start + (end - start) * f64::from(step) / f64::from(steps)).unwrap();
    }
}

/// Volume ∫ a A dz below z = 0, m³, that of the ball included: the weight a rises over R/2 from z = 0 down.
fn void_volume(frame: &MeshFrame, scene: &Scene) -> f64 {
    let weight = |x: &Vector3| (-x.z / (0.5 * RADIUS)).clamp(0.0, 1.0);
    let is_near = |x: &Vector3| x.x.abs().max(x.y.abs()) < 0.012;
    let facets = frame.cells.facets.iter().map(|facet| facet.map(|node| frame.points[node as usize]));
    let wall = facets.filter(|corners| corners[..frame.dimension].iter().all(is_near));
    if frame.dimension == 3 {
        let copies = scene.gel.symmetry.copies();
        return wall.map(|[a, b, c]| copies * flux_in_space([a, b - a, c - a], &weight)).sum();
    }
    let thickness = scene.gel.thickness;
    let flux = |[a, b, _]: [Vector3; 3]| -> f64 {
        let points = (0..100).map(|i| a + (b - a) * (f64::from(i) + 0.5) / 100.0);
        let section = |x: Vector3| weight(&x) * thickness.map_or(PI * x.x * x.x, |thickness| thickness * x.x);
        -points.map(section).sum::<f64>() * (b.z - a.z) / 100.0
    };
    wall.map(flux).sum()
}

/// Flux −∫ a (x, y, 0)·n/2 dA through a triangle with a corner and two edges, by the middles of 20² parts.
fn flux_in_space([a, u, v]: [Vector3; 3], weight: &impl Fn(&Vector3) -> f64) -> f64 {
    let (n, area) = (20, u.cross(&v) / 2.0);
    let at = |i: i32, j: i32, third: f64| a + (u * (f64::from(i) + third) + v * (f64::from(j) + third)) / f64::from(n);
    let upright = (0..n).flat_map(|i| (0..n - i).map(move |j| at(i, j, 1.0 / 3.0)));
    let turned = (0..n - 1).flat_map(|i| (0..n - 1 - i).map(move |j| at(i, j, 2.0 / 3.0)));
    let points = upright.chain(turned);
    -points.map(|x| weight(&x) * 0.5 * x.xy().dot(&area.xy())).sum::<f64>() / f64::from(n * n)
}

#[test]
fn work_of_the_air_is_its_pressure_times_the_volume_of_the_void() {
    let shots: [(&str, &[&[&str]], f64, f64); 3] = [
        ("fbi-bb", &[&SHOT], 0.12e-3, 0.02),
        ("fbi-bb", &[&SHOT, &IN_THE_PLANE], 0.12e-3, 0.02),
        ("fbi-bb-3d", &[&IN_SPACE], 0.07e-3, 0.05),
    ];
    for (name, changes, end, tolerance) in shots {
        for pressure in [0.0, 5e5] {
            let air = sealed(pressure);
            let scene = read(name, &[&changes.concat(), &[air.as_str()]]);
            let mut simulation = run(&scene, 0.5 * end);
            let at = simulation.frame().bodies[0].kinematics.position.z;
            assert!(at + RADIUS < -0.5 * RADIUS, "the whole pressure acts: {at}");
            let before = (simulation.observe().energy.air, void_volume(&simulation.frame(), &scene));
            advance(&mut simulation, end, 1);
            let (seen, volume) = (simulation.observe(), void_volume(&simulation.frame(), &scene) - before.1);
            let ratio = (seen.energy.air - before.0) / ((pressure - 101_325.0) * volume);
            println!(
                "{name} {:?} at {pressure} Pa: {volume:.3e} m³, {:.4e} J, ratio {ratio:.4}, {} remeshes",
                scene.scene.dimension, seen.energy.air, seen.cost.remeshes
            );
            assert!(
                volume > 4.0 * RADIUS.powi(3) && before.0 != 0.0 && seen.cost.remeshes > 3,
                "{volume} {:?}",
                seen.cost
            );
            assert!((ratio - 1.0).abs() < tolerance, "{name}: {ratio}");
            assert!(seen.energy.energy_error < 1e-10 && seen.energy.load == 0.0, "{:?}", seen.energy);
            assert!(seen.momentum_error < 1e-11 && seen.angular_momentum_error < 1e-11, "{seen:?}");
        }
    }
}

#[test]
fn books_close_whoever_moves_the_projectile_and_beside_a_load() {
    let modes = [CouplingMode::Integrated, CouplingMode::Corrected, CouplingMode::Prescribed];
    for (mode, air) in modes.into_iter().flat_map(|mode| [sealed(0.0), INFLOW.to_owned()].map(|air| (mode, air))) {
        let scene = read("fbi-bb", &[&SHOT, &[&air, "load=[{on=\"side\",pressure=2e4}]"]]);
        let seen = run_in(mode, &scene, 0.1e-3).observe();
        let energy = seen.energy;
        assert!(energy.energy_error < 1e-10 && seen.momentum_error < 1e-11, "{mode:?}: {seen:?}");
        assert!(energy.air < -1e-4 && energy.load != 0.0, "{mode:?}: {energy:?}");
    }
}

#[test]
fn air_in_a_cavity_leaves_no_trace_of_slices_threads_or_restarts() {
    let shots = [("fbi-bb", &SHOT[..], 0.1e-3), ("fbi-bb-3d", &IN_SPACE[..], 0.045e-3)];
    for ((name, changes, end), air) in
        shots.into_iter().flat_map(|shot| [sealed(0.0), INFLOW.to_owned()].map(|air| (shot, air)))
    {
        let scene = read(name, &[changes, &[&air]]);
        let whole = run(&scene, end);
        assert!(whole.observe().energy.air < 0.0 && whole.remeshes() > 0);
        let mut other = Simulation::new(&scene, CouplingMode::Integrated, 3).unwrap();
        advance(&mut other, 0.7 * end, 13);
        let mut restored = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
        restored.restore(&other.save()).expect("a state of the same scene");
        for mut simulation in [other, restored] {
            advance(&mut simulation, end, 2);
            assert_eq!(simulation.digest(), whole.digest(), "{name}");
        }
    }
}

#[test]
fn air_that_flows_in_takes_less_work_than_a_vacuum_the_less_the_wider_its_way() {
    assert_eq!(read("fbi-bb", &[&[INFLOW]]), read("fbi-bb", &[&["gel.cavity={inflow={discharge=0.61}}"]]));
    let work = |air: &str| run(&read("fbi-bb", &[&SHOT, &[air]]), 0.12e-3).observe().energy.air;
    let [vacuum, closed] = [&sealed(0.0), "gel.cavity={inflow={discharge=0.0}}"].map(work);
    let [usual, wide] = [INFLOW, "gel.cavity={inflow={discharge=1.0}}"].map(work);
    println!("vacuum {vacuum:.4e} J, no inflow {closed:.4e} J, usual {usual:.4e} J, wide {wide:.4e} J");
    // Without a flow the little air behind the ball at the start expands to nearly nothing.
    assert!(vacuum < closed && closed < 0.8 * vacuum && closed < usual && usual < wide && wide < 0.0);
}

#[test]
fn books_close_where_the_ball_leaves_a_cavity_into_which_air_flows() {
    let thin = [
        "gel.shape={cylinder={radius=0.03,height=0.01}}",
        "gel.supports={}",
        THIN_CELLS,
        "scene.end_time=4e-4",
        INFLOW,
    ];
    let seen = run(&read("fbi-bb", &[&SHOT, &thin]), 4e-4).observe();
    assert!(seen.projectile().exit.is_some(), "the ball goes through");
    assert!(seen.energy.energy_error < 1e-10 && seen.energy.energy_defect < 0.05, "{:?}", seen.energy);
    let vented = run(&read("fbi-bb", &[&SHOT, &thin[..4], &["gel.cavity=vented"]]), 4e-4).observe();
    let [with, without] = [&seen, &vented].map(|seen| seen.projectile().kinematics.velocity.z);
    assert!((with / without - 1.0).abs() < 0.02, "{with} and {without} m/s");
}

#[test]
fn a_vented_cavity_and_one_at_ambient_pressure_change_nothing() {
    let absent =
        scene::builtin("fbi-bb").unwrap().lines().filter(|line| !line.starts_with("cavity = ")).collect::<Vec<_>>();
    let absent = scene::read(&absent.join("\n")).unwrap();
    let scene = |air: &str| read("fbi-bb", &[&SHOT, &[air]]);
    assert_eq!(absent.gel, read("fbi-bb", &[&["gel.cavity=vented"]]).gel);
    let [vented, ambient] = ["gel.cavity=vented", &sealed(101_325.0)].map(|air| run(&scene(air), 0.1e-3));
    let [without, with] = [&vented, &ambient].map(Simulation::observe);
    assert_eq!(without.energy, with.energy);
    assert_eq!(without.projectile().kinematics, with.projectile().kinematics);
}

#[test]
fn a_cavity_that_cannot_be_is_refused_with_its_key() {
    let error = |changes: &[&str]| {
        let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
        scene::read(&scene::resolve(scene::builtin("fbi-bb").unwrap(), &changes).unwrap()).unwrap_err().to_string()
    };
    for pressure in ["-1.0", "inf", "nan"] {
        let text = error(&[&format!("gel.cavity={{sealed={{pressure={pressure}}}}}")]);
        assert!(text.contains("gel.cavity.sealed.pressure") && text.contains("101325"), "{text}");
    }
    for discharge in ["-0.1", "1.1", "nan"] {
        let text = error(&[&format!("gel.cavity={{inflow={{discharge={discharge}}}}}")]);
        assert!(text.contains("gel.cavity.inflow.discharge"), "{text}");
    }
    let loads = format!("load=[{}]", ["{pressure=1.0}"; 8].join(","));
    let air = sealed(0.0);
    assert!(
        error(&[&air, &loads]).contains("at most 7 beside a cavity that is not vented"),
        "{}",
        error(&[&air, &loads])
    );
    let shell = ["gel.shape={shell={inner=0.01,outer=0.05}}", "gel.supports={}", &air];
    assert!(error(&shell).contains("\"vented\""), "{}", error(&shell));
}

#[test]
fn the_air_is_listed_where_it_is_computed_and_where_it_is_not() {
    let air = sealed(2e3);
    let lines = |scene: &Scene| [scene::modelled_physics(scene), scene::switched_off(scene)];
    let starts = |lines: &[String], start: &str| lines.iter().any(|line| line.starts_with(start));
    let [on, off] = lines(&read("fbi-bb", &[&[&air]]));
    assert!(starts(&on, "air: 2000.0 Pa in the sealed cavity") && !starts(&off, "air:") && starts(&off, "air flow:"));
    let [on, off] = lines(&read("fbi-bb", &[&[INFLOW]]));
    assert!(starts(&on, "air: flows into the cavity") && !starts(&off, "air:") && starts(&off, "air waves:"));
    let [on, off] = lines(&read("fbi-bb", &[&["gel.cavity=vented"]]));
    assert!(!starts(&on, "air") && starts(&off, "air: none"));
}
