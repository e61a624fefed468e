//! Subcommands that print one document: `scenes`, `schema` and `completions`.

use crate::console::Console;
use crate::failure::CommandError;
use crate::{completions, source};
use ballistic_gel::scene;
use clap_complete::Shell;
use comfy_table::{Table, presets};
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
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    let mut rows = Vec::new();
    for (name, _) in scene::builtins() {
        let header = source::load(name, &[])?.scene.scene;
        table.add_row([name, &header.title]);
        rows.push(json!({ "name": name, "title": header.title, "dimension": header.dimension }));
    }
    console.document(&Value::Array(rows), &table.to_string());
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

/// Prints the JSON schema of scene files.
pub fn schema(console: &Console) {
    let schema = scene::schema();
    console.document(&schema, &format!("{schema:#}"));
}

/// Prints a shell completion script.
pub fn completions(shell: Shell, console: &Console) {
    let script = completions::completion_script(shell);
    console.document(&json!({ "shell": shell.to_string(), "script": script }), &script);
}
