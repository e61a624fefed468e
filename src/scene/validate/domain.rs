//! The few questions that are asked of every number.

use crate::scene::SceneError;
use std::ops::RangeInclusive;

/// Nothing, or the first thing that is wrong.
pub(super) type Check = Result<(), SceneError>;

/// Refuses `found` unless `good`.
pub(super) fn require(good: bool, key: &str, found: impl FnOnce() -> String, expected: &str) -> Check {
    if good { Ok(()) } else { Err(SceneError::value(key, found(), expected)) }
}

pub(super) fn finite(key: &str, value: f64) -> Check {
    require(value.is_finite(), key, || format!("{value:?}"), "a finite number")
}

pub(super) fn all_finite(key: &str, values: &[f64]) -> Check {
    require(values.iter().all(|v| v.is_finite()), key, || format!("{values:?}"), "finite numbers")
}

pub(super) fn positive(key: &str, value: f64, expected: &str) -> Check {
    require(value.is_finite() && value > 0.0, key, || format!("{value:?}"), expected)
}

pub(super) fn within(key: &str, value: f64, range: RangeInclusive<f64>) -> Check {
    let expected = format!("a number from {:?} to {:?}", range.start(), range.end());
    require(range.contains(&value), key, || format!("{value:?}"), &expected)
}
