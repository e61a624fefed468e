//! Pressure loads on faces of the gel: each loaded facet is kicked at the ticks of the element behind it, as part of
//! that element's energy (method A6). The work of the pressures is booked.

use super::LoadedFacet;
use super::cavity::{OpenCavity, find_air_load};
use super::cavity_gas::update_gas;
use super::element_order::SLOTS;
use super::kick_sums::ConstraintReaction;
use super::system::DiscreteSystem;
use super::workspace::{FacetLoad, LoadStiffness, PressureSource};
use crate::fem::{Potential, push};
use crate::math::{Vector, embed};
use crate::mesh::NodeId;
use crate::state::Tick;

/// Finds the pressure loads of the facets of active elements and adds their load stiffness; called before the
/// clocks are set.
pub(super) fn find_loads<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    system.workspace.facet_loads.clear();
    system.workspace.load_stiffness.clear();
    if !system.is_loaded() {
        return;
    }
    let (gel, time) = (system.model.gel.clone(), system.model.grid.time(tick));
    let now: Vec<f64> = gel.loads.pressures.iter().map(|pressure| pressure.at(time)).collect();
    update_gas(system, tick);
    let (entry, cavity) = (system.entry_height(time), OpenCavity::at(system, time));
    for (facet, loaded) in gel.loads.facets.iter().enumerate() {
        let group = system.model.layout.group(loaded.behind);
        if is_group_active(system, group, tick) {
            let slot = system.model.layout.slot(loaded.behind);
            let cavity = cavity.filter(|_| loaded.can_bound_cavity());
            let air = cavity.and_then(|cavity| find_air_load(system, &cavity, loaded, group, tick));
            let mut added = 0.0;
            for (load, stiffness) in
                find_load(system, loaded, &LoadLevel { pressures: &now, entry }, group, tick).into_iter().chain(air)
            {
                system.workspace.facet_loads.push(load);
                added += stiffness;
            }
            let before = system.state.stiffness[slot];
            system.workspace.load_stiffness.push(LoadStiffness { facet, slot, added, before });
        }
    }
    add_load_stiffness(system);
}

/// Pressures at a time, Pa, and the height of the entry surface of a block that moves as a whole, m.
struct LoadLevel<'a> {
    pressures: &'a [f64],
    entry: f64,
}

/// Finds the pressure load of a facet, and the stiffness that it adds to the element behind the facet, N/m.
fn find_load<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    loaded: &LoadedFacet,
    level: &LoadLevel,
    group: usize,
    tick: Tick,
) -> Option<(FacetLoad<D>, f64)> {
    let (loads, time) = (&system.model.gel.loads, system.model.grid.time(tick));
    let corners = loaded.facet.map(|node| system.position_at(node, time));
    let middle = corners[..D].iter().sum::<Vector<D>>() / D as f64;
    let (pressure, growth) = loads.pressure(loaded.mark, level.pressures, middle[D - 1] - level.entry);
    if pressure == 0.0 {
        return None;
    }
    let push = push(loads.section, &corners);
    // f_a = p(z) w_a A n with Σ w_a = 1 and z = Σ z_b/D: its derivative through p′ has the norm p′A|w|/√D ≤
    // p′A/√D.
    let area = push.forces.iter().sum::<Vector<D>>().norm();
    let added = pressure.abs() * push.stiffness + growth * area / (D as f64).sqrt();
    let (forces, weight) = (push.forces.map(|force| force * pressure), system.trailing_half(group, tick));
    Some((FacetLoad { nodes: loaded.facet, forces, group, weight, source: PressureSource::Face }, added))
}

/// Returns true if a group is active at this tick; called before the clocks are set.
fn is_group_active<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, group: usize, tick: Tick) -> bool {
    match system.blocks {
        Some(_) => system.tick_context(tick).is_active(system.state.clocks[group].step),
        None => system.workspace.active_groups.binary_search(&(group as u32)).is_ok(),
    }
}

/// Adds the load stiffness of pressures to the stiffness of active elements. Elements of a block at rest were not
/// swept: they take the stiffness of their last sweep without the former load stiffness, as a sweep now or a
/// restart would give.
pub(super) fn add_load_stiffness<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let stiffness = &mut system.state.stiffness;
    if let Some(blocks) = &mut system.blocks {
        for load in &system.workspace.load_stiffness {
            let (found, stored) = (&mut blocks.unloaded[load.facet], &mut stiffness[load.slot]);
            if blocks.all[load.slot / SLOTS].report.is_some() {
                *found = *stored;
            }
        }
        let is_unswept = |load: &&LoadStiffness| blocks.all[load.slot / SLOTS].report.is_none();
        for load in system.workspace.load_stiffness.iter().filter(is_unswept) {
            stiffness[load.slot] = blocks.unloaded[load.facet];
        }
    }
    for load in &system.workspace.load_stiffness {
        stiffness[load.slot] += load.added;
    }
    sum_nodal_stiffness(system);
}

