//! Level `instant`: the reduced model of a shot, and its coefficients for the scene.

use super::{BodyShape, BulletNose, FidelityKind, Preset, ProjectileSpec, Scene};
use crate::reduced::{BodyClass, IdentifiedClass, ReducedCoefficients};
use std::sync::LazyLock;

/// Coefficients in `gelatin-10`, as `python -m ballistic_gel reduce` has written them.
static GELATIN_10: LazyLock<ReducedCoefficients> = LazyLock::new(|| {
    toml::from_str(include_str!("../../reduced/gelatin-10.toml")).expect("the coefficients of the gel are TOML")
});

/// Returns the coefficients that are shipped for a gel, if there are any.
#[must_use]
pub fn shipped_coefficients(preset: Preset) -> Option<&'static ReducedCoefficients> {
    (preset == Preset::Gelatin10).then(|| &*GELATIN_10)
}

/// Returns the class of a body whose nose is a hemisphere; `None` for any other body.
pub(super) fn body_class(body: &ProjectileSpec) -> Option<BodyClass> {
    match &body.shape {
        BodyShape::Sphere { .. } => Some(BodyClass::Sphere),
        BodyShape::Capsule { .. } => Some(BodyClass::RoundNose),
        BodyShape::Bullet(bullet) if bullet.nose == BulletNose::Round && bullet.tail.is_none() => {
            Some(BodyClass::RoundNose)
        }
        _ => None,
    }
}

/// Describes the reduced model of a class of bodies.
pub(super) fn describe_reduced(class: &IdentifiedClass) -> Vec<String> {
    let bodies = match class.body {
        BodyClass::Sphere => "spheres",
        BodyClass::RoundNose => "bodies with a round nose",
    };
    vec![
        "gel: reduced model, without finite elements; resistance to the nose by shear, inertia, added mass at the entry and \
         an elastic return"
            .to_owned(),
        format!("identified: from {} runs of {bodies} at the level {}", class.runs, class.level),
        "cavity: rings that open and fall back by themselves, each with the energy of the nose as it passed".to_owned(),
        "block: it moves as a whole by the impulses on it".to_owned(),
    ]
}

/// Physics that the reduced model leaves out.
pub(super) const OMITTED: [&str; 8] = [
    "gravity: none",
    "heat: none",
    "deformation of the bodies: none, they are rigid",
    "waves: none, and no pressures: sensors are refused",
    "sides of the block: none, and no surface: a cavity near the width of the block is too narrow",
    "neighbours: none, each ring of the cavity opens by itself",
    "yaw: none, the body keeps to its axis",
    "damage: none, and no permanent track",
];

/// Expectation of the reduced model for a class of bodies, in words.
#[must_use]
pub fn describe_instant(class: &IdentifiedClass) -> String {
    let percent = |error: f64| format!("{:.0} %", 100.0 * error);
    format!(
        "reduced model: depth within {}, exit speed within {} and widest cavity within {} of the level {} in nine of ten shots",
        percent(class.depth_error),
        percent(class.exit_error),
        percent(class.cavity_error),
        class.level
    )
}

impl Scene {
    /// Returns the coefficients of the projectile, if the scene could be run at the level `instant`.
    #[must_use]
    pub fn instant_class(&self) -> Option<&IdentifiedClass> {
        super::validate::check_instant(self).ok()?;
        self.reduced_coefficients()?.of(body_class(&self.projectile)?)
    }

    /// Returns the error of the level `instant`, where that of the level from which it is identified is known: their sum.
    #[must_use]
    pub fn instant_error(&self) -> Option<f64> {
        let class = self.instant_class()?;
        let level: FidelityKind = class.level.parse().ok()?;
        Some(self.fidelity.get(level)?.error? + class.depth_error.max(class.exit_error))
    }

    /// Returns the error of the level of the scene, if it is known.
    #[must_use]
    pub fn level_error(&self) -> Option<f64> {
        match self.scene.fidelity {
            FidelityKind::Instant => self.instant_error(),
            level => self.fidelity.get(level)?.error,
        }
    }

    /// Returns the coefficients of the reduced model of the scene, its own or those that are shipped for its gel.
    pub(super) fn reduced_coefficients(&self) -> Option<&ReducedCoefficients> {
        self.instant.as_ref().or_else(|| shipped_coefficients(self.gel.preset?))
    }

    /// Returns the coefficients of the projectile in the reduced model; `None` at any level but `instant`.
    #[must_use]
    pub fn reduced_class(&self) -> Option<&IdentifiedClass> {
        if self.scene.fidelity != FidelityKind::Instant {
            return None;
        }
        self.reduced_coefficients()?.of(body_class(&self.projectile)?)
    }
}
