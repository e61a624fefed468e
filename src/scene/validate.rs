//! Validation of a scene: every number is finite, in its domain, and consistent with the others.

mod body;
mod cavity;
mod domain;
mod expansion;
mod gel;
mod hyperelastic;
mod instant;
mod layer;
mod library;
mod load;
mod motion;
mod output;
mod sensor;
mod shape;
mod two_network;

use super::{
    CellLattice, ContactLaw, ContactSpec, Dimension, FidelityLevels, GelShape, GradingSpec, IntegratorSpec,
    MOST_FRAGMENTS, OctreeSpec, OutputSpec, RemeshMethod, RemeshSpec, Scene, SceneError, SceneHeader, ScheduleKind,
    body_name,
};
use crate::geometry::SignedDistance;
use domain::{CheckResult, finite, positive, require, within};

pub(super) use instant::check_shot as check_instant;

/// Refuses the first invalid value of the scene.
pub(super) fn validate(scene: &Scene) -> CheckResult {
    check_header(&scene.scene)?;
    library::check(scene)?;
    gel::check(scene)?;
    load::check(scene)?;
    cavity::check(scene)?;
    sensor::check(scene)?;
    check_size(scene)?;
    check_body(scene)?;
    let most = format!("at most {MOST_FRAGMENTS}");
    require(
        scene.fragment.len() <= MOST_FRAGMENTS,
        "fragment",
        || format!("{} fragments", scene.fragment.len()),
        &most,
    )?;
    for i in 1..scene.n_bodies() {
        let renamed = |key: &str| key.strip_prefix("projectile").map(|rest| body_name(i) + rest);
        check_body(&scene.alone(i)).map_err(|e| SceneError { key: renamed(&e.key).unwrap_or(e.key), ..e })?;
    }
    check_mesh(scene)?;
    check_remesh(scene)?;
    layer::check(scene)?;
    check_integrator(&scene.integrator)?;
    check_levels(&scene.fidelity)?;
    check_contact(&scene.contact)?;
    check_output(&scene.output, scene.scene.end_time)?;
    output::check_fields(scene)?;
    instant::check(scene)
}

/// Checks the projectile of a scene.
fn check_body(scene: &Scene) -> CheckResult {
    body::check(scene)?;
    motion::check(scene)
}

/// Greatest number of communication steps of a run: days of computing, and rows that fill a disk.
pub const MOST_STEPS: f64 = 1e9;

fn check_header(header: &SceneHeader) -> CheckResult {
    let name = &header.name;
    let allowed = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    let good = !name.is_empty() && name.chars().all(allowed);
    require(good, "scene.name", || format!("{name:?}"), "letters, digits, - and _: it names the output folder")?;
    let good = !header.title.chars().any(char::is_control);
    require(good, "scene.title", || format!("{:?}", header.title), "one line of text without control characters")?;
    positive("scene.end_time", header.end_time, "a positive time, s")?;
    let (step, end) = (header.communication_step, header.end_time);
    positive("scene.communication_step", step, "a positive time, s")?;
    require(
        step <= end,
        "scene.communication_step",
        || format!("{step:?}"),
        &format!("at most scene.end_time, {end:?} s"),
    )?;
    let wait = header.stop_after_exit.time();
    require(wait >= 0.0, "scene.stop_after_exit", || format!("{wait:?}"), "a time of 0 or more, s, or \"never\"")?;
    let expected = format!("at least scene.end_time / {MOST_STEPS:?}, {:?} s", end / MOST_STEPS);
    require(step >= end / MOST_STEPS, "scene.communication_step", || format!("{step:?}"), &expected)
}

fn check_size(scene: &Scene) -> CheckResult {
    let size = scene.mesh.size;
    positive("mesh.size", size, "a positive length, m")?;
    let smallest = gel::smallest_dimension(&scene.gel.shape);
    let expected = format!("at most the smallest dimension of the gel, {smallest:?} m");
    require(size <= smallest, "mesh.size", || format!("{size:?}"), &expected)
}

fn check_mesh(scene: &Scene) -> CheckResult {
    check_resolution(scene)?;
    let round = scene.scene.dimension == Dimension::Spatial && matches!(scene.gel.shape, GelShape::Cylinder { .. });
    let flat = round && scene.mesh.lattice == CellLattice::Kuhn;
    let expected = "\"centred\": in a spatial cylinder Kuhn tetrahedra would lie flat on the mantle";
    require(!flat, "mesh.lattice", || "\"kuhn\"".to_owned(), expected)?;
    scene.mesh.grading.map_or(Ok(()), |grading| check_grading(&grading, scene))?;
    scene.mesh.tree.map_or(Ok(()), |tree| check_tree(&tree, scene))
}

