//! Curves against time or depth as SVG.

use super::number::prefix;
use plotters::prelude::*;
use std::ops::Range;

/// Colours that stand out on white and on black.
const COLOURS: [RGBColor; 9] = [
    RGBColor(66, 133, 225),
    RGBColor(228, 120, 28),
    RGBColor(40, 160, 92),
    RGBColor(196, 72, 168),
    RGBColor(20, 168, 182),
    RGBColor(220, 66, 66),
    RGBColor(150, 140, 30),
    RGBColor(132, 104, 220),
    RGBColor(128, 128, 128),
];
/// Units of the drawing per pixel of the page: coordinates are whole numbers, and curves must not show their steps.
const FINE: u32 = 8;
const SIZE: (u32, u32) = (640 * FINE, 300 * FINE);

/// A named curve of (time, s, or depth, m, and value).
pub(super) struct Curve {
    pub(super) name: String,
    pub(super) points: Vec<(f64, f64)>,
}

/// How values are laid out.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Height {
    /// As they are.
    Linear,
    /// As they are, from zero up.
    FromZero,
    /// They are decadic logarithms already.
    Decades,
}

/// What curves go along.
pub(super) struct Across {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) range: Range<f64>,
}

/// A plot of curves that share a unit.
pub(super) struct Plot {
    pub(super) title: &'static str,
    pub(super) unit: &'static str,
    pub(super) height: Height,
    pub(super) across: Across,
    pub(super) curves: Vec<Curve>,
}

impl Curve {
    /// Whether there is anything to see.
    pub(super) fn varies(&self) -> bool {
        self.travel() > 0.0
    }

    /// From the lowest to the highest value.
    pub(super) fn travel(&self) -> f64 {
        let values = self.points.iter().map(|point| point.1);
        let range = values.fold(f64::INFINITY..f64::NEG_INFINITY, |range, x| range.start.min(x)..range.end.max(x));
        (range.end - range.start).max(0.0)
    }
}

impl Plot {
    /// As many curves as there are colours.
    pub(super) const MOST_CURVES: usize = COLOURS.len();

    /// The plot with its title and a legend.
    pub(super) fn figure(&self) -> String {
        let key = self.curves.iter().zip(COLOURS).map(|(curve, RGBColor(r, g, b))| {
            format!("<li><span style=\"background:rgb({r},{g},{b})\"></span>{}</li>", curve.name)
        });
        let key = key.collect::<Vec<_>>().concat();
        format!(
            "<figure class=\"plot\"><figcaption>{}</figcaption>\n<div role=\"img\" aria-label=\"{} against {}\">{}</div>\n\
             <ul class=\"key\">{key}</ul></figure>\n",
            self.title,
            self.title,
            self.across.name,
            self.svg()
        )
    }

    fn svg(&self) -> String {
        let mut text = String::new();
        self.draw(&SVGBackend::with_string(&mut text, SIZE).into_drawing_area()).expect("a string takes every shape");
        let size = format!("width=\"{}\" height=\"{}\" ", SIZE.0, SIZE.1);
        text.replacen(&size, "", 1)
    }

    fn draw<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, plotters::coord::Shift>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let (Across { name, unit, range }, values) = (&self.across, self.values());
        let (along, along_prefix) = prefix(range.end);
        let (factor, value_prefix) = match self.height {
            Height::Linear | Height::FromZero => prefix(values.start.abs().max(values.end.abs())),
            Height::Decades => (1.0, ""),
        };
        let mut chart = ChartBuilder::on(area)
            .margin(8 * FINE)
            .margin_right(18 * FINE)
            .x_label_area_size(40 * FINE)
            .y_label_area_size(64 * FINE)
            .build_cartesian_2d(scaled(range, along), self.padded(&scaled(&values, factor)))?;
        let mark = |value: &f64| match self.height {
            Height::Linear | Height::FromZero => tick(*value),
            Height::Decades if (value - value.round()).abs() < 1e-6 => format!("1e{value:.0}"),
            Height::Decades => String::new(),
        };
        let mut mesh = chart.configure_mesh();
        mesh.x_desc(format!("{name}, {along_prefix}{unit}")).x_labels(8).y_labels(6);
        if self.height != Height::Decades {
            mesh.y_desc(format!("{value_prefix}{}", self.unit));
        }
        mesh.axis_style(BLACK.stroke_width(FINE)).set_all_tick_mark_size(5 * FINE);
        mesh.label_style(("sans-serif", 14 * FINE))
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.15).stroke_width(FINE));
        mesh.x_label_formatter(&|place| tick(*place)).y_label_formatter(&mark).draw()?;
        for (curve, colour) in self.curves.iter().zip(COLOURS) {
            let points = curve.points.iter().map(|(x, y)| (x * along, y * factor));
            chart.draw_series(LineSeries::new(points, colour.stroke_width(2 * FINE)))?;
        }
        area.present()
    }

    /// Room above and below the curves; whole decades, three at least.
    fn padded(&self, range: &Range<f64>) -> Range<f64> {
        match self.height {
            Height::Linear => {
                let margin = 0.05 * (range.end - range.start);
                range.start - margin..range.end + margin
            }
            Height::FromZero => 1.05 * range.start.min(0.0)..1.05 * range.end,
            Height::Decades => range.start.floor().min(range.end.ceil() - 3.0)..range.end.ceil(),
        }
    }

    fn values(&self) -> Range<f64> {
        let values = self.curves.iter().flat_map(|curve| &curve.points).map(|point| point.1).filter(|x| x.is_finite());
        values.fold(f64::INFINITY..f64::NEG_INFINITY, |range, x| range.start.min(x)..range.end.max(x))
    }
}

fn scaled(range: &Range<f64>, factor: f64) -> Range<f64> {
    range.start * factor..range.end * factor
}

/// A number without the zeros behind it.
fn tick(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_string() } else { text.to_string() }
}
