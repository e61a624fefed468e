//! Builds the engine of a checked scene at time 0.

use super::build_error::BuildError;
use super::gel::define_gel;
use super::grid::{check_planes, plane_mesh, section_mesh, space_mesh};
use super::loads::load_markers;
use super::model::{ErasedModel, GelModel, MOST_TICKS, is_centre_in_gel, overlap};
use super::reduced_model::build_reduced;
use super::saved::EraseDimension;
use super::scene_bodies::build_body;
use super::sensors::place_sensors;
use crate::adapt::{AdaptiveGel, RemeshDriver};
use crate::contact::ImpulseLaw;
use crate::fem::Simplices;
use crate::integrator::{
    DiscreteGel, Engine, ExitRule, GelFrame, IntegratorSettings, SteppingSchedule, UnusableStep, WorkerPool, node_order,
};
use crate::math::{Vector, Vector3, embed, restrict};
use crate::mesh::{Mesh, NodeId, face_neighbours};
use crate::scene::{ContactLaw, ContactSpec, Dimension, Scene, ScheduleKind, body_name};
use crate::state::DynamicState;

/// Builds the engine of a scene; `prescribed` if the importer gives the motion of the bodies.
pub(super) fn build(scene: &Scene, prescribed: bool, threads: usize) -> Result<Box<dyn ErasedModel>, BuildError> {
    if let Some(class) = scene.reduced_class() {
        return build_reduced(scene, class, prescribed);
    }
    check_planes(scene)?;
    match scene.scene.dimension {
        Dimension::Planar => assemble(scene, plane_mesh(scene)?, prescribed, threads),
        Dimension::Axisymmetric => assemble(scene, section_mesh(scene)?, prescribed, threads),
        Dimension::Spatial => assemble(scene, space_mesh(scene)?, prescribed, threads),
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
    AdaptiveGel<D>: RemeshDriver,
{
    let definition = define_gel(scene);
    let mesh = Mesh { marks: load_markers(scene, &mesh)?, ..mesh };
    let adjacency = if definition.needs_adjacency() { face_neighbours::<D>(&mesh.elements) } else { vec![] };
    let patches = definition.build_patches(&mesh, &mesh.rest, &adjacency);
    let gel_of = |mesh: &Mesh<D>| {
        let simplices = definition.build_first_simplices(mesh, patches.clone());
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
        let position = |node: NodeId| embed(&mesh.rest[node.index()]);
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
    let frame = block_frame(scene, &engine, &mesh);
    engine.set_exits(exit_rule(scene, &frame));
    engine.set_frame(frame);
    engine.set_remesh_times(scene.remesh.as_ref().map_or(&[], |remesh| &remesh.times));
    let points: Vec<Vector3> = scene.sensor.iter().map(|sensor| sensor.position.into()).collect();
    let sensors = place_sensors(&points, definition.symmetry_planes, &engine);
    let fields = if scene.output.frames > 0 { scene.output.fields.clone() } else { vec![] };
    Ok(Box::new(GelModel { gel: AdaptiveGel::new(engine, definition, mesh, adjacency), sensors, fields }))
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

/// Frame of a block or cylinder; that of a gel without an entry face does not move.
fn block_frame<const D: usize>(scene: &Scene, engine: &Engine<D, Simplices<D>>, mesh: &Mesh<D>) -> GelFrame {
    if scene.gel.shape.bounding_box().is_none() {
        return GelFrame::default();
    }
    let is_held = |i: usize| mesh.held.iter().any(|held| held[i]);
    let free = embed(&Vector::<D>::from_fn(|i, _| if is_held(i) { 0.0 } else { 1.0 }));
    GelFrame {
        initial_velocity: Vector3::from(scene.gel.velocity).component_mul(&free),
        mobility: free / engine.gel().mass.iter().sum::<f64>(),
    }
}

/// Exit rule of a scene; `None` for a gel without a back face, or one that moves against its supports.
fn exit_rule(scene: &Scene, frame: &GelFrame) -> Option<ExitRule> {
    let follows = frame.initial_velocity == Vector3::from(scene.gel.velocity);
    let gel = scene.gel.shape.bounding_box().filter(|_| follows)?;
    Some(ExitRule {
        back_face: gel.lower.z,
        half_width: gel.upper.xy().into(),
        rest_after: scene.scene.stop_after_exit.time(),
    })
}
