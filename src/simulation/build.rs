//! Builds the engine of a checked scene at time 0.

use super::driver::RemeshDriver;
use super::gel_definition::GelDefinition;
use super::loads;
use super::model::{EraseDimension, ErasedModel, GelModel, is_centre_in_gel, overlap};
use super::sensors::locate_sensors;
use crate::contact::{BodyMotion, BodyState, DomeMotion, FreeDirections, ImpulseLaw, RigidBody};
use crate::fem::Simplices;
use crate::geometry::{ShapeGeometry, SignedDistance};
use crate::integrator::{
    DiscreteGel, Engine, ExitRule, IntegratorSettings, SteppingSchedule, UnusableStep, WorkerPool, node_order,
};
use crate::math::{Tensor3, Vector, Vector3, restrict};
use crate::mesh::{self, BlockSpec, CellSplit, FaceConstraint, HeldFace, Mesh, NodeId, face_neighbours};
use crate::scene::{
    self, CellLattice, ContactLaw, ContactSpec, Dimension, FaceSupport, GelShape, ProjectileSpec, Scene, ScheduleKind,
    body_name,
};
use crate::state::DynamicState;
use nalgebra::{Quaternion, UnitQuaternion};

/// Reason why a checked scene could not be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// Mesh with more cells than a process can hold.
    #[error(
        "mesh.size: the mesh would have about {cells:.2e} cells, more than {limit:.0e}; \
         raise mesh.size or add mesh.grading"
    )]
    TooLarge {
        /// Cells of the mesh.
        cells: f64,
        /// Greatest number of cells.
        limit: f64,
    },
    /// Gel with more edges along an axis than can be numbered.
    #[error("mesh.size: the gel is {edges:.2e} edges long, more than {limit:.0e}; raise mesh.size")]
    TooFine {
        /// Length of the gel over the edge length.
        edges: f64,
        /// Greatest number of edges.
        limit: f64,
    },
    /// Run with more ticks than are exact.
    #[error(
        "scene.end_time: {ticks:.2e} ticks are more than {limit:.0e}, the most that stay exact; \
         shorten the run, coarsen the mesh or raise integrator.cfl"
    )]
    TooLong {
        /// Ticks up to the end time.
        ticks: f64,
        /// Greatest number of exact ticks.
        limit: f64,
    },
    /// Element without a finite stable step.
    #[error(
        "gel: the stable step of an element is {step:e} s; density, moduli and sizes are out of range: bring \
         gel.density, its moduli and mesh.size nearer to those of a gel"
    )]
    NoStep {
        /// Stable step, s.
        step: f64,
    },
    /// Load without a facet to act on.
    #[error(
        "{key}: no facet of the surface of the gel is on that face and, with all its corners, in that box; \
         widen {key}.within"
    )]
    Unloaded {
        /// Key `load[i]`.
        key: String,
    },
    /// Body whose centre is in the gel at the start.
    #[error("{body}.position: at the start the centre of that body is in the gel; move it out")]
    Swallowed {
        /// Body: `projectile` or `fragment[i]`.
        body: String,
    },
    /// Gel and body that overlap at the start.
    #[error("{body}.position: at the start the surface of the gel is {depth:.3e} m inside that body; move it out")]
    Overlap {
        /// Body: `projectile` or `fragment[i]`.
        body: String,
        /// Depth of the deepest node, m.
        depth: f64,
    },
}

/// Greatest number of cells that is built: some 24 million tetrahedra in 10 GB.
pub(super) const MOST_CELLS: f64 = 2e6;
/// Greatest number of cells along an axis if all had the least size.
const MOST_PLANES: f64 = 1e5;
/// Greatest number of ticks: a tick times q ≤ 31 stays below 2⁵³ (numerics A3).
pub(super) const MOST_TICKS: f64 = 2.8e14;

/// Builds the engine of a scene; `prescribed` if the importer gives the motion of the bodies.
pub(super) fn build(scene: &Scene, prescribed: bool, threads: usize) -> Result<Box<dyn ErasedModel>, BuildError> {
    check_planes(scene)?;
    match scene.scene.dimension {
        Dimension::Planar => assemble(scene, plane_mesh(scene)?, prescribed, threads),
        Dimension::Axisymmetric => assemble(scene, section_mesh(scene)?, prescribed, threads),
        Dimension::Spatial => assemble(scene, space_mesh(scene)?, prescribed, threads),
    }
}

