//! Measured errors of the levels: `projectiles/level-errors.csv`, whose rows `python -m ballistic_gel levels` writes.

use super::arrival::Arrival;
use super::shot::Shot;
use crate::rounding::rounded;
use ballistic_gel::scene::{BodyShape, FidelityKind, Preset, ProjectileKind};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// Table of the measured errors.
const TABLE: &str = include_str!("../../../../projectiles/level-errors.csv");
/// Greatest relative difference of calibre, speed, and mass by the cube of the calibre, at which a measured error
/// holds. Cells are fractions of the radius, so these decide how many of them a shot passes. The error of
/// `draft` grows by 0.6 points in a tenth of the speed, and by 0.7 in a tenth of the calibre (`docs/shots.md`).
const BAND: f64 = 0.1;

/// Shot as the table identifies it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShotIdentity {
    /// Name of the projectile.
    pub projectile: String,
    /// Kind of body: `sphere`, `cylinder` or `chisel` of a laboratory, `service` or `recovered` bullet.
    pub kind: &'static str,
    /// Calibre, m.
    pub calibre: f64,
    /// Mass, kg.
    pub mass: f64,
    /// Speed, m/s.
    pub speed: f64,
    /// Yaw, degrees.
    pub yaw: f64,
    /// Gel.
    pub gel: Preset,
}

/// Row of the table: the error of the depth at one level.
#[derive(Debug, Clone, PartialEq, Deserialize)]
struct LevelErrorRow {
    /// Projectile of the measurement.
    projectile: String,
    kind: String,
    /// Calibre, m.
    calibre: f64,
    /// Mass, kg.
    mass: f64,
    /// Speed, m/s.
    speed: f64,
    /// Yaw, degrees.
    yaw: f64,
    gel: Preset,
    level: FidelityKind,
    /// Level of the reference.
    reference: FidelityKind,
    /// Depth of the reference, m.
    reference_depth: f64,
    /// Relative error of the depth.
    error: f64,
    /// Command that wrote the row.
    command: String,
}

/// Errors of the levels of a shot; none where no shot of its kind was measured.
#[derive(Debug)]
pub struct LevelErrors {
    rows: Vec<LevelErrorRow>,
    command: String,
}

impl ShotIdentity {
    /// Identity of a shot.
    pub fn of(shot: &Shot) -> Self {
        let kind = match (shot.projectile.kind, &shot.projectile.shape) {
            (ProjectileKind::Recovered, _) => "recovered",
            (ProjectileKind::Service, _) => "service",
            (ProjectileKind::Expanding, _) => "expanding",
            (ProjectileKind::Test, BodyShape::Sphere { .. }) => "sphere",
            (ProjectileKind::Test, BodyShape::Cylinder { .. }) => "cylinder",
            (ProjectileKind::Test, BodyShape::Chisel(_)) => "chisel",
            (ProjectileKind::Test, _) => "test",
        };
        let Shot { speed, yaw, gel, .. } = *shot;
        let (projectile, mass) = (shot.projectile.name.clone(), shot.projectile.mass);
        Self { projectile, kind, calibre: 2.0 * shot.radius(), mass, speed, yaw, gel }
    }

    /// Command that measures the errors of this shot.
    fn command(&self) -> String {
        let Self { projectile, speed, yaw, gel, .. } = self;
        let mut command = format!("python -m ballistic_gel levels {projectile} --speed {speed:?} --yaw {yaw:?}");
        if *gel != Preset::Gelatin10 {
            write!(command, " --gel {}", gel.name()).expect("a string grows");
        }
        command
    }
}

impl LevelErrorRow {
    /// Returns true if the error holds for a shot in a block of this length, m.
    fn holds_for(&self, shot: &ShotIdentity, length: f64) -> bool {
        let density = |mass: f64, calibre: f64| mass / calibre.powi(3);
        let pairs = [
            (self.calibre, shot.calibre),
            (self.speed, shot.speed),
            (density(self.mass, self.calibre), density(shot.mass, shot.calibre)),
        ];
        let is_near = pairs.iter().all(|(measured, found)| (found / measured - 1.0).abs() <= BAND);
        let is_same = (self.kind.as_str(), self.yaw, self.gel) == (shot.kind, shot.yaw, shot.gel);
        is_same && is_near && self.reference_depth < length
    }
}

