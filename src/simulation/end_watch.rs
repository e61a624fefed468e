//! Watch over the end of a run: the turn of the cavity after an exit, and the rest of the projectile in the gel.
//!
//! The watch looks at times of its own, multiples of an interval, never at communication points: the end that it finds
//! does not depend on them.

use super::opening::{DepthGrid, GelSection, void_radii};
use crate::math::Vector3;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// Interval between two looks, s: the greatest diameter of a cavity lasts for some tenths of a millisecond.
const INTERVAL: f64 = 1e-4;
/// Greatest number of looks up to `scene.end_time`: a longer run has a longer interval.
const MOST_LOOKS: f64 = 1e4;
/// Fraction of its greatest diameter below which a cavity has turned.
const TURNED: f64 = 0.95;
/// Time for which a projectile at rest stays within [`REST_BAND`], s.
const REST_TIME: f64 = 2e-3;
/// Greatest change of the depth within that time, m. The calibration shot ends after 10.8 of 13.8 ms by it, with a rest
/// depth that changes by 0.05 mm from then on (`draft`).
const REST_BAND: f64 = 1e-4;
/// Greatest change of the diameter of the cavity within that time, as a fraction of the greatest diameter.
const CAVITY_BAND: f64 = 0.05;
/// Number of depths at which the cavity is measured.
const N_DEPTHS: usize = 200;
/// Greatest ratio of lateral to axial speed of a shot along −z.
const MAX_DRIFT: f64 = 0.1;

/// End rules of a scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct EndRules {
    /// Time from the exit of the projectile to the end of the run, s.
    pub stop_after_exit: f64,
    /// True if a run ends by the exit only after the cavity has turned.
    pub awaits_cavity: bool,
    /// True if a run ends when the projectile rests.
    pub stops_at_rest: bool,
    /// Line of the shot; `None` for a body that does not fly along −z, or a gel without a back face.
    pub line: Option<CavityLine>,
    /// Latest end of the run, s: nothing is awaited from then on.
    end_time: f64,
    /// Interval between two looks, s.
    interval: f64,
}

/// Returns true if a velocity relative to the block, m/s, is that of a shot along −z.
#[must_use]
pub fn is_shot(velocity: &Vector3) -> bool {
    velocity.z < 0.0 && velocity.xy().norm() <= MAX_DRIFT * -velocity.z
}

/// Vertical line of a shot, about which the cavity is measured.
#[derive(Debug, Clone, Copy)]
pub(super) struct CavityLine {
    origin: Vector3,
    /// Depth of the gel at rest, m.
    depth: f64,
    section: GelSection,
}

impl CavityLine {
    /// Returns the line of a projectile with initial motion along −z against a block of this velocity, m/s.
    fn of(scene: &Scene, block: &Vector3) -> Option<Self> {
        let gel = scene.gel.shape.bounding_box()?;
        let velocity = Vector3::from(scene.projectile.velocity) - block;
        let section = GelSection { dimension: scene.scene.dimension, symmetry: scene.gel.symmetry };
        is_shot(&velocity).then_some(Self { origin: scene.projectile.position.into(), depth: -gel.lower.z, section })
    }

    /// Returns the greatest diameter of the cavity from the entry to the first depth closed by gel, at depths between
    /// `first` and `rear`, m; 0 without a cavity. `facets` are the corners of the surface of the gel.
    pub(super) fn diameter(&self, facets: impl Iterator<Item = [Vector3; 3]>, first: f64, rear: f64) -> f64 {
        let per_metre = N_DEPTHS as f64 / self.depth;
        let radii = void_radii(self.section, facets, &self.origin, DepthGrid { n: N_DEPTHS, per_metre });
        let open = radii.into_iter().zip(1..).take_while(|(radius, _)| *radius != Some(0.0));
        let is_behind = |depth: f64| depth > first && depth <= rear;
        let counted = open.filter(|(_, k)| is_behind(f64::from(*k) / per_metre));
        2.0 * counted.filter_map(|(radius, _)| radius).fold(0.0, f64::max)
    }
}

impl EndRules {
    /// Returns the rules of a scene whose block starts with this velocity, m/s.
    pub fn of(scene: &Scene, block: &Vector3) -> Self {
        Self {
            stop_after_exit: scene.scene.stop_after_exit.time(),
            awaits_cavity: scene.scene.await_cavity,
            stops_at_rest: scene.scene.stop_at_rest,
            line: CavityLine::of(scene, block),
            end_time: scene.scene.end_time,
            interval: INTERVAL.max(scene.scene.end_time / MOST_LOOKS),
        }
    }

    /// Returns the time of the next look, s; `None` if nothing is awaited, or the last look is over.
    pub fn next_look(&self, time: f64, watch: &EndWatch) -> Option<f64> {
        let awaits_turn = self.awaits_cavity && self.stop_after_exit.is_finite() && self.line.is_some();
        let is_awaited = (awaits_turn || self.stops_at_rest) && !watch.is_last;
        let passed = (time / self.interval).floor();
        let looks = [0.0, 1.0, 2.0].map(|k| (passed + k) * self.interval);
        looks.into_iter().find(|look| *look > time).filter(|_| is_awaited)
    }

    /// Returns the time from the exit of the projectile until the gel is put to rest, s; infinite while the cavity is
    /// awaited.
    pub fn rest_after(&self, watch: &EndWatch) -> f64 {
        if self.has_turned(watch) { self.stop_after_exit } else { f64::INFINITY }
    }

