//! Handover between meshes: the system that continues where another mesh has ended, at one tick (method A12).

use super::assemble::{Carryover, assemble, use_reference_form};
use super::mesh_end::stepless_corners;
use super::report::BalanceReference;
use super::system::DiscreteSystem;
use super::{DiscreteGel, UnusableStep};
use crate::contact::{BodyState, RigidBody};
use crate::fem::{HistoryVariables, Potential};
use crate::math::Vector;
use crate::state::{MOST_TICKS, MeshInstance, Tick};
use std::sync::Arc;

/// Creates a system that continues with another gel from the end of this one, with its nodes at these positions and
/// velocities. The changes of energy, momentum and angular momentum are booked. `birth` is the new mesh and is given
/// the steps with which it begins; steps that it has already are not exceeded at first. The thread pool stays with this system.
///
/// # Errors
/// [`UnusableStep`] if a step of the new mesh is no valid step.
pub(super) fn continue_on_mesh<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    gel: DiscreteGel<D, P>,
    memory: Option<Vec<HistoryVariables<D>>>,
    nodes: Vec<(Vector<D>, Vector<D>)>,
    birth: Option<MeshInstance<D>>,
) -> Result<DiscreteSystem<D, P>, UnusableStep> {
    let held = birth.as_ref().map_or_else(Vec::new, |birth| birth.steps.clone());
    // Steps with the history variables: elements that have flowed far are none the stiffer for it.
    let (mut new, steps) = begin_mesh(system, gel, memory, nodes, system.last_tick(), None, held)?;
    let (was, now) = (
        BalanceReference::of(&system.model.gel, &system.model.bodies, &system.state),
        BalanceReference::of(&new.model.gel, &new.model.bodies, &new.state),
    );
    let ledger = &mut new.state.ledger;
    ledger.energy.remesh += now.energy - was.energy;
    ledger.momentum.remesh += now.momentum - was.momentum;
    ledger.angular_momentum.remesh += now.angular_momentum - was.angular_momentum;
    new.state.birth = birth.map(|birth| Arc::new(MeshInstance { steps, ..birth }));
    Ok(new)
}

/// Creates a system on a mesh of this run, past or future, into which a state of that mesh is to be restored;
/// without threads. `birth` is the mesh, unless it is the first one.
///
/// # Errors
/// [`UnusableStep`] as [`continue_on_mesh`].
pub(super) fn system_on_mesh<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    gel: DiscreteGel<D, P>,
    position: &[Vector<D>],
    birth: Option<Arc<MeshInstance<D>>>,
) -> Result<DiscreteSystem<D, P>, UnusableStep> {
    let nodes = position.iter().map(|x| (*x, Vector::<D>::zeros())).collect();
    // The history variables of the new mesh are lost, apart from the steps that followed from them.
    let (tick, steps) = birth.as_ref().map_or((0, None), |birth| (birth.tick, Some(birth.steps.clone())));
    let (mut other, _) = begin_mesh(system, gel, None, nodes, tick, steps, vec![])?;
    other.state.birth = birth;
    Ok(other)
}

/// Creates a system with another gel from `tick` on; also returns the stable steps of its elements, s.
fn begin_mesh<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    gel: DiscreteGel<D, P>,
    memory: Option<Vec<HistoryVariables<D>>>,
    nodes: Vec<(Vector<D>, Vector<D>)>,
    tick: Tick,
    steps: Option<Vec<f64>>,
    held_steps: Vec<f64>,
) -> Result<(DiscreteSystem<D, P>, Vec<f64>), UnusableStep> {
    let bodies: Vec<(RigidBody, BodyState)> =
        system.model.bodies.iter().cloned().zip(system.state.bodies.iter().copied()).collect();
    let (ledger, record) = (system.state.ledger, system.state.record.clone());
    let carryover = Carryover { tick, grid: Some(system.model.grid), ledger, record, memory, steps, held_steps };
    let (mut new, steps) = assemble(gel, system.model.settings, bodies, nodes, carryover)?;
    new.clock.ends.clone_from(&system.clock.ends);
    new.model.frame = system.model.frame;
    if system.blocks.is_none() {
        use_reference_form(&mut new);
    }
    if let (Some(new), Some(old)) = (&mut new.blocks, &system.blocks) {
        (new.level, new.never_rest) = (old.level, old.never_rest);
    }
    let ((least, most), grid) = (new.clock.initial_steps, new.model.grid);
    if least < 1.0 {
        return Err(UnusableStep { step: grid.length(least), corners: stepless_corners(&new) });
    }
    if most > MOST_TICKS as f64 {
        return Err(UnusableStep { step: grid.length(most), corners: vec![] });
    }
    Ok((new, steps))
}

#[cfg(test)]
mod tests {
    use super::super::test_cube;
    use super::*;
    use crate::mesh::ElementPatches;

    #[test]
    fn a_mesh_with_invalid_stable_steps_is_refused() {
        let mesh = test_cube::mesh(&[0.0, 0.5, 1.0]);
        let engine = test_cube::engine(test_cube::gel(&mesh));
        let tick = engine.system.model.grid.length(1.0);
        let begins = |first: f64| {
            let mut steps = vec![1024.0 * tick; mesh.elements.len()];
            steps[0] = first;
            let (mass, corner_mass) = (engine.system.model.gel.mass.clone(), vec![[1.0; 4]; mesh.elements.len()]);
            let (mesh, position) = (mesh.clone(), mesh.rest.clone());
            let (references, parts, patches) = (vec![], vec![], ElementPatches::alone(mesh.elements.len()));
            let birth = MeshInstance { tick: 7, mesh, position, mass, corner_mass, references, patches, parts, steps };
            let gel = test_cube::gel(&birth.mesh);
            engine
                .engine_on_mesh(gel, &birth.position.clone(), Some(Arc::new(birth)))
                .map(|other| other.system.clock.origin)
        };
        assert_eq!(begins(tick).ok(), Some(7));
        for forged in [0.9 * tick, 1e-300, 1e300] {
            let found = begins(forged).expect_err("a step of no run");
            assert!((found.step / forged - 1.0).abs() < 1e-12, "{forged}: {found:?}");
        }
    }
}
