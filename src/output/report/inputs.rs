//! Inputs of a run with their sources: those of the shot in the units of the trade, and all values in SI units.

use super::format::{bullet_list, escape};
use super::shot_inputs;
use super::tables::{row, table};
use crate::scene::{self, LayerSpec, LibraryProjectile, Preset, PresetValue, ProjectileSpec, Scene};
use serde_json::Value;
use std::collections::HashMap;

/// Value of the scene with its dotted key.
struct InputValue {
    key: String,
    value: Value,
}

/// Value of a preset at its dotted key in the scene: of the gel, or of a layer.
struct PresetFact {
    key: String,
    fact: &'static PresetValue,
}

/// Sources of the values of a scene.
pub(super) struct ValueSources {
    /// Values of the presets of gel and layers that the material of the scene uses.
    facts: Vec<PresetFact>,
    /// True for each key of the presets whose value in the scene is that of the preset.
    own: HashMap<String, bool>,
    /// Dotted keys, or beginnings of them, of the values that are those of the library, with their sources.
    library: Vec<(String, String)>,
}

impl ValueSources {
    /// Returns where the value of a key, or of the keys below it, comes from, in a few words.
    pub(super) fn short(&self, key: &str) -> String {
        let is_at = |known: &str| {
            known.strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
                || key.strip_prefix(known).is_some_and(|rest| rest.starts_with('.'))
        };
        if self.library.iter().any(|(known, _)| is_at(known)) {
            return "library".to_owned();
        }
        let of_preset = self.facts.iter().any(|known| known.key == key && self.own.get(key) == Some(&true));
        if of_preset { "preset of the gel".to_owned() } else { "scene".to_owned() }
    }
}

/// Returns the section of the inputs: those of the shot, and folded all values of the scene with their sources.
pub(super) fn inputs(scene: &Scene, level: &str) -> String {
    let all = serde_json::to_value(scene).unwrap_or_default();
    let sources = sources(scene, &all);
    let shot = [("projectile", "Projectile"), ("fragment", "Fragments"), ("gel", "Gel"), ("layer", "Layers")];
    let rest = [
        ("scene", "Run"),
        ("mesh", "Mesh"),
        ("remesh", "Remeshing"),
        ("integrator", "Time integration"),
        ("contact", "Contact"),
        ("load", "Loads"),
        ("sensor", "Sensors"),
    ];
    let tables = |names: &[(&str, &str)]| -> String {
        names.iter().map(|(name, title)| input_table(name, title, &all[*name], &sources)).collect()
    };
    format!(
        "<section class=\"inputs\"><h2>Inputs</h2>\n{}<details class=\"values\"><summary>Projectile, gel and layers: all \
         values with their sources</summary>\n{}</details>\n<details class=\"values\"><summary>Mesh, remeshing, time \
         integration and contact</summary>\n{}</details>\n<details class=\"models\"><summary>Models</summary>\n{}</details></section>\n",
        shot_inputs::table(scene, level, &sources),
        tables(&shot),
        tables(&rest),
        bullet_list(&scene::modelled_physics(scene))
    )
}

/// Returns the sources of the values of a scene, which is also given as JSON.
fn sources(scene: &Scene, all: &Value) -> ValueSources {
    let facts = applicable_facts(scene);
    let is_own = |fact: &PresetFact| {
        let found = fact.key.split('.').try_fold(all, |value, name| value.get(name));
        found.is_some_and(|found| has_same_value(fact.fact.value, found))
    };
    let mut own: HashMap<String, bool> = facts.iter().map(|fact| (fact.key.clone(), is_own(fact))).collect();
    own.insert("gel.preset".to_owned(), scene.gel.preset.is_some());
    ValueSources { facts, own, library: library_sources(scene) }
}

