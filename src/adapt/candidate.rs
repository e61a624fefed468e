//! Candidate mesh for remeshing: target sizes, mesh generation, acceptance and transfer of fields and state.

use super::gel_definition::{GelDefinition, RemeshSizes};
use super::history;
use super::model::GelModel;
use super::source_mesh::{SourceMesh, TargetMesh};
use crate::contact::{BodyState, RigidBody};
use crate::fem::{HistoryVariables, Potential, Section};
use crate::geometry::SharpEnd;
use crate::integrator::UnusableStep;
use crate::math::{Vector, Vector3, embed, restrict};
use crate::mesh::{ElementId, ElementPatches, Mesh, boundary_from_neighbours, face_neighbours};
use crate::remesh::{
    self, AcceptanceLimits, BodySymmetry, ConservationDefects, DeformedMesh, ElementNeighbours, MeshCorrespondence,
    MeshQuality, MeshRejected, NodalFields, ProposedMesh, RemeshError, RemeshRules, SizeRange, TransferredFields,
};
use crate::scene::RemeshMethod;
use crate::state::MeshInstance;
use std::f64::consts::FRAC_PI_2;

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
}

/// Derived properties of a mesh and its nodal positions, computed once.
#[derive(Debug, Clone)]
pub(super) struct MeshProperties {
    pub patches: ElementPatches,
    /// Quality of each element, infinite where it is too good to matter.
    pub qualities: Vec<f64>,
    /// Neighbours of each element.
    pub adjacency: ElementNeighbours,
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
pub(super) struct RemeshInput<'a, const D: usize> {
    pub old: &'a MeshInstance<D>,
    /// Mesh with its current nodal positions.
    pub moved: &'a DeformedMesh<'a, D>,
    pub data: &'a OldMeshData,
    /// Target sizes of the nodes, m.
    pub size: &'a [f64],
}

/// Reason why a candidate mesh was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RemeshRefusal {
    /// Mesh generation failed.
    #[error(transparent)]
    Made(#[from] RemeshError),
    /// Mesh quality is not acceptable.
    #[error(transparent)]
    Judged(#[from] MeshRejected),
    /// Nodes of the new mesh have no mass.
    #[error("{nodes} nodes of the new mesh have no mass: no old element overlaps their elements")]
    Massless {
        /// Number of massless nodes.
        nodes: usize,
    },
    /// Total mass is not conserved.
    #[error("the mass of the new mesh is {after:e} kg, expected {before:e} kg")]
    Mass {
        /// Mass of the old mesh, kg.
        before: f64,
        /// Mass of the new mesh, kg.
        after: f64,
    },
    /// Kinetic energy has increased: nodes of hardly any mass have excessive velocities.
    #[error(
        "the kinetic energy on the new mesh is {after:.3e} J, on the old mesh {before:.3e} J: a new node has almost \
         no mass"
    )]
    Gains {
        /// Kinetic energy of the old mesh, J.
        before: f64,
        /// Kinetic energy of the new mesh, J.
        after: f64,
    },
    /// Element without a valid rest shape.
    #[error("an element of the new mesh has no reference shape: the old elements under it are inverted")]
    Restless,
    /// Element without a finite stable step.
    #[error("in the new mesh {0}")]
    Steps(UnusableStep),
}

/// Attempt to generate a mesh; a method has several, tried in order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum RemeshAttempt {
    /// Local remeshing.
    ///
    /// A boundary node is removed where the boundary stays within `sag` chords of the chord without it. In space a
    /// node may also slide along the boundary, off it by at most `slide` target lengths. `rests` is true if the gel
    /// has a surface at rest.
    Retained { sag: f64, slide: f64, rests: bool },
    /// Immersed mesh with target sizes scaled by `size_factor`.
    Immersed { size_factor: f64 },
}

/// Mesh generator of a dimension: returns a proposal and its tolerance for the change of area or volume.
pub(super) type MeshGenerator<const D: usize> = fn(
    RemeshAttempt,
    &DeformedMesh<'_, D>,
    &[f64],
    BodyClearance<'_, D>,
) -> Result<(ProposedMesh<D>, f64), RemeshError>;
/// Function that returns the point nearest to a given one that is in no body.
pub(super) type BodyClearance<'a, const D: usize> = &'a dyn Fn(&Vector<D>) -> Vector<D>;

