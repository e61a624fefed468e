//! Step size of a patch: the assembled nodal stability rule, hysteresis for longer steps, and limits by contact
//! (method 1.3, 1.4, A7, A8).

use super::element_block::{BlockActivity, ElementBlock};
use super::element_loop::closes;
use super::report::synchronous_until;
use super::stability::{nodal_limit, nodal_step_limit};
use super::step_monitor::{RAISE_MARGIN, StepMonitor};
use super::system::DiscreteSystem;
use super::workspace::{ContactLimit, StepChange};
use super::{DistortionLimits, StepError, SteppingSchedule};
use crate::fem::{ElementBatches, FORESEEN, Potential};
use crate::geometry::{Gap, ShapeGeometry};
use crate::math::{Vector3, embed};
use crate::mesh::{ElementId, NodeId};
use crate::state::{GroupAlarm, GroupClock, Tick};

/// Number of a group's own ticks in a row at which [`RAISE_MARGIN`] must hold. Raising sooner pumps energy:
/// per-update adaptation drifted by up to +18000 % in 400 wave transits, this rule by at most 1.2 % (method 1.4).
const RAISE_PATIENCE: u32 = 64;
/// Depth up to which a surface node may be found in a body at its next tick, in element sizes (method A7).
const MAX_DEPTH: f64 = 0.1;
/// Depth by which a node deeper than [`MAX_DEPTH`] may sink further until its next tick, in element sizes.
const EXTRA_DEPTH: f64 = 0.05;
/// Maximum number of gap queries along a path; the bound proved so far is then taken.
const MAX_QUERIES: usize = 16;

/// Updates the cost of one global stable step up to `tick`: its length is the smallest nodal limit so far.
pub(super) fn count_global_steps<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    limit: f64,
    tick: Tick,
) {
    let limit = system.model.grid.ticks(limit);
    if limit < system.state.record.synchronous.0 {
        system.state.record.synchronous = (limit, tick, synchronous_until(system, tick as f64));
    }
}

/// Ends the cost of one global stable step on this mesh at its last tick.
pub(super) fn end_global_steps<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    let length = system.state.record.synchronous.0;
    system.state.record.synchronous = (length, tick, synchronous_until(system, tick as f64));
}

/// Returns the stable step of a group, ticks.
pub(super) fn group_limit<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, group: usize) -> f64 {
    let elements = system.model.layout.elements(system.model.layout.slots(group));
    system.model.grid.ticks(least_limit(system, elements.flat_map(|element| system.model.gel.potential.nodes(element))))
}

/// Returns the least limit of these nodes, s.
fn least_limit<'a, const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    nodes: impl IntoIterator<Item = &'a NodeId>,
) -> f64 {
    nodes.into_iter().map(|node| node_limit(system, *node)).fold(f64::INFINITY, f64::min)
}

/// Collects the active groups whose step may change, ascending: those with a limit below or far above the step,
/// with a hold count, or near a body.
pub(super) fn groups_to_check<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    tick: Tick,
) -> Vec<u32> {
    let mut groups = std::mem::take(&mut system.workspace.active_groups);
    if system.blocks.is_some() {
        groups.clear();
        check_blocks(system, tick, &mut groups);
        add_inverting_groups(system, tick, &mut groups);
        add_groups_near_contact(system, tick, &mut groups);
        groups.sort_unstable();
        groups.dedup();
    }
    groups
}

/// Adds the active groups of watched blocks whose step may change.
fn check_blocks<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick, groups: &mut Vec<u32>) {
    let Some(blocks) = &mut system.blocks else { return };
    let (mut all, mut monitors) = (std::mem::take(&mut blocks.all), std::mem::take(&mut blocks.monitors));
    let mut limits = std::mem::take(&mut system.workspace.block_limits);
    for (i, (block, monitor)) in all.iter_mut().zip(&mut monitors).enumerate() {
        let is_watched = monitor.contributes || block.has_active_nodes || block.may_raise_step;
        if block.activity == BlockActivity::Nothing || !is_watched || monitor.holds_steps() {
            continue;
        }
        collect_limits(system, block, monitor.contributes, &mut limits);
        // Inactive groups of a block at rest are not checked.
        let must_wait = block.may_raise_step && block.activity == BlockActivity::Some && !monitor.contributes;
        block.may_raise_step = collect_changeable_groups(system, tick, i, &limits, groups) || must_wait;
        if !block.may_raise_step {
            watch_limits(system, monitor, i, block.nodes.len(), &limits);
        }
    }
    system.workspace.block_limits = limits;
    if let Some(blocks) = &mut system.blocks {
        (blocks.all, blocks.monitors) = (all, monitors);
    }
}

