//! Table of the figures of a run for the console: the results of the shot first, the diagnostics of the solver last.

use crate::text_width::{keep_names_whole, new_table};
use ballistic_gel::output::{FigureRow, INCH, UnitSystem, figure_rows, layer_rows_in_units, rows_in_units};
use ballistic_gel::scene::Scene;
use comfy_table::presets;
use serde_json::Value;
use std::path::Path;

/// Rows of the solver and of its cost, which end the table.
const DIAGNOSTICS: [&str; 10] = [
    "end",
    "mesh",
    "element time steps",
    "element updates",
    "energy",
    "momentum",
    "self-overlap",
    "wall time",
    "CPU time",
    "digest",
];
/// Name of the row of the centimetre of the path that takes the most energy.
const MOST_ENERGY: &str = "most energy";

/// Formats the summary of a run as a table, with one row for each layer, followed by the result files.
pub fn describe(summary: &Value, scene: &Scene, folder: &Path, units: UnitSystem) -> String {
    let mut table = new_table(presets::UTF8_FULL_CONDENSED);
    let figures = rows_in_units(figure_rows(summary, scene), summary, units);
    let rows = figures.into_iter().chain(most_energy_row(summary, units));
    let rows = rows.chain(layer_rows_in_units(folder, scene, units));
    for row in order_rows(rows.collect(), summary) {
        table.add_row([row.name, row.text]);
    }
    keep_names_whole(&mut table);
    format!("{table}\n{}", list_files(folder))
}

/// Orders the rows: the exit or the depth, the widest cavity, the most energy, the expansion, the others, the diagnostics.
fn order_rows(mut rows: Vec<FigureRow>, summary: &Value) -> Vec<FigureRow> {
    let way: &[&str] = match (summary["perforated"].as_bool(), summary["rest_depth"].as_f64()) {
        (Some(true), _) => &["exit"],
        (_, Some(_)) => &["rest depth", "greatest depth"],
        _ => &["greatest depth"],
    };
    let first = [way, &["temporary cavity", MOST_ENERGY, "expansion"]].concat();
    let rank = |row: &FigureRow| {
        let is_row = |name: &&str| *name == row.name;
        let place = first.iter().position(is_row).unwrap_or(first.len());
        place + DIAGNOSTICS.iter().position(is_row).map_or(0, |n| n + 1)
    };
    rows.sort_by_key(rank);
    rows
}

/// Row of the centimetre of the path in which the gel takes the most energy.
fn most_energy_row(summary: &Value, units: UnitSystem) -> Option<FigureRow> {
    let energies =
        summary["energy_per_centimetre"].as_array()?.iter().map(|energy| energy.as_f64().unwrap_or(f64::NAN));
    let (centimetre, energy) =
        energies.enumerate().filter(|(_, energy)| *energy > 0.0).max_by(|a, b| a.1.total_cmp(&b.1))?;
    let [from, to] = [centimetre, centimetre + 1];
    let text = match units {
        UnitSystem::Si => format!("{}/cm, {from} to {to} cm deep", units.format(energy, "J")),
        UnitSystem::Us => {
            let [from, to] = [from, to].map(|end| 0.01 * end as f64 / INCH);
            format!("{}, {from:.2} to {to:.2} in deep", units.format(100.0 * energy, "J/m"))
        }
    };
    Some(FigureRow { name: MOST_ENERGY.to_owned(), text, is_key: false })
}

fn list_files(folder: &Path) -> String {
    const FILES: [(&str, &str); 9] = [
        ("report.html", "the report, for a browser"),
        ("series.pvd", "the frames, for ParaView"),
        ("history.csv", "one row per communication step"),
        ("shot.csv", "speed, force and energy by depth"),
        ("cavity.csv", "radius and diameter of the cavity by time and depth"),
        ("track.csv", "permanent track and energy per centimetre by depth"),
        ("cracks.csv", "estimated crack length of each centimetre"),
        ("layers.csv", "speed at entry and energy of each layer"),
        ("summary.json", "the figures above"),
    ];
    let written = FILES.into_iter().filter(|(name, _)| folder.join(name).exists());
    let lines: Vec<String> = written.map(|(name, what)| format!("\n  {name:<13} {what}")).collect();
    format!("{}{}", folder.display(), lines.concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballistic_gel::scene;
    use serde_json::json;

    /// Names of the rows of a summary in their order.
    fn names(summary: &Value) -> Vec<String> {
        let scene = scene::read(scene::builtin("sphere-block").unwrap()).unwrap();
        let rows = figure_rows(summary, &scene).into_iter().chain(most_energy_row(summary, UnitSystem::Si));
        order_rows(rows.collect(), summary).into_iter().map(|row| row.name).collect()
    }

    #[test]
    fn the_results_of_the_shot_come_first_and_the_diagnostics_last() {
        let mut summary = json!({
            "rest_depth": 0.0832, "greatest_cavity_diameter": 0.03, "energy_per_centimetre": [3.0, 7.5, 2.0],
            "expansion": 1.0, "energy_deposited": 12.5, "overlapped_volume": 1e-9,
        });
        let named = names(&summary);
        assert_eq!(named[..5], ["rest depth", "greatest depth", "temporary cavity", "most energy", "expansion"]);
        assert_eq!(named[named.len() - DIAGNOSTICS.len()..], DIAGNOSTICS);
        summary["rest_depth"] = Value::Null;
        assert_eq!(names(&summary)[..2], ["greatest depth", "temporary cavity"]);
        summary["perforated"] = Value::Bool(true);
        assert_eq!(names(&summary)[..2], ["exit", "temporary cavity"]);
    }

    #[test]
    fn the_centimetre_with_the_most_energy_has_its_place() {
        let row = |energies: Value, units| most_energy_row(&json!({ "energy_per_centimetre": energies }), units);
        let text = |energies: Value| row(energies, UnitSystem::Si).map(|row| row.text);
        assert_eq!(text(json!([3.0, 7.5, null])).unwrap(), "7.500 J/cm, 1 to 2 cm deep");
        let us = row(json!([3.0, 7.5]), UnitSystem::Us).unwrap().text;
        assert_eq!(us, "14.05 ft·lbf/in, 0.39 to 0.79 in deep");
        assert_eq!([text(json!([])), text(json!([0.0])), text(Value::Null)], [None, None, None]);
    }
}