    /// Returns true if the cavity has turned or is not awaited.
    fn has_turned(&self, watch: &EndWatch) -> bool {
        !self.awaits_cavity || self.line.is_none() || watch.has_turned || watch.is_last
    }

    /// Returns true if no look follows one at this time, s.
    pub fn is_last(&self, time: f64) -> bool {
        time >= self.end_time
    }
}

/// Projectile and cavity at a look.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EndSample {
    /// Time, s.
    pub time: f64,
    /// Depth of the foremost point in the block, m.
    pub depth: f64,
    /// Greatest diameter of the cavity, m.
    pub diameter: f64,
    /// True if the projectile has left the gel at its back.
    pub has_left: bool,
    /// True if the projectile is in the gel, and every other body is still or away.
    pub may_rest: bool,
}

/// Findings of the looks so far.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct EndWatch {
    /// Greatest diameter of the cavity, m.
    greatest: f64,
    /// True if the projectile has left the gel, and the cavity has turned.
    has_turned: bool,
    /// First look from which on projectile and cavity have stood still.
    still_since: Option<EndSample>,
    /// True if the projectile rests.
    rests: bool,
    /// True if the latest end of the run has passed.
    pub(super) is_last: bool,
}

impl EndWatch {
    /// Adds a look.
    pub(super) fn add(&mut self, sample: EndSample) {
        self.greatest = self.greatest.max(sample.diameter);
        let is_smaller = sample.diameter <= TURNED * self.greatest;
        self.has_turned = sample.has_left && (self.has_turned || is_smaller);
        let is_near = |from: &EndSample| {
            (sample.depth - from.depth).abs() <= REST_BAND
                && (sample.diameter - from.diameter).abs() <= CAVITY_BAND * self.greatest
        };
        self.still_since = sample.may_rest.then(|| self.still_since.filter(is_near).unwrap_or(sample));
        // The sum of intervals is rounded.
        self.rests = self.still_since.is_some_and(|from| sample.time - from.time >= REST_TIME * (1.0 - 1e-9));
    }

    /// Returns true if the projectile rests in the gel: for 2 ms it has moved by less than 0.1 mm, and the cavity has
    /// kept its diameter.
    #[must_use]
    pub fn rests(&self) -> bool {
        self.rests
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(time: f64, depth: f64, diameter: f64) -> EndSample {
        EndSample { time, depth, diameter, has_left: false, may_rest: true }
    }

    /// Time at which a projectile with a depth and a cavity as functions of time is found to rest, s.
    fn time_of_rest(depth: impl Fn(f64) -> f64, diameter: impl Fn(f64) -> f64) -> Option<f64> {
        let mut watch = EndWatch::default();
        (1..=200).map(|k| f64::from(k) * 1e-4).find(|time| {
            watch.add(sample(*time, depth(*time), diameter(*time)));
            watch.rests()
        })
    }

    #[test]
    fn a_cavity_has_turned_once_it_is_smaller_by_a_twentieth_after_the_exit() {
        let mut watch = EndWatch::default();
        let mut turned = |diameter: f64, has_left: bool| {
            watch.add(EndSample { has_left, ..sample(0.0, 0.1, diameter) });
            watch.has_turned
        };
        assert_eq!([turned(0.08, false), turned(0.05, false)], [false; 2], "the projectile is in the gel");
        assert_eq!([turned(0.09, true), turned(0.1, true), turned(0.096, true)], [false; 3], "a ripple is no turn");
        assert_eq!([turned(0.095, true), turned(0.1, true)], [true; 2]);
        assert!(!turned(0.1, false), "a body that comes back has not left");
    }

    #[test]
    fn a_projectile_rests_when_it_and_the_cavity_have_stood_still_for_two_milliseconds() {
        let stop = |time: f64| 0.085 - 0.02 * (1.0 - time / 3e-3).max(0.0).powi(2);
        let closed = |_: f64| 0.0;
        // The last 0.1 mm take 7 % of the 3 ms.
        let rest = time_of_rest(stop, closed).unwrap();
        assert!((rest - 4.8e-3).abs() < 1.5e-4, "{rest} s");
        let closing = |time: f64| 0.03 * (1.0 - time / 8e-3).max(0.0);
        let later = time_of_rest(stop, closing).unwrap();
        assert!((9.5e-3..=10.1e-3).contains(&later), "a cavity that closes is not cut off: {later} s");
        assert_eq!(time_of_rest(|time| 0.05 + 0.1 * time, closed), None, "0.2 mm in 2 ms are no rest");
    }

    #[test]
    fn looks_are_at_multiples_of_an_interval_and_none_is_left_out() {
        let mut scene = crate::scene::read(crate::scene::builtin("fbi-bb").unwrap()).unwrap();
        // Three times the interval is greater than 3e-4 in double precision: the last look is after the end time.
        for end_time in [8e-3, 3e-4] {
            scene.scene.end_time = end_time;
            let (rules, mut watch) = (EndRules::of(&scene, &Vector3::zeros()), EndWatch::default());
            let n = (end_time / INTERVAL).round() as u32;
            let mut time = 0.0;
            for k in 1..=n {
                let look = rules.next_look(time, &watch).unwrap();
                assert_eq!(look, f64::from(k) * INTERVAL);
                assert_eq!(rules.next_look(look - 1e-9, &watch), Some(look));
                time = look;
            }
            assert!(
                time == end_time || rules.next_look(end_time, &watch) == Some(time),
                "no point leaves out the last"
            );
            watch.is_last = rules.is_last(time);
            assert_eq!(rules.next_look(time, &watch), None, "nothing is awaited after the end time");
        }
    }
}
