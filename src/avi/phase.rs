//! Where a tick is in the life of a mesh: each begins with half a kick and ends with one (numerics A12).

/// First tick of a mesh, last, or between.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    /// The kick is that of half of the step ahead.
    First,
    /// Half of the step behind and half of that ahead.
    Between,
    /// Half of the step behind: positions and velocities are those of one instant then.
    Last,
}

impl Phase {
    /// The part of the step behind that a sweep takes for the kick: all of it, mended where the step ahead is another one.
    pub fn taken(self) -> f64 {
        if self == Self::Last { 0.5 } else { 1.0 }
    }

    /// The part of a kick that belongs to the step ahead.
    pub fn share_ahead(self) -> f64 {
        match self {
            Self::First => 1.0,
            Self::Between => 0.5,
            Self::Last => 0.0,
        }
    }
}
