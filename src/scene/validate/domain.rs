//! Domain checks that apply to every number of a scene.

use crate::scene::SceneError;
use std::ops::RangeInclusive;

/// Result of a check: success, or the first error.
pub(super) type CheckResult = Result<(), SceneError>;

/// Refuses `found` unless `good`.
pub(super) fn require(good: bool, key: &str, found: impl FnOnce() -> String, expected: &str) -> CheckResult {
    if good { Ok(()) } else { Err(SceneError::value(key, found(), expected)) }
}

/// Greatest magnitude of an input: squares and quotients of larger ones overflow.
const LARGEST: f64 = 1e15;
/// Least magnitude of a positive input.
const SMALLEST: f64 = 1e-15;

pub(super) fn finite(key: &str, value: f64) -> CheckResult {
    all_finite(key, &[value])
}

pub(super) fn all_finite(key: &str, values: &[f64]) -> CheckResult {
    let found = || if let [value] = values { format!("{value:?}") } else { format!("{values:?}") };
    let expected = if values.len() == 1 { "a finite number" } else { "finite numbers" };
    require(values.iter().all(|v| v.is_finite()), key, found, expected)?;
    require(values.iter().all(|v| v.abs() <= LARGEST), key, found, "nothing beyond 1e15 in size")
}

pub(super) fn positive(key: &str, value: f64, expected: &str) -> CheckResult {
    require(value.is_finite() && value > 0.0, key, || format!("{value:?}"), expected)?;
    within(key, value, SMALLEST..=LARGEST)
}

pub(super) fn within(key: &str, value: f64, range: RangeInclusive<f64>) -> CheckResult {
    let expected = format!("a number from {:?} to {:?}", range.start(), range.end());
    require(range.contains(&value), key, || format!("{value:?}"), &expected)
}
