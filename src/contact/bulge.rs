use crate::geometry::Dome;
use crate::math::Vector;
use serde::{Deserialize, Serialize};

/// Base radius that a flat bulge without one is given, m: the fourth power, which the distance needs, is a normal number.
const LEAST_RADIUS: f64 = 1e-60;

/// Height and base radius of a dome, and how they change: prescribed by whoever owns the armour.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bulge {
    /// Height and base radius, m.
    pub size: Vector<2>,
    /// Their rates, m/s.
    pub rate: Vector<2>,
    /// The rates of these, m/s².
    pub acceleration: Vector<2>,
}

impl Bulge {
    /// At rest.
    #[must_use]
    pub fn at_rest(dome: &Dome) -> Self {
        let size = Vector::<2>::new(dome.height(), dome.radius());
        Self { size, rate: Vector::<2>::zeros(), acceleration: Vector::<2>::zeros() }
    }

    /// After a time `h`, s: constant acceleration.
    #[must_use]
    pub fn after(&self, h: f64) -> Self {
        Self {
            size: self.size + h * (self.rate + 0.5 * h * self.acceleration),
            rate: self.rate + h * self.acceleration,
            ..*self
        }
    }

    /// What is wrong with it as a dome, if anything. A bulge of height 0 is a flat plate, whatever its base radius.
    ///
    /// # Errors
    /// What a dome must be.
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

    /// The dome now. Between two checked ends an accelerated bulge may be off by a little: that is cut.
    #[must_use]
    pub fn dome(&self) -> Dome {
        let radius = self.size[1].max(LEAST_RADIUS);
        Dome::new(self.size[0].clamp(0.0, radius), radius)
    }

    /// Greatest speed of its surface along its normal, m/s.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.rate.abs().sum()
    }

    /// Greatest rate of that speed, m/s².
    #[must_use]
    pub fn pull(&self) -> f64 {
        self.acceleration.abs().sum()
    }
}
