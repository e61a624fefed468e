//! The errors against the step, double logarithmic: a row per scene, a column per error, the legend below.

use super::master::Master;
use super::{ERRORS, Sheet};
use plotters::coord::Shift;
use plotters::prelude::*;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Units of the drawing per pixel: coordinates are whole numbers.
const FINE: u32 = 4;
const SIZE: (u32, u32) = (1080 * FINE, 640 * FINE);
const LEGEND: u32 = 40 * FINE;
const COLOURS: [RGBColor; 7] = [
    RGBColor(220, 66, 66),
    RGBColor(228, 120, 28),
    RGBColor(66, 133, 225),
    RGBColor(20, 168, 182),
    RGBColor(40, 160, 92),
    RGBColor(196, 72, 168),
    RGBColor(128, 128, 128),
];
/// Errors at round-off are drawn from here on.
const LEAST: f64 = 1e-17;

pub fn svg(sheets: &[Sheet]) -> String {
    let mut text = String::new();
    let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
    root.fill(&WHITE).expect("a string takes every shape");
    let (plots, legend) = root.split_vertically(SIZE.1 - LEGEND);
    for (sheet, line) in sheets.iter().zip(plots.split_evenly((sheets.len(), 1))) {
        for (i, panel) in line.split_evenly((1, ERRORS.len())).iter().enumerate() {
            draw(sheet, i, panel);
        }
    }
    key(&legend);
    drop((plots, legend, root));
    let size = format!("width=\"{}\" height=\"{}\" ", SIZE.0, SIZE.1);
    text.replacen(&size, "", 1)
}

fn draw(sheet: &Sheet, error: usize, panel: &Area) {
    let caption = format!("{}: |{}|", sheet.scene, ERRORS[error]);
    let mut chart = ChartBuilder::on(panel)
        .margin(8 * FINE)
        .margin_right(16 * FINE)
        .caption(caption, ("sans-serif", 15 * FINE))
        .x_label_area_size(36 * FINE)
        .y_label_area_size(48 * FINE)
        .build_cartesian_2d((0.9e-6..1.1e-3).log_scale(), (LEAST..1.0).log_scale())
        .expect("a panel");
    let mut mesh = chart.configure_mesh();
    mesh.x_desc("communication step, s").x_labels(4).y_labels(8).max_light_lines(0);
    mesh.x_label_formatter(&|x| format!("{x:.0e}")).y_label_formatter(&|y| format!("{y:.0e}"));
    mesh.axis_style(BLACK.stroke_width(FINE)).label_style(("sans-serif", 12 * FINE));
    mesh.bold_line_style(BLACK.mix(0.12).stroke_width(FINE)).draw().expect("a grid");
    for (master, colour) in Master::ALL.into_iter().zip(COLOURS) {
        let points = sheet.of(master).map(|row| (row.step, row.errors[error].abs().max(LEAST)));
        chart.draw_series(LineSeries::new(points, colour.stroke_width(2 * FINE))).expect("a curve");
    }
}

fn key(legend: &Area) {
    let [pixel, middle] = [FINE, LEGEND / 2].map(u32::cast_signed);
    for ((master, colour), area) in Master::ALL.into_iter().zip(COLOURS).zip(legend.split_evenly((1, 7))) {
        let line = vec![(10 * pixel, middle), (40 * pixel, middle)];
        area.draw(&PathElement::new(line, colour.stroke_width(3 * FINE))).expect("a line");
        let style = ("sans-serif", 14 * FINE).into_font();
        area.draw(&Text::new(master.name(), (50 * pixel, middle - 7 * pixel), style)).expect("a name");
    }
}
