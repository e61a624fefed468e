//! Plots of curves against time or depth, as SVG.

use super::axis::{AxisMargin, PlotAxis, finite_range};
use super::legend::{LegendEntry, legend};
use crate::output::view::packed_text;
use plotters::prelude::*;
use serde_json::{Value, json};
use std::ops::Range;

/// Curve colours with contrast on white and on black.
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
/// Dash patterns of the curves, pixels: curves can be told apart without colours. The first is solid.
const DASHES: [&[u32]; COLOURS.len()] =
    [&[], &[9, 4], &[2, 3], &[10, 3, 2, 3], &[16, 4], &[6, 2, 2, 2, 2, 2], &[4, 2], &[12, 3, 5, 3], &[2, 6]];
/// Drawing units per pixel of the page: coordinates are whole numbers, and curves must not show steps.
const FINE: u32 = 8;
const SIZE: (u32, u32) = (640 * FINE, 300 * FINE);
/// Limits of the numbered ticks, horizontal and vertical.
const MAX_TICKS: (usize, usize) = (8, 6);

/// Named curve: abscissa (time, s, or depth, m) and value.
#[derive(Debug)]
pub(super) struct PlotCurve {
    pub(super) name: String,
    pub(super) points: Vec<(f64, f64)>,
    /// True for measured points, which are drawn as dots.
    pub(super) dots: bool,
}

/// Colour and dash pattern of a curve.
#[derive(Clone, Copy)]
struct CurveStyle {
    rgb: RGBColor,
    /// Lengths of strokes and gaps, pixels; empty for a solid line.
    dash: &'static [u32],
}

impl CurveStyle {
    /// Returns the styles in the order of the curves.
    fn all() -> impl Iterator<Item = Self> {
        COLOURS.into_iter().zip(DASHES).map(|(rgb, dash)| Self { rgb, dash })
    }

    /// Returns the colour in CSS.
    fn colour(self) -> String {
        let RGBColor(r, g, b) = self.rgb;
        format!("rgb({r},{g},{b})")
    }

    /// Returns the dash pattern of an SVG with this many units per pixel.
    fn dashes(self, fine: u32) -> String {
        match self.dash {
            [] => "none".to_owned(),
            dash => dash.iter().map(|length| (fine * length).to_string()).collect::<Vec<_>>().join(","),
        }
    }
}

/// Scale of the vertical axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum VerticalScale {
    /// Linear.
    Linear,
    /// Linear, from zero.
    FromZero,
    /// Decades; the values are decadic logarithms.
    Decades,
}

/// Horizontal axis: quantity and range.
pub(super) struct HorizontalAxis {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) range: Range<f64>,
}

/// Plot of curves with a common unit.
pub(super) struct CurvePlot {
    pub(super) title: &'static str,
    pub(super) unit: &'static str,
    pub(super) vertical: VerticalScale,
    pub(super) horizontal: HorizontalAxis,
    pub(super) curves: Vec<PlotCurve>,
}

impl PlotCurve {
    /// Creates a curve that is drawn as a line.
    pub(super) fn line(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points, dots: false }
    }

    /// Creates a curve of measured points.
    pub(super) fn dots(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points, dots: true }
    }

    /// Returns true if the curve is not constant.
    pub(super) fn varies(&self) -> bool {
        self.travel() > 0.0
    }

    /// Returns the difference between the greatest and the least finite value.
    pub(super) fn travel(&self) -> f64 {
        let range = finite_range(self.points.iter().map(|point| point.1)).unwrap_or(0.0..0.0);
        (range.end - range.start).min(f64::MAX)
    }
}

impl CurvePlot {
    /// Limit of the number of curves: one per colour.
    pub(super) const MAX_CURVES: usize = COLOURS.len();

    /// Returns the plot as HTML with title and legend.
    pub(super) fn figure(&self) -> String {
        let key = self.curves.iter().zip(CurveStyle::all()).map(|(curve, style)| {
            if curve.dots {
                LegendEntry::dots(&style.colour(), &curve.name)
            } else {
                LegendEntry::curve(&style.colour(), &style.dashes(1), &curve.name)
            }
        });
        format!(
            "<figure class=\"plot\"><figcaption>{}</figcaption>\n<div class=\"still\" role=\"img\" aria-label=\"{} against \
             {}\">{}</div>\n{}<script type=\"text/plain\" class=\"curves\">{}</script></figure>\n",
            self.title,
            self.title,
            self.horizontal.name,
            self.svg(),
            legend(&key.collect::<Vec<_>>()),
            packed_text(self.data().to_string().as_bytes())
        )
    }

    /// Returns the name of the quantity of the vertical axis: the first word of the title.
    fn quantity(&self) -> String {
        self.title.split(' ').next().unwrap_or_default().to_lowercase()
    }

    /// Returns the title of the vertical axis: quantity and unit.
    fn vertical_title(&self, unit: &str) -> String {
        let quantity = self.quantity();
        if unit.is_empty() { quantity } else { format!("{quantity}, {unit}") }
    }

    /// Returns the curves in the units of the axes, for the script of the page.
    fn data(&self) -> Value {
        let (along, up) = (self.along(), self.up());
        let curves = self.curves.iter().zip(CurveStyle::all()).map(|(curve, style)| {
            let points = curve.points.iter().filter_map(|(x, y)| along.place(*x).zip(up.place(*y)));
            let (x, y): (Vec<f64>, Vec<f64>) = points.map(|(x, y)| (rounded(x), rounded(y))).unzip();
            let CurveStyle { dash, .. } = style;
            json!({
                "name": curve.name, "colour": style.colour(), "dash": dash, "dots": curve.dots, "x": x, "y": y
            })
        });
        json!({
            "horizontal": {
                "name": self.horizontal.name,
                "unit": along.unit,
                "range": [along.range.start, along.range.end],
            },
            "vertical": {
                "title": self.vertical_title(&up.unit),
                "decades": self.vertical == VerticalScale::Decades,
                "fromZero": self.vertical == VerticalScale::FromZero,
            },
            "curves": curves.collect::<Vec<_>>(),
        })
    }

