//! Layers of a target in the results of a run: the table, the report and the console.

use crate::page::page_of;
use crate::shot;
use ballistic_gel::output::{DriverInterface, RunRecorder, result_names};
use ballistic_gel::scene::{self, LayerSpec, Scene};
use std::fs;
use std::path::Path;
use std::process::Command;

const HEAD: &str = "layer,depth_from_m,depth_to_m,density_kg_per_m3,entry_speed_m_per_s,energy_J,energy_fraction";

/// Row of `layers.csv`: name and numbers, NaN for an empty cell.
struct LayerRow {
    name: String,
    numbers: Vec<f64>,
}

fn rows(folder: &Path) -> Vec<LayerRow> {
    let text = fs::read_to_string(folder.join("layers.csv")).unwrap();
    assert_eq!(text.lines().next(), Some(HEAD));
    let number = |cell: &str| if cell.is_empty() { f64::NAN } else { cell.parse().unwrap() };
    let row = |line: &str| {
        let (name, numbers) = line.split_once(',').unwrap();
        LayerRow { name: name.to_owned(), numbers: numbers.split(',').map(number).collect() }
    };
    text.lines().skip(1).map(row).collect()
}

fn layers(text: &str) -> Vec<LayerSpec> {
    let table: toml::Table = text.parse().unwrap();
    table["layer"].clone().try_into().unwrap()
}

/// The ball of closed form, in a gel of 50 mm with a skin of 12 mm and a layer of 10 mm.
fn layered() -> Scene {
    let mut scene = shot::scene();
    let skin = "[[layer]]\nname = \"skin\"\nthickness = 0.012\ndensity = 1100.0\nshear_modulus = 138e3\n";
    scene.layer = layers(&format!("{skin}[[layer]]\nthickness = 0.01\n"));
    scene
}

/// Records the ball on `part` of its way.
fn recorded(name: &str, scene: &Scene, part: f64) -> std::path::PathBuf {
    let folder = shot::folder(name);
    let mut recorder = RunRecorder::create(&folder, scene, DriverInterface::Direct, 1).unwrap();
    shot::record(&mut recorder, scene, 0..=shot::STEPS, part);
    shot::conclude(&mut recorder, scene, part);
    folder
}

#[test]
fn speed_and_energy_of_each_layer_are_those_of_a_steady_force() {
    let folder = recorded("layered", &layered(), 1.0);
    let found = rows(&folder);
    assert_eq!(found.iter().map(|row| row.name.as_str()).collect::<Vec<_>>(), ["skin", "layer-2", "gel"]);
    let (force, end) = (shot::MASS * shot::SLOWING, shot::depth(shot::END));
    for (row, (from, to, density)) in
        found.iter().zip([(0.0, 0.012, 1100.0), (0.012, 0.022, 1030.0), (0.022, 0.05, 1030.0)])
    {
        let [depth_from, depth_to, own, speed, energy, part] = row.numbers[..] else { panic!("seven columns") };
        assert!((depth_from - from).abs() < 1e-12 && (depth_to - to).abs() < 1e-12 && own == density, "{from}");
        let expected = (shot::SPEED * shot::SPEED - 2.0 * shot::SLOWING * from).sqrt();
        assert!((speed / expected - 1.0).abs() < 1e-9, "{from}: {speed} m/s");
        assert!((energy - force * (to.min(end) - from)).abs() < 1e-9, "{from}: {energy} J");
        assert!((part - energy / (force * end)).abs() < 1e-9, "{from}: {part}");
    }
    let energies = &shot::summary(&folder)["energy_per_centimetre"];
    let total: f64 = energies.as_array().unwrap().iter().map(|energy| energy.as_f64().unwrap()).sum();
    let sum: f64 = found.iter().map(|row| row.numbers[4]).sum();
    assert!((sum / total - 1.0).abs() < 1e-12, "{sum} J, {total} J");
}

#[test]
fn the_report_has_a_table_of_the_layers_and_their_interfaces() {
    let page = page_of(&recorded("layered-page", &layered(), 1.0));
    let rows = [
        "<th scope=\"row\">skin</th><td>0–12 mm</td><td>–</td><td>1100 kg/m³</td><td>138 kPa</td><td>1.33 MPa</td>\
         <td>5.00 m/s</td><td>158 mJ</td><td>40.0 %</td>",
        "<th scope=\"row\">layer-2</th><td>12–22 mm</td>",
        "<th scope=\"row\">gel</th><td>22–50 mm</td>",
    ];
    for row in rows.iter().chain(&["interface of skin and layer-2", "interface of layer-2 and gel"]) {
        assert!(page.contains(row), "{row}: {page}");
    }
    assert_eq!(page.matches("class=\"interface\"").count(), 3);
    assert!(page.contains("layer[1].density"), "the inputs");
    let uniform = page_of(&recorded("uniform-page", &shot::scene(), 1.0));
    for mark in ["<figcaption>Layers<", "class=\"interface\"", "interface of"] {
        assert!(!uniform.contains(mark), "{mark}");
    }
}

