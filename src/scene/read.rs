//! Skeleton.
use super::{Scene, SceneError};
/// One replaced value: dotted key and TOML value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    /// Dotted key, such as `mesh.size` or `projectile.shape.sphere.radius`.
    pub key: String,
    /// TOML text of the value, such as `1e-3` or `[0, 0, -2]`.
    pub value: String,
}
/// The scene text with the overrides written into it.
///
/// # Errors
/// [`SceneError`]
pub fn resolve(_text: &str, _overrides: &[Override]) -> Result<String, SceneError> {
    todo!()
}
/// Reads and checks a scene.
///
/// # Errors
/// [`SceneError`]
pub fn read(_text: &str) -> Result<Scene, SceneError> {
    todo!()
}
