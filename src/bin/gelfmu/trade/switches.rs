//! Cost of each scene option, switched on and off; an unused option must cost nothing.

use super::curve::TradeRun;
use super::ladder::LadderRung;
use super::row::TradeRow;
use crate::console::Console;
use crate::failure::{CommandError, RunError};
use ballistic_gel::output::ResultFolder;
use ballistic_gel::scene::{BodyShape, MaterialModel, Override, Scene};
use comfy_table::{CellAlignment, Table, presets};
use serde_json::{Value, json};

/// Repetitions of each run; the least CPU time counts.
pub const REPEATS: usize = 3;

/// Scene option with its overrides: `off` if a value turns it off explicitly, and `on`.
struct OptionSwitch {
    name: &'static str,
    off: Option<&'static str>,
    on: Vec<String>,
}

fn new_switch(name: &'static str, off: Option<&'static str>, on: &[&str]) -> OptionSwitch {
    OptionSwitch { name, off, on: on.iter().map(|set| (*set).to_owned()).collect() }
}

/// Lists the options that the scene does not use.
fn unused_options(scene: &Scene) -> Vec<OptionSwitch> {
    let mut all = vec![];
    if scene.contact.friction == 0.0 {
        all.push(new_switch("friction", Some("contact.friction=0.0"), &["contact.friction=0.3"]));
    }
    if scene.contact.restitution == 0.0 {
        all.push(new_switch("restitution", Some("contact.restitution=0.0"), &["contact.restitution=0.5"]));
    }
    if scene.integrator.damping == 0.0 {
        all.push(new_switch("damping", Some("integrator.damping=0.0"), &["integrator.damping=1.0"]));
    }
    if scene.load.is_empty() {
        all.push(new_switch("pressure on a face", Some("load=[]"), &["load=[{on=\"z_max\", pressure=1.0}]"]));
    }
    if scene.fragment.is_empty() && matches!(scene.projectile.shape, BodyShape::Sphere { .. }) {
        all.push(OptionSwitch {
            name: "a fragment out of reach",
            off: Some("fragment=[]"),
            on: vec![far_fragment(scene)],
        });
    }
    all.push(new_switch("patches of elements", Some("mesh.element=\"plain\""), &["mesh.element=\"patch\""]));
    if scene.remesh.is_none() {
        let never = ["remesh.quality=0.0", "remesh.min_volume_ratio=0.0"];
        all.push(new_switch("a mesh that may be remade", None, &never));
    }
    if scene.gel.material == MaterialModel::NeoHookean {
        let branch = "gel.branches=[{shear_modulus=1.0, time=1e-2}]";
        all.push(new_switch("a viscous branch", None, &["gel.material=\"two-network\"", branch]));
        let flows = [
            "gel.material=\"two-network\"",
            "gel.branches=[{shear_modulus=1.0, power_law={stress=1e9, exponent=1.0}}]",
        ];
        all.push(new_switch("a stiff branch", None, &flows));
        all.push(new_switch(
            "bulk viscosity, and that branch",
            None,
            &[flows[0], flows[1], "gel.viscosity={linear=0.1}"],
        ));
    }
    all
}

/// Returns a second ball of the same kind at rest, far above the gel.
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

fn parse_overrides(sets: &[String]) -> Vec<Override> {
    sets.iter().map(|set| set.parse().expect("a key and a value")).collect()
}

/// Returns rungs for the unmodified scene, and for each option off and on.
pub fn option_rungs(scene: &Scene) -> Vec<LadderRung> {
    let rung = |knob, refinement, sets: &[String]| LadderRung {
        knob,
        refinement,
        overrides: parse_overrides(sets),
        ..LadderRung::unmodified()
    };
    let both = |switch: OptionSwitch| {
        let off = switch.off.map(|off| rung(switch.name, -1.0, &[off.to_owned()]));
        off.into_iter().chain([rung(switch.name, 1.0, &switch.on)])
    };
    [LadderRung::unmodified()].into_iter().chain(unused_options(scene).into_iter().flat_map(both)).collect()
}

const HEADER: [&str; 7] =
    ["option", "run", "M updates", "of the scene", "ns per update", "of the scene", "CPU s of the scene"];

/// Formats a table row: figures, absolute and relative to the unmodified scene.
fn table_cells(run: &TradeRun, base: &TradeRow) -> Vec<String> {
    let name = if run.rung.knob.is_empty() { "as it comes" } else { run.rung.knob };
    let label = run.rung.label();
    let row = match &run.row {
        Ok(row) if row.failure.is_none() => row,
        Ok(row) => return vec![name.to_owned(), label, row.failure.clone().unwrap_or_default()],
        Err(why) => return vec![name.to_owned(), label, why.clone()],
    };
    let off = run.rung.refinement < 0.0 && row.digest == base.digest;
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

/// Name of the table file.
pub const FILE: &str = "options.md";

/// Prints the table and writes `options.md`.
pub fn report(
    scene: &str,
    runs: &[TradeRun],
    folder: &mut ResultFolder,
    console: &Console,
) -> Result<(), CommandError> {
    let Some(base) = runs.first().and_then(|run| run.row.as_ref().ok()) else {
        return Err(CommandError::Stopped("the scene as it comes cannot be run".to_owned()));
    };
    let lines: Vec<Vec<String>> = runs.iter().map(|run| table_cells(run, base)).collect();
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
    let path = folder.path().join(FILE);
    folder.write(FILE, markdown.as_bytes()).map_err(RunError::from)?;
    let value = |run: &TradeRun| json!({ "option": run.rung.knob, "run": run.rung.label(), "row": run.row.as_ref().ok(), "refused": run.row.as_ref().err() });
    let values: Vec<Value> = runs.iter().map(value).collect();
    console.result(&json!({ "scene": scene, "options": values }), &format!("{table}\n{}", path.display()));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::option_rungs;
    use ballistic_gel::scene;

    #[test]
    fn every_option_of_every_builtin_scene_of_elastic_gel_is_a_scene() {
        for name in ["sphere-block", "ball-bounce", "ball-square", "l-beam"] {
            let text = scene::builtin(name).unwrap();
            for rung in option_rungs(&scene::read(text).unwrap()) {
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
