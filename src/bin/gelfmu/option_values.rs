//! Parsers of the values of options.

use ballistic_gel::fmi2;
use ballistic_gel::scene::{self, FidelityKind, QuantityKind};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Arg, Command};
use std::ffi::OsStr;

/// Parser of a name: known names are completed, and every text is accepted.
#[derive(Debug, Clone, Copy)]
pub struct NameParser {
    /// Lists the known names.
    known: fn() -> Vec<&'static str>,
}

/// Parser of a scene argument: the name of a built-in scene, or a path.
pub const SCENE_NAME: NameParser = NameParser { known: || scene::builtins().map(|(name, _)| name).collect() };
/// Parser of the name of a projectile of the library.
pub const PROJECTILE_NAME: NameParser = NameParser { known: || scene::library().map(|(name, _)| name).collect() };

impl TypedValueParser for NameParser {
    type Value = String;

    fn parse_ref(&self, command: &Command, _: Option<&Arg>, value: &OsStr) -> Result<String, clap::Error> {
        value.to_str().map(str::to_owned).ok_or_else(|| clap::Error::new(ErrorKind::InvalidUtf8).with_cmd(command))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new((self.known)().into_iter().map(PossibleValue::new)))
    }
}

/// Parses a level by its name, which shells complete, or by its number.
pub fn level_parser() -> impl TypedValueParser<Value = FidelityKind> {
    let numbered = FidelityKind::WITH_INSTANT.iter().zip(["0", "1", "2", "3", "4", "5"]);
    let names = numbered.map(|(level, number)| PossibleValue::new(level.as_str()).alias(number));
    PossibleValuesParser::new(names.collect::<Vec<_>>()).try_map(|text| text.parse::<FidelityKind>())
}

pub fn parse_time(text: &str) -> Result<f64, String> {
    parse_quantity(text, QuantityKind::Time)
}

pub fn parse_length(text: &str) -> Result<f64, String> {
    parse_quantity(text, QuantityKind::Length)
}

/// Parses a positive speed with or without a unit.
pub fn parse_speed(text: &str) -> Result<f64, String> {
    parse_quantity(text, QuantityKind::Speed)
}

pub fn parse_quantity(text: &str, kind: QuantityKind) -> Result<f64, String> {
    let expected = || {
        format!("expected a positive {}, {}, or with a unit, such as \"{}\"", kind.name(), kind.unit(), kind.example())
    };
    kind.parse(text).ok().filter(|value| *value > 0.0).ok_or_else(expected)
}

pub fn parse_positive(text: &str, what: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err(format!("expected a positive {what}")),
    }
}

/// Parses an error in percent as a fraction.
pub fn parse_error(text: &str) -> Result<f64, String> {
    parse_positive(text.trim().trim_end_matches('%').trim_end(), "error in percent, such as 2%")
        .map(|percent| 0.01 * percent)
}

/// Least and greatest number of elements: cells of a fifth of the height of the block; the memory of a process.
const ELEMENT_RANGE: (usize, usize) = (7000, 20_000_000);

/// Parses a number of elements of `gelfmu bench`.
pub fn parse_elements(text: &str) -> Result<usize, String> {
    let (least, most) = ELEMENT_RANGE;
    let number = text.parse::<usize>().ok().filter(|n| (least..=most).contains(n));
    number.ok_or_else(|| format!("expected a number of elements from {least} to {most}"))
}

pub fn parse_threads(text: &str) -> Result<usize, String> {
    let most = fmi2::most_threads();
    match text.parse::<usize>() {
        Ok(n) if n <= most => Ok(n),
        _ => Err(format!("expected 0 for all cores, or a number of threads up to {most}")),
    }
}
