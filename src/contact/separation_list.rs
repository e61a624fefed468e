//! Separation list of a surface with itself: it proves which nodes and facets cannot meet, and lists all others.
//!
//! Facets stand in a tree of clusters, and every node and facet are together in one pair of clusters, as in a
//! well-separated pair decomposition (Callahan & Kosaraju 1995). A pair cannot meet as long as its proof holds:
//!
//! - *Far* clusters are apart by a fraction of their extent. They are proved by the distance of their boxes.
//! - *Near* leaves whose normals all lie within a right angle of each other face the same way (Volino & Magnenat-Thalmann
//!   1994). They are proved by the cones of their normals.
//! - Other near leaves are looked at node by facet once: those near contact are listed as close pairs, and the least
//!   distance of the others is the room of the two leaves. It is used up by the displacements of one leaf relative to the
//!   other.
//!
//! A proof is looked at again when the nodes of a cluster have travelled half of what it allows. No result depends on the
//! list: a node and a facet that it omits are out of reach, or do not face each other.

use super::close_pairs::{ClosePair, CloseSearch, FacetBall};
use super::cluster_tree::ClusterTree;
use super::cone_guard::ConeGuard;
use super::leaf_motion::LeafMotions;
use super::pair_chains::{END, PairChains};
use super::self_contact::CONTACT_REACH;
use super::surface_motion::{NodePaths, SurfaceMotion, SurfaceStars};
use super::travel_monitor::TravelMonitor;
use crate::geometry::BoundingBox;
use crate::math::Vector;

/// Distance of two clusters, as a fraction of the larger one, from which on they are far.
const SEPARATION: f64 = 0.5;
/// Part of the room of a pair that may be left when the pair is proved anew.
const LEAST_ROOM: f64 = 0.25;
/// Chord between normals that may be left when a pair is proved anew: 6°.
const LEAST_CHORD: f64 = 0.1;
/// Spread of the displacements of a leaf, as a fraction of the room of a pair, from which on the leaf gets new
/// references.
const MOST_SPREAD: f64 = 0.1;

/// Proof that two near leaves do not meet: relative displacements since these are less than the room, m.
#[derive(Debug, Clone)]
struct DistanceProof<const D: usize> {
    since: BoundingBox<D>,
    room: f64,
    /// Room at which the pair is proved anew, m.
    least_room: f64,
}

/// Separation list of a surface.
#[derive(Debug)]
pub(crate) struct SeparationList<const D: usize> {
    tree: ClusterTree,
    stars: SurfaceStars,
    /// Far pairs, with the room at which each is proved anew, m.
    far: PairChains<f64>,
    /// Boxes around the corners of the clusters as they were measured.
    bounds: Vec<BoundingBox<D>>,
    far_monitor: TravelMonitor,
    /// Near pairs that face the same way.
    aligned: PairChains<()>,
    guard: ConeGuard<D>,
    /// Other near pairs.
    near: PairChains<DistanceProof<D>>,
    leaves: LeafMotions<D>,
    near_monitor: TravelMonitor,
    /// Nodes and facets near contact.
    close: Vec<ClosePair>,
    balls: Vec<FacetBall>,
    /// Number of the present look, and those at which boxes, displacements and normals were measured last.
    look: u64,
    looks: Vec<[u64; 3]>,
    /// Clusters whose far, near and aligned pairs have to be looked at.
    unsettled: [Vec<u32>; 3],
    failed: Vec<u32>,
}

