//! Close pairs: nodes and facets of two leaves that are near contact, and the least distance of the others.

use super::cluster_tree::{ClusterTree, FacetCluster};
use super::facet_foot::FacetFoot;
use super::self_contact::{CONTACT_REACH, contact_size};
use super::surface_motion::{SurfaceMotion, SurfaceStars};
use crate::math::{Vector, Vector3, embed};
use crate::mesh::{ElementId, NodeId};

/// Distance beyond the reach of contact up to which a node and a facet are a close pair, in element sizes.
const SKIN: f64 = 0.3;
/// Owner of close pairs that stay on the list.
const NO_OWNER: u32 = u32::MAX;

/// Node and facet near contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ClosePair {
    /// Pair of leaves that lists them.
    pub owner: u32,
    pub node: NodeId,
    pub facet: ElementId,
    /// Greatest travel of a node of the surface, m, up to which they are out of reach.
    pub quiet_until: f64,
}

/// Distances of the nodes of a leaf to the facets of another; buffers of one search.
#[derive(Debug, Default)]
pub(super) struct LeafDistances {
    facets: Vec<FacetBall>,
}

/// Facet and a ball around it.
#[derive(Debug, Clone, Copy)]
struct FacetBall {
    facet: ElementId,
    corners: [Vector3; 3],
    centre: Vector3,
    radius: f64,
}

impl LeafDistances {
    /// Finds the distances between two leaves, or within one: appends the close pairs, and returns the least distance of
    /// the others less the reach of contact, m; infinite if there are none.
    pub fn find<const D: usize>(
        &mut self,
        (tree, stars): (&ClusterTree, &SurfaceStars),
        [a, b]: [&FacetCluster; 2],
        at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>,
        owner: u32,
        close: &mut Vec<ClosePair>,
    ) -> f64 {
        let room = self.find_to((tree, stars), [a, b], at, owner, close);
        if a.facets == b.facets { room } else { room.min(self.find_to((tree, stars), [b, a], at, owner, close)) }
    }

    /// Finds the distances of the nodes of one leaf to the facets of another.
    fn find_to<const D: usize>(
        &mut self,
        (tree, stars): (&ClusterTree, &SurfaceStars),
        [from, to]: [&FacetCluster; 2],
        at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>,
        owner: u32,
        close: &mut Vec<ClosePair>,
    ) -> f64 {
        self.facets.clear();
        self.facets.extend(tree.facets[to.facets.clone()].iter().map(|facet| FacetBall::new(at, *facet)));
        let mut room = f64::INFINITY;
        for node in &tree.nodes[from.nodes.clone()] {
            let point = embed(&(at.place)(*node));
            for ball in &self.facets {
                let size = contact_size::<D>(at.surface, *node, ball.facet);
                let least = (point - ball.centre).norm() - ball.radius - CONTACT_REACH * size;
                if least >= room || stars.are_neighbours::<D>(at.surface, *node, ball.facet) {
                    continue;
                }
                let own = FacetFoot::new::<D>(&ball.corners, &point).distance - CONTACT_REACH * size;
                if own > SKIN * size {
                    room = room.min(own);
                } else {
                    close.push(ClosePair { owner, node: *node, facet: ball.facet, quiet_until: f64::NEG_INFINITY });
                }
            }
        }
        room
    }
}

/// Leaves the close pairs of an owner on the list for good.
pub(super) fn keep_for_good(owner: u32, close: &mut [ClosePair]) {
    close.iter_mut().filter(|close| close.owner == owner).for_each(|close| close.owner = NO_OWNER);
}

impl FacetBall {
    /// Returns a facet with its ball.
    fn new<const D: usize>(at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>, facet: ElementId) -> Self {
        let corners = at.surface.facets[facet.index()].map(|node| embed(&(at.place)(node)));
        let centre = corners[..D].iter().sum::<Vector3>() / D as f64;
        let radius = corners[..D].iter().map(|corner| (corner - centre).norm_squared()).fold(0.0, f64::max).sqrt();
        Self { facet, corners, centre, radius }
    }
}
