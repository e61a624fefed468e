//! Pressure loads on faces of the gel: each loaded facet is kicked at the ticks of the element behind it, as part of
//! that element's energy (numerics A6). The work of the pressures is booked.

use super::blocks::ElementBlocks;
use super::cavity::{OpenCavity, find_air_load};
use super::cavity_gas::update_gas;
use super::element_order::SLOTS;
use super::kick_sums::ConstraintReaction;
use super::load_input::LoadInput;
use super::system::DiscreteSystem;
use super::workspace::{FacetLoad, LoadStiffness, PressureSource};
use super::{DiscreteGel, LoadedFacet};
use crate::fem::{Potential, push};
use crate::math::{Vector, embed};
use crate::mesh::NodeId;
use crate::state::{CavityGas, Tick};

/// Load phase: finds the pressure loads of the facets of active elements, before the clocks are set.
pub(super) struct LoadPhase<'a, const D: usize, P> {
    pub input: LoadInput<'a, D, P>,
    /// κ by slot, N/m.
    pub stiffness: &'a [f64],
    pub gas: &'a mut Option<CavityGas>,
    pub facet_loads: &'a mut Vec<FacetLoad<D>>,
    pub load_stiffness: &'a mut Vec<LoadStiffness>,
}

impl<const D: usize, P: Potential<D>> LoadPhase<'_, D, P> {
    /// Finds the loads, and the stiffness that they add to the elements behind them.
    pub fn find_loads(self) {
        let Self { input, stiffness, gas, facet_loads, load_stiffness } = self;
        facet_loads.clear();
        load_stiffness.clear();
        let loads = &input.model.gel.loads;
        if loads.facets.is_empty() {
            return;
        }
        let now: Vec<f64> = loads.pressures.iter().map(|pressure| pressure.at(input.time)).collect();
        update_gas(&input, gas);
        let cavity = OpenCavity::at(&input, *gas);
        for (facet, loaded) in loads.facets.iter().enumerate().filter(|(_, loaded)| input.is_active(loaded)) {
            let slot = input.model.layout.slot(loaded.behind);
            let cavity = cavity.filter(|_| loaded.can_bound_cavity());
            let air = cavity.and_then(|cavity| find_air_load(&input, &cavity, loaded));
            let mut added = 0.0;
            for (load, stiffness) in find_load(&input, loaded, &now).into_iter().chain(air) {
                facet_loads.push(load);
                added += stiffness;
            }
            load_stiffness.push(LoadStiffness { facet, slot, added, before: stiffness[slot] });
        }
    }
}

/// Finds the load of these pressures, Pa, on a facet, and the stiffness that it adds to the element behind the facet,
/// N/m.
fn find_load<const D: usize, P: Potential<D>>(
    input: &LoadInput<'_, D, P>,
    loaded: &LoadedFacet,
    pressures: &[f64],
) -> Option<(FacetLoad<D>, f64)> {
    let (loads, corners) = (&input.model.gel.loads, input.corners(loaded));
    let middle = corners[..D].iter().sum::<Vector<D>>() / D as f64;
    let (pressure, growth) = loads.pressure(loaded.mark, pressures, middle[D - 1] - input.entry);
    if pressure == 0.0 {
        return None;
    }
    let push = push(loads.section, &corners);
    // f_a = p(z) w_a A n with Σ w_a = 1 and z = Σ z_b/D: its derivative through p′ has the norm p′A|w|/√D ≤
    // p′A/√D.
    let area = push.forces.iter().sum::<Vector<D>>().norm();
    let added = pressure.abs() * push.stiffness + growth * area / (D as f64).sqrt();
    Some((input.load(loaded, push.forces.map(|force| force * pressure), PressureSource::Face), added))
}

/// Loaded elements, whose stiffness grows by the pressures in front of them.
pub(super) struct LoadedElements<'a, const D: usize, P> {
    pub gel: &'a DiscreteGel<D, P>,
    pub loads: &'a [LoadStiffness],
    pub blocks: Option<&'a mut ElementBlocks<D>>,
    /// κ by slot, N/m.
    pub stiffness: &'a mut [f64],
    /// Blocks whose stiffness the loads change.
    pub stiffened: &'a mut Vec<usize>,
}

impl<const D: usize, P: Potential<D>> LoadedElements<'_, D, P> {
    /// Adds the load stiffness of pressures to the stiffness of active elements. Elements of a block at rest were not
    /// swept: they take the stiffness of their last sweep without the former load stiffness, as a sweep now or a
    /// restart would give.
    pub fn add_load_stiffness(mut self) {
        let (loads, stiffness) = (self.loads, &mut *self.stiffness);
        if let Some(blocks) = &mut self.blocks {
            for load in loads {
                let (found, stored) = (&mut blocks.unloaded[load.facet], &mut stiffness[load.slot]);
                if blocks.all[load.slot / SLOTS].report.is_some() {
                    *found = *stored;
                }
            }
            let is_unswept = |load: &&LoadStiffness| blocks.all[load.slot / SLOTS].report.is_none();
            for load in loads.iter().filter(is_unswept) {
                stiffness[load.slot] = blocks.unloaded[load.facet];
            }
        }
        for load in loads {
            stiffness[load.slot] += load.added;
        }
        self.sum_nodal_stiffness();
    }

    /// Sums κ at the nodes of the blocks in which it has changed, in the order of a sweep, and requests a step check
    /// around blocks at rest.
    fn sum_nodal_stiffness(self) {
        let Self { gel, loads, blocks: Some(blocks), stiffness, stiffened } = self else { return };
        for load in loads {
            let (block, behind) = (load.slot / SLOTS, gel.loads.facets[load.facet].behind);
            // A sweep leaves out the load stiffness of the tick before.
            let (is_at_rest, was_swept) = (!blocks.all[block].is_moving(), blocks.all[block].report.is_some());
            if stiffness[load.slot] == load.before && !(is_at_rest && was_swept) {
                continue;
            }
            stiffened.push(block);
            if is_at_rest {
                gel.potential.nodes(behind).iter().for_each(|node| blocks.request_check_around(node.index()));
            }
        }
        stiffened.sort_unstable();
        stiffened.dedup();
        for block in stiffened.drain(..) {
            let (groups, own) = (blocks.groups_of(block), &blocks.all[block]);
            let part = &mut blocks.parts[own.first..own.first + own.nodes.len()];
            blocks.lanes.sum_stiffness(groups, &stiffness[block * SLOTS..], part);
        }
    }
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