#[test]
fn only_a_deep_shot_into_layers_has_their_table() {
    let [layered, uniform] = [layered(), shot::scene()];
    for (name, scene, part) in [("no-layers", &uniform, 1.0), ("shallow-layers", &layered, 0.1)] {
        assert!(!recorded(name, scene, part).join("layers.csv").exists(), "{name}");
    }
    let has = |scene: &Scene| result_names(scene).contains(&"layers.csv".to_owned());
    assert!(has(&layered) && !has(&uniform));
}

#[test]
fn a_layer_below_the_projectile_has_neither_speed_nor_energy() {
    let found = rows(&recorded("one-layer", &layered(), 0.5));
    // 15 mm deep.
    assert!(found[1].numbers[3].is_finite() && found[2].numbers[3].is_nan() && found[2].numbers[4] == 0.0);
    let page = page_of(&recorded("one-layer-page", &layered(), 0.5));
    assert!(page.contains("<td>–</td><td>0 J</td><td>0 %</td>"), "{page}");
}

/// Speed at the first arrival at a depth, m/s, from `history.csv`: v² is linear in depth between communication points.
fn speed_at(history: &Path, depth: f64) -> f64 {
    let text = fs::read_to_string(history).unwrap();
    let names: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let column = |name: &str| names.iter().position(|known| *known == name).unwrap();
    let [deep, fall, block] = ["depth_m", "velocity_z_m_per_s", "block_velocity_z_m_per_s"].map(column);
    let mut before = (f64::NAN, f64::NAN);
    for line in text.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        let now = (cells[deep], (cells[fall] - cells[block]).powi(2));
        if now.0 > depth {
            return (before.1 + (depth - before.0) / (now.0 - before.0) * (now.1 - before.1)).sqrt();
        }
        before = now;
    }
    f64::NAN
}

#[test]
fn a_run_into_two_layers_prints_and_writes_them() {
    let folder = tempfile::tempdir().unwrap();
    let layers = "\n[[layer]]\nname = \"skin\"\nthickness = 0.006\n[[layer]]\nthickness = 0.005\n";
    fs::write(folder.path().join("two.toml"), scene::builtin("fbi-bb").unwrap().to_owned() + layers).unwrap();
    let options = ["--direct", "--set=mesh.size=2e-3", "--set=scene.end_time=1.5e-4", "--out=shot"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelfmu"));
    let said = command.args(["run", "two.toml"]).args(options).current_dir(folder.path()).output().unwrap();
    let told = format!(
        "{}{}",
        String::from_utf8_lossy(&said.stdout),
        crate::lines::joined(&String::from_utf8_lossy(&said.stderr))
    );
    assert_eq!(said.status.code(), Some(0), "{told}");
    let shot = folder.path().join("shot");
    let (found, summary) = (rows(&shot), shot::summary(&shot));
    assert_eq!(found.len(), 3);
    for row in &found {
        let [from, _, _, speed, energy, _] = row.numbers[..] else { panic!("seven columns") };
        let expected = speed_at(&shot.join("history.csv"), from);
        assert!((speed / expected - 1.0).abs() < 1e-9 && energy > 0.0, "{}: {speed}, {expected}", row.name);
        // A row has two lines of 80 columns.
        let printed = told.split_once(&format!("│ in {} ", row.name)).map_or("", |(_, rest)| rest);
        let printed = printed.lines().take(2).collect::<Vec<_>>().join(" ");
        assert!(printed.contains(" m/s at entry, ") && printed.contains(" %)"), "{told}");
    }
    let energies = summary["energy_per_centimetre"].as_array().unwrap();
    let total: f64 = energies.iter().map(|energy| energy.as_f64().unwrap()).sum();
    let sum: f64 = found.iter().map(|row| row.numbers[4]).sum();
    assert!((sum / total - 1.0).abs() < 1e-9, "{sum} J, {total} J");
    assert!(told.contains("  layers.csv    speed at entry and energy of each layer"), "{told}");
    let page = fs::read_to_string(shot.join("report.html")).unwrap();
    let mut reader = quick_xml::Reader::from_str(&page);
    while reader.read_event().unwrap() != quick_xml::events::Event::Eof {}
    assert!(page.contains("<figcaption>Layers</figcaption>"));
    assert_eq!(crate::written::defect(&shot), Ok(()));
}
