//! Contact detection: the surface nodes and facets near bodies, and the contact points of a tick (method 2.3, 2.6).

use super::facet::{DeepestPoint, distance_lower_bound};
use super::facet_candidate::{BodyOfSearch, FacetCandidate, NearFacet};
use super::neighbour_list::{NeighbourList, STRETCH};
use super::point::{ContactCarriers, ContactPoint, TickBodies};
use super::surface::{ContactSurface, SurfaceNode, SurfaceView};
use super::tip::{TipPenetration, pole_lines};
use super::tolerance::{ContactTolerances, TOUCH_TOLERANCE};
use super::{BodyState, RigidBody};
use crate::geometry::{Gap, SignedDistance as _};
use crate::math::{Vector3, embed, least};
use crate::mesh::ElementId;

/// Fraction of the allowed facet depth below which a facet needs no query; it is below 1 by more than rounding.
const DEPTH_FRACTION: f64 = 0.999;

/// Contact detection of a surface: its neighbour list, and what the queries of this tick have found.
///
/// A tick goes [`Self::begin_tick`], [`Self::query_gaps`], [`Self::find_facets`], [`Self::collect_points`]. Gaps and
/// facets stay those of the last tick until they are found anew.
#[derive(Debug)]
pub(crate) struct ContactDetection {
    pub neighbours: NeighbourList,
    /// True if the neighbour list knows the last event of every body.
    pub knows_bodies: bool,
    /// Active surface nodes that may be near a body, ascending.
    pub queried: Vec<u32>,
    /// Queried nodes that a body may reach before their next tick or that are within an element size of one.
    pub close: Vec<u32>,
    /// Facets that reach to a body, body by body.
    pub facets: Vec<FacetCandidate>,
    /// Index in `queried` of each surface node.
    place: Vec<u32>,
    /// Gap φ and normal n of each queried node to each body, if it is active.
    gaps: Vec<Option<Gap>>,
    n_bodies: usize,
    /// Facets at queried nodes near a body.
    near: Vec<NearFacet>,
    /// Index of each facet in `near`, counted from 1, while these are found; else 0.
    near_index: Vec<u32>,
}

impl ContactDetection {
    /// Creates the detection of a surface.
    pub fn new(neighbours: NeighbourList, surface: &ContactSurface) -> Self {
        let place = vec![u32::MAX; surface.nodes.len()];
        Self {
            neighbours,
            knows_bodies: false,
            queried: vec![],
            close: vec![],
            facets: vec![],
            place,
            gaps: vec![],
            n_bodies: 0,
            near: vec![],
            near_index: vec![0; surface.facets.len()],
        }
    }

    /// Begins a tick at a time, s, with the bodies at that time: no node is queried yet.
    pub fn begin_tick(&mut self, time: f64, bodies: &[BodyState]) {
        for surface in self.queried.drain(..) {
            self.place[surface as usize] = u32::MAX;
        }
        self.follow_bodies(time, bodies);
    }

    /// Moves the bodies of the neighbour list to a time, s.
    pub fn follow_bodies(&mut self, time: f64, bodies: &[BodyState]) {
        self.neighbours.go_on(time, bodies);
        self.knows_bodies = true;
    }

    /// Queries the gaps of the nodes listed in `queried` to each active body, and lists those close to a body: within
    /// their size or the `reach` of a body in a step, m.
    pub fn query_gaps<const D: usize>(&mut self, surface: &impl SurfaceView<D>, bodies: TickBodies<'_>, reach: f64) {
        let n = bodies.rigid.len();
        self.n_bodies = n;
        self.gaps.clear();
        self.close.clear();
        for (index, queried) in self.queried.iter().enumerate() {
            let SurfaceNode { node, size, .. } = surface.surface().nodes[*queried as usize];
            let point = embed(&surface.position(node));
            let all = bodies.rigid.iter().zip(bodies.at);
            self.gaps.extend(all.map(|(rigid, body)| body.active.then(|| rigid.gap(body, &point))));
            let nearest = self.gaps[index * n..].iter().flatten().map(|gap| gap.distance).fold(f64::INFINITY, f64::min);
            self.neighbours.set_gap(*queried, nearest);
            if nearest < size.max(reach) {
                self.close.push(*queried);
            }
            self.place[*queried as usize] = index as u32;
        }
    }

