//! JSON schema of a scene, with which editors complete and check scene files.

use super::Scene;
use serde_json::json;

/// JSON schema of a scene file.
///
/// # Examples
/// ```
/// let schema = ballistic_gel::scene::schema();
/// assert_eq!(schema["properties"]["mesh"]["$ref"], "#/$defs/MeshSpec");
/// ```
#[must_use]
pub fn schema() -> serde_json::Value {
    let mut schema = schemars::schema_for!(Scene).to_value();
    // A preset may supply all other keys of a gel.
    schema["$defs"]["GelSpec"]["required"] = json!(["shape"]);
    schema
}
