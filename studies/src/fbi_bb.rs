//! The two-network gel: limit of its depth under refinement, fit, validation, forces and air.

use super::run::scene;
use ballistic_gel::output::{DriverInterface, FinalState, RunRecorder, RunSummary};
use ballistic_gel::simulation::{CouplingMode, Simulation};
use std::path::Path;

/// Keys of a scene and what they are instead.
type Keys = Vec<(&'static str, String)>;

/// Cells: name, size, its growth at the start, least size and growth.
const MESHES: [(&str, [&str; 4]); 4] = [
    ("R/8", ["0.27e-3", "0.15", "0.135e-3", "0.1"]),
    ("R/11", ["0.1909e-3", "0.1061", "95.46e-6", "0.07071"]),
    ("R/16", ["0.135e-3", "0.075", "67.5e-6", "0.05"]),
    ("R/23", ["95.46e-6", "0.05303", "47.73e-6", "0.03536"]),
];
const REFINED: [&str; 4] = ["mesh.size", "mesh.tree.slope", "remesh.smallest", "remesh.growth"];
/// End of a shot of the BB, by which it rests, s.
const BB_END: f64 = 8e-3;
/// Communication step, s.
const STEP: f64 = 2e-5;
/// Sectional area, m², and mass, kg, of the BB; density of the gel, kg/m³.
const AREA: f64 = std::f64::consts::PI * 2.185e-3 * 2.185e-3;
const MASS: f64 = 0.343e-3;
const DENSITY: f64 = 1030.0;

/// A finished shot.
struct Shot {
    summary: RunSummary,
    /// Nose at every communication step: time, s, depth, m, and speed, m/s.
    way: Vec<[f64; 3]>,
    /// Rows of `cavity.csv`: time, s, depth, m, and diameter, m.
    cavity: Vec<[f64; 3]>,
}

impl Shot {
    fn fly(name: &str, keys: &Keys) -> Self {
        let scene = scene(name, keys);
        let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
        let folder = tempfile::tempdir().expect("a folder of its own");
        let mut recorder =
            RunRecorder::create(folder.path(), &scene, DriverInterface::Direct, 1).expect("a run's folder");
        recorder.record(&simulation).expect("a row of history");
        let mut way = vec![];
        for step in 1..=(scene.scene.end_time / STEP).round() as u32 {
            let inputs = simulation.inputs();
            let end = simulation.step(&inputs, STEP * f64::from(step));
            recorder.record(&simulation).expect("a row of history");
            way.push([simulation.time(), simulation.depth(0), -simulation.kinematics(0).velocity.z]);
            if let Err(why) = end {
                eprintln!("{name} {keys:?}: {why}");
                break;
            }
        }
        let (observation, frame) = (&simulation.observe(), &simulation.frame());
        let ending = FinalState { observation, frame, digest: simulation.digest(), failure: None };
        let summary = recorder.conclude(&ending).expect("a summary");
        Self { summary, way, cavity: cavity(folder.path()) }
    }

    fn bb(speed: f64, mesh: usize, more: &[(&'static str, &str)]) -> Self {
        let mut keys: Keys = vec![
            ("projectile.velocity", format!("[0, 0, {}]", -speed)),
            ("scene.end_time", BB_END.to_string()),
            ("scene.communication_step", STEP.to_string()),
        ];
        keys.extend(REFINED.iter().zip(MESHES[mesh].1).map(|(key, value)| (*key, value.to_owned())));
        keys.extend(more.iter().map(|(key, value)| (*key, (*value).to_owned())));
        Self::fly("fbi-bb", &keys)
    }

    /// A steel sphere into the block of `sphere-720`, with cells of R/8.
    fn sphere(diameter: f64, speed: f64, end: f64, more: &[(&'static str, &str)]) -> Self {
        let (radius, mass) = (0.5 * diameter, 7850.0 * std::f64::consts::PI / 6.0 * diameter.powi(3));
        let mut keys: Keys = vec![
            ("projectile.shape.sphere.radius", radius.to_string()),
            ("projectile.mass", mass.to_string()),
            ("projectile.position", format!("[0, 0, {radius}]")),
            ("projectile.velocity", format!("[0, 0, {}]", -speed)),
            ("scene.end_time", end.to_string()),
            ("scene.communication_step", STEP.to_string()),
            ("mesh.size", (radius / 8.0).to_string()),
            ("remesh.smallest", (radius / 16.0).to_string()),
        ];
        keys.extend(more.iter().map(|(key, value)| (*key, (*value).to_owned())));
        Self::fly("sphere-720", &keys)
    }

    fn rest(&self) -> f64 {
        self.summary.wound.rest_depth.unwrap_or(f64::NAN)
    }

    /// Greatest diameter of the cavity in a range of times, s, and depths, m: the diameter, m, and its time, s.
    fn widest(&self, times: [f64; 2], depths: [f64; 2]) -> [f64; 2] {
        let is_in =
            |row: &&[f64; 3]| (times[0]..=times[1]).contains(&row[0]) && (depths[0]..=depths[1]).contains(&row[1]);
        let found = self.cavity.iter().filter(is_in).max_by(|a, b| a[2].total_cmp(&b[2]));
        found.map_or([0.0; 2], |row| [row[2], row[0]])
    }

    /// Depth of the nose at a time, s.
    fn nose(&self, time: f64) -> f64 {
        let near = |a: &[f64; 3]| (a[0] - time).abs();
        self.way.iter().min_by(|a, b| near(a).total_cmp(&near(b))).map_or(f64::NAN, |look| look[1])
    }

    /// Cells of a row: peak depth and its time, rest depth and its time, the greatest cavity and its time.
    fn cells(&self) -> String {
        let (s, wound) = (&self.summary, &self.summary.wound);
        let told = |value: Option<f64>, digits: usize| {
            value.map_or("–".to_owned(), |value| format!("{:.digits$}", 1e3 * value))
        };
        format!(
            "{:.2} | {:.2} | {} | {} | {} | {}",
            1e3 * s.peak_depth,
            1e3 * s.time_of_peak_depth,
            told(wound.rest_depth, 2),
            told(wound.time_of_rest, 1),
            told(s.wound.greatest_cavity_diameter, 2),
            told(s.wound.time_of_greatest_cavity, 2)
        )
    }
}

fn cavity(folder: &Path) -> Vec<[f64; 3]> {
    let text = std::fs::read_to_string(folder.join("cavity.csv")).unwrap_or_default();
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        [cells[0], cells[1], cells[3]]
    };
    text.lines().skip(1).map(row).collect()
}

const CELLS: &str = "peak depth, mm | at, ms | rest depth, mm | from, ms | cavity, mm | at, ms";

/// Limit, fit, validation and forces.
pub fn study() {
    let standard = meshes();
    let [slow, fast] = [165.0, 195.0].map(|speed| Shot::bb(speed, 1, &[]));
    let shots = FittedShots { standard, slow, fast, sphere: Shot::sphere(4.8e-3, 720.0, 4.5e-3, &[]) };
    fit(&shots);
    validation(&shots);
    forces(&shots.standard);
}

/// Shots that the gel was fitted to: the BB in cells of R/16, at 165 and 195 m/s in cells of R/11, and 4.8 mm at 720 m/s.
struct FittedShots {
    standard: Shot,
    slow: Shot,
    fast: Shot,
    sphere: Shot,
}

/// Depth by mesh and by the rule of transfer; returns the shot in cells of R/16.
fn meshes() -> Shot {
    println!("\nBB of 179.8 m/s by mesh and by the rule of the averages\n");
    println!("| averages | cells | {CELLS} | at a depth of 30 mm: greatest, mm | at 2 ms | M updates |");
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    let mut fitted = None;
    for (rule, n) in [("stored-energy", 4), ("normalised-mean", 3)] {
        for (mesh, (cells, _)) in MESHES.iter().enumerate().take(n) {
            let shot = Shot::bb(179.8, mesh, &[("remesh.elastic_average", rule)]);
            let here = [0.0295, 0.0305];
            println!(
                "| {rule} | {cells} | {} | {:.2} | {:.2} | {:.1} |",
                shot.cells(),
                1e3 * shot.widest([0.0, BB_END], here)[0],
                1e3 * shot.widest([1.95e-3, 2.05e-3], here)[0],
                1e-6 * shot.summary.element_updates
            );
            if (rule, *cells) == ("stored-energy", "R/16") {
                fitted = Some(shot);
            }
        }
    }
    fitted.expect("R/16 is among the meshes")
}

/// Fit: windows and computed values.
fn fit(shots: &FittedShots) {
    let slope = 1e3 * (shots.fast.rest() - shots.slow.rest()) / 30.0;
    println!("\nFit\n");
    println!("| | window | the window is | computed |");
    println!("|---|---|---|---|");
    println!(
        "| BB of 179.8 m/s, rest depth in cells of R/16, mm | 85 ± 0.5 | measured (grade B), 85 ± 10 | {:.2} |",
        1e3 * shots.standard.rest()
    );
    println!("| rest depth by speed from 165 to 195 m/s, mm per m/s | 0.46 to 0.58 | derived | {slope:.3} |");
    println!(
        "| 4.8 mm at 720 m/s, greatest cavity, mm | 38 to 66 | derived | {:.2} |",
        1e3 * shots.sphere.summary.wound.greatest_cavity_diameter.unwrap_or(f64::NAN)
    );
}

/// Depth of Poncelet's law of `drag` and `strength`, Pa, in which the BB of 179.8 m/s stops at 85 mm, for another sphere, m.
fn poncelet(drag: f64, strength: f64, diameter: f64, mass: f64, speed: f64) -> f64 {
    let (area, b) = (std::f64::consts::PI * 0.25 * diameter * diameter, 0.5 * DENSITY * drag);
    mass / (2.0 * b * area) * (b * speed * speed / strength).ln_1p()
}

/// Shots beside laws that are drawn through the calibration shot; what the gel is fitted to is marked.
fn validation(shots: &FittedShots) {
    println!(
        "\nOther speeds and calibres (nothing fitted but what is marked; the laws are drawn through the calibration shot)\n"
    );
    println!("| shot | expected depth, mm | {CELLS} | at 4 ms: cavity, mm | nose at 0.1, 0.2, 0.5, 1 ms: mm |");
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let row = |name: &str, expected: &str, shot: &Shot| {
        let nose = [1e-4, 2e-4, 5e-4, 1e-3].map(|time| format!("{:.1}", 1e3 * shot.nose(time))).join(", ");
        let late = 1e3 * shot.widest([3.9e-3, 4.1e-3], [0.005, 1.0])[0];
        println!("| {name} | {expected} | {} | {late:.1} | {nose} |", shot.cells());
    };
    row("BB, 179.8 m/s, R/16", "85 (fitted)", &shots.standard);
    for (speed, expected) in [
        (75.0, "23.5–27 (Poncelet), 41.5–43.5 (Resal)"),
        (100.0, "38–42, 53–55"),
        (125.0, "53–56, 64–65"),
        (150.0, "68–70, 74–75"),
        (210.0, "99–101.5, 94.5–95.5"),
    ] {
        row(&format!("BB, {speed} m/s, R/11"), expected, &Shot::bb(speed, 1, &[]));
    }
    row("BB, 165 m/s, R/11", "76.5–78, 80", &shots.slow);
    row("BB, 195 m/s, R/11", "92–93.5, 90–90.5", &shots.fast);
    let deep = [("gel.shape", "{ cylinder = { radius = 0.115, height = 0.45 } }")];
    row("4.8 mm, 650 m/s", "209–274", &Shot::sphere(4.8e-3, 650.0, 4.5e-3, &[]));
    row("4.8 mm, 720 m/s (cavity fitted)", "220–290; nose 58, 98, 172, 235 (derived)", &shots.sphere);
    row("4.8 mm, 1150 m/s", "269–365", &Shot::sphere(4.8e-3, 1150.0, 6e-3, &deep));
    for (speed, expected) in [(122.0, "64–69, 95–96"), (300.0, "168–181"), (526.0, "231–276")] {
        row(&format!("5.5 mm, {speed} m/s"), expected, &Shot::sphere(5.5e-3, speed, 8e-3, &[]));
    }
    let of = |drag: f64, strength: f64| 1e3 * poncelet(drag, strength, 4.37e-3, MASS, 179.8);
    println!(
        "\nPoncelet's laws with drags of 0.30, 0.35, 0.40 stop the BB at {:.1}, {:.1}, {:.1} mm.",
        of(0.30, 2.32e6),
        of(0.35, 2.07e6),
        of(0.40, 1.84e6)
    );
}

/// Retarding force by depth beside two laws that stop the BB as deep: mean over 4 mm.
fn forces(shot: &Shot) {
    println!("\nForce on the BB by depth, means over 4 mm\n");
    println!("| depth, mm | speed, m/s | force, N | Poncelet (0.35, 2.07 MPa) | | Resal (0.30, 35.8 kPa s/m) | |");
    println!("|---|---|---|---|---|---|---|");
    for depth in (5..84).step_by(4).map(|depth| 1e-3 * f64::from(depth)) {
        let at = |depth: f64| shot.way.iter().position(|look| look[1] >= depth);
        let (Some(from), Some(to)) = (at(depth - 2e-3), at(depth + 2e-3)) else { break };
        if to <= from {
            continue;
        }
        let ([_, before, fast], [_, after, slow]) = (shot.way[from], shot.way[to]);
        let force = 0.5 * MASS * (fast * fast - slow * slow) / (after - before);
        let (square, speed) = (0.5 * (fast * fast + slow * slow), 0.5 * (fast + slow));
        let poncelet = AREA * (2.07e6 + 0.5 * DENSITY * 0.35 * square);
        let resal = AREA * (35.8e3 * speed + 0.5 * DENSITY * 0.30 * square);
        let off = |law: f64| 100.0 * (force / law - 1.0);
        println!(
            "| {:.0} | {speed:.1} | {force:.1} | {poncelet:.1} | {:+.1} % | {resal:.1} | {:+.1} % |",
            1e3 * depth,
            off(poncelet),
            off(resal)
        );
    }
}

/// The cavity of 720 m/s, vented and sealed.
pub fn air() {
    println!("\n4.8 mm at 720 m/s by what is in the cavity\n");
    println!("| cavity | {CELLS} | at 4 ms: cavity, mm |");
    println!("|---|---|---|---|---|---|---|---|");
    let cavities = [
        ("vented", "\"vented\""),
        ("air flows in", "{ inflow = { discharge = 0.61 } }"),
        ("sealed, nothing in it", "{ sealed = { pressure = 0.0 } }"),
    ];
    for (name, value) in cavities {
        let shot = Shot::sphere(4.8e-3, 720.0, 4.5e-3, &[("gel.cavity", value)]);
        println!("| {name} | {} | {:.1} |", shot.cells(), 1e3 * shot.widest([3.9e-3, 4.1e-3], [0.005, 1.0])[0]);
    }
}

/// A .45 ACP ball of 265 m/s (230 grains, 869 ft/s) that cannot turn over, by mesh: 660 mm are measured.
pub fn bullet() {
    println!("\n.45 ACP ball of 265 m/s about an axis, where 660 mm are measured\n");
    println!("| cells | {CELLS} | speed at 660 mm, m/s |");
    println!("|---|---|---|---|---|---|---|---|");
    let nose = "{ ogive = { length = 10e-3, meplat_radius = 2e-3 } }";
    let shape = format!("{{ bullet = {{ radius = 5.74e-3, length = 17.3e-3, edge_radius = 0.5e-3, nose = {nose} }} }}");
    for (cells, size) in [("R/4", 1.4e-3), ("R/6", 0.96e-3)] {
        let keys: Keys = [
            ("gel.shape", "{ cylinder = { radius = 0.15, height = 1.6 } }".to_owned()),
            ("scene.end_time", "20e-3".to_owned()),
            ("scene.communication_step", STEP.to_string()),
            ("projectile.shape", shape.clone()),
            ("projectile.mass", "14.9e-3".to_owned()),
            ("projectile.position", "[0, 0, 11e-3]".to_owned()),
            ("projectile.velocity", "[0, 0, -265]".to_owned()),
            ("mesh.size", size.to_string()),
            ("mesh.tree.core", "8e-3".to_owned()),
            ("remesh.smallest", (0.5 * size).to_string()),
            ("remesh.erosion_thickness", (0.05 * size).to_string()),
        ]
        .to_vec();
        let shot = Shot::fly("sphere-720", &keys);
        let passing = shot.way.iter().find(|look| look[1] >= 0.66).map_or(f64::NAN, |look| look[2]);
        println!("| {cells} | {} | {passing:.0} |", shot.cells());
    }
}

/// The shot in space, and about the axis with the same cells, bulk modulus and end.
pub fn space() {
    println!("\nThe BB in space and about the axis, with cells, bulk modulus and end of fbi-bb-3d\n");
    println!(
        "| | {CELLS} | nose at 0.1, 0.2, 0.5, 1 ms: mm | defect, % | remesh, % of E₀ | elements | remeshings | M updates |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    let same: Keys = [
        ("gel.bulk_modulus", "370.8e6"),
        ("mesh.size", "0.43e-3"),
        ("mesh.tree.slope", "0.3"),
        ("remesh.smallest", "0.215e-3"),
        ("remesh.growth", "0.25"),
        ("scene.end_time", "2.2e-3"),
    ]
    .map(|(key, value)| (key, value.to_owned()))
    .to_vec();
    for (name, shot) in [("about the axis", Shot::fly("fbi-bb", &same)), ("in space", Shot::fly("fbi-bb-3d", &vec![]))]
    {
        let nose = [1e-4, 2e-4, 5e-4, 1e-3].map(|time| format!("{:.1}", 1e3 * shot.nose(time))).join(", ");
        let RunSummary { accounts, elements, remeshes, element_updates, energy_defect, .. } = &shot.summary;
        let booked =
            |name: &str| accounts.iter().find(|account| account.name == name).map_or(f64::NAN, |account| account.value);
        println!(
            "| {name} | {} | {nose} | {:.2} | {:+.2} | {elements} | {remeshes} | {:.1} |",
            shot.cells(),
            100.0 * energy_defect,
            100.0 * booked("remesh") / booked("initial"),
            1e-6 * element_updates
        );
    }
}
