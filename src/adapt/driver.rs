//! Remeshing driver: replaces a distorted mesh, and continues the run on the new one.

use super::RestoreError;
use super::candidate::{
    self, MeshGenerator, MeshProperties, OldMeshData, RemeshAttempt, RemeshInput, RemeshRefusal, section_symmetry,
};
use super::gel_definition::{GelDefinition, RemeshSizes};
use super::history::inherited;
use super::model::GelModel;
use super::observe::MeshFrame;
use super::preview::{FailedRemesh, RemeshPreview, RemeshRecord};
use super::sensors::locate_sensors;
use super::source_mesh::{SourceMesh, TargetMesh};
use crate::fem::{HistoryVariables, Potential, Simplices};
use crate::integrator::{BalanceTotals, StepError, UnusableStep};
use crate::math::Vector;
use crate::mesh::{ElementId, ElementPatches, Mesh, face_neighbours};
use crate::remesh::{self, DeformedMesh, ElementNeighbours, UnchangedElement};
use crate::state::{DynamicState, MeshInstance};
use std::sync::Arc;
use std::time::Instant;

/// Gel whose mesh can be replaced.
pub(super) trait RemeshDriver {
    /// Continues with a better mesh, or with the old one where no candidate is accepted.
    ///
    /// # Errors
    /// [`StepError`] if not even the old mesh can be stepped.
    fn remesh(&mut self) -> Result<(), StepError>;

    /// Preview of a remeshing now, in the plane and where the scene has remeshing; `frame` is the current mesh.
    fn preview_now(&self, frame: MeshFrame) -> Option<RemeshPreview>;
}

impl RemeshDriver for GelModel<2> {
    fn remesh(&mut self) -> Result<(), StepError> {
        self.remesh_with(candidate::mesh_in_plane)
    }

    fn preview_now(&self, frame: MeshFrame) -> Option<RemeshPreview> {
        Some(self.build_preview(frame, self.definition.remesh.as_ref()?))
    }
}

impl RemeshDriver for GelModel<3> {
    fn remesh(&mut self) -> Result<(), StepError> {
        self.remesh_with(candidate::mesh_in_space)
    }

    fn preview_now(&self, _: MeshFrame) -> Option<RemeshPreview> {
        None
    }
}

/// Thickness, as a fraction of the least edge, below which gel is eroded when every new mesh is refused, regardless
/// of the scene. Opposite walls may pinch gel to no thickness (1e-10 m has occurred), and remeshing does not thicken
/// gel.
const PINCH_FRACTION: f64 = 0.01;
/// Greatest fraction of the gel that one such erosion may remove, detached parts included; heavier parts stay.
pub(super) const MAX_ERODED_FRACTION: f64 = 0.01;

/// Greatest number of erosions at one time in search of an acceptable mesh. Each removes the elements for which the
/// last mesh was refused, or which could not be stepped.
pub(super) const MAX_EROSIONS: usize = 32;

/// Ratio of the energy to the energy provided, above which a run has diverged.
const RUNAWAY_RATIO: f64 = 10.0;

/// Failed replacement of a mesh.
struct FailedReplacement {
    /// Reasons why each candidate was refused.
    reasons: Vec<RemeshRefusal>,
    /// Data of the old mesh.
    data: OldMeshData,
}

impl<const D: usize> GelModel<D> {
    fn remesh_with(&mut self, generator: MeshGenerator<D>) -> Result<(), StepError> {
        let Some(sizes) = self.definition.remesh.clone() else { return Ok(()) };
        let begun = Instant::now();
        if self.engine.state().birth.is_none() {
            self.first_mesh = Some(self.current_mesh());
        }
        if let Some(diverged) = self.check_divergence() {
            return Err(diverged);
        }
        // A mesh that fails at once would be followed by one that fails for the same elements.
        if let Some(failure) = self.engine.early_failure().cloned()
            && !self.erode_on_failure(&[])
        {
            return Err(failure);
        }
        // Thin sheets stay if the rest could not be stepped without them.
        if let Some(below) = sizes.rules.erosion_thickness {
            self.erode_thin_gel(below, 1.0);
        }
        let mut outcome = self.replace_mesh(generator, &sizes, begun);
        if outcome.is_err() && self.erode_thin_gel(PINCH_FRACTION * sizes.least, MAX_ERODED_FRACTION) {
            outcome = self.replace_mesh(generator, &sizes, begun);
        }
        for _ in 0..MAX_EROSIONS {
            match &outcome {
                Err(failed) if self.erode_on_failure(&failed.reasons) => {
                    outcome = self.replace_mesh(generator, &sizes, begun);
                }
                _ => break,
            }
        }
        let Err(FailedReplacement { reasons, data }) = outcome else { return Ok(()) };
        let time = self.engine.now();
        self.failed_remeshes.push(FailedRemesh { time, why: reasons });
        // The failure of the gel after erosion: failed elements may have been eroded.
        if let Some(failure) = self.engine.failure() {
            return Err(failure.clone());
        }
        self.keep_mesh(&self.current_mesh(), data).map_err(|UnusableStep { step, .. }| StepError::Worn { time, step })
    }