    /// Returns the index of a surface node among the queried ones, if it is one of them.
    #[inline]
    pub fn index_of(&self, surface: u32) -> Option<usize> {
        Some(self.place[surface as usize]).filter(|place| *place != u32::MAX).map(|place| place as usize)
    }

    /// Returns φ and n of a queried node to each body, by its index.
    #[inline]
    pub fn gaps_of(&self, index: usize) -> &[Option<Gap>] {
        &self.gaps[index * self.n_bodies..][..self.n_bodies]
    }

    /// Returns φ and n of a queried node to one body.
    #[inline]
    fn gap(&self, index: usize, body: usize) -> Option<Gap> {
        self.gaps[index * self.n_bodies + body]
    }

    /// Finds the facets between the queried nodes and a body, each once.
    pub fn find_facets<const D: usize>(
        &mut self,
        surface: &impl SurfaceView<D>,
        bodies: TickBodies<'_>,
        tolerances: ContactTolerances,
    ) {
        self.update_facet_bounds(surface, bodies, tolerances);
        self.facets.clear();
        for (index, (rigid, at)) in bodies.rigid.iter().zip(bodies.at).enumerate() {
            self.find_near_facets(surface, index);
            if self.near.is_empty() {
                continue;
            }
            let body = BodyOfSearch { index, rigid, at, poles: pole_lines(rigid, at) };
            let candidate =
                |near: &NearFacet| FacetCandidate::new::<D>(near, facet_corners(surface, near.facet), &body);
            self.facets.extend(self.near.iter().filter_map(candidate));
        }
    }

    /// Finds the facets at the queried nodes near a body, ascending.
    fn find_near_facets<const D: usize>(&mut self, surface: &impl SurfaceView<D>, body: usize) {
        let Self { neighbours, queried, gaps, n_bodies, near, near_index, .. } = self;
        near.clear();
        for (index, queried) in queried.iter().enumerate() {
            let SurfaceNode { node, size, .. } = surface.surface().nodes[*queried as usize];
            let is_near = |gap: &Gap| gap.distance < STRETCH * size && neighbours.needs_facet_query(*queried);
            let Some(Gap { distance, .. }) = gaps[index * *n_bodies + body].filter(is_near) else { continue };
            for facet in surface.surface().around.of(node) {
                let index = &mut near_index[facet.index()];
                if *index == 0 {
                    near.push(NearFacet { facet: *facet, distance, least_size: size, greatest_size: size });
                    *index = near.len() as u32;
                    continue;
                }
                let near = &mut near[*index as usize - 1];
                near.distance = near.distance.min(distance);
                near.least_size = near.least_size.min(size);
                near.greatest_size = near.greatest_size.max(size);
            }
        }
        for near in near.iter() {
            near_index[near.facet.index()] = 0;
        }
        near.sort_unstable_by_key(|near| near.facet);
    }

    /// Updates around the queried nodes how far anything may travel before their facets need a query.
    fn update_facet_bounds<const D: usize>(
        &mut self,
        surface: &impl SurfaceView<D>,
        bodies: TickBodies<'_>,
        tolerances: ContactTolerances,
    ) {
        for (index, queried) in self.queried.iter().enumerate() {
            if self.neighbours.needs_facet_query(*queried) {
                let node = surface.surface().nodes[*queried as usize].node;
                let gaps = self.gaps_of(index).iter().flatten();
                let nearest = gaps.map(|gap| gap.distance).fold(f64::INFINITY, f64::min);
                let around = surface.surface().around.of(node).iter();
                let mut clearances = around.map(|facet| facet_clearance(surface, bodies, tolerances, *facet, nearest));
                // One facet without clearance is enough.
                let further = |so_far: f64, next: f64| if next > 0.0 { Ok(least(so_far, next)) } else { Err(next) };
                let clearance = clearances.try_fold(f64::INFINITY, further).unwrap_or_else(|none| none);
                self.neighbours.set_facet_bound(*queried, clearance);
            }
        }
    }

