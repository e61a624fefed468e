//! `gelfmu check`: validates a scene and lists the modelled physics.

use crate::console::Console;
use crate::failure::{CommandError, RunError};
use crate::job;
use crate::level;
use crate::options::CheckOptions;
use crate::source::{self, SceneSource};
use ballistic_gel::fmi2::{self, AmountOfMemory};
use ballistic_gel::geometry::SignedDistance;
use ballistic_gel::math::Vector3;
use ballistic_gel::output::UnitSystem;
use ballistic_gel::scene::{
    self, LIBRARY_VERSION, LibraryProjectile, LibraryValue, Preset, PresetValue, ProjectileSpec, Scene, body_name,
};
use ballistic_gel::simulation::{CouplingMode, MemoryEstimate, Simulation, memory_estimate};
use nalgebra::{Quaternion, UnitQuaternion};
use serde_json::{Value, json};

/// Builds a scene and prints its model, cost and levels.
pub fn check(options: &CheckOptions, console: &Console) -> Result<(), CommandError> {
    let source = source::load(&options.scene, &options.set)?;
    let SceneSource { scene, text, .. } = source;
    let memory = memory_estimate(&scene).map_err(RunError::from)?;
    let simulation = job::build_simulation(&scene, CouplingMode::Integrated, 1)?;
    let cost = simulation.observe().cost;
    let bodies: Vec<Value> = (0..scene.n_bodies()).map(|body| body_json(&scene, &simulation, body)).collect();
    let (modelled, off) = (scene::modelled_physics(&scene), scene::switched_off(&scene));
    let (preset_facts, doubts) = (scene::from_preset(&text), doubts_of(&scene, options));
    let result = json!({
        "scene": scene.scene.name,
        "title": scene.scene.title,
        "valid": true,
        "values": scene,
        "modelled": modelled,
        "switched_off": off,
        "elements": cost.elements,
        "nodes": cost.nodes,
        "bodies": bodies,
        "smallest_step": cost.smallest_step,
        "memory_to_build": memory.building,
        "memory_to_remesh": memory.remeshing,
        "preset": scene.gel.preset.map(Preset::name),
        "fitted_to": scene.gel.preset.map(|preset| preset.shots().fitted),
        "validated_on": scene.gel.preset.map(|preset| preset.shots().validated),
        "from_library": library_values(&scene),
        "from_preset": preset_facts.iter().map(|fact| fact_json(fact)).collect::<Vec<_>>(),
        "model_error": scene::shot_class(&scene, 0).map(|class| class.error),
        "fidelity": scene.fidelity,
        "doubts": doubts,
    });
    let set: Vec<String> =
        options.set.iter().map(|o| format!(" --set {}", shell_word(&format!("{}={}", o.key, o.value)))).collect();
    let shot = section("bodies", &body_lines(&scene, &simulation, options.units.system()), console);
    let levels = section("fidelity", &level_lines(&scene), console);
    let text = format!(
        "{}: {}\n\n{}\n{}\n\n{}\n{}\n\n{shot}{}{levels}{}The scene is valid: {} elements, {} nodes, steps of at least \
         {:.3e} s. {}. Run it with:\n    gelfmu run {}{}",
        scene.scene.name,
        scene.scene.title,
        console.heading("models"),
        bullet_list(&modelled),
        console.heading("switched off"),
        bullet_list(&off),
        library_section(&scene, console) + &preset_section(scene.gel.preset, &preset_facts, console),
        section("model error of the gel", &model_errors(&scene), console) + &section("doubtful", &doubts, console),
        cost.elements,
        cost.nodes,
        cost.smallest_step,
        describe_memory(&memory),
        shell_word(&options.scene),
        set.concat()
    );
    console.result(&result, &text);
    Ok(())
}

/// Returns a line for the reduced model, if it is identified for the shot, and one for each level of the scene.
fn level_lines(scene: &Scene) -> Vec<String> {
    let instant = scene.instant_class().map(|class| format!("instant: {}", scene::describe_instant(class)));
    let levels = scene.fidelity.known().map(|(fidelity, level)| {
        let set = if level.set.is_empty() { String::new() } else { format!(" ({})", level.set.join(" ")) };
        format!("{}: {}{set}", fidelity.as_str(), level::describe_expectation(level))
    });
    instant.into_iter().chain(levels).collect()
}

/// Model errors of the bodies whose class of shots is known.
fn model_errors(scene: &Scene) -> Vec<String> {
    let class = |body: usize| scene::shot_class(scene, body).map(|class| format!("{}: {class}", body_name(body)));
    (0..scene.n_bodies()).filter_map(class).collect()
}

/// Doubts about a scene, and about its levels that a run refuses.
fn doubts_of(scene: &Scene, options: &CheckOptions) -> Vec<String> {
    let at_level = |fidelity| {
        let set: Vec<_> = options.set.iter().cloned().chain([level::level_override(fidelity)]).collect();
        Ok(source::load(&options.scene, &set)?.scene)
    };
    [scene::doubts(scene), level::refused_levels(&scene.fidelity, at_level)].concat()
}

