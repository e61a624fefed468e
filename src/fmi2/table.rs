//! The table of variables, made by `build.rs` from `modelDescription/variables.toml`.

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
    /// Whether every body has it.
    pub each: bool,
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
    /// Of a Boolean.
    Boolean(bool),
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

    /// Whether every sensor has it.
    #[must_use]
    pub fn is_of_sensors(&self) -> bool {
        self.of_sensor().is_some()
    }

    /// Its name behind `sensor.`, if every sensor has it.
    pub(super) fn of_sensor(&self) -> Option<&'static str> {
        self.name.strip_prefix("sensor.")
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

/// The variable with this source.
///
/// # Panics
/// If the table has no such row; the sources are made from the rows.
#[must_use]
pub(super) fn row(source: Source) -> &'static Variable {
    VARIABLES.iter().find(|v| v.source == source).expect("each source is made from a row of the table")
}
