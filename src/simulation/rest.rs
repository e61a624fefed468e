//! Rest of a projectile in the gel: peak depth, rest depth and time of rest, from the depths at communication points.

use std::collections::VecDeque;

/// Length of the window in which a projectile at rest stays within [`REST_BAND`], s.
const REST_WINDOW: f64 = 1e-3;
/// Upper limit of the range of the depth within a window at rest, m.
const REST_BAND: f64 = 2e-4;
/// Relative tolerance of times for round-off.
const TIME_TOLERANCE: f64 = 1e-9;

/// Greatest depth of the foremost point at a communication point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeakDepth {
    /// Depth, m.
    pub depth: f64,
    /// First time of this depth, s.
    pub time: f64,
}

/// Rest of a projectile whose foremost point has moved by less than 0.2 mm in the last millisecond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RestDepth {
    /// Mean depth of the foremost point over the last millisecond, m.
    pub depth: f64,
    /// Time of rest, s: start of the first window of one millisecond that satisfies the condition, and after which
    /// every window up to now satisfies it.
    pub time: f64,
}

/// Detector of rest: sliding window over the depth of the foremost point, linear between communication points.
///
/// The memory holds one window, and a push takes constant time on average (monotone queues of the extremes, Lemire
/// 2006). A run that goes back in time needs a new detector.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RestDetector {
    /// Samples of the window, ascending in time, preceded by the last sample at or before the start of the window.
    samples: VecDeque<NoseSample>,
    /// Samples of descending depth; the first is the deepest after the start of the window.
    deepest: VecDeque<NoseSample>,
    /// Samples of ascending depth; the first is the least deep after the start of the window.
    shallowest: VecDeque<NoseSample>,
    peak: Option<PeakDepth>,
    /// Start of the first window of the present sequence of windows at rest, s.
    at_rest_since: Option<f64>,
}

/// Depth at a communication point.
#[derive(Debug, Clone, Copy, PartialEq)]
struct NoseSample {
    time: f64,
    depth: f64,
}

impl NoseSample {
    /// Returns the point at `time` on the straight line to `next`.
    fn interpolate(self, next: Self, time: f64) -> Self {
        let share = (time - self.time) / (next.time - self.time);
        Self { time, depth: self.depth + share * (next.depth - self.depth) }
    }
}

impl RestDetector {
    /// Creates a detector without samples.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the depth of the foremost point, m, at a communication point, s. A depth that is not finite and a time not
    /// later than the last one are ignored.
    pub fn push(&mut self, time: f64, depth: f64) {
        if !(time.is_finite() && depth.is_finite()) || self.samples.back().is_some_and(|last| time <= last.time) {
            return;
        }
        if self.peak.is_none_or(|peak| depth > peak.depth) {
            self.peak = Some(PeakDepth { depth, time });
        }
        self.append(NoseSample { time, depth });
        self.at_rest_since = match self.range() {
            Some(range) if range < REST_BAND => self.at_rest_since.or(self.window_start().map(|start| start.time)),
            _ => None,
        };
    }

    /// Returns the greatest depth so far; `None` before the first sample.
    #[must_use]
    pub fn peak(&self) -> Option<PeakDepth> {
        self.peak
    }

    /// Returns the rest depth; `None` for a projectile that has moved by 0.2 mm or more within the last millisecond,
    /// in the first millisecond, and above the gel.
    #[must_use]
    pub fn rest(&self) -> Option<RestDepth> {
        let time = self.at_rest_since?;
        let first = self.window_start()?;
        let window = || std::iter::once(first).chain(self.samples.iter().copied().skip(1));
        let area: f64 =
            window().zip(window().skip(1)).map(|(a, b)| 0.5 * (b.time - a.time) * (a.depth + b.depth)).sum();
        let last = self.samples.back()?;
        let depth = area / (last.time - first.time);
        (depth > 0.0).then_some(RestDepth { depth, time })
    }

    /// Appends a sample and drops the samples before the window.
    fn append(&mut self, sample: NoseSample) {
        self.samples.push_back(sample);
        push_monotone(&mut self.deepest, sample, |last| last.depth <= sample.depth);
        push_monotone(&mut self.shallowest, sample, |last| last.depth >= sample.depth);
        let start = sample.time - REST_WINDOW;
        while self.samples.get(1).is_some_and(|second| second.time <= start) {
            self.samples.pop_front();
        }
        for extremes in [&mut self.deepest, &mut self.shallowest] {
            while extremes.front().is_some_and(|first| first.time <= start) {
                extremes.pop_front();
            }
        }
    }

    /// Returns the range of the depth within the window, m; `None` in the first millisecond.
    fn range(&self) -> Option<f64> {
        let first = self.window_start()?.depth;
        Some(first.max(self.deepest.front()?.depth) - first.min(self.shallowest.front()?.depth))
    }

    /// Returns the interpolated sample at the start of the window; `None` in the first millisecond.
    fn window_start(&self) -> Option<NoseSample> {
        let (first, second, last) = (*self.samples.front()?, *self.samples.get(1)?, self.samples.back()?);
        let start = last.time - REST_WINDOW;
        let reached = start >= first.time - TIME_TOLERANCE * REST_WINDOW;
        reached.then(|| first.interpolate(second, start.max(first.time)))
    }
}

