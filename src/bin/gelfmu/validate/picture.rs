//! Scatter plot of a validation: computed against measured, with the band.

use super::table::{BAND, ShotResult};
use plotters::prelude::*;

/// Drawing units per pixel, as coordinates are integers.
const UNITS: u32 = 4;
const SIZE: (u32, u32) = (560 * UNITS, 520 * UNITS);
/// Greatest depth of the axes, mm.
const MOST: f64 = 1000.0;
/// Least depth of the axes, mm.
const LEAST: f64 = 60.0;
const COUNTED: RGBColor = RGBColor(0, 90, 181);
const TOLD: RGBColor = RGBColor(150, 150, 150);

/// Draws computed against measured values, mm, as SVG: the range of the measured values is a line, the scatter of the
/// yaw another.
pub fn draw_svg(results: &[ShotResult]) -> String {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE).expect("a string takes every shape");
        draw(&root, results).expect("a string takes every shape");
    }
    let size = format!("width=\"{}\" height=\"{}\" ", SIZE.0, SIZE.1);
    text.replacen(&size, "", 1)
}

type PlotResult = Result<(), Box<dyn std::error::Error>>;

fn draw(root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>, results: &[ShotResult]) -> PlotResult {
    let axis = || (LEAST..MOST).log_scale();
    let mut chart = ChartBuilder::on(root)
        .margin(12 * UNITS)
        .caption("Measured shots: computed against measured, mm", ("sans-serif", 15 * UNITS))
        .x_label_area_size(34 * UNITS)
        .y_label_area_size(44 * UNITS)
        .build_cartesian_2d(axis(), axis())?;
    let style = ("sans-serif", 12 * UNITS);
    let number = |value: &f64| format!("{value:.0}");
    chart
        .configure_mesh()
        .x_desc("measured, mm")
        .y_desc("computed, mm; line: scatter of the yaw at draft")
        .label_style(style)
        .axis_desc_style(style)
        .x_label_formatter(&number)
        .y_label_formatter(&number)
        .light_line_style(WHITE)
        .draw()?;
    for factor in [1.0 - BAND, 1.0, 1.0 + BAND] {
        let ends = [LEAST, MOST].map(|x| (x, (factor * x).clamp(LEAST, MOST)));
        let ends =
            if factor > 1.0 { [ends[0], (MOST / factor, MOST)] } else { [(LEAST / factor.min(1.0), LEAST), ends[1]] };
        chart
            .draw_series(LineSeries::new(ends, BLACK.mix(if factor == 1.0 { 0.8 } else { 0.3 }).stroke_width(UNITS)))?;
    }
    for result in results {
        let colour = if result.measured.is_judged() { COUNTED } else { TOLD };
        let (low, high) = (1e3 * result.measured.low, 1e3 * result.measured.high);
        let middle = (low * high).sqrt();
        let scatter: Vec<f64> = result.scatter().iter().map(|value| 1e3 * value).collect();
        let vertical = scatter.iter().map(|value| (middle, *value)).collect::<Vec<_>>();
        chart.draw_series(LineSeries::new(vertical, colour.mix(0.5).stroke_width(2 * UNITS)))?;
        let Some(value) = result.value() else { continue };
        chart
            .draw_series(LineSeries::new([(low, 1e3 * value), (high, 1e3 * value)], colour.stroke_width(2 * UNITS)))?;
        chart.draw_series([Circle::new((middle, 1e3 * value), 4 * UNITS, colour.filled())])?;
        let name = Text::new(
            result.measured.name.clone(),
            (middle * 1.02, 1e3 * value),
            ("sans-serif", 9 * UNITS).into_font().color(&colour),
        );
        chart.draw_series([name])?;
    }
    Ok(())
}
