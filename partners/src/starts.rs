//! `resources/starts.toml` of a packed partner: the start values that differ from those of its table.

use super::table::{Causality, Model, place};
use std::path::PathBuf;
use toml::{Table, Value};

/// Name of the file in `resources/`.
pub const FILE: &str = "starts.toml";

/// Returns the start values of all components: those of the text, else those of the table.
pub fn read(model: &Model, text: &str) -> Result<Vec<f64>, String> {
    let table: Table = text.parse().map_err(|error| format!("{FILE}: {error}"))?;
    let mut values = model.values();
    for (name, value) in &table {
        let variable = model.variables.iter().find(|variable| variable.name == name);
        let settable = |causality| matches!(causality, Causality::Parameter | Causality::Input);
        let size = variable.filter(|variable| settable(variable.causality)).map(|variable| variable.start.len());
        let size = size.ok_or_else(|| format!("{FILE}: {name}: found no parameter or input of this name"))?;
        let numbers = numbers(value).filter(|numbers| numbers.len() == size);
        let numbers = numbers.ok_or_else(|| format!("{FILE}: {name}: found {value}, expected {size} numbers"))?;
        values[place(model.variables, name)..][..size].copy_from_slice(&numbers);
    }
    Ok(values)
}

/// Returns a number, or a list of them, as a list.
fn numbers(value: &Value) -> Option<Vec<f64>> {
    match value {
        Value::Array(list) => list.iter().map(Value::as_float).collect(),
        single => Some(vec![single.as_float()?]),
    }
}

/// Returns the text that gives these start values.
#[allow(dead_code, reason = "only what packs the partners writes it")]
pub fn written(model: &Model, values: &[f64]) -> String {
    let mut table = Table::new();
    for variable in model.variables {
        let own = &values[place(model.variables, variable.name)..][..variable.start.len()];
        if own != variable.start {
            let list = own.iter().copied().map(Value::Float).collect();
            table.insert(variable.name.to_owned(), Value::Array(list));
        }
    }
    table.to_string()
}

/// Reads the start values in the resource location of an unpacked FMU, a URI.
#[allow(dead_code, reason = "what packs the partners loads none")]
pub fn at(model: &Model, location: Option<&str>) -> Result<Vec<f64>, String> {
    let folder = location.and_then(path_of).ok_or_else(|| {
        let found = location.map_or_else(|| "none".to_owned(), |uri| format!("{uri:?}"));
        format!("fmuResourceLocation: found {found}, expected the URI of the folder resources of the unpacked FMU")
    })?;
    let file = folder.join(FILE);
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    read(model, &text)
}

/// Returns the path of a `file:` URI, percent-decoded.
fn path_of(uri: &str) -> Option<PathBuf> {
    let path = uri.strip_prefix("file:")?;
    let path = path.strip_prefix("//localhost").or_else(|| path.strip_prefix("//")).unwrap_or(path);
    let (mut bytes, mut decoded) = (path.bytes(), Vec::with_capacity(path.len()));
    while let Some(byte) = bytes.next() {
        let hex = |digit: Option<u8>| (digit? as char).to_digit(16);
        decoded.push(if byte == b'%' { (16 * hex(bytes.next())? + hex(bytes.next())?) as u8 } else { byte });
    }
    let path = String::from_utf8(decoded).ok()?;
    let has_drive = cfg!(windows) && path.as_bytes().get(2) == Some(&b':');
    path.starts_with('/').then(|| PathBuf::from(if has_drive { &path[1..] } else { &path }))
}
