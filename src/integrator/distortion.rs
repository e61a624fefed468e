//! Distortion monitor: decides when a mesh is distorted, with travel bounds that skip elements whose nodes have not
//! moved far enough.

use super::active_set::RUN;
use super::element_block::ElementBlock;
use super::stability::nodal_limit;
use super::substep::{MeshPhase, TickContext};
use super::system::DiscreteSystem;
use crate::fem::{MAX_NODES, Potential, ReferenceShape};
use crate::math::Vector;
use crate::mesh::{CORNERS, NodeId, is_worse, travel_bound};
use crate::state::{SurfaceStretch, Tick};

/// Age below which only a heavily distorted mesh ends, in its finest steps (A12), and the fraction of the limits that
/// applies until then.
const YOUNG_AGE: Tick = 50;
const YOUNG_FRACTION: f64 = 0.7;
/// Least age at which a stretched facet ends a mesh, in its finest steps: at a sharp corner no mesh helps.
const MIN_STRETCHED_AGE: Tick = 200;
/// Returns true if the mesh is distorted at this tick, at an age in its finest steps. Elements are skipped until
/// their nodes have moved far enough.
pub(super) fn is_distorted<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    tick: Tick,
    age: Tick,
) -> bool {
    if system.clock.ends.distortion.is_none() {
        return false;
    }
    if system.state.record.stretch >= SurfaceStretch::Distorted && age >= MIN_STRETCHED_AGE {
        return true;
    }
    if system.contact.neighbours.n_parts() == 0 {
        divide_mesh(system);
    }
    let fraction = if age < YOUNG_AGE { YOUNG_FRACTION } else { 1.0 };
    if is_step_short(system, fraction) {
        return true;
    }
    (0..system.contact.neighbours.n_parts()).any(|block| is_block_distorted(system, block, tick, fraction))
}

/// Returns true if the stable step of an element is below a fraction of its limit. The step of its group is then, too:
/// only the groups of the shortest steps are looked at.
fn is_step_short<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, fraction: f64) -> bool {
    let Some(limits) = &system.clock.ends.distortion else { return false };
    let is_short = |step: Tick| system.model.grid.time(step) < limits.greatest_step;
    if !is_short(system.clock.step_range.0) {
        return false;
    }
    let groups = (0..system.state.clocks.len()).filter(|group| is_short(system.state.clocks[*group].step));
    let mut elements = groups.flat_map(|group| system.model.layout.elements(system.model.layout.slots(group)));
    elements.any(|element| {
        let least = fraction * limits.step[element.index()];
        system.model.gel.potential.nodes(element).iter().any(|node| stable_step(system, *node) < least)
    })
}

/// Returns the stable step of a node, s, by the stiffness of the state: a run that has just been restored knows no other.
pub(super) fn stable_step<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, node: NodeId) -> f64 {
    let (model, stiffness) = (&system.model, &system.state.stiffness);
    model.settings.cfl * nodal_limit(&model.gel, stiffness, &model.layout, node)
}

/// Returns true if an element of a block exceeds a fraction of its limits after half of its step; the reference
/// form has one block. In the second half, neighbours with shorter steps can invert an element before its kick.
/// In the first half, the end of the mesh would take back part of the leading half kick by the changed forces of
/// the element.
fn is_block_distorted<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    block: usize,
    tick: Tick,
    fraction: f64,
) -> bool {
    let groups = match &system.blocks {
        // A block at rest where it was made is not distorted.
        Some(blocks) if !blocks.all[block].is_moving() => return false,
        Some(blocks) => blocks.groups_of(block),
        None => 0..system.state.clocks.len(),
    };
    let (time, end) =
        (system.model.grid.time(tick), TickContext { phase: MeshPhase::Last, ..system.tick_context(tick) });
    let travel = system.contact.neighbours.part_travel(block, time);
    if !system.contact.neighbours.may_part_be_distorted(block, travel) {
        return false;
    }
    for group in groups.clone() {
        let is_owed = end.trailing_half(system.state.clocks[group].step) >= 0.0;
        if is_owed && system.contact.neighbours.may_group_be_distorted(group, travel) {
            let Some(bound) = group_travel_bound(system, group, time, fraction) else { return true };
            system.contact.neighbours.set_group_bound(group, travel + bound);
        }
    }
    system.contact.neighbours.set_part_bound(block, groups);
    false
}

/// Gives each block a travel bound of its own; in the reference form the whole mesh has one.
fn divide_mesh<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let all = || vec![(0..system.state.position.len().div_ceil(RUN) as u32).collect()];
    let parts = system.blocks.as_ref().map_or_else(all, |blocks| blocks.all.iter().map(ElementBlock::runs).collect());
    system.contact.neighbours.set_parts(parts, system.state.clocks.len());
}

/// Returns the travel of its nodes at which an element of a group can be distorted, m; `None` if an element
/// exceeds this fraction of its limits.
fn group_travel_bound<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    group: usize,
    time: f64,
    fraction: f64,
) -> Option<f64> {
    let limits = system.clock.ends.distortion.as_ref()?;
    let mut least = f64::INFINITY;
    for element in system.model.layout.elements(system.model.layout.slots(group)) {
        let (e, nodes) = (element.index(), system.model.gel.potential.nodes(element));
        let mut now = [Vector::<D>::zeros(); MAX_NODES];
        now.iter_mut().zip(nodes).for_each(|(corner, node)| *corner = system.position_at(*node, time));
        let measure = system.model.gel.potential.measure(&now);
        if measure < fraction * limits.least[e] || is_worse(&now, &CORNERS, fraction * limits.quality[e]) {
            return None;
        }
        let rings = system.model.gel.potential.measures_rings();
        let radius = if rings { ReferenceShape::of(&now, &CORNERS).radius } else { f64::INFINITY };
        least = least.min(travel_bound(&now, &CORNERS, (limits.quality[e], limits.least[e] / measure), radius));
    }
    Some(least)
}
