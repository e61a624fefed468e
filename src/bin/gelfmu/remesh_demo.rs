//! `gelfmu remesh-demo`: draws the stages of one remesh.

use crate::console::Console;
use crate::failure::{CommandError, RunError};
use crate::job;
use crate::options::{DEMO_SCENE, RemeshDemoOptions};
use crate::results;
use crate::source::{self, SceneSource};
use ballistic_gel::output::{self, FolderClaim, FolderState, OutputError, RemeshFigures};
use ballistic_gel::scene::{Dimension, Override};
use ballistic_gel::simulation::{CouplingMode, RemeshPreview};
use serde_json::json;
use std::path::Path;

/// Remeshing criteria for a scene without any: the mesh becomes so distorted that the run could hardly continue.
const LATE_REMESH: [(&str, &str); 2] = [("remesh.quality", "0.05"), ("remesh.min_volume_ratio", "0.0")];

/// Name of the command in the manifest of its folder.
const COMMAND: &str = "remesh-demo";

/// Runs to the remesh in the options and draws it.
pub fn show(options: &RemeshDemoOptions, console: &Console) -> Result<(), CommandError> {
    let name = options.scene.as_deref().unwrap_or(DEMO_SCENE);
    let source = load_scene(name, options)?;
    let header = &source.scene.scene;
    let folder = options.out.clone();
    let folder = folder.unwrap_or_else(|| Path::new("gelfmu-out").join(format!("{}-remesh", header.name)));
    let (policy, needs) = (results::policy(options.force), ["index.html".to_owned()]);
    let inputs = results::inputs(name, &source);
    let mut claimed = results::claim(
        &folder,
        &FolderClaim { command: COMMAND, policy, needs: &needs, inputs: &inputs, is_of_fmu: false },
    )?;
    console.note(&format!("{}: {} (into {})", header.name, header.title, folder.display()));
    let shown = rehearse_remesh(name, &source, options)?;
    let figures = output::draw_steps(&mut claimed, &source.scene, &shown).map_err(output_failure)?;
    claimed.begin().and_then(|()| claimed.mark(FolderState::Complete)).map_err(output_failure)?;
    let page = folder.join("index.html");
    console.result(&json!({ "page": page, "figures": figures }), &describe_figures(&figures, &page));
    Ok(())
}

/// Loads the scene, and adds remeshing criteria if necessary.
fn load_scene(name: &str, options: &RemeshDemoOptions) -> Result<SceneSource, CommandError> {
    let set = |key: &str, value: String| Override { key: key.to_owned(), value };
    let mut overrides = options.set.clone();
    if let Some(at) = options.at {
        overrides.push(set("remesh.times", format!("[{at:?}]")));
    }
    let source = source::load(name, &overrides)?;
    let dimension = source.scene.scene.dimension;
    if dimension == Dimension::Spatial {
        return Err(CommandError::BadInput(format!(
            "scene {name}: found a spatial gel, expected a planar or axisymmetric one: the pictures are of meshes in the plane"
        )));
    }
    if source.scene.remesh.is_some() {
        return Ok(source);
    }
    overrides.extend(LATE_REMESH.map(|(key, value)| set(key, value.to_owned())));
    source::load(name, &overrides)
}

/// Runs the scene to its remesh, and keeps the intermediate stages.
fn rehearse_remesh(
    name: &str,
    source: &SceneSource,
    options: &RemeshDemoOptions,
) -> Result<RemeshPreview, CommandError> {
    let scene = &source.scene;
    let mut simulation = job::build_simulation(scene, CouplingMode::Integrated, options.threads)?;
    let from = options.at.unwrap_or(0.0);
    let end = scene.scene.end_time;
    let stopped = |reason: String| CommandError::Stopped(format!("scene {name}: {reason}"));
    match simulation.rehearse(from, end) {
        Ok(Some(shown)) => Ok(shown),
        Ok(None) => Err(stopped(format!(
            "the mesh is not distorted up to scene.end_time, {end:?} s: give a time with --at, or raise remesh.quality"
        ))),
        Err(error) => Err(stopped(error.to_string())),
    }
}

fn output_failure(error: OutputError) -> CommandError {
    RunError::Output(error).into()
}

fn describe_figures(figures: &RemeshFigures, page: &Path) -> String {
    let RemeshFigures { time, elements, least_quality, methods } = figures;
    let mut lines = vec![format!(
        "at {:.4} ms a mesh of {elements} elements is replaced, its least quality is {least_quality:.3}",
        1e3 * time
    )];
    for outcome in methods {
        let method = format!("{:?}", outcome.method).to_lowercase();
        lines.push(match (&outcome.mesh, &outcome.refused) {
            (Some(new), _) => format!(
                "{method}: {} elements, quality {:.3}, area {:+.1e}, momentum {:.1e}, kinetic energy {:+.2e}, stored {:+.2e}",
                new.elements, new.least_quality, new.area, new.momentum, new.kinetic, new.stored
            ),
            (None, why) => format!("{method}: none, {}", why.as_deref().unwrap_or("it was not tried")),
        });
    }
    lines.push(format!("pictures: {}", page.display()));
    lines.join("\n")
}
