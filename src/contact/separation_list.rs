//! Separation list of a surface with itself: it proves which nodes and facets cannot meet, and lists all others.
//!
//! Facets stand in a tree of clusters. Every node and facet that can ever meet are together in one pair of clusters, as
//! in a well-separated pair decomposition (Callahan & Kosaraju 1995): a pair of clusters that are apart as far as they
//! are large is kept as one. Its room is the distance of their boxes, less the reach of contact. Leaves nearer to each
//! other are looked at node by facet once: those near contact are listed as close pairs, the least distance of the
//! others is the room of the two leaves. It is used up by the displacements of the corners of one leaf *relative to*
//! those of the other only, so that a surface in motion stays proved as long as it is strained little.
//!
//! A pair is looked at again when the nodes of a cluster have travelled half of the room that is left. No result depends
//! on the list: a pair that it omits is out of reach.

use super::close_pairs::{ClosePair, LeafDistances, keep_for_good};
use super::cluster_motion::ClusterMotions;
use super::cluster_tree::ClusterTree;
use super::self_contact::CONTACT_REACH;
use super::surface_motion::{SurfaceMotion, SurfaceStars};
use crate::geometry::BoundingBox;
use crate::math::Vector;
use crate::mesh::NodeId;

/// Distance of two clusters, as a fraction of the larger one, from which on they are kept as one pair.
const SEPARATION: f64 = 0.5;
/// Part of the room of a pair that may be left when the pair is looked at anew.
const LEAST_ROOM: f64 = 0.25;
/// Spread of the displacements of a leaf, as a fraction of the room of a pair, from which on the leaf gets new
/// references.
const MOST_SPREAD: f64 = 0.1;
/// End of a chain of pairs.
const END: u32 = u32::MAX;

/// Pair of clusters that cannot meet before its room is used up.
#[derive(Debug, Clone)]
struct ClusterPair<const D: usize> {
    clusters: [usize; 2],
    /// Box around the relative displacements of two leaves when the room was found; none for boxes far apart.
    reference: Option<BoundingBox<D>>,
    /// Room of two leaves, m.
    room: f64,
    /// Room at which the pair is looked at anew, m.
    least_room: f64,
    /// Next pairs in the chains of both clusters.
    next: [u32; 2],
}

/// Separation list of a surface.
#[derive(Debug)]
pub(crate) struct SeparationList<const D: usize> {
    tree: ClusterTree,
    stars: SurfaceStars,
    motions: ClusterMotions<D>,
    pairs: Vec<ClusterPair<D>>,
    /// First pair in the chain of each cluster.
    chains: Vec<u32>,
    /// Pairs that can be used again.
    unused: Vec<u32>,
    /// Nodes and facets near contact.
    close: Vec<ClosePair>,
    leaf_distances: LeafDistances,
    /// Number of the last look, and that at which each cluster was measured last.
    look: u64,
    looks: Vec<u64>,
    /// Clusters whose pairs have to be looked at.
    unsettled: Vec<u32>,
    exhausted: Vec<u32>,
}

impl<const D: usize> SeparationList<D> {
    /// Builds the list of a surface.
    pub fn new(at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>, stars: SurfaceStars) -> Self {
        let tree = ClusterTree::new(at.surface, &at.place);
        let n = tree.clusters.len();
        let motions = ClusterMotions::new(&tree, at.travel, &at.place);
        let mut list = Self {
            tree,
            stars,
            motions,
            pairs: vec![],
            chains: vec![END; n],
            unused: vec![],
            close: vec![],
            leaf_distances: LeafDistances::default(),
            look: 0,
            looks: vec![0; n],
            unsettled: vec![],
            exhausted: vec![],
        };
        if n > 0 {
            list.separate(at, [0, 0]);
            list.settle_all(at);
        }
        list
    }

    /// Returns the nodes and facets that may be in contact, in no particular order.
    pub fn close(&mut self) -> &mut [ClosePair] {
        &mut self.close
    }

