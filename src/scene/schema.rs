//! JSON schema of a scene, with which editors complete and check.

use super::Scene;

/// JSON schema of a scene file.
///
/// # Examples
/// ```
/// let schema = ballistic_gel::scene::schema();
/// assert_eq!(schema["properties"]["mesh"]["$ref"], "#/$defs/MeshSpec");
/// ```
#[must_use]
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(Scene).to_value()
}
