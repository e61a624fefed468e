//! Rounding of numbers to significant digits.

/// Rounds a number to three significant digits.
pub fn rounded(value: f64) -> f64 {
    rounded_to(3, value)
}

/// Rounds a number to a number of significant digits.
pub fn rounded_to(digits: usize, value: f64) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}
