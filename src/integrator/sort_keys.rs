//! Sort keys of patches and nodes: data that are stepped together are adjacent in memory.

use super::element_order::{ElementLayout, SortKey};
use super::stability::{stable_steps, tick_grid};
use super::{DiscreteGel, IntegratorSettings, SteppingSchedule};
use crate::fem::{LANES, Potential};
use crate::mesh::{ElementId, NodeId};
use crate::state::MOST_TICKS;

/// Returns the nodes of a gel at rest in the order in which its elements first refer to them.
///
/// The nodes of a block are then adjacent in memory. Compared with nodes along a space-filling curve a step of 169
/// 200 tetrahedra takes 6 % less time, one of 968 112 takes 4 % less. `None` where a stable step is unusable.
#[must_use]
pub fn node_order<const D: usize, P: Potential<D>>(
    gel: &DiscreteGel<D, P>,
    rules: &IntegratorSettings,
) -> Option<Vec<NodeId>> {
    let stiffness = gel.measure(gel.potential.rest(), &gel.fresh_memory()).stiffness;
    let steps = stable_steps(gel, &stiffness, rules.cfl);
    let (grid, _) = tick_grid(&steps, None).ok()?;
    let order = element_layout(gel, rules, |element| grid.ticks(steps[element.index()]));
    let elements = order.elements(0..order.n_slots());
    let all = (0..gel.mass.len() as u32).map(NodeId);
    let mut is_new = vec![true; gel.mass.len()];
    let referenced = elements.flat_map(|element| gel.potential.nodes(element)).copied().chain(all);
    Some(referenced.filter(|node| std::mem::take(&mut is_new[node.index()])).collect())
}

/// Lays the elements out with patches of equal steps adjacent; in the queue each patch is a group by itself.
pub(super) fn element_layout<const D: usize, P: Potential<D>>(
    gel: &DiscreteGel<D, P>,
    rules: &IntegratorSettings,
    ticks: impl Fn(ElementId) -> f64,
) -> ElementLayout {
    let limit = |patch: usize| {
        let elements = gel.potential.patches().of(patch).iter();
        elements.map(|element| ticks(*element)).fold(f64::INFINITY, f64::min).clamp(1.0, MOST_TICKS as f64)
    };
    let key = |patch: usize| {
        // Patches at the surface are kept apart: contact shortens the steps of whole groups.
        let (limit, is_interior) = (limit(patch), u64::from(is_interior(gel, patch)));
        SortKey { class: 2 * rules.schedule.step(limit) + is_interior, within: octave_eighth(limit) }
    };
    match rules.schedule {
        SteppingSchedule::Bins => ElementLayout::new(&gel.potential, LANES, key),
        SteppingSchedule::Global => ElementLayout::new(&gel.potential, LANES, |_| SortKey::default()),
        SteppingSchedule::Queue => ElementLayout::new(&gel.potential, 1, |_| SortKey::default()),
    }
}

/// Returns the octave of a positive number and the eighth of it: sign, exponent and three bits of the mantissa.
fn octave_eighth(x: f64) -> u64 {
    x.to_bits() >> (f64::MANTISSA_DIGITS - 1 - 3)
}

/// Returns true if no node of a patch is on the surface.
fn is_interior<const D: usize, P: Potential<D>>(gel: &DiscreteGel<D, P>, patch: usize) -> bool {
    let mut nodes = gel.potential.patches().of(patch).iter().flat_map(|element| gel.potential.nodes(*element));
    nodes.all(|node| gel.surface.of[node.index()].is_none())
}

#[cfg(test)]
mod tests {
    use super::super::test_cube;
    use super::*;

    #[test]
    fn node_order_is_idempotent() {
        let mesh = test_cube::mixed();
        let rules = test_cube::rules();
        let order = node_order(&test_cube::gel(&mesh), &rules).expect("steps");
        let all: Vec<NodeId> = (0..mesh.rest.len() as u32).map(NodeId).collect();
        assert_ne!(order, all);
        let gel = test_cube::gel(&mesh.renumbered(&order));
        assert_eq!(node_order(&gel, &rules).expect("steps"), all);
    }

    #[test]
    fn octave_eighth_distinguishes_the_eighths_of_an_octave() {
        assert_eq!(octave_eighth(1.0), octave_eighth(1.124));
        assert_eq!(octave_eighth(1.126), octave_eighth(1.0) + 1);
        assert_eq!(octave_eighth(2.0), octave_eighth(1.0) + 8);
    }
}
