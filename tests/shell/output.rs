//! The folder of a run, made from observations and frames written by hand.

#[path = "../output/extremes.rs"]
mod extremes;
#[path = "../output/fragments.rs"]
mod fragments;

use crate::page;
use crate::stage;
use crate::written;
use ballistic_gel::math::Vector3;
use ballistic_gel::output::{DriverInterface, FinalState, RunRecorder, model_picture};
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{MeshFrame, Observation};
use page::page_of;
use stage::{frame, observation, scene};
use std::{fs, path::Path, path::PathBuf};

const STEPS: usize = 50;
/// Keys of `summary.json` that scripts hold on to, in the order of the file.
const KEYS: [&str; 73] = [
    "ended_by",
    "perforated",
    "exit_velocity",
    "exit_time",
    "residual_energy",
    "energy_deposited",
    "expansion",
    "expanded_diameter",
    "expansion_work_fraction",
    "doubts",
    "scene",
    "version",
    "interface",
    "fidelity",
    "expected_error",
    "model_error",
    "completed",
    "end_time",
    "wall_seconds",
    "cpu_seconds",
    "serial_seconds",
    "parallel_seconds",
    "threads",
    "dimension",
    "elements",
    "nodes",
    "element_updates",
    "updates_per_second",
    "synchronous_updates",
    "smallest_step",
    "largest_step",
    "remeshes",
    "unconverged_solves",
    "incompatible_fraction",
    "overlapped_volume",
    "min_jacobian",
    "peak_depth",
    "time_of_peak_depth",
    "final_depth",
    "rebound_velocity",
    "final_velocity",
    "contact_duration",
    "peak_force",
    "force_window",
    "format",
    "total_impulse",
    "greatest_cavity_diameter",
    "time_of_greatest_cavity",
    "final_cavity_diameter",
    "cavity_still_opening",
    "rest_depth",
    "time_of_rest",
    "neck_length",
    "depth_of_greatest_cavity",
    "cavity_course",
    "time_of_cavity_collapse",
    "cavity_pulsation_diameter",
    "time_of_cavity_pulsation",
    "greatest_track_diameter",
    "energy_per_centimetre",
    "fragments",
    "sensors",
    "energy",
    "energy_error",
    "energy_defect",
    "momentum_error",
    "angular_momentum_error",
    "mass_error",
    "mean_standing_penetration",
    "digest",
    "switched_off",
    "failure",
    "doubt",
];

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("output").join(name)
}

/// A new folder: an earlier run of the tests may have left one.
fn new_folder(name: &str) -> PathBuf {
    let folder = folder(name);
    drop(fs::remove_dir_all(&folder));
    folder
}

fn time(scene: &Scene, step: usize) -> f64 {
    scene.scene.end_time * step as f64 / STEPS as f64
}

fn record(recorder: &mut RunRecorder, scene: &Scene, steps: std::ops::RangeInclusive<usize>) {
    for step in steps {
        let t = time(scene, step);
        recorder.record_observation(&observation(scene, t), || frame(scene, t)).unwrap();
    }
}

fn run(name: &str, scene: &Scene, failure: Option<&str>) -> PathBuf {
    let folder = new_folder(name);
    let mut recorder = RunRecorder::create(&folder, scene, DriverInterface::Direct, 2).unwrap();
    let last = if failure.is_some() { STEPS - 7 } else { STEPS };
    record(&mut recorder, scene, 0..=last);
    let (o, f): (Observation, MeshFrame) = (observation(scene, time(scene, last)), frame(scene, time(scene, last)));
    recorder.conclude(&FinalState { observation: &o, frame: &f, digest: 0xABC, failure }).unwrap();
    folder
}

fn lines(folder: &Path, file: &str) -> Vec<String> {
    fs::read_to_string(folder.join(file)).unwrap().lines().map(str::to_string).collect()
}

fn frames(folder: &Path) -> usize {
    fs::read_dir(folder.join("frames"))
        .unwrap()
        .filter(|entry| entry.as_ref().unwrap().file_name().to_string_lossy().starts_with("frame_"))
        .count()
}

