//! Cavity behind a projectile: radius against time and depth.

use super::opening::{DepthGrid, GelSection, void_radii};
use super::shot_line::{DEPTHS_PER_METRE, ShotLine, depths_per_metre};
use crate::output::files::format_cell;
use crate::scene::Scene;
use crate::simulation::MeshFrame;
use std::fmt::Write;

/// Cavity profile: radius against depth at one time.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::output) struct CavityProfile {
    /// Time of the profile, s.
    pub(in crate::output) time: f64,
    /// Number of depths per metre: 1000, fewer in a very deep gel.
    per_metre: f64,
    /// Radius at each depth, m, the first depth one interval below the entry. A radius of 0 means gel on the shot
    /// line, `None` a void without gel all around.
    radii: Vec<Option<f64>>,
}

/// Cavity figures of a run.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::output) struct CavityFigures {
    /// Greatest diameter, m.
    pub(in crate::output) greatest_diameter: f64,
    /// Time of the greatest diameter, s.
    pub(in crate::output) time_of_greatest: f64,
    /// Greatest diameter at the end, m.
    pub(in crate::output) last_diameter: f64,
    /// Temporary cavity: depth, m, and greatest radius of the run at this depth, m.
    pub(in crate::output) temporary: Vec<(f64, f64)>,
    /// Cavity at the time of the greatest diameter: depth, m, and radius, m.
    pub(in crate::output) widest: Vec<(f64, f64)>,
    /// Cavity at the end: depth, m, and radius, m.
    pub(in crate::output) last: Vec<(f64, f64)>,
}

impl CavityProfile {
    /// Computes the profile of a frame.
    pub(in crate::output) fn of(line: &ShotLine, scene: &Scene, frame: &MeshFrame) -> Self {
        let per_metre = depths_per_metre(line.gel_depth);
        let depths = DepthGrid { n: (line.gel_depth * per_metre) as usize, per_metre };
        let gel = GelSection { dimension: scene.scene.dimension, symmetry: scene.gel.symmetry };
        Self { time: frame.time, per_metre, radii: void_radii(gel, frame, &line.origin, depths) }
    }

    /// Returns the part of the void behind the projectile, from the entry to the first depth closed by gel. The part
    /// ends at `depth`, m, the greatest depth reached by the foremost point. A deeper void was not opened by the
    /// projectile, and a void below a closure is not connected with the entry.
    pub(super) fn behind_projectile(&self, depth: f64) -> Self {
        let is_behind = |k: usize| (k + 1) as f64 <= depth * self.per_metre * (1.0 + f64::EPSILON);
        let closure = self.radii.iter().position(|radius| *radius == Some(0.0)).unwrap_or(self.radii.len());
        let radii = self.radii.iter().enumerate().map(|(k, radius)| radius.filter(|_| k <= closure && is_behind(k)));
        Self { radii: radii.collect(), ..*self }
    }

    /// Returns the greatest diameter, m, below one projectile length; the diameter above belongs to the entry crater.
    pub(super) fn diameter(&self, line: &ShotLine) -> f64 {
        let deep = self.curve().into_iter().filter(|(depth, _)| *depth > line.projectile_length);
        2.0 * deep.map(|(_, radius)| radius).fold(0.0, f64::max)
    }

    /// Returns depth, m, and radius, m, down to the end of the cavity, at the depths enclosed by gel.
    fn curve(&self) -> Vec<(f64, f64)> {
        let end = self.radii.iter().rposition(|radius| radius.is_some_and(|radius| radius > 0.0));
        let known = self.radii.iter().zip(1..).take(end.map_or(0, |end| end + 1));
        known.filter_map(|(radius, i)| radius.map(|radius| (f64::from(i) / self.per_metre, radius))).collect()
    }
}

impl CavityFigures {
    pub(super) fn of(line: &ShotLine, profiles: &[CavityProfile]) -> Self {
        let diameters: Vec<f64> = profiles.iter().map(|profile| profile.diameter(line)).collect();
        let widest = (0..profiles.len()).reduce(|a, b| if diameters[b] > diameters[a] { b } else { a });
        let curve = |i: Option<usize>| i.map_or(vec![], |i| profiles[i].curve());
        Self {
            greatest_diameter: widest.map_or(0.0, |i| diameters[i]),
            time_of_greatest: widest.map_or(0.0, |i| profiles[i].time),
            last_diameter: diameters.last().copied().unwrap_or(0.0),
            temporary: envelope(profiles).curve(),
            widest: curve(widest),
            last: curve(profiles.len().checked_sub(1)),
        }
    }
}

/// Returns the greatest radius at each depth.
fn envelope(profiles: &[CavityProfile]) -> CavityProfile {
    let wider = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) => Some(a.max(b)),
        (a, b) => a.or(b),
    };
    let n = profiles.iter().map(|profile| profile.radii.len()).max().unwrap_or(0);
    let radius = |i: usize| profiles.iter().map(|profile| profile.radii.get(i).copied().flatten()).fold(None, wider);
    let per_metre = profiles.first().map_or(DEPTHS_PER_METRE, |profile| profile.per_metre);
    CavityProfile { time: 0.0, per_metre, radii: (0..n).map(radius).collect() }
}

/// Returns the text of `cavity.csv`: each profile down to the end of the cavity.
pub(super) fn csv(profiles: &[CavityProfile]) -> String {
    let mut text = String::from("time_s,depth_m,radius_m\n");
    for profile in profiles {
        for (depth, radius) in profile.curve() {
            writeln!(text, "{},{},{}", format_cell(profile.time), format_cell(depth), format_cell(radius))
                .expect("a string grows");
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
        let profile = CavityProfile { time: 0.0, per_metre: DEPTHS_PER_METRE, radii: radii.to_vec() };
        assert_eq!(profile.behind_projectile(0.01).radii, [Some(0.004), Some(0.002), Some(0.0), None, None, None]);
        assert_eq!(profile.behind_projectile(0.001).radii, [Some(0.004), None, None, None, None, None]);
    }
}
