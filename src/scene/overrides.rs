//! Overrides: single values written over those of a scene text.

use super::named_body::{NamedBody, named_bodies};
use super::quantity::begins_like_number;
use super::{FidelityKind, FidelityLevel, LibraryProjectile, LibraryValue, Scene, SceneError, explain};
use std::str::FromStr;
use toml::de::DeTable;
use toml_edit::{DocumentMut, Item, Key, Table, TableLike, Value};

/// Override of one value: dotted key and TOML value.
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
    /// TOML text of the value, such as `1e-3` or `[0, 0, -2]`; a bare word that is not TOML is read as a string, also
    /// with dots.
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

/// Returns true if one of two dotted keys is, or contains, the other.
pub(super) fn keys_overlap(a: &str, b: &str) -> bool {
    let holds = |a: &str, b: &str| b.strip_prefix(a).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
    holds(a, b) || holds(b, a)
}

/// Writes the overrides into the scene text; all other lines stay unchanged.
///
/// An unknown key is written too, and refused by [`read()`](super::read()).
///
/// # Errors
/// [`SceneError`] if the text is not TOML, or an override is not a dotted key and a TOML value.
pub fn resolve(text: &str, overrides: &[Override]) -> Result<String, SceneError> {
    edit_document(text, overrides, |document, override_| {
        write_override(document, override_)?;
        override_levels(document, &override_.key);
        Ok(())
    })
}

/// Writes the overrides into the scene text as its new standard.
///
/// The levels of `scene.fidelity` keep their own overrides but lose their measured figures. The text is resolved
/// instead if an override sets `scene.fidelity`, or the scene already has another level.
///
/// # Errors
/// An error of [`resolve`].
pub fn rebase_scene(text: &str, overrides: &[Override]) -> Result<String, SceneError> {
    let is_level = |key: &str| key == "scene.fidelity" || key == "scene";
    let document = text.parse::<DocumentMut>().ok();
    let own = document.as_ref().and_then(|scene| scene.get("scene")?.get("fidelity")?.as_str());
    if own.is_some_and(|own| own != FidelityKind::Standard.as_str()) || overrides.iter().any(|o| is_level(&o.key)) {
        return resolve(text, overrides);
    }
    edit_document(text, overrides, |document, override_| {
        write_override(document, override_)?;
        remove_figures(document, &override_.key, |_| {});
        Ok(())
    })
}

/// Writes overrides that do not affect the measured figures of the fidelity levels, such as another file name.
///
/// # Errors
/// An error of [`resolve`].
pub fn written(text: &str, overrides: &[Override]) -> Result<String, SceneError> {
    edit_document(text, overrides, write_override)
}

/// Writes the values that the library gives into the bodies that name it, and its version: the text then holds them
/// under any version of the library.
///
/// # Errors
/// [`SceneError`] if the text is not TOML, or states a version of the library in which a body had other values.
pub fn fill_bodies(text: &str) -> Result<String, SceneError> {
    let mut document = parse_document(text)?;
    for named in bodies_of_library(text) {
        write_values(&mut document, &named, &named.missing_values()?)?;
    }
    Ok(document.to_string())
}

fn edit_document(
    text: &str,
    overrides: &[Override],
    each: impl Fn(&mut DocumentMut, &Override) -> Result<(), SceneError>,
) -> Result<String, SceneError> {
    let mut document = parse_document(text)?;
    for named in bodies_of_library(text) {
        refuse_other_name(&named, overrides)?;
        release_body(&mut document, &named, overrides)?;
    }
    overrides.iter().try_for_each(|override_| each(&mut document, override_))?;
    Ok(document.to_string())
}

fn parse_document(text: &str) -> Result<DocumentMut, SceneError> {
    text.parse().map_err(|error: toml_edit::TomlError| explain::syntax_error(text, error.span(), error.message()))
}

/// Bodies that name a projectile of the library; none in a text that [`read()`](super::read()) refuses for a name.
fn bodies_of_library(text: &str) -> Vec<NamedBody> {
    DeTable::parse(text).ok().and_then(|scene| named_bodies(scene.get_ref()).ok()).unwrap_or_default()
}

fn write_values(document: &mut DocumentMut, named: &NamedBody, values: &[LibraryValue]) -> Result<(), SceneError> {
    let key = |value: &LibraryValue| format!("{}.{}", named.key(), value.key);
    values.iter().try_for_each(|v| write_override(document, &Override { key: key(v), value: v.value.clone() }))
}

/// Refuses another name for a body that the name alone describes: start, cells and times of the scene stay those of the
/// first one.
fn refuse_other_name(named: &NamedBody, overrides: &[Override]) -> Result<(), SceneError> {
    let key = format!("{}.library", named.key());
    let own = &named.projectile.name;
    let values = overrides.iter().filter(|o| plain_key(&o.key) == plain_key(&key)).filter_map(|o| parse_value(o).ok());
    let other = values.filter_map(|value| value.as_str().and_then(LibraryProjectile::named)).find(|p| p.name != *own);
    let Some(LibraryProjectile { name, .. }) = other.filter(|_| !named.has_own_values()) else { return Ok(()) };
    let expected = format!(
        "{own:?}, for which start, cells and times of the scene are chosen: `gelfmu new --projectile {name}` writes a \
         scene of this one"
    );
    Err(SceneError::value(&key, format!("{name:?} in a scene of {own:?}"), expected))
}

