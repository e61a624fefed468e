//! Axes of plots: any range of numbers becomes a range with ticks.

use super::format::si_scale;
use std::ops::Range;

/// Least width of an axis relative to its largest value: round-off is not drawn as a curve.
const MIN_RELATIVE_WIDTH: f64 = 1e-9;
/// Margin of an axis: a fraction of its width, or of its largest value if the width is zero.
const MARGIN: f64 = 0.05;
/// Largest decadic logarithm of a double, rounded up; the least logarithm is above the negative.
const MAX_LOGARITHM: f64 = 330.0;

/// Axis of a plot: finite, ascending and wider than zero.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlotAxis {
    /// Factor from values to axis units.
    pub(super) factor: f64,
    /// Unit of the scaled values.
    pub(super) unit: String,
    /// First and last scaled value.
    pub(super) range: Range<f64>,
}

/// Margin between the values and the ends of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AxisMargin {
    /// No margin: the ends are the first and the last value.
    None,
    /// Margin at both ends.
    Both,
    /// Zero at one end, a margin beyond the values.
    FromZero,
}

impl PlotAxis {
    /// Returns a linear axis of the finite values in a unit; without finite values from 0 to 1.
    pub(super) fn linear(values: impl Iterator<Item = f64>, unit: &str, margin: AxisMargin) -> Self {
        let Range { start, end } = finite_range(values).unwrap_or(0.0..0.0);
        let (factor, unit) = si_scale(start.abs().max(end.abs()), unit);
        let scaled = widen(start * factor..end * factor);
        let room = MARGIN * (scaled.end - scaled.start);
        let range = match margin {
            AxisMargin::None => scaled,
            AxisMargin::Both => scaled.start - room..scaled.end + room,
            AxisMargin::FromZero => (1.0 + MARGIN) * scaled.start.min(0.0)..(1.0 + MARGIN) * scaled.end.max(0.0),
        };
        Self { factor, unit, range }
    }

    /// Returns an axis of decadic logarithms over whole decades, at least three.
    pub(super) fn decades(values: impl Iterator<Item = f64>) -> Self {
        let known = values.filter(|value| value.abs() <= MAX_LOGARITHM);
        let Range { start, end } = finite_range(known).unwrap_or(0.0..0.0);
        let range = start.floor().min(end.ceil() - 3.0)..end.ceil();
        Self { factor: 1.0, unit: String::new(), range }
    }

    /// Returns the scaled value if the axis covers it.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        let place = value * self.factor;
        let slack = MARGIN * (self.range.end - self.range.start);
        (self.range.start - slack..=self.range.end + slack).contains(&place).then_some(place)
    }
}

/// Returns the range of the finite values, if any.
pub(super) fn finite_range(values: impl Iterator<Item = f64>) -> Option<Range<f64>> {
    let finite = values.filter(|value| value.is_finite()).map(|value| value..value);
    finite.reduce(|range, value| range.start.min(value.start)..range.end.max(value.end))
}

/// Returns a range of sufficient width for ticks; a range without width is widened on both sides.
fn widen(range: Range<f64>) -> Range<f64> {
    let size = range.start.abs().max(range.end.abs());
    if size < MIN_RELATIVE_WIDTH {
        // Scaled values lie between 1 and 1000, except zero and values next to the least double.
        return 0.0..1.0;
    }
    if range.end - range.start >= MIN_RELATIVE_WIDTH * size {
        return range;
    }
    let (middle, half) = (0.5 * (range.start + range.end), MARGIN * size);
    middle - half..middle + half
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_is_finite_and_has_a_width_whatever_it_shows() {
        let all: [&[f64]; 9] = [
            &[],
            &[f64::NAN, f64::INFINITY],
            &[0.0],
            &[-3.0, -3.0],
            &[1.0, 1.0 + f64::EPSILON],
            &[5e-324, 1e-323],
            &[-f64::MAX, f64::MAX],
            &[1e308, 1e308],
            &[-1.0, f64::NEG_INFINITY, 2.0],
        ];
        for values in all {
            for margin in [AxisMargin::None, AxisMargin::Both, AxisMargin::FromZero] {
                let Range { start, end } = PlotAxis::linear(values.iter().copied(), "m", margin).range;
                let size = start.abs().max(end.abs());
                assert!(
                    size <= 1e4 && end - start >= MIN_RELATIVE_WIDTH * size && end > start,
                    "{values:?}: {start} to {end}"
                );
            }
            let Range { start, end } = PlotAxis::decades(values.iter().copied()).range;
            assert!(end - start >= 3.0 && end - start <= 2.0 * MAX_LOGARITHM + 3.0, "{values:?}: {start} to {end}");
        }
    }
}
