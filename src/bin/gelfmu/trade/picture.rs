//! Error-cost curve as a picture: error against element updates and against CPU time.

use super::curve::{AssessedRun, TradeCurve};
use super::ladder::{MESH, REMESHED};
use super::others::PeerRun;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::ops::Range;

type PlotArea<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Drawing units per pixel, as coordinates are integers.
const UNITS_PER_PIXEL: u32 = 4;
const SIZE: (u32, u32) = (1080 * UNITS_PER_PIXEL, 460 * UNITS_PER_PIXEL);
const LEGEND: u32 = 60 * UNITS_PER_PIXEL;
const COLOURS: [RGBColor; 12] = [
    RGBColor(66, 133, 225),
    RGBColor(228, 120, 28),
    RGBColor(40, 160, 92),
    RGBColor(196, 72, 168),
    RGBColor(20, 168, 182),
    RGBColor(220, 66, 66),
    RGBColor(150, 140, 30),
    RGBColor(132, 104, 220),
    RGBColor(128, 128, 128),
    RGBColor(160, 90, 44),
    RGBColor(90, 200, 120),
    RGBColor(240, 140, 180),
];

/// PlotMark of a run; without an error if the run failed.
struct PlotMark {
    cost: f64,
    /// Relative error, percent.
    error: Option<f64>,
    colour: RGBColor,
    kind: MarkKind,
    name: Option<String>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum MarkKind {
    /// Run on the Pareto front.
    Best,
    /// Other run of ours.
    Run,
    /// Run of another code.
    Other,
}

/// Draws the curve with the runs of other codes as SVG; returns `None` if no run has an error.
pub fn draw_svg(scene: &str, curve: &TradeCurve, others: &[PeerRun]) -> Option<String> {
    let knobs = knob_names(curve);
    let by_updates: Vec<PlotMark> =
        curve.runs.iter().filter_map(|run| run_mark(run, &knobs, |row| row.element_updates)).collect();
    let by_time = curve.runs.iter().filter_map(|run| run_mark(run, &knobs, |row| row.cpu_seconds));
    let mut others: Vec<PlotMark> = others.iter().filter_map(peer_mark).collect();
    others.sort_by(|a, b| b.cost.total_cmp(&a.cost));
    let by_time: Vec<PlotMark> = by_time.chain(others).collect();
    let errors = padded_range(by_updates.iter().chain(&by_time).filter_map(|mark| mark.error))?;
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE).expect("a string takes every shape");
        let (plots, legend) = root.split_vertically(SIZE.1 - LEGEND);
        let (left, right) = plots.split_horizontally(SIZE.0 / 2);
        draw_panel(&left, &format!("{scene}: error against work"), "element updates", &by_updates, &errors);
        draw_panel(&right, &format!("{scene}: error against time"), "CPU seconds", &by_time, &errors);
        draw_legend(&legend, &knobs);
    }
    let size = format!("width=\"{}\" height=\"{}\" ", SIZE.0, SIZE.1);
    Some(text.replacen(&size, "", 1))
}

/// Lists the knobs in the order of the runs.
fn knob_names(curve: &TradeCurve) -> Vec<&'static str> {
    let mut all: Vec<&'static str> = curve.runs.iter().map(|assessed| family_name(assessed)).collect();
    let mut seen = vec![];
    all.retain(|knob| {
        !seen.contains(knob) && {
            seen.push(*knob);
            true
        }
    });
    all
}

/// Returns the mesh family of a run; the unmodified scene belongs to its own mesh.
fn family_name(assessed: &AssessedRun) -> &'static str {
    let knob = assessed.run.rung.knob;
    if knob.is_empty() { MESH } else { knob }
}

