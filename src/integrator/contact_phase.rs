//! Contact of a tick: what contact sees of the gel, the contact points, their impulses and the accounts of these.

use super::DiscreteGel;
use super::clock::MeshClock;
use super::model::DiscreteModel;
use super::step_size::{find_contact_limits, shortest_step_around};
use super::substep::MeshPhase;
use super::system::DiscreteSystem;
use super::workspace::Workspace;
use crate::contact::{
    ContactProblem, ContactSurface, ContactTolerances, SurfaceNode, SurfaceView, SymmetryContact, TickBodies,
    symmetry_contacts,
};
use crate::fem::Potential;
use crate::math::Vector;
use crate::mesh::{ElementId, NodeId};
use crate::state::{DynamicState, Tick};

/// Surface of the gel at a tick, as contact sees it.
pub(super) struct SurfaceAtTick<'a, const D: usize, P> {
    model: &'a DiscreteModel<D, P>,
    state: &'a DynamicState<D>,
    clock: &'a MeshClock,
    workspace: &'a Workspace<D>,
    /// Time of the tick, s.
    time: f64,
}

impl<'a, const D: usize, P> SurfaceAtTick<'a, D, P> {
    /// Returns the surface of a system.
    pub fn of(system: &'a DiscreteSystem<D, P>) -> Self {
        Self::new(&system.model, &system.state, &system.clock, &system.workspace)
    }

    /// Views the parts of a system.
    fn new(
        model: &'a DiscreteModel<D, P>,
        state: &'a DynamicState<D>,
        clock: &'a MeshClock,
        workspace: &'a Workspace<D>,
    ) -> Self {
        Self { model, state, clock, workspace, time: workspace.bodies_before[0].time }
    }

    /// Returns the bodies before the impulses of the tick.
    pub fn bodies(&self) -> TickBodies<'a> {
        TickBodies { fixed: &self.model.bodies, at: &self.workspace.bodies_before }
    }
}

impl<const D: usize, P: Potential<D>> SurfaceView<D> for SurfaceAtTick<'_, D, P> {
    type Masses = DiscreteGel<D, P>;

    #[inline]
    fn masses(&self) -> &DiscreteGel<D, P> {
        &self.model.gel
    }

    #[inline]
    fn surface(&self) -> &ContactSurface {
        &self.model.gel.surface
    }

    #[inline]
    fn position(&self, node: NodeId) -> Vector<D> {
        self.state.position[node.index()]
    }

    #[inline]
    fn drifted(&self, node: NodeId) -> Vector<D> {
        let last = self.model.grid.time(self.clock.last_ticks[node.index()]);
        self.state.drifted(node.index(), self.time - last)
    }

    #[inline]
    fn velocity(&self, node: NodeId) -> Vector<D> {
        self.state.velocity[node.index()]
    }

    #[inline]
    fn velocity_before(&self, node: NodeId) -> Vector<D> {
        self.workspace.velocity_before(node, &self.state.velocity)
    }
}

/// Queries φ and n of the active surface nodes to the active bodies, where a body may be within reach.
pub(super) fn query_gaps<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    system.contact.begin_tick(system.model.grid.time(tick), &system.workspace.bodies_before);
    let horizon = system.horizon() * system.model.grid.time(1);
    let reach = system.contact.neighbours.reach(&system.model.bodies, horizon);
    find_queried_nodes(system, reach);
    let DiscreteSystem { model, state, clock, contact, workspace, .. } = system;
    let surface = SurfaceAtTick::new(model, state, clock, workspace);
    contact.query_gaps(&surface, surface.bodies(), reach);
    collect_stars(system);
    find_contact_limits(system);
}

/// Finds the active surface nodes that need a query, ascending.
fn find_queried_nodes<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, reach: f64) {
    let (surface, contact) = (&system.model.gel.surface, &mut system.contact);
    let (neighbours, queried) = (&mut contact.neighbours, &mut contact.queried);
    if let Some(blocks) = &system.blocks {
        return neighbours.append_queries(surface, reach, |node| blocks.is_active(node.index()), queried);
    }
    let active = system.workspace.active_nodes.reference_nodes().iter().filter_map(|a| surface.of[*a as usize]);
    queried.extend(active.filter(|node| neighbours.needs_query(*node, surface.nodes[*node as usize].size, reach)));
    queried.sort_unstable();
}

/// Collects the nodes and groups around each surface node that a body comes close to, once per node.
fn collect_stars<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let (gel, layout, workspace) = (&system.model.gel, &system.model.layout, &mut system.workspace);
    for surface in &system.contact.close {
        let star = &mut workspace.surface_stars[*surface as usize];
        if star.nodes.is_empty() {
            let around = || gel.star.of(gel.surface.nodes[*surface as usize].node).iter();
            star.nodes = distinct(around().flat_map(|element| gel.potential.nodes(*element)).copied());
            star.groups = distinct(around().map(|element| layout.group(*element) as u32));
        }
    }
}

/// Returns the distinct items in ascending order.
fn distinct<T: Ord>(all: impl Iterator<Item = T>) -> Vec<T> {
    let mut all: Vec<T> = all.collect();
    all.sort_unstable();
    all.dedup();
    all.shrink_to_fit();
    all
}

