//! Formats of numbers and texts in the report.

/// SI prefixes from 10⁻¹² in steps of a thousand.
const PREFIXES: [&str; 9] = ["p", "n", "µ", "m", "", "k", "M", "G", "T"];
const UNITY: i32 = 4;
/// Least value with a prefix.
const SMALLEST: f64 = 1e-12;
/// Least value written with an exponent instead of a prefix.
const LARGEST: f64 = 1e15;

/// Returns the factor and the prefix that bring a magnitude between 1 and 1000: 0.014 gives 10³ and "m".
pub(super) fn si_prefix(magnitude: f64) -> (f64, &'static str) {
    if magnitude == 0.0 || !magnitude.is_finite() {
        return (1.0, "");
    }
    // Slightly more than the magnitude: 1000 of one prefix becomes 1 of the next in spite of round-off.
    let thousands = ((magnitude.abs() * (1.0 + 1e-9)).log10() / 3.0).floor().clamp(-4.0, 4.0) as i32;
    (1000f64.powi(-thousands), PREFIXES[(thousands + UNITY) as usize])
}

/// Significant digits of a number on the page.
pub(super) const PAGE_DIGITS: i32 = 3;
/// Significant digits of a number on the console.
pub(super) const CONSOLE_DIGITS: i32 = 4;

/// Formats a value with unit in three significant digits: "14.1 mm".
pub(in crate::output) fn quantity(value: f64, unit: &str) -> String {
    quantity_in(value, unit, PAGE_DIGITS)
}

/// Formats a value with unit in a number of significant digits: in four "14.05 mm".
pub(super) fn quantity_in(value: f64, unit: &str, significant: i32) -> String {
    match value.abs() {
        size if !size.is_finite() => "not known".to_string(),
        size if size > 0.0 && !(SMALLEST..LARGEST).contains(&size) => {
            format!("{} {unit}", ratio_in(value, significant))
        }
        _ => format_prefixed(value, value, unit, significant),
    }
}

/// Returns the label of a peak force with the window of its mean, s: the figure depends on it.
#[must_use]
pub fn peak_force_label(window: f64) -> String {
    let width = quantity_in(window, "s", CONSOLE_DIGITS);
    let (digits, unit) = width.split_once(' ').unwrap_or((&width, ""));
    let digits = if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
    format!("peak force, mean over {digits} {unit}").trim_end().to_owned()
}

/// Formats a value with unit in three significant digits and the prefix of the end of its scale.
pub(super) fn format_tick(value: f64, end: f64, unit: &str) -> String {
    if value.is_finite() && value.abs() < LARGEST {
        format_prefixed(value, end, unit, 3)
    } else {
        quantity(value, unit)
    }
}

/// Returns the factor and the unit that bring a magnitude between 1 and 1000, even outside the prefixes: 10¹⁸ m gives
/// 10⁻¹⁸ and "10^18 m".
pub(super) fn si_scale(magnitude: f64, unit: &str) -> (f64, String) {
    /// Powers of a thousand whose factor and inverse are doubles.
    const THOUSANDS: (f64, f64) = (-100.0, 102.0);
    if magnitude == 0.0 || !magnitude.is_finite() || (SMALLEST..LARGEST).contains(&magnitude) {
        let (factor, prefix) = si_prefix(magnitude);
        return (factor, format!("{prefix}{unit}"));
    }
    let thousands = (magnitude.log10() / 3.0).floor().clamp(THOUSANDS.0, THOUSANDS.1) as i32;
    (1000f64.powi(-thousands), format!("10^{} {unit}", 3 * thousands))
}

fn format_prefixed(value: f64, model: f64, unit: &str, significant: i32) -> String {
    let (factor, prefix) = si_prefix(model);
    format!("{} {prefix}{unit}", format_digits(value * factor, significant))
}

