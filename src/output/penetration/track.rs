//! Track of a projectile through the gel: motion and energy against depth.

use super::shot_line::{MAX_DEPTHS, ShotLine, depths_per_metre};
use crate::math::Vector3;
use crate::output::files::{OutputError, format_cell};
use crate::output::history::{HistoryFile, HistoryRow};
use std::fmt::Write;

/// Depth window of the mean force, m: a communication step of a shot covers some millimetres.
const FORCE_WINDOW: f64 = 4e-3;
const CENTIMETRES: f64 = 100.0;
/// Tolerance of depths, m, for round-off.
const DEPTH_TOLERANCE: f64 = 1e-9;

/// State of the projectile at a depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::output) struct TrackPoint {
    /// Depth of the foremost point, m.
    pub(in crate::output) depth: f64,
    /// Time of the first arrival at the depth, s.
    pub(in crate::output) time: f64,
    /// Speed along −z, m/s.
    pub(in crate::output) velocity: f64,
    /// Energy given to the gel down to the depth, J.
    pub(in crate::output) energy: f64,
    /// Yaw, rad: angle between axis and velocity, or between axis and reversed velocity on the way back.
    pub(in crate::output) yaw: f64,
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
    velocity: Vector3,
    spin: Vector3,
}

impl StepVelocities {
    fn of(row: &HistoryRow) -> Self {
        Self { velocity: row.vector("velocity_", "_m_per_s"), spin: row.vector("angular_velocity_", "_rad_per_s") }
    }
}

impl ProjectileTrack {
    /// Reads the track from the history. The energy given in a communication step is −J·(v₀ + v₁)/2 − A·(ω₀ + ω₁)/2,
    /// exact for a body without other loads.
    pub(super) fn of(line: &ShotLine, history: &HistoryFile) -> Result<Self, OutputError> {
        let mut points: Vec<TrackPoint> = vec![];
        let (mut before, mut energy) = (None, 0.0);
        history.for_each_row(|row| {
            let now = StepVelocities::of(row);
            energy += before.as_ref().map_or(0.0, |before| energy_given(before, row, &now));
            append_deeper(&mut points, line.gel_depth, row, -now.velocity.z, energy);
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

    /// Returns the mean retarding force, N, over a window of 4 mm around a depth, clipped at both ends of the track.
    /// A track of one point has no force.
    pub(in crate::output) fn force(&self, depth: f64) -> Option<f64> {
        let (from, to) = (
            (depth - FORCE_WINDOW / 2.0).max(self.first_depth()),
            (depth + FORCE_WINDOW / 2.0).min(self.greatest_depth()),
        );
        (to > from).then(|| (self.interpolate(to).energy - self.interpolate(from).energy) / (to - from))
    }

    /// Returns the energy given to the gel in each centimetre of depth, J; the last centimetre ends at the greatest
    /// depth.
    pub(in crate::output) fn energy_per_centimetre(&self) -> Vec<f64> {
        let n = (((self.greatest_depth() - DEPTH_TOLERANCE) * CENTIMETRES).ceil() as usize).min(MAX_DEPTHS);
        let end =
            |i: usize| if i == n { self.greatest_depth() } else { (i as f64 / CENTIMETRES).min(self.greatest_depth()) };
        let reached = |i: usize| self.interpolate(end(i)).energy;
        (0..n).map(|i| reached(i + 1) - reached(i)).collect()
    }

    /// Returns the text of `shot.csv`.
    pub(super) fn csv(&self) -> String {
        let mut text = String::from("depth_m,time_s,velocity_m_per_s,force_N,energy_J,yaw_rad\n");
        for place in self.table() {
            let TrackPoint { depth, time, velocity, energy, yaw } = place;
            let force = self.force(depth).unwrap_or(f64::NAN);
            let row = [depth, time, velocity, force, energy, yaw].map(format_cell);
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
            velocity: between(a.velocity * a.velocity.abs(), b.velocity * b.velocity.abs()).max(0.0).sqrt(),
            energy: between(a.energy, b.energy),
            yaw: between(a.yaw, b.yaw),
        }
    }
}

/// Appends a row deeper than all rows before; only the last row above the gel is kept.
fn append_deeper(points: &mut Vec<TrackPoint>, end: f64, row: &HistoryRow, velocity: f64, energy: f64) {
    let depth = row.get("depth_m");
    let deepest = points.last().map_or(f64::NEG_INFINITY, |last| last.depth);
    if !depth.is_finite() || depth <= deepest || deepest >= end {
        return;
    }
    if depth <= 0.0 {
        points.clear();
    }
    let (time, yaw) = (row.get("time_s"), row.get("yaw_rad"));
    let yaw = if velocity < 0.0 { std::f64::consts::PI - yaw } else { yaw };
    points.push(TrackPoint { depth, time, velocity, energy, yaw });
}

/// Returns the energy given to the gel in the step that ends with this row, J.
fn energy_given(before: &StepVelocities, row: &HistoryRow, now: &StepVelocities) -> f64 {
    let (impulse, angular) = (row.vector("impulse_", "_N_s"), row.vector("angular_impulse_", "_N_m_s"));
    -0.5 * (impulse.dot(&(before.velocity + now.velocity)) + angular.dot(&(before.spin + now.spin)))
}
