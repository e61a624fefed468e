//! Remeshing by local operations: those of a gel without history variables keep its rest map, those of a gel that flows
//! are performed in its present shape, and its history is transferred.

use super::adaptive_gel::{AdaptiveGel, MeshProperties};
use super::candidate::{
    CandidateMesh, NETWORK_MEASURE_TOLERANCE, NewMesh, OldMeshData, RemeshInput, clear_of_bodies, transfer_to,
};
use super::hindrance::{ElasticElements, FlowingElements, hindering_elements};
use super::record::RemeshRecord;
use super::refusal::RemeshRefusal;
use super::settings::AdaptSettings;
use super::sizes::BodySizes;
use crate::fem::Potential;
use crate::integrator::UnusableStep;
use crate::math::Vector;
use crate::mesh::{ElementId, Mesh, boundary_from_neighbours};
use crate::remesh::operations::{
    EditCounts, EditLimits, EditScene, EditSource, EditableMesh, EditedMesh, RestMap, improve,
};
use crate::remesh::{self, AcceptanceLimits, MeshCorrespondence, ProposedMesh};
use crate::state::MeshInstance;
use std::time::Instant;

/// Hindrance that local operations may leave; beyond it the mesh is exchanged, and new elements have rest shapes of their
/// own.
const SUFFICIENT_HINDRANCE: f64 = 8.0;

/// Mesh after local operations.
pub(super) struct EditedGel<const D: usize> {
    mesh: EditedMesh<D>,
    pairing: MeshCorrespondence,
    /// Operations performed.
    counts: EditCounts,
}

impl<const D: usize> EditedGel<D> {
    /// Returns true if no element hinders much.
    pub(super) fn is_sufficient(&self) -> bool {
        self.counts.hindrance <= SUFFICIENT_HINDRANCE
    }

    /// Returns true if no element is inverted.
    pub(super) fn is_upright(&self) -> bool {
        self.counts.hindrance.is_finite()
    }

    /// Operations performed.
    pub(super) fn counts(&self) -> EditCounts {
        self.counts
    }

    /// Fraction of the elements that stay.
    pub(super) fn unchanged(&self) -> f64 {
        self.pairing.same.iter().flatten().count() as f64 / self.pairing.same.len() as f64
    }

    /// Elements that operations have made, and their masses, kg.
    fn new_elements(&self) -> Vec<(ElementId, f64)> {
        let all = (0..).map(ElementId).zip(&self.pairing.same).zip(&self.mesh.corner_mass);
        all.filter(|((_, same), _)| same.is_none()).map(|((e, _), corners)| (e, corners[..=D].iter().sum())).collect()
    }
}

/// Remakes the elements that hinder the gel of the engine, by local operations.
pub(super) fn edit_mesh<const D: usize>(
    gel: &AdaptiveGel<D>,
    old: &MeshInstance<D>,
    settings: &AdaptSettings,
) -> EditedGel<D> {
    let (potential, state) = (&gel.engine.gel().potential, gel.engine.state());
    let compatible = (0..potential.len() as u32).map(|element| potential.is_compatible(ElementId(element))).collect();
    let grid = gel.engine.grid();
    let step = |element| Some(gel.engine.step_of(ElementId(element))).filter(|step| *step > 0);
    let steps = (0..potential.len() as u32).map(|e| step(e).map_or(f64::INFINITY, |step| grid.time(step))).collect();
    let flows = gel.has_networks();
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
        rest_map: if flows { RestMap::Present } else { RestMap::Nodes },
    });
    let bodies = gel.active_bodies();
    let sizes = BodySizes::new(&bodies, settings);
    let scene = EditScene { gap: &|x| sizes.gap(x), cleared: &|x| clear_of_bodies(&bodies, x), size: &|x| sizes.of(x) };
    let totals = gel.engine.totals(gel.engine.now());
    let limits = EditLimits {
        energy: totals.ledger.energy.provided(totals.initial_energy),
        usual: settings.usual,
        least: settings.tip_size.unwrap_or(settings.usual).min(settings.usual),
    };
    let bad = hindering_elements(gel, old, settings);
    let counts = if flows {
        improve(&mut mesh, &FlowingElements::of(gel, settings), &scene, &limits, bad)
    } else {
        improve(&mut mesh, &ElasticElements::of(gel, settings), &scene, &limits, bad)
    };
    let (mesh, pairing) = mesh.finish();
    EditedGel { mesh, pairing, counts }
}

