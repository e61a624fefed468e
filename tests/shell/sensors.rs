//! Sensors in the gel: waves, hydrostatic pressure, remeshing, files.

use crate::page;
use ballistic_gel::output::{DriverInterface, RunRecorder};
use ballistic_gel::scene::{self, Scene};
use ballistic_gel::simulation::{CouplingMode, SensorReport, Simulation};
use page::page_of;
use std::path::Path;

const DENSITY: f64 = 1000.0;

/// A gel of this shape and matter that no body meets.
fn gel(space: &str, rest: &str) -> Scene {
    let text = format!(
        "[scene]\nname = \"sensed\"\n{space}\ndensity = {DENSITY:?}\n[projectile]\nshape.half-space.normal = [0.0, 0.0, -1.0]\n\
         fixed = true\nactive = false\nposition = [0.0, 0.0, 1.0]\n{rest}"
    );
    scene::read(&text).unwrap_or_else(|error| panic!("{error}"))
}

/// What the sensors see after each communication step.
fn run(scene: &Scene) -> Vec<(f64, Vec<SensorReport>)> {
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let n = (scene.scene.end_time / scene.scene.communication_step).round() as u32;
    let step = |k: u32| {
        let inputs = simulation.inputs();
        simulation.step(&inputs, f64::from(k) * scene.scene.communication_step).expect("a gel that bears it");
        (simulation.time(), simulation.sensors())
    };
    (1..=n).map(step).collect()
}

/// A column between smooth walls, sensors 20 mm deep on its axis and 50.5 mm deep beside it.
const COLUMN: &str = "dimension = \"axisymmetric\"\nend_time = 60e-6\ncommunication_step = 0.5e-6\n[gel]\n\
     shape.cylinder = { radius = 4e-3, height = 0.1 }\nsupports.side = \"roller\"\nshear_modulus = 60e3\nbulk_modulus = 2.25e9\n";
const DEPTHS: [f64; 2] = [20e-3, 50.5e-3];
const ALONG: &str =
    "[[sensor]]\nposition = [0.0, 0.0, -0.02]\n[[sensor]]\nposition = [1e-3, 0.0, -0.0505]\n[mesh]\nsize = 1e-3\n";

/// Speed of the plane wave, √((K + 4/3 μ)/ρ), m/s.
fn sound() -> f64 {
    ((2.25e9 + 4.0 / 3.0 * 60e3) / DENSITY).sqrt()
}

#[test]
fn a_plate_that_strikes_a_column_gives_it_the_pressure_rho_c_v_and_the_wave_comes_when_it_should() {
    let struck = format!("{COLUMN}material = \"two-network\"\nviscosity = {{ linear = 0.3 }}");
    let mut scene = gel(&struck, &format!("{ALONG}element = \"patch\"\n"));
    let plate = &mut scene.projectile;
    (plate.fixed, plate.active, plate.position, plate.velocity) = (false, true, [0.0; 3], [0.0, 0.0, -1.0]);
    (plate.mass, plate.inertia) = (Some(1e3), Some([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]));
    let seen = run(&scene);
    let expected = DENSITY * sound();
    for (i, depth) in DEPTHS.into_iter().enumerate() {
        let half = seen.windows(2).find(|pair| pair[1].1[i].pressure > 0.5 * expected).expect("a wave");
        let [(before, below), (after, above)] = [0, 1].map(|k| (half[k].0, half[k].1[i].pressure));
        let arrival = before + (0.5 * expected - below) / (above - below) * (after - before);
        assert!((arrival * sound() / depth - 1.0).abs() < 0.01, "{arrival} s to {depth} m");
        let behind: Vec<_> = seen.iter().filter(|row| row.0 > arrival + 4e-6).map(|row| row.1[i]).collect();
        let mean = behind.iter().map(|sensor| sensor.pressure).sum::<f64>() / behind.len() as f64;
        assert!((mean / expected - 1.0).abs() < 0.01, "{mean} Pa at {depth} m, expected {expected}");
        let speed = behind.iter().map(|sensor| -sensor.velocity.z).sum::<f64>() / behind.len() as f64;
        assert!((speed - 1.0).abs() < 0.01, "{speed} m/s");
    }
}

