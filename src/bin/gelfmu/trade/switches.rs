//! What each option of a scene costs when it is on, and that it costs nothing when it is off.

use super::Task;
use super::curve::Run;
use super::ladder::Rung;
use super::row::Row;
use crate::console::Console;
use crate::failure::Failure;
use crate::job::RunError;
use ballistic_gel::output::ResultFolder;
use ballistic_gel::scene::{BodyShape, MaterialModel, Override, Scene};
use comfy_table::{CellAlignment, Table, presets};
use serde_json::{Value, json};

/// Runs of which the least CPU time counts.
pub const REPEATS: usize = 3;

/// An option: what turns it off, if a value does, and what turns it on.
struct Switch {
    name: &'static str,
    off: Option<&'static str>,
    on: Vec<String>,
}

fn switch(name: &'static str, off: Option<&'static str>, on: &[&str]) -> Switch {
    Switch { name, off, on: on.iter().map(|set| (*set).to_owned()).collect() }
}

/// The options that the scene does not use.
fn switches(scene: &Scene) -> Vec<Switch> {
    let mut all = vec![];
    if scene.contact.friction == 0.0 {
        all.push(switch("friction", Some("contact.friction=0.0"), &["contact.friction=0.3"]));
    }
    if scene.contact.restitution == 0.0 {
        all.push(switch("restitution", Some("contact.restitution=0.0"), &["contact.restitution=0.5"]));
    }
    if scene.integrator.damping == 0.0 {
        all.push(switch("damping", Some("integrator.damping=0.0"), &["integrator.damping=1.0"]));
    }
    if scene.load.is_empty() {
        all.push(switch("pressure on a face", Some("load=[]"), &["load=[{on=\"z_max\", pressure=1.0}]"]));
    }
    if scene.fragment.is_empty() && matches!(scene.projectile.shape, BodyShape::Sphere { .. }) {
        all.push(Switch { name: "a fragment out of reach", off: Some("fragment=[]"), on: vec![far_fragment(scene)] });
    }
    all.push(switch("patches of elements", Some("mesh.element=\"plain\""), &["mesh.element=\"patch\""]));
    if scene.remesh.is_none() {
        let never = ["remesh.quality=0.0", "remesh.compression=0.0"];
        all.push(switch("a mesh that may be exchanged", None, &never));
    }
    if scene.gel.material == MaterialModel::NeoHookean {
        let branch = "gel.branches=[{shear_modulus=1.0, time=1e-2}]";
        all.push(switch("a viscous branch", None, &["gel.material=\"viscoelastic\"", branch]));
        let flows = ["gel.material=\"flowing\"", "gel.strength={yield_stress=1e9, rate_exponent=0.0, cap=2e9}"];
        all.push(switch("strength, not reached", None, &flows));
        all.push(switch(
            "bulk viscosity, and that strength",
            None,
            &[flows[0], flows[1], "gel.viscosity={linear=0.1}"],
        ));
    }
    all
}

/// Another ball of the same kind, high above the gel, at rest.
fn far_fragment(scene: &Scene) -> String {
    let radius = scene.bodies().next().map_or(0.0, |body| match body.shape {
        BodyShape::Sphere { radius } => radius,
        _ => 0.0,
    });
    format!(
        "fragment=[{{shape={{sphere={{radius={radius:?}}}}}, mass=1.0, position=[0.0, 0.0, {:?}]}}]",
        100.0 * radius
    )
}

fn overrides(sets: &[String]) -> Vec<Override> {
    sets.iter().map(|set| set.parse().expect("a key and a value")).collect()
}

/// Runs of the scene as it comes, and with each option off and on.
pub fn rungs(scene: &Scene) -> Vec<Rung> {
    let rung = |knob, place, sets: &[String]| Rung { knob, place, overrides: overrides(sets), ..Rung::base() };
    let both = |switch: Switch| {
        let off = switch.off.map(|off| rung(switch.name, -1.0, &[off.to_owned()]));
        off.into_iter().chain([rung(switch.name, 1.0, &switch.on)])
    };
    [Rung::base()].into_iter().chain(switches(scene).into_iter().flat_map(both)).collect()
}

const HEADER: [&str; 7] =
    ["option", "run", "M updates", "of the scene", "ns per update", "of the scene", "CPU s of the scene"];

/// A line of the table: figures, and those of the scene as it comes.
fn cells(run: &Run, base: &Row) -> Vec<String> {
    let name = if run.rung.knob.is_empty() { "as it comes" } else { run.rung.knob };
    let label = run.rung.label();
    let row = match &run.row {
        Ok(row) if row.failure.is_none() => row,
        Ok(row) => return vec![name.to_owned(), label, row.failure.clone().unwrap_or_default()],
        Err(why) => return vec![name.to_owned(), label, why.clone()],
    };
    let off = run.rung.place < 0.0 && row.digest == base.digest;
    let label = if off { format!("{label}: the same bits") } else { label };
    let (each, own) = (1e9 * row.cpu_seconds / row.element_updates, 1e9 * base.cpu_seconds / base.element_updates);
    let figures = [
        1e-6 * row.element_updates,
        row.element_updates / base.element_updates,
        each,
        each / own,
        row.cpu_seconds / base.cpu_seconds,
    ];
    [name.to_owned(), label].into_iter().chain(figures.map(|value| format!("{value:.3}"))).collect()
}

/// Name of the file of the table.
pub const FILE: &str = "options.md";

/// Prints the table and writes `options.md`.
pub fn show(task: &Task<'_>, runs: &[Run], folder: &mut ResultFolder, console: &Console) -> Result<(), Failure> {
    let Some(base) = runs.first().and_then(|run| run.row.as_ref().ok()) else {
        return Err(Failure::Stopped("the scene as it comes cannot be run".to_owned()));
    };
    let lines: Vec<Vec<String>> = runs.iter().map(|run| cells(run, base)).collect();
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header(HEADER);
    for line in &lines {
        table.add_row(line);
    }
    table.column_iter_mut().skip(2).for_each(|column| column.set_cell_alignment(CellAlignment::Right));
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let rule = HEADER.map(|_| "---".to_owned());
    let markdown: String =
        [HEADER.map(str::to_owned).to_vec(), rule.to_vec()].iter().chain(&lines).map(|cells| line(cells)).collect();
    let path = task.folder.join(FILE);
    folder.write(FILE, markdown.as_bytes()).map_err(RunError::from)?;
    let value = |run: &Run| json!({ "option": run.rung.knob, "run": run.rung.label(), "row": run.row.as_ref().ok(), "refused": run.row.as_ref().err() });
    let values: Vec<Value> = runs.iter().map(value).collect();
    console
        .result(&json!({ "scene": task.scene.scene.name, "options": values }), &format!("{table}\n{}", path.display()));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::rungs;
    use ballistic_gel::scene;

    #[test]
    fn every_option_of_every_builtin_scene_of_elastic_gel_is_a_scene() {
        for name in ["sphere-block", "ball-bounce", "ball-square", "l-beam"] {
            let text = scene::builtin(name).unwrap();
            for rung in rungs(&scene::read(text).unwrap()) {
                let read = scene::resolve(text, &rung.overrides).and_then(|text| scene::read(&text));
                assert!(
                    read.is_ok() || rung.label().contains("z_max"),
                    "{name}: {}: {}",
                    rung.label(),
                    read.unwrap_err()
                );
            }
        }
    }
}
