//! Coordinates of the planes of a rectilinear grid along one axis.

/// Equal cells from `from` to `to`, each at most `size` long; the last plane equals `to` bit for bit.
#[must_use]
pub fn uniform(from: f64, to: f64, size: f64) -> Vec<f64> {
    let n = n_cells(to - from, size);
    let plane = |i: usize| if i == n { to } else { from + (to - from) * i as f64 / n as f64 };
    (0..=n).map(plane).collect()
}

/// Equal cells from 0 to `length`, each at most `size` long; `by` divides their number.
#[must_use]
pub fn uniform_divisible(length: f64, size: f64, by: usize) -> Vec<f64> {
    let n = by * n_cells(length, size * by as f64);
    uniform(0.0, length, length / n as f64)
}

/// Graded cells: `size` long within `core` of 0, then each `growth` times longer, up to `largest`. The last cell takes
/// the remainder up to `length`; a remainder below half a cell is joined to the cell before it.
#[must_use]
pub fn graded(length: f64, size: f64, (core, growth, largest): (f64, f64, f64)) -> Vec<f64> {
    let mut planes = vec![0.0];
    let (mut at, mut step) = (0.0, size);
    while length - at > 1.5 * step {
        at += step;
        planes.push(at);
        if at >= core {
            step = (step * growth).min(largest);
        }
    }
    if length - at > 1.000_001 * step {
        planes.push(0.5 * (at + length));
    }
    planes.push(length);
    planes
}

/// Least number of equal cells no longer than `size`.
fn n_cells(length: f64, size: f64) -> usize {
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
    fn the_number_of_cells_can_be_asked_to_be_divisible() {
        for n in 1..400 {
            let (length, by) = (1e-3 * f64::from(n), 1 << (n % 6));
            let planes = uniform_divisible(length, 0.7e-3, by);
            assert!(
                (planes.len() - 1).is_multiple_of(by)
                    && planes[1] <= 0.700_001e-3
                    && planes[planes.len() - 1] == length
            );
        }
        assert_eq!(uniform_divisible(1.0, 0.25, 4), [0.0, 0.25, 0.5, 0.75, 1.0]);
    }

    #[test]
    fn the_last_plane_is_the_end_to_the_bit() {
        for n in 1..400 {
            let (half, size) = (1e-3 * f64::from(n), 0.7e-3);
            let planes = uniform(-half, half, size);
            assert_eq!((planes[0], planes[planes.len() - 1]), (-half, half));
        }
    }

    #[test]
    fn graded_planes_keep_the_core_and_grow_to_the_far_end() {
        for growth in [1.2, 2.0, 10.0, 1e6] {
            let planes = graded(0.15, 1e-3, (0.01, growth, 0.01));
            let widths: Vec<f64> = planes.windows(2).map(|w| w[1] - w[0]).collect();
            assert_eq!((planes[0], *planes.last().unwrap()), (0.0, 0.15));
            assert!(widths[..10].iter().all(|w| (w - 1e-3).abs() < 1e-12));
            let inner = &widths[..widths.len() - 2];
            assert!(inner.windows(2).all(|w| w[1] >= w[0] * 0.999 && w[1] <= w[0] * growth * 1.001));
            assert!(widths.iter().all(|w| *w <= 0.015_001 && *w >= 0.499e-3));
        }
    }
}
