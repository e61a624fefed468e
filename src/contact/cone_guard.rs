//! Cone guard: it keeps the normals of each leaf within a cone whose width its pairs with other leaves allow.
//!
//! A normal turns only as far as the corners of its facet move *relative to each other*. A box around the velocities of
//! the corners of a leaf bounds this: it grows when a velocity leaves it. A surface that moves as a whole is therefore
//! measured seldom, however fast it is.

use super::cluster_tree::ClusterTree;
use super::facet::outward_normal;
use super::surface_motion::{NodePaths, SurfaceMotion};
use crate::geometry::BoundingBox;
use crate::math::{Vector, Vector3, embed};

/// Cone of the unit normals of a leaf and of the facets around its nodes. Angles are measured by chords: two unit
/// vectors are at a right angle if the chord between them is √2.
#[derive(Debug, Clone, Copy)]
struct GuardedCone<const D: usize> {
    /// Axis of the cone.
    axis: Vector3,
    /// Greatest chord from the axis to a normal when they were measured.
    chord: f64,
    /// Greatest chord from the axis to a normal that the pairs of the leaf allow.
    limit: f64,
    /// Bound of the turn of a normal by the relative displacement r of its corners, 1/m: the greatest sum of two edges over
    /// twice the area of a facet, or twice the reciprocal length in the plane.
    sharpness: f64,
    /// Box around the velocities of the corners since the normals were measured, m/s.
    velocities: BoundingBox<D>,
    /// Relative displacement of two corners up to a time, m, and that time, s.
    displacement: f64,
    time: f64,
    /// Time up to which the normals are proved to be within the limit, s.
    alarm: f64,
}

/// Guard of the cones of all leaves.
#[derive(Debug)]
pub(super) struct ConeGuard<const D: usize> {
    cones: Vec<GuardedCone<D>>,
    /// Earliest alarm, s.
    alarm: f64,
    /// Leaves with each surface node among their corners or those around their nodes, in compressed rows.
    start: Vec<u32>,
    leaves: Vec<u32>,
    /// Buffers of a measurement: places of the corners and normals of the facets.
    places: Vec<Vector3>,
    normals: Vec<Vector3>,
}

impl<const D: usize> ConeGuard<D> {
    /// Creates the guard of the leaves of a tree.
    pub fn new(tree: &ClusterTree, at: &SurfaceMotion<'_, impl NodePaths<D>>) -> Self {
        let cone = GuardedCone {
            axis: Vector3::zeros(),
            chord: f64::INFINITY,
            limit: f64::INFINITY,
            sharpness: f64::INFINITY,
            velocities: BoundingBox::NONE,
            displacement: 0.0,
            time: at.time,
            alarm: f64::INFINITY,
        };
        let mut corners: Vec<[u32; 2]> = vec![];
        for leaf in (0..tree.clusters.len()).filter(|cluster| tree.clusters[*cluster].halves.is_none()) {
            let nodes = tree.rim(leaf).iter();
            corners.extend(nodes.filter_map(|node| Some([at.surface.of[node.index()]?, leaf as u32])));
        }
        corners.sort_unstable();
        corners.dedup();
        let mut start = vec![0; at.surface.nodes.len() + 1];
        for [node, _] in &corners {
            start[*node as usize + 1] += 1;
        }
        for node in 0..at.surface.nodes.len() {
            start[node + 1] += start[node];
        }
        let leaves = corners.into_iter().map(|[_, leaf]| leaf).collect();
        Self {
            cones: vec![cone; tree.clusters.len()],
            alarm: f64::INFINITY,
            start,
            leaves,
            places: vec![],
            normals: vec![],
        }
    }

    /// Returns true if the normals of a leaf may have passed their limit by a time, s.
    #[inline]
    pub fn has_alarm(&self, time: f64) -> bool {
        is_due(time, self.alarm)
    }

    /// Appends the leaves whose normals may have passed their limits.
    pub fn append_due(&self, time: f64, due: &mut Vec<u32>) {
        due.extend((0..).zip(&self.cones).filter(|(_, cone)| is_due(time, cone.alarm)).map(|(leaf, _)| leaf));
    }

    /// Sets the earliest alarm.
    pub fn reset_alarm(&mut self) {
        self.alarm = self.cones.iter().map(|cone| cone.alarm).fold(f64::INFINITY, f64::min);
    }

