//! Quantities with units in the text of a scene, such as `"124 gr"`: replaced by SI numbers before the text is read.

use super::SceneError;
use super::places::{KeyLocations, join, numbered};
use std::borrow::Cow;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use uom::si::{angle, angular_velocity, f64 as si, length, mass, mass_density, pressure, time, velocity};

/// Physical quantity of a key of a scene, or of an option of the command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QuantityKind {
    /// Length, m.
    Length,
    /// Mass, kg.
    Mass,
    /// Time, s.
    Time,
    /// Speed, m/s.
    Speed,
    /// Angular velocity, rad/s.
    AngularVelocity,
    /// Mass density, kg/m3.
    Density,
    /// Pressure, stress or modulus, Pa.
    Pressure,
    /// Angle, degrees: the unit of angles in a scene.
    Angle,
}

/// Names of the keys that take a quantity: the last part of the dotted key, in all tables.
const KEYS: [(QuantityKind, &[&str]); 8] = [
    (
        QuantityKind::Length,
        &[
            "radius",
            "length",
            "edge_radius",
            "arc_radius",
            "meplat_radius",
            "size",
            "height",
            "high",
            "low",
            "bore",
            "inner",
            "outer",
            "corner",
            "leg",
            "thickness",
            "width",
            "core",
            "largest",
            "depth",
            "position",
            "erosion_thickness",
            "smallest",
            "tip_size",
            "face_width",
            "head_length",
            "shank_radius",
            "rim_radius",
            "path",
        ],
    ),
    (QuantityKind::Mass, &["mass"]),
    (
        QuantityKind::Time,
        &["time", "delay", "ramp", "times", "communication_step", "end_time", "stop_after_exit", "force_window"],
    ),
    (QuantityKind::Speed, &["velocity", "speed", "opening_speed", "full_speed"]),
    (QuantityKind::AngularVelocity, &["angular_velocity"]),
    (QuantityKind::Density, &["density"]),
    (
        QuantityKind::Pressure,
        &[
            "shear_modulus",
            "bulk_modulus",
            "pressure",
            "c1",
            "c2",
            "stress",
            "modulus",
            "tension_limit",
            "opening_pressure",
            "full_pressure",
        ],
    ),
    (QuantityKind::Angle, &["angle", "curvature_angle", "face_angle"]),
];

/// Units that people write and the library of units names otherwise.
const SYNONYMS: [(&str, &str); 11] = [
    ("fps", "ft/s"),
    ("kph", "km/h"),
    ("mph", "mi/h"),
    ("us", "µs"),
    ("um", "µm"),
    ("μm", "µm"),
    ("deg", "°"),
    ("deg/s", "°/s"),
    ("g/cm3", "g/cm³"),
    ("g/cc", "g/cm³"),
    ("kg/m3", "kg/m³"),
];

impl QuantityKind {
    /// All quantities.
    pub const ALL: [Self; 8] = [
        Self::Length,
        Self::Mass,
        Self::Time,
        Self::Speed,
        Self::AngularVelocity,
        Self::Density,
        Self::Pressure,
        Self::Angle,
    ];

    /// Quantity of the values of a key, by the last part of its name; `None` for a key without a unit.
    #[must_use]
    pub fn of_key(name: &str) -> Option<Self> {
        KEYS.iter().find(|(_, names)| names.contains(&name)).map(|(kind, _)| *kind)
    }

