//! Gaps of the surface to the bodies at a tick, and the limits that they set to the steps around (method A7).

use super::model::DiscreteModel;
use super::step_limits::StepLimits;
use super::surface_at_tick::SurfaceAtTick;
use super::workspace::{ContactLimit, NodeStar};
use crate::contact::{ContactDetection, SurfaceNode, SurfaceView as _};
use crate::fem::Potential;
use crate::geometry::{Gap, ShapeGeometry};
use crate::math::{Vector3, embed};

/// Depth up to which a surface node may be found in a body at its next tick, in element sizes (method A7).
const MAX_DEPTH: f64 = 0.1;
/// Depth by which a node deeper than [`MAX_DEPTH`] may sink further until its next tick, in element sizes.
const EXTRA_DEPTH: f64 = 0.05;
/// Maximum number of gap queries along a path; the bound proved so far is then taken.
const MAX_QUERIES: usize = 16;

/// Gap phase: reads the surface, the bodies and the stable limits, and writes gaps and contact limits.
pub(super) struct GapPhase<'a, const D: usize, P> {
    pub surface: SurfaceAtTick<'a, D, P>,
    pub limits: StepLimits<'a, D, P>,
    /// Longest step that any group can have after this tick, ticks.
    pub horizon: f64,
    pub contact: &'a mut ContactDetection,
    pub surface_stars: &'a mut [NodeStar],
    pub contact_limits: &'a mut Vec<ContactLimit>,
}

impl<const D: usize, P: Potential<D>> GapPhase<'_, D, P> {
    /// Queries φ and n of the active surface nodes to the active bodies, where a body may be within reach.
    pub fn query_gaps(mut self) {
        let DiscreteModel { bodies, grid, .. } = self.surface.model;
        self.contact.begin_tick(self.surface.time(), self.surface.bodies);
        let reach = self.contact.neighbours.reach(bodies, self.horizon * grid.time(1));
        self.find_queried_nodes(reach);
        self.contact.query_gaps(&self.surface, self.surface.bodies(), reach);
        self.collect_stars();
        self.find_contact_limits();
    }

    /// Finds the active surface nodes that need a query, ascending.
    fn find_queried_nodes(&mut self, reach: f64) {
        let (surface, ContactDetection { neighbours, queried, .. }) = (self.surface.surface(), &mut *self.contact);
        if let Some(blocks) = self.limits.blocks {
            return neighbours.append_queries(surface, reach, |node| blocks.is_active(node.index()), queried);
        }
        let active = self.limits.active.reference_nodes().iter().filter_map(|a| surface.of[*a as usize]);
        queried.extend(active.filter(|node| neighbours.needs_query(*node, surface.nodes[*node as usize].size, reach)));
        queried.sort_unstable();
    }

    /// Collects the nodes and groups around each surface node that a body comes close to, once per node.
    fn collect_stars(&mut self) {
        let DiscreteModel { gel, layout, .. } = self.surface.model;
        for surface in &self.contact.close {
            let star = &mut self.surface_stars[*surface as usize];
            if star.nodes.is_empty() {
                let around = || gel.star.of(gel.surface.nodes[*surface as usize].node).iter();
                star.nodes = distinct(around().flat_map(|element| gel.potential.nodes(*element)).copied());
                star.groups = distinct(around().map(|element| layout.group(*element) as u32));
            }
        }
    }

    /// Finds the contact limits of the steps around each node close to a body.
    fn find_contact_limits(self) {
        let Self { ref surface, ref limits, horizon, contact, surface_stars, contact_limits } = self;
        contact_limits.clear();
        for (index, queried) in contact.queried.iter().enumerate() {
            let at = surface.surface().nodes[*queried as usize];
            let mut nearness = ContactLimit { limit: f64::INFINITY, is_near: false };
            for (body, gap) in contact.gaps_of(index).iter().enumerate().filter_map(|(body, gap)| Some((body, (*gap)?)))
            {
                let proved = path_limit(surface, &at, &gap, horizon, body);
                nearness.limit = if proved < horizon { nearness.limit.min(proved) } else { nearness.limit };
                nearness.is_near |= gap.distance < at.size;
            }
            if nearness.is_near {
                // The shortest stable step of the elements around, ticks: with it all of them are active together.
                //
                // It is the stable step and not the present one: a step shortened by contact would spread over the
                // whole contact area, and its finest cell would set every step. A mesh of 1:8 took 16 % more updates
                // then; the depth differed by 0.01 %.
                let stable = limits.least(&surface_stars[*queried as usize].nodes);
                nearness.limit = nearness.limit.min(surface.model.grid.ticks(stable));
            }
            contact_limits.push(nearness);
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

/// Returns how long the relative path of a node is proved to stay above the allowed depth, ticks; at most
/// `horizon`.
///
/// The node moves straight on, the wrench accelerates the body by at most a, and the body's surface grows at w at
/// most. φ is 1-Lipschitz. From the point of the straight path at s the way is free for (φ + allowed − ½as² −
/// ws)/(|v| + as_end + w), as ½a(s + δ)² − ½as² ≤ as_end δ.
fn path_limit<const D: usize, P: Potential<D>>(
    surface: &SurfaceAtTick<'_, D, P>,
    at: &SurfaceNode,
    gap: &Gap,
    horizon: f64,
    body: usize,
) -> f64 {
    let (x, v) = (embed(&surface.position(at.node)), embed(&surface.velocity_before(at.node)));
    let (grid, (rigid, body)) = (surface.model.grid, surface.bodies().get(body));
    // A spinning sphere occupies the same place.
    let is_sphere = matches!(rigid.shape, ShapeGeometry::Sphere(_));
    let relative_velocity: Vector3 = v - if is_sphere { body.velocity } else { rigid.velocity_at(body, &x) };
    let end_time = horizon * grid.time(1);
    let (growth_speed, growth_acceleration) =
        body.shape_motion.map_or((0.0, 0.0), |shape| (shape.max_speed(), shape.max_acceleration()));
    let half_acceleration = 0.5 * (body.wrench.force.norm() / rigid.mass + growth_acceleration);
    let speed = relative_velocity.norm() + 2.0 * half_acceleration * end_time + growth_speed;
    let allowed = (MAX_DEPTH * at.size).max(EXTRA_DEPTH * at.size - gap.distance);
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
    grid.ticks(proved)
}
