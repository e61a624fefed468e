//! Subcommands that print or write one document: `scenes`, `schema`, `completions` and `pack`.

use crate::console::Console;
use crate::failure::CommandError;
use crate::job::RunError;
use crate::options::{DEFAULT_SCENE, PackOptions};
use crate::{completions, pack, results, source};
use ballistic_gel::fmi2::VariablePorts;
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

/// Writes the FMU of a scene.
pub fn pack(options: &PackOptions, console: &Console) -> Result<(), CommandError> {
    let name = options.named.as_deref().or(options.scene.as_deref()).unwrap_or(DEFAULT_SCENE);
    let source = source::load_for_fmu(name, &options.set)?;
    source::note_former_keys(&source, console);
    results::check_archive(&options.out, &results::inputs(name, &source))?;
    let available = VariablePorts::of(&source.scene);
    let ports = VariablePorts {
        fragments: count_ports("fragment", "body", options.fragments, available.fragments)?,
        sensors: count_ports("sensor", "sensor", options.sensors, available.sensors)?,
    };
    let packed = pack::pack((&source.text, &source.folder), ports, &options.out).map_err(|error| match error {
        RunError::File { path, source, .. } => CommandError::BadInput(format!(
            "--out {}: found {source} at {}, expected a file that can be written",
            options.out.display(),
            path.display()
        )),
        other => other.into(),
    })?;
    let file = options.out.display().to_string();
    let value = json!({ "file": file, "bytes": packed.bytes, "platform": packed.platform });
    let text = format!("{file}: {} bytes, scene {}, for {}", packed.bytes, source.scene.scene.name, packed.platform);
    console.result(&value, &text);
    if packed.is_development {
        console.warning(&format!(
            "this FMU holds the library of a development build: the same bits, some percent slower; {} makes a gelfmu for FMUs to give away",
            pack::INSTALLATION
        ));
    }
    Ok(())
}

/// Returns the number of ports of a kind: the requested number, at most the number of tables; by default all.
fn count_ports(table: &str, needs: &str, asked: Option<usize>, available: usize) -> Result<usize, CommandError> {
    match asked {
        Some(asked) if asked > available => {
            let expected = format!("at most the [[{table}]] tables of the scene, {available}: a port needs a {needs}");
            Err(CommandError::BadInput(format!("--{table}s: found {asked}, expected {expected}")))
        }
        asked => Ok(asked.unwrap_or(available)),
    }
}