/// The text between two marks.
fn between<'a>(text: &'a str, before: &str, after: &str) -> &'a str {
    text.split_once(before).and_then(|(_, rest)| rest.split_once(after)).unwrap().0
}

#[test]
fn history_has_a_row_per_step_that_reads_back_with_the_same_bits() {
    let scene = scene("spatial");
    let lines = lines(&run("history", &scene, None), "history.csv");
    assert!(lines[0].starts_with("time_s,position_x_m,position_y_m,position_z_m,velocity_x_m_per_s,"));
    assert_eq!(lines.len(), STEPS + 2);
    let columns: Vec<&str> = lines[0].split(',').collect();
    let column = |name: &str| columns.iter().position(|known| *known == name).unwrap();
    for (step, line) in lines[1..].iter().enumerate() {
        let values: Vec<f64> = line.split(',').map(|value| value.parse().unwrap()).collect();
        let expected = observation(&scene, time(&scene, step));
        assert_eq!(values.len(), columns.len());
        assert_eq!(values[column("time_s")], expected.time);
        assert_eq!(values[column("depth_m")], expected.projectile().depth);
        assert_eq!(values[column("velocity_z_m_per_s")], expected.projectile().kinematics.velocity.z);
        assert_eq!(
            values[column("force_z_N")],
            expected.projectile().exchange.impulse.z / expected.projectile().exchange.duration
        );
        assert_eq!(values[column("energy_elastic_J")], expected.energy.elastic);
    }
}

#[test]
fn rows_are_on_disk_before_the_run_ends() {
    let scene = scene("planar");
    let folder = new_folder("killed");
    let mut recorder = RunRecorder::create(&folder, &scene, DriverInterface::Fmi2, 1).unwrap();
    record(&mut recorder, &scene, 0..=20);
    assert_eq!(lines(&folder, "history.csv").len(), 22);
    assert_eq!(lines(&folder, "series.pvd").iter().filter(|line| line.contains("frame_")).count(), 5);
    drop(recorder);
}

#[test]
fn frames_are_taken_at_equally_spaced_times_and_listed_in_the_collection() {
    let scene = scene("spatial");
    let folder = run("frames", &scene, None);
    assert_eq!(frames(&folder), 11);
    let collection = fs::read_to_string(folder.join("series.pvd")).unwrap();
    let sets: Vec<&str> = collection.lines().filter(|line| line.starts_with("<DataSet")).collect();
    assert_eq!(sets.len(), 22);
    for (number, pair) in sets.chunks(2).enumerate() {
        let due: f64 = between(pair[0], "timestep=\"", "\"").parse().unwrap();
        assert!((due - 0.001 * number as f64).abs() < 1e-12);
        for set in pair {
            assert!(folder.join(between(set, "file=\"", "\"")).is_file(), "{set}");
        }
    }
}

/// The bytes of a named array of a grid.
fn array(file: &[u8], name: &str) -> Vec<u8> {
    let named = format!("Name=\"{name}\"");
    written::grid::arrays(file).into_iter().find(|array| array.line.contains(&named)).unwrap().bytes
}

