//! Records of remeshings, and the preview of a remeshing before it is made.

use super::candidate::{CandidateMesh, RemeshAttempt, RemeshInput, RemeshRefusal, mesh_in_plane};
use super::gel_definition::RemeshSizes;
use super::model::GelModel;
use super::observe::MeshFrame;
use crate::math::Vector;
use crate::mesh::{Simplex, shape_quality};
use crate::remesh::{self, ConservationDefects, DeformedMesh, ImmersionSteps, MeshQuality, RemeshError, RemeshRules};
use crate::scene::RemeshMethod;
use std::fmt::{self, Display, Formatter};

/// Failed remeshing: the old mesh was kept, or the run ended with it.
#[derive(Debug, Clone, PartialEq)]
pub struct FailedRemesh {
    /// Time, s.
    pub time: f64,
    /// Reasons, attempt by attempt.
    pub why: Vec<RemeshRefusal>,
}

impl Display for FailedRemesh {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let mut reasons: Vec<String> = self.why.iter().map(ToString::to_string).collect();
        reasons.dedup();
        write!(f, "No new mesh was accepted at {:.6e} s: {}", self.time, reasons.join("; "))
    }
}

/// Record of a remeshing.
#[derive(Debug, Clone, PartialEq)]
pub struct RemeshRecord {
    /// Time, s.
    pub time: f64,
    /// Number of the successful attempt, from 1.
    pub attempt: usize,
    /// Quality of the new mesh.
    pub quality: MeshQuality,
    /// Fraction of the mass that was deposited where no new element covers the old ones.
    pub mass: f64,
    /// Momentum defect before any correction, apart from held nodes, N·s.
    pub momentum: f64,
    /// Kinetic energy before and after, J.
    pub kinetic: [f64; 2],
    /// Change of kinetic and stored energy, J.
    pub energy: f64,
    /// Elements of the new mesh.
    pub elements: usize,
    /// Fraction of the new elements that are elements of the old mesh.
    pub unchanged: f64,
    /// Wall-clock time of all attempts, s.
    pub seconds: f64,
}

impl RemeshRecord {
    pub(super) fn of<const D: usize>(candidate: &CandidateMesh<D>, time: f64, attempt: usize) -> Self {
        let CandidateMesh { birth, quality, defects, .. } = candidate;
        Self {
            time,
            attempt,
            quality: *quality,
            mass: defects.relative_mass(),
            momentum: defects.momentum_defect().norm(),
            kinetic: [defects.before.kinetic, defects.after.kinetic],
            energy: 0.0,
            elements: birth.mesh.elements.len(),
            unchanged: defects.unchanged,
            seconds: 0.0,
        }
    }
}

/// Preview of a remeshing with all its steps, by either method.
#[derive(Debug, Clone, PartialEq)]
pub struct RemeshPreview {
    /// Mesh to be replaced.
    pub frame: MeshFrame,
    /// Quality of each element, q = 4√3 A/Σl².
    pub shapes: Vec<f64>,
    /// Curvature indicator of displacement and velocity at each element, rad.
    pub bend: Vec<f64>,
    /// Target sizes of the nodes, m.
    pub size: Vec<f64>,
    /// Steps of the immersed method.
    pub steps: Result<ImmersionSteps, RemeshError>,
    /// New mesh by each method.
    pub successors: [(RemeshMethod, Result<PreviewMesh, RemeshRefusal>); 2],
}

/// New mesh of a preview.
#[derive(Debug, Clone, PartialEq)]
pub struct PreviewMesh {
    /// Nodal positions, m.
    pub points: Vec<Vector<2>>,
    /// Elements.
    pub elements: Vec<Simplex>,
    /// Nodal velocities, m/s.
    pub velocity: Vec<Vector<2>>,
    /// Number of the successful attempt, from 1.
    pub attempt: usize,
    /// Quality of the mesh.
    pub quality: MeshQuality,
    /// Changes of mass, momentum and energy by the transfer.
    pub defects: ConservationDefects<2>,
    /// Stored energy of the old mesh and of this one, J.
    pub stored: [f64; 2],
}

impl GelModel<2> {
    /// Builds the preview of a remeshing now.
    pub fn build_preview(&self, frame: MeshFrame, sizes: &RemeshSizes) -> RemeshPreview {
        let old = self.current_mesh();
        let position = self.engine.state().position.clone();
        let moved = DeformedMesh { mesh: &old.mesh, position: &position };
        let data = self.old_mesh_data(&moved, self.adjacency.clone());
        let size = self.target_sizes(&moved, sizes, &data.adjacency);
        let input = RemeshInput { old: &old, moved: &moved, data: &data, size: &size };
        let successors =
            [RemeshMethod::Immersed, RemeshMethod::Local].map(|method| (method, self.first_accepted(&input, method)));
        RemeshPreview {
            shapes: old.mesh.elements.iter().map(|element| shape_quality(&position, element)).collect(),
            bend: self.curvatures(&moved),
            steps: remesh::immerse(&moved, &size, &RemeshRules::default()),
            frame,
            size,
            successors,
        }
    }

    /// Mesh of the first accepted attempt; the reason of the last refusal if there is none.
    fn first_accepted(&self, input: &RemeshInput<'_, 2>, method: RemeshMethod) -> Result<PreviewMesh, RemeshRefusal> {
        let mut refused = None;
        for (attempt, number) in RemeshAttempt::of(method, self.is_viscoplastic()).into_iter().zip(1..) {
            match self.generate_candidate(input, mesh_in_plane, attempt) {
                Ok(candidate) => return Ok(self.preview_mesh(candidate, input.moved, number)),
                Err(why) => refused = Some(why),
            }
        }
        Err(refused.expect("a method has attempts"))
    }

    fn preview_mesh(&self, candidate: CandidateMesh<2>, moved: &DeformedMesh<'_, 2>, attempt: usize) -> PreviewMesh {
        let CandidateMesh { birth, memory, velocity, quality, defects, properties, .. } = candidate;
        let before = self.engine.gel().stored_energy(moved.position, &self.engine.state().memory);
        let stored = [before, self.gel_on_mesh(&birth, properties.patches).stored_energy(&birth.position, &memory)];
        PreviewMesh {
            points: birth.position,
            elements: birth.mesh.elements,
            velocity,
            attempt,
            quality,
            defects,
            stored,
        }
    }
}
