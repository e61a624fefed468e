//! From `variables.toml` to Rust: three enums (a missing `match` arm is a compile error) and the static table.

use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    unit: Vec<Unit>,
    enumeration: Vec<Enumeration>,
    variable: Vec<Variable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unit {
    name: String,
    base: BTreeMap<String, i32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Enumeration {
    name: String,
    description: String,
    items: Vec<Item>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Item {
    name: String,
    value: i32,
    description: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Variable {
    name: String,
    reference: u32,
    #[serde(default)]
    each: bool,
    r#type: String,
    causality: String,
    variability: Option<String>,
    unit: Option<String>,
    declared_type: Option<String>,
    min: Option<f64>,
    max: Option<f64>,
    #[serde(default)]
    keys: Vec<String>,
    start: Option<toml::Value>,
    description: String,
}

/// Value references of one body.
const BLOCK: u32 = 10_000;

/// Reads the table, checks it and writes the Rust source.
pub fn generate(table: &str, file: &Path) -> Result<(), String> {
    let text = fs::read_to_string(table).map_err(|e| format!("cannot read {table}: {e}"))?;
    let parsed: File = toml::from_str(&text).map_err(|e| format!("{table}: {e}"))?;
    check(&parsed).map_err(|e| format!("{table}: {e}"))?;
    fs::write(file, source(&parsed)?).map_err(|e| format!("cannot write {}: {e}", file.display()))
}

fn check(file: &File) -> Result<(), String> {
    let units: BTreeSet<&str> = file.unit.iter().map(|u| u.name.as_str()).collect();
    let types: BTreeSet<&str> = file.enumeration.iter().map(|e| e.name.as_str()).collect();
    let (mut names, mut next) = (BTreeSet::new(), 1);
    for variable in &file.variable {
        let (name, length) = array(&variable.name)?;
        if !names.insert(name) {
            return Err(format!("{name}: the name stands twice"));
        }
        if variable.reference < next {
            return Err(format!("{name}: reference {} is taken or out of order: {next} is free", variable.reference));
        }
        if variable.reference >= BLOCK {
            return Err(format!("{name}: references from {BLOCK} on belong to the fragments"));
        }
        next = variable.reference + u32::try_from(length.max(1)).map_err(|e| e.to_string())?;
        check_one(variable, &units, &types).map_err(|e| format!("{name}: {e}"))?;
    }
    Ok(())
}

fn check_one(variable: &Variable, units: &BTreeSet<&str>, types: &BTreeSet<&str>) -> Result<(), String> {
    let unit = variable.unit.as_deref();
    if (variable.r#type == "Real") != unit.is_some() || unit.is_some_and(|u| !units.contains(u)) {
        return Err(format!("a Real needs a unit of the table and nothing else has one; found {unit:?}"));
    }
    let declared = variable.declared_type.as_deref();
    if (variable.r#type == "Enumeration") != declared.is_some() || declared.is_some_and(|t| !types.contains(t)) {
        return Err(format!("an Enumeration needs a declared_type of the table; found {declared:?}"));
    }
    let given = matches!(variable.causality.as_str(), "parameter" | "input");
    if given && variable.start.is_none() && variable.keys.is_empty() {
        return Err(format!("a {} needs a start or keys of the scene", variable.causality));
    }
    if !given && (variable.start.is_some() || !variable.keys.is_empty()) {
        return Err(format!("a {} has no start", variable.causality));
    }
    if let (Some(min), Some(max)) = (variable.min, variable.max)
        && min > max
    {
        return Err(format!("min {min} is above max {max}"));
    }
    if variable.description.trim().is_empty() {
        return Err("a variable needs a description".to_string());
    }
    Ok(())
}

/// Name and length of `name[1..n]`; length 0 for a scalar.
fn array(name: &str) -> Result<(&str, usize), String> {
    let Some((name, rest)) = name.split_once('[') else { return Ok((name, 0)) };
    let length = rest.strip_prefix("1..").and_then(|r| r.strip_suffix(']')).and_then(|n| n.parse().ok());
    length.map(|n| (name, n)).ok_or_else(|| format!("{name}[{rest}: an array is written name[1..n]"))
}

fn source(file: &File) -> Result<String, String> {
    let mut out = format!("/// Value references of one body.\npub const BLOCK: u32 = {BLOCK};\n");
    enumeration(&mut out, "Setting", "A parameter that no scene key stands for.", file)?;
    enumeration(&mut out, "Input", "An input.", file)?;
    enumeration(&mut out, "Observed", "What is computed.", file)?;
    let _ = writeln!(out, "/// Every variable, by ascending value reference.\npub static VARIABLES: &[Variable] = &[");
    for variable in &file.variable {
        out += &row(variable)?;
    }
    out += "];\n";
    units(&mut out, &file.unit);
    types(&mut out, &file.enumeration);
    Ok(out)
}

/// Which of the three enums a variable belongs to; an overridden scene key belongs to none.
fn family(variable: &Variable) -> Option<&'static str> {
    match variable.causality.as_str() {
        "parameter" if variable.keys.is_empty() => Some("Setting"),
        "parameter" => None,
        "input" => Some("Input"),
        _ => Some("Observed"),
    }
}

fn enumeration(out: &mut String, name: &str, doc: &str, file: &File) -> Result<(), String> {
    // The names are those of the variables, whatever they have in common.
    let attributes = "#[derive(Debug, Clone, Copy, PartialEq, Eq)]\n#[allow(clippy::enum_variant_names)]";
    let _ = writeln!(out, "/// {doc}\n{attributes}\npub enum {name} {{");
    for variable in file.variable.iter().filter(|v| family(v) == Some(name)) {
        let (plain, _) = array(&variable.name)?;
        let _ = writeln!(out, "/// `{plain}`.\n{},", camel(plain));
    }
    out.push_str("}\n");
    Ok(())
}

fn row(variable: &Variable) -> Result<String, String> {
    let (name, length) = array(&variable.name)?;
    let source = match family(variable) {
        Some(family) => format!("Source::{family}({family}::{})", camel(name)),
        None => "Source::Scene".to_string(),
    };
    let fixed = matches!(variable.causality.as_str(), "parameter" | "calculatedParameter");
    let default = if fixed { "fixed" } else { "continuous" };
    Ok(format!(
        "Variable {{ name: {name:?}, length: {length}, reference: {}, each: {}, kind: Kind::{}, causality: Causality::{}, \
         variability: {:?}, unit: {:?}, declared_type: {:?}, min: {:?}, max: {:?}, keys: &{:?}, start: {}, source: {source}, \
         description: {:?} }},\n",
        variable.reference,
        variable.each,
        variable.r#type,
        camel(&variable.causality),
        variable.variability.as_deref().unwrap_or(default),
        variable.unit,
        variable.declared_type,
        variable.min,
        variable.max,
        variable.keys,
        start(variable)?,
        variable.description,
    ))
}

fn start(variable: &Variable) -> Result<String, String> {
    match &variable.start {
        None => Ok("None".to_string()),
        Some(toml::Value::Float(value)) => Ok(format!("Some(Start::Real({value:?}))")),
        Some(toml::Value::Integer(value)) => Ok(format!("Some(Start::Integer({value}))")),
        Some(toml::Value::String(value)) => Ok(format!("Some(Start::Text({value:?}))")),
        Some(toml::Value::Boolean(value)) => Ok(format!("Some(Start::Boolean({value:?}))")),
        Some(other) => Err(format!("{}: start = {other} is no float, integer, string, true or false", variable.name)),
    }
}

fn units(out: &mut String, units: &[Unit]) {
    let _ = writeln!(out, "/// Every unit.\npub static UNITS: &[Unit] = &[");
    for unit in units {
        let base: Vec<(&String, &i32)> = unit.base.iter().collect();
        let _ = writeln!(out, "Unit {{ name: {:?}, base: &{base:?} }},", unit.name);
    }
    out.push_str("];\n");
}

fn types(out: &mut String, enumerations: &[Enumeration]) {
    let _ = writeln!(out, "/// Every enumeration.\npub static ENUMERATIONS: &[Enumeration] = &[");
    for e in enumerations {
        let items: Vec<String> = e
            .items
            .iter()
            .map(|i| format!("Item {{ name: {:?}, value: {}, description: {:?} }}", i.name, i.value, i.description))
            .collect();
        let (name, text, items) = (&e.name, &e.description, items.join(", "));
        let _ = writeln!(out, "Enumeration {{ name: {name:?}, description: {text:?}, items: &[{items}] }},");
    }
    out.push_str("];\n");
}

/// `projectile.initial_position` becomes `ProjectileInitialPosition`.
fn camel(name: &str) -> String {
    let words = name.split(['.', '_']).filter(|w| !w.is_empty());
    words.map(|w| w[..1].to_uppercase() + &w[1..]).collect()
}
