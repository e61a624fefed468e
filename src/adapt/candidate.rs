//! Candidate mesh for remeshing: mesh generation, acceptance and transfer of fields and state.

use super::adaptive_gel::{AdaptiveGel, MeshProperties};
use super::attempt::MeshGenerator;
use super::history;
use super::layer_parts::{RemeshedMasses, inherited_parts};
use super::refusal::RemeshRefusal;
use super::source_mesh::{SourceMesh, TargetMesh};
use crate::constitutive::MaterialParts;
use crate::contact::{BodyState, RigidBody};
use crate::fem::HistoryVariables;
use crate::math::{Vector, embed, restrict};
use crate::mesh::{ElementId, ElementPatches, Mesh, boundary_from_neighbours, face_neighbours};
use crate::remesh::operations::EditCounts;
use crate::remesh::{
    self, AcceptanceLimits, ConservationDefects, DeformedMesh, ElementNeighbours, MeshCorrespondence, MeshQuality,
    NodalFields, ProposedMesh, TransferredFields,
};
use crate::state::MeshInstance;

/// Accepted new mesh with its transferred fields and state.
#[derive(Debug)]
pub(super) struct CandidateMesh<const D: usize> {
    pub birth: MeshInstance<D>,
    /// History variables of the elements.
    pub memory: Vec<HistoryVariables<D>>,
    pub velocity: Vec<Vector<D>>,
    /// Quality of the mesh.
    pub quality: MeshQuality,
    /// Changes of mass, momentum and energy by the transfer.
    pub defects: ConservationDefects<D>,
    /// Derived properties of the mesh.
    pub properties: MeshProperties,
    /// Elements that are not elements of the old mesh.
    pub new_elements: Vec<ElementId>,
    /// Local operations that have made the mesh; `None` if it was made as a whole.
    pub edits: Option<EditCounts>,
}

/// Data of the mesh to be replaced that every attempt needs.
#[derive(Debug, Clone)]
pub(super) struct OldMeshData {
    /// Neighbours of each element.
    pub adjacency: ElementNeighbours,
    /// Current quality of each element, infinite where it is too good to matter.
    pub qualities: Vec<f64>,
}

/// Mesh to be replaced, and target sizes of the new one.
#[derive(Clone, Copy)]
pub(super) struct RemeshInput<'a, const D: usize> {
    pub old: &'a MeshInstance<D>,
    /// Mesh with its current nodal positions.
    pub moved: &'a DeformedMesh<'a, D>,
    pub data: &'a OldMeshData,
    /// Target sizes of the nodes, m; none where operations have made the mesh.
    pub size: &'a [f64],
}

/// Tolerance for the relative change of area or volume of a two-network gel, whose surface is smoothed: that of the wall of
/// a wide cavity in coarsening cells.
pub(super) const NETWORK_MEASURE_TOLERANCE: f64 = 1e-4;
/// Quality that an immersed mesh must reach if the old mesh did. Cutting stays above it except in corners that the
/// sizes do not resolve (`smooth_bodies_of_any_size_and_place_are_cut_out_whole`).
const IMMERSED_QUALITY: f64 = 0.1;
/// Relative tolerance of mass conservation. Round-off leaves 2e-14 over a run with a hundred remeshings.
const MASS_TOLERANCE: f64 = 1e-12;
/// Greatest ratio of new to old kinetic energy: finer meshes hold a few per cent more of short waves.
const MAX_KINETIC_RATIO: f64 = 1.1;
/// Fraction of an even share of its elements' masses below which a node is light. A node of a seventh in front of the
/// nose of `bullet-yaw` was thrown at twice the bullet's speed, which cut the step to a thousandth.
const LIGHT_NODE_SHARE: f64 = 0.25;

impl<const D: usize> CandidateMesh<D> {
    /// Elements that are not elements of the old mesh, and their masses, kg.
    pub fn new_elements_with_masses(&self) -> Vec<(ElementId, f64)> {
        self.new_elements.iter().map(|e| (*e, self.birth.corner_mass[e.index()].iter().sum())).collect()
    }
}

