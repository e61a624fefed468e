//! Motion of the clusters of a surface: boxes around the places and the displacements of the corners of each, measured
//! anew only when the nodes have travelled as far as is allowed.

use super::cluster_tree::ClusterTree;
use crate::geometry::BoundingBox;
use crate::math::Vector;
use crate::mesh::NodeId;

/// Motion of the clusters. Displacements are those from the reference places of a leaf.
#[derive(Debug)]
pub(super) struct ClusterMotions<const D: usize> {
    /// Reference places of the corners of each leaf, m.
    references: Vec<Vector<D>>,
    /// Box around the displacements of the corners of each leaf when they were measured, m.
    displacements: Vec<BoundingBox<D>>,
    /// Box around the corners of each cluster when they were measured, m.
    bounds: Vec<BoundingBox<D>>,
    /// Travel of each run of each cluster up to that measurement, m.
    measured: Vec<f64>,
    /// Travel since that each cluster is allowed, m.
    allowed: Vec<f64>,
    /// Travel of each run of nodes at which a cluster has used up its own, m.
    alarms: Vec<f64>,
    /// Clusters with corners of each run, in compressed rows, with the index of the run in the cluster.
    of_run: Vec<Vec<[u32; 2]>>,
}

impl<const D: usize> ClusterMotions<D> {
    /// Box of displacements of corners at their references.
    const AT_REFERENCE: BoundingBox<D> = BoundingBox {
        low: Vector::<D>::from_array_storage(nalgebra::ArrayStorage([[0.0; D]])),
        high: Vector::<D>::from_array_storage(nalgebra::ArrayStorage([[0.0; D]])),
    };

    /// Creates the motion of a tree whose corners are at their references and have travelled this far, m.
    pub fn new(tree: &ClusterTree, travel: &[f64], place: impl Fn(NodeId) -> Vector<D>) -> Self {
        let mut of_run = vec![vec![]; travel.len()];
        for (cluster, of) in tree.clusters.iter().enumerate() {
            of.runs.clone().for_each(|at| of_run[tree.runs[at] as usize].push([cluster as u32, at as u32]));
        }
        let references: Vec<Vector<D>> = tree.corners.iter().map(|node| place(*node)).collect();
        let bounds = tree.clusters.iter().map(|of| BoundingBox::around(&references[of.corners.clone()])).collect();
        Self {
            references,
            displacements: vec![Self::AT_REFERENCE; tree.clusters.len()],
            bounds,
            measured: tree.runs.iter().map(|run| travel[*run as usize]).collect(),
            allowed: vec![f64::INFINITY; tree.clusters.len()],
            alarms: vec![f64::INFINITY; travel.len()],
            of_run,
        }
    }

    /// Returns true if a cluster has used up its travel.
    #[inline]
    pub fn has_alarm(&self, travel: &[f64]) -> bool {
        self.alarms.iter().zip(travel).any(|(alarm, travel)| !(travel <= alarm))
    }

    /// Appends the clusters that have used up their travel.
    pub fn append_due(&self, travel: &[f64], due: &mut Vec<u32>) {
        for (run, travel) in travel.iter().enumerate().filter(|(run, travel)| !(**travel <= self.alarms[*run])) {
            let is_due = |[cluster, at]: &&[u32; 2]| {
                let left = self.measured[*at as usize] + self.allowed[*cluster as usize];
                !(*travel <= left)
            };
            due.extend(self.of_run[run].iter().filter(is_due).map(|[cluster, _]| *cluster));
        }
    }

    /// Sets the alarms of the runs that have passed theirs.
    pub fn reset_alarms(&mut self, travel: &[f64]) {
        for (run, travel) in travel.iter().enumerate() {
            if !(*travel <= self.alarms[run]) {
                let left = |[cluster, at]: &[u32; 2]| self.measured[*at as usize] + self.allowed[*cluster as usize];
                self.alarms[run] = self.of_run[run].iter().map(left).fold(f64::INFINITY, f64::min);
            }
        }
    }

    /// Measures the displacements of a cluster, which is allowed any travel until it is told otherwise.
    pub fn measure(&mut self, tree: &ClusterTree, cluster: usize, travel: &[f64], place: impl Fn(NodeId) -> Vector<D>) {
        let of = &tree.clusters[cluster];
        let (mut bounds, mut displacements) = (BoundingBox::NONE, BoundingBox::NONE);
        for (node, reference) in tree.corners[of.corners.clone()].iter().zip(&self.references[of.corners.clone()]) {
            let now = place(*node);
            bounds = bounds.joined(&BoundingBox { low: now, high: now });
            let displacement = now - reference;
            displacements = displacements.joined(&BoundingBox { low: displacement, high: displacement });
        }
        (self.bounds[cluster], self.displacements[cluster]) = (bounds, displacements);
        for at in of.runs.clone() {
            self.measured[at] = travel[tree.runs[at] as usize];
        }
        self.allowed[cluster] = f64::INFINITY;
    }

    /// Returns the greatest travel of a corner of a cluster since it was measured, m.
    pub fn unmeasured(&self, tree: &ClusterTree, cluster: usize, travel: &[f64]) -> f64 {
        let since = |at: usize| travel[tree.runs[at] as usize] - self.measured[at];
        tree.clusters[cluster].runs.clone().map(since).fold(0.0, f64::max)
    }

    /// Limits the travel of a cluster since it was measured, m.
    pub fn allow(&mut self, tree: &ClusterTree, cluster: usize, travel: f64) {
        if travel < self.allowed[cluster] {
            self.allowed[cluster] = travel;
            for at in tree.clusters[cluster].runs.clone() {
                let alarm = &mut self.alarms[tree.runs[at] as usize];
                *alarm = alarm.min(self.measured[at] + travel);
            }
        }
    }

    /// Makes the places of the corners of a measured leaf its references.
    pub fn set_reference(&mut self, tree: &ClusterTree, leaf: usize, place: impl Fn(NodeId) -> Vector<D>) {
        let corners = tree.clusters[leaf].corners.clone();
        for (node, reference) in tree.corners[corners.clone()].iter().zip(&mut self.references[corners]) {
            *reference = place(*node);
        }
        self.displacements[leaf] = Self::AT_REFERENCE;
    }

    /// Returns the box around the corners of a cluster when they were measured, m.
    pub fn bounds(&self, cluster: usize) -> &BoundingBox<D> {
        &self.bounds[cluster]
    }

    /// Returns the extent of the displacements of the corners of a leaf, m.
    pub fn spread(&self, leaf: usize) -> f64 {
        let BoundingBox { low, high } = &self.displacements[leaf];
        (high - low).norm()
    }

    /// Returns the box around the displacements of the corners of one leaf less those of another, m.
    pub fn relative(&self, [a, b]: [usize; 2]) -> BoundingBox<D> {
        let (a, b) = (&self.displacements[a], &self.displacements[b]);
        BoundingBox { low: a.low - b.high, high: a.high - b.low }
    }
}
