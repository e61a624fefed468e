//! Wires between the gel and its partners.

use crate::structure::{End, GEL, Wire};

/// Unit of the armour.
pub const ARMOUR: &str = "armour";

/// A unit that is a rigid body, and the body of the gel that it moves.
#[derive(Debug, Clone)]
pub struct BodyUnit {
    /// Name of the unit.
    pub name: String,
    /// Index of the body in the scene; 0 is the projectile.
    pub body: usize,
}

impl BodyUnit {
    /// Returns an input of the gel for this body, or an output that the gel predicts for it.
    fn motion(&self, name: &str) -> End {
        gel(format!("{}.{name}", self.owner()))
    }

    /// Returns an output of the contact between the gel and this body.
    fn contact(&self, name: &str) -> End {
        gel(if self.body == 0 { format!("contact.{name}") } else { format!("{}.contact.{name}", fragment(self.body)) })
    }

    /// Returns the name of the depth of this body in the gel.
    pub fn depth(&self) -> String {
        format!("{}.depth", self.owner())
    }

    fn owner(&self) -> String {
        if self.body == 0 { "projectile".to_owned() } else { fragment(self.body) }
    }

    fn end(&self, variable: &str) -> End {
        End { unit: self.name.clone(), variable: variable.to_owned() }
    }
}

fn fragment(body: usize) -> String {
    format!("fragment[{body}]")
}

fn gel(variable: String) -> End {
    End { unit: GEL.to_owned(), variable }
}

fn armour(variable: &str) -> End {
    End { unit: ARMOUR.to_owned(), variable: variable.to_owned() }
}

/// Returns the wires by which a body follows the impulses of the gel.
pub fn impulses(body: &BodyUnit) -> Vec<Wire> {
    let wire = |name: &str, size, unit| Wire { from: body.contact(name), to: body.end(name), size, unit };
    vec![
        wire("impulse", 3, "N.s"),
        wire("angular_impulse", 3, "N.m.s"),
        wire("impulse_moment", 3, "N.s2"),
        Wire { from: body.motion("predicted_orientation"), to: body.end("predicted_orientation"), size: 4, unit: "1" },
    ]
}

/// Returns the wires by which a body gives its motion to the gel, which reads it in `corrected` and `prescribed` only.
pub fn motion(body: &BodyUnit) -> Vec<Wire> {
    let wire = |name: &str, size, unit| Wire { from: body.end(name), to: body.motion(name), size, unit };
    vec![
        wire("position", 3, "m"),
        wire("velocity", 3, "m/s"),
        wire("orientation", 4, "1"),
        wire("angular_velocity", 3, "rad/s"),
    ]
}

/// Returns the wires of an armour between a body and the gel, whose first fragment is the dome.
pub fn armour_wires(body: &BodyUnit) -> Vec<Wire> {
    let meets =
        |name: &str, unit| Wire { from: body.end(name), to: armour(&format!("projectile.{name}")), size: 3, unit };
    let force = |to| Wire { from: armour("force"), to, size: 3, unit: "N" };
    let bulge =
        |name: &str, unit| Wire { from: armour(name), to: gel(format!("{}.{name}", fragment(1))), size: 1, unit };
    let answer = |name: &str| Wire {
        from: gel(format!("{}.contact.{name}", fragment(1))),
        to: armour(name),
        size: 1,
        unit: "N.s",
    };
    vec![
        meets("position", "m"),
        meets("velocity", "m/s"),
        force(body.motion("external_force")),
        force(body.end("force")),
        bulge("bulge_height", "m"),
        bulge("bulge_radius", "m"),
        bulge("bulge_height_rate", "m/s"),
        bulge("bulge_radius_rate", "m/s"),
        answer("bulge_height_impulse"),
        answer("bulge_radius_impulse"),
    ]
}