/// Relative round-off by which a length may miss its bound.
const ROUND_OFF: f64 = 1e-9;

/// Checks that the mesh resolves every body. Contact is found at nodes: a body that fits between them would pass
/// through unseen.
fn check_resolution(scene: &Scene) -> CheckResult {
    let radii = (0..scene.n_bodies()).map(|body| (scene.shape(body).inner_radius(), body));
    let (radius, body) = radii.min_by(|a, b| a.0.total_cmp(&b.0)).expect("there is a projectile");
    let (size, name) = (scene.mesh.size, if body == 0 { "the projectile".to_owned() } else { body_name(body) });
    let expected =
        format!("at most the radius of the greatest ball inside {name}, {radius:?} m: it would slip through the mesh");
    require(size <= radius * (1.0 + ROUND_OFF), "mesh.size", || format!("{size:?}"), &expected)
}

fn check_grading(grading: &GradingSpec, scene: &Scene) -> CheckResult {
    let GradingSpec { core, growth, largest } = *grading;
    let expected = fixed_mesh_reason(&scene.gel.shape);
    require(expected.is_empty(), "mesh.grading", || "a table".to_owned(), expected)?;
    finite("mesh.grading.core", core)?;
    require(core >= 0.0, "mesh.grading.core", || format!("{core:?}"), "a length of 0 or more, m")?;
    finite("mesh.grading.growth", growth)?;
    require(growth > 1.0, "mesh.grading.growth", || format!("{growth:?}"), "a ratio above 1")?;
    finite("mesh.grading.largest", largest)?;
    let size = scene.mesh.size;
    let expected = format!("at least mesh.size, {size:?} m");
    require(largest >= size, "mesh.grading.largest", || format!("{largest:?}"), &expected)
}

/// Reason why a shape cannot have growing cells; empty where it can.
fn fixed_mesh_reason(shape: &GelShape) -> &'static str {
    match shape {
        GelShape::LBeam { .. } => "nothing: an l-beam has a uniform mesh",
        GelShape::Shell { .. } => "nothing: the cells of a shell grow with the distance from its middle",
        GelShape::Cylinder { bore: Some(_), .. } => "nothing: a cylinder with a bore has a uniform mesh",
        GelShape::Block { .. } | GelShape::Cylinder { bore: None, .. } => "",
    }
}

fn check_tree(tree: &OctreeSpec, scene: &Scene) -> CheckResult {
    let OctreeSpec { coarsest, core, slope } = *tree;
    let nothing = |good: bool, expected: &str| require(good, "mesh.tree", || "a table".to_owned(), expected);
    let expected = fixed_mesh_reason(&scene.gel.shape);
    nothing(expected.is_empty(), expected)?;
    nothing(scene.mesh.grading.is_none(), "nothing beside mesh.grading: cells grow in one way or the other")?;
    let centred = scene.mesh.lattice == CellLattice::Centred;
    require(
        centred,
        "mesh.lattice",
        || "\"kuhn\"".to_owned(),
        "\"centred\": mesh.tree divides cells around their centres",
    )?;
    let good = coarsest >= 2 && coarsest.is_power_of_two();
    require(good, "mesh.tree.coarsest", || coarsest.to_string(), "a power of two: 2, 4, 8 and so on")?;
    let (size, room) = (scene.mesh.size, gel::shortest_way(&scene.gel.shape));
    let expected =
        format!("cells of at most {room:?} m: the shortest way from the z axis or the entry surface to a face");
    let found = || format!("{coarsest}, cells of {:?} m", coarsest as f64 * size);
    require(coarsest as f64 * size <= room * (1.0 + ROUND_OFF), "mesh.tree.coarsest", found, &expected)?;
    finite("mesh.tree.core", core)?;
    require(core >= 0.0, "mesh.tree.core", || format!("{core:?}"), "a length of 0 or more, m")?;
    positive("mesh.tree.slope", slope, "a positive ratio of length to distance")
}

