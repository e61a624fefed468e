//! Gels that are known by name: what is known of them, and from where.

use serde::{Deserialize, Serialize};

/// A gel that is known by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum Preset {
    /// Ballistic gelatin of 10 % by weight at 4 °C, the FBI's.
    #[serde(rename = "gelatin-10")]
    Gelatin10,
    /// Ballistic gelatin of 20 % by weight at 10 °C.
    #[serde(rename = "gelatin-20")]
    Gelatin20,
    /// Clear synthetic gel (styrene copolymer and mineral oil) sold as 20 %.
    #[serde(rename = "synthetic-clear")]
    SyntheticClear,
}

/// One value of a preset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fact {
    /// The key that it fills, such as `gel.density`.
    pub key: &'static str,
    /// Its value, as TOML, SI units.
    pub value: &'static str,
    /// Materials that it is of.
    pub of: Materials,
    /// Where it is from, or what it was fitted to.
    pub source: &'static str,
}

/// Materials that a value of a preset is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Materials {
    /// All.
    All,
    /// `neo-hookean`, and `viscoelastic` in the long run: slow and shallow contact.
    Slow,
    /// `flowing`: penetration.
    Flowing,
}

impl Materials {
    /// Whether a material of this name is among them.
    #[must_use]
    pub fn includes(self, model: &str) -> bool {
        match self {
            Self::All => true,
            Self::Slow => ["neo-hookean", "viscoelastic"].contains(&model),
            Self::Flowing => model == "flowing",
        }
    }
}

impl Preset {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Gelatin10, Self::Gelatin20, Self::SyntheticClear];

    /// Its name in a scene.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Gelatin10 => "gelatin-10",
            Self::Gelatin20 => "gelatin-20",
            Self::SyntheticClear => "synthetic-clear",
        }
    }

    /// The preset of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.name() == name)
    }

    /// What is known of it, `gel.material` first.
    #[must_use]
    pub fn facts(self) -> &'static [Fact] {
        match self {
            Self::Gelatin10 => &GELATIN_10,
            Self::Gelatin20 => &GELATIN_20,
            Self::SyntheticClear => &SYNTHETIC_CLEAR,
        }
    }
}

const fn all(key: &'static str, value: &'static str, source: &'static str) -> Fact {
    Fact { key, value, of: Materials::All, source }
}

const fn slow(key: &'static str, value: &'static str, source: &'static str) -> Fact {
    Fact { key, value, of: Materials::Slow, source }
}

const fn flowing(key: &'static str, value: &'static str, source: &'static str) -> Fact {
    Fact { key, value, of: Materials::Flowing, source }
}

const MATERIAL: Fact =
    all("gel.material", "\"flowing\"", "of the models of this program the one that lets a projectile in");
const EXPONENT: Fact = flowing(
    "gel.strength.rate_exponent",
    "0.23",
    "proposed, with 10 % gelatin in mind: from 0.1 MPa at rest to the strengths that the FBI's BB and a 4.8 mm sphere of 720 m/s ask for",
);
const TENSION: Fact = flowing(
    "gel.volume.tension_limit",
    "5e6",
    "assumed: above what cavities open at (0.1 to 0.3 MPa proposed), so that it acts in shocks only",
);
const LINEAR: Fact = flowing("gel.viscosity.linear", "0.1", "of the method: damps the ringing behind shocks");
const QUADRATIC: Fact = flowing("gel.viscosity.quadratic", "1.2", "of the method: 1.2 to 1.5 are usual");

