//! Rows of a run with customary units in the place of SI units: each quantity is formatted again from its figure.

use super::report::{FigureRow, layer_rows};
use super::saved_run::layer_passages;
use super::units::{INCH, UnitSystem};
use crate::scene::Scene;
use serde_json::Value;
use std::path::Path;

/// Quantity in the text of a row.
#[derive(Debug, Clone, Copy)]
struct RowQuantity {
    /// Value, SI.
    value: f64,
    /// SI unit.
    unit: &'static str,
}

/// Figures of the rows, in the order of their texts: name of the row, or its beginning, unit and keys of `summary.json`.
const FIGURES: [(&str, &[(&str, &str)]); 14] = [
    ("exit", &[("exit_velocity", "m/s"), ("residual_energy", "J")]),
    ("rebound velocity", &[("rebound_velocity", "m/s")]),
    ("greatest depth", &[("peak_depth", "m")]),
    ("depth at the end", &[("final_depth", "m")]),
    ("rest depth", &[("rest_depth", "m")]),
    ("speed at the end", &[("final_velocity", "m/s")]),
    ("energy deposited", &[("energy_deposited", "J")]),
    ("peak force", &[("peak_force", "N")]),
    ("total impulse", &[("total_impulse", "N s")]),
    (
        "temporary cavity",
        &[("greatest_cavity_diameter", "m"), ("depth_of_greatest_cavity", "m"), ("final_cavity_diameter", "m")],
    ),
    ("collapse of the cavity", &[("cavity_pulsation_diameter", "m")]),
    ("permanent track", &[("greatest_track_diameter", "m")]),
    ("expansion", &[("expanded_diameter", "m")]),
    ("neck", &[("neck_length", "m")]),
];

/// Replaces the units of the rows of a run. `summary` is the content of `summary.json`.
#[must_use]
pub fn rows_in_units(rows: Vec<FigureRow>, summary: &Value, units: UnitSystem) -> Vec<FigureRow> {
    let replaced = |row: FigureRow| {
        let figures =
            FIGURES.iter().find(|(name, _)| row.name.starts_with(name)).map_or(&[][..], |(_, figures)| figures);
        let known = figures.iter().filter_map(|(key, unit)| Some(RowQuantity { value: number(&summary[key])?, unit }));
        FigureRow { text: replace_quantities(&row.text, known, units), ..row }
    };
    rows.into_iter().map(replaced).collect()
}

/// Returns the rows of the layers in a system of units; empty without the table of the layers.
#[must_use]
pub fn layer_rows_in_units(folder: &Path, scene: &Scene, units: UnitSystem) -> Vec<FigureRow> {
    let rows = layer_rows(folder, scene);
    if units == UnitSystem::Si {
        return rows;
    }
    let passages = layer_passages(folder).unwrap_or_default();
    let replaced = |(row, passage): (FigureRow, _)| {
        let super::penetration::LayerPassage { depth_from, depth_to, entry_speed, energy, .. } = passage;
        let extent = format!("{:.3}–{:.3} in deep", depth_from / INCH, depth_to / INCH);
        let rest = row.text.split_once(" mm deep").map_or("", |(_, rest)| rest);
        let known = [RowQuantity { value: entry_speed, unit: "m/s" }, RowQuantity { value: energy, unit: "J" }];
        FigureRow { text: extent + &replace_quantities(rest, known.into_iter(), units), ..row }
    };
    rows.into_iter().zip(passages).map(replaced).collect()
}

/// Returns a figure, or the norm of a vector.
fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Array(parts) => {
            parts.iter().map(|part| Some(part.as_f64()?.powi(2))).sum::<Option<f64>>().map(f64::sqrt)
        }
        other => other.as_f64(),
    }
}