/// Tolerance for the relative change of area or volume when boundary nodes are removed.
const MEASURE_TOLERANCE: f64 = 1e-5;
/// Tolerance for a viscoplastic gel. The wall of a wide cavity in coarsening cells exceeds
/// [`MEASURE_TOLERANCE`]. At 210 m/s
/// nodes were then no longer removed, came within 0.1 µm of each other on the axis, and cut the step to a thousandth.
const VISCOPLASTIC_MEASURE_TOLERANCE: f64 = 1e-4;
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
/// Quality that a local mesh in the plane must reach if the old mesh did: that of a needle of 10°.
const PLANE_QUALITY: f64 = 0.3;
/// Quality that a local mesh in space must reach if the old mesh did: splitting long edges may leave worse elements.
const SPACE_QUALITY: f64 = 0.2;

impl<const D: usize> CandidateMesh<D> {
    /// Elements that are not elements of the old mesh, and their masses, kg.
    pub fn new_elements_with_masses(&self) -> Vec<(ElementId, f64)> {
        self.new_elements.iter().map(|e| (*e, self.birth.corner_mass[e.index()].iter().sum())).collect()
    }
}

impl RemeshAttempt {
    /// Attempts of a method in the plane; `is_viscoplastic` for a viscoplastic gel.
    pub fn of(method: RemeshMethod, is_viscoplastic: bool) -> [Self; 3] {
        match method {
            RemeshMethod::Local => {
                [0.06, 0.02, 0.0].map(|sag| Self::Retained { sag, slide: 0.0, rests: !is_viscoplastic })
            }
            RemeshMethod::Immersed => [1.0, 0.7, 0.5].map(|size_factor| Self::Immersed { size_factor }),
        }
    }

    /// Attempts in space for an elastic gel: nodes slide along the surface only where no other mesh is accepted.
    pub const ELASTIC: [Self; 3] = [
        Self::Retained { sag: 0.06, slide: 0.0, rests: true },
        Self::Retained { sag: 0.02, slide: 0.05, rests: true },
        Self::Retained { sag: 0.2, slide: 0.1, rests: true },
    ];

    /// Attempts in space for a viscoplastic gel.
    ///
    /// Its surface has no rest shape that tells how flat it was. A cavity in cells of a quarter of the ball's radius
    /// is flat to no more than 0.13 of a cell. Without sliding, an element of the calibration shot inverts after 11
    /// µs.
    pub const VISCOPLASTIC: [Self; 3] = [
        Self::Retained { sag: 0.2, slide: 0.1, rests: false },
        Self::Retained { sag: 0.06, slide: 0.05, rests: false },
        Self::Retained { sag: 0.0, slide: 0.0, rests: false },
    ];

    /// Least quality required of a new mesh, if `old` is that of the old one.
    fn least_quality<const D: usize>(self, old: f64) -> f64 {
        match self {
            Self::Retained { .. } => old.min(if D == 3 { SPACE_QUALITY } else { PLANE_QUALITY }),
            Self::Immersed { .. } => old.min(IMMERSED_QUALITY),
        }
    }
}

/// Generates a mesh in the plane; new boundary points of an immersed mesh lie on the old boundary.
pub(super) fn mesh_in_plane(
    attempt: RemeshAttempt,
    moved: &DeformedMesh<'_, 2>,
    size: &[f64],
    cleared: BodyClearance<'_, 2>,
) -> Result<(ProposedMesh<2>, f64), RemeshError> {
    match attempt {
        RemeshAttempt::Retained { sag, rests, .. } => Ok((
            remesh::propose(moved, size, &RemeshRules { sag, rests, ..RemeshRules::default() }, cleared)?,
            MEASURE_TOLERANCE,
        )),
        RemeshAttempt::Immersed { size_factor } => {
            let size: Vec<f64> = size.iter().map(|size| size_factor * size).collect();
            let steps = remesh::immerse(moved, &size, &RemeshRules::default())?;
            Ok((steps.proposal, MEASURE_TOLERANCE + remesh::rounding(moved, &size)))
        }
    }
}

/// Generates a mesh in space; the immersed method is available in the plane only.
pub(super) fn mesh_in_space(
    attempt: RemeshAttempt,
    moved: &DeformedMesh<'_, 3>,
    size: &[f64],
    cleared: BodyClearance<'_, 3>,
) -> Result<(ProposedMesh<3>, f64), RemeshError> {
    match attempt {
        RemeshAttempt::Retained { sag, slide, rests } => {
            let rules = RemeshRules { sag, slide, rests, ..RemeshRules::default() };
            Ok((remesh::propose_in_space(moved, size, &rules, cleared)?, MEASURE_TOLERANCE))
        }
        RemeshAttempt::Immersed { .. } => Err(RemeshError::PlaneOnly),
    }
}