/// Refuses more planes along an axis than can be numbered.
pub(super) fn check_planes(scene: &Scene) -> Result<(), BuildError> {
    let planes = longest_dimension(&scene.gel.shape) / scene.mesh.size;
    if planes > MOST_PLANES {
        return Err(BuildError::TooFine { edges: planes, limit: MOST_PLANES });
    }
    Ok(())
}

fn longest_dimension(shape: &GelShape) -> f64 {
    match shape {
        GelShape::Block { size } => size.iter().copied().fold(0.0, f64::max),
        GelShape::Cylinder { radius, height, .. } => height.max(2.0 * radius),
        GelShape::Shell { outer, .. } => *outer,
        GelShape::LBeam { leg, width, .. } => leg.max(width.unwrap_or(0.0)),
    }
}

fn assemble<const D: usize>(
    scene: &Scene,
    mesh: Mesh<D>,
    prescribed: bool,
    threads: usize,
) -> Result<Box<dyn ErasedModel>, BuildError>
where
    DynamicState<D>: EraseDimension,
    GelModel<D>: RemeshDriver,
{
    let definition = GelDefinition::of(scene);
    let mesh = Mesh { marks: loads::load_markers(scene, &mesh)?, ..mesh };
    let adjacency = if definition.needs_adjacency() { face_neighbours::<D>(&mesh.elements) } else { vec![] };
    let patches = definition.build_patches(&mesh, &mesh.rest, &adjacency);
    let gel_of = |mesh: &Mesh<D>| {
        let simplices = definition.build_simplices(mesh, patches.clone());
        let mass = simplices.lumped_masses(mesh, definition.density);
        definition.build_gel(simplices, mesh, &mesh.rest, mass)
    };
    let rules = integration_rules(scene);
    let (mesh, gel) = renumber_nodes(mesh, &rules, gel_of);
    let velocity = restrict::<D>(&Vector3::from(scene.gel.velocity));
    let moving = |held: &[bool; D]| Vector::<D>::from_fn(|i, _| if held[i] { 0.0 } else { velocity[i] });
    let nodes = mesh.rest.iter().zip(&mesh.held).map(|(x, held)| (*x, moving(held))).collect();
    let bodies: Vec<_> = (0..scene.n_bodies()).map(|i| build_body(scene, i, prescribed)).collect();
    for (i, (body, state)) in bodies.iter().enumerate() {
        let position = |node: NodeId| crate::math::embed(&mesh.rest[node.index()]);
        if let Some(depth) = overlap(&gel, body, state, position, |_| 0.0).filter(|_| state.active) {
            return Err(BuildError::Overlap { body: body_name(i), depth });
        }
        if state.active && is_centre_in_gel(&mesh.rest, &mesh.elements, body, state) {
            return Err(BuildError::Swallowed { body: body_name(i) });
        }
    }
    let engine = Engine::try_new(gel, bodies, rules, nodes);
    let mut engine =
        engine.map_err(|UnusableStep { step, .. }| BuildError::NoStep { step })?.with_pool(WorkerPool::new(threads));
    let ticks = engine.grid().ticks(scene.scene.end_time);
    if ticks > MOST_TICKS {
        return Err(BuildError::TooLong { ticks, limit: MOST_TICKS });
    }
    let qualities = definition.element_qualities(&mesh.elements, &mesh.rest);
    engine.set_distortion_limits(definition.distortion_limits(&engine.gel().potential, &mesh.rest, &qualities));
    engine.set_exits(exit_rule(scene));
    engine.set_remesh_times(scene.remesh.as_ref().map_or(&[], |remesh| &remesh.times));
    let Mesh { facets, marks, .. } = mesh;
    let sensor_locations = locate_sensors(&engine, &definition);
    Ok(Box::new(GelModel {
        engine,
        facets,
        marks,
        sensor_locations,
        adjacency: definition.remesh.as_ref().map(|_| adjacency),
        definition,
        first_mesh: None,
        remesh_records: vec![],
        failed_remeshes: vec![],
    }))
}

