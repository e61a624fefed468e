//! The exit of the projectile at the back of the gel, and how long a run goes on after it.

use serde::{Deserialize, Serialize};

/// Time that a run goes on after the projectile has left the gel at its back face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a time of 0 or more, s, or \"never\"")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum StopAfterExit {
    /// This time, s.
    After(f64),
    /// The run goes on to `scene.end_time`.
    Never(Never),
}

/// The word `"never"`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum Never {
    /// Without an end of its own.
    Never,
}

impl StopAfterExit {
    /// The time, s; infinite if it never comes.
    #[must_use]
    pub fn time(self) -> f64 {
        match self {
            Self::After(time) => time,
            Self::Never(Never::Never) => f64::INFINITY,
        }
    }
}

impl Default for StopAfterExit {
    /// 2 ms, about what a service bullet takes through 400 mm: the cavity has opened along all of its way, and is told to widen still where
    /// it does. In `gelatin-10` that of a 9 mm bullet of 350 m/s does so for more than 5 ms: 68 mm at the exit, 95 mm after 2 ms.
    fn default() -> Self {
        Self::After(2e-3)
    }
}
