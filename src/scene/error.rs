//! What is wrong with a scene: which key, on which line, what was found, what was expected.

/// A scene that cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}{key}: {kind}", line.map(|l| format!("line {l}: ")).unwrap_or_default())]
pub struct SceneError {
    /// Dotted key, such as `mesh.size`; the whole file if empty.
    pub key: String,
    /// Line of the scene text, from 1.
    pub line: Option<usize>,
    /// What is wrong.
    pub kind: SceneErrorKind,
}

/// What is wrong with a key.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneErrorKind {
    /// The text is not what serde or TOML expect there.
    #[error("{message}")]
    Syntax {
        /// What was found and what was expected.
        message: String,
    },
    /// A value outside its domain.
    #[error("found {found}, expected {expected}")]
    Value {
        /// What is there.
        found: String,
        /// What may be there.
        expected: String,
    },
}
