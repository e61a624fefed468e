//! What is wrong with a scene: which key, on which line, what was found, what was expected.

use std::fmt;

/// A scene that cannot be used. Shows as `line 12: mesh.size: found -1.0, expected a positive length, m`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}{kind}", Place { key, line: *line })]
pub struct SceneError {
    /// Dotted key, such as `mesh.size`; the whole file if empty.
    pub key: String,
    /// Line of the scene text, from 1.
    pub line: Option<usize>,
    /// What is wrong.
    pub kind: SceneErrorKind,
}

/// What is wrong with a key.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneErrorKind {
    /// The text is not TOML.
    #[error("found `{found}`, which is not TOML: {expected}")]
    Syntax {
        /// The line as it stands.
        found: String,
        /// What the TOML reader expected there.
        expected: String,
    },
    /// A key that no table of a scene has.
    #[error("found the unknown key `{found}`{hint}, expected {expected}")]
    UnknownKey {
        /// The key.
        found: String,
        /// Question that names a known key that is near; may be empty.
        hint: String,
        /// The keys that may be there.
        expected: String,
    },
    /// A value, or its absence, outside the domain of the key.
    #[error("found {found}, expected {expected}")]
    Value {
        /// What is there.
        found: String,
        /// What may be there.
        expected: String,
    },
}

impl SceneError {
    /// A value outside its domain, on a line yet to be found.
    pub(super) fn value(key: &str, found: impl Into<String>, expected: impl Into<String>) -> Self {
        let kind = SceneErrorKind::Value { found: found.into(), expected: expected.into() };
        Self { key: key.to_owned(), line: None, kind }
    }

    /// The same value, but this was expected.
    pub(super) fn expecting(self, expected: &str) -> Self {
        match self.kind {
            SceneErrorKind::Value { found, .. } => Self::value(&self.key, found, expected),
            SceneErrorKind::Syntax { .. } | SceneErrorKind::UnknownKey { .. } => self,
        }
    }
}

struct Place<'a> {
    key: &'a str,
    line: Option<usize>,
}

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, "line {line}: ")?;
        }
        if self.key.is_empty() { Ok(()) } else { write!(f, "{}: ", self.key) }
    }
}
