//! `gelfmu calibrate --sensitivity`: derivatives of the measures of shots by the logarithms of parameters of the gel.

use super::shots::campaign::{CommonSetting, ShotCampaign};
use super::shots::gel_values::{GelValue, greatest_exponent, key_name, read_value, rounded};
use super::shots::least_squares::FitBreak;
use super::shots::shot_file::{self, MeasuredShot, ShotMeasure};
use super::shots::target::FitTarget;
use super::shots::{self, words};
use crate::console::Console;
use crate::failure::CommandError;
use crate::interrupt;
use crate::options::{CalibrateOptions, DEFAULT_SCENE, GelKey};
use crate::source;
use ballistic_gel::scene::FidelityKind;
use comfy_table::{Table, presets};
use serde_json::{Value, json};

/// Relative difference of a parameter to either side.
const DIFFERENCE: f64 = 0.2;
/// Answer to the first Ctrl-C.
const WAITING: &str = "interrupted: complete rows are kept; Ctrl-C again ends it at once";

/// Derivatives of all measures by the logarithm of one parameter.
struct SensitivityRow {
    given: GelValue,
    /// Tried values.
    tried: [f64; 2],
    /// Derivative of each shot; a text if a shot has no value.
    derivatives: Vec<Result<f64, String>>,
}

/// Prints the table of derivatives, and returns the exit status.
pub fn measure(options: &CalibrateOptions, console: &Console) -> Result<u8, CommandError> {
    let scene = options.scene.as_deref().unwrap_or(DEFAULT_SCENE);
    let gel = source::load(scene, &options.set)?.scene.gel;
    let given = shots::start_values(scene, &gel, &options.sensitivity)?;
    let (measured, level) = match &options.shots {
        Some(file) => (shot_file::read(file)?, Some(options.level.unwrap_or(FidelityKind::Fine))),
        None => (vec![rest_depth_of(scene, options.speed)], options.level),
    };
    let common = CommonSetting { scene, set: &options.set, level };
    let mut campaign = ShotCampaign::plan(measured, &common, options.threads, console)?;
    if let Err(error) = interrupt::listen(WAITING, console.listener()) {
        console.note(&format!("Ctrl-C will not keep complete rows: {error}"));
    }
    let mut rows = vec![];
    let mut status = 0;
    let saturates = read_value(&gel, GelKey::Rate).is_some();
    for given in given {
        match differentiate(&mut campaign, given, greatest_exponent(saturates)) {
            Ok(row) => rows.push(row),
            Err(FitBreak::Command(error)) => return Err(error),
            Err(FitBreak::Interrupted) => {
                status = interrupt::INTERRUPTED;
                break;
            }
        }
    }
    let json = json!({ "sensitivity": rows.iter().map(|row| row.to_json(&campaign.shots)).collect::<Vec<_>>() });
    console.result(&json, &table(&campaign.shots, &rows).to_string());
    for why in rows.iter().flat_map(|row| &row.derivatives).filter_map(|derivative| derivative.as_ref().err()) {
        console.warning(why);
    }
    Ok(status)
}

/// Returns the rest depth of a scene as the only measure.
fn rest_depth_of(scene: &str, speed: Option<f64>) -> MeasuredShot {
    MeasuredShot {
        name: scene.to_owned(),
        scene: None,
        set: vec![],
        measure: ShotMeasure::Depth { speed },
        target: FitTarget { value: 0.0, band: 1.0, window: 0.0 },
        limit: 1.0,
        place: String::new(),
    }
}

/// Returns the derivatives by the logarithm of one parameter, by central differences; an exponent is at most `greatest`.
fn differentiate(campaign: &mut ShotCampaign<'_>, given: GelValue, greatest: f64) -> Result<SensitivityRow, FitBreak> {
    let most = if given.key == GelKey::Exponent { greatest } else { f64::INFINITY };
    let tried = [1.0 - DIFFERENCE, 1.0 + DIFFERENCE].map(|factor| rounded(factor * given.value).min(most));
    let points = tried.map(|value| vec![GelValue { value, ..given }]);
    let stage = format!("{} = {:?} and {:?}", key_name(given.key), tried[0], tried[1]);
    let computed = campaign.compute(&stage, &points)?;
    let width = (tried[1] / tried[0]).ln();
    let both = computed[0].iter().zip(&computed[1]);
    let derivative =
        |(low, high): (&Result<f64, String>, &Result<f64, String>)| Ok((high.clone()? - low.clone()?) / width);
    Ok(SensitivityRow { given, tried, derivatives: both.map(derivative).collect() })
}

/// Returns the table: one row for each parameter, one column for each shot.
fn table(shots: &[MeasuredShot], rows: &[SensitivityRow]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    let measures = shots.iter().map(|shot| {
        let measure =
            if matches!(shot.measure, ShotMeasure::Depth { .. }) { "rest depth" } else { shot.measure.name() };
        format!("{}: d {measure} / d ln", shot.name)
    });
    table.set_header(["parameter", "value", "tried"].map(str::to_owned).into_iter().chain(measures));
    for SensitivityRow { given, tried, derivatives } in rows {
        let first =
            [key_name(given.key).to_owned(), format!("{:?}", given.value), format!("{:?}, {:?}", tried[0], tried[1])];
        let cells = shots.iter().zip(derivatives).map(|(shot, derivative)| match derivative {
            Ok(derivative) => words::with_unit(shot.measure, *derivative),
            Err(_) => "no value".to_owned(),
        });
        table.add_row(first.into_iter().chain(cells));
    }
    table
}

impl SensitivityRow {
    /// Returns the row as JSON, SI units.
    fn to_json(&self, shots: &[MeasuredShot]) -> Value {
        let derivatives: Vec<Value> = shots
            .iter()
            .zip(&self.derivatives)
            .map(|(shot, derivative)| {
                let measure = shot.measure.name();
                json!({ "name": shot.name, "measure": measure, "derivative": derivative.as_ref().ok() })
            })
            .collect();
        let parameter = key_name(self.given.key);
        json!({ "parameter": parameter, "value": self.given.value, "tried": self.tried, "shots": derivatives })
    }
}
