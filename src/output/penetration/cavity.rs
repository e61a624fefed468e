//! Cavity behind a projectile: radius against time and depth.

use super::course::{CavityCourse, CavityCoursePoint};
use super::shot_line::{ShotLine, depths_per_metre};
use crate::output::files::format_cell;
use crate::scene::Scene;
use crate::simulation::{DepthGrid, GelSection, MeshFrame, void_radii};
use std::fmt::Write;

/// Cavity profile: radius against depth at one time.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::output) struct CavityProfile {
    /// Time of the profile, s.
    pub(in crate::output) time: f64,
    /// Number of depths per metre: 1000, fewer in a very deep gel.
    per_metre: f64,
    /// Depth of the rear of the projectile, m; infinite if the projectile fills no part of the cavity.
    rear: f64,
    /// Radius at each depth, m, the first depth one interval below the entry. A radius of 0 means gel on the shot
    /// line, `None` a void without gel all around.
    radii: Vec<Option<f64>>,
}

/// Cavity figures of a run.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::output) struct CavityFigures {
    /// Greatest diameter over the depth by time.
    pub(in crate::output) course: CavityCourse,
    /// True if the greatest diameter is that of the last profile.
    pub(in crate::output) still_opens: bool,
    /// Greatest diameter at the end, m; `None` where the rear of the projectile is above the first depth that counts.
    pub(in crate::output) last_diameter: Option<f64>,
}

impl CavityProfile {
    /// Computes the profile of a frame.
    pub(in crate::output) fn of(line: &ShotLine, scene: &Scene, frame: &MeshFrame) -> Self {
        let per_metre = depths_per_metre(line.gel_depth);
        let depths = DepthGrid { n: (line.gel_depth * per_metre) as usize, per_metre };
        let gel = GelSection { dimension: scene.scene.dimension, symmetry: scene.gel.symmetry };
        let rear = ShotLine::rear_depth(scene, frame);
        Self { time: frame.time, per_metre, rear, radii: void_radii(gel, frame.facet_corners(), &line.origin, depths) }
    }

    /// Returns the part of the void behind the projectile, from the entry to the first depth closed by gel. The part
    /// ends at the rear of the projectile: deeper, the projectile itself fills the void. It ends at the latest at
    /// `depth`, m, the greatest depth reached by the foremost point. A deeper void was not opened by the projectile, and
    /// a void below a closure is not connected with the entry.
    pub(super) fn behind_projectile(&self, depth: f64) -> Self {
        let end = depth.min(self.rear);
        let is_behind = |k: usize| (k + 1) as f64 <= end * self.per_metre * (1.0 + f64::EPSILON);
        let closure = self.radii.iter().position(|radius| *radius == Some(0.0)).unwrap_or(self.radii.len());
        let radii = self.radii.iter().enumerate().map(|(k, radius)| radius.filter(|_| k <= closure && is_behind(k)));
        Self { radii: radii.collect(), ..*self }
    }

    /// Returns the greatest diameter below one projectile diameter; the diameter above belongs to the entry crater.
    /// `None` while the rear is not that deep; the diameter is 0 where the cavity is closed above that depth.
    pub(super) fn widest(&self, line: &ShotLine) -> Option<CavityCoursePoint> {
        let first = line.projectile_width;
        let point = |(depth, radius): (f64, f64)| CavityCoursePoint { time: self.time, diameter: 2.0 * radius, depth };
        let deep = self.curve().into_iter().filter(|(depth, _)| *depth > first).map(point);
        let closed = CavityCoursePoint { time: self.time, diameter: 0.0, depth: first };
        let is_closed = self.rear > first + 1.0 / self.per_metre && self.radii.contains(&Some(0.0));
        deep.reduce(|a, b| if b.diameter > a.diameter { b } else { a }).or(is_closed.then_some(closed))
    }

    /// Returns depth, m, and radius, m, down to the end of the cavity, at the depths enclosed by gel.
    pub(super) fn curve(&self) -> Vec<(f64, f64)> {
        let end = self.radii.iter().rposition(|radius| radius.is_some_and(|radius| radius > 0.0));
        let known = self.radii.iter().zip(1..).take(end.map_or(0, |end| end + 1));
        known.filter_map(|(radius, i)| radius.map(|radius| (f64::from(i) / self.per_metre, radius))).collect()
    }
}

#[cfg(test)]
impl CavityProfile {
    /// Returns a profile with a radius each millimetre and no projectile in it.
    pub(super) fn with_radii(time: f64, radii: Vec<Option<f64>>) -> Self {
        Self { time, per_metre: 1000.0, rear: f64::INFINITY, radii }
    }
}

impl CavityFigures {
    pub(super) fn of(line: &ShotLine, profiles: &[CavityProfile]) -> Self {
        let widest: Vec<Option<CavityCoursePoint>> = profiles.iter().map(|profile| profile.widest(line)).collect();
        let last_diameter = widest.last().copied().flatten().map(|point| point.diameter);
        let course = CavityCourse(widest.into_iter().flatten().collect());
        let opened = course.greatest().filter(|greatest| greatest.diameter > 0.0);
        Self {
            still_opens: opened.is_some_and(|widest| profiles.last().is_some_and(|last| last.time == widest.time)),
            last_diameter,
            course,
        }
    }
}

/// Returns the text of `cavity.csv`: each profile down to the end of the cavity.
pub(super) fn csv(profiles: &[CavityProfile]) -> String {
    let mut text = String::from("time_s,depth_m,radius_m,diameter_m\n");
    for profile in profiles {
        for (depth, radius) in profile.curve() {
            let row = [profile.time, depth, radius, 2.0 * radius].map(format_cell);
            writeln!(text, "{}", row.join(",")).expect("a string grows");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector3;

    #[test]
    fn a_void_below_a_closure_is_not_connected_with_the_entry() {
        let radii = [Some(0.004), Some(0.002), Some(0.0), Some(0.003), Some(0.003), None].to_vec();
        let profile = CavityProfile { time: 0.0, per_metre: 1000.0, rear: f64::INFINITY, radii };
        assert_eq!(profile.behind_projectile(0.01).radii, [Some(0.004), Some(0.002), Some(0.0), None, None, None]);
        assert_eq!(profile.behind_projectile(0.001).radii, [Some(0.004), None, None, None, None, None]);
    }

    #[test]
    fn the_hole_that_the_projectile_fills_is_no_cavity() {
        let line =
            ShotLine { origin: Vector3::zeros(), projectile_length: 0.002, projectile_width: 0.002, gel_depth: 0.006 };
        // A cavity closed behind a ball 4 to 6 mm deep, and one that is open from the entry to the ball.
        let ball = [Some(0.001); 2];
        let radii = |behind: [f64; 4]| behind.map(Some).into_iter().chain(ball).collect();
        let profile = |behind, rear| CavityProfile { time: 0.0, per_metre: 1000.0, rear, radii: radii(behind) };
        let widest = |behind, rear| profile(behind, rear).behind_projectile(0.006).widest(&line);
        let closed = widest([0.003, 0.0, 0.0, 0.0], 0.004).unwrap();
        assert_eq!(closed.diameter, 0.0);
        let open = widest([0.003, 0.002, 0.0015, 0.0005], 0.004).unwrap();
        assert_eq!((open.diameter, open.depth), (0.003, 0.003));
        assert_eq!(widest([0.003, 0.002, 0.0015, 0.0005], 0.002), None);
        // A projectile that has left through the entry fills nothing.
        assert_eq!(widest([0.0005; 4], f64::INFINITY).unwrap().diameter, 0.002);
    }
}
