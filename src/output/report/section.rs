//! Section of the gel at one moment, drawn to scale with a ruler in centimetres: cavity, path and permanent track.

use super::format::{quantity, shortest};
use super::legend::{LegendEntry, legend};
use crate::output::history::HistoryRow;
use crate::output::saved_run::SavedShot;
use crate::output::summary::RunSummary;
use crate::output::view::{SectionOutline, SectionPoint};
use std::fmt::Write;

/// Width of the drawing of the gel, and room for the ruler beside and below it, in units of the drawing.
const WIDTH: f64 = 880.0;
const LEFT: f64 = 54.0;
const RIGHT: f64 = 26.0;
const TOP: f64 = 10.0;
const RULER: f64 = 46.0;
/// Greatest height of the drawn gel.
const MAX_HEIGHT: f64 = 380.0;
/// Depth that is drawn beyond the shot, as a factor of its depth.
const MARGIN: f64 = 1.5;
/// Depth that is drawn at least, in half widths of the bodies.
const BODIES: f64 = 3.0;
/// Least room above the entry surface, as a fraction of the drawn depth.
const ABOVE: f64 = 0.1;
/// Limit of the points of a drawn outline, and of the path.
const MAX_POINTS: usize = 4000;

/// Moment of the section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SectionMoment {
    /// Time, s.
    pub(super) time: f64,
    /// True for the moment of the widest cavity, false for that of the greatest depth.
    pub(super) is_widest: bool,
}

impl SectionMoment {
    /// Returns the moment of the widest cavity, or of the greatest depth in a run without a cavity.
    pub(super) fn of(summary: &RunSummary) -> Self {
        let widest = summary.wound.time_of_greatest_cavity;
        Self { time: widest.unwrap_or(summary.time_of_peak_depth), is_widest: widest.is_some() }
    }

    /// Keeps the section of the frame that is nearest to the moment.
    pub(super) fn keep_nearest(
        self,
        kept: &mut Option<SectionOutline>,
        time: f64,
        cut: impl FnOnce() -> SectionOutline,
    ) {
        let distance = |at: f64| (at - self.time).abs();
        if kept.as_ref().is_none_or(|kept| distance(time) < distance(kept.time)) {
            *kept = Some(cut());
        }
    }
}

/// Window of the drawing: depths, m, and half width, m, and units of the drawing per metre.
struct SectionWindow {
    from: f64,
    to: f64,
    half: f64,
    scale: f64,
}

impl SectionWindow {
    /// Returns the window on the gel from the entry to beyond the shot, with the bodies near it; `None` without gel.
    fn of(outline: &SectionOutline, reach: f64) -> Option<Self> {
        let greatest = |loops: &[Vec<SectionPoint>], value: fn(&SectionPoint) -> f64| {
            loops.iter().flatten().map(value).fold(0.0, f64::max)
        };
        let [deepest, widest] =
            [greatest(&outline.gel, |point| point[0]), greatest(&outline.gel, |point| point[1].abs())];
        let [behind, across] =
            [greatest(&outline.bodies, |point| -point[0]), greatest(&outline.bodies, |point| point[1].abs())];
        let shown = (MARGIN * reach).max(BODIES * across.min(widest));
        let to = if shown > 0.7 * deepest { 1.01 * deepest } else { shown };
        let from = -(1.1 * behind).clamp(ABOVE * to, to);
        let most = (0.5 * MAX_HEIGHT / WIDTH * (to - from)).max(1.1 * across);
        let half = (1.01 * widest).min(most);
        let scale = (WIDTH / (to - from)).min(0.5 * MAX_HEIGHT / half);
        // A drawing that its height limits shows more of the depth.
        let to = to.max((from + WIDTH / scale).min(1.01 * deepest));
        let is_drawn = to > 0.0 && half > 0.0 && (to + half).is_finite();
        is_drawn.then_some(Self { from, to, half, scale })
    }

    /// Returns the width of the drawn gel, in units of the drawing.
    fn width(&self) -> f64 {
        self.scale * (self.to - self.from)
    }

    fn x(&self, depth: f64) -> f64 {
        LEFT + self.scale * (depth - self.from)
    }

    /// Returns the height of the drawn gel, in units of the drawing.
    fn height(&self) -> f64 {
        2.0 * self.half * self.scale
    }

    fn y(&self, across: f64) -> f64 {
        TOP + 0.5 * self.height() - self.scale * across
    }

