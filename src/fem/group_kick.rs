//! Kick of a group of elements: how long its forces act, and the time since its last tick.

/// Velocity kick of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupKick {
    /// Duration of the impulse, s.
    pub length: f64,
    /// Time since the previous tick of the group, s.
    pub elapsed: f64,
}

impl GroupKick {
    /// No kick, at the tick of the last one.
    pub const NONE: Self = Self { length: 0.0, elapsed: 0.0 };

    /// Returns true if the kick takes back a part of the last one: the mesh ends in the first half of a step. Viscosity
    /// has no part in such a kick, because reversed it would feed the motion (method A12).
    #[inline]
    #[must_use]
    pub fn takes_back(&self) -> bool {
        self.length < 0.0
    }
}
