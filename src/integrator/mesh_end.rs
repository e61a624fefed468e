//! End of a mesh: by distortion, on time, by a step collapse or a leak (method A12).

use super::distortion::{is_distorted, stable_step};
use super::system::DiscreteSystem;
use super::{StepError, SteppingSchedule};
use crate::fem::Potential;
use crate::math::{Vector3, embed};
use crate::mesh::{ElementId, NodeId};
use crate::state::{GroupClock, SurfaceStretch, Tick};

/// Least age of a mesh, in its finest steps, unless a step collapses or the surface leaks (A12).
const MIN_AGE: Tick = 4;

/// Returns the step collapse or leak that has ended a mesh younger than [`MIN_AGE`]: a new mesh would fail just as soon. Its
/// age is measured here in the finest step with which it began.
pub(super) fn early_failure<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>) -> Option<&StepError> {
    let is_young = ((system.last_tick() - system.clock.origin) as f64) < MIN_AGE as f64 * system.clock.initial_steps.0;
    let ends_at_once =
        |failure: &&StepError| matches!(failure, StepError::StepCollapsed { .. } | StepError::Leak { .. });
    system.clock.failure.as_ref().filter(|failure| is_young && ends_at_once(failure))
}

/// Returns the next tick at or after which this mesh ends.
pub(super) fn next_remesh_tick<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>) -> Option<Tick> {
    system.clock.ends.at.iter().copied().find(|due| *due > system.clock.origin)
}

/// Returns true if the mesh ends at this tick: by collapse or leak at once, by distortion from [`MIN_AGE`] on, and on time only
/// where all steps end, so that none is cut short.
pub(super) fn is_over<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) -> bool {
    if system.state.now.is_none() || system.model.settings.schedule == SteppingSchedule::Queue {
        return false;
    }
    let age = (tick - system.clock.origin) / system.clock.step_range.0;
    let is_due = || next_remesh_tick(system).is_some_and(|due| due <= tick);
    let is_whole = system.model.settings.schedule.is_active(system.clock.step_range.1, tick);
    age >= MIN_AGE && (is_whole && is_due() || is_distorted(system, tick, age))
        || has_collapsed(system)
        || has_leaked(system)
}

/// Returns true if the surface leaked at the last tick.
fn has_leaked<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>) -> bool {
    system.can_be_distorted() && system.state.record.stretch == SurfaceStretch::Leaking
}

/// Returns true if the stable step of a group is shorter than a tick, by the stiffness at the last ticks of its
/// nodes. It tests element by element before a tick; `StepLimits::find_collapse` tests block by block after the sweep.
/// Roundings may differ between the two, and either ends the mesh.
fn has_collapsed<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>) -> bool {
    let (layout, groups) = (&system.model.layout, finest_groups(system.clock.step_range.0, &system.state.clocks));
    let mut elements = groups.flat_map(|group| layout.elements(layout.slots(group)));
    system.can_be_distorted()
        && elements
            .any(|element| system.model.gel.potential.nodes(element).iter().any(|node| is_step_short(system, *node)))
}

/// Returns true if the stable step at a node is shorter than a tick.
fn is_step_short<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, node: NodeId) -> bool {
    system.model.grid.ticks(stable_step(system, node)) < 1.0
}

/// Iterates over the nodes whose stable step is shorter than a tick, and gives the stiffest element around each.
pub(super) fn stepless<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
) -> impl Iterator<Item = ElementId> + '_ {
    let stiffness = |element: &ElementId| system.state.stiffness[system.model.layout.slot(*element)];
    let stiffest = move |node: NodeId| {
        system.model.gel.star.of(node).iter().copied().max_by(|a, b| stiffness(a).total_cmp(&stiffness(b)))
    };
    (0..system.model.gel.mass.len() as u32).map(NodeId).filter(|node| is_step_short(system, *node)).filter_map(stiffest)
}

/// Returns the positions of the corners of the first such element, m.
pub(super) fn stepless_corners<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>) -> Vec<Vector3> {
    let nodes = stepless(system).next().map_or(&[][..], |element| system.model.gel.potential.nodes(element));
    nodes.iter().map(|node| embed(&system.state.position[node.index()])).collect()
}

/// Iterates over the groups whose step is one tick, the shortest possible; none if `least`, the shortest of all, is longer.
pub(super) fn finest_groups(least: Tick, clocks: &[GroupClock]) -> impl Iterator<Item = usize> + '_ {
    let all = if least == 1 { clocks } else { &[] };
    all.iter().enumerate().filter(|(_, clock)| clock.step == 1).map(|(group, _)| group)
}
