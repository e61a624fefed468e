//! Axes of plots: every range of numbers becomes one that can be divided into ticks.

use super::number::scale;
use std::ops::Range;

/// Width of the narrowest axis, as a part of its largest value: round-off is not drawn as a curve.
const NARROWEST: f64 = 1e-9;
/// Part of its largest value by which an axis without a width reaches to both sides.
const ROOM: f64 = 0.05;
/// Largest decadic logarithm of a double, rounded up; the least is above its negative.
const MOST_DECADES: f64 = 330.0;

/// An axis of a plot: finite, ascending and of a width that differs from zero.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    /// What a value is multiplied by.
    pub(super) factor: f64,
    /// The unit of the multiplied values.
    pub(super) unit: String,
    /// First and last multiplied value.
    pub(super) range: Range<f64>,
}

/// Where an axis starts and ends beside the values that it shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Margin {
    /// At the first and the last value.
    None,
    /// A little beyond them.
    Both,
    /// At zero, and a little beyond the values.
    FromZero,
}

impl Axis {
    /// An axis of values in a unit; those that are not finite count for nothing, and without any it goes from 0 to 1.
    pub(super) fn linear(values: impl Iterator<Item = f64>, unit: &str, margin: Margin) -> Self {
        let Range { start, end } = span(values).unwrap_or(0.0..0.0);
        let (factor, unit) = scale(start.abs().max(end.abs()), unit);
        let scaled = widened(start * factor..end * factor);
        let room = ROOM * (scaled.end - scaled.start);
        let range = match margin {
            Margin::None => scaled,
            Margin::Both => scaled.start - room..scaled.end + room,
            Margin::FromZero => (1.0 + ROOM) * scaled.start.min(0.0)..(1.0 + ROOM) * scaled.end.max(0.0),
        };
        Self { factor, unit, range }
    }

    /// An axis of decadic logarithms: whole decades, three at least.
    pub(super) fn decades(values: impl Iterator<Item = f64>) -> Self {
        let known = values.filter(|value| value.abs() <= MOST_DECADES);
        let Range { start, end } = span(known).unwrap_or(0.0..0.0);
        let range = start.floor().min(end.ceil() - 3.0)..end.ceil();
        Self { factor: 1.0, unit: String::new(), range }
    }

    /// The multiplied value, if it is on the axis.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        let place = value * self.factor;
        let slack = ROOM * (self.range.end - self.range.start);
        (self.range.start - slack..=self.range.end + slack).contains(&place).then_some(place)
    }
}

/// From the least to the greatest of the finite values, if there is one.
pub(super) fn span(values: impl Iterator<Item = f64>) -> Option<Range<f64>> {
    let finite = values.filter(|value| value.is_finite()).map(|value| value..value);
    finite.reduce(|range, value| range.start.min(value.start)..range.end.max(value.end))
}

/// A range that can be divided into ticks: one without a width is given room on both sides.
fn widened(range: Range<f64>) -> Range<f64> {
    let size = range.start.abs().max(range.end.abs());
    if size < NARROWEST {
        // Scaled values are between 1 and 1000, unless they are zero or next to the least number that there is.
        return 0.0..1.0;
    }
    if range.end - range.start >= NARROWEST * size {
        return range;
    }
    let (middle, half) = (0.5 * (range.start + range.end), ROOM * size);
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
            for margin in [Margin::None, Margin::Both, Margin::FromZero] {
                let Range { start, end } = Axis::linear(values.iter().copied(), "m", margin).range;
                let size = start.abs().max(end.abs());
                assert!(size <= 1e4 && end - start >= NARROWEST * size && end > start, "{values:?}: {start} to {end}");
            }
            let Range { start, end } = Axis::decades(values.iter().copied()).range;
            assert!(end - start >= 3.0 && end - start <= 2.0 * MOST_DECADES + 3.0, "{values:?}: {start} to {end}");
        }
    }
}