    /// Looks at the pairs whose room may be used up.
    #[inline]
    pub fn update(&mut self, at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>) {
        if self.motions.has_alarm(at.travel) {
            self.look += 1;
            let mut due = std::mem::take(&mut self.exhausted);
            due.clear();
            self.motions.append_due(at.travel, &mut due);
            due.iter().for_each(|cluster| self.measure(at, *cluster as usize));
            self.exhausted = due;
            self.settle_all(at);
            self.motions.reset_alarms(at.travel);
        }
    }

    /// Measures a cluster, unless this look has done so.
    fn measure(&mut self, at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>, cluster: usize) {
        if self.looks[cluster] != self.look {
            self.looks[cluster] = self.look;
            self.motions.measure(&self.tree, cluster, at.travel, &at.place);
            self.unsettled.push(cluster as u32);
        }
    }

    /// Shares the room of the pairs of all clusters that are not settled, and divides the pairs without room.
    fn settle_all(&mut self, at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>) {
        while let Some(cluster) = self.unsettled.pop() {
            self.exhausted.clear();
            let mut next = self.chains[cluster as usize];
            while next != END {
                let pair = next;
                next = self.next(pair, cluster as usize);
                if !self.share_room(at, pair) {
                    self.exhausted.push(pair);
                }
            }
            for i in 0..self.exhausted.len() {
                let pair = self.exhausted[i];
                let clusters = self.pairs[pair as usize].clusters;
                self.remove(pair);
                self.separate(at, clusters);
            }
        }
    }

    /// Returns the next pair in the chain of a cluster.
    fn next(&self, pair: u32, cluster: usize) -> u32 {
        let pair = &self.pairs[pair as usize];
        pair.next[usize::from(pair.clusters[0] != cluster)]
    }

    /// Allows both clusters of a pair half of the room that is left to travel; returns false if there is too little.
    fn share_room(&mut self, at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>, pair: u32) -> bool {
        let pair = &self.pairs[pair as usize];
        let unmeasured = pair.clusters.map(|cluster| self.motions.unmeasured(&self.tree, cluster, at.travel));
        let room = self.measured_room(pair) - unmeasured[0] - unmeasured[1];
        if !(room > pair.least_room) {
            return false;
        }
        for (cluster, unmeasured) in pair.clusters.into_iter().zip(unmeasured) {
            self.motions.allow(&self.tree, cluster, unmeasured + 0.5 * room);
        }
        true
    }

    /// Returns the room of a pair as its clusters were measured, m.
    fn measured_room(&self, pair: &ClusterPair<D>) -> f64 {
        match &pair.reference {
            None => self.gap(pair.clusters),
            Some(reference) => pair.room - self.relative_displacement(pair.clusters, reference),
        }
    }

    /// Returns the distance of the boxes of two clusters less the reach of contact, m.
    fn gap(&self, clusters: [usize; 2]) -> f64 {
        let [a, b] = clusters.map(|cluster| self.motions.bounds(cluster));
        let apart = (a.low - b.high).sup(&(b.low - a.high)).sup(&Vector::<D>::zeros());
        let [a, b] = clusters.map(|cluster| self.tree.clusters[cluster].size);
        apart.norm() - CONTACT_REACH * a.min(b)
    }

    /// Returns a bound of the displacements of two leaves relative to each other since the displacements were these, m.
    fn relative_displacement(&self, leaves: [usize; 2], since: &BoundingBox<D>) -> f64 {
        let now = self.motions.relative(leaves);
        (now.high - since.low).sup(&(since.high - now.low)).norm()
    }

    /// Divides two clusters into pairs that cannot meet.
    fn separate(&mut self, at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>, [a, b]: [usize; 2]) {
        let halves = [a, b].map(|cluster| self.tree.clusters[cluster].halves);
        if a == b {
            let Some([low, high]) = halves[0] else { return self.add_leaves(at, [a, b]) };
            [[low, low], [high, high], [low, high]].into_iter().for_each(|halves| self.separate(at, halves));
            return;
        }
        [a, b].into_iter().for_each(|cluster| self.measure(at, cluster));
        let extents = [a, b].map(|cluster| (self.motions.bounds(cluster).high - self.motions.bounds(cluster).low).norm());
        let gap = self.gap([a, b]);
        if gap >= SEPARATION * extents[0].max(extents[1]) {
            return self.add(at, [a, b], gap, None);
        }
        match halves {
            [None, None] => self.add_leaves(at, [a, b]),
            [Some(halves), None] => halves.into_iter().for_each(|half| self.separate(at, [half, b])),
            [Some(halves), Some(_)] if extents[0] >= extents[1] => {
                halves.into_iter().for_each(|half| self.separate(at, [half, b]));
            }
            [_, Some(halves)] => halves.into_iter().for_each(|half| self.separate(at, [a, half])),
        }
    }

