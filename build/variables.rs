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
    nominal: f64,
    display: Option<DisplayUnit>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DisplayUnit {
    name: String,
    factor: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Enumeration {
    name: String,
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
    #[serde(default)]
    details: String,
    #[serde(default)]
    outputs: Vec<String>,
}

/// Value references of one body.
const BLOCK: u32 = 10_000;
/// Length of a description from which some importers cut it.
const LONG_DESCRIPTION: usize = 100;
/// Sets of outputs that a variable can be in; every output is in `full`.
const OUTPUT_SETS: [&str; 2] = ["integrated", "corrected"];

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
        check_items(variable, &file.enumeration).map_err(|e| format!("{name}: {e}"))?;
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
    if let Some(unknown) = variable.outputs.iter().find(|set| !OUTPUT_SETS.contains(&set.as_str())) {
        return Err(format!("{unknown} is no set of outputs; expected of {OUTPUT_SETS:?}"));
    }
    if !variable.outputs.is_empty() && variable.causality != "output" {
        return Err(format!("a {} is in no set of outputs", variable.causality));
    }
    check_description(&variable.description)
}

/// Checks that the description of an Enumeration names its items.
fn check_items(variable: &Variable, enumerations: &[Enumeration]) -> Result<(), String> {
    let own = enumerations.iter().filter(|enumeration| Some(&enumeration.name) == variable.declared_type.as_ref());
    let named = |item: &&Item| variable.description.contains(&format!("{} {}", item.value, item.name));
    match own.flat_map(|enumeration| &enumeration.items).find(|item| !named(item)) {
        Some(item) => Err(format!("the description does not name the item {} {}", item.value, item.name)),
        None => Ok(()),
    }
}

/// Checks the description with the longest choice of `{x|y|z}`.
fn check_description(text: &str) -> Result<(), String> {
    let (before, rest) = text.split_once('{').unwrap_or((text, ""));
    let (choice, after) = rest.split_once('}').unwrap_or(("", rest));
    let length = |text: &str| text.chars().count();
    let choice = choice.split('|').map(length).max().unwrap_or(0);
    match length(before) + choice + length(after) {
        0 => Err("a variable needs a description".to_string()),
        length if length >= LONG_DESCRIPTION => Err(format!(
            "the description has {length} characters, expected less than {LONG_DESCRIPTION}: move the rest to details"
        )),
        _ => Ok(()),
    }
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
    enumeration(&mut out, "EnergyAccount", "An account of the energy balance.", file)?;
    let _ = writeln!(out, "/// Every variable, by ascending value reference.\npub static VARIABLES: &[Variable] = &[");
    for variable in &file.variable {
        out += &row(variable)?;
    }
    out += "];\n";
    units(&mut out, &file.unit);
    types(&mut out, &file.enumeration);
    Ok(out)
}

/// Beginning of the names of the energy accounts.
const ENERGY: &str = "energy.";

/// Enum that a variable belongs to; an overridden scene key belongs to none.
fn family(variable: &Variable) -> Option<&'static str> {
    match variable.causality.as_str() {
        "parameter" if variable.keys.is_empty() => Some("Setting"),
        "parameter" => None,
        "input" => Some("Input"),
        _ if variable.name.starts_with(ENERGY) => Some("EnergyAccount"),
        _ => Some("Observed"),
    }
}

fn enumeration(out: &mut String, name: &str, doc: &str, file: &File) -> Result<(), String> {
    // The names are those of the variables, whatever they have in common.
    let attributes = "#[derive(Debug, Clone, Copy, PartialEq, Eq)]\n#[allow(clippy::enum_variant_names)]";
    let _ = writeln!(out, "/// {doc}\n{attributes}\npub enum {name} {{");
    for variable in file.variable.iter().filter(|v| family(v) == Some(name)) {
        let (plain, _) = array(&variable.name)?;
        let _ = writeln!(out, "/// `{plain}`.\n{},", camel(plain.strip_prefix(ENERGY).unwrap_or(plain)));
    }
    if name == "Observed" {
        out.push_str("/// Account of the energy balance.\nEnergy(EnergyAccount),\n");
    }
    out.push_str("}\n");
    Ok(())
}

fn row(variable: &Variable) -> Result<String, String> {
    let (name, length) = array(&variable.name)?;
    let source = match family(variable) {
        Some("EnergyAccount") => {
            let account = camel(name.strip_prefix(ENERGY).unwrap_or(name));
            format!("Source::Observed(Observed::Energy(EnergyAccount::{account}))")
        }
        Some(family) => format!("Source::{family}({family}::{})", camel(name)),
        None => "Source::Scene".to_string(),
    };
    let fixed = matches!(variable.causality.as_str(), "parameter" | "calculatedParameter");
    let default = if fixed { "fixed" } else { "continuous" };
    Ok(format!(
        "Variable {{ name: {name:?}, length: {length}, reference: {}, each: {}, kind: Kind::{}, causality: Causality::{}, \
         variability: {:?}, unit: {:?}, declared_type: {:?}, min: {:?}, max: {:?}, keys: &{:?}, start: {}, source: {source}, \
         description: {:?}, details: {:?}, outputs: &[{}] }},\n",
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
        variable.details,
        variable.outputs.iter().map(|set| format!("OutputSet::{}", camel(set))).collect::<Vec<String>>().join(", "),
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
        let display = unit.display.as_ref().map_or("None".to_owned(), |DisplayUnit { name, factor }| {
            format!("Some(DisplayUnit {{ name: {name:?}, factor: {factor:e} }})")
        });
        let (name, nominal) = (&unit.name, unit.nominal);
        let _ = writeln!(out, "Unit {{ name: {name:?}, base: &{base:?}, nominal: {nominal:e}, display: {display} }},");
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
        let (name, items) = (&e.name, items.join(", "));
        let _ = writeln!(out, "Enumeration {{ name: {name:?}, items: &[{items}] }},");
    }
    out.push_str("];\n");
}

/// `projectile.initial_position` becomes `ProjectileInitialPosition`.
fn camel(name: &str) -> String {
    let words = name.split(['.', '_']).filter(|w| !w.is_empty());
    words.map(|w| w[..1].to_uppercase() + &w[1..]).collect()
}
