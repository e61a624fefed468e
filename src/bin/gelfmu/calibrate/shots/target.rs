//! Measured values of shots, and the residuals of computed ones.

/// Measured value with its band and its window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitTarget {
    /// Measured value, SI units.
    pub value: f64,
    /// Band: unit of the residual.
    pub band: f64,
    /// Half width of the window about the measured value without a residual; 0 for none.
    pub window: f64,
}

impl FitTarget {
    /// Returns the edge of the window that is next to a computed value outside it; `None` within the window.
    pub fn violated_edge(&self, computed: f64) -> Option<f64> {
        let deviation = computed - self.value;
        (deviation.abs() > self.window).then(|| self.value + self.window.copysign(deviation))
    }

    /// Returns the residual, in bands: the distance of a computed value from the window, with its sign.
    pub fn residual(&self, computed: f64) -> f64 {
        self.violated_edge(computed).map_or(0.0, |edge| (computed - edge) / self.band)
    }
}

#[cfg(test)]
mod tests {
    use super::FitTarget;

    #[test]
    fn a_value_within_the_window_has_no_residual_and_outside_it_counts_from_the_edge() {
        let slope = FitTarget { value: 0.51, band: 0.02, window: 0.05 };
        for inside in [0.46 + 1e-9, 0.5, 0.51, 0.56 - 1e-9] {
            assert_eq!(slope.residual(inside), 0.0, "{inside}");
        }
        assert!((slope.residual(0.58) - 1.0).abs() < 1e-9 && (slope.residual(0.42) + 2.0).abs() < 1e-9);
        let depth = FitTarget { value: 0.085, band: 0.0005, window: 0.0 };
        assert_eq!(depth.residual(0.085), 0.0);
        assert!((depth.residual(0.0848) + 0.4).abs() < 1e-9);
    }
}