    /// Adds the contact points of one body: the queried nodes inside it, ascending, then the facets that a tip pierces
    /// or that are deep inside it, if they are active.
    pub fn collect_points<const D: usize>(
        &self,
        surface: &impl SurfaceView<D>,
        bodies: TickBodies<'_>,
        tolerances: ContactTolerances,
        body: usize,
        is_active: impl Fn(ElementId) -> bool,
        points: &mut Vec<ContactPoint<D>>,
    ) {
        for (index, queried) in self.queried.iter().enumerate() {
            let SurfaceNode { node, size, .. } = surface.surface().nodes[*queried as usize];
            let is_inside = |gap: &Gap| gap.distance <= TOUCH_TOLERANCE * size;
            let Some(gap) = self.gap(index, body).filter(is_inside) else { continue };
            let point = embed(&surface.position(node));
            let carriers = ContactCarriers { nodes: &[node], weights: [1.0, 0.0, 0.0], size, point };
            points.extend(ContactPoint::new(surface, bodies, &carriers, &gap, body));
        }
        for candidate in self.facets.iter().filter(|candidate| candidate.body == body && is_active(candidate.facet)) {
            points.extend(facet_contact(surface, bodies, tolerances, candidate));
        }
    }
}

/// Returns the contact point of a facet at a tip of the body or where the facet is deepest.
fn facet_contact<const D: usize>(
    surface: &impl SurfaceView<D>,
    bodies: TickBodies<'_>,
    tolerances: ContactTolerances,
    candidate: &FacetCandidate,
) -> Option<ContactPoint<D>> {
    let FacetCandidate { body, facet, greatest_size: size, .. } = *candidate;
    let nodes = &surface.surface().facets[facet.index()][..D];
    let (rigid, at) = bodies.get(body);
    let tip = candidate.penetration.filter(|tip| tip.is_deep(size, rigid, at));
    let (point, weights, gap) = if let Some(tip) = tip {
        let TipPenetration { point, weights, gap, .. } = tip;
        (point, weights, gap)
    } else {
        let allowed = tolerances.facet_depth * size.min(rigid.shape.inner_radius());
        let DeepestPoint { point, weights, gap } = candidate.deepest_point::<D>(allowed, rigid, at)?;
        (point, weights, gap)
    };
    // The facet is only stopped, its penetration is not removed. Removal at a pointed tip pumps energy, up to 26 % of
    // the impact energy (a sharp ogive of 10 mm on cells of 6.7 mm).
    let without_depth = Gap { distance: 0.0, ..gap };
    ContactPoint::new(surface, bodies, &ContactCarriers { nodes, weights, size, point }, &without_depth, body)
}

/// Returns how far anything may travel before a facet with a body at distance d from a corner needs a query, m.
///
/// For blunt bodies it is the travel until the facet can reach the allowed depth, as the least φ on it falls by at most
/// the travel s. For other bodies a facet needs no query while d exceeds twice its length l, as no corner is then nearer
/// than d − l ≥ l. d falls by at most s, and l grows by at most 2s.
fn facet_clearance<const D: usize>(
    surface: &impl SurfaceView<D>,
    bodies: TickBodies<'_>,
    tolerances: ContactTolerances,
    facet: ElementId,
    distance: f64,
) -> f64 {
    if !bodies.rigid.iter().all(|body| body.shape.is_blunt()) {
        return (distance - 2.0 * longest_edge(surface, facet)) / 5.0;
    }
    let (corners, nodes) = (facet_corners(surface, facet), &surface.surface().facets[facet.index()][..D]);
    let size = nodes.iter().filter_map(|node| surface.surface().size(*node)).fold(f64::INFINITY, f64::min);
    let depth = |(rigid, at): (&RigidBody, &BodyState)| {
        let allowed = tolerances.facet_depth * size.min(rigid.shape.inner_radius());
        distance_lower_bound::<D>(&corners, |x| rigid.gap(at, x)) + DEPTH_FRACTION * allowed
    };
    bodies.active().map(depth).fold(f64::INFINITY, least)
}

/// Returns the positions of the corners of a facet at this tick, m.
pub(crate) fn facet_corners<const D: usize>(surface: &impl SurfaceView<D>, facet: ElementId) -> [Vector3; 3] {
    surface.surface().facets[facet.index()].map(|node| embed(&surface.drifted(node)))
}

/// Returns the length of the longest edge of a facet at this tick, m.
fn longest_edge<const D: usize>(surface: &impl SurfaceView<D>, facet: ElementId) -> f64 {
    let corners = facet_corners(surface, facet);
    (0..D).map(|i| (corners[(i + 1) % D] - corners[i]).norm()).fold(0.0, f64::max)
}