/// Sums κ at the nodes of the blocks in which it has changed, in the order of a sweep, and requests a step check
/// around blocks at rest.
fn sum_nodal_stiffness<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let (Some(blocks), stiffness) = (&mut system.blocks, &system.state.stiffness) else { return };
    let mut stiffened = std::mem::take(&mut system.workspace.stiffened_blocks);
    for load in &system.workspace.load_stiffness {
        let (block, behind) = (load.slot / SLOTS, system.model.gel.loads.facets[load.facet].behind);
        // A sweep leaves out the load stiffness of the tick before.
        let (is_at_rest, was_swept) = (!blocks.all[block].is_moving(), blocks.all[block].report.is_some());
        if stiffness[load.slot] == load.before && !(is_at_rest && was_swept) {
            continue;
        }
        stiffened.push(block);
        if is_at_rest {
            system.model.gel.potential.nodes(behind).iter().for_each(|node| blocks.request_check_around(node.index()));
        }
    }
    stiffened.sort_unstable();
    stiffened.dedup();
    for block in stiffened.drain(..) {
        let (groups, own) = (blocks.groups_of(block), &blocks.all[block]);
        let part = &mut blocks.parts[own.first..own.first + own.nodes.len()];
        blocks.lanes.sum_stiffness(groups, &stiffness[block * SLOTS..], part);
    }
    system.workspace.stiffened_blocks = stiffened;
}

/// Kicks the nodes of the loaded facets by their pressures; held directions take up the rest.
pub(super) fn apply_pressures<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    if system.workspace.facet_loads.is_empty() {
        return;
    }
    let (gel, freedom, mut reaction) = (system.model.gel.clone(), system.freedom(), ConstraintReaction::default());
    let time = system.model.grid.time(tick);
    let mut load = std::mem::take(&mut system.workspace.facet_loads);
    for load in &mut load {
        load.weight += 0.5 * system.model.grid.time(system.ahead(load.group, tick));
        for (node, impulse) in load.impulses() {
            let (a, push) = (node.index(), embed(&impulse));
            system.state.velocity[a] += impulse.component_mul(&gel.free(a)) / gel.mass[a];
            let at = embed(&system.state.position[a]);
            reaction.add(&gel.free(a), freedom, at, push);
            let ledger = &mut system.state.ledger;
            let (momentum, angular_momentum) = match load.source {
                PressureSource::Face => (&mut ledger.momentum.load, &mut ledger.angular_momentum.load),
                PressureSource::Cavity => (&mut ledger.momentum.air, &mut ledger.angular_momentum.air),
            };
            let free_push = freedom.translation(&push);
            *momentum += free_push;
            *angular_momentum += freedom.rotation(&at.cross(&push));
            system.state.record.outside.add(&free_push, time);
            system.state.record.pressed += push.norm();
        }
    }
    reaction.post(&mut system.state.ledger);
    system.workspace.facet_loads = load;
}

/// Iterates over the nodes of the loaded facets of this tick.
pub(super) fn loaded_nodes<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
) -> impl Iterator<Item = NodeId> + '_ {
    system.workspace.facet_loads.iter().flat_map(|load| load.nodes[..D].iter().copied())
}

/// Returns the velocity of a node of a loaded facet before the kicks of this tick, m/s. In the block form a node
/// that was still is not active.
fn velocity_before_loads<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, node: NodeId) -> Vector<D> {
    match system.workspace.impulse_nodes.binary_search_by_key(&node, |impulse_node| impulse_node.node) {
        Ok(at) if system.blocks.is_some() => system.workspace.impulse_nodes[at].before,
        _ => system.workspace.velocities_before[node.index()],
    }
}

/// Posts the work of the pressures, Σ J·(v⁻ + v⁺)/2, once all velocities of the tick are known.
pub(super) fn post_load_work<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let work = |(node, impulse): (NodeId, Vector<D>)| {
        let velocity_sum = velocity_before_loads(system, node) + system.state.velocity[node.index()];
        0.5 * impulse.component_mul(&system.model.gel.free(node.index())).dot(&velocity_sum)
    };
    let of_source = |source: PressureSource| -> f64 {
        let own = system.workspace.facet_loads.iter().filter(|load| load.source == source);
        own.flat_map(FacetLoad::impulses).map(work).sum()
    };
    let [load, air] = [PressureSource::Face, PressureSource::Cavity].map(of_source);
    system.state.ledger.energy.load += load;
    system.state.ledger.energy.air += air;
}
