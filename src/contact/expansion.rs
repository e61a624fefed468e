//! Expansion of a bullet: its opening, and the law by which the stagnation pressure of the gel opens it.

use crate::math::Vector3;
use serde::{Deserialize, Serialize};

/// Opening of an expanding body and its rate, by its law or prescribed by the importer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ExpansionMotion {
    /// Opening e: 0 unopened, 1 opened.
    pub opening: f64,
    /// Rate of the opening, 1/s, until it reaches `end`.
    pub rate: f64,
    /// Opening at which the motion stops.
    pub end: f64,
    /// Greatest distance that the surface moves along its normal from unopened to opened, m.
    pub travel: f64,
}

impl ExpansionMotion {
    /// Creates the state of a body that does not open further, and whose surface moves by at most `travel`, m.
    #[must_use]
    pub fn at_rest(opening: f64, travel: f64) -> Self {
        Self { opening, rate: 0.0, end: opening, travel }
    }

    /// Returns the opening after a time `h`, s.
    #[must_use]
    pub fn after(&self, h: f64) -> Self {
        if self.rate == 0.0 {
            return *self;
        }
        let opening = self.opening + self.rate * h;
        let is_past_end = if self.rate < 0.0 { opening <= self.end } else { opening >= self.end };
        if is_past_end { Self { opening: self.end, rate: 0.0, ..*self } } else { Self { opening, ..*self } }
    }

    /// Checks the opening.
    ///
    /// # Errors
    /// The violated requirement.
    pub fn check(&self) -> Result<(), &'static str> {
        let is_fraction = |x: f64| (0.0..=1.0).contains(&x);
        let is_ahead = self.rate * (self.end - self.opening) >= 0.0;
        if is_ahead
            && is_fraction(self.opening)
            && is_fraction(self.end)
            && self.rate.is_finite()
            && self.travel.is_finite()
        {
            Ok(())
        } else {
            Err("an opening from 0, unopened, to 1, opened")
        }
    }
}

/// Law of expansion: the stagnation pressure ½ρv² of the gel opens the nose, along a path in the gel.
///
/// Below `opening_pressure` the body stays as it is, above `full_pressure` it opens completely, in between in proportion.
/// The opening grows by 1 along `path`, as long as the gel acts on the body. A body that has opened does not close.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpansionLaw {
    /// Stagnation pressure at which the nose begins to open, Pa.
    pub opening_pressure: f64,
    /// Stagnation pressure at which it opens completely, Pa.
    pub full_pressure: f64,
    /// Path in the gel along which it opens completely, m.
    pub path: f64,
    /// ρ, mass density of the gel, kg/m³.
    pub density: f64,
}

/// Part of the opening after a contact impulse during which the gel counts as acting on the body: it covers the time to
/// the next impulse, and stops a body that has left the gel within this part of its path.
const AFTER_IMPULSE: f64 = 0.05;

impl ExpansionLaw {
    /// Returns the opening that this velocity relative to the gel, m/s, leads to.
    #[must_use]
    pub fn target(&self, velocity: &Vector3) -> f64 {
        let pressure = 0.5 * self.density * velocity.norm_squared();
        if pressure >= self.full_pressure {
            return 1.0;
        }
        ((pressure - self.opening_pressure) / (self.full_pressure - self.opening_pressure)).clamp(0.0, 1.0)
    }

    /// Returns the motion of the opening from a contact impulse on: de/dt = v/path, up to the target.
    #[must_use]
    pub fn opened_by_impulse(&self, now: &ExpansionMotion, velocity: &Vector3) -> ExpansionMotion {
        let end = self.target(velocity).min(now.opening + AFTER_IMPULSE);
        if end > now.opening {
            ExpansionMotion { rate: velocity.norm() / self.path, end, ..*now }
        } else {
            ExpansionMotion::at_rest(now.opening, now.travel)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: ExpansionLaw =
        ExpansionLaw { opening_pressure: 10e6, full_pressure: 20e6, path: 0.025, density: 1000.0 };

    fn opened(from: f64, speed: f64, time: f64) -> f64 {
        let start = ExpansionMotion::at_rest(from, 0.004);
        LAW.opened_by_impulse(&start, &Vector3::new(0.0, 0.0, -speed)).after(time).opening
    }

    #[test]
    fn the_target_grows_with_the_stagnation_pressure_between_the_thresholds() {
        let target = |pressure: f64| LAW.target(&Vector3::new(0.0, 0.0, -(pressure / 500.0).sqrt()));
        assert_eq!([target(9e6), target(21e6)], [0.0, 1.0]);
        assert!((target(15e6) - 0.5).abs() < 1e-12);
        let same = ExpansionLaw { full_pressure: LAW.opening_pressure, ..LAW };
        assert_eq!([100.0, 200.0].map(|v| same.target(&Vector3::new(0.0, 0.0, v))), [0.0, 1.0]);
    }

    #[test]
    fn the_opening_grows_along_the_path_and_stops_at_its_target() {
        assert!((opened(0.0, 250.0, 1e-6) - 250.0 * 1e-6 / 0.025).abs() < 1e-15);
        assert_eq!(opened(0.0, 250.0, 1.0), AFTER_IMPULSE, "no impulse follows");
        assert_eq!(opened(0.99, 250.0, 1.0), 1.0);
        assert_eq!(opened(0.7, 170.0, 1.0), 0.7, "a body that has opened does not close");
        assert_eq!(opened(0.0, 130.0, 1.0), 0.0);
    }

    #[test]
    fn a_prescribed_opening_stops_at_its_end_in_both_directions() {
        let motion = ExpansionMotion { opening: 0.5, rate: -10.0, end: 0.0, travel: 0.0 };
        assert_eq!([0.01, 0.2].map(|h| motion.after(h).opening), [0.4, 0.0]);
        assert!(motion.after(1.0).check().is_ok() && ExpansionMotion { opening: 1.1, ..motion }.check().is_err());
    }
}