#[test]
fn grids_hold_the_mesh_where_their_offsets_say() {
    let scene = scene("spatial");
    let file = fs::read(run("grid", &scene, None).join("frames/frame_00003.vtu")).unwrap();
    let frame = frame(&scene, time(&scene, 15));
    let head = String::from_utf8_lossy(&file[..600]).into_owned();
    let sizes = format!("NumberOfPoints=\"{}\" NumberOfCells=\"{}\"", frame.points.len(), frame.cells.nodes.len());
    assert!(head.contains(&sizes) && head.contains("byte_order=\"LittleEndian\" header_type=\"UInt64\""));
    let points: Vec<f64> =
        array(&file, "Points").chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
    assert!(points.chunks(3).zip(&frame.points).all(|(read, p)| Vector3::from_row_slice(read) == *p));
    assert_eq!(points.len(), 3 * frame.points.len());
    let nodes: Vec<u32> =
        array(&file, "connectivity").chunks(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect();
    assert_eq!(nodes, frame.cells.nodes.concat());
    let end = &array(&file, "offsets")[4 * (frame.cells.nodes.len() - 1)..];
    assert_eq!(end, (nodes.len() as u32).to_le_bytes());
    assert!(array(&file, "types").iter().all(|kind| *kind == 10));
    let steps: Vec<f32> = array(&file, "step").chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    assert!(steps.iter().zip(&frame.cells.step).all(|(read, step)| *read == *step as f32));
    assert_eq!(array(&file, "step_level").iter().max(), Some(&4));
    assert_eq!(array(&file, "TimeValue"), frame.time.to_le_bytes());
    assert!(file.ends_with(b"\n</AppendedData>\n</VTKFile>\n"));
}

#[test]
fn grids_of_two_dimensions_hold_triangles() {
    let file = fs::read(run("triangles", &scene("planar"), None).join("frames/frame_00000.vtu")).unwrap();
    assert!(array(&file, "types").iter().all(|kind| *kind == 5));
    assert_eq!(array(&file, "connectivity").len(), 4 * 3 * 2 * 12 * 12);
}

fn summary(folder: &Path) -> serde_json::Map<String, serde_json::Value> {
    serde_json::from_slice(&fs::read(folder.join("summary.json")).unwrap()).unwrap()
}

#[test]
fn summary_has_the_promised_keys_and_no_others() {
    let folder = run("summary", &scene("spatial"), None);
    let (mut keys, mut expected): (Vec<String>, Vec<&str>) =
        (summary(&folder).keys().cloned().collect(), KEYS.to_vec());
    keys.sort_unstable();
    expected.sort_unstable();
    assert_eq!(keys, expected);
}

#[test]
fn summary_tells_a_finished_run() {
    let summary = summary(&run("finished", &scene("spatial"), None));
    assert_eq!(summary["completed"], true);
    assert_eq!(summary["failure"], serde_json::Value::Null);
    assert_eq!(summary["interface"], "direct");
    assert_eq!(summary["digest"], "00000000000000000000000000000abc");
    assert_eq!(summary["peak_depth"], 0.014);
    assert_eq!(summary["force_window"], 1e-4);
    assert!((summary["rebound_velocity"].as_f64().unwrap() - 0.014 * std::f64::consts::PI / 0.01).abs() < 1e-12);
    assert!((summary["contact_duration"].as_f64().unwrap() - 0.0079).abs() < 1e-15);
    assert!(summary["mass_error"].as_f64().unwrap() < 1e-14);
    assert!(summary["switched_off"].as_array().unwrap().iter().any(|entry| entry == "gravity: none"));
    assert_eq!(summary["energy"].as_object().unwrap().len(), 22);
}

#[test]
fn a_run_that_stopped_keeps_what_it_computed_and_says_why() {
    let folder = run("stopped", &scene("spatial"), Some("element 7 is inverted: J < 0"));
    let summary = summary(&folder);
    assert_eq!(summary["completed"], false);
    assert_eq!(summary["failure"], "element 7 is inverted: J < 0");
    assert_eq!(summary["rebound_velocity"], serde_json::Value::Null);
    assert_eq!(frames(&folder), 10, "nine due frames and the last state");
    let page = page_of(&folder);
    assert!(page.contains("stopped early") && page.contains("element 7 is inverted: J &lt; 0"));
}

#[test]
fn rewinding_and_repeating_leaves_the_files_of_a_straight_run() {
    let scene = scene("axisymmetric");
    let straight = run("straight", &scene, None);
    let folder = new_folder("rewound");
    let mut recorder = RunRecorder::create(&folder, &scene, DriverInterface::Direct, 1).unwrap();
    record(&mut recorder, &scene, 0..=37);
    recorder.rewind(time(&scene, 12)).unwrap();
    assert_eq!((lines(&folder, "history.csv").len(), frames(&folder)), (14, 3));
    record(&mut recorder, &scene, 13..=STEPS);
    for file in ["history.csv", "series.pvd", "frames/frame_00004.vtu", "frames/projectile_00010.vtu"] {
        assert_eq!(fs::read(folder.join(file)).unwrap(), fs::read(straight.join(file)).unwrap(), "{file}");
    }
}

#[test]
fn a_new_run_removes_what_an_earlier_one_left() {
    let scene = scene("planar");
    let folder = run("again", &scene, None);
    fs::write(folder.join("notes.txt"), "mine").unwrap();
    let mut recorder = RunRecorder::create(&folder, &scene, DriverInterface::Direct, 1).unwrap();
    assert_eq!(frames(&folder), 11, "they are there until the new run has a record");
    record(&mut recorder, &scene, 0..=0);
    assert_eq!((frames(&folder), lines(&folder, "history.csv").len()), (1, 2));
    assert!(!folder.join("report.html").exists() && folder.join("notes.txt").exists());
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let inside = file.path().join("run");
    let error = RunRecorder::create(&inside, &scene("planar"), DriverInterface::Direct, 1).unwrap_err();
    assert!(error.to_string().contains(&inside.display().to_string()), "{error}");
}

#[cfg(feature = "cli")]
#[test]
fn reports_are_well_formed_and_need_nothing_from_outside() {
    for dimension in ["planar", "axisymmetric", "spatial"] {
        let page = page_of(&run(&format!("report-{dimension}"), &scene(dimension), None));
        let mut reader = quick_xml::Reader::from_str(&page);
        while reader.read_event().unwrap() != quick_xml::events::Event::Eof {}
        assert_eq!(page.matches("<div class=\"still\"").count(), 5, "position, velocity, force, energy, closure");
        assert_eq!(
            page.matches("src=\"data:image/png;base64,").count(),
            12,
            "two pictures of every second of eleven frames"
        );
        let closed = "integrator, contact, energy, cost, switched off";
        let tables = page.matches("<table>").count();
        assert!((9..=11).contains(&tables), "{tables}: shot, projectile, gel, run, mesh, {closed}");
        assert!(page.contains("id=\"view-data\"") && page.contains("id=\"page-script\""), "the view and its script");
        assert!(page.contains("14.0 mm") && page.contains("&lt; dents &gt; a gel &amp; leaves"));
        for outside in ["src=\"http", "href=", "url(", "@import"] {
            assert!(!page.contains(outside), "{outside}");
        }
    }
}

/// Width, height and pixels (red, green, blue, opacity) of a PNG file.
fn pixels(file: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.width, info.height, pixels)
}

