//! Remeshing by local operations: those of a gel without history variables keep its rest map, the rest positions X that
//! the nodes carry; those of a gel that flows are judged in its present configuration, and its history is transferred.

use super::adaptive_gel::{AdaptiveGel, MeshProperties};
use super::candidate::{CandidateMesh, NewMesh, RemeshInput, clear_of_bodies, transfer_to};
use super::hindrance::{ElasticElements, FlowingElements, compressed_elements, hindering_elements};
use super::layer_parts::{corners_of, parts_at_rest};
use super::refusal::RemeshRefusal;
use super::settings::AdaptSettings;
use super::sizes::BodySizes;
use crate::constitutive::MaterialParts;
use crate::fem::Potential;
use crate::mesh::{ElementId, Mesh, Simplex, boundary_from_neighbours, signed_volume};
use crate::remesh::operations::{
    EditCounts, EditLimits, EditScene, EditSource, EditableMesh, EditedMesh, ReferenceConfiguration, improve,
};
use crate::remesh::{
    self, AcceptanceLimits, ConservationDefects, ConservedTotals, MeshCorrespondence, ProposedMesh, UnchangedElement,
};
use crate::state::MeshInstance;

/// Hindrance that local operations may leave of a gel that flows; beyond it a mesh in the plane or about an axis is
/// immersed. A gel with a rest map would lose it then, so there only an inverted element is reason enough: a short step
/// costs little, as it is local.
const SUFFICIENT_HINDRANCE: f64 = 8.0;
/// Relative change of the area or volume of a gel that flows by the operations of one remeshing: each may smooth the
/// surface. With 1e-4 two of seven balls of 1500 to 2500 m/s on coarse meshes diverged on the meshes that took their
/// place.
const EDITED_MEASURE: f64 = 1e-3;

/// Mesh after local operations.
pub(super) struct EditedGel<const D: usize> {
    mesh: EditedMesh<D>,
    pairing: MeshCorrespondence,
    /// Operations performed.
    counts: EditCounts,
    /// Inverted elements that are left.
    inverted: usize,
}

impl<const D: usize> EditedGel<D> {
    /// Returns true if no element hinders so much that a whole mesh is better for this gel.
    pub(super) fn is_sufficient(&self, gel: &AdaptiveGel<D>) -> bool {
        self.is_upright() && self.counts.hindrance <= if gel.flows() { SUFFICIENT_HINDRANCE } else { f64::MAX }
    }

    /// Returns true if no element is inverted.
    pub(super) fn is_upright(&self) -> bool {
        self.inverted == 0 && self.counts.hindrance.is_finite()
    }

    /// Refusal of this mesh for its inverted elements.
    pub(super) fn refusal(&self) -> RemeshRefusal {
        RemeshRefusal::Inverted { elements: self.inverted.max(1) }
    }

    /// Fraction of the elements that stay.
    fn unchanged(&self) -> f64 {
        self.pairing.same.iter().flatten().count() as f64 / self.pairing.same.len() as f64
    }
}

/// Remakes the elements that hinder the gel of the engine, by local operations.
pub(super) fn edit_mesh<const D: usize>(
    gel: &AdaptiveGel<D>,
    old: &MeshInstance<D>,
    settings: &AdaptSettings,
) -> EditedGel<D> {
    let settings = &settings.of_operations();
    let (potential, state) = (&gel.engine.gel().potential, gel.engine.state());
    let compatible = (0..potential.len() as u32).map(|element| potential.is_compatible(ElementId(element))).collect();
    let grid = gel.engine.grid();
    let step = |element| Some(gel.engine.step_of(ElementId(element))).filter(|step| *step > 0);
    let steps = (0..potential.len() as u32).map(|e| step(e).map_or(f64::INFINITY, |step| grid.time(step))).collect();
    let flows = gel.flows();
    let mut mesh = EditableMesh::new(EditSource {
        mesh: &old.mesh,
        incidence: &gel.engine.gel().star,
        patches: potential.patches(),
        position: &state.position,
        velocity: &state.velocity,
        mass: &old.mass,
        corner_mass: &old.corner_mass,
        step: steps,
        is_compatible: if flows { vec![true; potential.len()] } else { compatible },
        symmetry: gel.definition.body_symmetry(),
        configuration: if flows { ReferenceConfiguration::Present } else { ReferenceConfiguration::Rest },
    });
    let bodies = gel.active_bodies();
    let sizes = BodySizes::new(&bodies, settings);
    let scene = EditScene {
        gap: &|x| sizes.gap(x),
        cleared: &|x| clear_of_bodies(&bodies, x),
        size: &|x| sizes.of(x),
        growth: settings.growth,
    };
    let totals = gel.engine.totals(gel.engine.now());
    let limits = EditLimits {
        energy: totals.provided.total(),
        usual: settings.usual,
        least: settings.tip_size.unwrap_or(settings.usual).min(settings.usual),
    };
    let bad = hindering_elements(gel, old, settings);
    let counts = if flows {
        let elements = FlowingElements::of(gel, settings, limits.energy);
        for (element, compression) in compressed_elements(gel, settings, &bad) {
            mesh.raise_hindrance(element, &elements, compression);
        }
        improve(&mut mesh, &elements, &scene, &limits, bad)
    } else {
        improve(&mut mesh, &ElasticElements::of(gel, settings), &scene, &limits, bad)
    };
    let (mesh, pairing) = mesh.finish();
    // An element whose rest shape is its own is left alone by the operations, inverted or not.
    let inverted = mesh.elements.iter().filter(|nodes| signed_volume(&mesh.position, nodes) <= 0.0).count();
    EditedGel { mesh, pairing, counts, inverted }
}

