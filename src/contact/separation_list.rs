//! Separation list of a surface with itself: it proves which nodes and facets cannot meet, and lists all others.
//!
//! Facets stand in a tree of clusters, and every node and facet are together in one pair of clusters, as in a
//! well-separated pair decomposition (Callahan & Kosaraju 1995). A pair cannot meet as long as its proof holds:
//!
//! - *Far* clusters are apart by a fraction of their extent. They are proved by the distance of their boxes.
//! - *Near* leaves whose normals all lie within a right angle of each other face the same way (Volino &
//!   Magnenat-Thalmann 1994). They are proved by the cones of their normals.
//! - Other near leaves are looked at node by facet once: those near contact are listed as close pairs, and the least
//!   distance of the others is the room of the two leaves. It is used up by the displacements of one leaf relative to
//!   the other.
//!
//! A proof is looked at again when the nodes of one side have travelled half of what it allows. No result depends on
//! the list: a node and a facet that it omits are out of reach, or do not face each other.

use super::close_pairs::{ClosePair, CloseSearch, FacetBall};
use super::cluster_tree::ClusterTree;
use super::cone_guard::ConeGuard;
use super::leaf_motion::LeafMotions;
use super::pair_chains::{END, PairChains};
use super::self_contact::CONTACT_REACH;
use super::surface_motion::{NodePlaces, SurfaceMotion, SurfaceStars};
use super::travel_monitor::TravelMonitor;
use crate::geometry::BoundingBox;
use crate::math::Vector;

/// Distance of two clusters, as a fraction of the larger one, from which on they are far.
const SEPARATION: f64 = 0.2;
/// Part of the room of a pair that may be left when the pair is proved anew.
const LEAST_ROOM: f64 = 0.25;
/// Chord between normals that may be left when a pair is proved anew: 6°.
const LEAST_CHORD: f64 = 0.1;
/// Spread of the displacements of a leaf, as a fraction of the room of a pair, from which on the leaf gets new
/// references.
const MOST_SPREAD: f64 = 0.4;

/// Kinds of proof that two clusters do not meet.
#[derive(Debug, Clone, Copy)]
enum ProofKind {
    /// Far clusters.
    Far,
    /// Near leaves that do not face the same way.
    Near,
    /// Near leaves that face the same way.
    Aligned,
}

/// Proof that a pair does not meet.
#[derive(Debug)]
enum PairProof<const D: usize> {
    /// Far clusters, with the room at which they are proved anew, m.
    Far { least_room: f64 },
    /// Near leaves that do not face the same way.
    Near(Box<DistanceProof<D>>),
    /// Near leaves that face the same way.
    Aligned,
}

/// Proof that two near leaves do not meet: relative displacements since these are less than the room, m.
#[derive(Debug)]
struct DistanceProof<const D: usize> {
    since: BoundingBox<D>,
    room: f64,
    /// Room at which the pair is proved anew, m.
    least_room: f64,
}

/// Separation list of a surface.
///
/// The proofs of each kind are kept by *sets*: for each cluster and kind those nodes whose travel can end a proof.
#[derive(Debug)]
pub(crate) struct SeparationList<const D: usize> {
    tree: ClusterTree,
    stars: SurfaceStars,
    /// Pairs of clusters in the chains of their sets.
    pairs: PairChains<PairProof<D>>,
    monitor: TravelMonitor,
    /// Boxes around the corners of the clusters as they were measured.
    bounds: Vec<BoundingBox<D>>,
    leaves: LeafMotions<D>,
    guard: ConeGuard,
    /// Nodes and facets near contact.
    close: Vec<ClosePair>,
    balls: Vec<FacetBall>,
    /// Number of the present look, and that at which each set was measured last.
    look: u64,
    looks: Vec<u64>,
    /// Sets whose pairs have to be looked at.
    unsettled: Vec<u32>,
    failed: Vec<u32>,
}

impl ProofKind {
    /// All kinds, in the order of their sets.
    const ALL: [Self; 3] = [Self::Far, Self::Near, Self::Aligned];

