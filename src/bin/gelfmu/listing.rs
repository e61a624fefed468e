//! Subcommands that print one document: `scenes`, `schema` and `completions`.

use crate::console::Console;
use crate::failure::CommandError;
use crate::new::named_projectile;
use crate::options::SchemaFile;
use crate::text_width::{keep_names_whole, new_table};
use crate::{completions, source};
use ballistic_gel::output::{self, UnitSystem};
use ballistic_gel::scene::{self, LibraryProjectile};
use clap_complete::Shell;
use comfy_table::presets;
use serde_json::{Value, json};

/// Lists the built-in scenes, or prints the named one.
pub fn scenes(name: Option<&str>, console: &Console) -> Result<(), CommandError> {
    match name {
        None => list_scenes(console)?,
        Some(name) => {
            let text = scene::builtin(name).ok_or_else(|| unknown_scene(name))?;
            console.document(&json!({ "name": name, "text": text }), text);
        }
    }
    Ok(())
}

fn list_scenes(console: &Console) -> Result<(), CommandError> {
    let mut table = new_table(presets::NOTHING);
    let mut rows = Vec::new();
    for (name, _) in scene::builtins() {
        let header = source::load(name, &[])?.scene.scene;
        table.add_row([name, &header.title]);
        rows.push(json!({ "name": name, "title": header.title, "dimension": header.dimension }));
    }
    keep_names_whole(&mut table);
    console.document(&Value::Array(rows), &table.trim_fmt());
    Ok(())
}

fn unknown_scene(name: &str) -> CommandError {
    let known: Vec<&str> = scene::builtins().map(|(name, _)| name).collect();
    let hint = scene::did_you_mean(name, known.iter().copied());
    CommandError::BadInput(format!(
        "scene {name}: found no built-in scene of this name{hint}, expected one of {}",
        known.join(", ")
    ))
}

/// Lists the projectiles of the library, or prints the named one with its sources.
pub fn projectiles(name: Option<&str>, units: UnitSystem, console: &Console) -> Result<(), CommandError> {
    let Some(name) = name else {
        list_projectiles(units, console);
        return Ok(());
    };
    let projectile = named_projectile(name)?;
    let text = scene::library().find(|(known, _)| *known == name).map_or("", |(_, text)| text);
    console.document(&json!(projectile), text);
    Ok(())
}

fn list_projectiles(units: UnitSystem, console: &Console) {
    let mut table = new_table(presets::NOTHING);
    let mut rows = Vec::new();
    for projectile in scene::library().filter_map(|(name, _)| LibraryProjectile::named(name)) {
        let LibraryProjectile { name, title, kind, speed, mass, .. } = projectile;
        table.add_row([name.clone(), units.format_mass(mass), units.format_speed(speed, 0), title.clone()]);
        rows.push(json!({ "name": name, "title": title, "kind": kind, "speed": speed, "mass": mass }));
    }
    keep_names_whole(&mut table);
    console.document(&Value::Array(rows), &table.trim_fmt());
}

/// Prints the JSON schema of a file.
pub fn schema(of: SchemaFile, console: &Console) {
    let schema = match of {
        SchemaFile::Scene => scene::schema(),
        SchemaFile::Summary => output::summary_schema(),
    };
    console.document(&schema, &format!("{schema:#}"));
}

/// Prints a shell completion script.
pub fn completions(shell: Shell, console: &Console) {
    let script = completions::completion_script(shell);
    console.document(&json!({ "shell": shell.to_string(), "script": script }), &script);
}
