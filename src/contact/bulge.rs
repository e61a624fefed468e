//! Growth of a dome: its height and base radius, with their rates.

use crate::geometry::Dome;
use crate::math::Vector;
use serde::{Deserialize, Serialize};

/// Least base radius of a flat bulge, m: the distance needs its fourth power, which must be a normal number.
const MIN_RADIUS: f64 = 1e-60;

/// Bulge of a dome: its height and base radius and their rates, prescribed by the owner of the armour.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DomeMotion {
    /// Height and base radius, m.
    pub size: Vector<2>,
    /// Rates of height and base radius, m/s.
    pub rate: Vector<2>,
    /// Second rates of height and base radius, m/s².
    pub acceleration: Vector<2>,
}

impl DomeMotion {
    /// Creates the bulge of a dome at rest.
    #[must_use]
    pub fn at_rest(dome: &Dome) -> Self {
        let size = Vector::<2>::new(dome.height(), dome.radius());
        Self { size, rate: Vector::<2>::zeros(), acceleration: Vector::<2>::zeros() }
    }

    /// Returns the bulge after a time `h`, s, at constant acceleration.
    #[must_use]
    pub fn after(&self, h: f64) -> Self {
        Self {
            size: self.size + h * (self.rate + 0.5 * h * self.acceleration),
            rate: self.rate + h * self.acceleration,
            ..*self
        }
    }

    /// Checks that the bulge is a dome. A bulge of height 0 is a flat plate, whatever its base radius.
    ///
    /// # Errors
    /// The violated requirement of a dome.
    pub fn check(&self) -> Result<(), &'static str> {
        let [height, radius] = self.size.into();
        if !(radius.is_finite() && (radius > 0.0 || (radius, height) == (0.0, 0.0))) {
            return Err("a base radius above 0 m");
        }
        if (0.0..=radius).contains(&height) {
            Ok(())
        } else {
            Err("a height from 0 to the base radius: a cap is at most a hemisphere")
        }
    }

    /// Returns the present dome. Between two checked ends an accelerated bulge may exceed the bounds a little; it is
    /// clamped to them.
    #[must_use]
    pub fn dome(&self) -> Dome {
        let radius = self.size[1].max(MIN_RADIUS);
        Dome::new(self.size[0].clamp(0.0, radius), radius)
    }

    /// Returns the greatest speed of its surface along its normal, m/s.
    #[must_use]
    pub fn max_speed(&self) -> f64 {
        self.rate.abs().sum()
    }

    /// Returns the greatest rate of that speed, m/s².
    #[must_use]
    pub fn max_acceleration(&self) -> f64 {
        self.acceleration.abs().sum()
    }
}
