//! Assembly of a system from a gel, bodies and nodes: at the start, or where another mesh has ended.

use super::blocks::ElementBlocks;
use super::clock::MeshClock;
use super::derived::derive_from_state;
use super::element_order::ElementLayout;
use super::gel_frame::GelFrame;
use super::model::DiscreteModel;
use super::sort_keys::element_layout;
use super::stability::{stable_steps, tick_grid};
use super::system::DiscreteSystem;
use super::workspace::Workspace;
use super::{DiscreteGel, IntegratorSettings, SteppingSchedule, TickGrid, UnusableStep};
use crate::contact::{BatchTravel, BodyState, ContactDetection, ImpulseLaw, NeighbourList, RigidBody};
use crate::fem::{ElementStates, HistoryVariables, Potential};
use crate::ledger::Ledger;
use crate::math::{Vector, embed};
use crate::mesh::ElementId;
use crate::state::{DynamicState, GroupAlarm, GroupClock, RunRecord, Tick};
use std::sync::Arc;

/// Data with which a mesh begins: those of the start, or those that the mesh before hands over.
pub(super) struct Carryover<const D: usize> {
    pub tick: Tick,
    pub grid: Option<TickGrid>,
    pub ledger: Ledger,
    pub record: RunRecord,
    /// History variables of the elements, unless they are fresh.
    pub memory: Option<Vec<HistoryVariables<D>>>,
    /// Stable steps of the elements of the new mesh, s, if they are known.
    pub steps: Option<Vec<f64>>,
    /// Steps that the elements of the new mesh may not exceed at first, s; empty if they may.
    pub held_steps: Vec<f64>,
}

impl<const D: usize> Carryover<D> {
    /// Creates the data of the start.
    pub fn at_start(n_bodies: usize) -> Self {
        let (ledger, record) = (Ledger::default(), RunRecord::new(n_bodies));
        Self { tick: 0, grid: None, ledger, record, memory: None, steps: None, held_steps: vec![] }
    }
}

/// Assembles a system; also returns the stable step of each element, s.
///
/// # Errors
/// [`UnusableStep`] if a stable step is unusable.
///
/// # Panics
/// If there is no body.
pub(super) fn assemble<const D: usize, P: Potential<D>>(
    gel: DiscreteGel<D, P>,
    settings: IntegratorSettings,
    bodies: Vec<(RigidBody, BodyState)>,
    nodes: Vec<(Vector<D>, Vector<D>)>,
    carryover: Carryover<D>,
) -> Result<(DiscreteSystem<D, P>, Vec<f64>), UnusableStep> {
    assert!(!bodies.is_empty(), "there is a body, if only one that touches nothing");
    let (position, velocity): (Vec<_>, Vec<_>) = nodes.into_iter().unzip();
    let (bodies, at): (Vec<_>, Vec<_>) = bodies.into_iter().unzip();
    let Carryover { tick: origin, grid, ledger, mut record, memory, steps, held_steps } = carryover;
    let memory = memory.unwrap_or_else(|| gel.fresh_memory());
    let measured = gel.measure(&position, &memory);
    let mut steps = steps.unwrap_or_else(|| stable_steps(&gel, &measured.stiffness, settings.cfl));
    steps.iter_mut().zip(held_steps).for_each(|(step, held)| *step = step.min(held));
    let (grid, step) = tick_grid(&steps, grid)?;
    record.synchronous = (step, origin, record.synchronous.2);
    let layout = element_layout(&gel, &settings, |element| grid.ticks(steps[element.index()]));
    let state = DynamicState {
        excess: vec![0.0; position.len()],
        stiffness: layout.by_slot(&measured.stiffness),
        clocks: initial_clocks(&gel, &layout, &measured),
        alarms: vec![GroupAlarm::default(); settings.schedule.n_alarms(layout.n_groups())],
        birth: None,
        now: None,
        bodies: at,
        memory,
        ledger,
        record,
        position,
        velocity,
    };
    let longest = grid.ticks(steps.iter().copied().fold(0.0, f64::max));
    let neighbours = NeighbourList::new(&gel.surface, 0.0, vec![], |node| embed(&state.position[node]));
    let mut system = DiscreteSystem {
        blocks: element_blocks(&gel, &layout, &settings),
        clock: MeshClock::new(origin, (step, longest), state.position.len()),
        batch_travel: BatchTravel::default(),
        separation: None,
        contact: ContactDetection::new(neighbours, &gel.surface),
        workspace: Workspace::new(state.position.len(), gel.surface.nodes.len(), layout.n_groups()),
        model: DiscreteModel {
            gel: Arc::new(gel),
            layout: Arc::new(layout),
            bodies,
            frame: GelFrame::default(),
            settings,
            grid,
        },
        state,
        pool: None,
    };
    derive_from_state(&mut system);
    Ok((system, steps))
}

/// Selects the reference form of every phase, which processes one element after the other.
pub(super) fn use_reference_form<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    system.blocks = None;
    system.workspace.chunk_sums.clear();
    derive_from_state(system);
}

/// Builds the blocks of the SIMD form; `None` where only the reference form applies.
fn element_blocks<const D: usize, P: Potential<D>>(
    gel: &DiscreteGel<D, P>,
    layout: &ElementLayout,
    settings: &IntegratorSettings,
) -> Option<ElementBlocks<D>> {
    let fast = settings.law != ImpulseLaw::Reversal && settings.schedule != SteppingSchedule::Queue;
    fast.then(|| ElementBlocks::new(gel, layout)).flatten()
}

/// Returns the clocks of groups that have not begun, with their initial energies.
fn initial_clocks<const D: usize, P: Potential<D>>(
    gel: &DiscreteGel<D, P>,
    layout: &ElementLayout,
    measured: &ElementStates,
) -> Vec<GroupClock> {
    let crushed = |element: &ElementId| gel.potential.is_crushed(measured.jacobian[element.index()]);
    let clock = |group: usize| GroupClock {
        energy: layout.patches(group).iter().map(|patch| measured.energy[*patch as usize]).sum::<f64>() + 0.0,
        crushed: layout.elements(layout.slots(group)).filter(crushed).count() as u32,
        ..GroupClock::default()
    };
    (0..layout.n_groups()).map(clock).collect()
}
