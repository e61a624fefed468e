//! Track of a projectile through the gel: motion and energy against depth.

use super::shot_line::{CENTIMETRES, MAX_DEPTHS, ShotLine, depths_per_metre};
use crate::math::Vector3;
use crate::output::files::{OutputError, format_cell};
use crate::output::history::{HistoryFile, HistoryRow};
use nalgebra::Vector2;
use std::fmt::Write;

/// Depth window of the mean force, m: a communication step of a shot covers some millimetres.
const FORCE_WINDOW: f64 = 4e-3;
/// Yaw at the end of the neck, rad: 30°.
const NECK_YAW: f64 = std::f64::consts::FRAC_PI_6;
/// Tolerance of depths, m, for round-off.
const DEPTH_TOLERANCE: f64 = 1e-9;

/// State of the projectile at a depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::output) struct TrackPoint {
    /// Depth of the foremost point, m.
    pub(in crate::output) depth: f64,
    /// Time of the first arrival at the depth, s.
    pub(in crate::output) time: f64,
    /// Path of the centre of mass along −z relative to the block, m: that of a rigid body that does not turn is the depth
    /// but for a constant.
    pub(in crate::output) path: f64,
    /// Speed along −z relative to the block, m/s.
    pub(in crate::output) velocity: f64,
    /// Energy given to the gel down to the depth, seen from the block, J.
    pub(in crate::output) energy: f64,
    /// Yaw, rad: angle between axis and velocity, or between axis and reversed velocity on the way back.
    pub(in crate::output) yaw: f64,
    /// Impulse of the gel on the projectile across the line of fire, down to the depth, along x and y, N·s.
    pub(in crate::output) side_impulse: Vector2<f64>,
    /// Opening of an expanding projectile; 0 for any other.
    pub(in crate::output) expansion: f64,
}

/// Track to the greatest depth; each depth carries the time of its first arrival.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::output) struct ProjectileTrack {
    points: Vec<TrackPoint>,
    /// Limit of the depth, m: the depth of the gel.
    end: f64,
}

/// Velocities of the projectile at the end of a communication step.
struct StepVelocities {
    /// Velocity relative to the block, m/s.
    velocity: Vector3,
    spin: Vector3,
}

impl StepVelocities {
    fn of(row: &HistoryRow) -> Self {
        let block = row.vector("block_velocity_", "_m_per_s");
        Self {
            velocity: row.vector("velocity_", "_m_per_s") - block,
            spin: row.vector("angular_velocity_", "_rad_per_s"),
        }
    }
}

impl ProjectileTrack {
    /// Reads the track from the history. The energy given in a communication step is −J·(v₀ + v₁)/2 − A·(ω₀ + ω₁)/2
    /// with velocities relative to the block, exact for a body without other loads. It is all the energy but that of
    /// the block's own motion, so that its derivative with respect to the depth is the force.
    pub(super) fn of(line: &ShotLine, history: &HistoryFile) -> Result<Self, OutputError> {
        let mut points: Vec<TrackPoint> = vec![];
        let (mut before, mut sums) = (None, TrackSums::default());
        history.for_each_row(|row| {
            let now = StepVelocities::of(row);
            sums.energy += before.as_ref().map_or(0.0, |before| energy_given(before, row, &now));
            sums.side_impulse += row.vector("impulse_", "_N_s").xy();
            append_deeper(&mut points, line.gel_depth, row, -now.velocity.z, &sums);
            before = Some(now);
        })?;
        Ok(Self { points, end: line.gel_depth })
    }

    /// Returns the greatest depth, m.
    pub(super) fn greatest_depth(&self) -> f64 {
        self.points.last().map_or(0.0, |last| last.depth.min(self.end))
    }

    /// Returns the greatest depth, m, up to a time, s.
    pub(super) fn depth_until(&self, time: f64) -> f64 {
        let until = self.points.partition_point(|place| place.time <= time);
        self.points[..until].last().map_or(0.0, |last| last.depth.min(self.end))
    }

    /// Returns the points of the table: every millimetre, or a wider interval in a long track, and the greatest
    /// depth.
    pub(in crate::output) fn table(&self) -> Vec<TrackPoint> {
        let per_metre = depths_per_metre(self.greatest_depth());
        let n = (self.greatest_depth() * per_metre) as usize;
        let regular = (0..=n)
            .map(|i| i as f64 / per_metre)
            .filter(|depth| *depth >= self.first_depth() && *depth < self.greatest_depth() - DEPTH_TOLERANCE);
        regular.chain([self.greatest_depth()]).map(|depth| self.interpolate(depth)).collect()
    }

