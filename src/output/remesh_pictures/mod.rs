//! An exchange of the mesh in pictures, step by step (figure 6 of the paper), and its figures.

mod drawing;
mod page;
mod panels;

use super::files::OutputError;
use super::folder::ResultFolder;
use crate::mesh::least_angle;
use crate::remesh::{Defects, Quality};
use crate::scene::{RemeshMethod, Scene};
use crate::simulation::{Rehearsal, Successor};
use serde::Serialize;

/// What an exchange changes, in numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// When, s.
    pub time: f64,
    /// Elements of the mesh that ends.
    pub elements: usize,
    /// Their least quality, q = 4√3 A/Σl².
    pub least_quality: f64,
    /// What each method makes of it.
    pub methods: Vec<Outcome>,
}

/// What a method makes of a mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// Which.
    pub method: RemeshMethod,
    /// Why it makes none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
    /// The numbers of the mesh that it makes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<Change>,
}

/// The numbers of a new mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Change {
    /// Which attempt made it, from 1.
    pub attempt: usize,
    /// Elements.
    pub elements: usize,
    /// Their least quality.
    pub least_quality: f64,
    /// Their least angle, degrees.
    pub least_angle: f64,
    /// Change of area, as a share.
    pub area: f64,
    /// Mass that no new element lay over, or two, as a share: it was laid down at the nearest place.
    pub mass: f64,
    /// Momentum that appeared before any correction, as a share of √(2 m E).
    pub momentum: f64,
    /// Change of the kinetic energy, as a share of it.
    pub kinetic: f64,
    /// Change of the stored energy, as a share of it.
    pub stored: f64,
    /// Part of the elements that are old ones.
    pub unchanged: f64,
}

impl Figures {
    fn of(shown: &Rehearsal) -> Self {
        let outcome = |(method, new): &(RemeshMethod, Result<Successor, _>)| Outcome {
            method: *method,
            refused: new.as_ref().err().map(ToString::to_string),
            mesh: new.as_ref().ok().map(Change::of),
        };
        Self {
            time: shown.frame.time,
            elements: shown.shapes.len(),
            least_quality: shown.shapes.iter().copied().fold(f64::INFINITY, f64::min),
            methods: shown.successors.iter().map(outcome).collect(),
        }
    }
}

impl Change {
    fn of(new: &Successor) -> Self {
        let Successor { attempt, quality: Quality { least, change, .. }, stored, ref defects, .. } = *new;
        let Defects { before, after, .. } = defects;
        let angles = new.elements.iter().map(|nodes| least_angle(&new.points, nodes));
        Self {
            attempt,
            elements: new.elements.len(),
            least_quality: least,
            least_angle: angles.fold(180.0, f64::min),
            area: change,
            mass: defects.relative_mass(),
            momentum: defects.momentum_defect().norm() / (2.0 * before.mass * before.kinetic).sqrt(),
            kinetic: after.kinetic / before.kinetic - 1.0,
            stored: stored[1] / stored[0] - 1.0,
            unchanged: defects.unchanged,
        }
    }
}

/// Writes the pictures of an exchange, and `index.html` that shows them in order with their figures.
///
/// # Errors
/// [`OutputError`] when a file cannot be written.
pub fn draw(folder: &mut ResultFolder, scene: &Scene, shown: &Rehearsal) -> Result<Figures, OutputError> {
    let panels = panels::panels(shown, scene);
    for (panel, number) in panels.iter().zip(1..) {
        for (view, picture) in [("whole", &panel.whole), ("close", &panel.close)] {
            folder.write(&page::file(number, panel.name, view), picture)?;
        }
    }
    let figures = Figures::of(shown);
    folder.write("index.html", page::page(scene, &panels, &figures).as_bytes())?;
    Ok(figures)
}