/// Writes out a body of the library of which an override replaces a value, and removes its name: the body is then that
/// of the scene.
fn release_body(document: &mut DocumentMut, named: &NamedBody, overrides: &[Override]) -> Result<(), SceneError> {
    let replaces = |quantity: &str| {
        let key = plain_key(&format!("{}.{quantity}", named.key()));
        overrides.iter().any(|o| keys_overlap(&plain_key(&o.key), &key))
    };
    if !named.quantities().iter().any(|quantity| replaces(quantity)) {
        return Ok(());
    }
    let mut values = named.missing_values()?;
    // A mass takes precedence over the density.
    values.retain(|value| value.quantity() != "mass" || !replaces("density"));
    write_values(document, named, &values)?;
    let body = match named.body {
        0 => document.get_mut("projectile").and_then(Item::as_table_like_mut),
        number => document.get_mut("fragment").and_then(|list| table_at(list, &number.to_string()).ok()),
    };
    if let Some(body) = body {
        body.remove("library");
        body.remove("library_version");
    }
    Ok(())
}

/// Dotted TOML key: `fragment.1.mass` of `fragment[1].mass`.
fn plain_key(key: &str) -> String {
    key.replace('[', ".").replace(']', "")
}

/// Keys that change neither results nor cost, and the keys of the levels themselves.
const NEUTRAL_KEYS: [&str; 6] =
    ["fidelity", "output", "scene.fidelity", "scene.name", "scene.title", "scene.communication_step"];

/// Removes the overridden key from the levels' own overrides, and the measured figures of the levels.
fn override_levels(document: &mut DocumentMut, key: &str) {
    remove_figures(document, key, |level| {
        if let Some(set) = level.get_mut("set").and_then(Item::as_array_mut) {
            set.retain(|entry| {
                !entry.as_str().is_some_and(|entry| keys_overlap(entry.split('=').next().unwrap_or("").trim(), key))
            });
        }
    });
}

/// Removes the measured figures of the levels, unless the key is harmless, and applies `more` to each level.
fn remove_figures(document: &mut DocumentMut, key: &str, more: impl Fn(&mut dyn TableLike)) {
    let levels = document.get_mut("fidelity").and_then(Item::as_table_like_mut);
    if NEUTRAL_KEYS.iter().any(|harmless| *harmless == key || key.starts_with(&format!("{harmless}."))) {
        return;
    }
    for (_, level) in levels.into_iter().flat_map(|levels| levels.iter_mut()) {
        let Some(level) = level.as_table_like_mut() else { continue };
        for measured in ["error", "updates", "cpu_seconds"] {
            level.remove(measured);
        }
        more(level);
    }
}

fn write_override(document: &mut DocumentMut, change: &Override) -> Result<(), SceneError> {
    let value = parse_value(change)?;
    let broken =
        |_| SceneError::value(&change.key, "a broken key", "a dotted key, such as mesh.size or fragment[1].mass");
    let path = Key::parse(&plain_key(&change.key)).map_err(broken)?;
    let Some((last, tables)) = path.split_last() else {
        return Err(SceneError::value(&change.key, "no key", "a dotted key, such as mesh.size"));
    };
    let mut place: &mut dyn TableLike = document.as_table_mut();
    let mut names = tables.iter().enumerate();
    while let Some((depth, name)) = names.next() {
        let numbered = tables.get(depth + 1).or(Some(last)).is_some_and(|next| next.get().parse::<usize>().is_ok());
        if numbered && place.get(name.get()).is_none() {
            return Err(no_member(change, name, 0));
        }
        let inner = place.entry(name.get()).or_insert_with(implicit_table);
        if depth + 1 == tables.len()
            && let Some(part) = component(inner, last)
        {
            let decor = part.decor().clone();
            *part = value;
            *part.decor_mut() = decor;
            return Ok(());
        }
        let inner = if is_list(inner) {
            let number = names.next().map_or("", |(_, number)| number.get());
            table_at(inner, number).map_err(|length| no_member(change, name, length))?
        } else {
            inner.as_table_like_mut().ok_or_else(|| not_a_table(change, &tables[..=depth]))?
        };
        place = inner;
    }
    replace_value(place, last, value);
    Ok(())
}

/// Returns true if the item is a list of tables.
fn is_list(item: &Item) -> bool {
    item.is_array_of_tables() || item.as_array().is_some_and(|list| list.iter().all(Value::is_inline_table))
}

