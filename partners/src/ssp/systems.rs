//! The systems: gel and body, and gel, armour and body.

use crate::structure::{Unit, Wire};

/// File of the body of `gel-and-body`.
pub const BODY: &str = "RigidBody.fmu";
/// File of the body of `gel-armour-body`.
pub const BODY_BEHIND_ARMOUR: &str = "RigidBodyBehindArmour.fmu";
/// File of the armour.
pub const ARMOUR: &str = "Armour.fmu";

/// Units of a gel and a body, their FMUs in these files.
pub fn gel_and_body(gel: &'static str, body: &'static str) -> Vec<Unit> {
    let watched = vec![("contact.total_impulse", 3, "N.s"), ("projectile.predicted_velocity", 3, "m/s")];
    let gel = Unit { name: "gel", file: gel, watched };
    vec![gel, Unit { name: "body", file: body, watched: vec![("total_impulse", 3, "N.s")] }]
}

/// Units of armour, gel and body. The plate steps first: what it gives belongs to the step that it has just made.
pub fn gel_armour_and_body(gel: &'static str) -> Vec<Unit> {
    let mut units = gel_and_body(gel, BODY_BEHIND_ARMOUR);
    let watched = vec![
        ("height", 1, "m"),
        ("penetration", 1, "m"),
        ("perforated", 1, "1"),
        ("impulse.projectile", 1, "N.s"),
        ("impulse.gel", 1, "N.s"),
        ("energy.imbalance", 1, "J"),
    ];
    units.insert(0, Unit { name: "armour", file: ARMOUR, watched });
    units
}

/// File of the gel among these units.
pub fn gel_file(units: &[Unit]) -> &'static str {
    units.iter().find(|unit| unit.name == "gel").map_or("", |unit| unit.file)
}

/// Wires between gel and body.
pub fn gel_and_body_wires() -> Vec<Wire> {
    let wire = |from, to, size, unit| Wire { from, to, size, unit };
    vec![
        wire(("gel", "contact.impulse"), ("body", "impulse"), 3, "N.s"),
        wire(("gel", "contact.angular_impulse"), ("body", "angular_impulse"), 3, "N.m.s"),
        wire(("gel", "contact.impulse_moment"), ("body", "impulse_moment"), 3, "N.s2"),
        wire(("gel", "projectile.predicted_orientation"), ("body", "predicted_orientation"), 4, "1"),
        wire(("body", "position"), ("gel", "projectile.position"), 3, "m"),
        wire(("body", "velocity"), ("gel", "projectile.velocity"), 3, "m/s"),
        wire(("body", "orientation"), ("gel", "projectile.orientation"), 4, "1"),
        wire(("body", "angular_velocity"), ("gel", "projectile.angular_velocity"), 3, "rad/s"),
    ]
}

/// Wires between armour, gel and body. The dome is the gel's first fragment.
pub fn gel_armour_and_body_wires() -> Vec<Wire> {
    let wire = |from, to, size, unit| Wire { from, to, size, unit };
    let mut wires = gel_and_body_wires();
    wires.extend([
        wire(("gel", "projectile.predicted_position"), ("armour", "projectile.position"), 3, "m"),
        wire(("gel", "projectile.predicted_velocity"), ("armour", "projectile.velocity"), 3, "m/s"),
        wire(("armour", "force"), ("gel", "projectile.external_force"), 3, "N"),
        wire(("armour", "force"), ("body", "force"), 3, "N"),
        wire(("armour", "bulge_height"), ("gel", "fragment[1].bulge_height"), 1, "m"),
        wire(("armour", "bulge_radius"), ("gel", "fragment[1].bulge_radius"), 1, "m"),
        wire(("armour", "bulge_height_rate"), ("gel", "fragment[1].bulge_height_rate"), 1, "m/s"),
        wire(("armour", "bulge_radius_rate"), ("gel", "fragment[1].bulge_radius_rate"), 1, "m/s"),
        wire(("gel", "fragment[1].contact.bulge_height_impulse"), ("armour", "bulge_height_impulse"), 1, "N.s"),
        wire(("gel", "fragment[1].contact.bulge_radius_impulse"), ("armour", "bulge_radius_impulse"), 1, "N.s"),
    ]);
    wires
}