/// Appends a sample to a monotone queue, after the removal of the samples that it outdoes.
fn push_monotone(queue: &mut VecDeque<NoseSample>, sample: NoseSample, is_outdone: impl Fn(&NoseSample) -> bool) {
    while queue.back().is_some_and(&is_outdone) {
        queue.pop_back();
    }
    queue.push_back(sample);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feeds a depth as a function of time at equal steps.
    fn detect(step: f64, end: f64, depth: impl Fn(f64) -> f64) -> RestDetector {
        let mut detector = RestDetector::new();
        for i in 0..=(end / step).round() as u32 {
            let time = f64::from(i) * step;
            detector.push(time, depth(time));
        }
        detector
    }

    /// Depth of a projectile that stops 85 mm deep after 1.5 ms, rebounds to 83 mm until 2 ms and stays there.
    fn stop_and_rebound(time: f64) -> f64 {
        match time {
            t if t < 1.5e-3 => 0.085 * (1.0 - (1.0 - t / 1.5e-3).powi(2)),
            t if t < 2e-3 => 0.085 - 0.002 * (t - 1.5e-3) / 0.5e-3,
            _ => 0.083,
        }
    }

    #[test]
    fn rest_is_the_first_millisecond_within_the_band_that_lasts() {
        let detector = detect(1e-5, 4e-3, stop_and_rebound);
        let (peak, rest) = (detector.peak().unwrap(), detector.rest().unwrap());
        assert!((peak.depth - 0.085).abs() < 1e-12 && (peak.time - 1.5e-3).abs() < 1e-12, "{peak:?}");
        assert!((rest.depth - 0.083).abs() < 1e-12, "{rest:?}");
        // The rebound covers the last 0.2 mm in 0.05 ms.
        assert!((rest.time - 1.95e-3).abs() < 1.1e-5, "{rest:?}");
        assert!(detector.samples.len() <= 102, "{} samples", detector.samples.len());
    }

    #[test]
    fn a_projectile_that_moves_on_is_not_at_rest() {
        // Still for two milliseconds, then on at 1 m/s: the rest ends.
        let creeping = |time: f64| 0.05 + (time - 3e-3).max(0.0);
        let still = detect(1e-5, 3e-3, creeping).rest().unwrap();
        assert!((still.depth - 0.05).abs() < 1e-12 && still.time.abs() < 1e-12, "{still:?}");
        assert_eq!(detect(1e-5, 4e-3, creeping).rest(), None);
        assert_eq!(detect(1e-5, 0.9e-3, creeping).rest(), None);
        // An oscillation of 0.3 mm about a mean is a motion, one of 0.1 mm is none.
        let swinging = |amplitude: f64| move |time: f64| 0.05 + amplitude * (time * 2e4).sin();
        assert_eq!(detect(1e-5, 4e-3, swinging(1.5e-4)).rest(), None);
        assert!((detect(1e-5, 4e-3, swinging(0.5e-4)).rest().unwrap().depth - 0.05).abs() < 5e-6);
    }

    #[test]
    fn the_mean_is_weighted_by_communication_steps() {
        let slow = |time: f64| 0.05 + 0.1 * time;
        let (coarse, fine) = (detect(0.7e-3, 4.2e-3, slow).rest().unwrap(), detect(1e-6, 4.2e-3, slow).rest().unwrap());
        assert!((coarse.depth - slow(3.7e-3)).abs() < 1e-12 && (fine.depth - coarse.depth).abs() < 1e-12);
        let mut uneven = RestDetector::new();
        for time in [0.0, 1e-3, 3.2e-3, 3.21e-3, 3.22e-3, 4.2e-3] {
            uneven.push(time, slow(time));
        }
        assert!((uneven.rest().unwrap().depth - coarse.depth).abs() < 1e-12);
        // The sliding extremes of the queues are those of a search through the window.
        let swinging = |time: f64| 0.05 + 1.5e-4 * (time * 4e3).sin() * (time * 700.0).cos();
        let detector = detect(1e-5, 4e-3, swinging);
        let depths = || (300..=400).map(|i| swinging(f64::from(i) * 1e-5));
        let range = depths().fold(0.0, f64::max) - depths().fold(f64::INFINITY, f64::min);
        assert!((detector.range().unwrap() - range).abs() < 1e-9, "{:?}, {range}", detector.range());
    }

    #[test]
    fn a_repeated_time_and_a_depth_above_the_gel_are_no_rest() {
        let above = detect(1e-5, 3e-3, |_| -0.01);
        assert_eq!((above.rest(), above.peak().unwrap().depth), (None, -0.01));
        let mut detector = detect(1e-5, 3e-3, |_| 0.01);
        let before = detector.clone();
        detector.push(3e-3, 0.5);
        detector.push(3.1e-3, f64::NAN);
        assert_eq!(detector, before);
    }
}
