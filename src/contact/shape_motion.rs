//! Motion of the surface of a body in its own frame: the bulge of a dome, or the opening of an expanding body.

use super::{DomeMotion, ExpansionMotion};
use crate::math::Vector;
use serde::{Deserialize, Serialize};

/// Motion of the shape of a body. Its coordinates are height and base radius of a dome, m, or the opening of an expanding
/// body, whose second coordinate is not used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ShapeMotion {
    /// Bulge of a dome.
    Bulge(DomeMotion),
    /// Opening of an expanding body.
    Expansion(ExpansionMotion),
}

impl ShapeMotion {
    /// Returns the shape after a time `h`, s.
    #[must_use]
    pub fn after(&self, h: f64) -> Self {
        match self {
            Self::Bulge(bulge) => Self::Bulge(bulge.after(h)),
            Self::Expansion(expansion) => Self::Expansion(expansion.after(h)),
        }
    }

    /// Checks that the shape is one of the body.
    ///
    /// # Errors
    /// The violated requirement.
    pub fn check(&self) -> Result<(), &'static str> {
        match self {
            Self::Bulge(bulge) => bulge.check(),
            Self::Expansion(expansion) => expansion.check(),
        }
    }

    /// Returns true if both are shapes of one body.
    #[must_use]
    pub fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Bulge(_), Self::Bulge(_)) => true,
            (Self::Expansion(a), Self::Expansion(b)) => a.travel == b.travel,
            _ => false,
        }
    }

    /// Returns the shape of a body that is taken out of the scene: an expanding body stops opening.
    #[must_use]
    pub fn held(&self) -> Self {
        match self {
            Self::Bulge(_) => *self,
            Self::Expansion(at) => Self::Expansion(ExpansionMotion::at_rest(at.opening, at.travel)),
        }
    }

    /// Returns the bulge of a dome.
    #[must_use]
    pub fn bulge(&self) -> Option<&DomeMotion> {
        match self {
            Self::Bulge(bulge) => Some(bulge),
            Self::Expansion(_) => None,
        }
    }

    /// Returns the opening of an expanding body.
    #[must_use]
    pub fn expansion(&self) -> Option<&ExpansionMotion> {
        match self {
            Self::Bulge(_) => None,
            Self::Expansion(expansion) => Some(expansion),
        }
    }

    /// Returns the opening of a body with this motion of its shape, from 0, unopened, to 1, opened; 0 for a body that does
    /// not expand.
    #[must_use]
    pub fn opening_of(motion: Option<&Self>) -> f64 {
        motion.and_then(Self::expansion).map_or(0.0, |at| at.opening)
    }

    /// Returns the rates of the coordinates, 1/s times their units.
    #[must_use]
    pub fn rate(&self) -> Vector<2> {
        match self {
            Self::Bulge(bulge) => bulge.rate,
            Self::Expansion(expansion) => Vector::<2>::new(expansion.rate, 0.0),
        }
    }

    /// Returns the second rates of the coordinates.
    #[must_use]
    pub fn acceleration(&self) -> Vector<2> {
        match self {
            Self::Bulge(bulge) => bulge.acceleration,
            Self::Expansion(_) => Vector::<2>::zeros(),
        }
    }

    /// Returns the greatest speed of the surface along its normal, m/s.
    #[must_use]
    pub fn max_speed(&self) -> f64 {
        match self {
            Self::Bulge(bulge) => bulge.max_speed(),
            Self::Expansion(expansion) => expansion.rate.abs() * expansion.travel,
        }
    }

    /// Returns the greatest rate of that speed, m/s².
    #[must_use]
    pub fn max_acceleration(&self) -> f64 {
        self.bulge().map_or(0.0, DomeMotion::max_acceleration)
    }

    /// Returns the greatest distance between the surfaces of two shapes of one body, m.
    #[must_use]
    pub fn greatest_distance(&self, other: &Self) -> f64 {
        match (self, other) {
            (Self::Bulge(a), Self::Bulge(b)) => (b.size - a.size).abs().sum(),
            (Self::Expansion(a), Self::Expansion(b)) => (b.opening - a.opening).abs() * a.travel,
            _ => f64::INFINITY,
        }
    }
}