/// Sets up the front of a block, none of whose steps may change now, to watch for limits that could change one.
fn watch_limits<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    monitor: &mut StepMonitor,
    block: usize,
    n_nodes: usize,
    limits: &[f64],
) {
    let Some(blocks) = &system.blocks else { return };
    monitor.watch(n_nodes, blocks.groups_of(block), &blocks.lanes, &system.state.clocks, system.model.grid, limits);
}

/// Adds the active groups of a block whose step may change; returns true if there are any, or if an inactive
/// group has a hold count.
fn collect_changeable_groups<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    tick: Tick,
    block: usize,
    limits: &[f64],
    groups: &mut Vec<u32>,
) -> bool {
    let Some(blocks) = &system.blocks else { return false };
    let (all, before) = (blocks.groups_of(block), groups.len());
    let is_changeable = |group: &usize| may_step_change(system, tick, *group, &blocks.lanes, limits);
    groups.extend(all.clone().filter(is_changeable).map(|group| group as u32));
    groups.len() > before || system.state.clocks[all].iter().any(|clock| clock.calm > 0)
}

/// Returns true if a group is active and its step may change.
fn may_step_change<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    tick: Tick,
    group: usize,
    lanes: &ElementBatches<D>,
    limits: &[f64],
) -> bool {
    let clock = &system.state.clocks[group];
    if !system.model.settings.schedule.is_active(clock.step, tick) {
        return false;
    }
    let mut limit = f64::INFINITY;
    lanes.nodes(group, |number| limit = limit.min(limits[usize::from(number)]));
    let (limit, step) = (system.model.grid.ticks(limit), clock.step as f64);
    clock.step == 0 || limit < step || clock.calm > 0 || (limit.is_finite() && limit >= RAISE_MARGIN * step)
}

/// Collects the limits of the nodes of a block that can have changed, s; infinite for the others. In an awake
/// block all nodes of active groups are active. In a block at rest only nodes that are active through another
/// block can have changed, unless the block may raise a step.
fn collect_limits<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    block: &ElementBlock,
    contributes: bool,
    limits: &mut Vec<f64>,
) {
    limits.clear();
    if block.may_raise_step && !contributes {
        limits.extend(block.nodes.iter().map(|node| node_limit(system, *node)));
        return;
    }
    limits.resize(block.nodes.len(), f64::INFINITY);
    for number in block.active_nodes() {
        let a = block.nodes[number].index();
        if system.workspace.active_nodes.has(a) {
            limits[number] = system.workspace.node_limits[a];
        }
    }
}

/// Returns CFL · 2/√λ_a of any node, s, from Σ κ of the last sweep of each block around it, as the active nodes
/// have it.
fn node_limit<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, node: NodeId) -> f64 {
    if system.workspace.active_nodes.has(node.index()) {
        return system.workspace.node_limits[node.index()];
    }
    let Some(blocks) = &system.blocks else {
        return system.model.settings.cfl
            * nodal_limit(&system.model.gel, &system.state.stiffness, &system.model.layout, node);
    };
    let parts = blocks.node_copies(node.index()).iter().map(|spot| blocks.parts[spot.at as usize][3]);
    system.model.settings.cfl * nodal_step_limit(parts.sum(), system.model.gel.mass[node.index()])
}