fn run_mark(
    assessed: &AssessedRun,
    knobs: &[&'static str],
    cost: impl Fn(&super::row::TradeRow) -> f64,
) -> Option<PlotMark> {
    let row = assessed.run.row.as_ref().ok()?;
    let number = knobs.iter().position(|knob| *knob == family_name(assessed))?;
    let error = assessed.confirmed.map(|error| 100.0 * error);
    if error.is_none() && row.failure.is_none() {
        return None;
    }
    let kind = if assessed.is_best { MarkKind::Best } else { MarkKind::Run };
    let name = assessed.run.rung.knob.is_empty().then(|| "as it comes".to_owned());
    Some(PlotMark { cost: cost(row), error, colour: COLOURS[number % COLOURS.len()], kind, name })
}

fn peer_mark(other: &PeerRun) -> Option<PlotMark> {
    let error = other.error.map(|error| 100.0 * error)?;
    Some(PlotMark {
        cost: other.cpu_seconds,
        error: Some(error),
        colour: BLACK,
        kind: MarkKind::Other,
        name: Some(other.name.clone()),
    })
}

/// Returns the range of the values with a margin on both sides; `None` without values.
fn padded_range(values: impl Iterator<Item = f64>) -> Option<Range<f64>> {
    /// Least error on the logarithmic axis.
    const LEAST: f64 = 1e-3;
    let (least, most) =
        values.map(|value| value.max(LEAST)).fold((f64::INFINITY, 0.0), |(a, b), x| (x.min(a), x.max(b)));
    least.is_finite().then_some(0.7 * least..2.0 * most)
}

/// Draws one panel: error against a cost, with the Pareto front as a line.
fn draw_panel(panel: &PlotArea, caption: &str, cost_label: &str, marks: &[PlotMark], errors: &Range<f64>) {
    let Some(costs) = padded_range(marks.iter().map(|mark| mark.cost)) else { return };
    let mut chart = ChartBuilder::on(panel)
        .margin(8 * UNITS_PER_PIXEL)
        .margin_right(16 * UNITS_PER_PIXEL)
        .caption(caption, ("sans-serif", 15 * UNITS_PER_PIXEL))
        .x_label_area_size(36 * UNITS_PER_PIXEL)
        .y_label_area_size(56 * UNITS_PER_PIXEL)
        .build_cartesian_2d(costs.log_scale(), errors.clone().log_scale())
        .expect("a panel");
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(format!("{cost_label}; x: failed"))
        .y_desc("error that holds, %")
        .x_labels(6)
        .y_labels(8)
        .max_light_lines(0);
    mesh.x_label_formatter(&|x| axis_label(*x)).y_label_formatter(&|y| axis_label(*y));
    mesh.axis_style(BLACK.stroke_width(UNITS_PER_PIXEL)).label_style(("sans-serif", 12 * UNITS_PER_PIXEL));
    mesh.bold_line_style(BLACK.mix(0.12).stroke_width(UNITS_PER_PIXEL)).draw().expect("a grid");
    let mut front: Vec<(f64, f64)> =
        marks.iter().filter(|mark| mark.kind == MarkKind::Best).filter_map(log_position).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    chart.draw_series(LineSeries::new(front, BLACK.mix(0.35).stroke_width(UNITS_PER_PIXEL))).expect("a curve");
    let mut n_others = 0;
    for mark in marks {
        // A failed run has no error: its mark is at the upper edge.
        let (at, size) =
            (log_position(mark).unwrap_or((mark.cost, 0.95 * errors.end)), 4 * UNITS_PER_PIXEL.cast_signed());
        let plotting = chart.plotting_area();
        let drawn = match (mark.error, mark.kind) {
            (None, _) => plotting.draw(&Cross::new(at, size, mark.colour.stroke_width(2 * UNITS_PER_PIXEL))),
            (Some(_), MarkKind::Best) => plotting.draw(&Circle::new(at, size, mark.colour.filled())),
            (Some(_), MarkKind::Run) => {
                plotting.draw(&Circle::new(at, size, mark.colour.stroke_width(UNITS_PER_PIXEL)))
            }
            (Some(_), MarkKind::Other) => plotting.draw(&TriangleMarker::new(at, size, mark.colour.filled())),
        };
        drawn.expect("a mark");
        // Names of other codes are stacked, as their marks lie side by side.
        n_others += i32::from(mark.kind == MarkKind::Other);
        let up =
            if mark.kind == MarkKind::Other { -(12 * n_others + 8) * UNITS_PER_PIXEL.cast_signed() } else { -size };
        if let Some(name) = &mark.name {
            let line = PathElement::new(vec![(0, 0), (0, up)], BLACK.mix(0.3).stroke_width(UNITS_PER_PIXEL / 2));
            let text = Text::new(name.clone(), (2 * size, up), ("sans-serif", 11 * UNITS_PER_PIXEL).into_font());
            plotting.draw(&(EmptyElement::at(at) + line + text)).expect("a name");
        }
    }
}

/// Formats an axis label: 0.1, 1, 10; 1e6.
fn axis_label(value: f64) -> String {
    if (1e-3..1e4).contains(&value) { format!("{value}") } else { format!("{value:e}") }
}

fn log_position(mark: &PlotMark) -> Option<(f64, f64)> {
    Some((mark.cost, mark.error?.max(1e-3)))
}

fn draw_legend(legend: &PlotArea, knobs: &[&str]) {
    let columns = knobs.len().div_ceil(2).max(1);
    for ((knob, colour), area) in knobs.iter().zip(COLOURS.iter().cycle()).zip(legend.split_evenly((2, columns))) {
        let (pixel, middle) = (UNITS_PER_PIXEL.cast_signed(), LEGEND.cast_signed() / 4);
        area.draw(&Circle::new((16 * pixel, middle), 4 * pixel, colour.filled())).expect("a mark");
        let name = if *knob == MESH || *knob == REMESHED { format!("{knob}: all cells") } else { (*knob).to_owned() };
        let style = ("sans-serif", 13 * UNITS_PER_PIXEL).into_font();
        area.draw(&Text::new(name, (26 * pixel, middle - 7 * pixel), style)).expect("a name");
    }
}
