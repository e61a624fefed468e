//! Course of the temporary cavity: its greatest diameter by time, its collapse and its pulsation.

use serde::{Deserialize, Serialize};

/// Fraction of the greatest diameter below which the cavity has collapsed.
const COLLAPSED: f64 = 0.4;
/// Least rise and fall of a pulsation, as a fraction of the greatest diameter.
const PULSATION: f64 = 0.05;

/// Greatest diameter of the cavity over the depth, at one time.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct CavityCoursePoint {
    /// Time, s.
    #[serde(deserialize_with = "crate::output::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "frame")))]
    pub time: f64,
    /// Diameter, m.
    #[serde(deserialize_with = "crate::output::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "frame")))]
    pub diameter: f64,
    /// Depth of this diameter, m.
    #[serde(deserialize_with = "crate::output::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "frame")))]
    pub depth: f64,
}

/// Course of the cavity in the order of time.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::output) struct CavityCourse(pub(super) Vec<CavityCoursePoint>);

impl CavityCourse {
    /// Returns the points of the course.
    pub(in crate::output) fn points(&self) -> &[CavityCoursePoint] {
        &self.0
    }

    /// Returns the point of the greatest diameter.
    pub(in crate::output) fn greatest(&self) -> Option<CavityCoursePoint> {
        self.0.iter().copied().reduce(|a, b| if b.diameter > a.diameter { b } else { a })
    }

    /// Returns the time of the collapse, s: the first time after the greatest diameter at which the diameter is below
    /// 40 % of it.
    pub(in crate::output) fn time_of_collapse(&self) -> Option<f64> {
        self.after_collapse().first().map(|point| point.time)
    }

    /// Returns the pulsation: the first maximum after the collapse that is followed, and preceded since the collapse,
    /// by diameters smaller by more than 5 % of the greatest one.
    pub(in crate::output) fn pulsation(&self) -> Option<CavityCoursePoint> {
        let (points, swing) = (self.after_collapse(), PULSATION * self.greatest()?.diameter);
        let (mut least, mut top) = (f64::INFINITY, None::<CavityCoursePoint>);
        for point in points {
            least = least.min(point.diameter);
            if top.is_some_and(|top| point.diameter < top.diameter - swing) {
                return top;
            }
            let is_raised = point.diameter > least + swing;
            if is_raised && top.is_none_or(|top| point.diameter > top.diameter) {
                top = Some(*point);
            }
        }
        None
    }

    /// Returns the points from the collapse on.
    fn after_collapse(&self) -> &[CavityCoursePoint] {
        let Some(greatest) = self.greatest() else { return &[] };
        let is_collapsed =
            |point: &CavityCoursePoint| point.time > greatest.time && point.diameter < COLLAPSED * greatest.diameter;
        &self.0[self.0.iter().position(is_collapsed).unwrap_or(self.0.len())..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course(diameters: &[f64]) -> CavityCourse {
        let point =
            |(i, diameter): (usize, &f64)| CavityCoursePoint { time: i as f64, diameter: *diameter, depth: 0.03 };
        CavityCourse(diameters.iter().enumerate().map(point).collect())
    }

    #[test]
    fn a_cavity_opens_collapses_and_pulsates() {
        let course = course(&[3.0, 8.0, 10.0, 9.0, 5.0, 3.9, 1.0, 1.2, 3.0, 4.5, 4.2, 2.0, 2.2, 5.0]);
        assert_eq!(course.greatest().unwrap().time, 2.0);
        assert_eq!(course.time_of_collapse(), Some(5.0));
        let pulsation = course.pulsation().unwrap();
        assert_eq!((pulsation.time, pulsation.diameter), (9.0, 4.5));
    }

    #[test]
    fn a_cavity_that_stays_open_has_no_collapse_and_ripples_are_no_pulsation() {
        assert_eq!(course(&[1.0, 3.0, 10.0, 8.0, 5.0, 4.0]).time_of_collapse(), None);
        let rippled = course(&[10.0, 3.0, 1.0, 1.4, 1.0, 1.3]);
        assert_eq!((rippled.time_of_collapse(), rippled.pulsation()), (Some(1.0), None));
        // The second maximum is not over at the end.
        assert_eq!(course(&[10.0, 1.0, 2.0, 3.0]).pulsation(), None);
        assert_eq!((course(&[]).greatest(), course(&[]).pulsation()), (None, None));
    }
}
