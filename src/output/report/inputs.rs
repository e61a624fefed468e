//! Inputs of a run with their sources, and the range in which the gel is valid.

use super::format::{bullet_list, escape};
use super::tables::{row, table};
use crate::output::summary::RunSummary;
use crate::scene::{self, LayerSpec, LibraryProjectile, Preset, PresetValue, ProjectileSpec, Scene, ShotClass};
use serde_json::Value;

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
struct ValueSources {
    /// Values of the presets of gel and layers that the material of the scene uses.
    facts: Vec<PresetFact>,
    /// Dotted keys, or beginnings of them, of the values that are those of the library, with their sources.
    library: Vec<(String, String)>,
}

/// Returns the section of the inputs: projectile, gel, layers and discretisation, each value with its source.
pub(super) fn inputs(scene: &Scene) -> String {
    let all = serde_json::to_value(scene).unwrap_or_default();
    let sources = ValueSources { facts: applicable_facts(scene), library: library_sources(scene) };
    let open = [("projectile", "Projectile"), ("fragment", "Fragments"), ("gel", "Gel"), ("layer", "Layers")];
    let folded = [
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
        "<section><h2>Inputs</h2>\n{}<details><summary>Mesh, remeshing, time integration and contact</summary>\n{}</details>\n\
         <details><summary>Models</summary>\n{}</details></section>\n",
        tables(&open),
        tables(&folded),
        bullet_list(&scene::modelled_physics(scene))
    )
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
    for leaf in &leaves {
        let value = escape(&leaf.value.to_string());
        row(&mut rows, &leaf.key, &[&format!("<code>{value}</code>"), &escape(&source(leaf, sources))]);
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

/// Returns the sentence on the model error of shots like this one; empty where it is not known.
fn model_error(scene: &Scene) -> String {
    let told = |class: &ShotClass| {
        let class = escape(&class.to_string());
        format!("<p>Model error of the gel, root mean square over shots of this class: {class}.</p>\n")
    };
    scene::shot_class(scene, 0).map_or(String::new(), told)
}

/// Returns the section of validity: the data behind the gel, the doubts and the effects switched off.
pub(super) fn validity(scene: &Scene, summary: &RunSummary) -> String {
    let gel = match scene.gel.preset {
        Some(preset) => {
            let shots = preset.shots();
            format!(
                "<p>The gel <code>{}</code> is fitted to {}. It is validated on {}. The tags stand in \
                 <code>docs/materials.md</code>.</p>\n{}",
                preset.name(),
                escape(shots.fitted),
                escape(shots.validated),
                model_error(scene)
            )
        }
        None => "<p>The gel is not a preset: its values are those of the scene, and nothing is known of their \
                 validity.</p>\n"
            .to_owned(),
    };
    let doubts = if summary.doubts.is_empty() {
        "<p>No reason to doubt the figures was found.</p>\n".to_owned()
    } else {
        format!("<p>Reasons to doubt the figures:</p>\n<div class=\"doubts\">{}</div>\n", bullet_list(&summary.doubts))
    };
    format!("<section><h2>Validity</h2>\n{gel}{doubts}</section>\n")
}
