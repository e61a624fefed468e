//! Calibration problem: scene, initial strength and target depth.

use super::search::ShotOutcome;
use super::trial::{self, ShotEnd, ShotRun};
use crate::failure::CommandError;
use crate::level;
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

/// Greatest factor between the first strength and the strongest one that is tried.
const GREATEST_FACTOR: f64 = 1e3;

/// Returns the override that gives the projectile a speed along −z, m/s.
pub fn speed_override(speed: f64) -> Override {
    Override { key: "projectile.velocity".to_owned(), value: format!("[0.0, 0.0, {:?}]", -speed) }
}

/// Explains why a speed, m/s, is out of range; `None` if the speed is valid.
pub fn explain_excess_speed(speed: f64) -> Option<String> {
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
        overrides.extend(options.speed.map(speed_override));
        overrides.extend(options.level.map(level::level_override));
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

    /// Returns the greatest strength that is tried: a thousand times the first one, or less if the bulk modulus bounds
    /// the shear moduli.
    pub fn strongest(&self) -> f64 {
        let gel = &self.scene.gel;
        let shear = gel.shear_modulus + gel.branches.iter().map(|branch| branch.shear_modulus).sum::<f64>();
        let bound = if shear > 0.0 { gel.bulk_modulus / shear } else { f64::INFINITY };
        bound.min(GREATEST_FACTOR * self.strength).max(self.strength)
    }

    /// Returns the outcome of a run for the search of the strength.
    pub fn outcome(&self, run: ShotRun) -> ShotOutcome {
        match run.end {
            ShotEnd::AtRest { depth, time } => ShotOutcome::Stopped { depth, time },
            ShotEnd::Perforated => ShotOutcome::Through,
            ShotEnd::ThrownBack => ShotOutcome::ThrownBack,
            ShotEnd::Moving { depth, speed } if depth > self.options.depth && speed > 0.0 => ShotOutcome::Through,
            ShotEnd::Moving { depth, speed } => ShotOutcome::Failed(format!(
                "found the projectile still moving at {speed:.3} m/s after {:e} s, {:.2} mm deep: give it a longer \
                 scene.end_time",
                run.time,
                1e3 * depth
            )),
            ShotEnd::Failed(why) => ShotOutcome::Failed(why),
        }
    }

    /// Loads the scene with another strength.
    pub fn load_with(&self, strength: f64) -> Result<SceneSource, CommandError> {
        let fitted = Override { key: FITTED_KEY.to_owned(), value: format!("{strength:?}") };
        let overrides: Vec<Override> = self.overrides.iter().cloned().chain([fitted]).collect();
        source::load(self.name, &overrides)
    }

    /// Returns the error of an invalid key.
    pub fn refuse(&self, key: &str, why: &str) -> CommandError {
        CommandError::BadInput(format!("scene {}: {key}: {why}", self.name))
    }
}