/// Returns component `number`, from 1, of a vector; `None` unless the item is a list of plain values with that many.
fn component<'a>(item: &'a mut Item, number: &Key) -> Option<&'a mut Value> {
    let at = number.get().parse::<usize>().ok()?.checked_sub(1)?;
    let values = item.as_array_mut().filter(|values| !values.iter().any(Value::is_inline_table))?;
    values.get_mut(at)
}

/// Table number `number`, from 1, of a list; otherwise the length of the list.
fn table_at<'a>(list: &'a mut Item, number: &str) -> Result<&'a mut dyn TableLike, usize> {
    let at = number.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
    match list {
        Item::ArrayOfTables(tables) => {
            let length = tables.len();
            at.and_then(|at| tables.get_mut(at)).map(|table| table as &mut dyn TableLike).ok_or(length)
        }
        Item::Value(Value::Array(values)) => {
            let length = values.len();
            let table = at.and_then(|at| values.get_mut(at)).and_then(Value::as_inline_table_mut);
            table.map(|table| table as &mut dyn TableLike).ok_or(length)
        }
        Item::None | Item::Value(_) | Item::Table(_) => Err(0),
    }
}

fn no_member(change: &Override, name: &Key, length: usize) -> SceneError {
    let name = name.get();
    let expected = match length {
        0 => format!("a scene with [[{name}]] tables"),
        _ => format!("{name}[1] to {name}[{length}]: the scene has so many [[{name}]] tables"),
    };
    SceneError::value(&change.key, "none of them", expected)
}

fn parse_value(change: &Override) -> Result<Value, SceneError> {
    let text = &change.value;
    // A name of the library may have a dot, such as sphere-4.8mm; a number has another beginning.
    let is_name = text.starts_with(|c: char| c.is_ascii_alphabetic());
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_' || c == '.' && is_name;
    match text.parse::<Value>() {
        Ok(value) => Ok(value),
        Err(_) if !text.is_empty() && text.chars().all(bare) => Ok(Value::from(text.as_str())),
        Err(_) if is_quantity(text) => Ok(Value::from(text.as_str())), // the reader names a wrong unit or key
        Err(_) => {
            let found = if text.is_empty() { "no value".to_owned() } else { format!("`{text}`") };
            Err(SceneError::value(&change.key, found, "a TOML value, such as 2e-3, [0, 0, -2], true or \"text\""))
        }
    }
}

/// Returns true for a number with any unit, such as 124 gr.
fn is_quantity(text: &str) -> bool {
    begins_like_number(text) && text.ends_with(|c: char| c.is_alphabetic() || "°³".contains(c))
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
fn replace_value(table: &mut dyn TableLike, name: &Key, mut value: Value) {
    if let Some(old) = table.get_mut(name.get()).and_then(Item::as_value_mut) {
        value.decor_mut().clone_from(old.decor());
        *old = value;
    } else {
        table.insert(name.get(), Item::Value(value));
    }
}

/// Scene text with its level written over it; `None` if the level changes nothing.
pub(super) fn apply_level(text: &str, scene: &Scene) -> Result<Option<String>, SceneError> {
    let fidelity = scene.scene.fidelity;
    let name = fidelity.as_str();
    let Some(level) = scene.fidelity.get(fidelity) else {
        let expected = format!(
            "\"standard\", or a table fidelity.{name}: `python -m ballistic_gel trade` measures it and prints the lines"
        );
        let unknown = SceneError::value("scene.fidelity", format!("{name:?}"), expected);
        let needs_none = matches!(fidelity, FidelityKind::Standard | FidelityKind::Instant);
        return if needs_none { Ok(None) } else { Err(unknown) };
    };
    if fidelity == FidelityKind::Standard && !level.set.is_empty() {
        let expected = "nothing: the level standard is the scene without changes";
        return Err(SceneError::value("fidelity.standard.set", format!("{:?}", level.set), expected));
    }
    if fidelity != FidelityKind::Standard && level.set.is_empty() {
        let expected = "a level that changes a value: overrides take precedence and replace all values of this level; \
                        omit one of them";
        return Err(SceneError::value("scene.fidelity", format!("{name:?}, which sets nothing"), expected));
    }
    let parsed: Result<Vec<Override>, SceneError> = level.set.iter().map(|set| set.parse()).collect();
    let made = parsed.and_then(|overrides| written(text, &overrides));
    made.map(|text| (!level.set.is_empty()).then_some(text)).map_err(|error| error_of_level(fidelity, level, &error))
}

/// Error of a level whose overrides do not make a valid scene.
pub(super) fn level_error(scene: &Scene, error: &SceneError) -> SceneError {
    let fidelity = scene.scene.fidelity;
    error_of_level(fidelity, scene.fidelity.get(fidelity).unwrap_or(&FidelityLevel::default()), error)
}

fn error_of_level(fidelity: FidelityKind, level: &FidelityLevel, error: &SceneError) -> SceneError {
    let at = SceneError { line: None, ..error.clone() };
    let key = format!("fidelity.{}.set", fidelity.as_str());
    SceneError::value(&key, format!("{:?} ({at})", level.set), "values that this scene can have")
}