    /// Adds a pair of leaves, or of a leaf with itself, that are near each other: lists the close pairs, and finds the
    /// room of the others.
    fn add_leaves(&mut self, at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>, leaves: [usize; 2]) {
        let pair = self.unused.last().copied().unwrap_or(self.pairs.len() as u32);
        leaves.into_iter().for_each(|leaf| self.measure(at, leaf));
        let clusters = leaves.map(|leaf| &self.tree.clusters[leaf]);
        let room = self.leaf_distances.find((&self.tree, &self.stars), clusters, at, pair, &mut self.close);
        if room == f64::INFINITY {
            return keep_for_good(pair, &mut self.close);
        }
        for leaf in leaves {
            if self.motions.spread(leaf) > MOST_SPREAD * room {
                self.renew_reference(at, leaf);
            }
        }
        let reference = self.motions.relative(leaves);
        self.add(at, leaves, room, Some(reference));
    }

    /// Makes the present places of the corners of a leaf its references, and takes from the rooms of its pairs of leaves
    /// what has been used up.
    fn renew_reference(&mut self, at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>, leaf: usize) {
        let mut next = self.chains[leaf];
        while next != END {
            let pair = next as usize;
            next = self.next(next, leaf);
            if let Some(reference) = &self.pairs[pair].reference {
                let clusters = self.pairs[pair].clusters;
                let unmeasured = clusters.map(|cluster| self.motions.unmeasured(&self.tree, cluster, at.travel));
                let used = self.relative_displacement(clusters, reference) + unmeasured[0] + unmeasured[1];
                self.pairs[pair].room -= used;
            }
        }
        self.motions.set_reference(&self.tree, leaf, &at.place);
        let mut next = self.chains[leaf];
        while next != END {
            let pair = next as usize;
            next = self.next(next, leaf);
            if self.pairs[pair].reference.is_some() {
                let clusters = self.pairs[pair].clusters;
                let unmeasured = clusters.map(|cluster| self.motions.unmeasured(&self.tree, cluster, at.travel));
                let margin = Vector::<D>::repeat(unmeasured[0] + unmeasured[1]);
                let BoundingBox { low, high } = self.motions.relative(clusters);
                self.pairs[pair].reference = Some(BoundingBox { low: low - margin, high: high + margin });
            }
        }
        self.unsettled.push(leaf as u32);
    }

    /// Adds a pair of clusters with this room, m.
    fn add(
        &mut self,
        at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>,
        clusters: [usize; 2],
        room: f64,
        reference: Option<BoundingBox<D>>,
    ) {
        let next = clusters.map(|cluster| self.chains[cluster]);
        let mut pair = ClusterPair { clusters, reference, room, least_room: 0.0, next };
        pair.least_room = LEAST_ROOM * self.measured_room(&pair);
        let index = self.unused.pop().unwrap_or(self.pairs.len() as u32);
        clusters.into_iter().for_each(|cluster| self.chains[cluster] = index);
        if index as usize == self.pairs.len() {
            self.pairs.push(pair);
        } else {
            self.pairs[index as usize] = pair;
        }
        self.share_room(at, index);
    }

    /// Removes a pair and its close pairs.
    fn remove(&mut self, pair: u32) {
        for cluster in self.pairs[pair as usize].clusters {
            let next = self.next(pair, cluster);
            if self.chains[cluster] == pair {
                self.chains[cluster] = next;
                continue;
            }
            let mut before = self.chains[cluster];
            while before != END && self.next(before, cluster) != pair {
                before = self.next(before, cluster);
            }
            if before != END {
                let before = &mut self.pairs[before as usize];
                before.next[usize::from(before.clusters[0] != cluster)] = next;
            }
        }
        self.unused.push(pair);
        self.close.retain(|close| close.owner != pair);
    }
}
