//! `gelfmu calibrate --shots`: fits parameters of a gel to several shots at once.

pub mod campaign;
pub mod gel_values;
pub mod least_squares;
pub mod shot_file;
pub mod target;
pub mod words;

use crate::console::Console;
use crate::failure::CommandError;
use crate::interrupt;
use crate::options::{CalibrateOptions, DEFAULT_SCENE, GelKey};
use crate::source;
use ballistic_gel::scene::{FidelityKind, GelSpec};
use campaign::{CommonSetting, ShotCampaign};
use gel_values::{FitCoordinates, GelValue, key_name, read_value};
use least_squares::{FitBreak, FitEnd, FitResult, PointOutcome};
use nalgebra::DVector;
use target::FitTarget;
use words::FitReport;

/// Answer to the first Ctrl-C.
const WAITING: &str = "interrupted: the best values so far are kept; Ctrl-C again ends it at once";
/// Parameters that a fit may change; data that are read fix no others.
const FITTED_KEYS: [GelKey; 4] = [GelKey::Stress, GelKey::Rate, GelKey::Exponent, GelKey::ShearModulus];

/// Fits the parameters, prints the table of residuals and the lines for a scene, and returns the exit status.
pub fn fit(file: &str, options: &CalibrateOptions, console: &Console) -> Result<u8, CommandError> {
    let name = options.scene.as_deref().unwrap_or(DEFAULT_SCENE);
    let gel = source::load(name, &options.set)?.scene.gel;
    let keys = fitted_keys(&options.fit, &gel)?;
    let shots = shot_file::read(file)?;
    if shots.len() < keys.len() {
        let [found, expected] = [shots.len(), keys.len()];
        let names: Vec<&str> = keys.iter().map(|key| key_name(*key)).collect();
        return Err(CommandError::BadInput(format!(
            "--shots {file}: found {found} shots, expected at least {expected}, as many as --fit {}",
            names.join(",")
        )));
    }
    let mut values = start_values(name, &gel, &keys)?;
    if let Err(error) = interrupt::listen(WAITING, console.listener()) {
        console.note(&format!("Ctrl-C will not keep the best values so far: {error}"));
    }
    let acceptance = options.level.unwrap_or(FidelityKind::Fine);
    if let Some(start) = options.start.filter(|start| *start != acceptance) {
        let report = fit_level(start, shots.clone(), &gel, &values, options, console)?;
        if report.end == FitEnd::Interrupted {
            return Ok(conclude(&report, console));
        }
        console.note(&format!("start from the fit of the level {}:\n{}", start.as_str(), report.table()));
        values = report.values;
    }
    let report = fit_level(acceptance, shots, &gel, &values, options, console)?;
    Ok(conclude(&report, console))
}

/// Returns the parameters of `--fit`, or all that a fit may change.
fn fitted_keys(asked: &[GelKey], gel: &GelSpec) -> Result<Vec<GelKey>, CommandError> {
    let expected = FITTED_KEYS.map(key_name).join(", ");
    for (i, key) in asked.iter().enumerate() {
        let found = if !FITTED_KEYS.contains(key) {
            key_name(*key).to_owned()
        } else if asked[..i].contains(key) {
            format!("{} twice", key_name(*key))
        } else {
            continue;
        };
        return Err(CommandError::BadInput(format!("--fit: found {found}, expected any of {expected}")));
    }
    let of_rate = if read_value(gel, GelKey::Rate).is_some() { GelKey::Rate } else { GelKey::Exponent };
    Ok(if asked.is_empty() { vec![GelKey::Stress, of_rate, GelKey::ShearModulus] } else { asked.to_vec() })
}

/// Returns the values of parameters in a scene; refuses a gel without one of them.
pub fn start_values(scene: &str, gel: &GelSpec, keys: &[GelKey]) -> Result<Vec<GelValue>, CommandError> {
    let value = |&key: &GelKey| {
        let value = read_value(gel, key).ok_or_else(|| {
            let (name, owner) = (key_name(key), words::owner_of(key));
            CommandError::BadInput(format!("{name}: found none in scene {scene}, expected a gel with {owner}"))
        })?;
        Ok(GelValue { key, value })
    };
    keys.iter().map(value).collect()
}

/// Fits the parameters at a level.
fn fit_level(
    level: FidelityKind,
    shots: Vec<shot_file::MeasuredShot>,
    gel: &GelSpec,
    start: &[GelValue],
    options: &CalibrateOptions,
    console: &Console,
) -> Result<FitReport, CommandError> {
    let scene = options.scene.as_deref().unwrap_or(DEFAULT_SCENE);
    let common = CommonSetting { scene, set: &options.set, level: Some(level) };
    let mut campaign = ShotCampaign::plan(shots, &common, options.threads, console)?;
    let saturates = read_value(gel, GelKey::Rate).is_some();
    let coordinates = FitCoordinates { keys: start.iter().map(|start| start.key).collect(), saturates };
    let targets: Vec<FitTarget> = campaign.shots.iter().map(|shot| shot.target).collect();
    let mut model = |stage: &str, points: &[DVector<f64>]| {
        run_points(&mut campaign, &format!("{}, {stage}", level.as_str()), &coordinates, points)
    };
    let (first, upper) = (coordinates.of_values(start), coordinates.upper_bounds());
    let FitResult { point, computed, end, iterations } = least_squares::fit(&targets, &upper, first, &mut model)?;
    Ok(FitReport {
        level,
        end,
        iterations,
        n_runs: campaign.n_completed,
        values: coordinates.to_values(&point),
        computed: computed.map(|computed| computed.iter().copied().collect()),
        shots: campaign.shots,
        gel: gel.clone(),
    })
}

/// Computes the shots at points of the fit, and tells those of a single point.
fn run_points(
    campaign: &mut ShotCampaign<'_>,
    stage: &str,
    coordinates: &FitCoordinates,
    points: &[DVector<f64>],
) -> Result<Vec<PointOutcome>, FitBreak> {
    let values: Vec<Vec<GelValue>> = points.iter().map(|point| coordinates.to_values(point)).collect();
    let computed = campaign.compute(stage, &values)?;
    for (values, computed) in values.iter().zip(&computed) {
        campaign.console.note(&words::point_line(stage, values, &campaign.shots, computed));
    }
    let outcome = |computed: Vec<Result<f64, String>>| {
        computed.into_iter().collect::<Result<Vec<f64>, String>>().map(DVector::from_vec)
    };
    Ok(computed.into_iter().map(outcome).collect())
}

/// Prints a fit, and returns the exit status.
fn conclude(report: &FitReport, console: &Console) -> u8 {
    console.result(&report.to_json(), &report.text());
    for shot in report.shots_outside_their_bands() {
        console.warning(&format!("{shot}: the residual is more than its band"));
    }
    match report.end {
        FitEnd::Converged => 0,
        FitEnd::Stalled => {
            console.warning("no step gave a smaller sum of squares: what is left is within the scatter of the runs");
            0
        }
        FitEnd::Exhausted => {
            console.error(&format!("not fitted: found no minimum in {} steps", report.iterations));
            1
        }
        FitEnd::Interrupted => {
            console.error("interrupted; above are the best values so far, if there are any");
            interrupt::INTERRUPTED
        }
    }
}