/// Describes the largest memory that a run needs, and the available memory.
fn describe_memory(memory: &MemoryEstimate) -> String {
    let available = fmi2::available_memory().map(|available| AmountOfMemory(available.bytes));
    let available = available.map_or(String::new(), |available| format!("; {available} are available"));
    let remeshing = match memory.remeshing {
        0 => String::new(),
        bytes => format!(", and {} more during remeshing", AmountOfMemory(bytes)),
    };
    format!("The run needs up to {} of memory{remeshing}{available}", AmountOfMemory(memory.building))
}

fn fact_json(fact: &PresetValue) -> Value {
    json!({ "key": fact.key, "value": fact.value, "source": fact.source })
}

/// Describes a body: its table with mass and inertia in use, null for a fixed body, and with its extent along the axes of the world at
/// the start, relative to its position, m.
fn body_json(scene: &Scene, simulation: &Simulation, body: usize) -> Value {
    let spec = scene.body(body);
    let (shape, [w, x, y, z]) = (scene.shape(body), spec.orientation);
    let to_body = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).inverse();
    let reach = |sign: f64| [0, 1, 2].map(|axis| sign * shape.reach(&(to_body * (sign * Vector3::ith(axis, 1.0)))));
    let (mass, inertia) = simulation.inertia(body);
    let mut value = json!(spec);
    value["mass"] = json!(mass);
    value["inertia"] = json!(inertia);
    value["extent"] = json!({ "min": reach(-1.0), "max": reach(1.0) });
    value
}

fn body_lines(scene: &Scene, simulation: &Simulation, units: UnitSystem) -> Vec<String> {
    (0..scene.n_bodies()).map(|body| body_line(scene, simulation, body, units)).collect()
}

/// Describes a body by its width across its axis, mass, speed and kinetic energy.
fn body_line(scene: &Scene, simulation: &Simulation, body: usize, units: UnitSystem) -> String {
    let (name, shape, spec) = (body_name(body), scene.shape(body), scene.body(body));
    let reach = |sign: f64| shape.reach(&(sign * Vector3::x()));
    let width = units.format(reach(1.0) + reach(-1.0), "m");
    if spec.fixed {
        return format!("{name}: {width} wide, fixed");
    }
    let (mass, speed) = (simulation.inertia(body).0, Vector3::from(spec.velocity).norm());
    let energy = units.format(0.5 * mass * speed * speed, "J");
    format!("{name}: {width} wide, {} at {}, {energy}", units.format_mass(mass), units.format(speed, "m/s"))
}

/// Returns the values of the bodies that are those of the library, with their dotted keys.
fn library_values(scene: &Scene) -> Vec<LibraryValue> {
    let values = |(i, body): (usize, &ProjectileSpec)| {
        let projectile = body.library.as_deref().and_then(LibraryProjectile::named);
        let values = projectile.map_or_else(Vec::new, |projectile| projectile.values_of(body));
        values.into_iter().map(move |value| LibraryValue { key: format!("{}.{}", body_name(i), value.key), ..value })
    };
    scene.bodies().enumerate().flat_map(values).collect()
}

/// Lists the values of the library with their sources; empty if no body is of the library.
fn library_section(scene: &Scene, console: &Console) -> String {
    let titles = scene.bodies().filter_map(|body| LibraryProjectile::named(body.library.as_deref()?));
    let titles: Vec<String> = titles.map(|projectile| format!("{}, {}", projectile.name, projectile.title)).collect();
    let values = library_values(scene).into_iter();
    let lines: Vec<String> =
        values.map(|LibraryValue { key, value, source }| format!("{key} = {value}: {source}")).collect();
    section(&format!("from the library, version {LIBRARY_VERSION}: {}", titles.join("; ")), &lines, console)
}

/// Lists the values of a preset with their sources; empty without a preset.
fn preset_section(preset: Option<Preset>, preset_facts: &[&PresetValue], console: &Console) -> String {
    let Some(preset) = preset else { return String::new() };
    let lines: Vec<String> =
        preset_facts.iter().map(|fact| format!("{} = {}: {}", fact.key, fact.value, fact.source)).collect();
    let shots = preset.shots();
    let lines: Vec<String> = lines
        .into_iter()
        .chain([format!("fitted to: {}", shots.fitted), format!("validated on: {}", shots.validated)])
        .collect();
    format!("{}\n{}\n\n", console.heading(&format!("from the preset {}", preset.name())), bullet_list(&lines))
}

/// Formats a heading and a list; empty without lines.
fn section(heading: &str, lines: &[String], console: &Console) -> String {
    if lines.is_empty() { String::new() } else { format!("{}\n{}\n\n", console.heading(heading), bullet_list(lines)) }
}

fn bullet_list(lines: &[String]) -> String {
    lines.iter().map(|line| format!("  {line}")).collect::<Vec<_>>().join("\n")
}

/// Quotes a word for a shell, if it needs that.
fn shell_word(text: &str) -> String {
    let is_plain = text.chars().all(|c| c.is_ascii_alphanumeric() || "._=-+:/".contains(c));
    if is_plain { text.to_owned() } else { format!("'{}'", text.replace('\'', "'\\''")) }
}