/// Data of the current mesh that every attempt needs; the neighbours are computed if they are not known.
pub(super) fn old_mesh_data<const D: usize>(
    gel: &AdaptiveGel<D>,
    moved: &DeformedMesh<'_, D>,
    adjacency: Option<ElementNeighbours>,
) -> OldMeshData {
    let adjacency = adjacency.unwrap_or_else(|| face_neighbours::<D>(&moved.mesh.elements));
    OldMeshData { adjacency, qualities: gel.definition.element_qualities(&moved.mesh.elements, moved.position) }
}

/// New mesh before the transfer of the fields.
pub(super) struct NewMesh<const D: usize> {
    pub proposal: ProposedMesh<D>,
    pub pairing: MeshCorrespondence,
    /// Limits that it must satisfy.
    pub acceptance: AcceptanceLimits,
    /// F-bar patches, if they are known.
    pub patches: Option<ElementPatches>,
}

/// Generates a new mesh of sizes scaled by a factor, and transfers all fields and state to it.
///
/// # Errors
/// [`RemeshRefusal`] if the mesh is not acceptable.
pub(super) fn generate_candidate<const D: usize>(
    gel: &AdaptiveGel<D>,
    input: &RemeshInput<'_, D>,
    generator: MeshGenerator<D>,
    size_factor: f64,
) -> Result<CandidateMesh<D>, RemeshRefusal> {
    let RemeshInput { old, moved, data, size } = *input;
    let (proposal, measure) = generator(moved, size, size_factor)?;
    let worst = data.qualities.iter().copied().fold(f64::INFINITY, f64::min);
    let measure = if gel.has_networks() { measure.max(NETWORK_MEASURE_TOLERANCE) } else { measure };
    let acceptance = AcceptanceLimits { measure, quality: worst.min(IMMERSED_QUALITY) };
    let pairing = MeshCorrespondence::of(&old.mesh, &proposal);
    transfer_to(gel, input, NewMesh { proposal, pairing, acceptance, patches: None })
}

/// Transfers all fields and state to a new mesh.
///
/// # Errors
/// [`RemeshRefusal`] if the mesh is not acceptable.
pub(super) fn transfer_to<const D: usize>(
    gel: &AdaptiveGel<D>,
    input: &RemeshInput<'_, D>,
    new: NewMesh<D>,
) -> Result<CandidateMesh<D>, RemeshRefusal> {
    let RemeshInput { old, moved, data, .. } = *input;
    let NewMesh { proposal, pairing, acceptance, patches } = new;
    let qualities =
        pairing.carried(&data.qualities, |e| gel.definition.element_quality(&proposal.position, &proposal.elements[e]));
    let adjacency = remesh::neighbours_after::<D>(&proposal.elements, &pairing, &data.adjacency);
    let facets = boundary_from_neighbours::<D>(&proposal.elements, &adjacency);
    let known = remesh::KnownQuality { shapes: &qualities, facets: &facets };
    let quality = remesh::check_acceptance_known(moved, &proposal, (&acceptance, &known))?;
    let new = transfer_fields(gel, old, moved, &proposal, pairing);
    check_conservation(&new.defects)?;
    let marks = remesh::facet_load_markers(&old.mesh, (&facets, &new.rest), &proposal.origin);
    let (rest, held) = (new.rest.clone(), new.held.clone());
    let mesh = Mesh { rest, elements: proposal.elements.clone(), facets, held, marks };
    let patches = patches.unwrap_or_else(|| gel.definition.build_patches(&mesh, &proposal.position, &adjacency));
    let (potential, memory) = (&gel.engine.gel().potential, &gel.engine.state().memory);
    let source = SourceMesh::new(potential, old, memory, moved.position);
    let target = TargetMesh::by(&proposal, &new, gel.elastic_average());
    let inherited = history::inherited(&source, moved.position, &target, &patches);
    let (references, memory) = inherited.ok_or(RemeshRefusal::Restless)?;
    let new_elements = (0..).map(ElementId).zip(&new.same).filter(|(_, same)| same.is_none()).map(|(e, _)| e).collect();
    let parts = material_parts(old, &new);
    let TransferredFields { mass, corner_mass, velocity, defects, .. } = new;
    let tick = gel.engine.last_tick();
    let (position, steps) = (proposal.position, vec![]);
    let birth = MeshInstance { tick, mesh, position, mass, corner_mass, references, patches, parts, steps };
    let properties = MeshProperties { qualities, adjacency };
    Ok(CandidateMesh { birth, memory, velocity, quality, defects, properties, new_elements, edits: None })
}