    fn svg(&self) -> String {
        let mut text = String::new();
        self.draw(&SVGBackend::with_string(&mut text, SIZE).into_drawing_area()).expect("a string takes every shape");
        let size = format!("width=\"{}\" height=\"{}\" ", SIZE.0, SIZE.1);
        let dashed =
            self.curves.iter().zip(CurveStyle::all()).filter(|(curve, style)| !curve.dots && !style.dash.is_empty());
        dashed.fold(text.replacen(&size, "", 1), |text, (_, style)| {
            let RGBColor(r, g, b) = style.rgb;
            let stroke = format!("stroke=\"#{r:02X}{g:02X}{b:02X}\"");
            text.replace(&stroke, &format!("{stroke} stroke-dasharray=\"{}\"", style.dashes(FINE)))
        })
    }

    fn draw<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, plotters::coord::Shift>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let (along, up) = (self.along(), self.up());
        let mut chart = ChartBuilder::on(area)
            .margin(8 * FINE)
            .margin_right(18 * FINE)
            .x_label_area_size(40 * FINE)
            .y_label_area_size(64 * FINE)
            .build_cartesian_2d(along.range.clone(), up.range.clone())?;
        let mark = |value: &f64| match self.vertical {
            VerticalScale::Linear | VerticalScale::FromZero => tick(*value),
            VerticalScale::Decades if (value - value.round()).abs() < 1e-6 => format!("1e{value:.0}"),
            VerticalScale::Decades => String::new(),
        };
        let mut mesh = chart.configure_mesh();
        mesh.x_desc(format!("{}, {}", self.horizontal.name, along.unit)).x_labels(MAX_TICKS.0).y_labels(MAX_TICKS.1);
        mesh.y_desc(self.vertical_title(&up.unit));
        mesh.axis_style(BLACK.stroke_width(FINE)).set_all_tick_mark_size(5 * FINE);
        mesh.label_style(("sans-serif", 14 * FINE))
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.15).stroke_width(FINE));
        mesh.x_label_formatter(&|place| tick(*place)).y_label_formatter(&mark).draw()?;
        for (curve, colour) in self.curves.iter().zip(COLOURS) {
            let points = curve.points.iter().filter_map(|(x, y)| along.place(*x).zip(up.place(*y)));
            if curve.dots {
                chart.draw_series(points.map(|point| Circle::new(point, 4 * FINE, colour.filled())))?;
            } else {
                chart.draw_series(LineSeries::new(points, colour.stroke_width(2 * FINE)))?;
            }
        }
        area.present()
    }

    /// Returns the horizontal axis.
    fn along(&self) -> PlotAxis {
        let HorizontalAxis { unit, range, .. } = &self.horizontal;
        PlotAxis::linear([range.start, range.end].into_iter(), unit, AxisMargin::None)
    }

    /// Returns the vertical axis over the values of all curves.
    fn up(&self) -> PlotAxis {
        let values = self.curves.iter().flat_map(|curve| &curve.points).map(|point| point.1);
        match self.vertical {
            VerticalScale::Linear => PlotAxis::linear(values, self.unit, AxisMargin::Both),
            VerticalScale::FromZero => PlotAxis::linear(values, self.unit, AxisMargin::FromZero),
            VerticalScale::Decades => PlotAxis::decades(values),
        }
    }
}

/// Rounds a number to six significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// Formats a number without trailing zeros.
fn tick(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_string() } else { text.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Generates arbitrary doubles, with many edge cases.
    fn number() -> impl Strategy<Value = f64> {
        let edges = vec![
            0.0,
            -0.0,
            1.0,
            -1.0,
            1e-3,
            1e308,
            -1e308,
            f64::MAX,
            f64::MIN,
            5e-324,
            f64::MIN_POSITIVE,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            1.0 + f64::EPSILON,
            1e17,
            1e17 + 16.0,
        ];
        prop_oneof![prop::sample::select(edges), any::<u64>().prop_map(f64::from_bits), -1e3..1e3]
    }

    fn curve() -> impl Strategy<Value = PlotCurve> {
        let points = prop::collection::vec((number(), number()), 0..12);
        points.prop_map(|points| PlotCurve::line("curve", points))
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

        #[test]
        fn a_plot_takes_any_numbers_and_has_a_bounded_number_of_ticks(
            curves in prop::collection::vec(curve(), 0..3),
            vertical in prop::sample::select(vec![
                VerticalScale::Linear,
                VerticalScale::FromZero,
                VerticalScale::Decades,
            ]),
            (start, end) in (number(), number()),
        ) {
            prop_assert!(curves.iter().all(|curve| curve.travel() >= 0.0));
            let horizontal = HorizontalAxis { name: "time", unit: "s", range: start..end };
            let page = CurvePlot { title: "Title", unit: "N", vertical, horizontal, curves }.figure();
            let texts = page.matches("<text").count();
            prop_assert!(texts <= MAX_TICKS.0 + MAX_TICKS.1 + 6 && page.len() < 32_000, "{texts} texts in {page}");
            let (page, _) = page.split_once("base64,").expect("the data of the curves");
            prop_assert!(!page.contains("NaN") && !page.contains("inf"), "{page}");
        }
    }
}