    /// Error of a run whose energy far exceeds the initial energy and the work done on it. Without this check a
    /// diverging run refuses new meshes at length: a ball of 23 m/s once reached 1e223 m.
    fn check_divergence(&self) -> Option<StepError> {
        let time = self.engine.now();
        let BalanceTotals { energies, ledger, initial_energy, .. } = self.engine.totals(time);
        let provided = ledger.energy.provided(initial_energy);
        let part = energies.discrete() / provided;
        (provided > self.definition.energy_round_off(self.gel_mass()) && part > RUNAWAY_RATIO)
            .then_some(StepError::Diverged { time, part })
    }

    /// Continues with a better mesh of the current gel; `begun` is when the remeshing began.
    ///
    /// # Errors
    /// [`FailedReplacement`] if every candidate was refused.
    fn replace_mesh(
        &mut self,
        generator: MeshGenerator<D>,
        sizes: &RemeshSizes,
        begun: Instant,
    ) -> Result<(), FailedReplacement> {
        let old = self.current_mesh();
        let position = self.engine.state().position.clone();
        let moved = DeformedMesh { mesh: &old.mesh, position: &position };
        // The mesh that the run continues on sets it again.
        let adjacency = self.adjacency.take();
        let data = self.old_mesh_data(&moved, adjacency);
        let size = self.target_sizes(&moved, sizes, &data.adjacency);
        let mut reasons = vec![];
        let attempts = match D {
            3 if self.is_viscoplastic() => RemeshAttempt::VISCOPLASTIC,
            3 => RemeshAttempt::ELASTIC,
            _ => RemeshAttempt::of(sizes.rules.method, self.is_viscoplastic()),
        };
        for (attempt, number) in attempts.into_iter().zip(1..) {
            let input = RemeshInput { old: &old, moved: &moved, data: &data, size: &size };
            let candidate = match self.generate_candidate(&input, generator, attempt) {
                Ok(candidate) => candidate,
                Err(why) => {
                    reasons.push(why);
                    continue;
                }
            };
            let record = RemeshRecord::of(&candidate, self.engine.now(), number);
            let booked = self.engine.state().ledger.energy.remesh;
            let new_elements = candidate.new_elements_with_masses();
            if let Err(why) =
                self.install_mesh(candidate.birth, candidate.memory, candidate.velocity, candidate.properties)
            {
                reasons.push(RemeshRefusal::Steps(why));
                continue;
            }
            self.engine.count_remesh();
            if self.is_viscoplastic() {
                self.engine.return_energy(&new_elements, booked - self.engine.state().ledger.energy.remesh);
            }
            let energy = self.engine.state().ledger.energy.remesh - booked;
            self.remesh_records.push(RemeshRecord { energy, seconds: begun.elapsed().as_secs_f64(), ..record });
            return Ok(());
        }
        Err(FailedReplacement { reasons, data })
    }

    /// Continues with the old mesh and new patches, as after a remeshing that leaves every element unchanged.
    fn keep_mesh(&mut self, old: &MeshInstance<D>, data: OldMeshData) -> Result<(), UnusableStep> {
        let OldMeshData { adjacency, qualities } = data;
        let state = self.engine.state();
        let mut birth = MeshInstance { tick: self.engine.last_tick(), position: state.position.clone(), ..old.clone() };
        let patches = self.definition.build_patches(&birth.mesh, &birth.position, &adjacency);
        let source = SourceMesh::new((&self.engine.gel().potential, old, &state.memory), &state.position);
        let Mesh { rest, elements, .. } = &birth.mesh;
        let same: Vec<_> =
            (0..elements.len() as u32).map(|element| Some(UnchangedElement::in_order(ElementId(element)))).collect();
        let target = TargetMesh { position: &birth.position, rest, elements, same: &same, sources: &[], is_kept: true };
        let (velocity, mut memory) = (state.velocity.clone(), state.memory.clone());
        if let Some((references, recalled)) = inherited(&source, &state.position, (&target, &patches)) {
            (birth.references, memory) = (references, recalled);
        }
        self.install_mesh(birth, memory, velocity, MeshProperties { patches, qualities, adjacency })
    }

    /// Continues the run on a mesh with these properties.
    pub(super) fn install_mesh(
        &mut self,
        birth: MeshInstance<D>,
        memory: Vec<HistoryVariables<D>>,
        velocity: Vec<Vector<D>>,
        properties: MeshProperties,
    ) -> Result<(), UnusableStep> {
        let MeshProperties { patches, qualities, adjacency } = properties;
        let gel = self.gel_on_mesh(&birth, patches);
        let nodes = birth.position.iter().copied().zip(velocity).collect();
        self.engine = self.engine.continue_on_mesh((gel, Some(memory)), nodes, Some(birth))?;
        self.adopt_mesh(&self.current_mesh(), &qualities, adjacency);
        Ok(())
    }
}

