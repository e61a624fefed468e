//! Trial of a remeshing by each method, without changing the gel.

use super::adaptive_gel::AdaptiveGel;
use super::attempt::{SIZE_FACTORS, generate_mesh};
use super::candidate::{CandidateMesh, RemeshInput, generate_candidate, old_mesh_data};
use super::local_edits::{candidate_of, edit_mesh};
use super::refusal::RemeshRefusal;
use super::settings::{AdaptSettings, RemeshMethod};
use super::sizes::{curvatures, target_sizes};
use crate::math::Vector;
use crate::mesh::{Simplex, shape_quality, signed_volume};
use crate::remesh::{self, ConservationDefects, DeformedMesh, ImmersionSteps, MeshQuality, MeshRejected, RemeshError};
use crate::state::MeshInstance;

/// Remeshing with all its steps, by either method.
#[derive(Debug, Clone, PartialEq)]
pub struct RemeshTrial {
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

/// Tries a remeshing now by both methods.
pub(super) fn try_remesh(gel: &AdaptiveGel<2>, settings: &AdaptSettings) -> RemeshTrial {
    let old = gel.current_mesh();
    let position = gel.engine.state().position.clone();
    let moved = DeformedMesh { mesh: &old.mesh, position: &position };
    let data = old_mesh_data(gel, &moved, gel.adjacency.clone());
    let size = target_sizes(gel, &moved, settings, &data.adjacency);
    let input = RemeshInput { old: &old, moved: &moved, data: &data, size: &size };
    let local = after_operations(gel, &input, settings);
    let immersed = first_accepted(gel, &input);
    let successors = [(RemeshMethod::Immersed, immersed), (RemeshMethod::Local, local)];
    RemeshTrial {
        shapes: old.mesh.elements.iter().map(|element| shape_quality(&position, element)).collect(),
        bend: curvatures(gel, &moved),
        steps: remesh::immerse(&moved, &size),
        size,
        successors,
    }
}

/// Mesh after local operations; the reason of the refusal if elements stay inverted, or the fields cannot be transferred.
fn after_operations(
    gel: &AdaptiveGel<2>,
    input: &RemeshInput<'_, 2>,
    settings: &AdaptSettings,
) -> Result<PreviewMesh, RemeshRefusal> {
    let candidate = candidate_of(gel, input, edit_mesh(gel, input.old, settings))?;
    let MeshInstance { mesh, position, .. } = &candidate.birth;
    let mut measures = mesh.elements.iter().map(|nodes| signed_volume(position, nodes)).enumerate();
    match measures.find(|(_, measure)| *measure <= 0.0) {
        Some((element, measure)) => Err(MeshRejected::Inverted { element, measure }.into()),
        None => Ok(preview_mesh(gel, candidate, input.moved, 1)),
    }
}

/// Mesh of the first accepted attempt of the immersed method; the reason of the last refusal if there is none.
fn first_accepted(gel: &AdaptiveGel<2>, input: &RemeshInput<'_, 2>) -> Result<PreviewMesh, RemeshRefusal> {
    let mut refused = None;
    for (size_factor, number) in SIZE_FACTORS.into_iter().zip(1..) {
        match generate_candidate(gel, input, generate_mesh, size_factor) {
            Ok(candidate) => return Ok(preview_mesh(gel, candidate, input.moved, number)),
            Err(why) => refused = Some(why),
        }
    }
    Err(refused.expect("there are attempts"))
}

fn preview_mesh(
    gel: &AdaptiveGel<2>,
    candidate: CandidateMesh<2>,
    moved: &DeformedMesh<'_, 2>,
    attempt: usize,
) -> PreviewMesh {
    let CandidateMesh { birth, memory, velocity, quality, defects, .. } = candidate;
    let before = gel.engine.gel().stored_energy(moved.position, &gel.engine.state().memory);
    let stored = [before, gel.gel_on_mesh(&birth).stored_energy(&birth.position, &memory)];
    PreviewMesh { points: birth.position, elements: birth.mesh.elements, velocity, attempt, quality, defects, stored }
}
