//! Where the planes of a rectilinear grid lie along one axis.

/// `n` equal cells from `from` to `to`, each at most `size` long.
#[must_use]
pub fn uniform(from: f64, to: f64, size: f64) -> Vec<f64> {
    let n = cells(to - from, size);
    (0..=n).map(|i| from + (to - from) * i as f64 / n as f64).collect()
}

/// Cells that grow away from `from`: `size` long within `core`, then each `growth` times longer up to `largest`.
///
/// All are scaled by one factor ≤ 1 so that the last one ends at `to`.
#[must_use]
pub fn graded(from: f64, to: f64, size: f64, (core, growth, largest): (f64, f64, f64)) -> Vec<f64> {
    let length = (to - from).abs();
    let mut planes = vec![0.0];
    let (mut at, mut step) = (0.0, size);
    while at < length * (1.0 - 1e-9) {
        at += step;
        planes.push(at);
        if at >= core {
            step = (step * growth).min(largest);
        }
    }
    let scale = (to - from) / at;
    planes.iter().map(|p| from + p * scale).collect()
}

fn cells(length: f64, size: f64) -> usize {
    ((length / size - 1e-9).ceil() as usize).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_planes_span_the_axis_with_cells_no_longer_than_asked() {
        assert_eq!(uniform(-1.0, 1.0, 0.5), [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert_eq!(uniform(0.0, 1.0, 0.3).len(), 5);
    }

    #[test]
    fn graded_planes_grow_from_the_core_to_the_far_end() {
        let planes = graded(0.0, -0.15, 1e-3, (0.01, 1.2, 0.01));
        let widths: Vec<f64> = planes.windows(2).map(|w| w[0] - w[1]).collect();
        assert_eq!((planes[0], *planes.last().unwrap()), (0.0, -0.15));
        assert!(widths[0] <= 1e-3 && widths[0] > 0.85e-3);
        assert!(widths.windows(2).all(|w| w[1] >= w[0] * 0.999 && w[1] <= w[0] * 1.2001));
    }
}