impl<const D: usize> GelModel<D> {
    /// Target sizes of the nodes: fine where displacement and velocity are curved and near bodies; uniform without
    /// adaptivity.
    pub fn target_sizes(
        &self,
        moved: &DeformedMesh<'_, D>,
        sizes: &RemeshSizes,
        adjacency: &ElementNeighbours,
    ) -> Vec<f64> {
        if !sizes.rules.adaptive {
            return vec![sizes.usual; moved.position.len()];
        }
        let range = SizeRange { least: sizes.least, greatest: sizes.longest };
        // Sizes change by a factor of two at most.
        let angle = sizes.rules.curvature_angle.to_radians();
        let asked = [0.5 * angle, 2.0 * angle].map(|angle| angle.min(FRAC_PI_2));
        let displacement = displacement(moved);
        let bends =
            remesh::curvature_angles_within(moved, &[&displacement, &self.engine.state().velocity], (adjacency, asked));
        let mut size = remesh::sizes_from_curvature(moved, &bends, angle, &range);
        let bodies = self.active_bodies();
        for (size, x) in size.iter_mut().zip(moved.position) {
            let gaps = bodies.iter().map(|(body, at)| body.gap(at, &embed(x)).distance);
            let gap = gaps.fold(f64::INFINITY, f64::min).max(0.0);
            *size = size.min(sizes.usual + sizes.rules.growth * gap);
        }
        let mut size =
            remesh::limit_sheet_sizes(moved, (&self.engine.gel().surface.facets, adjacency), size, sizes.least);
        if let Some(tip) = sizes.rules.tip_size {
            let axial_ends = axial_ends(&bodies);
            for (size, x) in size.iter_mut().zip(moved.position) {
                let near = axial_ends.iter().map(|end| (embed(x) - end).norm()).fold(f64::INFINITY, f64::min);
                *size = size.min(tip + sizes.rules.growth * near);
            }
        }
        remesh::graded(moved, size, sizes.rules.growth)
    }

    /// Active bodies in their current states.
    fn active_bodies(&self) -> Vec<(&RigidBody, BodyState)> {
        let time = self.engine.now();
        let all = self.engine.bodies().iter().zip(&self.engine.state().bodies);
        all.map(|(body, last)| (body, last.at(body, time))).filter(|(_, at)| at.active).collect()
    }

    /// Curvature indicator of displacement and velocity at each element, rad.
    pub fn curvatures(&self, moved: &DeformedMesh<'_, D>) -> Vec<f64> {
        remesh::curvature_angles(moved, &[&displacement(moved), &self.engine.state().velocity])
    }

    /// Data of the current mesh that every attempt needs; the neighbours are computed if they are not known.
    pub fn old_mesh_data(&self, moved: &DeformedMesh<'_, D>, adjacency: Option<ElementNeighbours>) -> OldMeshData {
        let adjacency = adjacency.unwrap_or_else(|| face_neighbours::<D>(&moved.mesh.elements));
        OldMeshData { adjacency, qualities: self.definition.element_qualities(&moved.mesh.elements, moved.position) }
    }