impl LevelErrors {
    /// Errors that hold for a shot.
    pub fn of(shot: &Shot) -> Self {
        let identity = ShotIdentity::of(shot);
        let is_of_gel = shot.is_square_on() && shot.layers.is_empty();
        let is_measured = is_of_gel && shot.arrival.as_ref().is_none_or(Arrival::is_like_fired);
        let holds = |row: &LevelErrorRow| is_measured && row.holds_for(&identity, shot.block.length);
        let of_scene = || "python -m ballistic_gel trade FILE".to_owned();
        let command = if shot.arrival.is_some() || !shot.layers.is_empty() { of_scene() } else { identity.command() };
        Self { rows: measured_errors().filter(holds).collect(), command }
    }

    /// Relative error of the depth at a level: the greatest of those that hold.
    pub fn error(&self, level: &str) -> Option<f64> {
        let of_level = self.rows.iter().filter(|row| row.level.as_str() == level).map(|row| row.error);
        of_level.reduce(f64::max).map(rounded)
    }

    /// Sentence on the measurement, or on the command that measures.
    pub fn note(&self) -> String {
        let [row, ..] = &self.rows[..] else {
            return format!("not measured for this kind of shot; `{}` measures them", self.command);
        };
        let (speed, reference) = (rounded(row.speed), row.reference.as_str());
        format!("those of {} at {speed} m/s against `{reference}`; `{}` measures them", row.projectile, row.command)
    }
}

/// Rows of the table.
fn measured_errors() -> impl Iterator<Item = LevelErrorRow> {
    csv::Reader::from_reader(TABLE.as_bytes()).into_deserialize().map(|row| row.expect("the table is tested"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::new::{BlockSize, named_projectile, scene_text};

    fn shot(name: &str, speed: f64, yaw: f64, length: f64) -> Shot {
        let block = BlockSize { width: 0.15, height: 0.15, length };
        Shot {
            projectile: named_projectile(name).unwrap(),
            speed,
            yaw,
            roll: 0.0,
            block,
            gel: Preset::Gelatin10,
            layers: vec![],
            arrival: None,
        }
    }

    #[test]
    fn each_measured_error_is_given_to_its_own_shot() {
        for row in measured_errors() {
            let measured = Shot { gel: row.gel, ..shot(&row.projectile, row.speed, row.yaw, 3.0) };
            let given = LevelErrors::of(&measured).error(row.level.as_str()).unwrap();
            assert!(given >= rounded(row.error) && row.level != row.reference, "{row:?}");
        }
    }

    #[test]
    fn a_shot_of_a_kind_that_was_not_measured_has_no_errors() {
        // Another kind of body, speed, yaw, and a block that the projectile leaves.
        for shot in [
            shot("45acp-230-xtp-recovered", 268.2, 0.0, 0.4),
            shot("sphere-4.8mm", 400.0, 0.0, 0.4),
            shot("bb", 120.0, 0.0, 0.4),
            shot("9mm-fmj", 350.0, 2.0, 0.4),
            shot("sphere-4.8mm", 720.0, 0.0, 0.2),
        ] {
            let text = scene_text(&shot).unwrap();
            let name = &shot.projectile.name;
            assert!(!text.contains("error ="), "{text}");
            let command = format!("`python -m ballistic_gel levels {name} --speed {:?}", shot.speed);
            assert!(text.contains(&format!("# Errors: not measured for this kind of shot; {command}")), "{text}");
        }
    }

    #[test]
    fn the_error_of_a_fast_sphere_is_not_that_of_the_calibration_shot() {
        let error = |name: &str, speed: f64| LevelErrors::of(&shot(name, speed, 0.0, 0.4)).error("draft").unwrap();
        assert!(error("sphere-4.8mm", 720.0) > 1.2 * error("bb", 179.8));
        assert_eq!(error("bb", 179.8), error("bb", 185.0), "within a tenth of the speed");
    }
}
