//! Figures of a remeshing, for each method.

use crate::mesh::least_angle;
use crate::remesh::{ConservationDefects, MeshQuality};
use crate::scene::RemeshMethod;
use crate::simulation::{PreviewMesh, RemeshPreview};
use serde::Serialize;

/// Figures of one remeshing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RemeshFigures {
    /// Time of the remeshing, s.
    pub time: f64,
    /// Number of elements of the old mesh.
    pub elements: usize,
    /// Least element quality of the old mesh, q = 4√3 A/Σl².
    pub least_quality: f64,
    /// Outcome of each method.
    pub methods: Vec<MethodOutcome>,
}

/// Outcome of a remeshing method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodOutcome {
    /// Remeshing method.
    pub method: RemeshMethod,
    /// Reason for a refusal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
    /// Figures of the new mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshChange>,
}

/// Figures of a new mesh relative to the old mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeshChange {
    /// Number of the successful attempt, from 1.
    pub attempt: usize,
    /// Number of elements.
    pub elements: usize,
    /// Least element quality.
    pub least_quality: f64,
    /// Least angle of an element, degrees.
    pub least_angle: f64,
    /// Relative change of area.
    pub area: f64,
    /// Relative mass covered by no new element, or by two; it was deposited at the nearest point.
    pub mass: f64,
    /// Momentum defect before any correction, relative to √(2 m E).
    pub momentum: f64,
    /// Relative change of the kinetic energy.
    pub kinetic: f64,
    /// Relative change of the stored energy.
    pub stored: f64,
    /// Fraction of unchanged elements.
    pub unchanged: f64,
}

impl RemeshFigures {
    pub(super) fn of(preview: &RemeshPreview) -> Self {
        let outcome = |(method, new): &(RemeshMethod, Result<PreviewMesh, _>)| MethodOutcome {
            method: *method,
            refused: new.as_ref().err().map(ToString::to_string),
            mesh: new.as_ref().ok().map(MeshChange::of),
        };
        Self {
            time: preview.frame.time,
            elements: preview.trial.shapes.len(),
            least_quality: preview.trial.shapes.iter().copied().fold(f64::INFINITY, f64::min),
            methods: preview.trial.successors.iter().map(outcome).collect(),
        }
    }
}

impl MeshChange {
    fn of(new: &PreviewMesh) -> Self {
        let PreviewMesh { attempt, quality: MeshQuality { least, change, .. }, stored, ref defects, .. } = *new;
        let ConservationDefects { before, after, .. } = defects;
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