#[test]
fn a_pressure_that_rises_evenly_on_a_column_is_felt_later_and_deeper_as_it_was() {
    let (pressure, ramp) = (1.5e6, 10e-6);
    let load = format!("[[load]]\non = \"z_max\"\npressure = {pressure:?}\nramp = {ramp:?}\n");
    let scene = gel(&format!("{COLUMN}material = \"neo-hookean\""), &format!("{load}{ALONG}"));
    for (time, sensors) in run(&scene) {
        for (sensor, depth) in sensors.iter().zip(DEPTHS) {
            let expected = pressure * ((time - depth / sound()) / ramp).clamp(0.0, 1.0);
            assert!((sensor.pressure - expected).abs() < 0.03 * pressure, "{} at {time} s", sensor.pressure);
        }
    }
}

#[test]
fn under_a_pressure_from_all_sides_every_sensor_feels_it_on_the_surface_too() {
    let pressed = |space: &str, points: [&str; 3]| {
        let sensors = points.map(|point| format!("[[sensor]]\nposition = {point}\n")).concat();
        let matter = "material = \"neo-hookean\"\nshear_modulus = 30e3\nbulk_modulus = 3e6";
        let space =
            format!("{space}\n{matter}").replacen("[gel]", "end_time = 20e-3\ncommunication_step = 20e-3\n[gel]", 1);
        let rest = "[[load]]\npressure = 20e3\nramp = 5e-3\n[mesh]\nsize = 4e-3\nelement = \"patch\"\n[integrator]\ndamping = 1000.0\n";
        let [(_, seen)] = run(&gel(&space, &(sensors + rest))).try_into().expect("one step");
        for (sensor, point) in seen.iter().zip(points) {
            assert!((sensor.pressure / 20e3 - 1.0).abs() < 0.01, "{} Pa at {point}", sensor.pressure);
        }
    };
    let flat = ["[0, 0, 0]", "[0.0137, 0, -0.0211]", "[0.02, 0, -0.03]"];
    pressed("dimension = \"planar\"\n[gel]\nshape.block.size = [0.04, 0.03]", flat);
    pressed("dimension = \"axisymmetric\"\n[gel]\nshape.cylinder = { radius = 0.02, height = 0.03 }", flat);
    let solid = ["[0, 0, 0]", "[0.0037, -0.0041, -0.0111]", "[0.01, 0.01, -0.02]"];
    pressed("dimension = \"spatial\"\n[gel]\nshape.block.size = [0.02, 0.02, 0.02]", solid);
}

const BALL: &str = "[scene]\nname = \"followed\"\ndimension = \"axisymmetric\"\nend_time = 6e-3\ncommunication_step = 50e-6\n[gel]\n\
     shape.cylinder = { radius = 0.05, height = 0.05 }\nmaterial = \"neo-hookean\"\ndensity = 1000.0\nshear_modulus = 30e3\n\
     bulk_modulus = 300e3\nsupports.z_min = \"fixed\"\n[projectile]\nshape.sphere.radius = 0.01\nmass = 0.033\n\
     position = [0.0, 0.0, 0.01]\nvelocity = [0.0, 0.0, -4.0]\n[[sensor]]\nposition = [0.0, 0.0, 0.0]\n\
     [[sensor]]\nposition = [0.004, 0.0, -0.013]\n[mesh]\nsize = 2e-3\nelement = \"patch\"\n";