/// Instance of the mesh after local operations, its properties and the velocities of its nodes, m/s.
pub(super) fn instance_of<const D: usize>(
    gel: &AdaptiveGel<D>,
    old: &MeshInstance<D>,
    edited: EditedGel<D>,
    data: &OldMeshData,
) -> (MeshInstance<D>, MeshProperties, Vec<Vector<D>>) {
    let EditedGel { mesh: edited, pairing, .. } = edited;
    let EditedMesh { rest, position, velocity, held, mass, elements, corner_mass, patches, step: steps, .. } = edited;
    let qualities = pairing.carried(&data.qualities, |e| gel.definition.element_quality(&position, &elements[e]));
    let adjacency = remesh::neighbours_after::<D>(&elements, &pairing, &data.adjacency);
    let facets = boundary_from_neighbours::<D>(&elements, &adjacency);
    let marks = remesh::facet_load_markers_at_rest(&old.mesh, (&facets, &rest), &pairing.unchanged);
    let potential = &gel.engine.gel().potential;
    let references = (0..)
        .map(ElementId)
        .zip(&pairing.same)
        .filter_map(|(new, same)| Some((new, same.as_ref()?.element)))
        .filter(|(_, old)| !potential.is_compatible(*old))
        .map(|(new, old)| (new, potential.reference(old)))
        .collect();
    let mesh = Mesh { rest, elements, facets, held, marks };
    let tick = gel.engine.last_tick();
    let birth = MeshInstance { tick, mesh, position, mass, corner_mass, references, patches, steps };
    (birth, MeshProperties { qualities, adjacency }, velocity)
}

/// Mesh of a gel with history variables after local operations, with all fields transferred.
///
/// # Errors
/// [`RemeshRefusal`] if the mesh is not acceptable.
pub(super) fn transfer_edited<const D: usize>(
    gel: &AdaptiveGel<D>,
    input: &RemeshInput<'_, D>,
    edited: EditedGel<D>,
) -> Result<CandidateMesh<D>, RemeshRefusal> {
    let EditedGel { mesh, pairing, .. } = edited;
    let EditedMesh { position, origin, elements, over, patches, .. } = mesh;
    let proposal = ProposedMesh { position, origin, elements, over, cleared: 0.0 };
    let acceptance = AcceptanceLimits { measure: NETWORK_MEASURE_TOLERANCE, quality: 0.0 };
    transfer_to(gel, input, NewMesh { proposal, pairing, acceptance, patches: Some(patches) })
}

/// Continues the run on the mesh after local operations; `begun` is when the remeshing began. The energy that the
/// operations took returns to the motion of the elements that they made.
///
/// # Errors
/// [`UnusableStep`] if the mesh could not be stepped.
pub(super) fn install_edited<const D: usize>(
    gel: &mut AdaptiveGel<D>,
    input: &RemeshInput<'_, D>,
    edited: EditedGel<D>,
    begun: Instant,
) -> Result<(), UnusableStep> {
    let booked = gel.engine.state().ledger.energy.remesh;
    let (new_elements, counts, unchanged) = (edited.new_elements(), edited.counts, edited.unchanged());
    let before = gel.kinetic_energy();
    let (birth, properties, velocity) = instance_of(gel, input.old, edited, input.data);
    let (quality, elements) = (properties.quality(), birth.mesh.elements.len());
    gel.install_mesh(birth, vec![], velocity, properties)?;
    let kinetic = [before, gel.kinetic_energy()];
    gel.engine.count_remesh();
    gel.engine.return_energy(&new_elements, booked - gel.engine.state().ledger.energy.remesh);
    let energy = gel.engine.state().ledger.energy.remesh - booked;
    gel.remesh_records.push(RemeshRecord {
        time: gel.engine.now(),
        attempt: 1,
        quality,
        mass: 0.0,
        momentum: 0.0,
        kinetic,
        energy,
        elements,
        unchanged,
        edits: counts,
        seconds: begun.elapsed().as_secs_f64(),
    });
    Ok(())
}
