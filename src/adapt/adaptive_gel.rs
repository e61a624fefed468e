//! Gel whose mesh can be replaced while it moves.

use super::gel_definition::GelDefinition;
use super::layer_parts::masses;
use super::record::RemeshRecord;
use super::refusal::FailedRemesh;
use super::settings::AdaptSettings;
use crate::constitutive::ElasticAverage;
use crate::contact::{BodyState, RigidBody};
use crate::fem::{HistoryVariables, Potential, Simplices};
use crate::integrator::{DiscreteGel, Engine, UnusableStep};
use crate::math::{Vector, ordered_sum};
use crate::mesh::{ElementId, Facet, Mesh};
use crate::remesh::{self, ElementNeighbours, MeshQuality};
use crate::state::MeshInstance;
use std::sync::Arc;

/// Gel whose mesh can be replaced: its engine, and the data beside it that remeshing needs.
pub(crate) struct AdaptiveGel<const D: usize> {
    pub engine: Engine<D, Simplices<D>>,
    /// Mesh-independent definition of the gel.
    pub definition: GelDefinition,
    /// Boundary facets of the mesh.
    pub facets: Vec<Facet>,
    /// Load markers of the facets; empty without loads.
    marks: Vec<u8>,
    /// Neighbours of the elements where the scene has remeshing; `None` during a remeshing, or after one has failed.
    pub(super) adjacency: Option<ElementNeighbours>,
    /// Mesh of the start, if the engine has another one.
    pub(super) first_mesh: Option<Arc<MeshInstance<D>>>,
    /// Remeshings since the gel was built.
    pub remesh_records: Vec<RemeshRecord>,
    /// Failed remeshings since the gel was built.
    pub failed_remeshes: Vec<FailedRemesh>,
}

/// Stable step, as a fraction of the least one of the first mesh, below which an element is remade, over the least quality
/// of the settings: an eighth at 0.3.
const LEAST_STEP: f64 = 0.125 / 0.3;
/// Edge of a facet at a body, in usual lengths, above which the mesh ends.
const LONG_FACET: f64 = 2.0;
/// Edge of a facet at a body, in usual lengths, above which the mesh of a gel that flows ends.
const FLOWING_FACET: f64 = 1.5;
/// Fraction of the step of an element on a new mesh below which the mesh ends, where that step is short already.
const AGED_STEP: f64 = 0.6;

/// Derived properties of a mesh and its nodal positions, computed once.
#[derive(Debug, Clone)]
pub(super) struct MeshProperties {
    /// Quality of each element, infinite where it is too good to matter.
    pub qualities: Vec<f64>,
    /// Neighbours of each element.
    pub adjacency: ElementNeighbours,
}

impl MeshProperties {
    /// Quality of a mesh whose area or volume has not changed.
    pub(super) fn quality(&self) -> MeshQuality {
        MeshQuality { least: self.qualities.iter().copied().fold(1.0, f64::min), change: 0.0, parts: 1, loops: 1 }
    }
}

impl<const D: usize> AdaptiveGel<D> {
    /// Gel with an engine on its first mesh; `adjacency` holds the neighbours of the elements.
    pub fn new(
        engine: Engine<D, Simplices<D>>,
        definition: GelDefinition,
        mesh: Mesh<D>,
        adjacency: ElementNeighbours,
    ) -> Self {
        let qualities = definition.element_qualities(&mesh.elements, &mesh.rest);
        let adjacency = definition.remesh.as_ref().map(|_| adjacency);
        let Mesh { facets, marks, rest, .. } = mesh;
        let (first_mesh, remesh_records, failed_remeshes) = (None, vec![], vec![]);
        let steps = definition.steps_when_new(&engine);
        let mut gel =
            Self { engine, definition, facets, marks, adjacency, first_mesh, remesh_records, failed_remeshes };
        gel.set_distortion_limits(&rest, &qualities, &steps);
        gel
    }

    /// Mass of the gel, kg.
    pub fn mass(&self) -> f64 {
        let mass = &self.engine.gel().mass;
        ordered_sum(mass.len(), 0.0, |i| mass[i])
    }

    /// Masses of the materials of the gel, kg, front to back; of a gel of one material that of the gel.
    pub fn material_masses(&self) -> Vec<f64> {
        let Some(stack) = &self.definition.layers else { return vec![self.mass()] };
        let mesh = self.current_mesh();
        let elements = mesh.corner_mass.iter().map(|own| own[..=D].iter().sum::<f64>()).zip(&mesh.parts);
        masses(elements)[..stack.n_materials()].to_vec()
    }

    /// Returns true for a two-network gel.
    pub(super) fn has_networks(&self) -> bool {
        self.engine.gel().potential.remembers()
    }

    /// Returns true if the rest positions of the nodes tell nothing: those of a two-network gel, and after an immersed mesh.
    pub(super) fn flows(&self) -> bool {
        self.has_networks() || !self.engine.gel().potential.has_rest_map()
    }

    /// Rule by which new elements of a two-network gel get their elastic state.
    pub(super) fn elastic_average(&self) -> ElasticAverage {
        self.definition.remesh.map(|settings| settings.average).unwrap_or_default()
    }