    fn place(&self, [depth, across]: SectionPoint) -> String {
        format!("{:.1},{:.1}", self.x(depth), self.y(across))
    }
}

/// Returns the figure of the section; empty without gel.
pub(super) fn figure(
    summary: &RunSummary,
    outline: &SectionOutline,
    rows: &[HistoryRow],
    shot: Option<&SavedShot>,
) -> String {
    let Some(window) = SectionWindow::of(outline, summary.peak_depth.max(0.0)) else { return String::new() };
    let moment = SectionMoment::of(summary);
    let caption = if moment.is_widest { "Section at the widest cavity" } else { "Section at the greatest depth" };
    let path = path_points(rows);
    let track = shot.map_or(String::new(), |shot| track(&window, &path, shot));
    let mut key = vec![
        LegendEntry::area("gel", "gel"),
        LegendEntry::area("body", "projectile"),
        LegendEntry::line("path", "path of its centre of mass"),
    ];
    if !track.is_empty() {
        key.push(LegendEntry::line("track", "permanent track at the end"));
    }
    format!(
        "<figure class=\"section\"><figcaption>{caption}, after {}, drawn to scale</figcaption>\n{}{}</figure>\n",
        quantity(outline.time, "s"),
        svg(&window, outline, &(polyline(&window, &path, "path") + &track)),
        legend(&key)
    )
}

fn svg(window: &SectionWindow, outline: &SectionOutline, lines: &str) -> String {
    let height = window.height();
    let (width, bottom) = (window.width(), TOP + height);
    let shapes = |loops: &[Vec<SectionPoint>], class: &str| {
        let path: String = loops.iter().map(|points| loop_path(window, points)).collect();
        format!("<path class=\"{class}\" fill-rule=\"evenodd\" d=\"{path}\"/>\n")
    };
    format!(
        "<svg viewBox=\"0 0 {:.0} {:.0}\" role=\"img\" aria-label=\"Section of the gel with the cavity, the projectile and its \
         path\" xmlns=\"http://www.w3.org/2000/svg\">\n<svg x=\"{LEFT}\" y=\"{TOP}\" width=\"{width:.1}\" \
         height=\"{height:.1}\" viewBox=\"{LEFT} {TOP} {width:.1} {height:.1}\">\n<rect class=\"ground\" \
         x=\"{LEFT}\" y=\"{TOP}\" width=\"{width:.1}\" height=\"{height:.1}\"/>\n{}{lines}{}</svg>\n{}{}</svg>\n",
        LEFT + WIDTH + RIGHT,
        bottom + RULER,
        shapes(&outline.gel, "gel"),
        shapes(&outline.bodies, "body"),
        depth_ruler(window, bottom),
        width_ruler(window)
    )
}

fn loop_path(window: &SectionWindow, points: &[SectionPoint]) -> String {
    let stride = points.len().div_ceil(MAX_POINTS).max(1);
    let places: Vec<String> = points.iter().step_by(stride).map(|point| window.place(*point)).collect();
    format!("M{}Z", places.join("L"))
}

/// Returns the path of the centre of mass, seen from the block.
fn path_points(rows: &[HistoryRow]) -> Vec<SectionPoint> {
    let place = |row: &HistoryRow| {
        let at = row.vector("position_", "_m") - row.vector("block_displacement_", "_m");
        [-at.z, at.x]
    };
    let stride = rows.len().div_ceil(MAX_POINTS).max(1);
    rows.iter().step_by(stride).map(place).filter(|[depth, x]| (depth + x).is_finite()).collect()
}

/// Returns a line through points; empty for a single point.
fn polyline(window: &SectionWindow, points: &[SectionPoint], class: &str) -> String {
    if points.len() < 2 {
        return String::new();
    }
    let places: Vec<String> = points.iter().map(|point| window.place(*point)).collect();
    format!("<polyline class=\"{class}\" points=\"{}\"/>\n", places.join(" "))
}

/// Returns both edges of the permanent track about the path; empty in an undamaged gel.
fn track(window: &SectionWindow, path: &[SectionPoint], shot: &SavedShot) -> String {
    let end = shot.greatest_depth();
    // The path passes each depth on its way in first.
    let across = |depth: f64| path.iter().find(|point| point[0] >= depth).or(path.last()).map_or(0.0, |point| point[1]);
    let known = shot.track.iter().filter(|(depth, width)| *depth <= end && width.is_finite());
    let edge = |side: f64| {
        let edge = known.clone().map(|(depth, width)| [*depth, across(*depth) + 0.5 * side * width]);
        polyline(window, &edge.collect::<Vec<_>>(), "track")
    };
    edge(1.0) + &edge(-1.0)
}

