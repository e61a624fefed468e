//! The way of a projectile through the gel, by depth instead of time.

use super::{Line, MOST_DEPTHS, per_metre};
use crate::math::Vector3;
use crate::output::files::{OutputError, cell};
use crate::output::history::{History, Row};
use std::fmt::Write;

/// Depth over which a force is a mean, m: a communication step of a shot is some millimetres long.
const WINDOW: f64 = 4e-3;
const CENTIMETRES: f64 = 100.0;
/// Depths that differ by less, m, are the same but for round-off.
const ROUND_OFF: f64 = 1e-9;

/// What is known of the projectile at a depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::output) struct Along {
    /// Depth of its foremost point, m.
    pub(in crate::output) depth: f64,
    /// When it first got there, s.
    pub(in crate::output) time: f64,
    /// Speed along −z, m/s.
    pub(in crate::output) velocity: f64,
    /// Energy given to the gel until then, J.
    pub(in crate::output) energy: f64,
    /// Angle between its axis and its velocity, or the way it came once it goes back, rad.
    pub(in crate::output) yaw: f64,
}

/// The way to the greatest depth, each depth at the time at which it was first reached.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::output) struct Track {
    way: Vec<Along>,
    /// Greatest depth that is shown, m: that of the gel.
    end: f64,
}

/// The motion at the end of a communication step.
struct Motion {
    velocity: Vector3,
    spin: Vector3,
}

impl Motion {
    fn of(row: &Row) -> Self {
        Self { velocity: row.triple("velocity_", "_m_per_s"), spin: row.triple("angular_velocity_", "_rad_per_s") }
    }
}

impl Track {
    /// Reads the way from the history. The energy given in a communication step is −J·(v₀ + v₁)/2 − A·(ω₀ + ω₁)/2: exact for
    /// a body on which nothing else acts.
    pub(super) fn of(line: &Line, history: &History) -> Result<Self, OutputError> {
        let mut way: Vec<Along> = vec![];
        let (mut before, mut energy) = (None, 0.0);
        history.each(|row| {
            let now = Motion::of(row);
            energy += before.as_ref().map_or(0.0, |before| given(before, row, &now));
            take(&mut way, line.gel, (row, -now.velocity.z, energy));
            before = Some(now);
        })?;
        Ok(Self { way, end: line.gel })
    }

    /// The greatest depth, m.
    pub(super) fn depth(&self) -> f64 {
        self.way.last().map_or(0.0, |last| last.depth.min(self.end))
    }

    /// The greatest depth up to a time, s, in m.
    pub(super) fn depth_until(&self, time: f64) -> f64 {
        let until = self.way.partition_point(|place| place.time <= time);
        self.way[..until].last().map_or(0.0, |last| last.depth.min(self.end))
    }

    /// The places of the table: every millimetre, or as many as there may be, and the greatest depth.
    pub(in crate::output) fn table(&self) -> Vec<Along> {
        let per_metre = per_metre(self.depth());
        let n = (self.depth() * per_metre) as usize;
        let whole = (0..=n)
            .map(|i| i as f64 / per_metre)
            .filter(|depth| *depth >= self.first() && *depth < self.depth() - ROUND_OFF);
        whole.chain([self.depth()]).map(|depth| self.at(depth)).collect()
    }

    /// Mean force against the motion over 4 mm of depth around a place, N; over what there is of them at the ends. Of a single
    /// place there is none.
    pub(in crate::output) fn force(&self, depth: f64) -> Option<f64> {
        let (from, to) = ((depth - WINDOW / 2.0).max(self.first()), (depth + WINDOW / 2.0).min(self.depth()));
        (to > from).then(|| (self.at(to).energy - self.at(from).energy) / (to - from))
    }

    /// Energy given to the gel in each centimetre of depth, J; the last one ends at the greatest depth, however deep that is.
    pub(in crate::output) fn energy_per_centimetre(&self) -> Vec<f64> {
        let n = (((self.depth() - ROUND_OFF) * CENTIMETRES).ceil() as usize).min(MOST_DEPTHS);
        let end = |i: usize| if i == n { self.depth() } else { (i as f64 / CENTIMETRES).min(self.depth()) };
        let reached = |i: usize| self.at(end(i)).energy;
        (0..n).map(|i| reached(i + 1) - reached(i)).collect()
    }

    /// `shot.csv`.
    pub(super) fn csv(&self) -> String {
        let mut text = String::from("depth_m,time_s,velocity_m_per_s,force_N,energy_J,yaw_rad\n");
        for place in self.table() {
            let Along { depth, time, velocity, energy, yaw } = place;
            let force = self.force(depth).unwrap_or(f64::NAN);
            let row = [depth, time, velocity, force, energy, yaw].map(cell);
            writeln!(text, "{}", row.join(",")).expect("a string grows");
        }
        text
    }

    /// Least depth of which anything is known, m: 0, unless it began deeper.
    fn first(&self) -> f64 {
        self.way.first().map_or(0.0, |first| first.depth.max(0.0))
    }

    /// Between two communication steps the force is taken as constant: then energy and v² are linear in depth.
    fn at(&self, depth: f64) -> Along {
        let next = self.way.partition_point(|place| place.depth < depth);
        let (Some(b), Some(a)) = (self.way.get(next), self.way.get(next.saturating_sub(1))) else {
            return *self.way.last().expect("a way has a place");
        };
        if b.depth <= a.depth {
            return *b;
        }
        let share = (depth - a.depth) / (b.depth - a.depth);
        let between = |from: f64, to: f64| from + share * (to - from);
        Along {
            depth,
            time: between(a.time, b.time),
            velocity: between(a.velocity * a.velocity.abs(), b.velocity * b.velocity.abs()).max(0.0).sqrt(),
            energy: between(a.energy, b.energy),
            yaw: between(a.yaw, b.yaw),
        }
    }
}

/// Adds a row that is deeper than all before it; of those above the gel only the last is kept.
fn take(way: &mut Vec<Along>, end: f64, (row, velocity, energy): (&Row, f64, f64)) {
    let depth = row.get("depth_m");
    let deepest = way.last().map_or(f64::NEG_INFINITY, |last| last.depth);
    if !depth.is_finite() || depth <= deepest || deepest >= end {
        return;
    }
    if depth <= 0.0 {
        way.clear();
    }
    let (time, yaw) = (row.get("time_s"), row.get("yaw_rad"));
    let yaw = if velocity < 0.0 { std::f64::consts::PI - yaw } else { yaw };
    way.push(Along { depth, time, velocity, energy, yaw });
}

/// Energy that the projectile gave to the gel in the step that ends with this row, J.
fn given(before: &Motion, row: &Row, now: &Motion) -> f64 {
    let (impulse, angular) = (row.triple("impulse_", "_N_s"), row.triple("angular_impulse_", "_N_m_s"));
    -0.5 * (impulse.dot(&(before.velocity + now.velocity)) + angular.dot(&(before.spin + now.spin)))
}