    /// Unit of a number without one.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Length => "m",
            Self::Mass => "kg",
            Self::Time => "s",
            Self::Speed => "m/s",
            Self::AngularVelocity => "rad/s",
            Self::Density => "kg/m3",
            Self::Pressure => "Pa",
            Self::Angle => "degrees",
        }
    }

    /// Name of the quantity.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Length => "length",
            Self::Mass => "mass",
            Self::Time => "time",
            Self::Speed => "speed",
            Self::AngularVelocity => "angular velocity",
            Self::Density => "density",
            Self::Pressure => "pressure",
            Self::Angle => "angle",
        }
    }

    /// Value with a unit, as an example.
    #[must_use]
    pub fn example(self) -> &'static str {
        match self {
            Self::Length => "9.02 mm",
            Self::Mass => "124 gr",
            Self::Time => "10 ms",
            Self::Speed => "1150 ft/s",
            Self::AngularVelocity => "30 °/s",
            Self::Density => "1.03 g/cm3",
            Self::Pressure => "80 kPa",
            Self::Angle => "2 °",
        }
    }

    /// Parses a number with a unit, or without one a number in [`Self::unit`], to 15 digits.
    ///
    /// # Errors
    /// Expected text, for a text that is neither.
    ///
    /// # Examples
    /// ```
    /// use ballistic_gel::scene::QuantityKind;
    ///
    /// assert_eq!(QuantityKind::Speed.parse("1150 ft/s"), Ok(350.52));
    /// assert_eq!(QuantityKind::Length.parse("9.02mm"), Ok(9.02e-3));
    /// assert_eq!(QuantityKind::Mass.parse("8e-3"), Ok(8e-3));
    /// assert!(QuantityKind::Mass.parse("9.02 mm").unwrap_err().contains("such as \"124 gr\""));
    /// ```
    pub fn parse(self, text: &str) -> Result<f64, String> {
        let text = text.trim();
        let (number, unit) = split_unit(text);
        let plain = || number.parse::<f64>().ok();
        let value = if unit.is_empty() { plain() } else { plain().and_then(|_| self.in_scene_unit(number, unit)) };
        value.filter(|value| value.is_finite()).ok_or_else(|| self.expected())
    }

    /// Names of all units that [`Self::parse`] reads: abbreviations, words and synonyms.
    #[must_use]
    pub fn unit_names(self) -> Vec<&'static str> {
        macro_rules! names_in {
            ($units:expr) => {
                $units.flat_map(|unit| [unit.abbreviation(), unit.singular(), unit.plural()]).collect()
            };
        }
        let mut names: Vec<&str> = match self {
            Self::Length => names_in!(length::units()),
            Self::Mass => names_in!(mass::units()),
            Self::Time => names_in!(time::units()),
            Self::Speed => names_in!(velocity::units()),
            Self::AngularVelocity => names_in!(angular_velocity::units()),
            Self::Density => names_in!(mass_density::units()),
            Self::Pressure => names_in!(pressure::units()),
            Self::Angle => names_in!(angle::units()),
        };
        names.extend(SYNONYMS.iter().map(|(written, _)| *written));
        // Synonyms of other quantities, and names that begin with a digit, such as 1/6 in, are not read.
        names.retain(|name| self.parse(&format!("1 {name}")).is_ok());
        names.sort_unstable();
        names.dedup();
        names
    }

    /// Description of a valid value: unit and example.
    pub(super) fn expected(self) -> String {
        format!("a number in {}, or with another unit in quotes, such as \"{}\"", self.unit(), self.example())
    }

    fn in_scene_unit(self, number: &str, unit: &str) -> Option<f64> {
        let unit = SYNONYMS.iter().find(|(written, _)| *written == unit).map_or(unit, |(_, known)| known);
        let text = format!("{number} {unit}");
        let value = match self {
            Self::Length => text.parse::<si::Length>().ok()?.get::<length::meter>(),
            Self::Mass => text.parse::<si::Mass>().ok()?.get::<mass::kilogram>(),
            Self::Time => text.parse::<si::Time>().ok()?.get::<time::second>(),
            Self::Speed => text.parse::<si::Velocity>().ok()?.get::<velocity::meter_per_second>(),
            Self::AngularVelocity => {
                text.parse::<si::AngularVelocity>().ok()?.get::<angular_velocity::radian_per_second>()
            }
            Self::Density => text.parse::<si::MassDensity>().ok()?.get::<mass_density::kilogram_per_cubic_meter>(),
            Self::Pressure => text.parse::<si::Pressure>().ok()?.get::<pressure::pascal>(),
            Self::Angle => text.parse::<si::Angle>().ok()?.get::<angle::degree>(),
        };
        // The product with the factor of a unit has some round-off: 1150 ft/s are 350.52 m/s.
        format!("{value:.14e}").parse().ok()
    }
}