/// Renumbers the nodes of a mesh in the order of the element loop, and builds the gel on it.
fn renumber_nodes<const D: usize>(
    mesh: Mesh<D>,
    rules: &IntegratorSettings,
    gel_of: impl Fn(&Mesh<D>) -> DiscreteGel<D, Simplices<D>>,
) -> (Mesh<D>, DiscreteGel<D, Simplices<D>>) {
    // The first gel is dropped before the second is built: only one is in memory.
    let order = node_order(&gel_of(&mesh), rules);
    let mesh = match order {
        Some(order) => mesh.renumbered(&order),
        None => mesh,
    };
    let gel = gel_of(&mesh);
    (mesh, gel)
}

fn integration_rules(scene: &Scene) -> IntegratorSettings {
    IntegratorSettings {
        schedule: match scene.integrator.schedule {
            ScheduleKind::Bins => SteppingSchedule::Bins,
            ScheduleKind::Queue => SteppingSchedule::Queue,
            ScheduleKind::Global => SteppingSchedule::Global,
        },
        cfl: scene.integrator.cfl(),
        law: match scene.contact.law {
            ContactLaw::Moreau => {
                let ContactSpec { restitution, bias, friction, .. } = scene.contact;
                ImpulseLaw::Moreau { restitution, bias, friction }
            }
            ContactLaw::Reversal => ImpulseLaw::Reversal,
        },
        force_window: scene.force_window(),
        damping: scene.integrator.damping,
    }
}

/// Constants of a body of the scene, and its state at time 0.
fn build_body(scene: &Scene, i: usize, prescribed: bool) -> (RigidBody, BodyState) {
    let (projectile, shape) = (scene.body(i), scene.shape(i));
    let freedom = match scene.freedom() {
        Dimension::Planar => FreeDirections::PLANAR,
        Dimension::Axisymmetric => FreeDirections::AXISYMMETRIC,
        Dimension::Spatial => FreeDirections::SPATIAL,
    };
    let body = if projectile.fixed {
        RigidBody::fixed(shape, freedom)
    } else {
        let motion = if prescribed { BodyMotion::Prescribed } else { BodyMotion::Free };
        let inertia = inertia(projectile, &shape, scene.scene.dimension);
        RigidBody::new(shape, motion, freedom, projectile.mass.unwrap_or(1.0), inertia)
    };
    let mut state = BodyState {
        orientation: orientation(freedom.turns(projectile.orientation)),
        bulge: match &body.shape {
            ShapeGeometry::Dome(dome) => Some(DomeMotion::at_rest(dome)),
            _ => None,
        },
        active: projectile.active,
        ..BodyState::at_start(projectile.position.into(), projectile.velocity.into())
    };
    if !projectile.fixed {
        state.angular_momentum = body.angular_momentum(&state, &Vector3::from(projectile.angular_velocity));
    }
    (body, state)
}

