//! Quantities derived from the state: events, last ticks of nodes, moving blocks, neighbour list, range of steps.

use super::SteppingSchedule;
use super::active_set::{NODE_BATCH, RUN};
use super::schedule::EventQueue;
use super::system::DiscreteSystem;
use crate::contact::{BatchTravel, NeighbourList};
use crate::fem::Potential;
use crate::math::{Vector, embed};
use crate::mesh::NodeId;
use crate::state::Tick;

/// Derives events, last ticks of nodes, moving blocks, neighbour list and step range from the state.
pub(super) fn derive_from_state<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let state = &system.state;
    let queued = system.model.settings.schedule == SteppingSchedule::Queue && state.now.is_some();
    system.clock.queue = EventQueue::new(if queued { &state.alarms } else { &[] });
    system.clock.quiet_until = None;
    if let Some(blocks) = &mut system.blocks {
        let (rest, zero) = (system.model.gel.potential.rest(), Vector::<D>::zeros());
        let moves = |node: usize| state.velocity[node] != zero || state.position[node] != rest[node];
        blocks.is_prestrained = system.model.gel.potential.remembers() && system.clock.origin > 0;
        blocks.reset(&state.clocks, system.model.grid, moves);
        blocks.load_history(&system.model.layout, &state.memory);
    }
    let max_speed = |chunk: &[Vector<D>]| chunk.iter().map(Vector::<D>::norm_squared).fold(0.0, f64::max).sqrt();
    let speeds = |nodes: usize| state.velocity.chunks(nodes).map(max_speed).collect::<Vec<f64>>();
    let (speeds, of_batches) = (speeds(RUN), speeds(NODE_BATCH));
    let now = system.model.grid.time(state.now.unwrap_or(system.clock.origin));
    derive_last_ticks(system);
    let place = |node: usize| embed(&system.position_at(NodeId(node as u32), now));
    system.contact.neighbours = NeighbourList::new(&system.model.gel.surface, now, speeds, place);
    system.contact.knows_bodies = false;
    system.batch_travel = BatchTravel::new(now, of_batches);
    system.separation = None;
    update_step_range(system);
}

/// Derives the last tick of each node: the latest tick of the groups at the node.
fn derive_last_ticks<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let (state, order, gel, all) =
        (&system.state, &system.model.layout, &system.model.gel, &mut system.clock.last_ticks);
    let now = state.now.unwrap_or(system.clock.origin);
    let last = |group: usize| match system.model.settings.schedule {
        SteppingSchedule::Bins => now & !state.clocks[group].step.saturating_sub(1),
        SteppingSchedule::Queue => state.alarms[group].last,
        SteppingSchedule::Global => state.alarms[0].last,
    };
    all.fill(system.clock.origin);
    let mut visit = |tick: Tick, node: &NodeId| all[node.index()] = tick.max(all[node.index()]);
    let of_group = |group: usize| {
        order
            .elements(order.slots(group))
            .flat_map(|element| gel.potential.nodes(element))
            .map(move |node| (group, node))
    };
    let Some(blocks) = &system.blocks else {
        return (0..state.clocks.len()).flat_map(of_group).for_each(|(group, node)| visit(last(group), node));
    };
    // Where all groups of a block have one step, each node is visited once instead of once per element.
    let (uniform, mixed): (Vec<_>, Vec<_>) =
        blocks.all.iter().enumerate().partition(|(_, block)| block.steps.0 == block.steps.1);
    for (i, block) in uniform {
        block.nodes.iter().for_each(|node| visit(last(i * blocks.groups), node));
    }
    let mixed = mixed.iter().flat_map(|(i, _)| blocks.groups_of(*i));
    mixed.flat_map(of_group).for_each(|(group, node)| visit(last(group), node));
}

/// Updates the least and the greatest step of any group; blocks store theirs.
pub(super) fn update_step_range<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let all = |(least, most): (Tick, Tick), of: (Tick, Tick)| (least.min(of.0), most.max(of.1));
    let none = (Tick::MAX, 0);
    system.clock.step_range = match &system.blocks {
        Some(blocks) => blocks.all.iter().map(|block| block.steps).fold(none, all),
        None => system.state.clocks.iter().map(|clock| (clock.step, clock.step)).fold(none, all),
    };
}
