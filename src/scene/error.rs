//! Errors of a scene: key, line, value found and value expected.

use std::fmt;

/// Invalid scene. Displays as `line 12: mesh.size: found -1.0, expected a positive length, m`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}{kind}", KeyPrefix { key, line: *line })]
pub struct SceneError {
    /// Dotted key, such as `mesh.size`; the whole file if empty.
    pub key: String,
    /// Line of the scene text, from 1.
    pub line: Option<usize>,
    /// Kind of the error.
    pub kind: SceneErrorKind,
}

/// Kind of a scene error.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneErrorKind {
    /// Text that is not TOML.
    #[error("found `{found}`, which is not TOML: {expected}")]
    Syntax {
        /// Line of the scene text.
        found: String,
        /// Syntax that the TOML reader expected there.
        expected: String,
    },
    /// Key that no table of a scene has.
    #[error("found the unknown key `{found}`{hint}, expected {expected}")]
    UnknownKey {
        /// Unknown key.
        found: String,
        /// Question that names a similar known key; may be empty.
        hint: String,
        /// Keys that the table may have.
        expected: String,
    },
    /// Value, or missing value, outside the domain of the key.
    #[error("found {found}, expected {expected}")]
    Value {
        /// Value found.
        found: String,
        /// Values allowed.
        expected: String,
    },
}

impl SceneErrorKind {
    /// Returns what the scene has at the place of the error.
    #[must_use]
    pub fn found(&self) -> &str {
        match self {
            Self::Syntax { found, .. } | Self::UnknownKey { found, .. } | Self::Value { found, .. } => found,
        }
    }

    /// Returns what may stand there.
    #[must_use]
    pub fn expected(&self) -> &str {
        match self {
            Self::Syntax { expected, .. } | Self::UnknownKey { expected, .. } | Self::Value { expected, .. } => {
                expected
            }
        }
    }
}

impl SceneError {
    /// Error of a value outside its domain; its line is found later.
    pub(super) fn value(key: &str, found: impl Into<String>, expected: impl Into<String>) -> Self {
        let kind = SceneErrorKind::Value { found: found.into(), expected: expected.into() };
        Self { key: key.to_owned(), line: None, kind }
    }

    /// Replaces the expected values of a value error.
    pub(super) fn expecting(self, expected: &str) -> Self {
        match self.kind {
            SceneErrorKind::Value { found, .. } => Self::value(&self.key, found, expected),
            SceneErrorKind::Syntax { .. } | SceneErrorKind::UnknownKey { .. } => self,
        }
    }
}

struct KeyPrefix<'a> {
    key: &'a str,
    line: Option<usize>,
}

impl fmt::Display for KeyPrefix<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, "line {line}: ")?;
        }
        if self.key.is_empty() { Ok(()) } else { write!(f, "{}: ", self.key) }
    }
}
