//! Layers in front of the gel of a shot, as given on the command line.

use crate::option_values::parse_length;
use ballistic_gel::scene::{Preset, QuantityKind};
use std::fmt::Write;

/// Layer of a shot.
#[derive(Debug, Clone, PartialEq)]
pub struct ShotLayer {
    /// Thickness, m.
    thickness: f64,
    /// Keys of its table with their values as TOML.
    entries: Vec<(String, String)>,
}

impl ShotLayer {
    /// Parses a thickness and keys of a `[[layer]]` table, such as `2mm,name=skin,strength_scale=3`.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut parts = text.split(',').map(str::trim);
        let thickness = parse_length(parts.next().unwrap_or_default())?;
        let entries: Vec<(String, String)> = parts.map(parse_entry).collect::<Result<_, _>>()?;
        let is_repeated = |i: usize| entries[..i].iter().any(|(key, _)| *key == entries[i].0);
        match (0..entries.len()).find(|i| is_repeated(*i)) {
            Some(i) => Err(format!("found {}= twice, expected each key once", entries[i].0)),
            None => Ok(Self { thickness, entries }),
        }
    }

    /// Table of the layer behind an empty line; `bulk_ratio` is that of the bulk modulus of the gel to that of its preset.
    pub fn table(&self, bulk_ratio: f64) -> String {
        let mut table = format!("\n[[layer]]\nthickness = {:?}\n", self.thickness);
        for (key, value) in &self.entries {
            writeln!(table, "{key} = {value}").expect("a string grows");
        }
        let value = |key: &str| self.entries.iter().find(|(own, _)| own == key).map(|(_, value)| value);
        let preset = value("preset").and_then(|name| Preset::named(name.trim_matches('"')));
        if let Some(own) = preset.and_then(|preset| network_value(preset, "gel.bulk_modulus"))
            && value("bulk_modulus").is_none()
            && bulk_ratio != 1.0
        {
            let reduced = crate::rounding::rounded(bulk_ratio * own);
            let line = format!("# That of its preset is reduced as that of the gel.\nbulk_modulus = {reduced:?}\n");
            table.push_str(&line);
        }
        table
    }
}

/// Value of a key of a preset's `two-network` gel.
pub fn network_value(preset: Preset, key: &str) -> Option<f64> {
    let fact = preset.facts().iter().find(|fact| fact.key == key && fact.of.includes("two-network"))?;
    fact.value.parse().ok()
}

/// Parses a key and its value.
fn parse_entry(text: &str) -> Result<(String, String), String> {
    let expected = "expected a thickness, and after commas name=, preset=, density=, strength_scale= or bulk_modulus=";
    let (key, value) = text.split_once('=').ok_or_else(|| format!("found {text:?}, {expected}"))?;
    let (key, value) = (key.trim(), value.trim());
    let in_unit = |kind: QuantityKind| kind.parse(value).map_err(|expected| format!("{key}: expected {expected}"));
    let value = match key {
        "name" | "preset" => format!("{value:?}"),
        "density" => format!("{:?}", in_unit(QuantityKind::Density)?),
        "bulk_modulus" => format!("{:?}", in_unit(QuantityKind::Pressure)?),
        "strength_scale" => {
            let factor = value.parse::<f64>().ok().filter(|factor| factor.is_finite());
            format!("{:?}", factor.ok_or_else(|| format!("{key}: found {value:?}, expected a number"))?)
        }
        _ => return Err(format!("found the key {key:?}, {expected}")),
    };
    Ok((key.to_owned(), value))
}

#[cfg(test)]
mod tests {
    use super::ShotLayer;

    #[test]
    fn a_layer_is_a_thickness_and_keys_with_units() {
        let skin = ShotLayer::parse("2mm, name=skin,strength_scale=3, density=1.1 g/cm3").unwrap();
        let table = "\n[[layer]]\nthickness = 0.002\nname = \"skin\"\nstrength_scale = 3.0\ndensity = 1100.0\n";
        assert_eq!(skin.table(0.5), table);
        let firm = ShotLayer::parse("2mm,preset=gelatin-20").unwrap();
        assert_eq!(firm.table(1.0), "\n[[layer]]\nthickness = 0.002\npreset = \"gelatin-20\"\n");
        assert!(firm.table(0.5).ends_with("\nbulk_modulus = 1300000000.0\n"), "{}", firm.table(0.5));
        for text in [
            "",
            "skin",
            "0mm",
            "2mm,density=900,density=800",
            "2mm,3",
            "2mm,strength=3",
            "2mm,strength_scale=much",
            "2mm,density=3 mm",
        ] {
            assert!(ShotLayer::parse(text).is_err(), "{text}");
        }
    }
}