/// Returns a step of whole centimetres, or of millimetres in a small gel, so that few marks are numbered, m.
fn ruler_step(length: f64) -> f64 {
    let steps = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5];
    steps.into_iter().find(|step| length / step <= 16.0).unwrap_or_else(|| length / 10.0)
}

/// Returns the ruler along the depth, below the gel.
fn depth_ruler(window: &SectionWindow, bottom: f64) -> String {
    let step = ruler_step(window.to);
    let y = bottom + 6.0;
    let mut text = format!(
        "<line class=\"axis\" x1=\"{:.1}\" y1=\"{y:.1}\" x2=\"{:.1}\" y2=\"{y:.1}\"/>\n",
        window.x(0.0),
        window.x(window.to)
    );
    let fine = if step >= 0.02 { 0.01_f64.max(0.2 * step) } else { 0.5 * step };
    for i in 0..=(window.to / fine * (1.0 + 1e-9)) as usize {
        let x = window.x(i as f64 * fine);
        write!(text, "<line class=\"axis\" x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{x:.1}\" y2=\"{:.1}\"/>", y + 4.0)
            .expect("a string grows");
    }
    for i in 0..=(window.to / step * (1.0 + 1e-9)) as usize {
        let depth = i as f64 * step;
        let x = window.x(depth);
        write!(
            text,
            "<line class=\"axis\" x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{x:.1}\" y2=\"{:.1}\"/>\n<text x=\"{x:.1}\" \
             y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n",
            y + 7.0,
            y + 21.0,
            shortest(100.0 * depth)
        )
        .expect("a string grows");
    }
    let middle = 0.5 * (window.x(0.0) + window.x(window.to));
    text + &format!("<text x=\"{middle:.0}\" y=\"{:.1}\" text-anchor=\"middle\">depth, cm</text>\n", y + 38.0)
}

/// Returns the ruler across the line of fire, on the left.
fn width_ruler(window: &SectionWindow) -> String {
    let step = ruler_step(window.to).min(window.half);
    let (top, bottom) = (window.y(window.half), window.y(-window.half));
    let x = LEFT - 4.0;
    let mut text = format!("<line class=\"axis\" x1=\"{x}\" y1=\"{top:.1}\" x2=\"{x}\" y2=\"{bottom:.1}\"/>\n");
    let most = (window.half / step * (1.0 + 1e-9)) as i32;
    for i in -most..=most {
        let across = f64::from(i) * step;
        let y = window.y(across);
        write!(
            text,
            "<line class=\"axis\" x1=\"{:.1}\" y1=\"{y:.1}\" x2=\"{x:.1}\" y2=\"{y:.1}\"/>\n<text x=\"{:.1}\" \
             y=\"{:.1}\" text-anchor=\"end\">{}</text>\n",
            x - 6.0,
            x - 9.0,
            y + 5.0,
            shortest(100.0 * across.abs())
        )
        .expect("a string grows");
    }
    text + &format!(
        "<text x=\"13\" y=\"{0:.1}\" text-anchor=\"middle\" transform=\"rotate(-90 13 {0:.1})\">cm</text>\n",
        window.y(0.0)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ruler_has_few_numbers_in_gels_of_any_size() {
        for length in [1e-3, 0.02, 0.085, 0.4, 1.2, 30.0] {
            let marks = length / ruler_step(length);
            assert!((1.0..=16.0).contains(&marks), "{length}: {marks}");
        }
    }

    #[test]
    fn a_short_shot_is_drawn_with_the_gel_around_it_and_a_long_one_with_the_block() {
        let square = vec![[0.0, -0.075], [0.4, -0.075], [0.4, 0.075], [0.0, 0.075]];
        let outline = SectionOutline { time: 0.0, gel: vec![square], bodies: vec![] };
        let window = |reach: f64| SectionWindow::of(&outline, reach).unwrap();
        assert!((window(0.1).to - 0.15).abs() < 1e-12 && window(0.3).to > 0.4);
        assert!(window(0.1).height() <= 1.02 * MAX_HEIGHT);
        assert!(SectionWindow::of(&SectionOutline { gel: vec![], ..outline.clone() }, 0.1).is_none());
    }
}