    /// Generates a new mesh and transfers all fields and state to it.
    ///
    /// # Errors
    /// [`RemeshRefusal`] if the mesh is not acceptable.
    pub fn generate_candidate(
        &self,
        input: &RemeshInput<'_, D>,
        generator: MeshGenerator<D>,
        attempt: RemeshAttempt,
    ) -> Result<CandidateMesh<D>, RemeshRefusal> {
        let RemeshInput { old, moved, data, size } = *input;
        let bodies = self.active_bodies();
        let (proposal, measure) = generator(attempt, moved, size, &|x| clear_of_bodies(&bodies, x))?;
        let worst = data.qualities.iter().copied().fold(f64::INFINITY, f64::min);
        let measure = if self.is_viscoplastic() { measure.max(VISCOPLASTIC_MEASURE_TOLERANCE) } else { measure };
        let acceptance = AcceptanceLimits { measure, quality: attempt.least_quality::<D>(worst) };
        let pairing = MeshCorrespondence::of(&old.mesh, &proposal);
        let qualities = pairing
            .carried(&data.qualities, |e| self.definition.element_quality(&proposal.position, &proposal.elements[e]));
        let adjacency = remesh::neighbours_after::<D>(&proposal.elements, &pairing, &data.adjacency);
        let facets = boundary_from_neighbours::<D>(&proposal.elements, &adjacency);
        let known = remesh::KnownQuality { shapes: &qualities, facets: &facets };
        let quality = remesh::check_acceptance_known(moved, &proposal, (&acceptance, &known))?;
        let new = self.transfer_fields(old, moved, &proposal, pairing);
        check_conservation(&new.defects)?;
        let marks = remesh::facet_load_markers(&old.mesh, (&facets, &new.rest), &proposal.origin);
        let (rest, held) = (new.rest.clone(), new.held.clone());
        let mesh = Mesh { rest, elements: proposal.elements.clone(), facets, held, marks };
        let patches = self.definition.build_patches(&mesh, &proposal.position, &adjacency);
        let source = (&self.engine.gel().potential, old, self.engine.state().memory.as_slice());
        let source = SourceMesh::new(source, moved.position);
        let inherited = history::inherited(&source, moved.position, (&TargetMesh::by(&proposal, &new), &patches));
        let (references, memory) = inherited.ok_or(RemeshRefusal::Restless)?;
        let new_elements =
            (0..).map(ElementId).zip(&new.same).filter(|(_, same)| same.is_none()).map(|(e, _)| e).collect();
        let TransferredFields { mass, corner_mass, velocity, defects, .. } = new;
        let tick = self.engine.last_tick();
        let (position, steps) = (proposal.position, vec![]);
        let birth = MeshInstance { tick, mesh, position, mass, corner_mass, references, steps };
        let properties = MeshProperties { patches, qualities, adjacency };
        Ok(CandidateMesh { birth, memory, velocity, quality, defects, properties, new_elements })
    }

    /// Returns true if the gel is viscoplastic.
    pub fn is_viscoplastic(&self) -> bool {
        self.engine.gel().potential.remembers()
    }

    /// Transfers mass and momentum to the new mesh. The transfer is repeated without corners of negative density if a
    /// node becomes massless or light.
    fn transfer_fields(
        &self,
        old: &MeshInstance<D>,
        moved: &DeformedMesh<'_, D>,
        proposal: &ProposedMesh<D>,
        pairing: MeshCorrespondence,
    ) -> TransferredFields<D> {
        let fields = self.nodal_fields(old);
        let new = remesh::transfer_paired(moved, &fields, (proposal, pairing.clone()));
        let is_light = || remesh::least_relative_mass(&proposal.elements, &new) < LIGHT_NODE_SHARE;
        if new.defects.massless == 0 && !is_light() {
            return new;
        }
        remesh::transfer_paired(moved, &NodalFields { is_level: true, ..fields }, (proposal, pairing))
    }

    fn nodal_fields<'a>(&'a self, old: &'a MeshInstance<D>) -> NodalFields<'a, D> {
        NodalFields {
            symmetry: section_symmetry(&self.definition),
            mass: &old.mass,
            corner_mass: &old.corner_mass,
            velocity: &self.engine.state().velocity,
            is_level: false,
        }
    }
}

fn displacement<const D: usize>(moved: &DeformedMesh<'_, D>) -> Vec<Vector<D>> {
    moved.position.iter().zip(&moved.mesh.rest).map(|(x, rest)| x - rest).collect()
}

/// Axial ends and corners of the bodies, m.
fn axial_ends(bodies: &[(&RigidBody, BodyState)]) -> Vec<Vector3> {
    let of = |(body, at): &(&RigidBody, BodyState)| -> Vec<Vector3> {
        let place = |pole: &SharpEnd| at.position + at.orientation.transform_vector(&pole.end);
        body.shape.poles().iter().map(place).collect()
    };
    bodies.iter().flat_map(of).collect()
}

/// Projects a point inside a body onto its surface: contact would have to push a new boundary node out of the body
/// later.
fn clear_of_bodies<const D: usize>(bodies: &[(&RigidBody, BodyState)], x: &Vector<D>) -> Vector<D> {
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

/// Symmetry of a section.
pub(super) fn section_symmetry(definition: &GelDefinition) -> BodySymmetry {
    match definition.section {
        Section::Planar { .. } => BodySymmetry::Planar,
        Section::Axisymmetric => BodySymmetry::Axisymmetric,
        Section::Spatial => BodySymmetry::Spatial,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