    /// Returns the set of a cluster.
    fn set(self, cluster: usize) -> usize {
        cluster * Self::ALL.len() + self as usize
    }

    /// Returns the kind of the proofs of a set.
    fn of(set: usize) -> Self {
        Self::ALL[set % Self::ALL.len()]
    }
}

/// Returns the cluster of a set.
fn cluster_of(set: usize) -> usize {
    set / ProofKind::ALL.len()
}

impl<const D: usize> SeparationList<D> {
    /// Builds the list of a surface.
    pub fn new(at: &SurfaceMotion<'_, impl NodePlaces<D>>, stars: SurfaceStars) -> Self {
        let tree = ClusterTree::new(at);
        let (n, n_sets) = (tree.clusters.len(), ProofKind::Far.set(tree.clusters.len()));
        let nodes = |set: usize| match (ProofKind::of(set), cluster_of(set)) {
            (ProofKind::Near, cluster) if tree.clusters[cluster].halves.is_some() => &[],
            (ProofKind::Far | ProofKind::Near, cluster) => tree.corners_of(cluster),
            (ProofKind::Aligned, leaf) => tree.rim(leaf),
        };
        let mut list = Self {
            pairs: PairChains::new(n_sets),
            monitor: TravelMonitor::new((0..n_sets).map(nodes), at.travel),
            bounds: vec![BoundingBox::NONE; n],
            leaves: LeafMotions::new((0..n).map(|leaf| nodes(ProofKind::Near.set(leaf))), at),
            guard: ConeGuard::new(n),
            close: vec![],
            balls: vec![],
            look: 1,
            looks: vec![0; n_sets],
            unsettled: vec![],
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

    /// Looks at the pairs whose proofs may no longer hold.
    #[inline]
    pub fn update(&mut self, at: &SurfaceMotion<'_, impl NodePlaces<D>>) {
        if self.monitor.has_alarm(at.travel) {
            self.look_at_exhausted(at);
        }
    }

    /// Measures the exhausted sets, and proves their pairs anew.
    fn look_at_exhausted(&mut self, at: &SurfaceMotion<'_, impl NodePlaces<D>>) {
        self.look += 1;
        let mut exhausted = std::mem::take(&mut self.failed);
        exhausted.clear();
        self.monitor.append_exhausted(at.travel, &mut exhausted);
        for set in &exhausted {
            self.measure(at, *set as usize);
        }
        self.failed = exhausted;
        self.settle_all(at);
        self.monitor.reset_alarms(at.travel);
    }

    /// Measures a set, unless this look has done so: the box of its cluster, the displacements of its leaf or the
    /// normals around it.
    fn measure(&mut self, at: &SurfaceMotion<'_, impl NodePlaces<D>>, set: usize) {
        let last = std::mem::replace(&mut self.looks[set], self.look);
        if last == self.look {
            return;
        }
        let cluster = cluster_of(set);
        self.monitor.restart(set, at.travel);
        match ProofKind::of(set) {
            ProofKind::Far => {
                let mut bounds = BoundingBox::NONE;
                for node in self.tree.corners_of(cluster) {
                    bounds = bounds.with(&at.nodes.place(*node));
                }
                self.bounds[cluster] = bounds;
            }
            ProofKind::Near => self.leaves.measure(cluster, at),
            ProofKind::Aligned => {
                self.guard.measure(&self.tree, cluster, at, last == 0);
                self.monitor.limit_travel(set, self.guard.travel_left(cluster));
                if self.guard.chord_left(cluster) > LEAST_CHORD {
                    return;
                }
            }
        }
        self.unsettled.push(set as u32);
    }

    /// Renews the travel bounds of all unsettled sets from the proofs of their pairs, and the proofs that have failed.
    fn settle_all(&mut self, at: &SurfaceMotion<'_, impl NodePlaces<D>>) {
        while let Some(set) = self.unsettled.pop() {
            self.settle(at, set as usize);
        }
    }

    /// Settles the pairs of a set, those of normals with a new axis.
    fn settle(&mut self, at: &SurfaceMotion<'_, impl NodePlaces<D>>, set: usize) {
        if let ProofKind::Aligned = ProofKind::of(set) {
            self.guard.measure(&self.tree, cluster_of(set), at, true);
            self.monitor.restart(set, at.travel);
        }
        let mut failed = std::mem::take(&mut self.failed);
        failed.clear();
        let mut pair = self.pairs.first(set);
        while pair != END {
            failed.extend((!self.allow(at, pair)).then_some(pair));
            pair = self.pairs.next(pair, set);
        }
        for pair in &failed {
            let clusters = self.pairs.sets(*pair).map(cluster_of);
            self.pairs.remove(*pair);
            match ProofKind::of(set) {
                ProofKind::Far => self.separate(at, clusters),
                ProofKind::Near => {
                    self.close.retain(|close| close.owner != *pair);
                    self.add_near(at, clusters);
                }
                ProofKind::Aligned => self.add_near(at, clusters),
            }
        }
        self.failed = failed;
    }

    /// Allows both sets of a pair half of the room that is left, if need be after they are measured; returns false if
    /// there is too little.
    fn allow(&mut self, at: &SurfaceMotion<'_, impl NodePlaces<D>>, pair: u32) -> bool {
        if self.allow_as_measured(at, pair) {
            return true;
        }
        let sets = self.pairs.sets(pair);
        if sets.iter().all(|set| self.looks[*set] == self.look) {
            return false;
        }
        for set in sets {
            self.measure(at, set);
        }
        self.allow_as_measured(at, pair)
    }

    /// Allows both sets of a pair half of the room that is left since they were measured; returns false if there is too
    /// little.
    fn allow_as_measured(&mut self, at: &SurfaceMotion<'_, impl NodePlaces<D>>, pair: u32) -> bool {
        let [a, b] = self.pairs.sets(pair);
        let clusters = [cluster_of(a), cluster_of(b)];
        let (room, least_room) = match self.pairs.known(pair) {
            PairProof::Far { least_room } => (self.gap(clusters), *least_room),
            PairProof::Near(proof) => {
                (proof.room - self.leaves.relative_since(clusters, &proof.since), proof.least_room)
            }
            PairProof::Aligned => return self.allow_aligned(at, clusters),
        };
        let [of_a, of_b] =
            [self.monitor.travel_since_measured(a, at.travel), self.monitor.travel_since_measured(b, at.travel)];
        let room = room - of_a - of_b;
        let is_proved = room > least_room;
        if is_proved {
            self.monitor.limit_travel(a, of_a + 0.5 * room);
            self.monitor.limit_travel(b, of_b + 0.5 * room);
        }
        is_proved
    }

    /// Allows the normals of both leaves half of the chord that is left until they can be at a right angle; returns
    /// false if there is too little.
    fn allow_aligned(&mut self, at: &SurfaceMotion<'_, impl NodePlaces<D>>, leaves: [usize; 2]) -> bool {
        let sets = leaves.map(|leaf| ProofKind::Aligned.set(leaf));
        for set in sets {
            self.measure(at, set);
        }
        let room = self.guard.room(leaves);
        let is_proved = room > 4.0 * LEAST_CHORD;
        if is_proved {
            for (set, leaf) in sets.into_iter().zip(leaves) {
                self.guard.limit(leaf, 0.5 * room);
                self.monitor.limit_travel(set, self.guard.travel_left(leaf));
            }
        }
        is_proved
    }

    /// Returns the distance of the boxes of two clusters less the reach of contact, m.
    #[inline]
    fn gap(&self, [a, b]: [usize; 2]) -> f64 {
        let (of_a, of_b) = (&self.bounds[a], &self.bounds[b]);
        let apart = (of_a.low - of_b.high).sup(&(of_b.low - of_a.high)).sup(&Vector::<D>::zeros());
        apart.norm() - CONTACT_REACH * self.tree.clusters[a].size.min(self.tree.clusters[b].size)
    }

    /// Divides two clusters into far and near pairs.
    fn separate(&mut self, at: &SurfaceMotion<'_, impl NodePlaces<D>>, [a, b]: [usize; 2]) {
        let halves = [a, b].map(|cluster| self.tree.clusters[cluster].halves);
        if a == b {
            let Some([low, high]) = halves[0] else { return self.add_near(at, [a, b]) };
            for halves in [[low, low], [high, high], [low, high]] {
                self.separate(at, halves);
            }
            return;
        }
        let sets = [a, b].map(|cluster| ProofKind::Far.set(cluster));
        for set in sets {
            self.measure(at, set);
        }
        let extents = [a, b].map(|cluster| (self.bounds[cluster].high - self.bounds[cluster].low).norm());
        let gap = self.gap([a, b]);
        if gap >= SEPARATION * extents[0].max(extents[1]) {
            let pair = self.pairs.add(sets, PairProof::Far { least_room: LEAST_ROOM * gap });
            self.allow(at, pair);
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
    fn add_near(&mut self, at: &SurfaceMotion<'_, impl NodePlaces<D>>, leaves: [usize; 2]) {
        let sets = leaves.map(|leaf| ProofKind::Aligned.set(leaf));
        // Normals that were far from aligned when they were measured last are not measured again.
        let may_be_aligned =
            sets.iter().any(|set| self.looks[*set] == 0) || self.guard.room(leaves) > 2.0 * LEAST_CHORD;
        if may_be_aligned && self.allow_aligned(at, leaves) {
            self.pairs.add(sets, PairProof::Aligned);
            return;
        }
        let sets = leaves.map(|leaf| ProofKind::Near.set(leaf));
        for set in sets {
            self.measure(at, set);
        }
        let owner = self.pairs.next_index();
        let (tree, stars, close, balls) = (&self.tree, &self.stars, &mut self.close, &mut self.balls);
        let room = CloseSearch { tree, stars, at, owner, close, balls }.find(leaves);
        for leaf in leaves {
            if self.leaves.spread(leaf) > MOST_SPREAD * room {
                self.renew_reference(at, leaf);
            }
        }
        let since = self.leaves.relative(leaves);
        let least_room = LEAST_ROOM * (room - self.leaves.relative_since(leaves, &since));
        let pair = self.pairs.add(sets, PairProof::Near(Box::new(DistanceProof { since, room, least_room })));
        self.allow(at, pair);
    }

    /// Makes the present places of the corners of a leaf its references, and takes what has been used up from the rooms
    /// of its pairs.
    fn renew_reference(&mut self, at: &SurfaceMotion<'_, impl NodePlaces<D>>, leaf: usize) {
        let set = ProofKind::Near.set(leaf);
        let mut pair = self.pairs.first(set);
        while pair != END {
            let sets = self.pairs.sets(pair);
            let travel = sets.map(|set| self.monitor.travel_since_measured(set, at.travel));
            if let PairProof::Near(proof) = self.pairs.known_mut(pair) {
                proof.room -= self.leaves.relative_since(sets.map(cluster_of), &proof.since) + travel[0] + travel[1];
            }
            pair = self.pairs.next(pair, set);
        }
        self.leaves.set_reference(leaf, at);
        let mut pair = self.pairs.first(set);
        while pair != END {
            let sets = self.pairs.sets(pair);
            let travel = sets.map(|set| self.monitor.travel_since_measured(set, at.travel));
            let margin = Vector::<D>::repeat(travel[0] + travel[1]);
            let BoundingBox { low, high } = self.leaves.relative(sets.map(cluster_of));
            if let PairProof::Near(proof) = self.pairs.known_mut(pair) {
                proof.since = BoundingBox { low: low - margin, high: high + margin };
            }
            pair = self.pairs.next(pair, set);
        }
        self.unsettled.push(set as u32);
    }
}
