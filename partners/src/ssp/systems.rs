//! The systems: a gel, its partners, and the wires between them.

use crate::gel::{GelCommand, GelOptions};
use crate::partner::Partner;
use crate::structure::{GEL, Port, Unit, Wire};
use crate::wires::{self, ARMOUR, BodyUnit};
use crate::{body, plate, scene, starts};
use serde_json::Value;
use std::fs;

/// Set of outputs of the gel in every system: impulses on the bodies and on the bulge of a dome.
const OUTPUTS: &str = "corrected";
/// Scene of the system with three fragments.
const FRAGMENTS_SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fragments-block.toml");
/// Scene of the system with a soft armour.
const SOFT_ARMOUR_SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/soft-armour.toml");
/// Parameters of the soft armour.
const SOFT_ARMOUR_PLATE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/soft-armour-plate.toml");

/// A system before it is packed.
#[derive(Debug)]
pub struct SystemPlan {
    /// Name of the system and of its file.
    pub name: &'static str,
    /// Options of its gel.
    pub gel: GelOptions,
    /// Name of the file of its gel.
    pub gel_file: &'static str,
    /// FMUs beside the gel.
    pub partners: Vec<Partner>,
    /// Units, in the order of their steps.
    pub units: Vec<Unit>,
    /// Wires between the units.
    pub wires: Vec<Wire>,
}

/// Returns the systems with a scene for gel and body, and with a scene for gel, armour and body.
pub fn plans(command: &GelCommand, scene: &str, armour_scene: &str) -> Result<Vec<SystemPlan>, String> {
    let bodies = command.bodies(scene)?;
    Ok(vec![
        gel_and_body(scene, &bodies)?,
        gel_and_body_corrected(scene, &bodies)?,
        gel_armour_body(armour_scene, &command.bodies(armour_scene)?)?,
        gel_fragments(&command.bodies(FRAGMENTS_SCENE)?)?,
        gel_soft_armour(&command.bodies(SOFT_ARMOUR_SCENE)?)?,
    ])
}

/// The gel integrates the body, and the body follows: nothing goes back to the gel.
fn gel_and_body(scene: &str, bodies: &[Value]) -> Result<SystemPlan, String> {
    let unit = body_unit("body", 0);
    let body = rigid_body(scene, bodies, &unit, "RigidBody.fmu")?;
    let gel_file = "BallisticGel.fmu";
    Ok(SystemPlan {
        name: "gel-and-body",
        gel: gel_options(scene, "integrated"),
        gel_file,
        units: vec![gel_unit(gel_file, &[&unit]), unit_of_body(&unit, &body)],
        partners: vec![body],
        wires: wires::impulses(&unit),
    })
}

/// The body owns its state, and gives it to the gel.
fn gel_and_body_corrected(scene: &str, bodies: &[Value]) -> Result<SystemPlan, String> {
    let plan = gel_and_body(scene, bodies)?;
    let (unit, gel_file) = (body_unit("body", 0), "BallisticGelCorrected.fmu");
    Ok(SystemPlan {
        name: "gel-and-body-corrected",
        gel: gel_options(scene, "corrected"),
        gel_file,
        units: vec![gel_unit(gel_file, &[&unit]), unit_of_body(&unit, &plan.partners[0])],
        wires: [wires::impulses(&unit), wires::motion(&unit)].concat(),
        ..plan
    })
}

fn gel_armour_body(scene: &str, bodies: &[Value]) -> Result<SystemPlan, String> {
    let body = rigid_body(scene, bodies, &body_unit("body", 0), "RigidBodyBehindArmour.fmu")?;
    let armour = armour(scene, bodies, plate::MODEL.values(), "Armour.fmu")?;
    Ok(armour_plan("gel-armour-body", scene, "BallisticGelBehindArmour.fmu", [armour, body]))
}

fn gel_soft_armour(bodies: &[Value]) -> Result<SystemPlan, String> {
    let scene = SOFT_ARMOUR_SCENE;
    let text = fs::read_to_string(SOFT_ARMOUR_PLATE).map_err(|error| format!("{SOFT_ARMOUR_PLATE}: {error}"))?;
    let parameters = starts::read(&plate::MODEL, &text).map_err(|error| format!("{SOFT_ARMOUR_PLATE}: {error}"))?;
    let body = rigid_body(scene, bodies, &body_unit("body", 0), "RigidBodyBehindSoftArmour.fmu")?;
    let armour = armour(scene, bodies, parameters, "SoftArmour.fmu")?;
    let mut plan = armour_plan("gel-soft-armour", scene, "BallisticGelBehindSoftArmour.fmu", [armour, body]);
    let gel = plan.units.iter_mut().find(|unit| unit.name == GEL).ok_or("the system has no gel")?;
    gel.watched.extend([port("sensor[2].pressure", 1, "Pa"), port("sensor[3].pressure", 1, "Pa")]);
    Ok(plan)
}