const GELATIN_10: [Fact; 13] = [
    MATERIAL,
    all("gel.density", "1030.0", "Wen and others 2013, recalled"),
    slow(
        "gel.shear_modulus",
        "20e3",
        "10 to 35 kPa at 4 °C: Cronin and Falzon 2011 and Jussila, recalled with low confidence",
    ),
    slow(
        "gel.bulk_modulus",
        "2e6",
        "of the method: 100 shear moduli, which changes the dent of a ball by 0.2 % against more",
    ),
    flowing("gel.shear_modulus", "4.8e6", "proposed: three times the cap of the strength"),
    flowing(
        "gel.bulk_modulus",
        "2.38e9",
        "density times the square of 1520 m/s, the speed of sound: Wen and others 2013, recalled",
    ),
    flowing(
        "gel.volume.hugoniot_slope",
        "2.0",
        "shock speed 1520 m/s + 2.0 u: Nagayama 2006, recalled with medium confidence",
    ),
    TENSION,
    flowing(
        "gel.strength.yield_stress",
        "0.138e6",
        "fitted to the FBI's calibration shot, a BB of 179.8 m/s 85 mm deep (scene fbi-bb)",
    ),
    EXPONENT,
    flowing("gel.strength.cap", "1.6e6", "proposed: what the power law reaches at 1.5e5/s"),
    LINEAR,
    QUADRATIC,
];

const GELATIN_20: [Fact; 13] = [
    MATERIAL,
    all("gel.density", "1060.0", "1060 to 1070: Cunniff 2014"),
    slow("gel.shear_modulus", "60e3", "assumed: the upper end of 25 kPa (room temperature) to 60 kPa (10 °C)"),
    slow(
        "gel.bulk_modulus",
        "6e6",
        "of the method: 100 shear moduli, which changes the dent of a ball by 0.2 % against more",
    ),
    flowing("gel.shear_modulus", "9.9e6", "proposed: three times the cap of the strength"),
    flowing(
        "gel.bulk_modulus",
        "2.61e9",
        "density times the square of 1570 m/s: gelatin of 25 %, Shepherd 2009, recalled with medium confidence",
    ),
    flowing(
        "gel.volume.hugoniot_slope",
        "1.77",
        "shock speed 1570 m/s + 1.77 u: gelatin of 25 %, Shepherd 2009, recalled with medium confidence",
    ),
    TENSION,
    flowing(
        "gel.strength.yield_stress",
        "0.285e6",
        "fitted with the cap to a BB of 179.8 m/s 49.7 mm deep (Maiden 2015: 49.7 ± 1.5 mm, 285 Bloom, 10 °C, 180 m/s)",
    ),
    EXPONENT,
    flowing("gel.strength.cap", "3.3e6", "fitted: 11.6 times the yield stress, as in gelatin-10"),
    LINEAR,
    QUADRATIC,
];

const SYNTHETIC_CLEAR: [Fact; 13] = [
    MATERIAL,
    all(
        "gel.density",
        "880.0",
        "styrene copolymer and oil, Bracq and others 2017, recalled with medium confidence; products are sold from 820 on",
    ),
    slow("gel.shear_modulus", "50e3", "assumed: 30 to 100 kPa are in use for this kind of gel"),
    slow(
        "gel.bulk_modulus",
        "5e6",
        "of the method: 100 shear moduli, which changes the dent of a ball by 0.2 % against more",
    ),
    flowing("gel.shear_modulus", "13.65e6", "proposed: three times the cap of the strength"),
    flowing(
        "gel.bulk_modulus",
        "1.82e9",
        "density times the square of 1440 m/s: 1430 to 1450, recalled with low confidence",
    ),
    flowing(
        "gel.volume.hugoniot_slope",
        "1.92",
        "assumed: that of water (Marsh); there is one of Perma-Gel that we could not read",
    ),
    TENSION,
    flowing(
        "gel.strength.yield_stress",
        "0.392e6",
        "fitted with the cap to a BB of 179.8 m/s 38.1 mm deep (predicted for clear gel of 20 % in a study of 2024; its maker's window is 31.75 to 44.45 mm)",
    ),
    EXPONENT,
    flowing("gel.strength.cap", "4.55e6", "fitted: 11.6 times the yield stress, as in gelatin-10"),
    LINEAR,
    QUADRATIC,
];