/// Adds the active groups in which an element would invert within the present step, if the gel is remeshed. On a
/// mesh that stays, the kick of a whole step throws an inverted element back. In short steps it is found inverted
/// twice in a row, which ends the run: the ball of 20 m/s on cells of 2.5 mm stopped so after 0.9 ms.
fn add_inverting_groups<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    tick: Tick,
    groups: &mut Vec<u32>,
) {
    let Some(blocks) = system.blocks.as_ref().filter(|_| system.can_be_distorted()) else { return };
    let (moment, responses) = (system.tick_context(tick), &system.workspace.responses);
    for (i, _) in blocks.all.iter().enumerate().filter(|(_, block)| block.report.is_some_and(|report| report.closes)) {
        let is_concerned = |group: &usize| {
            let step = system.state.clocks[*group].step;
            moment.is_active(step) && closes(&responses[*group], system.model.grid.time(step))
        };
        groups.extend(blocks.groups_of(i).filter(is_concerned).map(|group| group as u32));
    }
}

/// Returns the time until an element of a group inverts at its present rate, ticks; infinite beyond the
/// look-ahead.
fn time_to_inversion<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    group: usize,
    clock: &GroupClock,
    tick: Tick,
) -> f64 {
    let time = system.model.grid.ticks(1.0 / system.workspace.responses[group].closing);
    let look_ahead = FORESEEN * system.tick_context(tick).elapsed(clock.step) as f64;
    let is_foreseen = system.can_be_distorted() && (clock.step == 0 || time < look_ahead);
    if is_foreseen { time } else { f64::INFINITY }
}

/// Adds the active groups around the nodes close to a body whose step contact shortens, or whose hold count it
/// resets.
fn add_groups_near_contact<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    tick: Tick,
    groups: &mut Vec<u32>,
) {
    for surface in &system.contact.close {
        let Some(index) = system.contact.index_of(*surface) else { continue };
        let nearness = &system.workspace.contact_limits[index];
        let is_concerned = |group: &u32| {
            let clock = &system.state.clocks[*group as usize];
            let is_active = system.model.settings.schedule.is_active(clock.step, tick);
            is_active && (nearness.limit < clock.step as f64 || nearness.is_near && clock.calm > 0)
        };
        groups.extend(system.workspace.surface_stars[*surface as usize].groups.iter().copied().filter(is_concerned));
    }
}

/// Chooses the next tick of each of these active groups, in ascending order, and lists the changed steps. Returns
/// the first group whose stable step is less than a tick: that is a thousandth of the smallest at the start, and
/// the mesh has failed (A11).
pub(super) fn set_clocks<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    groups: &[u32],
    tick: Tick,
) -> Option<StepError> {
    let mut collapsed = None;
    system.workspace.changed_steps.clear();
    for group in groups {
        let (i, was) = (*group as usize, system.state.clocks[*group as usize]);
        let limit = group_limit(system, i);
        if limit < 1.0 && collapsed.is_none() {
            collapsed = Some(collapse_error(system, i, limit, tick));
        }
        let limit = limit.min(time_to_inversion(system, i, &was, tick)).min(held_step(system, i, &was));
        let (step, calm) = apply_hysteresis(system, limit.max(1.0), &was, tick);
        let (step, is_near) = limit_by_contact(system, i, step);
        let clock = &mut system.state.clocks[i];
        (clock.step, clock.calm) = (step, if is_near { 0 } else { calm });
        let moment = system.tick_context(tick);
        if step != was.step {
            let (planned, ahead) = (moment.ahead(was.step), moment.ahead(step));
            system.workspace.changed_steps.push(StepChange { group: *group, planned, ahead });
        }
        if system.model.settings.schedule == SteppingSchedule::Queue {
            // In the queue, patches near contact wait for the common multiples of their steps, so that they are
            // active together.
            system.state.alarms[i] =
                GroupAlarm { last: tick, next: if is_near { (tick / step + 1) * step } else { tick + step } };
        }
    }
    if system.model.settings.schedule == SteppingSchedule::Global {
        equalise_steps(system, tick);
    }
    collapsed
}

