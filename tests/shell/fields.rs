//! Fields in the frames of a run: they are there when asked for, and observing them leaves no trace.

use crate::written::grid;
use ballistic_gel::output::{DriverInterface, RunRecorder};
use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, FrameField, MeshFrame, Simulation};

/// A built-in scene with overrides.
fn scene(name: &str, overrides: &[(&str, &str)]) -> Scene {
    let own = |(key, value): &(&str, &str)| Override { key: (*key).to_owned(), value: (*value).to_owned() };
    let overrides: Vec<Override> = overrides.iter().map(own).collect();
    scene::read_with(scene::builtin(name).unwrap(), &overrides, &scene::no_files).unwrap().scene
}

/// Advances by communication steps, with a frame after each.
fn run(scene: &Scene, threads: usize, steps: u32) -> (Vec<MeshFrame>, u128) {
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, threads).unwrap();
    let mut frames = vec![simulation.frame()];
    for k in 1..=steps {
        let inputs = simulation.inputs();
        simulation.step(&inputs, f64::from(k) * scene.scene.communication_step).unwrap();
        frames.push(simulation.frame());
    }
    (frames, simulation.digest())
}

fn named<'a>(frame: &'a MeshFrame, name: &str) -> &'a FrameField {
    frame.fields.iter().find(|field| field.name == name).unwrap()
}

fn greatest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// Returns the rest volume of a ring over 2π, m³.
fn ring(frame: &MeshFrame, cell: usize) -> f64 {
    let [a, b, c, _] = frame.cells.nodes[cell].map(|node| frame.points[node as usize]);
    (b - a).cross(&(c - a)).norm() / 2.0 * (a.x + b.x + c.x) / 3.0 / frame.cells.jacobian[cell]
}

const ALL: &str = "[\"pressure\", \"von_mises\", \"strain_rate\", \"viscous_strain\", \"damage\"]";

/// The calibration shot in coarse cells, with its remeshing.
fn shot(fields: &str) -> Scene {
    scene("fbi-bb", &[("scene.fidelity", "draft"), ("output.fields", fields)])
}

#[test]
fn fields_leave_no_trace_in_the_run_and_are_the_same_for_any_number_of_threads() {
    let (plain, digest) = run(&shot("[]"), 1, 12);
    let (frames, with_fields) = run(&shot(ALL), 1, 12);
    let (others, on_threads) = run(&shot(ALL), 3, 12);
    assert_eq!([with_fields, on_threads], [digest; 2]);
    assert!(frames == others, "the frames of one thread and of three");
    assert!(plain.iter().all(|frame| frame.fields.is_empty()));
    assert!(plain.iter().zip(&frames).all(|(plain, frame)| plain.points == frame.points && plain.cells == frame.cells));
}

#[test]
fn the_fields_of_a_shot_are_zero_at_rest_and_grow_where_the_ball_passes() {
    let (frames, _) = run(&shot(ALL), 1, 12);
    let names = ["pressure", "von_mises", "strain_rate", "viscous_strain", "damage"];
    for frame in &frames {
        assert_eq!(frame.fields.iter().map(|field| field.name).collect::<Vec<_>>(), names);
        for field in &frame.fields {
            assert_eq!([field.cells.len(), field.points.len()], [frame.cells.nodes.len(), frame.points.len()]);
            assert!(field.cells.iter().chain(&field.points).all(|value| value.is_finite()), "{}", field.name);
        }
    }
    let [start, middle, end] = [0, 4, 12].map(|i| &frames[i]);
    for name in names {
        assert_eq!(greatest(&named(start, name).cells), 0.0, "{name} at rest");
        assert!(greatest(&named(end, name).cells) > 0.0, "{name} after the impact");
    }
    // Remeshing averages, so that the greatest value of an element may fall; the integral over the gel at rest grows.
    for name in ["viscous_strain", "damage"] {
        let sum = |frame: &MeshFrame| -> f64 {
            named(frame, name).cells.iter().enumerate().map(|(cell, value)| value * ring(frame, cell)).sum()
        };
        assert!(sum(middle) > 0.0 && sum(end) > sum(middle), "{name}: {} then {}", sum(middle), sum(end));
    }
    assert_eq!(named(end, "damage").cells, end.cells.damage);
    assert!(greatest(&named(end, "damage").points) <= 1.0);
}

#[test]
fn the_pressure_of_a_node_is_that_of_a_sensor_in_a_quarter_and_in_the_whole() {
    let sensed = "[{ position = [0.0, 0.0, -0.01] }, { position = [0.005, 0.005, -0.005] }]";
    for symmetry in ["none", "quarter"] {
        let size = [("gel.symmetry", symmetry), ("output.fields", "[\"pressure\"]"), ("sensor", sensed)];
        let scene = scene("sphere-block", &size);
        let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
        let inputs = simulation.inputs();
        simulation.step(&inputs, 2e-3).unwrap();
        let (frame, sensors) = (simulation.frame(), simulation.sensors());
        for sensor in sensors {
            let place = |x: &ballistic_gel::math::Vector3| (x - sensor.position).norm();
            let near = |a: &usize, b: &usize| place(&frame.points[*a]).total_cmp(&place(&frame.points[*b]));
            let node = (0..frame.points.len()).min_by(near).unwrap();
            assert!(place(&frame.points[node]) < 1e-12, "a node at the sensor");
            let value = named(&frame, "pressure").points[node];
            assert!((value / sensor.pressure - 1.0).abs() < 1e-12 && value > 100.0, "{value}, {}", sensor.pressure);
        }
    }
}

#[test]
fn a_grid_holds_the_fields_of_its_elements_and_nodes() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = shot("[\"von_mises\", \"pressure\"]");
    (scene.output.frames, scene.output.report) = (2, false);
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
    let mut recorder = RunRecorder::create(folder.path(), &scene, DriverInterface::Direct, 1).unwrap();
    recorder.record(&simulation).unwrap();
    let inputs = simulation.inputs();
    simulation.step(&inputs, 60e-6).unwrap();
    recorder.finish(&simulation, None).unwrap();
    let (frame, file) = (simulation.frame(), std::fs::read(folder.path().join("frames/frame_00001.vtu")).unwrap());
    let single = |values: &[f64]| values.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect::<Vec<u8>>();
    for name in ["pressure", "von_mises"] {
        let arrays = grid::arrays(&file);
        let arrays: Vec<_> = arrays.iter().filter(|array| array.line.contains(&format!("\"{name}\""))).collect();
        let field = named(&frame, name);
        assert_eq!(arrays.len(), 2, "of the nodes, then of the elements");
        assert!(arrays[0].bytes == single(&field.points) && arrays[1].bytes == single(&field.cells), "{name}");
        assert!(greatest(&field.cells) > 1e3 && arrays[0].line.starts_with("<DataArray type=\"Float32\""));
    }
}
