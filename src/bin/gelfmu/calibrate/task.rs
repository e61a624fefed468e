//! Calibration problem: scene, initial strength and target depth.

use super::trial;
use crate::failure::CommandError;
use crate::options::{CalibrateOptions, DEFAULT_SCENE};
use crate::source::{self, SceneSource};
use ballistic_gel::scene::{MaterialModel, Override, Scene};

/// Scene key of the fitted value.
pub const FITTED_KEY: &str = "gel.strength_scale";

/// Calibration problem: the scene with its initial strength, and the target depth in the options, m.
pub struct CalibrationTask<'a> {
    pub name: &'a str,
    pub overrides: Vec<Override>,
    pub scene: Scene,
    pub strength: f64,
    pub options: &'a CalibrateOptions,
}

/// Reason for the end of a calibration.
pub enum CalibrationEnd {
    /// The depth was met within the tolerance.
    Fitted,
    /// The user interrupted the search.
    Interrupted,
    /// The depth cannot be met; the reason.
    GivenUp(String),
}

/// Greatest calibrated speed, m/s: above it the gel and the projectile flow whatever their strength.
const GREATEST_SPEED: f64 = 5000.0;

/// Explains why a speed, m/s, is out of range; `None` if the speed is valid.
fn explain_excess_speed(speed: f64) -> Option<String> {
    let hint = if speed <= 1e3 * GREATEST_SPEED {
        format!("; were mm/s meant? They are {} m/s", 1e-3 * speed)
    } else {
        String::new()
    };
    (speed > GREATEST_SPEED).then(|| format!("found {speed:?} m/s, expected at most {GREATEST_SPEED:?} m/s{hint}"))
}

impl<'a> CalibrationTask<'a> {
    /// Loads the scene, and refuses a problem without a solution.
    pub fn read(options: &'a CalibrateOptions) -> Result<Self, CommandError> {
        let name = options.scene.as_deref().unwrap_or(DEFAULT_SCENE);
        let mut overrides = options.set.clone();
        if let Some(speed) = options.speed {
            let value = format!("[0.0, 0.0, {:?}]", -speed);
            overrides.push(Override { key: "projectile.velocity".to_owned(), value });
        }
        let scene = source::load(name, &overrides)?.scene;
        let refuse = |key: &str, why: &str| CommandError::BadInput(format!("scene {name}: {key}: {why}"));
        if scene.gel.material != MaterialModel::TwoNetwork {
            let why = "found another one, expected \"two-network\", whose moduli and dashpot stresses are scaled";
            return Err(refuse("gel.material", why));
        }
        let strength = scene.gel.strength_scale;
        if let Some(why) = options.speed.and_then(explain_excess_speed) {
            return Err(CommandError::BadInput(format!("--speed: {why}")));
        }
        if let Some(why) =
            scene.gel.shape.thickness().and_then(|thickness| trial::explain_excess_depth(options.depth, thickness))
        {
            return Err(CommandError::BadInput(format!("--depth: {why}")));
        }
        let velocity = scene.projectile.velocity;
        if velocity[2] >= 0.0 {
            let expected = "a projectile that runs into the gel along -z: --speed gives its speed";
            return Err(refuse("projectile.velocity", &format!("found {velocity:?}, expected {expected}")));
        }
        Ok(Self { name, overrides, scene, strength, options })
    }

    /// Loads the scene with another yield stress, Pa.
    pub fn load_with(&self, yield_stress: f64) -> Result<SceneSource, CommandError> {
        let fitted = Override { key: FITTED_KEY.to_owned(), value: format!("{yield_stress:?}") };
        let overrides: Vec<Override> = self.overrides.iter().cloned().chain([fitted]).collect();
        source::load(self.name, &overrides)
    }

    /// Returns the error of an invalid key.
    pub fn refuse(&self, key: &str, why: &str) -> CommandError {
        CommandError::BadInput(format!("scene {}: {key}: {why}", self.name))
    }
}
