//! Remeshing by local operations that keep the rest map, for gels without history variables.

use super::adaptive_gel::{AdaptiveGel, MeshProperties};
use super::candidate::{OldMeshData, clear_of_bodies};
use super::record::RemeshRecord;
use super::settings::AdaptSettings;
use crate::fem::{Potential, ReferenceShape, SingleElementLaw, SingleElementResponse};
use crate::integrator::UnusableStep;
use crate::math::{Vector, embed};
use crate::mesh::{ElementId, Mesh, NodeId, Simplex, boundary_from_neighbours};
use crate::remesh::operations::{
    EditCounts, EditLimits, EditScene, EditableMesh, EditedMesh, ElementModel, ElementState, improve,
};
use crate::remesh::{self, MeshCorrespondence};
use crate::state::MeshInstance;
use std::time::Instant;

/// Frequency, as a fraction of the one that ends a mesh, from which elements are remade with the others: elements that
/// would end the next mesh soon. Of 16 m/s on cells of 1.25 mm it leaves half of the remeshings.
const ANTICIPATION: f64 = 0.7;
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

/// Elements of a gel without history variables.
struct ElasticElements {
    law: SingleElementLaw,
    /// Density, kg/m³.
    density: f64,
    /// Frequency above which an element is remade, 1/s.
    frequency: f64,
    /// J below which an element is remade.
    jacobian: f64,
}

/// Corners of a simplex.
const CORNERS: [NodeId; 4] = [NodeId(0), NodeId(1), NodeId(2), NodeId(3)];

impl<const D: usize> ElementModel<D> for ElasticElements {
    fn state(&self, rest: &[Vector<D>; 4], now: &[Vector<D>; 4]) -> ElementState {
        let [rest, now] = [rest, now].map(|x| ReferenceShape::of(x, &CORNERS));
        let SingleElementResponse { volume, energy, stiffness, jacobian } = self.law.evaluate(&rest, &now, &[]);
        let frequency = ((D + 1) as f64 * stiffness / (self.density * volume)).sqrt() / self.frequency;
        let is_positive = jacobian > 0.0 && frequency.is_finite();
        let hindrance = if is_positive { frequency.max(self.jacobian / jacobian) } else { f64::INFINITY };
        ElementState { volume, jacobian, energy, hindrance }
    }

    fn common_energy(&self, jacobian: f64) -> f64 {
        self.law.common_energy(jacobian)
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
    let mut mesh = EditableMesh::new(
        (&old.mesh, &gel.engine.gel().star, potential.patches()),
        (&state.position, &state.velocity),
        (&old.mass, &old.corner_mass),
        (steps, compatible),
        gel.definition.body_symmetry(),
    );
    let law = SingleElementLaw {
        material: gel.definition.material,
        section: gel.definition.section,
        has_patches: gel.definition.has_patches,
    };
    let frequency = ANTICIPATION * gel.engine.frequency_of_step(gel.least_step(settings));
    let jacobian = settings.min_volume_ratio;
    let model = ElasticElements { law, density: gel.definition.density, frequency, jacobian };
    let bodies = gel.active_bodies();
    let gap =
        |x: &Vector<D>| bodies.iter().map(|(body, at)| body.gap(at, &embed(x)).distance).fold(f64::INFINITY, f64::min);
    let scene = EditScene {
        gap: &gap,
        cleared: &|x| clear_of_bodies(&bodies, x),
        size: &|x| (settings.usual + settings.growth * gap(x).max(0.0)).min(settings.longest),
    };
    let now = gel.engine.now();
    let totals = gel.engine.totals(now);
    let limits = EditLimits { energy: totals.ledger.energy.provided(totals.initial_energy), usual: settings.usual };
    let mut bad = gel.engine.elements_above(frequency, |element| old.corner_mass[element][..=D].iter().sum());
    let is_compressed = |(element, nodes): &(ElementId, &Simplex)| {
        potential.measure(&nodes.map(|node| state.position[node.index()])) < jacobian * potential.rest_measure(*element)
    };
    bad.extend((0..).map(ElementId).zip(potential.elements()).filter(is_compressed).map(|(element, _)| element));
    bad.sort_unstable();
    bad.dedup();
    let counts = improve(&mut mesh, &model, &scene, &limits, bad);
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
    let EditedMesh { rest, position, velocity, held, mass, elements, corner_mass, patches, step: steps } = edited;
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

/// Continues the run on the mesh after local operations; `begun` is when the remeshing began. The energy that the
/// operations took returns to the motion of the elements that they made.
///
/// # Errors
/// [`UnusableStep`] if the mesh could not be stepped.
pub(super) fn install_edited<const D: usize>(
    gel: &mut AdaptiveGel<D>,
    old: &MeshInstance<D>,
    edited: EditedGel<D>,
    data: &OldMeshData,
    begun: Instant,
) -> Result<(), UnusableStep> {
    let booked = gel.engine.state().ledger.energy.remesh;
    let (new_elements, counts, unchanged) = (edited.new_elements(), edited.counts, edited.unchanged());
    let before = gel.kinetic_energy();
    let (birth, properties, velocity) = instance_of(gel, old, edited, data);
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