    /// Measures the normals of a leaf against its axis, or against a new axis without a limit.
    pub fn measure(
        &mut self,
        tree: &ClusterTree,
        leaf: usize,
        at: &SurfaceMotion<'_, impl NodePaths<D>>,
        has_new_axis: bool,
    ) {
        let mut velocities = BoundingBox::<D>::NONE;
        self.places.clear();
        for node in tree.rim(leaf) {
            let velocity = at.nodes.velocity(*node);
            velocities = velocities.with(&velocity);
            self.places.push(embed(&at.nodes.place(*node)));
        }
        self.normals.clear();
        let (mut sum, mut sharpness) = (Vector3::zeros(), 0.0_f64);
        for facet in tree.around(leaf) {
            let (across, edges) = area_vector::<D>(&facet.map(|corner| self.places[usize::from(corner)]));
            let area = across.norm();
            let normal = across / area;
            sum += normal;
            // What is not a number stays, so that nothing is proved.
            sharpness = if edges / area <= sharpness { sharpness } else { edges / area };
            self.normals.push(normal);
        }
        let cone = &mut self.cones[leaf];
        if has_new_axis {
            (cone.axis, cone.limit) = (sum / sum.norm(), f64::INFINITY);
        }
        let chords = self.normals.iter().map(|normal| (normal - cone.axis).norm_squared());
        cone.chord = chords.fold(0.0_f64, |all, one| if one <= all { all } else { one }).sqrt();
        (cone.sharpness, cone.velocities, cone.displacement, cone.time) = (sharpness, velocities, 0.0, at.time);
        cone.set_alarm();
        self.alarm = self.alarm.min(cone.alarm);
    }

    /// Returns true if the normals of a measured leaf turned less than half of the way to their limit.
    pub fn is_within(&self, leaf: usize, least: f64) -> bool {
        let cone = &self.cones[leaf];
        cone.limit - cone.chord > least
    }

    /// Returns the chord that is left until a normal of one measured leaf and one of another can be at a right angle.
    pub fn room(&self, leaves: [usize; 2]) -> f64 {
        let [a, b] = leaves.map(|leaf| &self.cones[leaf]);
        std::f64::consts::SQRT_2 - a.chord - b.chord - (a.axis - b.axis).norm()
    }

    /// Limits the chord from the axis of a measured leaf to a normal to that measured and a turn.
    pub fn limit(&mut self, leaf: usize, turn: f64) {
        let cone = &mut self.cones[leaf];
        cone.limit = cone.limit.min(cone.chord + turn);
        cone.set_alarm();
        self.alarm = self.alarm.min(cone.alarm);
    }

    /// Records the new velocity of a surface node at a time, s.
    #[inline]
    pub fn note_velocity(&mut self, surface: u32, velocity: &Vector<D>, time: f64) {
        let leaves = self.start[surface as usize] as usize..self.start[surface as usize + 1] as usize;
        for leaf in &self.leaves[leaves] {
            let cone = &mut self.cones[*leaf as usize];
            if !cone.has_velocity(velocity) {
                cone.add_velocity(velocity, time);
                self.alarm = self.alarm.min(cone.alarm);
            }
        }
    }
}

impl<const D: usize> GuardedCone<D> {
    /// Returns true if a velocity lies in the box.
    #[inline]
    fn has_velocity(&self, velocity: &Vector<D>) -> bool {
        (0..D).all(|i| self.velocities.low[i] <= velocity[i] && velocity[i] <= self.velocities.high[i])
    }

    /// Adds a velocity to the box at a time, s.
    fn add_velocity(&mut self, velocity: &Vector<D>, time: f64) {
        self.displacement += self.relative_speed() * (time - self.time).max(0.0);
        self.time = time;
        self.velocities = self.velocities.with(velocity);
        self.set_alarm();
    }

    /// Returns a bound of the velocity of a corner relative to another, m/s.
    fn relative_speed(&self) -> f64 {
        (self.velocities.high - self.velocities.low).norm()
    }

    /// Sets the time up to which no normal turns past the limit, s.
    ///
    /// The area vector N of a triangle with the edges e₁, e₂ changes by |ΔN| ≤ r(|e₁| + |e₂|) + r² if its corners are
    /// displaced by r relative to each other, so that with q = (|e₁| + |e₂|)/|N| and q² ≥ 4/|N| it is
    /// x = |ΔN|/|N| ≤ (1 + qr/2)² − 1. The chord between the unit vectors is at most 2|ΔN|/(|N| + |N′|) ≤ 2x/(2 − x).
    fn set_alarm(&mut self) {
        if self.limit == f64::INFINITY {
            self.alarm = f64::INFINITY;
            return;
        }
        let turn = (self.limit - self.chord).max(0.0);
        let change = (2.0 * turn / (2.0 + turn)).min(1.0);
        let displacement = 2.0 * ((1.0 + change).sqrt() - 1.0) / self.sharpness;
        let left = (0.999 * displacement - self.displacement) / self.relative_speed().max(f64::MIN_POSITIVE);
        self.alarm = if left > 0.0 { self.time + left } else { f64::NEG_INFINITY };
    }
}

/// Returns true if an alarm may have come by a time, s; what is not a number has.
#[inline]
fn is_due(time: f64, alarm: f64) -> bool {
    let is_early = time < alarm;
    !is_early
}

/// Returns the normal of a facet out of the gel, twice its area or its length long, and what bounds its change: the sum of
/// two edges, or 2.
#[inline]
fn area_vector<const D: usize>(corners: &[Vector3; 3]) -> (Vector3, f64) {
    let [a, b, c] = corners;
    (outward_normal::<D>(corners), if D == 2 { 2.0 } else { (b - a).norm() + (c - a).norm() })
}