fn check_remesh(scene: &Scene) -> CheckResult {
    let Some(remesh) = &scene.remesh else { return Ok(()) };
    let RemeshSpec {
        method, quality, min_volume_ratio, ref times, smallest, tip_size, curvature_angle, growth, ..
    } = *remesh;
    let possible = method != RemeshMethod::Immersed || scene.scene.dimension != Dimension::Spatial;
    require(
        possible,
        "remesh.method",
        || "\"immersed\" for a spatial gel".to_owned(),
        "\"local\": immersed remeshing is for planar and axisymmetric scenes only",
    )?;
    let bins = scene.integrator.schedule != ScheduleKind::Queue;
    require(
        bins,
        "remesh",
        || "a queue".to_owned(),
        "integrator.schedule = \"bins\" or \"global\": a queue has no tick at which all elements are active",
    )?;
    within("remesh.quality", quality, 0.0..=0.6)?;
    within("remesh.min_volume_ratio", min_volume_ratio, 0.0..=0.5)?;
    within("remesh.curvature_angle", curvature_angle, 1.0..=180.0)?;
    let ascending = times.windows(2).all(|pair| pair[0] < pair[1]);
    let within_run = times.iter().all(|time| *time > 0.0 && *time <= scene.scene.end_time);
    let expected = format!("ascending times above 0, up to scene.end_time, {:?} s", scene.scene.end_time);
    require(ascending && within_run, "remesh.times", || format!("{times:?}"), &expected)?;
    within("remesh.growth", growth, 0.01..=1.0)?;
    let size = scene.mesh.size;
    smallest.map_or(Ok(()), |smallest| within("remesh.smallest", smallest, 1e-3 * size..=size))?;
    tip_size.map_or(Ok(()), |edge| within("remesh.tip_size", edge, 1e-3 * size..=size))?;
    remesh.erosion_thickness.map_or(Ok(()), |thickness| within("remesh.erosion_thickness", thickness, 0.0..=size))
}

/// Least fraction of the stable step: a run then costs a million times more than with 1.
const LEAST_CFL: f64 = 1e-6;

fn check_integrator(integrator: &IntegratorSpec) -> CheckResult {
    let cfl = integrator.cfl();
    let expected = format!("a fraction from {LEAST_CFL:e} to 1");
    require((LEAST_CFL..=1.0).contains(&cfl), "integrator.cfl", || format!("{cfl:?}"), &expected)?;
    within("integrator.damping", integrator.damping, 0.0..=1e9)
}

/// Checks that the figures of the fidelity levels are valid numbers.
fn check_levels(levels: &FidelityLevels) -> CheckResult {
    for (fidelity, level) in levels.known() {
        let key = |name: &str| format!("fidelity.{}.{name}", fidelity.as_str());
        let error = level.error.unwrap_or(0.0);
        let expected = "a relative error, a finite number of 0 or more";
        require(error.is_finite() && error >= 0.0, &key("error"), || format!("{error:?}"), expected)?;
        let figures = [
            ("updates", level.updates, "a positive number of element updates"),
            ("cpu_seconds", level.cpu_seconds, "a positive time, s"),
        ];
        for (name, figure, expected) in figures {
            figure.map_or(Ok(()), |figure| positive(&key(name), figure, expected))?;
        }
    }
    Ok(())
}

fn check_contact(contact: &ContactSpec) -> CheckResult {
    within("contact.restitution", contact.restitution, 0.0..=1.0)?;
    within("contact.bias", contact.bias, 0.0..=0.5)?;
    within("contact.friction", contact.friction, 0.0..=10.0)?;
    for (key, value) in [("restitution", contact.restitution), ("friction", contact.friction)] {
        let unheeded = contact.law == ContactLaw::Reversal && value != 0.0;
        let expected = format!("0: the law \"reversal\" has no {key}, \"moreau\" has");
        require(!unheeded, &format!("contact.{key}"), || format!("{value:?}"), &expected)?;
    }
    Ok(())
}

fn check_output(output: &OutputSpec, end_time: f64) -> CheckResult {
    const MOST_FRAMES: usize = 10_000;
    let OutputSpec { frames, report: _, force_window, fields: _ } = *output;
    let expected = format!("a number from 0, for none, to {MOST_FRAMES}");
    require(frames <= MOST_FRAMES, "output.frames", || frames.to_string(), &expected)?;
    let good = (0.0..=end_time).contains(&force_window);
    let expected = format!("a time from 0 to scene.end_time, {end_time:?} s");
    require(good, "output.force_window", || format!("{force_window:?}"), &expected)
}