/// Formats a length, m, in millimetres without trailing zeros.
pub(super) fn millimetres(length: f64) -> String {
    let text = format!("{:.3}", 1e3 * length);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Formats a ratio or an error in three significant digits, with an exponent if small or large.
pub(super) fn ratio(value: f64) -> String {
    ratio_in(value, PAGE_DIGITS)
}

/// Formats a ratio or an error in a number of significant digits, with an exponent if small or large.
pub(super) fn ratio_in(value: f64, significant: i32) -> String {
    match value.abs() {
        0.0 => "0".to_string(),
        size if !size.is_finite() => "not known".to_string(),
        size if (1e-3..1e4).contains(&size) => format_digits(value, significant),
        _ => {
            let text = format!("{value:.2e}");
            let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
            format!("{mantissa} × 10<sup>{}</sup>", exponent.replace('-', "−")).replace('-', "−")
        }
    }
}

/// Formats a fraction in percent, in three significant digits.
pub(super) fn percent(value: f64) -> String {
    percent_in(value, PAGE_DIGITS)
}

/// Formats a fraction in percent, in a number of significant digits.
pub(super) fn percent_in(value: f64, significant: i32) -> String {
    ratio_in(100.0 * value, significant) + " %"
}

/// Formats a length, m, in centimetres, in three significant digits and without trailing zeros: "4.25 cm".
pub(super) fn centimetres(length: f64) -> String {
    shortest(100.0 * length) + " cm"
}

/// Formats a number in three significant digits, without trailing zeros: "8.04", "15".
pub(super) fn shortest(value: f64) -> String {
    let text = format_digits(value, PAGE_DIGITS);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Formats a count with thin spaces between thousands.
pub(super) fn count(value: f64) -> String {
    if value.is_nan() || value.abs() >= LARGEST {
        return ratio(value);
    }
    let plain = format!("{value:.0}");
    let digits = plain.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy);
    digits.collect::<Vec<_>>().join("\u{202f}")
}

fn format_digits(value: f64, significant: i32) -> String {
    let size = value.abs();
    let places = |size: f64| match size {
        0.0 => 0,
        _ => (significant - 1 - size.log10().floor() as i32).clamp(0, 6) as usize,
    };
    // A value that rounds up to the next power of ten has one digit more before the point.
    let rounded: f64 = format!("{size:.0$}", places(size)).parse().unwrap_or(size);
    format!("{value:.0$}", places(rounded)).replace('-', "−")
}

/// Returns a list of texts as HTML.
pub(super) fn bullet_list(texts: &[String]) -> String {
    let items: Vec<String> = texts.iter().map(|text| format!("<li>{}</li>", escape(text))).collect();
    format!("<ul>{}</ul>", items.concat())
}

/// Escapes a text for HTML; characters outside XML are replaced by U+FFFD.
pub(in crate::output) fn escape(text: &str) -> String {
    let is_forbidden = |c: char| (c.is_control() && c != '\n' && c != '\t') || matches!(c, '\u{fffe}' | '\u{ffff}');
    let text = text.replace(is_forbidden, "\u{fffd}");
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_label_of_a_peak_force_names_its_window() {
        let windows = [24e-6, 24.35e-6, 1e-4, 0.0].map(peak_force_label);
        let expected = ["24 µs", "24.35 µs", "100 µs", "0 s"].map(|width| format!("peak force, mean over {width}"));
        assert_eq!(windows, expected);
    }

    #[test]
    fn quantities_carry_the_prefix_that_suits_them() {
        assert_eq!(quantity(0.01405, "m"), "14.1 mm");
        assert_eq!(quantity_in(0.01405, "m", 4), "14.05 mm");
        assert_eq!(quantity(1e-3, "s"), "1.00 ms");
        assert_eq!(quantity(-3.8634, "m/s"), "−3.86 m/s");
        assert_eq!(quantity(9.999e-3, "m"), "10.0 mm", "a number that rounds up has no digit more");
        assert_eq!(quantity(0.0, "J"), "0 J");
        assert_eq!(quantity(f64::NAN, "J"), "not known");
        assert_eq!(quantity(-1e300, "m"), "−1.00 × 10<sup>300</sup> m");
        assert_eq!(format_tick(1e300, 1e300, "m"), "1.00 × 10<sup>300</sup> m");
    }

    #[test]
    fn ratios_and_counts_can_be_read() {
        assert_eq!(ratio(1.234e-12), "1.23 × 10<sup>−12</sup>");
        assert_eq!([ratio(12.5), shortest(12.5), shortest(8.037)], ["12.5", "12.5", "8.04"]);
        assert_eq!([centimetres(0.15), centimetres(0.0425), centimetres(0.4)], ["15 cm", "4.25 cm", "40 cm"]);
        assert_eq!(count(1_234_567.0), "1\u{202f}234\u{202f}567");
        assert_eq!((count(1e300), count(f64::NAN)), ("1.00 × 10<sup>300</sup>".to_owned(), "not known".to_owned()));
    }

    #[test]
    fn every_magnitude_has_a_scale() {
        assert_eq!(si_scale(0.014, "m"), (1e3, "mm".to_owned()));
        assert_eq!(si_scale(2e19, "m"), (1e-18, "10^18 m".to_owned()));
        for magnitude in [5e-324, 1e-300, 1e-13, 1e-12, 1.0, 999.9, 1e15, 1e300, f64::MAX] {
            let scaled = si_scale(magnitude, "m").0 * magnitude;
            assert!(scaled < 1000.1 && (scaled >= 0.999 || magnitude < 1e-299), "{magnitude}: {scaled}");
        }
    }
}
