//! Plots of the report for a shot: against depth, and energy and cavity against time.

use super::crack_slices;
use super::layers;
use super::plot::{CurvePlot, HorizontalAxis, PlotCurve, VerticalScale};
use crate::output::saved_run::{SavedShot, ShotPoint};
use crate::scene::Scene;

/// Least yaw of a visible curve, degrees.
pub(super) const MIN_YAW: f64 = 0.01;

/// Line above plots that the script of the page brings to life.
pub(super) const HINT: &str = "<p class=\"hint\">Point at a plot to read it; drag along it to zoom; double-click for all of it. Plots \
                    over the same axis go together.</p>\n";

/// Returns the plots of a shot against depth, the table of its layers, and the slices with estimated cracks.
pub(super) fn charts(scene: &Scene, shot: &SavedShot) -> String {
    let plots = [
        cavity_plot(shot),
        yaw_plot(shot),
        speed_plot(shot),
        expansion_plot(shot),
        force_plot(shot),
        energy_plot(scene, shot),
    ];
    let figures: String = plots.iter().filter(|plot| !plot.curves.is_empty()).map(CurvePlot::figure).collect();
    format!(
        "<section><h2>Along the path of the projectile</h2>\n{HINT}<div class=\"plots\">{figures}</div>{}{}</section>\n",
        layers::table(scene, shot),
        crack_slices::figure(scene, shot)
    )
}

fn speed_plot(shot: &SavedShot) -> CurvePlot {
    depth_plot(
        shot,
        "Speed of the projectile by depth",
        "m/s",
        vec![curve_along_track(shot, "speed", |place| place.velocity)],
    )
}

fn force_plot(shot: &SavedShot) -> CurvePlot {
    let curve = curve_along_track(shot, "mean over 4 mm of depth", |place| place.force);
    let across = curve_along_track(shot, "across the line of fire", |place| place.side_force);
    let is_turned = across.points.iter().any(|(_, force)| *force > 0.0);
    let curves = if is_turned { vec![curve, across] } else { vec![curve] };
    depth_plot(shot, "Force on the projectile by depth", "N", curves)
}

/// Returns the plot of the energy per centimetre, as a step curve, with the interfaces of the layers.
fn energy_plot(scene: &Scene, shot: &SavedShot) -> CurvePlot {
    let curve = PlotCurve::line("in each centimetre", energy_steps(shot));
    let curves = [curve].into_iter().chain(layers::interface_curves(scene, shot)).collect();
    depth_plot(shot, "Energy given to the gel by depth", "J", curves)
}

/// Returns the energy in each centimetre of depth as a step curve.
pub(super) fn energy_steps(shot: &SavedShot) -> Vec<(f64, f64)> {
    let end = shot.greatest_depth();
    let level =
        |(i, energy): (usize, &f64)| [(i as f64 / 100.0, *energy), (((i + 1) as f64 / 100.0).min(end), *energy)];
    shot.energies.iter().enumerate().flat_map(level).collect()
}

/// Returns the plot of the yaw, without a curve if the projectile flies straight.
fn yaw_plot(shot: &SavedShot) -> CurvePlot {
    let curve = curve_along_track(shot, "between axis and velocity", |place| place.yaw.to_degrees());
    let turns = curve.points.iter().any(|(_, yaw)| *yaw > MIN_YAW);
    depth_plot(shot, "Yaw of the projectile by depth", "°", if turns { vec![curve] } else { vec![] })
}

/// Returns the plot of the opening, without a curve if the projectile does not expand.
fn expansion_plot(shot: &SavedShot) -> CurvePlot {
    let curve = curve_along_track(shot, "opening", |place| 100.0 * place.expansion);
    let opens = curve.points.iter().any(|(_, opening)| *opening > 0.0);
    depth_plot(shot, "Expansion of the projectile by depth", "%", if opens { vec![curve] } else { vec![] })
}

fn cavity_plot(shot: &SavedShot) -> CurvePlot {
    let cavity = &shot.cavity;
    let diameters = |points: &[(f64, f64)]| points.iter().map(|(depth, radius)| (*depth, 2.0 * radius)).collect();
    let curves = [
        ("temporary cavity: widest over the run", &cavity.temporary),
        ("temporary cavity at its widest moment", &cavity.widest),
        ("cavity at the end", &cavity.last),
    ];
    let curves = curves.map(|(name, points)| PlotCurve::line(name, diameters(points)));
    let curves = curves.into_iter().chain([track_curve(shot)]).filter(|curve| !curve.points.is_empty()).collect();
    depth_plot(shot, "Diameter of cavity and permanent track by depth", "m", curves)
}

/// Returns the plot of the energy given to the gel by time.
pub(super) fn energy_by_time(shot: &SavedShot) -> CurvePlot {
    let track = &shot.points;
    let points: Vec<(f64, f64)> = track.iter().map(|place| (place.time, place.energy)).collect();
    let curve = PlotCurve::line("up to the greatest depth", points);
    CurvePlot {
        title: "Energy given to the gel by time",
        unit: "J",
        vertical: VerticalScale::FromZero,
        horizontal: HorizontalAxis { name: "time", unit: "s", range: 0.0..track.last().map_or(0.0, |last| last.time) },
        curves: if curve.varies() { vec![curve] } else { vec![] },
    }
}

/// Returns the plot of the greatest diameter of the cavity over the depth, without a curve for a single time.
pub(super) fn cavity_by_time(shot: &SavedShot) -> CurvePlot {
    let course = &shot.course;
    let points = course.iter().map(|point| (point.time, point.diameter)).collect();
    let curve = PlotCurve::line("greatest over the depth", points);
    CurvePlot {
        title: "Diameter of the cavity by time",
        unit: "m",
        vertical: VerticalScale::FromZero,
        horizontal: HorizontalAxis { name: "time", unit: "s", range: 0.0..course.last().map_or(0.0, |last| last.time) },
        curves: if course.len() > 1 { vec![curve] } else { vec![] },
    }
}

/// Returns the curve of the permanent track, without a point in an undamaged gel.
fn track_curve(shot: &SavedShot) -> PlotCurve {
    let mut points = shot.track.clone();
    points.retain(|(depth, _)| *depth <= shot.greatest_depth());
    PlotCurve::line("permanent track: damaged gel, as a circle", points)
}

/// Returns a value of the projectile by depth as a curve.
pub(super) fn curve_along_track(shot: &SavedShot, name: &str, value: impl Fn(&ShotPoint) -> f64) -> PlotCurve {
    let points = shot.points.iter().map(|place| (place.depth, value(place))).collect();
    PlotCurve::line(name, points)
}

fn depth_plot(shot: &SavedShot, title: &'static str, unit: &'static str, curves: Vec<PlotCurve>) -> CurvePlot {
    CurvePlot {
        title,
        unit,
        vertical: VerticalScale::FromZero,
        horizontal: HorizontalAxis { name: "depth", unit: "m", range: 0.0..shot.greatest_depth() },
        curves,
    }
}
