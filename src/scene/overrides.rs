//! Single values written over those of a scene text.

use super::{SceneError, explain};
use std::str::FromStr;
use toml_edit::{DocumentMut, Item, Key, Table, TableLike, Value};

/// One replaced value: dotted key and TOML value.
///
/// # Examples
/// ```
/// use ballistic_gel::scene::{self, Override};
///
/// let text = scene::builtin("sphere-block").unwrap();
/// let faster: Override = "projectile.velocity=[0, 0, -7]".parse()?;
/// let scene = scene::read(&scene::resolve(text, &[faster])?)?;
/// assert_eq!(scene.projectile.velocity, [0.0, 0.0, -7.0]);
/// # Ok::<(), scene::SceneError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    /// Dotted key, such as `mesh.size` or `projectile.shape.sphere.radius`.
    pub key: String,
    /// TOML text of the value, such as `1e-3` or `[0, 0, -2]`; a bare word that is not TOML stands for itself.
    pub value: String,
}

impl FromStr for Override {
    type Err = SceneError;

    fn from_str(text: &str) -> Result<Self, SceneError> {
        let Some((key, value)) = text.split_once('=') else {
            return Err(SceneError::value(text, "no value", "key=value, such as mesh.size=2e-3"));
        };
        Ok(Self { key: key.trim().to_owned(), value: value.trim().to_owned() })
    }
}

/// The scene text with the overrides written into it; all other lines stay as they are.
///
/// A key that no scene has is written too, and refused by [`read()`](super::read()).
///
/// # Errors
/// [`SceneError`] if the text is not TOML, or an override is not a dotted key and a TOML value.
pub fn resolve(text: &str, overrides: &[Override]) -> Result<String, SceneError> {
    let parsed = text.parse::<DocumentMut>();
    let mut document = parsed.map_err(|error| explain::syntax(text, error.span(), error.message()))?;
    for change in overrides {
        write(&mut document, change)?;
    }
    Ok(document.to_string())
}

fn write(document: &mut DocumentMut, change: &Override) -> Result<(), SceneError> {
    let value = parse_value(change)?;
    let path = Key::parse(&change.key)
        .map_err(|_| SceneError::value(&change.key, "a broken key", "a dotted key, such as mesh.size"))?;
    let Some((last, tables)) = path.split_last() else {
        return Err(SceneError::value(&change.key, "no key", "a dotted key, such as mesh.size"));
    };
    let mut table: &mut dyn TableLike = document.as_table_mut();
    for (depth, name) in tables.iter().enumerate() {
        let inner = table.entry(name.get()).or_insert_with(implicit_table);
        let Some(inner) = inner.as_table_like_mut() else {
            return Err(not_a_table(change, &tables[..=depth]));
        };
        table = inner;
    }
    put(table, last, value);
    Ok(())
}

fn parse_value(change: &Override) -> Result<Value, SceneError> {
    let text = &change.value;
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    match text.parse::<Value>() {
        Ok(value) => Ok(value),
        Err(_) if !text.is_empty() && text.chars().all(bare) => Ok(Value::from(text.as_str())),
        Err(_) => {
            let found = if text.is_empty() { "no value".to_owned() } else { format!("`{text}`") };
            Err(SceneError::value(&change.key, found, "a TOML value, such as 2e-3, [0, 0, -2], true or \"text\""))
        }
    }
}

fn implicit_table() -> Item {
    let mut table = Table::new();
    table.set_dotted(true);
    Item::Table(table)
}

fn not_a_table(change: &Override, path: &[Key]) -> SceneError {
    let names: Vec<&str> = path.iter().map(Key::get).collect();
    let found = format!("that {} is a single value", names.join("."));
    SceneError::value(&change.key, found, "a key inside a table")
}

/// Replaces a value and keeps the comment behind it.
fn put(table: &mut dyn TableLike, name: &Key, mut value: Value) {
    if let Some(old) = table.get_mut(name.get()).and_then(Item::as_value_mut) {
        value.decor_mut().clone_from(old.decor());
        *old = value;
    } else {
        table.insert(name.get(), Item::Value(value));
    }
}
