//! Named gels: material parameters with their sources.

use serde::{Deserialize, Serialize};

/// Named gel.
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

/// Value of one key of a preset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PresetValue {
    /// Dotted key, such as `gel.density`.
    pub key: &'static str,
    /// Value as TOML, SI units.
    pub value: &'static str,
    /// Material models that use the value.
    pub of: ApplicableModels,
    /// Source of the value, or the data it was fitted to: the tags are those of `docs/materials.md`.
    pub source: &'static str,
}

/// Range of shots that the `flowing` values of a preset were fitted to or checked with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShotRange {
    /// Least and greatest speed, m/s.
    pub speed: [f64; 2],
    /// Least and greatest width of the projectile, m.
    pub calibre: [f64; 2],
    /// Source of the shots: the tags are those of `docs/materials.md`.
    pub source: &'static str,
}

/// Material models that use a value of a preset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ApplicableModels {
    /// All models.
    All,
    /// `neo-hookean`, and `viscoelastic` in the long run: slow and shallow contact.
    Slow,
    /// `neo-hookean`.
    NeoHookean,
    /// `viscoelastic`.
    Viscoelastic,
    /// `flowing`: penetration.
    Flowing,
}

impl ApplicableModels {
    /// Returns true if the material model of this name uses the value.
    #[must_use]
    pub fn includes(self, model: &str) -> bool {
        match self {
            Self::All => true,
            Self::Slow => Self::NeoHookean.includes(model) || Self::Viscoelastic.includes(model),
            Self::NeoHookean => model == "neo-hookean",
            Self::Viscoelastic => model == "viscoelastic",
            Self::Flowing => model == "flowing",
        }
    }
}

impl Preset {
    /// All presets.
    pub const ALL: [Self; 3] = [Self::Gelatin10, Self::Gelatin20, Self::SyntheticClear];

    /// Name of the preset in a scene file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Gelatin10 => "gelatin-10",
            Self::Gelatin20 => "gelatin-20",
            Self::SyntheticClear => "synthetic-clear",
        }
    }

    /// Preset of a name, if there is one.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.name() == name)
    }

    /// Range of shots that the `flowing` values were fitted to or checked with.
    #[must_use]
    pub fn shots(self) -> ShotRange {
        let calibre = [4.37e-3; 2];
        match self {
            Self::Gelatin10 => ShotRange {
                speed: [165.0, 720.0],
                calibre: [4.37e-3, 4.8e-3],
                source: "a steel BB at 165 to 195 m/s [R1, D], and a steel sphere of 4.8 mm at 720 m/s, see sphere-720",
            },
            Self::Gelatin20 => ShotRange { speed: [180.0; 2], calibre, source: "a BB of 180 m/s at 10 °C [R2]" },
            Self::SyntheticClear => {
                ShotRange { speed: [179.8; 2], calibre, source: "a predicted depth of a BB of 179.8 m/s [R4]" }
            }
        }
    }

    /// Values of the preset, `gel.material` first.
    #[must_use]
    pub fn facts(self) -> &'static [PresetValue] {
        match self {
            Self::Gelatin10 => &GELATIN_10,
            Self::Gelatin20 => &GELATIN_20,
            Self::SyntheticClear => &SYNTHETIC_CLEAR,
        }
    }
}

const fn fact(key: &'static str, value: &'static str, of: ApplicableModels, source: &'static str) -> PresetValue {
    PresetValue { key, value, of, source }
}

const MATERIAL: PresetValue = fact(
    "gel.material",
    "\"flowing\"",
    ApplicableModels::All,
    "the only material model here that a projectile can penetrate",
);
const SHEAR: &str = "fitted with the yield stress: 461.5 of it, as in gelatin-10";
const SOFT: &str = "of the method: 100 shear moduli; more changes the dent of a ball by 0.2 % [D]";
const CAP: &str = "fitted with the yield stress: 15.38 of it, as in gelatin-10";
const PRESSURE: &str = "fitted with the yield stress: 28.85 of it, as in gelatin-10";
const EXPONENT: PresetValue = fact(
    "gel.strength.rate_exponent",
    "0.23",
    ApplicableModels::Flowing,
    "[D] proposed: 0.1 MPa at 1/s, 1.15 MPa at 40 000/s around a BB",
);
const FACTOR: PresetValue = fact(
    "gel.strength.confined.factor",
    "15.0",
    ApplicableModels::Flowing,
    "fitted, in gelatin-10, to a temporary cavity of the BB of 14 to 15 mm [D] at its depth",
);
const TIME: PresetValue = fact(
    "gel.strength.confined.time",
    "3e-6",
    ApplicableModels::Flowing,
    "assumed: a quarter of the time in which the BB passes its radius; less makes the depth depend on the speed of sound",
);
const TENSION: PresetValue = fact(
    "gel.volume.tension_limit",
    "5e6",
    ApplicableModels::Flowing,
    "assumed, not measured: it acts in shocks only; cavities in gels open at less, 0.1 to 0.3 MPa [D] proposed",
);
const LINEAR: PresetValue =
    fact("gel.viscosity.linear", "0.05", ApplicableModels::Flowing, "of the method: damps ringing; 0.06 is usual");
const QUADRATIC: PresetValue =
    fact("gel.viscosity.quadratic", "1.2", ApplicableModels::Flowing, "of the method: 1.2 to 1.5 are usual");

