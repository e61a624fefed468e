//! Rounding of numbers to significant digits.

/// Rounds a number to three significant digits.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
