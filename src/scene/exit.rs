//! Duration of a run after the projectile has left the gel at its back face.

use serde::{Deserialize, Serialize};

/// Time that a run continues after the projectile has left the gel at its back face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a time of 0 or more, s, or \"never\"")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum StopAfterExit {
    /// Finite time, s.
    After(f64),
    /// No end before `scene.end_time`.
    Never(NeverKeyword),
}

/// Keyword `"never"`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum NeverKeyword {
    /// No end before `scene.end_time`.
    Never,
}

impl StopAfterExit {
    /// Time from the exit to the end of the run, s; infinite for `"never"`.
    #[must_use]
    pub fn time(self) -> f64 {
        match self {
            Self::After(time) => time,
            Self::Never(NeverKeyword::Never) => f64::INFINITY,
        }
    }
}

impl Default for StopAfterExit {
    /// Default of 2 ms, about the time in which a service bullet passes 400 mm.
    ///
    /// By then the cavity has opened along the whole path, and the report says where it still widens. In `gelatin-10`
    /// the cavity of a 9 mm bullet of 350 m/s widens for more than 5 ms: 68 mm at the exit, 95 mm after 2 ms.
    fn default() -> Self {
        Self::After(2e-3)
    }
}