impl<const D: usize> GelModel<D> {
    /// Derived properties of a mesh of this gel: patches, element qualities and neighbours. `position` is where the
    /// nodes of the new mesh are.
    pub fn mesh_properties(
        &self,
        mesh: &Mesh<D>,
        position: &[Vector<D>],
        adjacency: ElementNeighbours,
    ) -> MeshProperties {
        let qualities = self.definition.element_qualities(&mesh.elements, position);
        MeshProperties { patches: self.definition.build_patches(mesh, position, &adjacency), qualities, adjacency }
    }

    /// Gel of the integrator on this mesh.
    pub fn gel_on_mesh(
        &self,
        birth: &MeshInstance<D>,
        patches: ElementPatches,
    ) -> crate::integrator::DiscreteGel<D, Simplices<D>> {
        let simplices = self.definition.build_simplices(&birth.mesh, patches).with_references(&birth.references);
        self.definition.build_gel(simplices, &birth.mesh, &birth.position, birth.mass.clone())
    }

    /// Continues from a state of this run.
    ///
    /// # Errors
    /// [`RestoreError`] if the state is not one of this run; nothing is changed then.
    pub fn restore_state(&mut self, state: &DynamicState<D>) -> Result<(), RestoreError> {
        let inconsistent = |what| RestoreError::Inconsistent { what };
        let own = &self.engine.state().birth;
        let is_current = match (own, &state.birth) {
            (Some(own), Some(its)) => Arc::ptr_eq(own, its) || own == its,
            (own, its) => own.is_none() && its.is_none(),
        };
        if is_current {
            return self.engine.restore(state).map_err(inconsistent);
        }
        if self.definition.remesh.is_none() {
            return Err(inconsistent("its mesh was remeshed, but this scene has no remeshing"));
        }
        let first_mesh = if own.is_none() { Some(self.current_mesh()) } else { self.first_mesh.clone() };
        let birth = state.birth.as_ref().or(first_mesh.as_ref()).map(Arc::clone).ok_or(RestoreError::Foreign)?;
        if !self.definition.has_positive_radii(&birth) {
            return Err(inconsistent("an element of its mesh is on the axis or beyond it"));
        }
        let adjacency = face_neighbours::<D>(&birth.mesh.elements);
        let MeshProperties { patches, qualities, adjacency } =
            self.mesh_properties(&birth.mesh, &birth.position, adjacency);
        let other = self.engine.engine_on_mesh(self.gel_on_mesh(&birth, patches), &birth.position, state.birth.clone());
        let mut other = other.map_err(|UnusableStep { .. }| inconsistent("its mesh has no finite stable step"))?;
        other.restore(state).map_err(inconsistent)?;
        self.engine = other.with_pool(self.engine.take_pool());
        self.first_mesh = first_mesh;
        self.adopt_mesh(&birth, &qualities, adjacency);
        Ok(())
    }

    /// Takes over the data that is kept beside the engine; `qualities` are those of the elements when the mesh was new.
    pub fn adopt_mesh(&mut self, birth: &MeshInstance<D>, qualities: &[f64], adjacency: ElementNeighbours) {
        self.adjacency = Some(adjacency);
        self.facets.clone_from(&birth.mesh.facets);
        self.marks.clone_from(&birth.mesh.marks);
        self.sensor_locations = locate_sensors(&self.engine, &self.definition);
        self.engine.set_distortion_limits(self.definition.distortion_limits(
            &self.engine.gel().potential,
            &birth.position,
            qualities,
        ));
    }

    /// Mesh of the engine as it was when it was new.
    pub fn current_mesh(&self) -> Arc<MeshInstance<D>> {
        if let Some(birth) = &self.engine.state().birth {
            return Arc::clone(birth);
        }
        let gel = self.engine.gel();
        let rest = gel.potential.rest().to_vec();
        let elements = gel.potential.elements().to_vec();
        let held = (0..rest.len()).map(|node| gel.held(node)).collect();
        let mesh = Mesh { rest, elements, facets: self.facets.clone(), held, marks: self.marks.clone() };
        let corner_mass = rest_corner_masses(&gel.potential, &self.definition);
        Arc::new(MeshInstance {
            tick: 0,
            position: mesh.rest.clone(),
            mass: gel.mass.clone(),
            corner_mass,
            references: vec![],
            steps: vec![],
            mesh,
        })
    }
}

/// Masses of the corners of the elements at rest, kg.
fn rest_corner_masses<const D: usize>(potential: &Simplices<D>, definition: &GelDefinition) -> Vec<[f64; 4]> {
    let mass = |element| definition.density * potential.volume(ElementId(element));
    let masses: Vec<f64> = (0..potential.len() as u32).map(mass).collect();
    remesh::corner_masses(potential.rest(), potential.elements(), &masses, section_symmetry(definition))
}