    /// Returns the mean retarding force, N, over a window of 4 mm around a depth, clipped at both ends of the track: the
    /// energy given over the path of the centre of mass. A track of one point has no force.
    pub(in crate::output) fn force(&self, depth: f64) -> Option<f64> {
        let (from, to) = (
            (depth - FORCE_WINDOW / 2.0).max(self.first_depth()),
            (depth + FORCE_WINDOW / 2.0).min(self.greatest_depth()),
        );
        let (from, to) = (self.interpolate(from), self.interpolate(to));
        (to.path > from.path).then(|| (to.energy - from.energy) / (to.path - from.path))
    }

    /// Returns the mean force across the line of fire, N, over the same window.
    pub(in crate::output) fn side_force(&self, depth: f64) -> Option<f64> {
        let from = self.interpolate((depth - FORCE_WINDOW / 2.0).max(self.first_depth()));
        let to = self.interpolate((depth + FORCE_WINDOW / 2.0).min(self.greatest_depth()));
        (to.time > from.time).then(|| (to.side_impulse - from.side_impulse).norm() / (to.time - from.time))
    }

    /// Returns the length of the neck, m: the depth at which the yaw first passes 30°; `None` if it never does, or does
    /// from the start.
    pub(in crate::output) fn neck_length(&self) -> Option<f64> {
        let after = self.points.iter().position(|place| place.yaw >= NECK_YAW)?;
        let (a, b) = (self.points.get(after.checked_sub(1)?)?, &self.points[after]);
        Some(a.depth + (NECK_YAW - a.yaw) / (b.yaw - a.yaw) * (b.depth - a.depth))
    }

    /// Returns the energy given to the gel in each centimetre of depth, J; the last centimetre ends at the greatest
    /// depth.
    pub(in crate::output) fn energy_per_centimetre(&self) -> Vec<f64> {
        let n = (((self.greatest_depth() - DEPTH_TOLERANCE) * CENTIMETRES).ceil() as usize).min(MAX_DEPTHS);
        let end =
            |i: usize| if i == n { self.greatest_depth() } else { (i as f64 / CENTIMETRES).min(self.greatest_depth()) };
        (0..n).map(|i| self.energy_between(end(i), end(i + 1))).collect()
    }

    /// Returns the energy given to the gel between two depths, J: there is none below the greatest depth.
    pub(super) fn energy_between(&self, from: f64, to: f64) -> f64 {
        let reached = |depth: f64| self.interpolate(depth.min(self.greatest_depth())).energy;
        reached(to) - reached(from)
    }

    /// Returns the speed along −z relative to the block at the first arrival at a depth, m/s; `None` for a projectile that
    /// goes no deeper, or begins deeper.
    pub(super) fn speed_at(&self, depth: f64) -> Option<f64> {
        let passes = self.first_depth() < depth + DEPTH_TOLERANCE && self.greatest_depth() > depth + DEPTH_TOLERANCE;
        passes.then(|| self.interpolate(depth).velocity)
    }

    /// Returns the depth of the gel at rest, m.
    pub(super) fn gel_depth(&self) -> f64 {
        self.end
    }

    /// Returns the text of `shot.csv`.
    pub(super) fn csv(&self) -> String {
        let mut text =
            String::from("depth_m,time_s,velocity_m_per_s,force_N,energy_J,yaw_rad,side_force_N,expansion\n");
        for place in self.table() {
            let TrackPoint { depth, time, velocity, energy, yaw, expansion, .. } = place;
            let [force, side_force] =
                [self.force(depth), self.side_force(depth)].map(|force| force.unwrap_or(f64::NAN));
            let row = [depth, time, velocity, force, energy, yaw, side_force, expansion].map(format_cell);
            writeln!(text, "{}", row.join(",")).expect("a string grows");
        }
        text
    }

    /// Returns the least depth of the track, m: 0 unless the run began deeper.
    fn first_depth(&self) -> f64 {
        self.points.first().map_or(0.0, |first| first.depth.max(0.0))
    }