/// Returns the step that a group of a new mesh may not exceed at its first tick, ticks: where a mesh is remade often and
/// a little at a time, steps that rose with each mesh would pump energy.
fn held_step<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, group: usize, clock: &GroupClock) -> f64 {
    let Some(birth) = system.state.birth.as_ref().filter(|_| clock.step == 0) else { return f64::INFINITY };
    if !system.clock.ends.distortion.as_ref().is_some_and(DistortionLimits::are_of_edits) {
        return f64::INFINITY;
    }
    let elements = system.model.layout.elements(system.model.layout.slots(group));
    let steps = elements.map(|element| birth.steps[element.index()]);
    system.model.grid.ticks(steps.fold(f64::INFINITY, f64::min))
}

/// Sets all steps to the least one, for the global schedule.
fn equalise_steps<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    if let Some(StepChange { planned, .. }) = system.workspace.changed_steps.first().copied() {
        let ahead = system.state.clocks.iter().map(|clock| clock.step).filter(|step| *step > 0).min().unwrap_or(1);
        system.state.clocks.iter_mut().for_each(|clock| clock.step = ahead);
        system.workspace.changed_steps.clear();
        let all = 0..system.state.clocks.len() as u32;
        system.workspace.changed_steps.extend(all.map(|group| StepChange { group, planned, ahead }));
    }
    system.state.alarms[0] = GroupAlarm { last: tick, next: tick + system.state.clocks[0].step };
}

/// Returns the step collapse of a group, at the element with the least limit.
pub(super) fn collapse_error<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    group: usize,
    limit: f64,
    tick: Tick,
) -> StepError {
    let own = |element: &ElementId| least_limit(system, system.model.gel.potential.nodes(*element));
    let elements = system.model.layout.elements(system.model.layout.slots(group));
    let element = elements.min_by(|a, b| own(a).total_cmp(&own(b))).map_or(0, ElementId::index);
    let (step, time) = (limit * system.model.grid.time(1), system.model.grid.time(tick));
    StepError::StepCollapsed { element, time, step, jacobian: system.workspace.responses[group].least_jacobian }
}

/// Returns the step and the hold count of a group: shortened at once, doubled only when aligned and after a long
/// hold.
fn apply_hysteresis<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    limit: f64,
    clock: &GroupClock,
    tick: Tick,
) -> (Tick, u32) {
    let allowed = system.model.settings.schedule.step(limit);
    if clock.step == 0 || allowed < clock.step {
        return (allowed, 0);
    }
    if limit < RAISE_MARGIN * clock.step as f64 || system.model.settings.schedule == SteppingSchedule::Global {
        return (clock.step, 0);
    }
    let calm = clock.calm.saturating_add(1);
    let is_aligned = system.model.settings.schedule == SteppingSchedule::Queue || tick.is_multiple_of(2 * clock.step);
    if calm >= RAISE_PATIENCE && is_aligned { (2 * clock.step, 0) } else { (clock.step, calm) }
}

/// Limits a step by contact: no surface node may sink deeper into a body than [`MAX_DEPTH`], and patches within
/// an element's size of a body take the shortest step around. Also returns true if the patch is that near.
fn limit_by_contact<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    group: usize,
    step: Tick,
) -> (Tick, bool) {
    let mut limit = step as f64;
    let mut is_near = false;
    let elements = system.model.layout.elements(system.model.layout.slots(group));
    for node in elements.flat_map(|element| system.model.gel.potential.nodes(element)) {
        let Some(surface) = system.model.gel.surface.of[node.index()] else { continue };
        let Some(index) = system.contact.index_of(surface) else { continue };
        let nearness = &system.workspace.contact_limits[index];
        limit = limit.min(nearness.limit);
        is_near |= nearness.is_near;
    }
    let limit = limit.max(1.0);
    let kind = if is_near && system.model.settings.schedule == SteppingSchedule::Queue {
        SteppingSchedule::Bins
    } else {
        system.model.settings.schedule
    };
    (if is_near || limit < step as f64 { kind.step(limit) } else { step }, is_near)
}

