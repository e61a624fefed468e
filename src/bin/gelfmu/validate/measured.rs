//! Measured shots: `projectiles/validation.csv`.

use crate::new::{BlockSize, Shot, named_projectile};
use ballistic_gel::scene::{Preset, ProjectileKind};
use serde::Deserialize;

/// Table of the measured shots.
const TABLE: &str = include_str!("../../../../projectiles/validation.csv");

/// Measured figure of a shot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MeasuredFigure {
    /// Depth of the nose at rest, m.
    Depth,
    /// Depth at which the yaw passes 30°, m.
    Neck,
}

/// Grade of a source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub enum SourceGrade {
    /// Read in a secondary place.
    B,
    /// Quoted without its source.
    C,
}

/// Measured shot.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValidationShot {
    /// Name.
    pub name: String,
    /// Projectile of the library.
    pub projectile: String,
    /// Speed, m/s.
    pub speed: f64,
    /// Yaw at the gel, degrees: assumed, as none was measured.
    pub yaw: f64,
    /// Block that is computed.
    pub block: String,
    /// Measured figure.
    pub measure: MeasuredFigure,
    /// Least measured value, m.
    pub low: f64,
    /// Greatest measured value, m.
    pub high: f64,
    /// Grade of the source.
    pub grade: SourceGrade,
    /// True if the gel is fitted to the shot.
    pub fitted: bool,
    /// Source.
    pub source: String,
}

/// Returns the measured shots of the table.
pub fn measured_shots() -> Vec<ValidationShot> {
    let rows = csv::Reader::from_reader(TABLE.as_bytes()).into_deserialize();
    rows.map(|row| row.expect("the table is tested")).collect()
}

impl ValidationShot {
    /// Shot with another yaw and roll, degrees.
    pub fn shot(&self, yaw: f64, roll: f64) -> Shot {
        Shot {
            projectile: named_projectile(&self.projectile).expect("the table names projectiles of the library"),
            speed: self.speed,
            yaw,
            roll,
            block: BlockSize::parse(&self.block).expect("the table has blocks of three lengths"),
            gel: Preset::Gelatin10,
        }
    }

    /// Returns true if the shot is judged: of grade B, and the gel is not fitted to it. Others are told only.
    pub fn is_judged(&self) -> bool {
        self.grade == SourceGrade::B && !self.fitted
    }

    /// Returns true if yaw decides the figure.
    pub fn is_of_service_bullet(&self) -> bool {
        self.shot(0.0, 0.0).projectile.kind == ProjectileKind::Service
    }

    /// Ratio of a computed value to the measured range: 1 inside it.
    pub fn ratio(&self, value: f64) -> f64 {
        value / value.clamp(self.low, self.high)
    }
}

#[cfg(test)]
mod tests {
    use super::{MeasuredFigure, SourceGrade, measured_shots};

    /// Poncelet's law of `gelfmu new` has its resistance from the calibration shot; these shots had no part in it.
    #[test]
    fn the_law_of_the_estimate_stops_recovered_bullets_within_a_quarter_of_their_measured_depths() {
        let counts = |grade, measure| (grade, measure) == (SourceGrade::B, MeasuredFigure::Depth);
        let is_recovered = |name: &str| name.ends_with("-recovered");
        let shots = measured_shots()
            .into_iter()
            .filter(|shot| counts(shot.grade, shot.measure) && is_recovered(&shot.projectile));
        let ratios: Vec<f64> = shots.map(|shot| shot.ratio(shot.shot(0.0, 0.0).longest_path())).collect();
        assert!(ratios.len() == 7 && ratios.iter().all(|ratio| (0.75..1.25).contains(ratio)), "{ratios:?}");
        let mean = ratios.iter().sum::<f64>() / 7.0;
        assert!((mean - 0.9).abs() < 0.05, "{mean}");
    }

    #[test]
    fn every_measured_shot_is_one_of_the_library_in_a_block_that_is_longer_than_its_depth() {
        let shots = measured_shots();
        assert!(shots.len() > 15);
        let fit = include_str!("../../../../presets/gelatin-10.csv");
        for (i, measured) in shots.iter().enumerate() {
            let shot = measured.shot(measured.yaw, 0.0);
            assert!(shot.block.length > 1.19 * measured.high && measured.low <= measured.high, "{}", measured.name);
            assert!(measured.low > 0.0 && !measured.source.is_empty());
            assert!(shots[..i].iter().all(|other| other.name != measured.name), "{} twice", measured.name);
            assert_eq!(measured.is_of_service_bullet(), measured.yaw != 0.0, "{}", measured.name);
            let is_in_fit = fit.contains(&format!("\n{0},{0},", measured.name));
            assert_eq!(measured.fitted, is_in_fit || measured.name == "bb-fbi", "{}", measured.name);
        }
        assert_eq!(shots.iter().filter(|shot| shot.is_judged()).count(), 5);
        assert_eq!(shots[0].ratio(0.08), 1.0);
        assert!((shots[0].ratio(0.19) - 2.0).abs() < 1e-12);
    }
}