#[test]
fn the_model_picture_shows_gel_and_projectile() {
    for dimension in ["planar", "axisymmetric", "spatial"] {
        let scene = scene(dimension);
        let file = model_picture(&frame(&scene, 0.005), &scene);
        fs::create_dir_all(folder("models")).unwrap();
        fs::write(folder("models").join(format!("{dimension}.png")), &file).unwrap();
        let (width, height, pixels) = pixels(&file);
        assert_eq!((width, height), (600, 450));
        let opaque: Vec<&[u8]> = pixels.chunks(4).filter(|pixel| pixel[3] == 255).collect();
        let amber = opaque.iter().filter(|pixel| pixel[0] > pixel[2].saturating_add(40)).count();
        let steel = opaque.iter().filter(|pixel| pixel[2] >= pixel[0] && pixel[2] > 40).count();
        assert!(amber > 60_000 && steel > 2_000, "{dimension}: {amber} pixels of gel, {steel} of the projectile");
        assert!(opaque.len() < 600 * 450 * 9 / 10, "the background is clear");
    }
}

#[test]
fn a_slice_without_thickness_says_per_metre_and_one_with_a_thickness_does_not() {
    let mut scene = scene("planar");
    let page = |name: &str, scene: &Scene| page_of(&run(name, scene, None));

    scene.gel.thickness = None;
    let per_metre = page("per-metre", &scene);
    assert!(per_metre.contains(" N per metre of thickness (mean over"), "the sentence");
    assert!(per_metre.contains("<dt>peak force, mean over 100 µs</dt>"), "the label has the window");
    assert!(per_metre.contains("N per metre of thickness</dd>"));
    scene.gel.thickness = Some(0.1);
    assert!(!page("thick", &scene).contains("per metre of thickness"));
}

