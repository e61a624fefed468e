//! Scalar variables: one component of a row of the variable table, for one body, with its start in a scene.

use super::table::{BLOCK, Source, Start, VARIABLES, Variable};
use crate::scene::{Scene, body_name, numbered};
use std::collections::BTreeMap;

/// Values by value reference.
pub(super) type ScalarValues = BTreeMap<u32, f64>;

/// Scalar variable. Body 0 is the projectile, the fragments follow from 1; a variable without a body has body 0. For
/// a sensor variable, `body` is the sensor, from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScalarVariable {
    /// Row of the variable table.
    pub variable: &'static Variable,
    /// Component, from 0.
    pub component: usize,
    /// Body or sensor.
    pub body: usize,
}

impl ScalarVariable {
    /// Returns the components of a row for one body.
    pub fn of(variable: &'static Variable, body: usize) -> impl Iterator<Item = Self> + Clone {
        (0..variable.size()).map(move |component| Self { variable, component, body })
    }

    /// Returns the scalar of a value reference, if any.
    #[must_use]
    pub fn find(reference: u32) -> Option<Self> {
        let (body, local) = (reference / BLOCK, reference % BLOCK);
        let row = VARIABLES.partition_point(|v| v.reference <= local).checked_sub(1)?;
        let variable = &VARIABLES[row];
        let component = (local - variable.reference) as usize;
        let exists = component < variable.size() && (body == 0 || variable.each || variable.is_of_sensors());
        exists.then_some(Self { variable, component, body: body as usize })
    }

    /// Returns the value reference.
    #[must_use]
    pub fn reference(&self) -> u32 {
        self.body as u32 * BLOCK + self.variable.reference + self.component as u32
    }

    /// Returns the name common to all components: `projectile.position`, `fragment[2].contact.force`.
    #[must_use]
    pub fn row_name(&self) -> String {
        let name = self.variable.name;
        if let Some(own) = self.variable.of_sensor() {
            return format!("{}.{own}", numbered("sensor", self.body));
        }
        if self.body == 0 { name.to_owned() } else { format!("{}.{}", body_name(self.body), without_projectile(name)) }
    }

    /// Returns the name: `contact.force[1]`, without index for a row of one component.
    #[must_use]
    pub fn name(&self) -> String {
        let name = self.row_name();
        if self.variable.length == 0 { name } else { format!("{name}[{}]", self.component + 1) }
    }

    /// Returns the name without its body or sensor: `position[1]`, `contact.force[1]`, `pressure`.
    #[must_use]
    pub fn member_name(&self) -> String {
        let name = self.variable.of_sensor().unwrap_or_else(|| without_projectile(self.variable.name));
        if self.variable.length == 0 { name.to_owned() } else { format!("{name}[{}]", self.component + 1) }
    }

    /// Returns the description.
    #[must_use]
    pub fn description(&self) -> String {
        let text = self.variable.component_description(self.component);
        if self.body == 0 { text } else { text.replace("the projectile", &format!("fragment {}", self.body)) }
    }

    /// Returns the first scene key whose table exists in the scene.
    #[must_use]
    pub(super) fn key_in(&self, scene: &toml::Table) -> Option<String> {
        let owns = |key: &String| key.rsplit_once('.').is_some_and(|(table, _)| find_key(scene, table).is_some());
        self.keys().find(owns)
    }

    /// Returns the scene keys of the start, in order of preference.
    pub(super) fn keys(&self) -> impl Iterator<Item = String> + '_ {
        self.variable.keys.iter().map(|key| match self.body {
            0 => (*key).to_owned(),
            body => format!("{}.{}", body_name(body), without_projectile(key)),
        })
    }

    /// Returns the start of a parameter or input in a scene: the value at its key, or the literal start. True counts
    /// as 1, an item of an Enumeration as its value; a String has no start here.
    #[must_use]
    pub fn start(&self, scene: &toml::Table) -> Option<f64> {
        let keyed = self.keys().find_map(|key| self.value_of(find_key(scene, &key)?));
        keyed.or(match self.variable.start {
            Some(Start::Real(value)) => Some(value),
            Some(Start::Integer(value)) => Some(f64::from(value)),
            Some(Start::Boolean(value)) => Some(f64::from(u8::from(value))),
            Some(Start::Text(_)) | None => None,
        })
    }
}

impl ScalarVariable {
    /// Converts a value of the scene to a number.
    fn value_of(&self, value: &toml::Value) -> Option<f64> {
        match value {
            toml::Value::String(name) => {
                self.variable.items().iter().find(|item| item.name == name).map(|item| item.value.into())
            }
            other => to_number(other, self.component),
        }
    }

    /// Formats a value as TOML.
    pub(super) fn toml(&self, value: f64) -> String {
        let item = self.variable.items().iter().find(|item| f64::from(item.value) == value);
        item.map_or_else(|| format!("{value:?}"), |item| format!("{:?}", item.name))
    }
}

