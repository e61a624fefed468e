//! Plots of the report for a shot: against depth, and the cavity against time.

use super::plot::{CurvePlot, HorizontalAxis, PlotCurve, VerticalScale};
use crate::output::penetration::{PenetrationRecord, TrackPoint};

/// Least yaw of a visible curve, degrees.
const MIN_YAW: f64 = 0.01;

/// Returns all plots of a shot.
pub(super) fn charts(shot: &PenetrationRecord) -> String {
    let plots = [
        speed_plot(shot),
        force_plot(shot),
        energy_plot(shot),
        yaw_plot(shot),
        cavity_plot(shot),
        course_plot(shot),
        track_plot(shot),
    ];
    let figures: String = plots.iter().filter(|plot| !plot.curves.is_empty()).map(CurvePlot::figure).collect();
    format!("<section><h2>Along the path of the projectile</h2>\n{figures}</section>\n")
}

fn speed_plot(shot: &PenetrationRecord) -> CurvePlot {
    depth_plot(
        shot,
        "Speed of the projectile by depth",
        "m/s",
        vec![curve_along_track(shot, "speed", |_, place| place.velocity)],
    )
}

fn force_plot(shot: &PenetrationRecord) -> CurvePlot {
    let curve = curve_along_track(shot, "mean over 4 mm of depth", |shot, place| {
        shot.track.force(place.depth).unwrap_or(f64::NAN)
    });
    depth_plot(shot, "Force on the projectile by depth", "N", vec![curve])
}

/// Returns the plot of the energy per centimetre, as a step curve.
fn energy_plot(shot: &PenetrationRecord) -> CurvePlot {
    let (energies, end) = (shot.track.energy_per_centimetre(), track_depth(shot));
    let level =
        |(i, energy): (usize, &f64)| [(i as f64 / 100.0, *energy), (((i + 1) as f64 / 100.0).min(end), *energy)];
    let points = energies.iter().enumerate().flat_map(level).collect();
    let curve = PlotCurve { name: "in each centimetre".to_owned(), points };
    depth_plot(shot, "Energy given to the gel by depth", "J", vec![curve])
}

/// Returns the plot of the yaw, without a curve if the projectile flies straight.
fn yaw_plot(shot: &PenetrationRecord) -> CurvePlot {
    let curve = curve_along_track(shot, "between axis and velocity", |_, place| place.yaw.to_degrees());
    let turns = curve.points.iter().any(|(_, yaw)| *yaw > MIN_YAW);
    depth_plot(shot, "Yaw of the projectile by depth", "°", if turns { vec![curve] } else { vec![] })
}

fn cavity_plot(shot: &PenetrationRecord) -> CurvePlot {
    let cavity = &shot.cavity;
    let curves = [
        ("temporary cavity: maximum over the run", &cavity.temporary),
        ("at its maximum width", &cavity.widest),
        ("at the end", &cavity.last),
    ];
    let curves = curves.map(|(name, points)| PlotCurve { name: name.to_owned(), points: points.clone() });
    let curves = curves.into_iter().filter(|curve| !curve.points.is_empty()).collect();
    depth_plot(shot, "Radius of the cavity by depth", "m", curves)
}

/// Returns the plot of the greatest diameter of the cavity over the depth, without a curve for a single time.
fn course_plot(shot: &PenetrationRecord) -> CurvePlot {
    let course = shot.cavity.course.points();
    let points = course.iter().map(|point| (point.time, point.diameter)).collect();
    let curve = PlotCurve { name: "greatest over the depth".to_owned(), points };
    CurvePlot {
        title: "Diameter of the cavity by time",
        unit: "m",
        vertical: VerticalScale::FromZero,
        horizontal: HorizontalAxis { name: "time", unit: "s", range: 0.0..course.last().map_or(0.0, |last| last.time) },
        curves: if course.len() > 1 { vec![curve] } else { vec![] },
    }
}

/// Returns the plot of the permanent track, without a curve in an undamaged gel.
fn track_plot(shot: &PenetrationRecord) -> CurvePlot {
    let is_damaged = shot.damage.greatest_diameter() > 0.0;
    let mut points = shot.damage.curve(track_depth(shot));
    points.retain(|(depth, _)| *depth <= track_depth(shot));
    let curve = PlotCurve { name: "damaged gel at the end, as a circle".to_owned(), points };
    depth_plot(shot, "Diameter of the permanent track by depth", "m", if is_damaged { vec![curve] } else { vec![] })
}

fn curve_along_track(
    shot: &PenetrationRecord,
    name: &str,
    value: impl Fn(&PenetrationRecord, &TrackPoint) -> f64,
) -> PlotCurve {
    let points = shot.track.table().iter().map(|place| (place.depth, value(shot, place))).collect();
    PlotCurve { name: name.to_owned(), points }
}

fn depth_plot(shot: &PenetrationRecord, title: &'static str, unit: &'static str, curves: Vec<PlotCurve>) -> CurvePlot {
    CurvePlot {
        title,
        unit,
        vertical: VerticalScale::FromZero,
        horizontal: HorizontalAxis { name: "depth", unit: "m", range: 0.0..track_depth(shot) },
        curves,
    }
}

fn track_depth(shot: &PenetrationRecord) -> f64 {
    shot.track.table().last().map_or(0.0, |last| last.depth)
}
