//! Wound profile: cavity, permanent track and yaw of a shot along one depth axis, drawn to scale.

use super::axis::finite_range;
use super::format::{escape, shortest};
use super::legend::{LegendEntry, legend};
use crate::output::saved_run::SavedShot;
use crate::scene::{Scene, layer_name};
use std::fmt::Write;

/// Width of the drawing and of its depth axis, and height of the yaw panel, in units of the drawing.
const WIDTH: f64 = 960.0;
const LEFT: f64 = 66.0;
const ALONG: f64 = 870.0;
const YAW_HEIGHT: f64 = 90.0;
/// Limits of the height of the profile.
const PROFILE_HEIGHT: [f64; 2] = [70.0, 340.0];
const TOP: f64 = 14.0;
/// Height of a row of names above the profile, and width of a letter at most.
const NAME_HEIGHT: f64 = 18.0;
const LETTER: f64 = 8.5;
const GAP: f64 = 26.0;
/// Least yaw of a drawn panel, degrees.
const MIN_YAW: f64 = 0.01;

/// Silhouettes and scales of the drawing.
struct WoundDrawing<'a> {
    shot: &'a SavedShot,
    /// Greatest depth, m.
    depth: f64,
    /// Units of the drawing per metre, along the depth and across it.
    scale: [f64; 2],
    /// Height of the profile.
    height: f64,
    /// Height of the upper edge of the profile, below the names of the layers.
    top: f64,
    /// Names of the layers that the projectile enters, with the interfaces above them.
    names: Vec<LayerLabel>,
}

/// Name of a layer above the profile.
struct LayerLabel {
    name: String,
    /// Depth of the upper interface, m.
    depth: f64,
    /// Row of the name, counted from the profile up.
    row: usize,
}

/// Returns the wound profile as an SVG figure, with the interfaces of its layers; empty without a cavity.
pub(super) fn figure(scene: &Scene, shot: &SavedShot) -> String {
    let depth = shot.greatest_depth();
    let radii = shot.cavity.temporary.iter().map(|point| point.1);
    let widest = finite_range(radii).map_or(0.0, |range| range.end).max(0.5 * shot.greatest_track_diameter());
    if depth <= 0.0 || widest <= 0.0 || !(depth + widest).is_finite() {
        return String::new();
    }
    let along = ALONG / depth;
    let across = along.min(0.46 * PROFILE_HEIGHT[1] / widest).max(0.5 * PROFILE_HEIGHT[0] * 0.8 / widest);
    let height = (2.2 * widest * across).clamp(PROFILE_HEIGHT[0], PROFILE_HEIGHT[1]);
    let names = layer_labels(scene, shot, along);
    let n_rows = names.iter().map(|label| label.row + 1).max().unwrap_or(0);
    let top = TOP + NAME_HEIGHT * n_rows as f64;
    let drawing = WoundDrawing { shot, depth, scale: [along, across], height, top, names };
    let note = match across / along {
        ratio if (ratio - 1.0).abs() < 1e-6 => "drawn to scale".to_owned(),
        ratio => format!("widths drawn {ratio:.2} times as large as depths"),
    };
    format!(
        "<figure class=\"wound\"><figcaption>Wound profile, {note}</figcaption>\n{}{}</figure>\n",
        drawing.svg(),
        legend(&[
            LegendEntry::area("cavity", "temporary cavity, widest over the run"),
            LegendEntry::area("track", "permanent track at the end"),
        ])
    )
}