    /// Interpolates the track at a depth with constant force between communication steps: energy and v² are linear in
    /// depth.
    fn interpolate(&self, depth: f64) -> TrackPoint {
        let next = self.points.partition_point(|place| place.depth < depth);
        let (Some(b), Some(a)) = (self.points.get(next), self.points.get(next.saturating_sub(1))) else {
            return *self.points.last().expect("a way has a place");
        };
        if b.depth <= a.depth {
            return *b;
        }
        let share = (depth - a.depth) / (b.depth - a.depth);
        let between = |from: f64, to: f64| from + share * (to - from);
        TrackPoint {
            depth,
            time: between(a.time, b.time),
            path: between(a.path, b.path),
            velocity: between(a.velocity * a.velocity.abs(), b.velocity * b.velocity.abs()).max(0.0).sqrt(),
            energy: between(a.energy, b.energy),
            yaw: between(a.yaw, b.yaw),
            side_impulse: a.side_impulse + share * (b.side_impulse - a.side_impulse),
            expansion: between(a.expansion, b.expansion),
        }
    }
}

#[cfg(test)]
impl ProjectileTrack {
    /// Creates the track of a mass of 1 kg through these depths, m, in a gel of a depth, m; a constant force, N, brakes it
    /// from a speed, m/s.
    pub(super) fn with_depths(depths: impl Iterator<Item = f64>, speed: f64, force: f64, gel_depth: f64) -> Self {
        let (mut points, mut first) = (vec![], None);
        for depth in depths {
            let path = depth - *first.get_or_insert(depth);
            let velocity = (speed * speed - 2.0 * force * path).sqrt();
            let time = (speed - velocity) / force;
            let (energy, yaw, side_impulse) = (force * path, 0.0, Vector2::zeros());
            points.push(TrackPoint { depth, time, path, velocity, energy, yaw, side_impulse, expansion: 0.0 });
        }
        Self { points, end: gel_depth }
    }
}

/// Sums over the rows of a history so far.
#[derive(Debug, Clone, Copy, Default)]
struct TrackSums {
    /// Energy given to the gel, J.
    energy: f64,
    /// Impulse of the gel on the projectile across the line of fire, N·s.
    side_impulse: Vector2<f64>,
}

/// Appends a row deeper than all rows before; only the last row above the gel is kept.
fn append_deeper(points: &mut Vec<TrackPoint>, end: f64, row: &HistoryRow, velocity: f64, sums: &TrackSums) {
    let depth = row.get("depth_m");
    let deepest = points.last().map_or(f64::NEG_INFINITY, |last| last.depth);
    if !depth.is_finite() || depth <= deepest || deepest >= end {
        return;
    }
    if depth <= 0.0 {
        points.clear();
    }
    let [time, yaw, expansion] = ["time_s", "yaw_rad", "expansion"].map(|name| row.get(name));
    let yaw = if velocity < 0.0 { std::f64::consts::PI - yaw } else { yaw };
    let &TrackSums { energy, side_impulse } = sums;
    let path = row.get("block_displacement_z_m") - row.get("position_z_m");
    points.push(TrackPoint { depth, time, path, velocity, energy, yaw, side_impulse, expansion });
}

/// Returns the energy given to the gel in the step that ends with this row, J.
fn energy_given(before: &StepVelocities, row: &HistoryRow, now: &StepVelocities) -> f64 {
    let (impulse, angular) = (row.vector("impulse_", "_N_s"), row.vector("angular_impulse_", "_N_m_s"));
    -0.5 * (impulse.dot(&(before.velocity + now.velocity)) + angular.dot(&(before.spin + now.spin)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a track of 10 cm at 100 m/s with a yaw of 0.1 rad per cm and 2 N across the line of fire.
    fn track() -> ProjectileTrack {
        let point = |i: i32| {
            let depth = 0.01 * f64::from(i);
            let time = depth / 100.0;
            let (yaw, side_impulse) = (0.1 * f64::from(i), Vector2::new(1.2, -1.6) * time);
            TrackPoint { depth, time, path: depth, velocity: 100.0, energy: 0.0, yaw, side_impulse, expansion: 0.0 }
        };
        ProjectileTrack { points: (0..=10).map(point).collect(), end: 1.0 }
    }

    #[test]
    fn the_neck_ends_where_the_yaw_passes_30_degrees() {
        let mut track = track();
        assert!((track.neck_length().unwrap() - 0.1 * NECK_YAW).abs() < 1e-12);
        track.points.truncate(5);
        assert_eq!(track.neck_length(), None);
    }

    #[test]
    fn the_side_force_is_the_rate_of_the_side_impulse() {
        for depth in [0.0, 0.013, 0.1] {
            assert!((track().side_force(depth).unwrap() - 2.0).abs() < 1e-9, "{depth}");
        }
    }
}