/// Returns the system of armour, gel and body. The plate steps first: its outputs belong to the step it has just made.
fn armour_plan(name: &'static str, scene: &str, gel_file: &'static str, [armour, body]: [Partner; 2]) -> SystemPlan {
    let unit = body_unit("body", 0);
    let watched = [
        ("height", "m"),
        ("height_rate", "m/s"),
        ("penetration", "m"),
        ("perforated", "1"),
        ("moving_mass", "kg"),
        ("momentum", "N.s"),
        ("impulse.projectile", "N.s"),
        ("impulse.gel", "N.s"),
        ("impulse.support", "N.s"),
        ("energy.kinetic", "J"),
        ("energy.elastic", "J"),
        ("energy.plastic", "J"),
        ("energy.projectile", "J"),
        ("energy.gel", "J"),
        ("energy.imbalance", "J"),
    ];
    let watched = watched.map(|(name, quantity)| port(name, 1, quantity)).to_vec();
    let plate = Unit { name: ARMOUR.to_owned(), file: armour.file.clone(), watched };
    SystemPlan {
        name,
        gel: gel_options(scene, "integrated"),
        gel_file,
        units: vec![plate, gel_unit(gel_file, &[&unit]), unit_of_body(&unit, &body)],
        partners: vec![armour, body],
        wires: [wires::impulses(&unit), wires::armour_wires(&unit)].concat(),
    }
}

/// The gel integrates three bodies, and each of them is followed by a partner of its own.
fn gel_fragments(bodies: &[Value]) -> Result<SystemPlan, String> {
    let (scene, gel_file) = (FRAGMENTS_SCENE, "BallisticGelFragments.fmu");
    let mut units = vec![];
    let (mut partners, mut followers, mut wires) = (vec![], vec![], vec![]);
    for body in 0..bodies.len() {
        let unit = body_unit(&format!("fragment{}", body + 1), body);
        let partner = rigid_body(scene, bodies, &unit, &format!("RigidBodyFragment{}.fmu", body + 1))?;
        followers.push(unit_of_body(&unit, &partner));
        wires.extend(wires::impulses(&unit));
        partners.push(partner);
        units.push(unit);
    }
    let gel = gel_unit(gel_file, &units.iter().collect::<Vec<_>>());
    let units = [vec![gel], followers].concat();
    let gel = gel_options(scene, "integrated");
    Ok(SystemPlan { name: "gel-fragments", gel, gel_file, partners, units, wires })
}

fn gel_options(scene: &str, mode: &'static str) -> GelOptions {
    GelOptions { scene: scene.to_owned(), mode, outputs: OUTPUTS }
}

fn body_unit(name: &str, body: usize) -> BodyUnit {
    BodyUnit { name: name.to_owned(), body }
}

fn rigid_body(scene: &str, bodies: &[Value], unit: &BodyUnit, file: &str) -> Result<Partner, String> {
    let starts = scene::body_starts(bodies, unit.body).map_err(named(scene))?;
    Ok(Partner { model: &body::MODEL, library: "rigid_body", file: file.to_owned(), starts })
}

fn armour(scene: &str, bodies: &[Value], parameters: Vec<f64>, file: &str) -> Result<Partner, String> {
    let starts = scene::armour_starts(bodies, parameters).map_err(named(scene))?;
    Ok(Partner { model: &plate::MODEL, library: "armour", file: file.to_owned(), starts })
}

fn gel_unit(file: &str, bodies: &[&BodyUnit]) -> Unit {
    let watched = bodies.iter().map(|body| port(&body.depth(), 1, "m")).collect();
    Unit { name: GEL.to_owned(), file: file.to_owned(), watched }
}

fn unit_of_body(unit: &BodyUnit, partner: &Partner) -> Unit {
    let watched = vec![port("position", 3, "m"), port("velocity", 3, "m/s"), port("total_impulse", 3, "N.s")];
    Unit { name: unit.name.clone(), file: partner.file.clone(), watched }
}

fn port(name: &str, size: usize, unit: &'static str) -> Port {
    Port { name: name.to_owned(), size, unit }
}

fn named(scene: &str) -> impl Fn(String) -> String {
    move |error| format!("scene {scene}: {error}")
}
