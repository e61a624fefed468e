//! The table of variables, made by `build.rs` from `modelDescription/variables.toml`.

use crate::scene::Scene;

include!(concat!(env!("OUT_DIR"), "/variables.rs"));

/// One row: a scalar, or an array whose components have consecutive value references.
#[derive(Debug, PartialEq)]
pub struct Variable {
    /// Name without indices.
    pub name: &'static str,
    /// Components; 0 for a scalar.
    pub length: u32,
    /// Value reference of the first component.
    pub reference: u32,
    /// Type.
    pub kind: Kind,
    /// Role.
    pub causality: Causality,
    /// `fixed`, `discrete` or `continuous`.
    pub variability: &'static str,
    /// Unit of a Real.
    pub unit: Option<&'static str>,
    /// Enumeration that it is of.
    pub declared_type: Option<&'static str>,
    /// Least value.
    pub min: Option<f64>,
    /// Greatest value.
    pub max: Option<f64>,
    /// Scene keys of the start, in order of preference.
    pub keys: &'static [&'static str],
    /// Start where the scene has none of the keys.
    pub start: Option<Start>,
    /// Where its value comes from.
    pub source: Source,
    description: &'static str,
}

/// Type of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Double precision.
    Real,
    /// 32 bits.
    Integer,
    /// True or false.
    Boolean,
    /// UTF-8 text.
    String,
    /// Named integers.
    Enumeration,
}

/// Role of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Time.
    Independent,
    /// Set before the start.
    Parameter,
    /// Computed once from parameters.
    CalculatedParameter,
    /// Set at every step.
    Input,
    /// Given back after every step.
    Output,
    /// To be looked at.
    Local,
}

/// Where the value of a variable comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// A parameter of its own.
    Setting(Setting),
    /// A scene key that a parameter overrides.
    Scene,
    /// What the importer set.
    Input(Input),
    /// The simulation.
    Observed(Observed),
}

/// A literal start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start {
    /// Of a Real.
    Real(f64),
    /// Of an Integer or Enumeration.
    Integer(i32),
    /// Of a String.
    Text(&'static str),
}

/// A unit by SI base units and exponents.
#[derive(Debug, PartialEq)]
pub struct Unit {
    /// ASCII name.
    pub name: &'static str,
    /// Base unit and exponent.
    pub base: &'static [(&'static str, i32)],
}

/// A type of named integers.
#[derive(Debug, PartialEq)]
pub struct Enumeration {
    /// Name.
    pub name: &'static str,
    /// What it chooses.
    pub description: &'static str,
    /// Its values.
    pub items: &'static [Item],
}

/// One value of an enumeration.
#[derive(Debug, PartialEq)]
pub struct Item {
    /// Name.
    pub name: &'static str,
    /// Number.
    pub value: i32,
    /// What it means.
    pub description: &'static str,
}

impl Variable {
    /// Number of components, 1 for a scalar.
    #[must_use]
    pub fn size(&self) -> usize {
        self.length.max(1) as usize
    }

    /// Name of one component, from 0: `contact.force[1]`, or the plain name of a scalar.
    #[must_use]
    pub fn component_name(&self, component: usize) -> String {
        if self.length == 0 { self.name.to_string() } else { format!("{}[{}]", self.name, component + 1) }
    }

    /// What it is; `{x|y|z}` stands for the component.
    #[must_use]
    pub fn description(&self) -> &'static str {
        self.description
    }

    /// Description of one component: of `{x|y|z}` the one that it is.
    #[must_use]
    pub fn component_description(&self, component: usize) -> String {
        let Some((before, rest)) = self.description.split_once('{') else { return self.description.to_string() };
        let Some((choice, after)) = rest.split_once('}') else { return self.description.to_string() };
        format!("{before}{}{after}", choice.split('|').nth(component).unwrap_or(choice))
    }
}

/// The variable and the component, from 0, that a value reference stands for.
#[must_use]
pub(super) fn find(reference: u32) -> Option<(&'static Variable, usize)> {
    let row = VARIABLES.partition_point(|v| v.reference <= reference).checked_sub(1)?;
    let variable = &VARIABLES[row];
    let component = (reference - variable.reference) as usize;
    (component < variable.size()).then_some((variable, component))
}

/// The variable with this source.
///
/// # Panics
/// If the table has no such row; the sources are made from the rows.
#[must_use]
pub(super) fn row(source: Source) -> &'static Variable {
    VARIABLES.iter().find(|v| v.source == source).expect("each source is made from a row of the table")
}

/// Start of a Real parameter or input with the scene: the value at its key, or the literal one.
#[must_use]
pub fn start_of(variable: &Variable, component: usize, scene: &toml::Table) -> Option<f64> {
    let keyed = variable.keys.iter().find_map(|key| number(lookup(scene, key)?, component));
    keyed.or(match variable.start {
        Some(Start::Real(value)) => Some(value),
        Some(Start::Integer(_) | Start::Text(_)) | None => None,
    })
}

/// The first of the variable's keys that the scene has, or could have beside the tables it has.
#[must_use]
pub(super) fn key_in(variable: &Variable, scene: &toml::Table) -> Option<&'static str> {
    let owns = |key: &&&str| key.rsplit_once('.').is_some_and(|(table, _)| lookup(scene, table).is_some());
    variable.keys.iter().find(owns).copied()
}

/// The scene as a table of TOML, every default filled in.
///
/// # Panics
/// If a scene cannot be written as TOML; its tables are plain values.
#[must_use]
pub fn table_of(scene: &Scene) -> toml::Table {
    toml::Table::try_from(scene).expect("a scene consists of tables, numbers and text")
}

fn lookup<'a>(table: &'a toml::Table, key: &str) -> Option<&'a toml::Value> {
    let (first, rest) = key.split_once('.').map_or((key, None), |(a, b)| (a, Some(b)));
    match (table.get(first)?, rest) {
        (value, None) => Some(value),
        (toml::Value::Table(inner), Some(rest)) => lookup(inner, rest),
        (_, Some(_)) => None,
    }
}

fn number(value: &toml::Value, component: usize) -> Option<f64> {
    match value {
        toml::Value::Float(x) => Some(*x),
        toml::Value::Integer(x) => Some(*x as f64),
        toml::Value::Array(items) => number(items.get(component)?, 0),
        toml::Value::String(_) | toml::Value::Boolean(_) | toml::Value::Datetime(_) | toml::Value::Table(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reference_finds_its_own_component() {
        for variable in VARIABLES {
            for component in 0..variable.size() {
                let (found, at) = find(variable.reference + component as u32).unwrap();
                assert_eq!((found.name, at), (variable.name, component));
            }
        }
        assert_eq!(find(0), None);
        assert_eq!(find(9_999), None);
    }

    #[test]
    fn a_component_is_described_by_its_axis() {
        let (variable, _) = find(100).unwrap();
        assert_eq!(variable.component_name(2), "projectile.position[3]");
        assert!(variable.component_description(2).contains(", z, world frame"));
    }

    #[test]
    fn a_start_comes_from_the_first_key_that_the_scene_has() {
        let scene: toml::Table = toml::from_str("[projectile.shape.cylinder]\nradius = 0.02\nlength = 1.0").unwrap();
        let (radius, _) = find(37).unwrap();
        assert_eq!(start_of(radius, 0, &scene), Some(0.02));
        assert_eq!(key_in(radius, &scene), Some("projectile.shape.cylinder.radius"));
        let (mass, _) = find(30).unwrap();
        assert_eq!(start_of(mass, 0, &scene), Some(0.0));
        assert_eq!(key_in(mass, &scene), Some("projectile.mass"));
    }
}
