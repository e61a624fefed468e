//! Units of the figures that people read: SI, or those customary in the United States. Files keep SI.

/// Inch, m (exact, NIST SP 811).
pub const INCH: f64 = 0.0254;
/// Foot, m (exact, NIST SP 811).
pub const FOOT: f64 = 0.3048;
/// Grain, kg (exact, NIST SP 811).
pub const GRAIN: f64 = 64.798_91e-6;
/// Pound-force, N (exact, NIST SP 811).
pub const POUND_FORCE: f64 = 4.448_221_615_260_5;
/// Foot pound-force, J: the product of both units, 1.355 817 948 331 400 4 J.
pub const FOOT_POUND: f64 = FOOT * POUND_FORCE;

/// Significant digits of a figure.
const SIGNIFICANT: i32 = 4;
/// SI prefixes from 10⁻¹² in steps of a thousand.
const PREFIXES: [&str; 9] = ["p", "n", "µ", "m", "", "k", "M", "G", "T"];

/// System of units of the figures that people read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum UnitSystem {
    /// International System of Units.
    #[default]
    Si,
    /// Inches, feet per second, grains, pounds-force and foot-pounds.
    Us,
}

/// Customary unit of a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CustomaryUnit {
    /// Symbol.
    pub symbol: &'static str,
    /// Value of the unit in SI.
    pub in_si: f64,
}

impl UnitSystem {
    /// Returns the customary unit in the place of an SI unit; `None` in SI, and for a quantity without one, such as a time.
    ///
    /// # Examples
    /// ```
    /// use ballistic_gel::output::UnitSystem;
    ///
    /// let inch = UnitSystem::Us.customary_unit("m").unwrap();
    /// assert_eq!((inch.symbol, inch.in_si), ("in", 0.0254));
    /// assert_eq!(UnitSystem::Si.customary_unit("m"), None);
    /// ```
    #[must_use]
    pub fn customary_unit(self, si: &str) -> Option<CustomaryUnit> {
        let (symbol, in_si) = match (self, si) {
            (Self::Us, "m") => ("in", INCH),
            (Self::Us, "m/s") => ("ft/s", FOOT),
            (Self::Us, "kg") => ("gr", GRAIN),
            (Self::Us, "J") => ("ft·lbf", FOOT_POUND),
            (Self::Us, "J/m") => ("ft·lbf/in", FOOT_POUND / INCH),
            (Self::Us, "N") => ("lbf", POUND_FORCE),
            (Self::Us, "N s") => ("lbf·s", POUND_FORCE),
            _ => return None,
        };
        Some(CustomaryUnit { symbol, in_si })
    }

    /// Formats an SI value in four significant digits, in plain text: "14.05 mm", "0.5531 in".
    ///
    /// # Examples
    /// ```
    /// use ballistic_gel::output::UnitSystem;
    ///
    /// assert_eq!(UnitSystem::Si.format(0.01405, "m"), "14.05 mm");
    /// assert_eq!(UnitSystem::Us.format(350.52, "m/s"), "1150 ft/s");
    /// ```
    #[must_use]
    pub fn format(self, value: f64, si: &str) -> String {
        match self.customary_unit(si) {
            Some(CustomaryUnit { symbol, in_si }) => format!("{} {symbol}", digits(value / in_si)),
            None => format_with_prefix(value, si),
        }
    }

    /// Formats a length to a tenth of a millimetre, or a hundredth of an inch: "83.2 mm", "3.28 in".
    #[must_use]
    pub fn format_length(self, length: f64) -> String {
        match self {
            Self::Si => format!("{:.1} mm", 1e3 * length),
            Self::Us => format!("{:.2} in", length / INCH),
        }
    }

    /// Formats the sides of a block to a millimetre, or a tenth of an inch: "150 x 150 x 400 mm".
    #[must_use]
    pub fn format_sides(self, sides: [f64; 3]) -> String {
        let [a, b, c] = sides;
        match self {
            Self::Si => format!("{:.0} x {:.0} x {:.0} mm", 1e3 * a, 1e3 * b, 1e3 * c),
            Self::Us => format!("{:.1} x {:.1} x {:.1} in", a / INCH, b / INCH, c / INCH),
        }
    }

