//! Text and JSON output of a fit to several shots.

use super::gel_values::{GelValue, key_name, scene_lines};
use super::least_squares::FitEnd;
use super::shot_file::{MeasuredShot, ShotMeasure};
use crate::options::GelKey;
use ballistic_gel::scene::{FidelityKind, GelSpec};
use comfy_table::{Table, presets};
use serde_json::{Map, Value, json};

/// Fit at a level, for output.
pub struct FitReport {
    pub level: FidelityKind,
    pub end: FitEnd,
    pub iterations: usize,
    pub n_runs: usize,
    pub values: Vec<GelValue>,
    /// Computed values of the shots; `None` if the fit was interrupted in its first runs.
    pub computed: Option<Vec<f64>>,
    pub shots: Vec<MeasuredShot>,
    /// Gel of the scene, which has the other parameters.
    pub gel: GelSpec,
}

/// Returns the part of a gel that has a parameter.
pub fn owner_of(key: GelKey) -> &'static str {
    match key {
        GelKey::Stress | GelKey::Exponent => "a branch of a power_law",
        GelKey::Rate => "a branch of a power_law with a rate",
        GelKey::ShearModulus => "a gel.shear_modulus above 0",
        GelKey::BranchModulus => "gel.branches",
        GelKey::CriticalStretch | GelKey::Delay => "gel.damage",
    }
}

/// Returns the unit of a measure in tables, and the factor from SI units.
fn table_unit(measure: ShotMeasure) -> (&'static str, f64) {
    match measure {
        ShotMeasure::Depth { .. } | ShotMeasure::Cavity { .. } => ("mm", 1e3),
        ShotMeasure::Slope { .. } => ("mm per m/s", 1e3),
    }
}

/// Formats a value in the unit of its measure, without the unit.
pub fn in_table_unit(measure: ShotMeasure, value: f64) -> String {
    let scaled = table_unit(measure).1 * value;
    match measure {
        ShotMeasure::Depth { .. } | ShotMeasure::Cavity { .. } => format!("{scaled:.2}"),
        ShotMeasure::Slope { .. } => format!("{scaled:.4}"),
    }
}

/// Formats a value in the unit of its measure.
pub fn with_unit(measure: ShotMeasure, value: f64) -> String {
    format!("{} {}", in_table_unit(measure, value), table_unit(measure).0)
}

/// Returns `key = value` of all values.
fn assignments(values: &[GelValue]) -> String {
    let texts: Vec<String> =
        values.iter().map(|given| format!("{} = {:?}", key_name(given.key), given.value)).collect();
    texts.join(", ")
}

/// Describes a point of a fit in one line: values, and computed shots with their residuals.
pub fn point_line(
    stage: &str,
    values: &[GelValue],
    shots: &[MeasuredShot],
    computed: &[Result<f64, String>],
) -> String {
    let told = shots.iter().zip(computed).map(|(shot, computed)| match computed {
        Ok(value) => {
            let residual = shot.target.residual(*value);
            format!("{} {} ({residual:+.2})", shot.name, with_unit(shot.measure, *value))
        }
        Err(why) => why.clone(),
    });
    format!("{stage}: {}: {}", assignments(values), told.collect::<Vec<_>>().join(", "))
}

impl FitReport {
    /// Returns the table of residuals, the values and the lines of a scene.
    pub fn text(&self) -> String {
        if self.computed.is_none() {
            return "No shots were completed.".to_owned();
        }
        let values = assignments(&self.values);
        let (level, lines) = (self.level.as_str(), scene_lines(&self.gel, &self.values));
        format!("{}\nlevel {level}, {} runs, {values}\n\n{lines}", self.table(), self.n_runs)
    }

    /// Returns the table of residuals.
    pub fn table(&self) -> Table {
        let mut table = Table::new();
        table.load_style(presets::UTF8_FULL_CONDENSED);
        table.set_header(["shot", "value", "window", "band", "computed", "residual"]);
        for (shot, computed) in self.shots.iter().zip(self.computed.iter().flatten()) {
            let (cell, target) = (|value: f64| in_table_unit(shot.measure, value), shot.target);
            let window = if target.window > 0.0 { format!("± {}", cell(target.window)) } else { "-".to_owned() };
            table.add_row([
                shot.name.clone(),
                format!("{} {}", shot.measure.name(), with_unit(shot.measure, target.value)),
                window,
                cell(target.band),
                cell(*computed),
                format!("{:+.2}", target.residual(*computed)),
            ]);
        }
        table
    }

    /// Returns the names of the shots whose residual is more than their band.
    pub fn shots_outside_their_bands(&self) -> impl Iterator<Item = &str> {
        let both = self.shots.iter().zip(self.computed.iter().flatten());
        both.filter(|(shot, computed)| shot.target.residual(**computed).abs() > 1.0).map(|(shot, _)| shot.name.as_str())
    }

    /// Returns the fit as JSON.
    pub fn to_json(&self) -> Value {
        let status = match self.end {
            FitEnd::Converged => "fitted",
            FitEnd::Stalled => "stalled",
            FitEnd::Exhausted => "not fitted",
            FitEnd::Interrupted => "interrupted",
        };
        let values: Map<String, Value> =
            self.values.iter().map(|given| (key_name(given.key).to_owned(), given.value.into())).collect();
        let shots: Vec<Value> = self
            .shots
            .iter()
            .zip(self.computed.iter().flatten())
            .map(|(shot, value)| shot_json(shot, *value))
            .collect();
        json!({
            "status": status,
            "level": self.level.as_str(),
            "iterations": self.iterations,
            "runs": self.n_runs,
            "values": self.computed.is_some().then_some(values),
            "lines": self.computed.is_some().then(|| scene_lines(&self.gel, &self.values)),
            "shots": shots,
        })
    }
}

fn shot_json(shot: &MeasuredShot, computed: f64) -> Value {
    let target = shot.target;
    json!({
        "name": shot.name,
        "measure": shot.measure.name(),
        "value": target.value,
        "band": target.band,
        "window": target.window,
        "limit": shot.limit,
        "computed": computed,
        "residual": target.residual(computed),
    })
}