#[test]
fn every_chart_reaches_to_the_end_of_the_run() {
    let scene = scene("spatial");
    let page = page_of(&run("last-label", &scene, None));
    let charts: Vec<&str> = page.split("<figure class=\"plot\">").skip(1).collect();
    assert!(charts.len() > 3);
    let labels = |chart: &str| -> Vec<String> {
        chart
            .split("text-anchor=\"middle\"")
            .skip(1)
            .map(|t| t.split(['<', '>']).nth(1).unwrap().trim().to_owned())
            .collect()
    };
    let first = labels(charts[0]);
    assert!(!first.is_empty());
    for chart in charts {
        assert_eq!(labels(chart).last(), first.last());
    }
}

/// A run with a dome that takes part and a splinter that does not.
fn run_with_fragments(name: &str) -> (Scene, PathBuf) {
    let (scene, folder) = (fragments::scene(), new_folder(name));
    let mut recorder = RunRecorder::create(&folder, &scene, DriverInterface::Direct, 2).unwrap();
    for step in 0..=STEPS {
        let t = time(&scene, step);
        recorder
            .record_observation(&fragments::observation(&scene, t), || fragments::frame(&scene, t, step > STEPS / 2))
            .unwrap();
    }
    let end = time(&scene, STEPS);
    let (o, f) = (fragments::observation(&scene, end), fragments::frame(&scene, end, false));
    recorder.conclude(&FinalState { observation: &o, frame: &f, digest: 0xABC, failure: None }).unwrap();
    (scene, folder)
}

#[test]
fn history_has_the_columns_of_each_fragment() {
    let (scene, folder) = run_with_fragments("fragments-history");
    let lines = lines(&folder, "history.csv");
    let columns: Vec<&str> = lines[0].split(',').collect();
    let values: Vec<f64> = lines[21].split(',').map(|value| value.parse().unwrap()).collect();
    let own = columns.iter().filter(|name| name.starts_with("fragment")).count();
    assert_eq!((columns.len(), own), (values.len(), 2 * 24), "twenty-four columns of each");
    let value = |name: &str| values[columns.iter().position(|known| *known == name).unwrap()];
    let t = time(&scene, 20);
    for (name, expected) in [
        ("fragment1_active", 1.0),
        ("fragment2_active", 0.0),
        ("fragment1_depth_m", 0.006 + 0.4 * t),
        ("fragment2_depth_m", -0.015),
        ("fragment2_position_x_m", 0.03),
        ("fragment2_velocity_z_m_per_s", -4.0),
        ("fragment1_orientation_w", 1.0),
        ("fragment2_orientation_y", std::f64::consts::FRAC_1_SQRT_2),
        ("fragment2_orientation_z", 0.0),
        ("fragment2_angular_velocity_x_rad_per_s", 7.0),
        ("fragment2_angular_velocity_z_rad_per_s", 9.0),
        ("fragment1_yaw_rad", 0.0),
        ("fragment1_impulse_y_N_s", 2e-4),
        ("fragment1_bulge_height_m", 0.006 + 0.4 * t),
        ("fragment1_bulge_radius_m", 0.016 + 0.2 * t),
        ("fragment1_bulge_height_impulse_N_s", -4e-4),
        ("fragment1_bulge_radius_impulse_N_s", -5e-4),
        ("fragment2_bulge_radius_m", 0.0),
        ("fragment2_bulge_height_impulse_N_s", 0.0),
    ] {
        assert_eq!(value(name), expected, "{name}");
    }
    let yaw = value("fragment2_yaw_rad");
    assert!((yaw - 4.0_f64.atan2(-3.0)).abs() < 1e-15, "its nose towards −x, it flies towards +x and −z: {yaw}");
}