/// Candidate mesh after local operations, with all fields and state.
///
/// # Errors
/// [`RemeshRefusal`] if the mesh of a gel with history variables is not acceptable.
pub(super) fn candidate_of<const D: usize>(
    gel: &AdaptiveGel<D>,
    input: &RemeshInput<'_, D>,
    edited: EditedGel<D>,
) -> Result<CandidateMesh<D>, RemeshRefusal> {
    if gel.flows() { transfer_edited(gel, input, edited) } else { Ok(keep_rest_map(gel, input, edited)) }
}

/// Candidate of a gel with a rest map: the operations have carried all fields.
fn keep_rest_map<const D: usize>(
    gel: &AdaptiveGel<D>,
    input: &RemeshInput<'_, D>,
    edited: EditedGel<D>,
) -> CandidateMesh<D> {
    let (unchanged, edits) = (edited.unchanged(), Some(edited.counts));
    let before = ConservedTotals::of(input.moved.position, &input.old.mass, &gel.engine.state().velocity);
    let EditedGel { mesh: edited, pairing, .. } = edited;
    let EditedMesh { rest, position, velocity, held, mass, elements, corner_mass, patches, step: steps, .. } = edited;
    let qualities = pairing.carried(&input.data.qualities, |e| gel.definition.element_quality(&position, &elements[e]));
    let adjacency = remesh::neighbours_after::<D>(&elements, &pairing, &input.data.adjacency);
    let facets = boundary_from_neighbours::<D>(&elements, &adjacency);
    let marks = remesh::facet_load_markers_at_rest(&input.old.mesh, &facets, &rest, &pairing.unchanged);
    let potential = &gel.engine.gel().potential;
    let references = (0..)
        .map(ElementId)
        .zip(&pairing.same)
        .filter_map(|(new, same)| Some((new, same.as_ref()?.element)))
        .filter(|(_, old)| !potential.is_compatible(*old))
        .map(|(new, old)| (new, potential.reference(old)))
        .collect();
    let after = ConservedTotals::of(&position, &mass, &velocity);
    let defects = ConservationDefects {
        before,
        raw: after,
        after,
        held_momentum: before.momentum - after.momentum,
        held_angular: before.angular - after.angular,
        stray_mass: 0.0,
        unchanged,
        misses: 0,
        massless: 0,
    };
    let new_elements = pairing.changed().map(|e| ElementId(e as u32)).collect();
    let mesh = Mesh { rest, elements, facets, held, marks };
    let tick = gel.engine.last_tick();
    let parts = parts_by_rest_map(gel, &mesh, &input.old.parts, &pairing);
    let birth = MeshInstance { tick, mesh, position, mass, corner_mass, references, patches, parts, steps };
    let properties = MeshProperties { qualities, adjacency };
    let quality = properties.quality();
    CandidateMesh { birth, memory: vec![], velocity, quality, defects, properties, new_elements, edits }
}

/// Parts of mass of the materials of a layered gel with a rest map, by the rest positions of new elements; empty of a gel
/// of one material.
fn parts_by_rest_map<const D: usize>(
    gel: &AdaptiveGel<D>,
    mesh: &Mesh<D>,
    old: &[MaterialParts],
    pairing: &MeshCorrespondence,
) -> Vec<MaterialParts> {
    let (Some(stack), section) = (&gel.definition.layers, gel.definition.section) else { return vec![] };
    let of = |(nodes, same): (&Simplex, &Option<UnchangedElement>)| match same {
        Some(same) => old[same.element.index()],
        None => parts_at_rest(stack, section, &corners_of(&mesh.rest, nodes)),
    };
    mesh.elements.iter().zip(&pairing.same).map(of).collect()
}

/// Candidate of a gel that flows: its fields are transferred.
fn transfer_edited<const D: usize>(
    gel: &AdaptiveGel<D>,
    input: &RemeshInput<'_, D>,
    edited: EditedGel<D>,
) -> Result<CandidateMesh<D>, RemeshRefusal> {
    let EditedGel { mesh, pairing, counts, .. } = edited;
    let EditedMesh { position, origin, elements, over, patches, .. } = mesh;
    let proposal = ProposedMesh { position, origin, elements, over };
    let acceptance = AcceptanceLimits { measure: EDITED_MEASURE, quality: 0.0 };
    let candidate = transfer_to(gel, input, NewMesh { proposal, pairing, acceptance, patches: Some(patches) })?;
    Ok(CandidateMesh { edits: Some(counts), ..candidate })
}
