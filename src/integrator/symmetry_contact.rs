//! Gel that meets its own image: no node of the surface passes the axis of revolution or a plane of symmetry (numerics 2.9).

use super::contact_solver::TOUCH;
use super::engine::Engine;
use super::gel::SurfaceNode;
use super::kick::Taken;
use super::neighbour_list::STRETCH;
use super::substep::Phase;
use crate::contact::impulse;
use crate::fem::Potential;
use crate::math::{Vector, embed};
use crate::mesh::NodeId;
use crate::state::Tick;

/// A node of the surface that may come to its image until its next tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meeting {
    /// The node.
    pub node: NodeId,
    /// Across which plane its image is.
    axis: usize,
    /// −x/Δt, with which it comes as far as to the plane, m/s; nothing of one that is beyond it: that is only stopped.
    least: f64,
    /// u⁻, its velocity away from the plane before the tick, m/s.
    before: f64,
    /// J so far, away from the plane, N·s.
    impulse: f64,
}

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Finds the active nodes of the surface that may come to their image, ascending: those less than their size from it, or than
    /// twice the way to their next tick.
    pub(super) fn find_meetings(&mut self, tick: Tick) {
        let mut meetings = std::mem::take(&mut self.scratch.meetings);
        meetings.clear();
        if !self.gel.mirrored.is_empty() {
            let (active, surface) = (&self.scratch.active, &self.gel.surface);
            if let Some(few) = active.few() {
                let reached = few.iter().filter_map(|node| surface.of[*node as usize]);
                reached.for_each(|at| meetings.extend(self.meetings_of(&surface.nodes[at as usize], tick)));
                meetings.sort_unstable_by_key(|meeting| (meeting.node, meeting.axis));
            } else {
                // They ascend as they stand.
                let reached = surface.nodes.iter().filter(|at| active.has(at.node.index()));
                reached.for_each(|at| meetings.extend(self.meetings_of(at, tick)));
            }
        }
        self.scratch.meetings = meetings;
    }

    fn meetings_of(&self, at: &SurfaceNode, tick: Tick) -> impl Iterator<Item = Meeting> + '_ {
        let SurfaceNode { node, size, .. } = *at;
        let a = node.index();
        let (x, v) = (self.state.position[a], self.state.velocity[a]);
        // Where the mesh ends there is no step ahead: what is at the plane is held there.
        let is_last = self.phase == Phase::Last;
        let reaches = move |axis: usize| {
            x[axis] < size || x[axis] < STRETCH * size && x[axis] < 2.0 * v[axis].abs() * self.until_next(node, tick)
        };
        let is_there = move |axis: usize| if is_last { x[axis] < TOUCH * size } else { reaches(axis) };
        let meets = move |axis: &usize| !self.gel.held(a)[*axis] && is_there(*axis);
        let meeting = move |axis: usize| {
            let least = if is_last { 0.0 } else { (-x[axis] / self.until_next(node, tick)).min(0.0) };
            Meeting { node, axis, least, before: self.velocity_before(node)[axis], impulse: 0.0 }
        };
        self.gel.mirrored.iter().copied().filter(meets).map(meeting)
    }

    /// From now until the next tick of a node, s.
    fn until_next(&self, node: NodeId, tick: Tick) -> f64 {
        let groups = self.gel.star.of(node).iter().map(|element| self.order.group(*element));
        let ahead = groups.map(|group| self.ahead(group, tick)).filter(|ahead| *ahead > 0);
        ahead.min().map_or(f64::INFINITY, |ahead| self.grid.time(ahead))
    }

    /// One correction of all impulses between nodes and their images; by how much it changes a velocity at most, m/s.
    pub(super) fn meet_all(&mut self) -> f64 {
        (0..self.scratch.meetings.len()).map(|i| self.meet(i)).fold(0.0, f64::max)
    }

    /// One correction of the impulse between a node and its image, which is as heavy and comes as fast: that of a wall at rest; by
    /// how much it changes the velocity, m/s.
    fn meet(&mut self, i: usize) -> f64 {
        let Meeting { node, axis, least, impulse: so_far, .. } = self.scratch.meetings[i];
        let (a, compliance) = (node.index(), 1.0 / self.gel.mass[node.index()]);
        let free = self.state.velocity[a][axis] - compliance * so_far;
        let change = impulse(free, least, compliance) - so_far;
        if change.abs() <= f64::EPSILON * so_far {
            return 0.0;
        }
        self.scratch.meetings[i].impulse += change;
        self.state.velocity[a][axis] += compliance * change;
        compliance * change.abs()
    }

    /// Posts the work of the images, Σ J (u⁻ + u⁺)/2, and their momentum, which is that of what holds the plane.
    pub(super) fn book_meetings(&mut self) {
        let mut taken = Taken::default();
        for Meeting { node, axis, before, impulse, .. } in &self.scratch.meetings {
            let a = node.index();
            self.state.ledger.energy.contact += 0.5 * impulse * (before + self.state.velocity[a][*axis]);
            let push = embed(&Vector::<D>::from_fn(|i, _| if i == *axis { *impulse } else { 0.0 }));
            taken.give(self.freedom(), (embed(&self.state.position[a]), push));
        }
        taken.post(&mut self.state.ledger);
    }
}
