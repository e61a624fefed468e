//! The cavity behind a projectile: how wide the gel is open, by time and depth.

use super::opening::{Depths, GelSection, openings};
use super::{Line, PER_METRE, per_metre};
use crate::output::files::cell;
use crate::scene::Scene;
use crate::simulation::Frame;
use std::fmt::Write;

/// Radius of the cavity against depth at one time.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::output) struct Profile {
    /// When, s.
    pub(in crate::output) time: f64,
    /// Depths in a metre: one in each millimetre, fewer in a very deep gel.
    per_metre: f64,
    /// Radius at each of these depths from the first one on, m: 0 where the line of the shot is in the gel, none where the void
    /// around it is no cavity.
    radii: Vec<Option<f64>>,
}

/// The cavities of a run.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::output) struct Cavity {
    /// Greatest diameter, m, and when, s.
    pub(in crate::output) greatest: (f64, f64),
    /// Greatest diameter at the end, m.
    pub(in crate::output) last_diameter: f64,
    /// The temporary cavity: (depth, m, greatest radius of the run there, m).
    pub(in crate::output) temporary: Vec<(f64, f64)>,
    /// The cavity when it was widest, as (depth, radius).
    pub(in crate::output) widest: Vec<(f64, f64)>,
    /// The cavity at the end, as (depth, radius).
    pub(in crate::output) last: Vec<(f64, f64)>,
}

impl Profile {
    /// That of a frame.
    pub(in crate::output) fn of(line: &Line, scene: &Scene, frame: &Frame) -> Self {
        let per_metre = per_metre(line.gel);
        let depths = Depths { n: (line.gel * per_metre) as usize, per_metre };
        let gel = GelSection { dimension: scene.scene.dimension, symmetry: scene.gel.symmetry };
        Self { time: frame.time, per_metre, radii: openings(gel, frame, &line.at, depths) }
    }

    /// The part of the void that lies behind the projectile: from the entry down to where gel closes it, and to the greatest depth, m,
    /// that the foremost point of the projectile has reached. What is open deeper was not opened by its passage, and a void below a
    /// closure is no longer connected with the entry.
    pub(super) fn behind(&self, depth: f64) -> Self {
        let is_behind = |k: usize| (k + 1) as f64 <= depth * self.per_metre * (1.0 + f64::EPSILON);
        let closure = self.radii.iter().position(|radius| *radius == Some(0.0)).unwrap_or(self.radii.len());
        let radii = self.radii.iter().enumerate().map(|(k, radius)| radius.filter(|_| k <= closure && is_behind(k)));
        Self { radii: radii.collect(), ..*self }
    }

    /// Greatest diameter, m, deeper than the projectile is long: nearer to the entry it is the crater's.
    fn diameter(&self, line: &Line) -> f64 {
        let deep = self.curve().into_iter().filter(|(depth, _)| *depth > line.size);
        2.0 * deep.map(|(_, radius)| radius).fold(0.0, f64::max)
    }

    /// (depth, m, radius, m) as far as the cavity reaches, where there is gel around it.
    fn curve(&self) -> Vec<(f64, f64)> {
        let end = self.radii.iter().rposition(|radius| radius.is_some_and(|radius| radius > 0.0));
        let known = self.radii.iter().zip(1..).take(end.map_or(0, |end| end + 1));
        known.filter_map(|(radius, i)| radius.map(|radius| (f64::from(i) / self.per_metre, radius))).collect()
    }
}

impl Cavity {
    pub(super) fn of(line: &Line, profiles: &[Profile]) -> Self {
        let diameters: Vec<f64> = profiles.iter().map(|profile| profile.diameter(line)).collect();
        let widest = (0..profiles.len()).reduce(|a, b| if diameters[b] > diameters[a] { b } else { a });
        let curve = |i: Option<usize>| i.map_or(vec![], |i| profiles[i].curve());
        Self {
            greatest: widest.map_or((0.0, 0.0), |i| (diameters[i], profiles[i].time)),
            last_diameter: diameters.last().copied().unwrap_or(0.0),
            temporary: envelope(profiles).curve(),
            widest: curve(widest),
            last: curve(profiles.len().checked_sub(1)),
        }
    }
}

/// The greatest radius at each depth.
fn envelope(profiles: &[Profile]) -> Profile {
    let wider = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) => Some(a.max(b)),
        (a, b) => a.or(b),
    };
    let n = profiles.iter().map(|profile| profile.radii.len()).max().unwrap_or(0);
    let radius = |i: usize| profiles.iter().map(|profile| profile.radii.get(i).copied().flatten()).fold(None, wider);
    let per_metre = profiles.first().map_or(PER_METRE, |profile| profile.per_metre);
    Profile { time: 0.0, per_metre, radii: (0..n).map(radius).collect() }
}

/// `cavity.csv`: each profile as far as the cavity reaches.
pub(super) fn csv(profiles: &[Profile]) -> String {
    let mut text = String::from("time_s,depth_m,radius_m\n");
    for profile in profiles {
        for (depth, radius) in profile.curve() {
            writeln!(text, "{},{},{}", cell(profile.time), cell(depth), cell(radius)).expect("a string grows");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_void_below_a_closure_is_not_connected_with_the_entry() {
        let radii = [Some(0.004), Some(0.002), Some(0.0), Some(0.003), Some(0.003), None];
        let profile = Profile { time: 0.0, per_metre: PER_METRE, radii: radii.to_vec() };
        assert_eq!(profile.behind(0.01).radii, [Some(0.004), Some(0.002), Some(0.0), None, None, None]);
        assert_eq!(profile.behind(0.001).radii, [Some(0.004), None, None, None, None, None]);
    }
}
