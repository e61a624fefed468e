//! Close pairs: nodes and facets of two leaves that are near contact, and the least distance of the others.

use super::cluster_tree::{ClusterTree, FacetCluster};
use super::facet_foot::FacetFoot;
use super::self_contact::CONTACT_REACH;
use super::surface_motion::{NodePlaces, SurfaceMotion, SurfaceStars};
use crate::geometry::BoundingBox;
use crate::math::{Vector, Vector3, embed};
use crate::mesh::{ElementId, NodeId};

/// Distance beyond the reach of contact up to which a node and a facet are a close pair, in element sizes.
const SKIN: f64 = 0.3;
/// Greatest distance beyond the reach of contact that is told, in element sizes of a leaf.
const MOST_ROOM: f64 = 1.0;

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

impl ClosePair {
    /// Returns true if node and facet may be in reach once nodes have travelled this far, m.
    pub fn may_be_in_reach(&self, travel: f64) -> bool {
        let is_quiet = travel <= self.quiet_until;
        !is_quiet
    }
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
    /// reach of contact, m, at most [`MOST_ROOM`].
    pub fn find<const D: usize>(&mut self, [a, b]: [usize; 2]) -> f64
    where
        N: NodePlaces<D>,
    {
        let (from, to) = (&self.tree.clusters[a], &self.tree.clusters[b]);
        let room = self.find_from(from, to, MOST_ROOM * from.size.min(to.size));
        if a == b { room } else { self.find_from(to, from, room) }
    }

    /// Lists the close pairs of the nodes of one leaf and the facets of another; returns the least distance of the others
    /// less the reach of contact, m, at most `room`.
    fn find_from<const D: usize>(&mut self, from: &FacetCluster, to: &FacetCluster, mut room: f64) -> f64
    where
        N: NodePlaces<D>,
    {
        let (tree, at) = (self.tree, self.at);
        let places: Vec<Vector<D>> =
            tree.corners[to.corners.clone()].iter().map(|node| at.nodes.place(*node)).collect();
        let bounds = BoundingBox::around(&places);
        self.balls.clear();
        for i in from.nodes.clone() {
            let (node, place) = (tree.nodes[i], at.nodes.place(tree.nodes[i]));
            let nearer = room + CONTACT_REACH * to.size.min(tree.node_sizes[i]);
            if bounds.distance_squared(&place) >= nearer * nearer {
                continue;
            }
            if self.balls.is_empty() {
                self.balls.extend(to.facets.clone().map(|i| FacetBall::new(tree, i, &places)));
            }
            let point = embed(&place);
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

impl FacetBall {
    /// Returns a facet of a leaf, the corners of which are at these places, with its ball.
    fn new<const D: usize>(tree: &ClusterTree, i: usize, places: &[Vector<D>]) -> Self {
        let place = |corner: u16| embed(&places[usize::from(corner)]);
        let [a, b, c] = tree.facet_corners[i];
        let corners = [place(a), place(b), place(c)];
        let centre = corners[..D].iter().sum::<Vector3>() / D as f64;
        let radius = corners[..D].iter().map(|corner| (corner - centre).norm_squared()).fold(0.0, f64::max).sqrt();
        Self { facet: tree.facets[i], corners, centre, radius, size: tree.facet_sizes[i] }
    }
}