const GELATIN_10: [PresetValue; 18] = [
    MATERIAL,
    fact("gel.density", "1030.0", ApplicableModels::All, "[M-H: Wen 2013]"),
    fact(
        "gel.shear_modulus",
        "20e3",
        ApplicableModels::Slow,
        "10 to 35 kPa at 4 °C [M-L: Cronin and Falzon 2011; Jussila]",
    ),
    fact("gel.bulk_modulus", "2e6", ApplicableModels::NeoHookean, SOFT),
    fact(
        "gel.bulk_modulus",
        "33e6",
        ApplicableModels::Viscoelastic,
        "of the method: 100 times all shear moduli together",
    ),
    fact(
        "gel.branches",
        "[{ shear_modulus = 30e3, time = 1e-3 }, { shear_modulus = 80e3, time = 1e-4 }, \
             { shear_modulus = 200e3, time = 1e-5 }]",
        ApplicableModels::Viscoelastic,
        "[D] proposed, not measured",
    ),
    fact(
        "gel.shear_modulus",
        "4.8e6",
        ApplicableModels::Flowing,
        "[D] proposed: three times 1.6 MPa, a strength at high rates",
    ),
    fact(
        "gel.bulk_modulus",
        "2.38e9",
        ApplicableModels::Flowing,
        "C1 of the pressure [M-H: Wen 2013], a sound speed of 1520 m/s",
    ),
    fact(
        "gel.volume.hugoniot_slope",
        "2.0",
        ApplicableModels::Flowing,
        "shocks of 1520 m/s + 2.0 u [M-M: Nagayama 2006]",
    ),
    TENSION,
    fact(
        "gel.strength.yield_stress",
        "10.4e3",
        ApplicableModels::Flowing,
        "fitted to 85 mm of a BB of 179.8 m/s [R1], in the scene fbi-bb",
    ),
    EXPONENT,
    fact(
        "gel.strength.cap",
        "0.16e6",
        ApplicableModels::Flowing,
        "[D] proposed: 15 times the strength at 1/s; under pressure 2.4 MPa",
    ),
    fact(
        "gel.strength.confined.pressure",
        "0.3e6",
        ApplicableModels::Flowing,
        "fitted to how the depth of the BB grows from 165 to 195 m/s, 0.48 to 0.56 mm per m/s [D]; from 0.1 to 1 MPa it changes little",
    ),
    FACTOR,
    TIME,
    LINEAR,
    QUADRATIC,
];

const GELATIN_20: [PresetValue; 16] = [
    MATERIAL,
    fact("gel.density", "1060.0", ApplicableModels::All, "1060, or 1070 [R11]"),
    fact(
        "gel.shear_modulus",
        "60e3",
        ApplicableModels::Slow,
        "assumed: the end at 10 °C of 25 to 60 kPa; 26 kPa at room temperature [R10→D]",
    ),
    fact("gel.bulk_modulus", "6e6", ApplicableModels::Slow, SOFT),
    fact("gel.shear_modulus", "9.984e6", ApplicableModels::Flowing, SHEAR),
    fact(
        "gel.bulk_modulus",
        "2.61e9",
        ApplicableModels::Flowing,
        "a sound speed of 1570 m/s: gelatin of 25 % [M-M: Shepherd 2009]",
    ),
    fact(
        "gel.volume.hugoniot_slope",
        "1.77",
        ApplicableModels::Flowing,
        "shocks of 1570 m/s + 1.77 u: gelatin of 25 % [M-M: Shepherd 2009]",
    ),
    TENSION,
    fact(
        "gel.strength.yield_stress",
        "21.632e3",
        ApplicableModels::Flowing,
        "fitted to 49.7 mm of a BB of 180 m/s at 10 °C (49.7 ± 1.5 mm [R2]), in the scene fbi-bb",
    ),
    EXPONENT,
    fact("gel.strength.cap", "0.3328e6", ApplicableModels::Flowing, CAP),
    fact("gel.strength.confined.pressure", "0.624e6", ApplicableModels::Flowing, PRESSURE),
    FACTOR,
    TIME,
    LINEAR,
    QUADRATIC,
];

const SYNTHETIC_CLEAR: [PresetValue; 16] = [
    MATERIAL,
    fact("gel.density", "880.0", ApplicableModels::All, "[M-M: Bracq 2017]; 820 to 890 are sold"),
    fact("gel.shear_modulus", "50e3", ApplicableModels::Slow, "assumed: 30 to 100 kPa are in use for such gels"),
    fact("gel.bulk_modulus", "5e6", ApplicableModels::Slow, SOFT),
    fact("gel.shear_modulus", "14.02e6", ApplicableModels::Flowing, SHEAR),
    fact("gel.bulk_modulus", "1.82e9", ApplicableModels::Flowing, "a sound speed of 1440 m/s, 1430 to 1450 [M-L]"),
    fact(
        "gel.volume.hugoniot_slope",
        "1.92",
        ApplicableModels::Flowing,
        "assumed: that of water [M-H: Marsh]; that of Perma-Gel [R16] could not be read",
    ),
    TENSION,
    fact(
        "gel.strength.yield_stress",
        "30.368e3",
        ApplicableModels::Flowing,
        "fitted to 38.1 mm of a BB of 179.8 m/s (predicted, maker's window 31.75 to 44.45 mm [R4]), in the scene fbi-bb",
    ),
    EXPONENT,
    fact("gel.strength.cap", "0.4672e6", ApplicableModels::Flowing, CAP),
    fact("gel.strength.confined.pressure", "0.876e6", ApplicableModels::Flowing, PRESSURE),
    FACTOR,
    TIME,
    LINEAR,
    QUADRATIC,
];
