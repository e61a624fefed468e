//! Contact points of a tick: surface points inside a body, and surface nodes at their mirror images.

use super::model::DiscreteModel;
use super::substep::{GroupTicks, MeshPhase};
use super::surface_at_tick::SurfaceAtTick;
use super::workspace::NodeStar;
use crate::contact::{
    ContactDetection, ContactPoint, ContactTolerances, SurfaceNode, SurfaceView as _, SymmetryContact,
    symmetry_contacts,
};
use crate::fem::Potential;
use crate::mesh::{ElementId, NodeId};
use crate::state::{ContactRecord, Tick};

/// Contact phase: reads the surface and the clocks, and writes contact points, symmetry contacts and records.
pub(super) struct ContactPhase<'a, const D: usize, P> {
    pub surface: SurfaceAtTick<'a, D, P>,
    pub ticks: GroupTicks<'a>,
    pub surface_stars: &'a [NodeStar],
    /// Depths at which contact acts.
    pub tolerances: ContactTolerances,
    pub contact: &'a mut ContactDetection,
    pub points: &'a mut Vec<ContactPoint<D>>,
    pub symmetry: &'a mut Vec<SymmetryContact>,
    /// Contact record of each body.
    pub records: &'a mut [ContactRecord],
}

impl<const D: usize, P: Potential<D>> ContactPhase<'_, D, P> {
    /// Finds the contact points of a tick, body by body: the active nodes inside it, ascending, then the active facets
    /// that a tip pierces or that are deep inside it.
    pub fn find_contact_points(mut self) {
        self.find_symmetry_contacts();
        let Self { surface, ticks, tolerances, contact, points, records, .. } = &mut self;
        let (bodies, tolerances, DiscreteModel { gel, layout, .. }) = (surface.bodies(), *tolerances, surface.model);
        points.clear();
        contact.find_facets(surface, bodies, tolerances);
        for body in 0..bodies.rigid.len() {
            let is_active = |facet: ElementId| ticks.was_active(layout.group(gel.behind[facet.index()]));
            contact.collect_points(surface, bodies, tolerances, body, is_active, points);
        }
        for point in points.iter() {
            let record = &mut records[point.body];
            record.approach = record.approach.max(-point.approach());
        }
        // At the last tick of a mesh there is no step ahead.
        if ticks.moment.phase != MeshPhase::Last {
            self.set_velocities_ahead();
        }
    }

    /// Sets lead and bias of the contact points, which count the step ahead.
    fn set_velocities_ahead(self) {
        let Self { ref surface, ref ticks, surface_stars, tolerances, points, records, .. } = self;
        let DiscreteModel { settings, grid, .. } = surface.model;
        for point in points {
            let step = grid.time(shortest_step_around(surface, ticks, surface_stars, point.nodes[0]));
            let (rigid, at) = surface.bodies().get(point.body);
            point.lead = point.lead_velocity(rigid, at, step);
            let greatest_approach = records[point.body].approach;
            point.bias = point.bias_velocity(settings.law, tolerances.slop, greatest_approach, step);
        }
    }

    /// Finds the active surface nodes that may reach their image, ascending.
    fn find_symmetry_contacts(&mut self) {
        let Self { surface: view, ticks, symmetry, .. } = self;
        symmetry.clear();
        if view.model.gel.mirrored.is_empty() {
            return;
        }
        let (active, surface) = (view.nodes.active, view.surface());
        if let Some(few) = active.listed_nodes() {
            let listed = few.iter().filter_map(|node| surface.of[*node as usize]);
            listed.for_each(|at| add_symmetry_contacts(view, ticks, &surface.nodes[at as usize], symmetry));
            symmetry.sort_unstable_by_key(|contact| (contact.node, contact.axis));
        } else {
            // Surface nodes are stored in ascending order.
            let all = surface.nodes.iter().filter(|at| active.has(at.node.index()));
            all.for_each(|at| add_symmetry_contacts(view, ticks, at, symmetry));
        }
    }
}

/// Adds the symmetry contacts of a surface node.
fn add_symmetry_contacts<const D: usize, P: Potential<D>>(
    surface: &SurfaceAtTick<'_, D, P>,
    ticks: &GroupTicks<'_>,
    at: &SurfaceNode,
    contacts: &mut Vec<SymmetryContact>,
) {
    let time_ahead = || surface.time_to_next_tick(ticks, at.node);
    let time_ahead = (ticks.moment.phase != MeshPhase::Last).then_some(time_ahead);
    contacts.extend(symmetry_contacts(surface, at, surface.model.gel.mirrored, time_ahead));
}

/// Returns the shortest present step of the elements of a surface node, ticks: every group has one after the
/// first choice of steps, before contact.
fn shortest_step_around<const D: usize, P: Potential<D>>(
    surface: &SurfaceAtTick<'_, D, P>,
    ticks: &GroupTicks<'_>,
    stars: &[NodeStar],
    node: NodeId,
) -> Tick {
    let DiscreteModel { gel, layout, .. } = surface.model;
    let cached = gel.surface.of[node.index()].map(|surface| &stars[surface as usize].groups);
    let cached = cached.map_or(&[] as &[u32], Vec::as_slice);
    // A corner of a facet that no body is close to has no cached groups.
    let star = if cached.is_empty() { gel.star.of(node) } else { &[] };
    let groups = cached.iter().map(|group| *group as usize).chain(star.iter().map(|element| layout.group(*element)));
    groups.map(|group| ticks.clocks[group].step).filter(|step| *step > 0).min().unwrap_or(1)
}