    /// Formats a mass to a hundredth of a gram, or a tenth of a grain: "8.04 g", "124.1 gr".
    #[must_use]
    pub fn format_mass(self, mass: f64) -> String {
        match self {
            Self::Si => format!("{:.2} g", 1e3 * mass),
            Self::Us => format!("{:.1} gr", mass / GRAIN),
        }
    }

    /// Formats a speed with this number of decimals: "350 m/s", "1148 ft/s".
    #[must_use]
    pub fn format_speed(self, speed: f64, decimals: usize) -> String {
        match self {
            Self::Si => format!("{speed:.decimals$} m/s"),
            Self::Us => format!("{:.decimals$} ft/s", speed / FOOT),
        }
    }
}

/// Formats an SI value with the prefix that brings it between 1 and 1000.
fn format_with_prefix(value: f64, unit: &str) -> String {
    let size = value.abs();
    if size == 0.0 || !(1e-12..1e15).contains(&size) {
        return format!("{} {unit}", digits(value));
    }
    // Slightly more than the size: 1000 of one prefix becomes 1 of the next in spite of round-off.
    let thousands = ((size * (1.0 + 1e-9)).log10() / 3.0).floor().clamp(-4.0, 4.0) as i32;
    format!("{} {}{unit}", digits(value * 1000f64.powi(-thousands)), PREFIXES[(thousands + 4) as usize])
}

/// Formats a number in four significant digits, with an exponent if it is very small or large.
fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e7).contains(&size) {
        return format!("{value:.3e}");
    }
    let places = (SIGNIFICANT - 1 - size.log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.places$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn customary_units_have_their_exact_factors() {
        assert_eq!(FOOT_POUND, 1.355_817_948_331_400_4);
        let us = |value: f64, unit: &str| UnitSystem::Us.format(value, unit);
        assert_eq!(us(0.0254, "m"), "1.000 in");
        assert_eq!(us(0.3048, "m/s"), "1.000 ft/s");
        assert_eq!(us(124.0 * 64.798_91e-6, "kg"), "124.0 gr");
        assert_eq!(us(1_355.817_948_331_400_4, "J"), "1000 ft·lbf");
        assert_eq!(us(1.355_817_948_331_400_4 / 0.0254, "J/m"), "1.000 ft·lbf/in");
        assert_eq!(us(4.448_221_615_260_5, "N"), "1.000 lbf");
        assert_eq!(us(-0.01, "m"), "-0.3937 in");
        assert_eq!([us(2e-3, "s"), us(0.0, "m")], ["2.000 ms", "0 in"]);
    }

    #[test]
    fn si_values_carry_the_prefix_that_suits_them() {
        let si = |value: f64, unit: &str| UnitSystem::Si.format(value, unit);
        assert_eq!([si(0.01405, "m"), si(1e-3, "s"), si(-3.8634, "m/s")], ["14.05 mm", "1.000 ms", "-3.863 m/s"]);
        assert_eq!([si(0.0, "J"), si(61_234.0, "N"), si(1e-300, "m")], ["0 J", "61.23 kN", "1.000e-300 m"]);
    }

    #[test]
    fn lengths_masses_and_speeds_have_fixed_decimals() {
        let [si, us] = [UnitSystem::Si, UnitSystem::Us];
        assert_eq!([si.format_length(0.0832), us.format_length(0.0832)], ["83.2 mm", "3.28 in"]);
        assert_eq!([si.format_mass(8.04e-3), us.format_mass(8.04e-3)], ["8.04 g", "124.1 gr"]);
        assert_eq!([si.format_speed(350.0, 0), us.format_speed(350.0, 0)], ["350 m/s", "1148 ft/s"]);
    }
}