impl<const D: usize> SeparationList<D> {
    /// Builds the list of a surface.
    pub fn new(at: &SurfaceMotion<'_, impl NodePaths<D>>, stars: SurfaceStars) -> Self {
        let tree = ClusterTree::new(at);
        let n = tree.clusters.len();
        let is_leaf = |cluster: usize| tree.clusters[cluster].halves.is_none();
        let corners = |cluster: usize| tree.corners[tree.clusters[cluster].corners.clone()].iter().copied();
        let far_monitor = TravelMonitor::new((0..n).map(corners), at.travel);
        let of_leaf = |leaf: usize| corners(leaf).filter(move |_| is_leaf(leaf));
        let near_monitor = TravelMonitor::new((0..n).map(of_leaf), at.travel);
        let mut list = Self {
            far: PairChains::new(n),
            bounds: vec![BoundingBox::NONE; n],
            far_monitor,
            aligned: PairChains::new(n),
            guard: ConeGuard::new(&tree, at),
            near: PairChains::new(n),
            leaves: LeafMotions::new(&tree, at),
            near_monitor,
            close: vec![],
            balls: vec![],
            look: 1,
            looks: vec![[0, 1, 0]; n],
            unsettled: [vec![], vec![], vec![]],
            failed: vec![],
            stars,
            tree,
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

    /// Records the new velocity of a surface node.
    #[inline]
    pub fn note_velocity(&mut self, surface: u32, velocity: &Vector<D>, time: f64) {
        self.guard.note_velocity(surface, velocity, time);
    }

    /// Looks at the pairs whose proofs may no longer hold.
    #[inline]
    pub fn update(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>) {
        if self.far_monitor.has_alarm(at.travel)
            || self.near_monitor.has_alarm(at.travel)
            || self.guard.has_alarm(at.time)
        {
            self.look_at_due(at);
        }
    }

    /// Looks at the pairs of the clusters that have used up what they are allowed.
    fn look_at_due(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>) {
        self.look += 1;
        let mut due = std::mem::take(&mut self.failed);
        due.clear();
        self.far_monitor.append_due(at.travel, &mut due);
        for cluster in &due {
            self.measure_box(at, *cluster as usize);
        }
        due.clear();
        self.near_monitor.append_due(at.travel, &mut due);
        for leaf in &due {
            self.measure_leaf(at, *leaf as usize);
        }
        due.clear();
        self.guard.append_due(at.time, &mut due);
        for leaf in due.iter().map(|leaf| *leaf as usize) {
            self.measure_normals(at, leaf);
            if !self.guard.is_within(leaf, LEAST_CHORD) {
                self.unsettled[2].push(leaf as u32);
            }
        }
        self.failed = due;
        self.settle_all(at);
        self.far_monitor.reset_alarms(at.travel);
        self.near_monitor.reset_alarms(at.travel);
        self.guard.reset_alarm();
    }

    /// Measures the box of a cluster, unless this look has done so.
    fn measure_box(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>, cluster: usize) {
        if self.looks[cluster][0] != self.look {
            self.looks[cluster][0] = self.look;
            let corners = self.tree.corners[self.tree.clusters[cluster].corners.clone()].iter();
            self.bounds[cluster] = corners.fold(BoundingBox::NONE, |all, node| all.with(&at.nodes.place(*node)));
            self.far_monitor.begin(cluster, at.travel);
            self.unsettled[0].push(cluster as u32);
        }
    }

    /// Measures a leaf, unless this look has done so.
    fn measure_leaf(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>, leaf: usize) {
        if self.looks[leaf][1] != self.look {
            self.looks[leaf][1] = self.look;
            self.leaves.measure(&self.tree, leaf, at);
            self.near_monitor.begin(leaf, at.travel);
            self.unsettled[1].push(leaf as u32);
        }
    }

    /// Measures the normals of a leaf, unless this look has done so.
    fn measure_normals(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>, leaf: usize) {
        if self.looks[leaf][2] != self.look {
            let is_first = self.looks[leaf][2] == 0;
            self.looks[leaf][2] = self.look;
            self.guard.measure(&self.tree, leaf, at, is_first);
        }
    }

    /// Renews what the pairs of all unsettled clusters and leaves allow them to travel, and the proofs that have failed.
    fn settle_all(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>) {
        loop {
            if let Some(cluster) = self.unsettled[0].pop() {
                self.settle_far(at, cluster as usize);
            } else if let Some(leaf) = self.unsettled[1].pop() {
                self.settle_near(at, leaf as usize);
            } else if let Some(leaf) = self.unsettled[2].pop() {
                self.settle_aligned(at, leaf as usize);
            } else {
                return;
            }
        }
    }

    /// Settles the far pairs of a cluster.
    fn settle_far(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>, cluster: usize) {
        let mut failed = std::mem::take(&mut self.failed);
        failed.clear();
        let mut pair = self.far.first(cluster);
        while pair != END {
            failed.extend((!self.allow_far(at, pair)).then_some(pair));
            pair = self.far.next(pair, cluster);
        }
        for pair in &failed {
            let clusters = self.far.clusters(*pair);
            self.far.remove(*pair);
            self.separate(at, clusters);
        }
        self.failed = failed;
    }

    /// Settles the near pairs of a leaf.
    fn settle_near(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>, leaf: usize) {
        let mut failed = std::mem::take(&mut self.failed);
        failed.clear();
        let mut pair = self.near.first(leaf);
        while pair != END {
            failed.extend((!self.allow_near(at, pair)).then_some(pair));
            pair = self.near.next(pair, leaf);
        }
        for pair in &failed {
            let leaves = self.near.clusters(*pair);
            self.near.remove(*pair);
            self.close.retain(|close| close.owner != *pair);
            self.add_near(at, leaves);
        }
        self.failed = failed;
    }

    /// Gives a leaf a new axis and settles its aligned pairs.
    fn settle_aligned(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>, leaf: usize) {
        let mut failed = std::mem::take(&mut self.failed);
        failed.clear();
        self.looks[leaf][2] = self.look;
        self.guard.measure(&self.tree, leaf, at, true);
        let mut pair = self.aligned.first(leaf);
        while pair != END {
            let leaves = self.aligned.clusters(pair);
            failed.extend((!self.allow_aligned(at, leaves)).then_some(pair));
            pair = self.aligned.next(pair, leaf);
        }
        for pair in &failed {
            let leaves = self.aligned.clusters(*pair);
            self.aligned.remove(*pair);
            self.add_near(at, leaves);
        }
        self.failed = failed;
    }

    /// Allows the normals of both leaves half of the chord that is left until they can be at a right angle; returns false
    /// if there is too little.
    fn allow_aligned(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>, leaves: [usize; 2]) -> bool {
        for leaf in leaves {
            self.measure_normals(at, leaf);
        }
        let room = self.guard.room(leaves);
        let is_proved = room > 4.0 * LEAST_CHORD;
        if is_proved {
            for leaf in leaves {
                self.guard.limit(leaf, 0.5 * room);
            }
        }
        is_proved
    }

    /// Allows both clusters of a far pair half of the room that is left; returns false if there is too little.
    fn allow_far(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>, pair: u32) -> bool {
        let clusters = self.far.clusters(pair);
        let travel = clusters.map(|cluster| self.far_monitor.since_measured(cluster, at.travel));
        let room = self.gap(clusters) - travel[0] - travel[1];
        let is_proved = room > *self.far.known(pair);
        if is_proved {
            for (cluster, travel) in clusters.into_iter().zip(travel) {
                self.far_monitor.allow(cluster, travel + 0.5 * room);
            }
        }
        is_proved
    }

    /// Allows both leaves of a near pair half of the room that is left; returns false if there is too little.
    fn allow_near(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>, pair: u32) -> bool {
        let (leaves, proof) = (self.near.clusters(pair), self.near.known(pair));
        let travel = leaves.map(|leaf| self.near_monitor.since_measured(leaf, at.travel));
        let room = proof.room - self.leaves.relative_since(leaves, &proof.since) - travel[0] - travel[1];
        let is_proved = room > proof.least_room;
        if is_proved {
            for (leaf, travel) in leaves.into_iter().zip(travel) {
                self.near_monitor.allow(leaf, travel + 0.5 * room);
            }
        }
        is_proved
    }

    /// Returns the distance of the boxes of two clusters less the reach of contact, m.
    fn gap(&self, clusters: [usize; 2]) -> f64 {
        let [a, b] = clusters.map(|cluster| &self.bounds[cluster]);
        let apart = (a.low - b.high).sup(&(b.low - a.high)).sup(&Vector::<D>::zeros());
        let [a, b] = clusters.map(|cluster| self.tree.clusters[cluster].size);
        apart.norm() - CONTACT_REACH * a.min(b)
    }

    /// Divides two clusters into far and near pairs.
    fn separate(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>, [a, b]: [usize; 2]) {
        let halves = [a, b].map(|cluster| self.tree.clusters[cluster].halves);
        if a == b {
            let Some([low, high]) = halves[0] else { return self.add_near(at, [a, b]) };
            for halves in [[low, low], [high, high], [low, high]] {
                self.separate(at, halves);
            }
            return;
        }
        for cluster in [a, b] {
            self.measure_box(at, cluster);
        }
        let extents = [a, b].map(|cluster| (self.bounds[cluster].high - self.bounds[cluster].low).norm());
        let gap = self.gap([a, b]);
        if gap >= SEPARATION * extents[0].max(extents[1]) {
            let pair = self.far.add([a, b], LEAST_ROOM * gap);
            self.allow_far(at, pair);
            return;
        }
        match halves {
            [None, None] => self.add_near(at, [a, b]),
            [Some(halves), None] => {
                for half in halves {
                    self.separate(at, [half, b]);
                }
            }
            [Some(halves), Some(_)] if extents[0] >= extents[1] => {
                for half in halves {
                    self.separate(at, [half, b]);
                }
            }
            [_, Some(halves)] => {
                for half in halves {
                    self.separate(at, [a, half]);
                }
            }
        }
    }

    /// Proves a pair of near leaves, or of a leaf with itself: by their cones, or by the distances of their nodes and
    /// facets.
    fn add_near(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>, leaves: [usize; 2]) {
        if self.allow_aligned(at, leaves) {
            self.aligned.add(leaves, ());
            return;
        }
        for leaf in leaves {
            self.measure_leaf(at, leaf);
        }
        let owner = self.near.next_index();
        let (tree, stars, close, balls) = (&self.tree, &self.stars, &mut self.close, &mut self.balls);
        let room = CloseSearch { tree, stars, at, owner, close, balls }.find(leaves);
        for leaf in leaves {
            if self.leaves.spread(leaf) > MOST_SPREAD * room {
                self.renew_reference(at, leaf);
            }
        }
        let since = self.leaves.relative(leaves);
        let least_room = LEAST_ROOM * (room - self.leaves.relative_since(leaves, &since));
        let pair = self.near.add(leaves, DistanceProof { since, room, least_room });
        self.allow_near(at, pair);
    }

    /// Makes the present places of the corners of a leaf its references, and takes what has been used up from the rooms
    /// of its pairs.
    fn renew_reference(&mut self, at: &SurfaceMotion<'_, impl NodePaths<D>>, leaf: usize) {
        let mut pair = self.near.first(leaf);
        while pair != END {
            let used = self.used_room(at, pair);
            self.near.known_mut(pair).room -= used;
            pair = self.near.next(pair, leaf);
        }
        self.leaves.set_reference(&self.tree, leaf, at);
        let mut pair = self.near.first(leaf);
        while pair != END {
            let leaves = self.near.clusters(pair);
            let travel = leaves.map(|leaf| self.near_monitor.since_measured(leaf, at.travel));
            let margin = Vector::<D>::repeat(travel[0] + travel[1]);
            let BoundingBox { low, high } = self.leaves.relative(leaves);
            self.near.known_mut(pair).since = BoundingBox { low: low - margin, high: high + margin };
            pair = self.near.next(pair, leaf);
        }
        self.unsettled[1].push(leaf as u32);
    }

    /// Returns a bound of the relative displacements of two leaves since the room of their pair was found, m.
    fn used_room(&self, at: &SurfaceMotion<'_, impl NodePaths<D>>, pair: u32) -> f64 {
        let leaves = self.near.clusters(pair);
        let travel = leaves.map(|leaf| self.near_monitor.since_measured(leaf, at.travel));
        self.leaves.relative_since(leaves, &self.near.known(pair).since) + travel[0] + travel[1]
    }
}