/// Replaces quantities in the order of a text; one that the text does not have is left out.
fn replace_quantities(text: &str, quantities: impl Iterator<Item = RowQuantity>, units: UnitSystem) -> String {
    let (mut replaced, mut rest) = (String::new(), text);
    for RowQuantity { value, unit } in quantities {
        // A height above the entry surface is a negative depth without its sign.
        let shown = [value, -value].into_iter().find_map(|value| {
            let found = UnitSystem::Si.format(value, unit);
            Some((rest.find(&found)?, found.len(), units.format(value, unit)))
        });
        if let Some((at, length, text)) = shown {
            replaced += &rest[..at];
            replaced += &text;
            rest = &rest[at + length..];
        }
    }
    replaced + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::report::figure_rows;
    use crate::scene;
    use serde_json::json;

    fn text(summary: &Value, units: UnitSystem) -> String {
        let scene = scene::read(scene::builtin("sphere-block").unwrap()).unwrap();
        let rows = rows_in_units(figure_rows(summary, &scene), summary, units);
        let line = |row: FigureRow| format!("{}: {}", row.name, row.text);
        rows.into_iter().map(line).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn every_length_speed_energy_and_force_of_a_shot_has_customary_units() {
        let mut summary = json!({
            "peak_depth": 0.254, "time_of_peak_depth": 2e-3, "final_depth": -0.0127, "rest_depth": 0.2413, "time_of_rest": 8e-3,
            "final_velocity": [0.0, 3.048, 0.0], "energy_deposited": 542.327_179_332_560_2, "peak_force": 4_448.221_615_260_5,
            "force_window": 1e-5, "total_impulse": [0.0, 0.0, 4.448_221_615_260_5], "rebound_velocity": 0.3048,
            "greatest_cavity_diameter": 0.1016, "depth_of_greatest_cavity": 0.1016, "time_of_greatest_cavity": 1e-3,
            "final_cavity_diameter": 0.0127, "time_of_cavity_collapse": 5e-3, "cavity_pulsation_diameter": 0.0254,
            "time_of_cavity_pulsation": 7e-3, "greatest_track_diameter": 0.0127, "neck_length": 0.127,
            "expansion": 1.0, "expanded_diameter": 0.01651, "contact_duration": 4e-3,
        });
        let us = text(&summary, UnitSystem::Us);
        for row in [
            "greatest depth: 10.00 in at 2.000 ms",
            "depth at the end: none, 0.5000 in above the entry surface",
            "rest depth: 9.500 in from 8.000 ms",
            "speed at the end: 10.00 ft/s",
            "energy deposited: 400.0 ft·lbf",
            "peak force, mean over 10 µs: 1000 lbf",
            "total impulse: 1.000 lbf·s",
            "rebound velocity: 1.000 ft/s",
            "temporary cavity: 4.000 in wide 4.000 in deep at 1.000 ms, 0.5000 in at the end",
            "again 1.000 in wide at 7.000 ms",
            "permanent track: 0.5000 in wide",
            "expansion: 100 % open, 0.6500 in wide",
            "neck: 5.000 in, then",
        ] {
            assert!(us.contains(row), "{row} in {us}");
        }
        summary["perforated"] = Value::Bool(true);
        summary["exit_velocity"] = json!([0.0, 0.0, -304.8]);
        summary["residual_energy"] = json!(135.581_794_833_140_04);
        let us = text(&summary, UnitSystem::Us);
        assert!(us.contains("exit: 1000 ft/s at -, 100.0 ft·lbf retained"), "{us}");
    }

    #[test]
    fn si_rows_stay_as_they_are() {
        let scene = scene::read(scene::builtin("sphere-block").unwrap()).unwrap();
        let summary =
            json!({ "peak_depth": 0.012_345_678, "final_depth": 1e-14, "energy_deposited": 12.5, "peak_force": 5e4 });
        let rows = |rows: Vec<FigureRow>| rows.into_iter().map(|row| row.text).collect::<Vec<_>>();
        let plain = figure_rows(&summary, &scene);
        let same = rows_in_units(figure_rows(&summary, &scene), &summary, UnitSystem::Si);
        assert_eq!(rows(same), rows(plain));
    }
}