/// Splits a text at the first character of its unit; an exponent belongs to the number.
fn split_unit(text: &str) -> (&str, &str) {
    let is_exponent = |at: usize| {
        let rest = text[at..].strip_prefix(['e', 'E']).map(|rest| rest.trim_start_matches(['+', '-']));
        rest.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
    };
    let is_unit = |(at, c): &(usize, char)| !(c.is_ascii_digit() || "+-._ ".contains(*c) || is_exponent(*at));
    let at = text.char_indices().find(is_unit).map_or(text.len(), |(at, _)| at);
    (text[..at].trim(), text[at..].trim())
}

/// Returns true for a text that begins like a number: `"never"` or a name is none.
pub(super) fn begins_like_number(text: &str) -> bool {
    text.trim_start().starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c))
}

/// Number that replaces a part of a scene text.
struct QuantityReplacement {
    place: Range<usize>,
    number: f64,
}

/// Scene text with SI numbers in place of the quantities with units; the lines stay.
///
/// # Errors
/// [`SceneError`] for a quantity of an unknown unit, or of another unit than its key has.
pub(super) fn si_text(text: &str) -> Result<Cow<'_, str>, SceneError> {
    let Ok(parsed) = DeTable::parse(text) else { return Ok(Cow::Borrowed(text)) };
    let mut replacements = Vec::new();
    let found = convert_table("", parsed.get_ref(), &mut replacements);
    found.map_err(|error| {
        let line = KeyLocations::of(text, parsed.get_ref()).line_of(&error.key);
        SceneError { line, ..error }
    })?;
    if replacements.is_empty() {
        return Ok(Cow::Borrowed(text));
    }
    replacements.sort_by_key(|replacement| replacement.place.start);
    let mut converted = text.to_owned();
    for QuantityReplacement { place, number } in replacements.into_iter().rev() {
        converted.replace_range(place, &format!("{number:?}"));
    }
    Ok(Cow::Owned(converted))
}

fn convert_table(prefix: &str, table: &DeTable<'_>, into: &mut Vec<QuantityReplacement>) -> Result<(), SceneError> {
    for (name, value) in table {
        let kind = QuantityKind::of_key(name.get_ref());
        convert_value(&join(prefix, name.get_ref()), kind, value, into)?;
    }
    Ok(())
}

