//! The curve as a picture: error against element updates, and against CPU time.

use super::curve::{Assessed, Curve};
use super::ladder::{MESH, REMESHED};
use super::others::Other;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::ops::Range;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Units of the drawing per pixel: coordinates are whole numbers.
const FINE: u32 = 4;
const SIZE: (u32, u32) = (1080 * FINE, 460 * FINE);
const LEGEND: u32 = 60 * FINE;
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

/// A mark: cost, error in percent (nothing if the run failed), colour, and what it is.
struct Mark {
    place: (f64, Option<f64>),
    colour: RGBColor,
    kind: Kind,
    name: Option<String>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Worth its cost.
    Best,
    /// Another run of ours.
    Run,
    /// Of another code.
    Other,
}

/// The picture, with the runs of other codes beside ours; nothing if no run has an error.
pub fn svg(scene: &str, curve: &Curve, others: &[Other]) -> Option<String> {
    let knobs = knobs(curve);
    let by_updates: Vec<Mark> =
        curve.runs.iter().filter_map(|run| mark(run, &knobs, |row| row.element_updates)).collect();
    let by_time = curve.runs.iter().filter_map(|run| mark(run, &knobs, |row| row.cpu_seconds));
    let mut others: Vec<Mark> = others.iter().filter_map(other).collect();
    others.sort_by(|a, b| b.place.0.total_cmp(&a.place.0));
    let by_time: Vec<Mark> = by_time.chain(others).collect();
    let errors = span(by_updates.iter().chain(&by_time).filter_map(|mark| mark.place.1))?;
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE).expect("a string takes every shape");
        let (plots, legend) = root.split_vertically(SIZE.1 - LEGEND);
        let (left, right) = plots.split_horizontally(SIZE.0 / 2);
        draw(&left, (&format!("{scene}: error against work"), "element updates"), &by_updates, &errors);
        draw(&right, (&format!("{scene}: error against time"), "CPU seconds"), &by_time, &errors);
        key(&legend, &knobs);
    }
    let size = format!("width=\"{}\" height=\"{}\" ", SIZE.0, SIZE.1);
    Some(text.replacen(&size, "", 1))
}

/// Names of the knobs, in the order of the runs.
fn knobs(curve: &Curve) -> Vec<&'static str> {
    let mut all: Vec<&'static str> = curve.runs.iter().map(|assessed| name_of(assessed)).collect();
    let mut seen = vec![];
    all.retain(|knob| {
        !seen.contains(knob) && {
            seen.push(*knob);
            true
        }
    });
    all
}

/// The scene as it comes is one of its own mesh.
fn name_of(assessed: &Assessed) -> &'static str {
    let knob = assessed.run.rung.knob;
    if knob.is_empty() { MESH } else { knob }
}

