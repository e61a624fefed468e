//! The subcommands that print or write one thing: `scenes`, `schema`, `completions` and `pack`.

use crate::console::Console;
use crate::failure::Failure;
use crate::job::RunError;
use crate::options::{DEFAULT_SCENE, PackOptions};
use crate::{completions, pack, results, source};
use ballistic_gel::fmi2::Ports;
use ballistic_gel::scene;
use clap_complete::Shell;
use comfy_table::{Table, presets};
use serde_json::{Value, json};

/// Lists the built-in scenes, or prints one.
pub fn scenes(name: Option<&str>, console: &Console) -> Result<(), Failure> {
    match name {
        None => list(console)?,
        Some(name) => {
            let text = scene::builtin(name).ok_or_else(|| unknown(name))?;
            console.document(&json!({ "name": name, "text": text }), text);
        }
    }
    Ok(())
}

fn list(console: &Console) -> Result<(), Failure> {
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

fn unknown(name: &str) -> Failure {
    let known: Vec<&str> = scene::builtins().map(|(name, _)| name).collect();
    let hint = scene::did_you_mean(name, known.iter().copied());
    Failure::BadInput(format!(
        "scene {name}: found no built-in scene of this name{hint}, expected one of {}",
        known.join(", ")
    ))
}

/// Prints the JSON schema of a scene.
pub fn schema(console: &Console) {
    let schema = scene::schema();
    console.document(&schema, &format!("{schema:#}"));
}

/// Prints a completion script.
pub fn completions(shell: Shell, console: &Console) {
    let script = completions::script(shell);
    console.document(&json!({ "shell": shell.to_string(), "script": script }), &script);
}

/// Writes the FMU.
pub fn pack(options: &PackOptions, console: &Console) -> Result<(), Failure> {
    let name = options.named.as_deref().or(options.scene.as_deref()).unwrap_or(DEFAULT_SCENE);
    let source = source::load_standard(name, &options.set)?;
    results::check_archive(&options.out, &results::inputs(name, &source))?;
    let there = Ports::of(&source.scene);
    let ports = Ports {
        fragments: most(("fragment", "body"), options.fragments, there.fragments)?,
        sensors: most(("sensor", "sensor"), options.sensors, there.sensors)?,
    };
    let packed = pack::pack((&source.text, &source.folder), ports, &options.out).map_err(|error| match error {
        RunError::File { path, source, .. } => Failure::BadInput(format!(
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

/// How many ports of a kind there are to be: as many as asked for, of those that there can be.
fn most((table, needs): (&str, &str), asked: Option<usize>, there: usize) -> Result<usize, Failure> {
    match asked {
        Some(asked) if asked > there => {
            let expected = format!("at most the [[{table}]] tables of the scene, {there}: a port needs a {needs}");
            Err(Failure::BadInput(format!("--{table}s: found {asked}, expected {expected}")))
        }
        asked => Ok(asked.unwrap_or(there)),
    }
}