fn convert_value(
    key: &str,
    kind: Option<QuantityKind>,
    value: &Spanned<DeValue<'_>>,
    into: &mut Vec<QuantityReplacement>,
) -> Result<(), SceneError> {
    match (value.get_ref(), kind) {
        (DeValue::Table(table), _) => convert_table(key, table, into)?,
        (DeValue::Array(values), _) => {
            for (i, value) in values.iter().enumerate() {
                let key = if value.get_ref().is_table() { numbered(key, i) } else { key.to_owned() };
                convert_value(&key, kind, value, into)?;
            }
        }
        (DeValue::String(text), Some(kind)) if begins_like_number(text) => {
            let number = kind.parse(text).map_err(|expected| SceneError::value(key, format!("{text:?}"), expected))?;
            into.push(QuantityReplacement { place: value.span(), number });
        }
        _ => (),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{QuantityKind, si_text, split_unit};
    use crate::scene::{builtin, read};

    #[test]
    fn a_number_is_parted_from_its_unit() {
        for (text, number, unit) in [
            ("124 gr", "124", "gr"),
            ("9.02mm", "9.02", "mm"),
            ("-1.5e3 m/s", "-1.5e3", "m/s"),
            ("2e-3", "2e-3", ""),
            ("3 eV", "3", "eV"),
            ("2°", "2", "°"),
        ] {
            assert_eq!(split_unit(text), (number, unit), "{text}");
        }
    }

    #[test]
    fn units_of_a_quantity_are_those_of_the_trade() {
        use QuantityKind::{Angle, Density, Length, Mass, Pressure, Speed, Time};
        for (kind, text, value) in [
            (Mass, "124 gr", 124.0 * 64.798_91e-6),
            (Mass, "8.04 g", 8.04e-3),
            (Speed, "1150 fps", 350.52),
            (Speed, "350 m/s", 350.0),
            (Length, ".355 in", 9.017e-3),
            (Length, "15 cm", 0.15),
            (Time, "20 us", 20e-6),
            (Pressure, "80 kPa", 80e3),
            (Density, "1.03 g/cm3", 1030.0),
            (Angle, "2 deg", 2.0),
        ] {
            let parsed = kind.parse(text).unwrap();
            assert!((parsed / value - 1.0).abs() < 1e-14, "{text}: {parsed}");
        }
        for (kind, text) in [(Mass, "9 mm"), (Speed, "fast"), (Length, "3 grains"), (Length, ""), (Length, "1 m 2 m")] {
            assert!(kind.parse(text).is_err(), "{text}");
        }
        for (kind, text) in [(Speed, "1e308 km/s"), (Length, "-1e308 km"), (Pressure, "1e308 kPa"), (Length, "1e400")] {
            assert!(kind.parse(text).is_err(), "{text} is not finite in the unit of a scene");
        }
    }

    #[test]
    fn the_units_of_a_quantity_are_named_with_synonyms_and_without_those_of_others() {
        let names = |kind: QuantityKind| kind.unit_names();
        for (kind, unit) in [(QuantityKind::Length, "um"), (QuantityKind::Mass, "grains"), (QuantityKind::Angle, "deg")]
        {
            assert!(names(kind).contains(&unit), "{kind:?}: {unit}");
        }
        let lengths = names(QuantityKind::Length);
        assert!(!lengths.iter().any(|unit| ["kg", "fps", "deg", "1/6 in"].contains(unit)), "{lengths:?}");
        assert!(QuantityKind::ALL.into_iter().all(|kind| names(kind).len() > 10));
    }

    #[test]
    fn a_scene_with_units_is_that_of_si_numbers() {
        let text = builtin("fbi-bb").unwrap();
        let with_units = text
            .replace("shape.sphere.radius = 2.185e-3", "shape.sphere.radius = \"2.185 mm\"")
            .replace("mass = 0.343e-3", "mass = \"0.343 g\"")
            .replace("velocity = [0.0, 0.0, -179.8]", "velocity = [0.0, 0.0, \"-179.8 m/s\"]")
            .replace("end_time = 8e-3", "end_time = \"8 ms\"");
        assert_ne!(with_units, text);
        assert_eq!(read(&with_units).unwrap(), read(text).unwrap());
    }

    #[test]
    fn a_unit_of_another_quantity_is_refused_with_key_and_line() {
        let text = builtin("fbi-bb").unwrap().replace("mass = 0.343e-3", "mass = \"0.343 mm\"");
        let error = read(&text).unwrap_err();
        let line = text.lines().position(|line| line.starts_with("mass")).map(|at| at + 1);
        assert_eq!((error.key.as_str(), error.line), ("projectile.mass", line));
        assert!(error.to_string().contains("\"0.343 mm\"") && error.to_string().contains("124 gr"), "{error}");
        let never = si_text("[scene]\nstop_after_exit = \"never\"\nname = \"9 mm\"\n").unwrap();
        assert!(never.contains("\"never\"") && never.contains("\"9 mm\""));
    }
}