fn mark(assessed: &Assessed, knobs: &[&'static str], cost: impl Fn(&super::row::Row) -> f64) -> Option<Mark> {
    let row = assessed.run.row.as_ref().ok()?;
    let number = knobs.iter().position(|knob| *knob == name_of(assessed))?;
    let error = assessed.held.map(|error| 100.0 * error);
    if error.is_none() && row.failure.is_none() {
        return None;
    }
    let kind = if assessed.best { Kind::Best } else { Kind::Run };
    let name = assessed.run.rung.knob.is_empty().then(|| "as it comes".to_owned());
    Some(Mark { place: (cost(row), error), colour: COLOURS[number % COLOURS.len()], kind, name })
}

fn other(other: &Other) -> Option<Mark> {
    let error = other.error.map(|error| 100.0 * error)?;
    Some(Mark {
        place: (other.cpu_seconds, Some(error)),
        colour: BLACK,
        kind: Kind::Other,
        name: Some(other.name.clone()),
    })
}

/// From the least to the greatest, with room on both sides; nothing of nothing.
fn span(values: impl Iterator<Item = f64>) -> Option<Range<f64>> {
    /// An error of nothing has no logarithm.
    const LEAST: f64 = 1e-3;
    let (least, most) =
        values.map(|value| value.max(LEAST)).fold((f64::INFINITY, 0.0), |(a, b), x| (x.min(a), x.max(b)));
    least.is_finite().then_some(0.7 * least..2.0 * most)
}

fn draw(panel: &Area, (caption, across): (&str, &str), marks: &[Mark], errors: &Range<f64>) {
    let Some(costs) = span(marks.iter().map(|mark| mark.place.0)) else { return };
    let mut chart = ChartBuilder::on(panel)
        .margin(8 * FINE)
        .margin_right(16 * FINE)
        .caption(caption, ("sans-serif", 15 * FINE))
        .x_label_area_size(36 * FINE)
        .y_label_area_size(56 * FINE)
        .build_cartesian_2d(costs.log_scale(), errors.clone().log_scale())
        .expect("a panel");
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(format!("{across}; x: failed"))
        .y_desc("error that holds, %")
        .x_labels(6)
        .y_labels(8)
        .max_light_lines(0);
    mesh.x_label_formatter(&|x| tick(*x)).y_label_formatter(&|y| tick(*y));
    mesh.axis_style(BLACK.stroke_width(FINE)).label_style(("sans-serif", 12 * FINE));
    mesh.bold_line_style(BLACK.mix(0.12).stroke_width(FINE)).draw().expect("a grid");
    let mut front: Vec<(f64, f64)> = marks.iter().filter(|mark| mark.kind == Kind::Best).filter_map(place).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    chart.draw_series(LineSeries::new(front, BLACK.mix(0.35).stroke_width(FINE))).expect("a curve");
    let mut n_others = 0;
    for mark in marks {
        // What has failed has no error: it stands at the upper edge.
        let (at, size) = (place(mark).unwrap_or((mark.place.0, 0.95 * errors.end)), 4 * FINE.cast_signed());
        let plotting = chart.plotting_area();
        let drawn = match (mark.place.1, mark.kind) {
            (None, _) => plotting.draw(&Cross::new(at, size, mark.colour.stroke_width(2 * FINE))),
            (Some(_), Kind::Best) => plotting.draw(&Circle::new(at, size, mark.colour.filled())),
            (Some(_), Kind::Run) => plotting.draw(&Circle::new(at, size, mark.colour.stroke_width(FINE))),
            (Some(_), Kind::Other) => plotting.draw(&TriangleMarker::new(at, size, mark.colour.filled())),
        };
        drawn.expect("a mark");
        // Names of other codes stand above each other: their marks lie side by side.
        n_others += i32::from(mark.kind == Kind::Other);
        let up = if mark.kind == Kind::Other { -(12 * n_others + 8) * FINE.cast_signed() } else { -size };
        if let Some(name) = &mark.name {
            let line = PathElement::new(vec![(0, 0), (0, up)], BLACK.mix(0.3).stroke_width(FINE / 2));
            let text = Text::new(name.clone(), (2 * size, up), ("sans-serif", 11 * FINE).into_font());
            plotting.draw(&(EmptyElement::at(at) + line + text)).expect("a name");
        }
    }
}

/// A number on an axis: 0.1, 1, 10; 1e6.
fn tick(value: f64) -> String {
    if (1e-3..1e4).contains(&value) { format!("{value}") } else { format!("{value:e}") }
}

fn place(mark: &Mark) -> Option<(f64, f64)> {
    Some((mark.place.0, mark.place.1?.max(1e-3)))
}

fn key(legend: &Area, knobs: &[&str]) {
    let columns = knobs.len().div_ceil(2).max(1);
    for ((knob, colour), area) in knobs.iter().zip(COLOURS.iter().cycle()).zip(legend.split_evenly((2, columns))) {
        let (pixel, middle) = (FINE.cast_signed(), LEGEND.cast_signed() / 4);
        area.draw(&Circle::new((16 * pixel, middle), 4 * pixel, colour.filled())).expect("a mark");
        let name = if *knob == MESH || *knob == REMESHED { format!("{knob}: all cells") } else { (*knob).to_owned() };
        let style = ("sans-serif", 13 * FINE).into_font();
        area.draw(&Text::new(name, (26 * pixel, middle - 7 * pixel), style)).expect("a name");
    }
}