/// Finds the contact points of a tick, body by body: the active nodes inside it, ascending, then the active facets that
/// a tip pierces or that are deep inside it.
pub(super) fn find_contact_points<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    find_symmetry_contacts(system, tick);
    let mut points = std::mem::take(&mut system.workspace.contact_points);
    points.clear();
    let tolerances = tolerances(system);
    let DiscreteSystem { model, state, clock, contact, workspace, .. } = system;
    let surface = SurfaceAtTick::new(model, state, clock, workspace);
    contact.find_facets(&surface, surface.bodies(), tolerances);
    for body in 0..system.model.bodies.len() {
        let surface = SurfaceAtTick::of(system);
        let is_active = |facet: ElementId| system.was_active(system.model.gel.behind[facet.index()], tick);
        system.contact.collect_points(&surface, surface.bodies(), tolerances, body, is_active, &mut points);
    }
    for point in &points {
        let contact = &mut system.state.record.contacts[point.body];
        contact.approach = contact.approach.max(-point.approach());
    }
    // At the last tick of a mesh there is no step ahead.
    for point in points.iter_mut().filter(|_| system.clock.phase != MeshPhase::Last) {
        let step = system.model.grid.time(shortest_step_around(system, point.nodes[0]) as Tick);
        let (rigid, at) = (&system.model.bodies[point.body], &system.workspace.bodies_before[point.body]);
        point.lead = point.lead_velocity(rigid, at, step);
        let greatest_approach = system.state.record.contacts[point.body].approach;
        point.bias = point.bias_velocity(system.model.settings.law, tolerances.slop, greatest_approach, step);
    }
    system.workspace.contact_points = points;
}

/// Returns the depths at which contact acts.
fn tolerances<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>) -> ContactTolerances {
    ContactTolerances::new(D == 3 && system.can_be_distorted() && system.model.gel.potential.remembers())
}

/// Finds the active surface nodes that may reach their image, ascending.
fn find_symmetry_contacts<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    let mut contacts = std::mem::take(&mut system.workspace.symmetry_contacts);
    contacts.clear();
    if !system.model.gel.mirrored.is_empty() {
        let (active, surface) = (&system.workspace.active_nodes, &system.model.gel.surface);
        if let Some(few) = active.listed_nodes() {
            let listed = few.iter().filter_map(|node| surface.of[*node as usize]);
            listed.for_each(|at| add_symmetry_contacts(system, &surface.nodes[at as usize], tick, &mut contacts));
            contacts.sort_unstable_by_key(|contact| (contact.node, contact.axis));
        } else {
            // Surface nodes are stored in ascending order.
            let all = surface.nodes.iter().filter(|at| active.has(at.node.index()));
            all.for_each(|at| add_symmetry_contacts(system, at, tick, &mut contacts));
        }
    }
    system.workspace.symmetry_contacts = contacts;
}

/// Adds the symmetry contacts of a surface node.
fn add_symmetry_contacts<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    at: &SurfaceNode,
    tick: Tick,
    contacts: &mut Vec<SymmetryContact>,
) {
    let time_ahead = || time_to_next_tick(system, at.node, tick);
    let time_ahead = (system.clock.phase != MeshPhase::Last).then_some(time_ahead);
    let (surface, axes) = (SurfaceAtTick::of(system), system.model.gel.mirrored);
    contacts.extend(symmetry_contacts(&surface, at, axes, time_ahead));
}

/// Returns the time until the next tick of a node, s.
pub(super) fn time_to_next_tick<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    node: NodeId,
    tick: Tick,
) -> f64 {
    let groups = system.model.gel.star.of(node).iter().map(|element| system.model.layout.group(*element));
    let ahead = groups.map(|group| system.ahead(group, tick)).filter(|ahead| *ahead > 0);
    ahead.min().map_or(f64::INFINITY, |ahead| system.model.grid.time(ahead))
}

/// Returns the contact problem of this tick.
fn contact_problem<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
) -> ContactProblem<'_, D, DiscreteGel<D, P>> {
    let DiscreteSystem { model, state, workspace, .. } = system;
    ContactProblem {
        masses: &*model.gel,
        velocity: &mut state.velocity,
        bodies: &model.bodies,
        was: &workspace.bodies_before,
        now: &mut workspace.bodies_after,
        points: &mut workspace.contact_points,
        symmetry: &mut workspace.symmetry_contacts,
        own: &mut workspace.self_contacts,
    }
}

/// Solves Moreau's law with Coulomb friction at all contact points and symmetry contacts.
pub(super) fn solve<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    restitution: f64,
    friction: f64,
) {
    let approaches = system.state.record.contacts.iter().map(|contact| contact.approach);
    let greatest_approach = approaches.fold(0.0, f64::max);
    contact_problem(system).solve(restitution, friction, greatest_approach);
}

/// Applies the paper's reversal law to the nodes of one element after its kick.
pub(super) fn apply_reversal<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, element: ElementId) {
    let gel = system.model.gel.clone();
    contact_problem(system).reverse(gel.potential.nodes(element));
}

/// Corrects the impulses of the gel with its images and with itself once.
pub(super) fn correct_gel_contacts<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    contact_problem(system).correct_gel_contacts();
}