fn ball(rest: &str) -> Scene {
    scene::read(&format!("{BALL}{rest}")).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_sensor_follows_its_gel_through_remeshings() {
    let still = run(&ball(""));
    let remeshed = run(&ball("[remesh]\nquality = 0.0\nmin_volume_ratio = 0.0\ntimes = [2e-3, 4e-3]\n"));
    let deepest = 7.6e-3;
    for ((time, still), (_, remeshed)) in still.iter().zip(&remeshed) {
        for (a, b) in still.iter().zip(remeshed) {
            assert!((a.displacement - b.displacement).norm() < 0.02 * deepest, "at {time} s: {a:?} {b:?}");
            assert!((b.position - b.displacement - a.position + a.displacement).norm() < 1e-15, "its point at rest");
        }
    }
    let last = &still[still.len() - 1].1[1];
    assert!((last.displacement.norm() - deepest).abs() < 0.05 * deepest, "{last:?}");
}

#[test]
fn a_state_that_is_taken_up_again_on_another_mesh_has_its_sensors_there() {
    let scene = ball("[remesh]\nquality = 0.0\nmin_volume_ratio = 0.0\ntimes = [1e-3]\n");
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let step = |simulation: &mut Simulation, end: f64| {
        let inputs = simulation.inputs();
        simulation.step(&inputs, end).expect("a gel that bears it");
        simulation.sensors()
    };
    let early = step(&mut simulation, 0.5e-3);
    let mut first = ballistic_gel::simulation::SavedSimulation::empty();
    simulation.save_into(&mut first);
    let late = step(&mut simulation, 1.5e-3);
    simulation.restore(&first).expect("its own state");
    assert_eq!(simulation.sensors(), early);
    assert_eq!(step(&mut simulation, 1.5e-3), late);
}

#[test]
fn a_sensor_in_the_mirrored_part_measures_the_image_of_its_gel() {
    let block = "[scene]\nname = \"felt\"\ndimension = \"spatial\"\nend_time = 2e-3\ncommunication_step = 0.5e-3\n\
         [gel]\nshape.block.size = [0.08, 0.08, 0.04]\nmaterial = \"neo-hookean\"\ndensity = 1000.0\n\
         shear_modulus = 30e3\nbulk_modulus = 300e3\nsymmetry = \"quarter\"\n[projectile]\nshape.sphere.radius = 0.01\n\
         mass = 0.033\nposition = [0.0, 0.0, 0.01]\nvelocity = [0.0, 0.0, -4.0]\n[mesh]\nsize = 5e-3\n";
    let at = |x: f64, y: f64| format!("[[sensor]]\nposition = [{x}, {y}, -0.01]\n");
    let places = [at(0.02, 0.01), at(-0.02, 0.01), at(0.02, -0.01), at(-0.02, -0.01)].concat();
    let scene = scene::read(&format!("{block}{places}")).unwrap_or_else(|error| panic!("{error}"));
    for (_, felt) in run(&scene) {
        for (image, [x, y]) in felt.iter().zip([[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]) {
            let side = ballistic_gel::math::Vector3::new(x, y, 1.0);
            assert_eq!(image.pressure, felt[0].pressure);
            assert_eq!(image.displacement, felt[0].displacement.component_mul(&side));
            assert_eq!(image.velocity, felt[0].velocity.component_mul(&side));
            assert_eq!(image.position, felt[0].position.component_mul(&side));
        }
        assert!(felt[0].position.x > 0.0 && felt[0].position.y > 0.0);
    }
    let last = run(&scene).pop().expect("rows").1[0].displacement;
    assert!(last.iter().all(|part| part.abs() > 1e-6), "{last}");
}

#[test]
fn files_of_a_run_have_its_sensors() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sensors");
    drop(std::fs::remove_dir_all(&folder));
    let scene = ball("");
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let mut recorder = RunRecorder::create(&folder, &scene, DriverInterface::Direct, 1).expect("a folder");
    recorder.record(&simulation).expect("a row");
    let (mut greatest, mut deepest) = (0.0_f64, 0.0_f64);
    for k in 1..=40 {
        let inputs = simulation.inputs();
        simulation.step(&inputs, f64::from(k) * 5e-5).expect("a gel that bears it");
        let seen = simulation.sensors();
        (greatest, deepest) = (greatest.max(seen[1].pressure), deepest.max(-seen[0].displacement.z));
        recorder.record(&simulation).expect("a row");
    }
    recorder.finish(&simulation, None).expect("its files");
    let text = |name: &str| std::fs::read_to_string(folder.join(name)).expect(name);
    let history = text("history.csv");
    assert!(history.lines().next().expect("a header").ends_with("sensor2_velocity_z_m_per_s"));
    let last = history.lines().last().and_then(|row| row.split(',').nth_back(6)).expect("a column");
    assert_eq!(last.parse::<f64>().expect("a number"), simulation.sensors()[1].pressure);
    let summary: serde_json::Value = serde_json::from_str(&text("summary.json")).expect("JSON");
    let [first, second] = [0, 1].map(|i| &summary["sensors"][i]);
    assert_eq!(second["peak_pressure"].as_f64(), Some(greatest));
    assert_eq!((second["position"][2].as_f64(), &second["dent"]), (Some(-0.013), &serde_json::Value::Null));
    assert_eq!(first["dent"]["depth"].as_f64(), Some(deepest));
    assert!(first["dent"]["viscous_criterion"].as_f64().expect("a number") > 0.0);
    let page = page_of(&folder);
    assert!(page.contains("Pressure at the sensors") && page.contains("sensor[2]"));
}