#[test]
fn summary_and_report_tell_what_became_of_each_fragment() {
    let (scene, folder) = run_with_fragments("fragments-summary");
    let figures = summary(&folder)["fragments"].clone();
    assert_eq!(figures.as_array().map(Vec::len), Some(2));
    let depth = 0.006 + 0.4 * scene.scene.end_time;
    assert_eq!((&figures[0]["active"], &figures[1]["active"]), (&true.into(), &false.into()));
    assert_eq!((&figures[0]["final_depth"], &figures[1]["final_depth"]), (&depth.into(), &(-0.015).into()));
    assert_eq!((&figures[0]["peak_depth"], &figures[1]["peak_depth"]), (&0.0125.into(), &0.0.into()));
    assert_eq!((&figures[0]["peak_force"], &figures[1]["peak_force"]), (&12.5.into(), &0.0.into()));
    assert_eq!(figures[1]["final_velocity"], serde_json::json!([3.0, 0.0, -4.0]));
    assert_eq!(figures[0]["total_impulse"], serde_json::json!([0.03, 0.0, 0.04]));
    let page = page_of(&folder);
    assert!(page.contains("There are 2 fragments beside the projectile, 1 of 2 active at the end."));
    let row = |cells: &str| format!("<tr><th scope=\"row\">fragment[{cells}</td></tr>").replace('|', "</td><td>");
    let one = row("1]</th><td>active|12.5 mm|10.0 mm|0 m/s|12.5 N|50.0 mN s");
    let two = row("2]</th><td>inactive|0 m|−15.0 mm|5.00 m/s|0 N|0 N s");
    assert!(page.contains(&one) && page.contains(&two), "{}", between(&page, "<h2>Fragments</h2>", "</section>"));
    let without = page_of(&run("no-fragments", &self::scene("spatial"), None));
    assert!(!without.contains("fragment["));
}

#[test]
fn only_bodies_that_take_part_are_drawn() {
    let (scene, folder) = run_with_fragments("fragments-grid");
    let points = |number: usize| -> Vec<Vector3> {
        let file = fs::read(folder.join(format!("frames/projectile_{number:05}.vtu"))).unwrap();
        let values: Vec<f64> =
            array(&file, "Points").chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
        values.chunks(3).map(Vector3::from_row_slice).collect()
    };
    let splinter =
        |points: &[Vector3]| points.iter().filter(|p| (*p - Vector3::new(0.03, 0.0, 0.02)).norm() < 0.006).count();
    let lowest = |points: &[Vector3]| points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let (before, after) = (points(0), points(10));
    assert_eq!(splinter(&before), 0, "it waits");
    assert_eq!(splinter(&after), after.len() - before.len(), "it is there");
    assert!(after.len() > before.len() + 100);
    let apex = 0.006 + 0.4 * time(&scene, STEPS);
    assert!((lowest(&after) + apex).abs() < 1e-12, "the dome is drawn with the bulge of the frame");
    let alone = fs::read(run("grid-alone", &self::scene("spatial"), None).join("frames/projectile_00000.vtu")).unwrap();
    assert!(before.len() > array(&alone, "Points").len() / 24, "the dome beside the ball");
}

#[test]
fn a_dome_does_not_hide_the_gel() {
    let scene = fragments::scene();
    let file = model_picture(&fragments::frame(&scene, 0.005, false), &scene);
    fs::create_dir_all(folder("models")).unwrap();
    fs::write(folder("models").join("dome.png"), &file).unwrap();
    let (_, _, pixels) = pixels(&file);
    let amber = pixels.chunks(4).filter(|p| p[3] == 255 && p[0] > p[2].saturating_add(40)).count();
    assert!(amber > 60_000, "{amber} pixels of gel");
}
