//! Numbers of a summary: one that is not finite is `null` in JSON, and reads back as NaN.

use serde::{Deserialize, Deserializer};

/// Reads a number.
pub(super) fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// Reads a vector.
pub(super) fn vector<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 3], D::Error> {
    Ok(<[Option<f64>; 3]>::deserialize(deserializer)?.map(|component| component.unwrap_or(f64::NAN)))
}

/// Reads a list, if there is one.
pub(super) fn list<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Vec<f64>>, D::Error> {
    let list = Option::<Vec<Option<f64>>>::deserialize(deserializer)?;
    Ok(list.map(|list| list.into_iter().map(|number| number.unwrap_or(f64::NAN)).collect()))
}