/// Returns the part of a name or key behind `projectile.`.
fn without_projectile(name: &str) -> &str {
    name.strip_prefix("projectile.").unwrap_or(name)
}

/// Returns the scene as a TOML table with all defaults.
///
/// # Panics
/// If a scene cannot be written as TOML; the tables are plain values.
#[must_use]
pub fn table_of(scene: &Scene) -> toml::Table {
    toml::Table::try_from(scene).expect("a scene consists of tables, numbers and text")
}

/// Returns the value at a dotted key; `fragment[1]` is the first table of a list.
fn find_key<'a>(table: &'a toml::Table, key: &str) -> Option<&'a toml::Value> {
    let (first, rest) = key.split_once('.').map_or((key, None), |(a, b)| (a, Some(b)));
    let value = match first.strip_suffix(']').and_then(|first| first.split_once('[')) {
        Some((list, number)) => table.get(list)?.as_array()?.get(number.parse::<usize>().ok()?.checked_sub(1)?)?,
        None => table.get(first)?,
    };
    match rest {
        None => Some(value),
        Some(rest) => find_key(value.as_table()?, rest),
    }
}

fn to_number(value: &toml::Value, component: usize) -> Option<f64> {
    match value {
        toml::Value::Float(x) => Some(*x),
        toml::Value::Integer(x) => Some(*x as f64),
        toml::Value::Boolean(x) => Some(f64::from(u8::from(*x))),
        toml::Value::Array(items) => to_number(items.get(component)?, 0),
        toml::Value::String(_) | toml::Value::Datetime(_) | toml::Value::Table(_) => None,
    }
}

/// Returns the start values of the inputs of this number of bodies in a scene.
pub(super) fn input_start_values(n_bodies: usize, scene: &toml::Table) -> ScalarValues {
    let inputs = VARIABLES.iter().filter(|variable| matches!(variable.source, Source::Input(_)));
    let scalars = (0..n_bodies).flat_map(|body| inputs.clone().flat_map(move |row| ScalarVariable::of(row, body)));
    scalars.filter_map(|scalar| Some((scalar.reference(), scalar.start(scene)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_component_is_described_by_its_axis() {
        let scalar = ScalarVariable::find(102).unwrap();
        assert_eq!(scalar.name(), "projectile.position[3]");
        assert!(scalar.description().contains(", z, world frame"));
    }

    #[test]
    fn a_fragment_has_names_and_descriptions_of_its_own() {
        let names = [20_102, 20_200, 20_250, 20_030].map(|reference| ScalarVariable::find(reference).unwrap().name());
        let expected = ["position[3]", "contact.impulse[1]", "coupling.energy_residual", "mass"];
        let members = [102, 20_102, 10_404].map(|reference| ScalarVariable::find(reference).unwrap().member_name());
        assert_eq!(members, ["position[3]", "position[3]", "velocity[1]"]);
        assert_eq!(names, expected.map(|name| format!("fragment[2].{name}")));
        assert!(ScalarVariable::find(20_119).unwrap().description().starts_with("True if fragment 2 is active"));
    }

    #[test]
    fn a_sensor_has_its_own_place_in_a_block() {
        let names = [400, 10_403, 10_404].map(|reference| ScalarVariable::find(reference).unwrap().name());
        assert_eq!(names, ["sensor[1].pressure", "sensor[2].displacement[3]", "sensor[2].velocity[1]"]);
    }

    #[test]
    fn an_item_of_an_enumeration_stands_in_the_scene_by_its_name() {
        let mode = ScalarVariable::find(13).unwrap();
        let scene: toml::Table = toml::from_str("[coupling]\nmode = \"corrected\"").unwrap();
        assert_eq!((mode.start(&scene), mode.toml(3.0)), (Some(3.0), "\"corrected\"".into()));
        assert_eq!(mode.start(&toml::Table::new()), Some(2.0));
    }

    #[test]
    fn a_start_comes_from_the_first_key_that_the_scene_has() {
        let text = "[projectile.shape.cylinder]\nradius = 0.02\nlength = 1.0\n[[fragment]]\nmass = 2.0\nactive = false";
        let scene: toml::Table = toml::from_str(text).unwrap();
        let found = |reference: u32| {
            let scalar = ScalarVariable::find(reference).unwrap();
            (scalar.start(&scene), scalar.key_in(&scene))
        };
        assert_eq!(found(37), (Some(0.02), Some("projectile.shape.cylinder.radius".into())));
        assert_eq!(found(30), (Some(0.0), Some("projectile.mass".into())));
        assert_eq!(found(10_030), (Some(2.0), Some("fragment[1].mass".into())));
        assert_eq!((found(119).0, found(10_119).0), (Some(1.0), Some(0.0)));
        assert_eq!(found(20_030), (Some(0.0), None));
    }
}
