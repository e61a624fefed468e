//! Close pairs: nodes and facets of two leaves that are near contact, and the least distance of the others.

use super::cluster_tree::{ClusterTree, FacetCluster};
use super::facet_foot::FacetFoot;
use super::self_contact::CONTACT_REACH;
use super::surface_motion::{NodeMotion, SurfaceMotion, SurfaceStars};
use crate::math::{Vector3, embed};
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

/// Search for the close pairs of a surface.
pub(super) struct CloseSearch<'a, N> {
    pub tree: &'a ClusterTree,
    pub stars: &'a SurfaceStars,
    pub at: &'a SurfaceMotion<'a, N>,
    /// Pair of leaves that is to own the close pairs.
    pub owner: u32,
    pub close: &'a mut Vec<ClosePair>,
    /// Buffer.
    pub balls: &'a mut Vec<FacetBall>,
}

/// Facet and a ball around it.
#[derive(Debug, Clone, Copy)]
pub(super) struct FacetBall {
    facet: ElementId,
    corners: [Vector3; 3],
    centre: Vector3,
    radius: f64,
    size: f64,
}

impl<N> CloseSearch<'_, N> {
    /// Lists the close pairs of two leaves, or of one with itself; returns the least distance of the others less the
    /// reach of contact, m; infinite if there are none.
    pub fn find<const D: usize>(&mut self, [a, b]: [usize; 2]) -> f64
    where
        N: NodeMotion<D>,
    {
        let tree = self.tree;
        let room = self.find_from(&tree.clusters[a], &tree.clusters[b]);
        if a == b { room } else { room.min(self.find_from(&tree.clusters[b], &tree.clusters[a])) }
    }

    /// Lists the close pairs of the nodes of one leaf and the facets of another.
    fn find_from<const D: usize>(&mut self, from: &FacetCluster, to: &FacetCluster) -> f64
    where
        N: NodeMotion<D>,
    {
        let (tree, at) = (self.tree, self.at);
        self.balls.clear();
        self.balls.extend(to.facets.clone().map(|i| FacetBall::new(at, tree.facets[i], tree.facet_sizes[i])));
        let mut room = f64::INFINITY;
        for i in from.nodes.clone() {
            let (node, point) = (tree.nodes[i], embed(&at.nodes.place(tree.nodes[i])));
            for ball in self.balls.iter() {
                let size = ball.size.min(tree.node_sizes[i]);
                let nearer = room + ball.radius + CONTACT_REACH * size;
                if (point - ball.centre).norm_squared() >= nearer * nearer
                    || self.stars.are_neighbours::<D>(at.surface, node, ball.facet)
                {
                    continue;
                }
                let own = FacetFoot::new::<D>(&ball.corners, &point).distance - CONTACT_REACH * size;
                if own > SKIN * size {
                    room = room.min(own);
                } else {
                    let (owner, facet, quiet_until) = (self.owner, ball.facet, f64::NEG_INFINITY);
                    self.close.push(ClosePair { owner, node, facet, quiet_until });
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
    /// Returns a facet of a size with its ball.
    fn new<const D: usize>(
        at: &SurfaceMotion<'_, impl NodeMotion<D>>,
        facet: ElementId,
        size: f64,
    ) -> Self {
        let corners = at.surface.facets[facet.index()].map(|node| embed(&at.nodes.place(node)));
        let centre = corners[..D].iter().sum::<Vector3>() / D as f64;
        let radius = corners[..D].iter().map(|corner| (corner - centre).norm_squared()).fold(0.0, f64::max).sqrt();
        Self { facet, corners, centre, radius, size }
    }
}
