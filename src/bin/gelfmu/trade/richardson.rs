//! What a quantity would be with cells of no size, from three meshes.

/// A limit of refinement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// f₀.
    pub value: f64,
    /// Observed order p.
    pub order: f64,
    /// What errors are relative to.
    pub scale: f64,
    /// Distance of the finest of the three from it, of the scale: how far it may itself be wrong.
    pub reach: f64,
}

/// Why three values have no limit that can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoLimit {
    /// They go up and down.
    #[error("not monotone")]
    NotMonotone,
    /// They come together too slowly, or not at all, or at once.
    #[error("no order from {least} to {most}")]
    NoOrder {
        /// Least order.
        least: f64,
        /// Greatest order.
        most: f64,
    },
    /// The finest is still far away.
    #[error("not converged: the finest is {:.0} % away", 100.0 * .reach)]
    Far {
        /// Its distance, of the scale.
        reach: f64,
    },
}

/// Orders between which three values tell of a limit: below, it is mostly extrapolation, above, mostly chance.
const ORDERS: (f64, f64) = (0.5, 6.0);
/// Greatest distance of the finest value from a limit, of the scale.
const REACH: f64 = 0.1;

/// Limit of f(h) = f₀ + C hᵖ through three sizes h, finest last (Richardson); errors are relative to `scale`, or to f₀.
///
/// # Errors
/// [`NoLimit`] where the values are not monotone, p is out of range, or f₀ lies far beyond the finest value.
pub fn limit([a, b, c]: [(f64, f64); 3], scale: Option<f64>) -> Result<Limit, NoLimit> {
    let ratio = (a.1 - b.1) / (b.1 - c.1);
    if !(ratio > 0.0 && ratio.is_finite()) {
        return Err(NoLimit::NotMonotone);
    }
    let misfit = |p: f64| (a.0.powf(p) - b.0.powf(p)) / (b.0.powf(p) - c.0.powf(p)) - ratio;
    let (mut low, mut high) = ORDERS;
    if misfit(low) * misfit(high) > 0.0 {
        return Err(NoLimit::NoOrder { least: low, most: high });
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if misfit(middle) * misfit(low) > 0.0 { low = middle } else { high = middle }
    }
    let constant = (b.1 - c.1) / (b.0.powf(low) - c.0.powf(low));
    let value = c.1 - constant * c.0.powf(low);
    let scale = scale.unwrap_or(value.abs());
    let reach = (c.1 - value).abs() / scale;
    if reach > REACH { Err(NoLimit::Far { reach }) } else { Ok(Limit { value, order: low, scale, reach }) }
}

#[cfg(test)]
mod tests {
    use super::{NoLimit, limit};

    fn of(f: impl Fn(f64) -> f64, sizes: [f64; 3]) -> Result<super::Limit, NoLimit> {
        limit(sizes.map(|h| (h, f(h))), None)
    }

    #[test]
    fn a_power_law_gives_back_its_order_and_limit_for_any_three_sizes() {
        for (order, sizes) in
            [(1.0, [4.0, 2.0, 1.0]), (2.0, [5.0, 3.57, 2.5]), (0.7, [2.0, 1.41, 1.0]), (1.5, [3.0, 2.0, 1.0])]
        {
            let found = of(|h| 14.5 - 0.03 * h.powf(order), sizes).unwrap();
            assert!((found.order - order).abs() < 1e-9, "{found:?}");
            assert!((found.value - 14.5).abs() < 1e-10, "{found:?}");
            assert!((found.reach - 0.03 / 14.5 * sizes[2].powf(order)).abs() < 1e-10, "{found:?}");
            let of_another = limit(sizes.map(|h| (h, 14.5 - 0.03 * h.powf(order))), Some(29.0)).unwrap();
            assert!((of_another.reach - 0.5 * found.reach).abs() < 1e-12, "{of_another:?}");
        }
    }

    #[test]
    fn what_goes_up_and_down_or_stands_still_has_no_limit() {
        assert_eq!(limit([(4.0, 1.0), (2.0, 2.0), (1.0, 1.5)], None), Err(NoLimit::NotMonotone));
        assert_eq!(limit([(4.0, 1.0), (2.0, 1.0), (1.0, 1.0)], None), Err(NoLimit::NotMonotone));
        assert_eq!(limit([(4.0, 1.0), (2.0, f64::NAN), (1.0, 1.0)], None), Err(NoLimit::NotMonotone));
    }

    #[test]
    fn what_goes_away_faster_and_faster_or_ends_far_away_has_no_limit() {
        assert!(matches!(limit([(4.0, 1.0), (2.0, 2.0), (1.0, 4.0)], None), Err(NoLimit::NoOrder { .. })));
        assert!(
            matches!(of(|h| 1.0 - 0.5 * h, [4.0, 2.0, 1.0]), Err(NoLimit::Far { reach }) if (reach - 0.5).abs() < 1e-9)
        );
    }
}