/// Parts of mass of the materials of the new elements of a layered gel; empty of a gel of one material.
fn material_parts<const D: usize>(old: &MeshInstance<D>, new: &TransferredFields<D>) -> Vec<MaterialParts> {
    if old.parts.is_empty() {
        return vec![];
    }
    let [old_mass, mass] = [&old.corner_mass, &new.corner_mass]
        .map(|all| all.iter().map(|own| own[..=D].iter().sum()).collect::<Vec<f64>>());
    let TransferredFields { same, sources, .. } = new;
    inherited_parts(&RemeshedMasses { old: &old.parts, old_mass: &old_mass, same, sources, mass: &mass })
}

/// Transfers mass and momentum to the new mesh. The transfer is repeated without corners of negative density if a
/// node becomes massless or light.
fn transfer_fields<const D: usize>(
    gel: &AdaptiveGel<D>,
    old: &MeshInstance<D>,
    moved: &DeformedMesh<'_, D>,
    proposal: &ProposedMesh<D>,
    pairing: MeshCorrespondence,
) -> TransferredFields<D> {
    let fields = NodalFields {
        symmetry: gel.definition.body_symmetry(),
        mass: &old.mass,
        corner_mass: &old.corner_mass,
        velocity: &gel.engine.state().velocity,
        is_level: false,
    };
    let new = remesh::transfer_paired(moved, &fields, (proposal, pairing.clone()));
    let is_light = || remesh::least_relative_mass(&proposal.elements, &new) < LIGHT_NODE_SHARE;
    if new.defects.massless == 0 && !is_light() {
        return new;
    }
    remesh::transfer_paired(moved, &NodalFields { is_level: true, ..fields }, (proposal, pairing))
}

/// Projects a point inside a body onto its surface: contact would have to push a new boundary node out of the body
/// later.
pub(super) fn clear_of_bodies<const D: usize>(bodies: &[(&RigidBody, BodyState)], x: &Vector<D>) -> Vector<D> {
    bodies.iter().fold(*x, |x, (body, at)| {
        let gap = body.gap(at, &embed(&x));
        x - restrict::<D>(&gap.normal) * gap.distance.min(0.0)
    })
}

/// Checks that a transfer has conserved mass, and not increased the kinetic energy.
fn check_conservation<const D: usize>(defects: &ConservationDefects<D>) -> Result<(), RemeshRefusal> {
    if defects.massless > 0 {
        return Err(RemeshRefusal::Massless { nodes: defects.massless });
    }
    let (before, after) = (defects.before.mass, defects.after.mass);
    if after.is_nan() || (after - before).abs() > MASS_TOLERANCE * before {
        return Err(RemeshRefusal::Mass { before, after });
    }
    let (before, after) = (defects.before.kinetic, defects.after.kinetic);
    if after.is_nan() || after > MAX_KINETIC_RATIO * before {
        return Err(RemeshRefusal::Gains { before, after });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector3;
    use crate::remesh::ConservedTotals;

    #[test]
    fn a_mesh_of_another_mass_is_refused() {
        let (momentum, angular) = (Vector::<2>::zeros(), Vector3::zeros());
        let books = |mass: f64| ConservedTotals { mass, momentum, angular, kinetic: 1.0 };
        let defects = |mass: f64| ConservationDefects {
            before: books(20.0),
            raw: books(mass),
            after: books(mass),
            held_momentum: momentum,
            held_angular: angular,
            stray_mass: 0.0,
            unchanged: 1.0,
            misses: 0,
            massless: 0,
        };
        assert_eq!(check_conservation(&defects(20.0 + 1e-12)), Ok(()));
        for after in [20.0 - 1e-4, 20.0 + 1e-10, 0.0] {
            assert_eq!(check_conservation(&defects(after)), Err(RemeshRefusal::Mass { before: 20.0, after }));
        }
        assert!(matches!(check_conservation(&defects(f64::NAN)), Err(RemeshRefusal::Mass { .. })));
    }
}