impl WoundDrawing<'_> {
    fn svg(&self) -> String {
        let yaw = self.yaw_panel();
        let bottom = self.top + self.height + if yaw.is_empty() { 0.0 } else { GAP + YAW_HEIGHT };
        let middle = self.middle();
        let cavity = self.silhouette(&self.shot.cavity.temporary, 1.0, "cavity");
        let track = self.silhouette(&self.shot.track, 0.5, "track");
        let interfaces = self.interfaces();
        format!(
            "<svg viewBox=\"0 0 {WIDTH} {:.0}\" role=\"img\" aria-label=\"Temporary cavity, permanent track and yaw against \
             depth\" xmlns=\"http://www.w3.org/2000/svg\">\n{cavity}{track}{interfaces}<line class=\"axis\" stroke-dasharray=\"5 4\" \
             x1=\"{LEFT}\" y1=\"{middle:.1}\" x2=\"{:.1}\" y2=\"{middle:.1}\"/>\n{}{yaw}{}</svg>\n",
            bottom + 46.0,
            LEFT + ALONG,
            self.width_ticks(),
            self.depth_axis(bottom)
        )
    }

    fn middle(&self) -> f64 {
        self.top + 0.5 * self.height
    }

    fn x(&self, depth: f64) -> f64 {
        LEFT + self.scale[0] * depth
    }

    /// Returns the outline of widths along the depth, on both sides of the shot line; `factor` makes radii of widths.
    fn silhouette(&self, widths: &[(f64, f64)], factor: f64, class: &str) -> String {
        let known = widths.iter().filter(|(depth, width)| *depth <= self.depth * (1.0 + 1e-9) && width.is_finite());
        let place = |(depth, width): &(f64, f64), sign: f64| {
            format!("{:.1},{:.1} ", self.x(*depth), self.middle() + sign * factor * width * self.scale[1])
        };
        let upper: String = known.clone().map(|point| place(point, -1.0)).collect();
        let lower: Vec<String> = known.map(|point| place(point, 1.0)).collect();
        let lower: String = lower.into_iter().rev().collect();
        if upper.is_empty() {
            return String::new();
        }
        format!("<polygon class=\"{class}\" points=\"{upper}{}\"/>\n", lower.trim_end())
    }

    /// Returns a dashed line at each interface, and the name of the layer below it.
    fn interfaces(&self) -> String {
        let mut text = String::new();
        for LayerLabel { name, depth, row } in &self.names {
            let (x, y) = (self.x(*depth), self.top - NAME_HEIGHT * (row + 1) as f64);
            let is_last = x + LETTER * name.len() as f64 > WIDTH;
            let (place, anchor) = if is_last { (x - 4.0, "end") } else { (x + 4.0, "start") };
            write!(
                text,
                "<line class=\"interface\" x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{x:.1}\" y2=\"{:.1}\"/>\n\
                 <text x=\"{place:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{}</text>\n",
                self.top + self.height,
                y + 13.0,
                escape(name)
            )
            .expect("a string grows");
        }
        text
    }

    /// Returns the marks of the diameter on both sides of the shot line.
    fn width_ticks(&self) -> String {
        let step = round_step(0.5 * self.height / self.scale[1] / 1.5);
        let mut text = String::new();
        for side in [-1.0, 0.0, 1.0] {
            let y = self.middle() + side * step * self.scale[1];
            write!(
                text,
                "<text x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\n<line class=\"axis\" x1=\"{:.0}\" y1=\"{y:.1}\" \
                 x2=\"{LEFT}\" y2=\"{y:.1}\"/>\n",
                LEFT - 9.0,
                y + 5.0,
                shortest(100.0 * step * side.abs()),
                LEFT - 5.0
            )
            .expect("a string grows");
        }
        text + &format!(
            "<text x=\"14\" y=\"{0:.1}\" text-anchor=\"middle\" transform=\"rotate(-90 14 {0:.1})\">radius, cm</text>\n",
            self.middle()
        )
    }

    /// Returns the panel of the yaw below the profile; empty if the projectile flies straight.
    fn yaw_panel(&self) -> String {
        let track = &self.shot.points;
        let degrees = |yaw: f64| yaw.to_degrees();
        let greatest = track.iter().map(|place| degrees(place.yaw)).filter(|yaw| yaw.is_finite()).fold(0.0, f64::max);
        if greatest <= MIN_YAW {
            return String::new();
        }
        let top = self.top + self.height + GAP;
        let bottom = top + YAW_HEIGHT;
        let step = [0.1, 1.0, 5.0, 10.0, 30.0, 45.0, 90.0].into_iter().find(|step| greatest <= 2.0 * step);
        let step = step.unwrap_or(90.0);
        let y = |yaw: f64| bottom - (YAW_HEIGHT - 4.0) * yaw / (2.0 * step).max(greatest);
        let points = track.iter().filter(|place| place.yaw.is_finite());
        let points: Vec<String> =
            points.map(|place| format!("{:.1},{:.1}", self.x(place.depth), y(degrees(place.yaw)))).collect();
        let mut text = format!("<polyline class=\"yaw\" points=\"{}\"/>\n", points.join(" "));
        for mark in [0.0, step, 2.0 * step] {
            write!(
                text,
                "<text x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">{mark}</text>\n<line class=\"grid\" x1=\"{LEFT}\" \
                 y1=\"{2:.1}\" x2=\"{3:.0}\" y2=\"{2:.1}\"/>\n",
                LEFT - 9.0,
                y(mark) + 5.0,
                y(mark),
                LEFT + ALONG
            )
            .expect("a string grows");
        }
        let middle = 0.5 * (top + bottom);
        text + &format!(
            "<text x=\"14\" y=\"{middle:.1}\" text-anchor=\"middle\" transform=\"rotate(-90 14 {middle:.1})\">yaw, °</text>\n"
        )
    }

    /// Returns the depth axis at a height of the drawing.
    fn depth_axis(&self, y: f64) -> String {
        let end = LEFT + ALONG;
        let mut text = format!("<line class=\"axis\" x1=\"{LEFT}\" y1=\"{y:.1}\" x2=\"{end:.1}\" y2=\"{y:.1}\"/>\n");
        let step = round_step(self.depth / 6.0);
        for i in 0..=(self.depth / step * (1.0 + 1e-9)) as usize {
            let depth = i as f64 * step;
            let x = self.x(depth);
            write!(
                text,
                "<line class=\"axis\" x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{x:.1}\" y2=\"{:.1}\"/>\n<text x=\"{x:.1}\" \
                 y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n",
                y + 5.0,
                y + 20.0,
                shortest(100.0 * depth)
            )
            .expect("a string grows");
        }
        let middle = LEFT + 0.5 * ALONG;
        text + &format!("<text x=\"{middle:.0}\" y=\"{:.1}\" text-anchor=\"middle\">depth, cm</text>\n", y + 39.0)
    }
}

/// Returns the names of the layers that the projectile enters, for `along` units of the drawing per metre. A name that
/// would meet that of the layer below stands in the row above it, so that no line crosses a name.
fn layer_labels(scene: &Scene, shot: &SavedShot, along: f64) -> Vec<LayerLabel> {
    let depth = shot.greatest_depth();
    let entered = shot.layers.iter().map(|passage| passage.depth_from).filter(|from| *from < depth).collect::<Vec<_>>();
    let mut labels: Vec<LayerLabel> = vec![];
    for (n, from) in entered.iter().enumerate().rev() {
        let name = layer_name(&scene.layer, n);
        let end = from * along + LETTER * name.len() as f64;
        let row = labels.last().map_or(0, |below| if below.depth * along < end { below.row + 1 } else { 0 });
        labels.push(LayerLabel { name, depth: *from, row });
    }
    labels
}

/// Returns 1, 2 or 5 times a power of ten: the greatest of these at or below a length, m.
fn round_step(length: f64) -> f64 {
    let decade = 10f64.powf(length.log10().floor());
    [5.0, 2.0, 1.0].map(|factor| factor * decade).into_iter().find(|step| *step <= length).unwrap_or(decade)
}