/// Finds the contact limits of the steps around each node close to a body.
pub(super) fn find_contact_limits<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let horizon = system.horizon();
    let mut all = std::mem::take(&mut system.workspace.contact_limits);
    all.clear();
    for (index, surface) in system.contact.queried.iter().enumerate() {
        let at = system.model.gel.surface.nodes[*surface as usize];
        let mut nearness = ContactLimit { limit: f64::INFINITY, is_near: false };
        for (body, gap) in
            system.contact.gaps_of(index).iter().enumerate().filter_map(|(body, gap)| Some((body, (*gap)?)))
        {
            let proved = path_limit(system, at.node, at.size, &gap, horizon, body);
            nearness.limit = if proved < horizon { nearness.limit.min(proved) } else { nearness.limit };
            nearness.is_near |= gap.distance < at.size;
        }
        if nearness.is_near {
            nearness.limit = nearness.limit.min(stable_step_around(system, *surface));
        }
        all.push(nearness);
    }
    system.workspace.contact_limits = all;
}

/// Returns the shortest stable step of the elements of a surface node, ticks: with this step all of them are
/// active together.
///
/// It is the stable step and not the present one: a step shortened by contact would spread over the whole contact
/// area, and its finest cell would set every step. A mesh of 1:8 took 16 % more updates then; the depth differed
/// by 0.01 %.
fn stable_step_around<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, surface: u32) -> f64 {
    system.model.grid.ticks(least_limit(system, &system.workspace.surface_stars[surface as usize].nodes))
}

/// Returns the shortest present step of the elements of a surface node, ticks.
pub(super) fn shortest_step_around<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    node: NodeId,
) -> f64 {
    let cached = system.model.gel.surface.of[node.index()]
        .map(|surface| &system.workspace.surface_stars[surface as usize].groups);
    let cached = cached.map_or(&[] as &[u32], Vec::as_slice);
    // A corner of a facet that no body is close to has no cached groups.
    let star = if cached.is_empty() { system.model.gel.star.of(node) } else { &[] };
    let groups = cached
        .iter()
        .map(|group| *group as usize)
        .chain(star.iter().map(|element| system.model.layout.group(*element)));
    let steps = groups.map(|group| system.state.clocks[group].step).filter(|step| *step > 0);
    steps.map(|step| step as f64).fold(f64::INFINITY, f64::min)
}

/// Returns how long the relative path of a node is proved to stay above the allowed depth, ticks; at most
/// `horizon`.
///
/// The node moves straight on, the wrench accelerates the body by at most a, and the body's surface grows at w at
/// most. φ is 1-Lipschitz. From the point of the straight path at s the way is free for (φ + allowed − ½as² −
/// ws)/(|v| + as_end + w), as ½a(s + δ)² − ½as² ≤ as_end δ.
fn path_limit<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    node: NodeId,
    size: f64,
    gap: &Gap,
    horizon: f64,
    body: usize,
) -> f64 {
    let (x, v) = (embed(&system.state.position[node.index()]), embed(&system.velocity_before(node)));
    let (rigid, body) = (&system.model.bodies[body], &system.workspace.bodies_before[body]);
    // A spinning sphere occupies the same place.
    let is_sphere = matches!(rigid.shape, ShapeGeometry::Sphere(_));
    let relative_velocity: Vector3 = v - if is_sphere { body.velocity } else { rigid.velocity_at(body, &x) };
    let end_time = horizon * system.model.grid.time(1);
    let (growth_speed, growth_acceleration) =
        body.bulge.map_or((0.0, 0.0), |bulge| (bulge.max_speed(), bulge.max_acceleration()));
    let half_acceleration = 0.5 * (body.wrench.force.norm() / rigid.mass + growth_acceleration);
    let speed = relative_velocity.norm() + 2.0 * half_acceleration * end_time + growth_speed;
    let allowed = (MAX_DEPTH * size).max(EXTRA_DEPTH * size - gap.distance);
    let (mut proved, mut distance) = (0.0, gap.distance);
    for _ in 0..MAX_QUERIES {
        let clearance = distance + allowed - (half_acceleration * proved + growth_speed) * proved;
        if clearance <= 0.0 {
            break;
        }
        proved += clearance / speed;
        if proved >= end_time || speed == 0.0 {
            return horizon;
        }
        distance = rigid.gap(body, &(x + relative_velocity * proved)).distance;
    }
    system.model.grid.ticks(proved)
}
