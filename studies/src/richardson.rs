//! Richardson extrapolation to zero cell size from three meshes.

/// Value of a quantity on a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshValue {
    /// Relative size of the cells.
    pub size: f64,
    /// Value of the quantity.
    pub value: f64,
}

/// Limit of refinement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefinementLimit {
    /// Extrapolated value f₀.
    pub value: f64,
    /// Observed order p.
    pub order: f64,
    /// Scale of the errors.
    pub scale: f64,
    /// Distance of the finest value from the limit, relative to the scale: a bound on the error of the limit.
    pub reach: f64,
}

/// Reason why three values have no trustworthy limit.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoLimit {
    /// The values are not monotone.
    #[error("not monotone")]
    NotMonotone,
    /// The observed order is out of range.
    #[error("no order from {least} to {most}")]
    NoOrder {
        /// Least order.
        least: f64,
        /// Greatest order.
        most: f64,
    },
    /// The finest value is far from the limit.
    #[error("not converged: the finest is {:.0} % away", 100.0 * .reach)]
    Far {
        /// Distance, relative to the scale.
        reach: f64,
    },
}

/// Trustworthy orders: below, the limit is mostly extrapolation, above, mostly chance.
const ORDER_RANGE: (f64, f64) = (0.5, 6.0);
/// Greatest distance of the finest value from the limit, relative to the scale.
const LARGEST_REACH: f64 = 0.1;

/// Extrapolates f(h) = f₀ + C hᵖ from three sizes h, finest last; errors are relative to `scale`, or to f₀.
pub fn extrapolate_limit([a, b, c]: [MeshValue; 3], scale: Option<f64>) -> Result<RefinementLimit, NoLimit> {
    let ratio = (a.value - b.value) / (b.value - c.value);
    if !(ratio > 0.0 && ratio.is_finite()) {
        return Err(NoLimit::NotMonotone);
    }
    let misfit = |p: f64| (a.size.powf(p) - b.size.powf(p)) / (b.size.powf(p) - c.size.powf(p)) - ratio;
    let (mut low, mut high) = ORDER_RANGE;
    if misfit(low) * misfit(high) > 0.0 {
        return Err(NoLimit::NoOrder { least: low, most: high });
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if misfit(middle) * misfit(low) > 0.0 { low = middle } else { high = middle }
    }
    let constant = (b.value - c.value) / (b.size.powf(low) - c.size.powf(low));
    let value = c.value - constant * c.size.powf(low);
    let scale = scale.unwrap_or(value.abs());
    let reach = (c.value - value).abs() / scale;
    if reach > LARGEST_REACH {
        Err(NoLimit::Far { reach })
    } else {
        Ok(RefinementLimit { value, order: low, scale, reach })
    }
}

#[cfg(test)]
mod tests {
    use super::{MeshValue, NoLimit, RefinementLimit, extrapolate_limit};

    fn limit(values: [(f64, f64); 3], scale: Option<f64>) -> Result<RefinementLimit, NoLimit> {
        extrapolate_limit(values.map(|(size, value)| MeshValue { size, value }), scale)
    }

    fn of(f: impl Fn(f64) -> f64, sizes: [f64; 3]) -> Result<RefinementLimit, NoLimit> {
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
    fn values_that_oscillate_or_stand_still_have_no_limit() {
        assert_eq!(limit([(4.0, 1.0), (2.0, 2.0), (1.0, 1.5)], None), Err(NoLimit::NotMonotone));
        assert_eq!(limit([(4.0, 1.0), (2.0, 1.0), (1.0, 1.0)], None), Err(NoLimit::NotMonotone));
        assert_eq!(limit([(4.0, 1.0), (2.0, f64::NAN), (1.0, 1.0)], None), Err(NoLimit::NotMonotone));
    }

    #[test]
    fn values_that_diverge_or_end_far_away_have_no_limit() {
        assert!(matches!(limit([(4.0, 1.0), (2.0, 2.0), (1.0, 4.0)], None), Err(NoLimit::NoOrder { .. })));
        assert!(
            matches!(of(|h| 1.0 - 0.5 * h, [4.0, 2.0, 1.0]), Err(NoLimit::Far { reach }) if (reach - 0.5).abs() < 1e-9)
        );
    }
}
