//! Pressure loads on faces of the gel: each loaded facet is kicked at the ticks of the element behind it, as part of
//! that element's energy (method A6). The work of the pressures is booked.

use super::blocks::ElementBlocks;
use super::cavity::{OpenCavity, find_air_load};
use super::cavity_gas::update_gas;
use super::element_order::SLOTS;
use super::load_input::LoadInput;
use super::workspace::{FacetLoad, LoadStiffness, PressureSource};
use super::{DiscreteGel, LoadedFacet};
use crate::fem::{Potential, push};
use crate::math::Vector;
use crate::state::CavityGas;

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