/// Unit quaternion of the components (w, x, y, z).
pub(super) fn orientation([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    let q = Quaternion::new(w, x, y, z);
    UnitQuaternion::new_unchecked(q / q.norm())
}

/// Inertia of the scene, or that of a homogeneous body, kg·m²; in the plane that of a prism about y.
fn inertia(projectile: &ProjectileSpec, shape: &ShapeGeometry, dimension: Dimension) -> Tensor3 {
    if let Some([xx, yy, zz, xy, xz, yz]) = projectile.inertia {
        return Tensor3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    }
    let specific = match dimension {
        Dimension::Planar => shape.specific_inertia_of_section().map(|i| Tensor3::identity() * i),
        Dimension::Axisymmetric | Dimension::Spatial => shape.specific_inertia(),
    };
    specific.expect("a half-space that moves has its inertia in the scene") * projectile.mass.unwrap_or(1.0)
}

fn plane_mesh(scene: &Scene) -> Result<Mesh<2>, BuildError> {
    let block = check_cell_count(plane_block(scene))?;
    Ok(match &scene.gel.shape {
        GelShape::LBeam { thickness, angle, corner, .. } => {
            mesh::l_beam(block, *thickness, (*angle, Vector::<2>::new(corner[0], corner[2])))
        }
        GelShape::Block { .. } | GelShape::Cylinder { .. } | GelShape::Shell { .. } => mesh::block(block),
    })
}

/// Structured grid of a planar gel; that of the square around the legs of a beam.
pub(super) fn plane_block(scene: &Scene) -> BlockSpec<2> {
    match &scene.gel.shape {
        GelShape::LBeam { leg, thickness, .. } => {
            let planes = leg_planes(scene, *leg, *thickness);
            BlockSpec { planes: [planes.clone(), planes], split: cell_division(scene), faces: vec![] }
        }
        GelShape::Block { size } => {
            let planes = [centred_planes(scene, 0.5 * size[0]), depth_planes(scene, size[1])];
            let s = &scene.gel.supports;
            BlockSpec {
                planes,
                split: cell_division(scene),
                faces: supported_faces([(0, s.x_min, s.x_max), (1, s.z_min, s.z_max)]),
            }
        }
        GelShape::Cylinder { .. } | GelShape::Shell { .. } => {
            unreachable!("a planar gel is a block or an l-beam: the scene was checked")
        }
    }
}

fn section_mesh(scene: &Scene) -> Result<Mesh<2>, BuildError> {
    let block = check_cell_count(section_block(scene))?;
    Ok(if matches!(scene.gel.shape, GelShape::Shell { .. }) { mesh::shell(block) } else { mesh::block(block) })
}

/// Structured grid of the section of an axisymmetric gel; in radius and angle for a shell.
pub(super) fn section_block(scene: &Scene) -> BlockSpec<2> {
    let s = &scene.gel.supports;
    match scene.gel.shape {
        GelShape::Cylinder { radius, height, bore } => {
            let across =
                bore.map_or_else(|| axis_planes(scene, radius), |bore| mesh::uniform(bore, radius, scene.mesh.size));
            let wall = if bore.is_none() { FaceSupport::Roller } else { FaceSupport::Free };
            let faces = supported_faces([(0, wall, s.side), (1, s.z_min, s.z_max)]);
            BlockSpec { planes: [across, depth_planes(scene, height)], split: cell_division(scene), faces }
        }
        GelShape::Shell { inner, outer } => {
            let planes = mesh::shell_planes([inner, outer], scene.mesh.size);
            let faces = supported_faces([(0, FaceSupport::Free, s.side), (1, FaceSupport::Roller, s.z_max)]);
            BlockSpec { planes, split: cell_division(scene), faces }
        }
        GelShape::Block { .. } | GelShape::LBeam { .. } => {
            unreachable!("an axisymmetric gel is a cylinder or a shell: the scene was checked")
        }
    }
}

fn space_mesh(scene: &Scene) -> Result<Mesh<3>, BuildError> {
    let block = check_cell_count(space_block(scene))?;
    Ok(match &scene.gel.shape {
        GelShape::Block { .. } | GelShape::Shell { .. } => mesh::block(block),
        GelShape::Cylinder { radius, .. } => mesh::cylinder(*radius, block),
        GelShape::LBeam { thickness, angle, corner, .. } => {
            mesh::l_beam(block, *thickness, (*angle, Vector3::from(*corner)))
        }
    })
}

/// Structured grid of a spatial gel; that of the square around a cylinder or around the legs of a beam.
pub(super) fn space_block(scene: &Scene) -> BlockSpec<3> {
    let s = &scene.gel.supports;
    match &scene.gel.shape {
        GelShape::Block { size } => {
            let mirrored = |axis: usize| scene.gel.symmetry.mirrored().contains(&axis);
            let side = |i: usize, low, high| {
                let half = 0.5 * size[i];
                let planes = if mirrored(i) { axis_planes(scene, half) } else { centred_planes(scene, half) };
                (planes, (i, if mirrored(i) { FaceSupport::Roller } else { low }, high))
            };
            let ((x, across), (y, along)) = (side(0, s.x_min, s.x_max), side(1, s.y_min, s.y_max));
            let planes = [x, y, depth_planes(scene, size[2])];
            BlockSpec {
                planes,
                split: cell_division(scene),
                faces: supported_faces([across, along, (2, s.z_min, s.z_max)]),
            }
        }
        GelShape::Shell { .. } => unreachable!("a spatial gel is no shell: the scene was checked"),
        GelShape::Cylinder { radius, height, .. } => {
            let planes = [centred_planes(scene, *radius), centred_planes(scene, *radius), depth_planes(scene, *height)];
            let faces = supported_faces([(0, FaceSupport::Free, s.side), (2, s.z_min, s.z_max)]);
            BlockSpec { planes, split: cell_division(scene), faces }
        }
        GelShape::LBeam { leg, thickness, width, .. } => {
            let half = 0.5 * width.unwrap_or(*thickness);
            let planes = leg_planes(scene, *leg, *thickness);
            let width = mesh::uniform(-half, half, scene.mesh.size);
            BlockSpec { planes: [planes.clone(), width, planes], split: cell_division(scene), faces: vec![] }
        }
    }
}

/// Number of cells of a grid. A tree is counted before it is balanced, and no further than the greatest number that
/// is built.
pub(super) fn n_cells<const D: usize>(block: &BlockSpec<D>) -> f64 {
    match block.split {
        CellSplit::Centred | CellSplit::Kuhn => block.planes.iter().map(|p| p.len() as f64 - 1.0).product(),
        CellSplit::Tree(tree) => tree.count(&block.planes, MOST_CELLS as usize + 1) as f64,
    }
}

fn check_cell_count<const D: usize>(block: BlockSpec<D>) -> Result<BlockSpec<D>, BuildError> {
    let cells = n_cells(&block);
    if cells > MOST_CELLS {
        return Err(BuildError::TooLarge { cells, limit: MOST_CELLS });
    }
    Ok(block)
}

fn cell_division(scene: &Scene) -> CellSplit {
    match (scene.mesh.tree, scene.mesh.lattice) {
        (Some(scene::OctreeSpec { coarsest, core, slope }), _) => {
            CellSplit::Tree(mesh::OctreeGrading { coarsest, core, slope })
        }
        (None, CellLattice::Centred) => CellSplit::Centred,
        (None, CellLattice::Kuhn) => CellSplit::Kuhn,
    }
}

/// Supports of the low and high face of each axis.
fn supported_faces<const N: usize>(sides: [(usize, FaceSupport, FaceSupport); N]) -> Vec<HeldFace> {
    let hold = |support| match support {
        FaceSupport::Free => None,
        FaceSupport::Roller => Some(FaceConstraint::Normal),
        FaceSupport::Fixed => Some(FaceConstraint::All),
    };
    let ends = sides.into_iter().flat_map(|(axis, low, high)| [(axis, false, low), (axis, true, high)]);
    ends.filter_map(|(axis, high, support)| hold(support).map(|hold| HeldFace { axis, high, hold })).collect()
}

/// Planes from 0 to `length`.
fn axis_planes(scene: &Scene, length: f64) -> Vec<f64> {
    let size = scene.mesh.size;
    match (scene.mesh.grading, scene.mesh.tree) {
        (Some(grading), _) => mesh::graded(length, size, (grading.core, grading.growth, grading.largest)),
        (None, Some(tree)) => mesh::uniform_divisible(length, size, tree.coarsest),
        (None, None) => mesh::uniform(0.0, length, size),
    }
}

/// Planes from −`half` to `half`, with a plane at 0 if graded.
fn centred_planes(scene: &Scene, half: f64) -> Vec<f64> {
    if scene.mesh.grading.is_none() && scene.mesh.tree.is_none() {
        return mesh::uniform(-half, half, scene.mesh.size);
    }
    let right = axis_planes(scene, half);
    right.iter().rev().map(|x| -x).chain(right.iter().skip(1).copied()).collect()
}

/// Planes from −`height` to the entry surface at 0.
fn depth_planes(scene: &Scene, height: f64) -> Vec<f64> {
    axis_planes(scene, height).iter().rev().map(|z| -z).collect()
}

/// Planes along a leg, one of them at its thickness.
fn leg_planes(scene: &Scene, leg: f64, thickness: f64) -> Vec<f64> {
    let mut planes = mesh::uniform(0.0, thickness, scene.mesh.size);
    planes.extend(mesh::uniform(thickness, leg, scene.mesh.size).into_iter().skip(1));
    planes
}

/// Exit rule of a scene; `None` for a gel without a back face, or one that moves as a whole.
fn exit_rule(scene: &Scene) -> Option<ExitRule> {
    let gel = scene.gel.shape.bounding_box().filter(|_| scene.gel.velocity == [0.0; 3])?;
    Some(ExitRule {
        back_face: gel.lower.z,
        half_width: gel.upper.xy().into(),
        rest_after: scene.scene.stop_after_exit.time(),
    })
}
