//! Figures of a wound for `summary.json`: when and where the projectile came to rest, the cavity over time, the permanent track.

use super::files::OutputError;
use super::history::HistoryFile;
use super::penetration::{CavityCoursePoint, PenetrationRecord};
use crate::simulation::{RestDepth, RestDetector};
use serde::{Deserialize, Serialize};

/// Figures of a wound, SI; `None` (null in JSON) for a figure without a value.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct WoundFigures {
    /// Rest depth, m: mean depth of the foremost point over the last millisecond, if it moves by less than 0.2 mm in it.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "step")))]
    pub rest_depth: Option<f64>,
    /// Time of rest, s: start of the first millisecond from which on the foremost point moves by less than 0.2 mm in
    /// every millisecond.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "step")))]
    pub time_of_rest: Option<f64>,
    /// Length of the neck, m: depth at which the yaw passes 30°.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "step")))]
    pub neck_length: Option<f64>,
    /// Greatest diameter of the cavity between one projectile diameter below the entry and the rear of the projectile,
    /// m; of a penetration along −z by which the rear is that deep, as all figures of the cavity.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "frame")))]
    pub greatest_cavity_diameter: Option<f64>,
    /// Time of the greatest diameter of the cavity, s.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "frame")))]
    pub time_of_greatest_cavity: Option<f64>,
    /// Greatest diameter of the cavity at the end, m, without the hole that the projectile fills.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "end")))]
    pub final_cavity_diameter: Option<f64>,
    /// Depth of the greatest diameter of the cavity, m.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "frame")))]
    pub depth_of_greatest_cavity: Option<f64>,
    /// True if the greatest diameter of the cavity is that of the end: the cavity still opens.
    pub cavity_still_opening: Option<bool>,
    /// Greatest diameter of the cavity over the depth by time.
    pub cavity_course: Option<Vec<CavityCoursePoint>>,
    /// Time of the collapse, s: the first time after the greatest diameter at which the diameter is below 40 % of it.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "frame")))]
    pub time_of_cavity_collapse: Option<f64>,
    /// Second maximum of the diameter, after the collapse, m.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "frame")))]
    pub cavity_pulsation_diameter: Option<f64>,
    /// Time of the second maximum, s.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "frame")))]
    pub time_of_cavity_pulsation: Option<f64>,
    /// Greatest diameter of the permanent track at the end, m: of the circle with the cross-section of the damaged gel.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "end")))]
    pub greatest_track_diameter: Option<f64>,
}

impl WoundFigures {
    pub(super) fn of(penetration: Option<&PenetrationRecord>, rest: Option<RestDepth>) -> Self {
        let rested = Self {
            rest_depth: rest.map(|rest| rest.depth),
            time_of_rest: rest.map(|rest| rest.time),
            ..Self::default()
        };
        let Some(shot) = penetration else { return rested };
        let (course, pulsation) = (&shot.cavity.course, shot.cavity.course.pulsation());
        Self {
            neck_length: shot.track.neck_length(),
            greatest_cavity_diameter: course.greatest().map(|point| point.diameter),
            time_of_greatest_cavity: course.greatest().map(|point| point.time),
            final_cavity_diameter: shot.cavity.last_diameter,
            cavity_still_opening: course.greatest().map(|_| shot.cavity.still_opens),
            depth_of_greatest_cavity: course.greatest().map(|point| point.depth),
            cavity_course: Some(course.points().to_vec()).filter(|points| !points.is_empty()),
            time_of_cavity_collapse: course.time_of_collapse(),
            cavity_pulsation_diameter: pulsation.map(|point| point.diameter),
            time_of_cavity_pulsation: pulsation.map(|point| point.time),
            greatest_track_diameter: Some(shot.damage.greatest_diameter()),
            ..rested
        }
    }
}

/// Returns the depth and the time at which the projectile came to rest, from the whole history.
pub(super) fn find_rest(history: &HistoryFile) -> Result<Option<RestDepth>, OutputError> {
    let mut detector = RestDetector::new();
    history.for_each_row(|row| detector.push(row.get("time_s"), row.get("depth_m")))?;
    Ok(detector.rest())
}