/// Returns the values of the presets of gel and layers that the material of the scene uses.
fn applicable_facts(scene: &Scene) -> Vec<PresetFact> {
    let all = serde_json::to_value(scene).unwrap_or_default();
    let material = all["gel"]["material"].as_str().unwrap_or_default().to_owned();
    let of_table = |table: String, preset: Option<Preset>| {
        let facts = preset.map(Preset::facts).unwrap_or_default().iter();
        let keyed = facts
            .filter(|fact| fact.of.includes(&material))
            .filter_map(|fact| Some(PresetFact { key: format!("{table}.{}", fact.key.strip_prefix("gel.")?), fact }));
        keyed.collect::<Vec<_>>()
    };
    let of_layer = |(i, layer): (usize, &LayerSpec)| of_table(scene::numbered("layer", i), layer.preset);
    let of_layers = scene.layer.iter().enumerate().flat_map(of_layer);
    of_table("gel".to_owned(), scene.gel.preset).into_iter().chain(of_layers).collect()
}

/// Returns the sources of the bodies' values that are those of the library, by their dotted keys.
fn library_sources(scene: &Scene) -> Vec<(String, String)> {
    let of_body = |(i, body): (usize, &ProjectileSpec)| {
        let projectile = body.library.as_deref().and_then(LibraryProjectile::named);
        let values = projectile.iter().flat_map(|known| known.values_of(body));
        let keyed = values.map(|value| (format!("{}.{}", scene::body_name(i), value.key), value.source));
        keyed.collect::<Vec<_>>()
    };
    scene.bodies().enumerate().flat_map(of_body).collect()
}

fn input_table(name: &str, title: &str, values: &Value, sources: &ValueSources) -> String {
    let mut leaves = vec![];
    collect_leaves(name, values, &sources.facts, &mut leaves);
    let mut rows = String::new();
    let mut last = String::new();
    for leaf in &leaves {
        let (value, source) = (escape(&leaf.value.to_string()), escape(&source(leaf, sources)));
        let told = if source == last { "as above" } else { &source };
        row(&mut rows, &leaf.key, &[&format!("<code>{value}</code>"), told]);
        last = source;
    }
    if rows.is_empty() { rows } else { table(title, &["key", "value, SI units", "source"], &rows) }
}

/// Collects the values below a key; the value of a preset's key is one, even if it is a table.
fn collect_leaves(key: &str, value: &Value, facts: &[PresetFact], leaves: &mut Vec<InputValue>) {
    let is_fact = facts.iter().any(|fact| fact.key == key);
    match value {
        Value::Null => {}
        Value::Object(members) if !is_fact => {
            for (name, value) in members {
                collect_leaves(&format!("{key}.{name}"), value, facts, leaves);
            }
        }
        Value::Array(items) if items.iter().any(Value::is_object) && !is_fact => {
            for (i, item) in items.iter().enumerate() {
                collect_leaves(&format!("{key}[{}]", i + 1), item, facts, leaves);
            }
        }
        _ => leaves.push(InputValue { key: key.to_owned(), value: value.clone() }),
    }
}

/// Returns the source of a value: that of the preset or the library if the value is theirs, otherwise the scene.
fn source(leaf: &InputValue, sources: &ValueSources) -> String {
    let of_preset = |known: &&PresetFact| known.key == leaf.key && has_same_value(known.fact.value, &leaf.value);
    if let Some(known) = sources.facts.iter().find(of_preset) {
        return format!("preset: {}", known.fact.source);
    }
    let covers = |(key, _): &&(String, String)| {
        leaf.key.strip_prefix(key.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    let of_library = sources.library.iter().filter(covers).max_by_key(|(key, _)| key.len());
    of_library.map_or("scene, or default".to_owned(), |(_, source)| format!("library: {source}"))
}

/// Returns true if the TOML text of a value says the JSON value.
fn has_same_value(text: &str, value: &Value) -> bool {
    let parsed: Result<toml::Table, _> = format!("value = {text}").parse();
    let Ok(table) = parsed else { return false };
    let Ok(said) = serde_json::to_value(&table["value"]) else { return false };
    contains(value, &said)
}

/// Returns true if a value has all that is said of it; further members are defaults.
fn contains(value: &Value, said: &Value) -> bool {
    match (value, said) {
        (Value::Number(a), Value::Number(b)) => a.as_f64() == b.as_f64(),
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| contains(a, b)),
        (Value::Object(a), Value::Object(b)) => b.iter().all(|(name, b)| a.get(name).is_some_and(|a| contains(a, b))),
        (a, b) => a == b,
    }
}