    /// Active bodies in their current states.
    pub(super) fn active_bodies(&self) -> Vec<(&RigidBody, BodyState)> {
        let time = self.engine.now();
        let all = self.engine.bodies().iter().zip(&self.engine.state().bodies);
        all.map(|(body, last)| (body, last.at(body, time))).filter(|(_, at)| at.active).collect()
    }

    /// Mesh of the engine as it was when it was new.
    pub(super) fn current_mesh(&self) -> Arc<MeshInstance<D>> {
        if let Some(birth) = &self.engine.state().birth {
            return Arc::clone(birth);
        }
        let gel = self.engine.gel();
        let rest = gel.potential.rest().to_vec();
        let elements = gel.potential.elements().to_vec();
        let held = (0..rest.len()).map(|node| gel.held(node)).collect();
        let mesh = Mesh { rest, elements, facets: self.facets.clone(), held, marks: self.marks.clone() };
        let corner_mass = self.rest_corner_masses();
        Arc::new(MeshInstance {
            tick: 0,
            position: mesh.rest.clone(),
            mass: gel.mass.clone(),
            corner_mass,
            references: vec![],
            patches: gel.potential.patches().clone(),
            parts: gel.potential.material_parts().to_vec(),
            steps: vec![],
            mesh,
        })
    }

    /// Masses of the corners of the elements at rest, kg.
    fn rest_corner_masses(&self) -> Vec<[f64; 4]> {
        let potential = &self.engine.gel().potential;
        let density = |element| self.definition.density * potential.ratios(element).density;
        let mass = |element| density(element) * potential.volume(element);
        let masses: Vec<f64> = (0..potential.len() as u32).map(ElementId).map(mass).collect();
        remesh::corner_masses(potential.rest(), potential.elements(), &masses, self.definition.body_symmetry())
    }

    /// Gel of the integrator on this mesh.
    pub(super) fn gel_on_mesh(&self, birth: &MeshInstance<D>) -> DiscreteGel<D, Simplices<D>> {
        let simplices = self.definition.build_simplices(&birth.mesh, birth.patches.clone(), birth.parts.clone());
        let simplices = simplices.with_references(&birth.references);
        self.definition.build_gel(simplices, &birth.mesh, &birth.position, birth.mass.clone())
    }

    /// Continues the run on a mesh with these properties.
    pub(super) fn install_mesh(
        &mut self,
        birth: MeshInstance<D>,
        memory: Vec<HistoryVariables<D>>,
        velocity: Vec<Vector<D>>,
        properties: MeshProperties,
    ) -> Result<(), UnusableStep> {
        let engine = self.engine_on_mesh(birth, memory, velocity)?;
        self.install_engine(engine, properties);
        Ok(())
    }

    /// Creates the engine that would continue the run on a mesh.
    pub(super) fn engine_on_mesh(
        &self,
        birth: MeshInstance<D>,
        memory: Vec<HistoryVariables<D>>,
        velocity: Vec<Vector<D>>,
    ) -> Result<Engine<D, Simplices<D>>, UnusableStep> {
        let gel = self.gel_on_mesh(&birth);
        let nodes = birth.position.iter().copied().zip(velocity).collect();
        self.engine.continue_on_mesh(gel, Some(memory), nodes, Some(birth))
    }

    /// Continues the run with an engine on another mesh of these properties.
    pub(super) fn install_engine(&mut self, engine: Engine<D, Simplices<D>>, properties: MeshProperties) {
        let MeshProperties { qualities, adjacency } = properties;
        self.engine = engine.with_pool(self.engine.take_pool());
        let steps = self.definition.steps_when_new(&self.engine);
        self.adopt_mesh(&self.current_mesh(), &qualities, &steps, adjacency);
    }

    /// Takes over the data that is kept beside the engine; `qualities` and `steps`, s, are those of the elements when the
    /// mesh was new.
    pub(super) fn adopt_mesh(
        &mut self,
        birth: &MeshInstance<D>,
        qualities: &[f64],
        steps: &[f64],
        adjacency: ElementNeighbours,
    ) {
        self.adjacency = Some(adjacency);
        self.facets.clone_from(&birth.mesh.facets);
        self.marks.clone_from(&birth.mesh.marks);
        self.set_distortion_limits(&birth.position, qualities, steps);
    }

    /// Limits the distortion of the current mesh by its nodal positions, element qualities and stable steps, s, when new.
    fn set_distortion_limits(&mut self, position: &[Vector<D>], qualities: &[f64], steps: &[f64]) {
        let mut limits = self.definition.distortion_limits(&self.engine.gel().potential, position, qualities);
        let settings = self.definition.remesh.filter(|_| self.definition.is_edited());
        if let (Some(limits), Some(settings)) = (limits.as_mut(), settings) {
            // Need asks for a remeshing, not shape, but where gel flows.
            if !self.flows() {
                limits.quality.fill(0.0);
            }
            limits.facet_edge = if self.flows() { FLOWING_FACET } else { LONG_FACET } * settings.usual;
            let least = self.least_step(&settings);
            limits.step = steps.iter().map(|step| least.min(AGED_STEP * step)).collect();
            limits.greatest_step = limits.step.iter().copied().fold(0.0, f64::max);
        }
        self.engine.set_distortion_limits(limits);
    }

    /// Stable step below which an element is remade, s.
    pub(super) fn least_step(&self, settings: &AdaptSettings) -> f64 {
        LEAST_STEP * settings.quality * self.engine.grid().first_step()
    }
}
