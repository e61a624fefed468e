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
    /// Source of the value, or the data it was fitted to, measured or derived: the tags are those of
    /// `docs/materials.md`.
    pub source: &'static str,
}

/// Data that the `two-network` values of a preset were fitted to and validated on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShotData {
    /// Data that the values were fitted to: the tags are those of `docs/materials.md`.
    pub fitted: &'static str,
    /// Shots that nothing was fitted to, measured or derived, with their result.
    pub validated: &'static str,
    /// Classes of shots whose model error is known.
    pub classes: &'static [ShotClass],
}

/// Class of shots with the model error of a preset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShotClass {
    /// Projectiles, in the plural, and if it is not the depth their figure.
    pub projectiles: &'static str,
    /// True for spheres; else other bodies.
    pub is_of_balls: bool,
    /// Least and greatest ratio of length to width.
    pub aspect: [f64; 2],
    /// Least and greatest width, m.
    pub calibre: [f64; 2],
    /// Least and greatest speed, m/s.
    pub speed: [f64; 2],
    /// Model error: root mean square of the relative deviations of the computed figures.
    pub error: f64,
    /// Basis of the error: number of shots, measured or derived, fitted or not.
    pub basis: &'static str,
}

/// Material models that use a value of a preset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ApplicableModels {
    /// All models.
    All,
    /// `neo-hookean`: slow and shallow contact.
    NeoHookean,
    /// `two-network`: penetration.
    TwoNetwork,
}

impl ApplicableModels {
    /// Returns true if the material model of this name uses the value.
    #[must_use]
    pub fn includes(self, model: &str) -> bool {
        match self {
            Self::All => true,
            Self::NeoHookean => model == "neo-hookean",
            Self::TwoNetwork => model == "two-network",
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

    /// Data that the `two-network` values were fitted to and validated on.
    #[must_use]
    pub fn shots(self) -> ShotData {
        match self {
            Self::Gelatin10 => ShotData {
                fitted: "85 mm of a steel BB of 179.8 m/s (measured, 85 ± 10 mm, grade B [R1]), depths of seven recovered pistol bullets (measured, grade B, 5 % less for their opening, assumed), and a derived window [D], the cavity of 4.8 mm at 720 m/s",
                validated: "derived depths of balls [D]: of 4.4 to 5.5 mm at 150 to 1150 m/s 9 % (root mean square), at 75 to 125 m/s 30 %, too early; on measured shots of grades B and C: balls of lead of 7.6 to 8.4 mm 14 %, too deep, pistol bullets 15 %, too early, and necks of rifle bullets 28 %",
                classes: &GELATIN_10_SHOTS,
            },
            Self::Gelatin20 => ShotData {
                fitted: "a BB of 180 m/s at 10 °C (measured [R2])",
                validated: NOTHING,
                classes: &[ShotClass {
                    speed: [180.0; 2],
                    error: 0.03,
                    basis: "uncertainty of one measured depth, fitted",
                    ..FITTED_BB
                }],
            },
            Self::SyntheticClear => ShotData {
                fitted: "a predicted depth of a BB of 179.8 m/s [R4]",
                validated: NOTHING,
                classes: &[ShotClass {
                    speed: [179.8; 2],
                    error: 0.17,
                    basis: "maker's window of one predicted depth, fitted",
                    ..FITTED_BB
                }],
            },
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

    /// Value of a key of a `two-network` gel, such as `gel.density`, as TOML; `None` for a key that the preset leaves out.
    #[must_use]
    pub(super) fn network_value(self, key: &str) -> Option<&'static str> {
        let facts = self.facts().iter().filter(|fact| fact.of.includes("two-network"));
        facts.into_iter().find(|fact| fact.key == key).map(|fact| fact.value)
    }
}

pub(super) const NOTHING: &str = "nothing";

const fn fact(key: &'static str, value: &'static str, of: ApplicableModels, source: &'static str) -> PresetValue {
    PresetValue { key, value, of, source }
}

/// Calibration shot of a gel whose factor of strength is fitted to it.
const FITTED_BB: ShotClass = ShotClass {
    projectiles: "steel balls",
    is_of_balls: true,
    aspect: [1.0; 2],
    calibre: [4.37e-3; 2],
    speed: [180.0; 2],
    error: 0.0,
    basis: "",
};
const GELATIN_10_SHOTS: [ShotClass; 6] = [
    ShotClass {
        calibre: [4.37e-3, 5.5e-3],
        speed: [75.0, 125.0],
        error: 0.3,
        basis: "4 shots, derived by penetration laws",
        ..FITTED_BB
    },
    ShotClass {
        calibre: [4.37e-3, 5.5e-3],
        speed: [150.0, 1150.0],
        error: 0.09,
        basis: "7 shots, derived by penetration laws",
        ..FITTED_BB
    },
    ShotClass {
        projectiles: "recovered pistol bullets",
        is_of_balls: false,
        aspect: [0.5, 0.7],
        calibre: [13.7e-3, 21.6e-3],
        speed: [259.1, 310.9],
        error: 0.11,
        basis: "8 shots, measured, 7 of them fitted",
    },
    ShotClass {
        projectiles: "balls of lead",
        calibre: [7.62e-3, 8.38e-3],
        speed: [250.0, 366.0],
        error: 0.14,
        basis: "3 shots, measured, grade C",
        ..FITTED_BB
    },
    ShotClass {
        projectiles: "pistol bullets that stay whole",
        is_of_balls: false,
        aspect: [1.5, 2.06],
        calibre: [5.7e-3, 11.48e-3],
        speed: [264.9, 350.0],
        error: 0.15,
        basis: "3 shots, measured, two of grade C, 2° of yaw assumed",
    },
    ShotClass {
        projectiles: "rifle bullets, their necks,",
        is_of_balls: false,
        aspect: [3.3, 4.5],
        calibre: [5.61e-3, 7.91e-3],
        speed: [715.0, 990.0],
        error: 0.28,
        basis: "4 necks, measured, 2° of yaw assumed",
    },
];

const MATERIAL: PresetValue = fact(
    "gel.material",
    "\"two-network\"",
    ApplicableModels::All,
    "the material model that a projectile can penetrate: it is damaged, flows and springs back",
);
const SOFT: &str = "of the method: 100 shear moduli; more changes the dent of a ball by 0.2 % [D]";
const SCALED: &str = "that of gelatin-10, which gel.strength_scale multiplies";
const BRANCHES: &str = "[{ shear_modulus = 10e6, power_law = { stress = 1.10e6, rate = 800.0, exponent = 3.0 } }, \
                        { shear_modulus = 12e3, time = 0.3e-3 }]";
const SCALED_ELASTIC: PresetValue = fact("gel.shear_modulus", "20e3", ApplicableModels::TwoNetwork, SCALED);
const SCALED_BRANCH: PresetValue = fact("gel.branches", BRANCHES, ApplicableModels::TwoNetwork, SCALED);
const STRETCH: PresetValue = fact(
    "gel.damage.critical_stretch",
    "3.0",
    ApplicableModels::TwoNetwork,
    "assumed: gelatin fails at 1.5 to 2.5 when slow [M-L], at more when fast; no data read",
);
const DELAY: PresetValue = fact(
    "gel.damage.delay",
    "10e-6",
    ApplicableModels::TwoNetwork,
    "assumed, no data read: about the time in which a BB passes its radius",
);
const TENSION: PresetValue = fact(
    "gel.volume.tension_limit",
    "5e6",
    ApplicableModels::TwoNetwork,
    "assumed, not measured: it acts in shocks only; cavities in gels open at less, 0.1 to 0.3 MPa [D] proposed",
);
const LINEAR: PresetValue =
    fact("gel.viscosity.linear", "0.05", ApplicableModels::TwoNetwork, "of the method: damps ringing; 0.06 is usual");
const QUADRATIC: PresetValue =
    fact("gel.viscosity.quadratic", "1.2", ApplicableModels::TwoNetwork, "of the method: 1.2 to 1.5 are usual");

const GELATIN_10: [PresetValue; 12] = [
    MATERIAL,
    fact("gel.density", "1030.0", ApplicableModels::All, "[M-H: Wen 2013]"),
    fact(
        "gel.shear_modulus",
        "20e3",
        ApplicableModels::All,
        "10 to 35 kPa at 4 °C [M-L: Cronin and Falzon 2011; Jussila]; chosen in this range, as the elastic network, by \
         38 to 66 mm of temporary cavity of a steel sphere of 720 m/s in sphere-720 (derived [D]; measured: some 11 \
         diameters, grade B [R12], at an unknown speed)",
    ),
    fact("gel.bulk_modulus", "2e6", ApplicableModels::NeoHookean, SOFT),
    STRETCH,
    DELAY,
    fact(
        "gel.branches",
        BRANCHES,
        ApplicableModels::TwoNetwork,
        "stress: fitted to 85 mm of rest depth of a BB of 179.8 m/s (measured, 85 ± 10 mm, grade B [R1]) in the limit of fine \
         cells; rate: chosen by the depths of seven recovered bullets (measured, grade B) and the cavity of 720 m/s; \
         exponent and modulus: assumed, no data decide them; second branch: chosen for a loss angle near 0.1 at 100 to \
         1000 Hz, where 0.05 to 0.15 is published [M-L]",
    ),
    fact(
        "gel.bulk_modulus",
        "2.38e9",
        ApplicableModels::TwoNetwork,
        "C1 of the pressure [M-H: Wen 2013], a sound speed of 1520 m/s",
    ),
    fact(
        "gel.volume.hugoniot_slope",
        "2.0",
        ApplicableModels::TwoNetwork,
        "shocks of 1520 m/s + 2.0 u [M-M: Nagayama 2006]",
    ),
    TENSION,
    LINEAR,
    QUADRATIC,
];

const GELATIN_20: [PresetValue; 14] = [
    MATERIAL,
    fact("gel.density", "1060.0", ApplicableModels::All, "1060, or 1070 [R11]"),
    fact(
        "gel.shear_modulus",
        "39e3",
        ApplicableModels::NeoHookean,
        "that of two-network, scaled; 25 to 60 kPa at 10 °C, 26 kPa at room temperature [R10→D]",
    ),
    fact("gel.bulk_modulus", "3.9e6", ApplicableModels::NeoHookean, SOFT),
    SCALED_ELASTIC,
    STRETCH,
    DELAY,
    SCALED_BRANCH,
    fact(
        "gel.strength_scale",
        "1.95",
        ApplicableModels::TwoNetwork,
        "fitted to 49.7 mm of a BB of 180 m/s at 10 °C (measured, 49.7 ± 1.5 mm [R2]), in the scene fbi-bb, limit of fine cells",
    ),
    fact(
        "gel.bulk_modulus",
        "2.61e9",
        ApplicableModels::TwoNetwork,
        "a sound speed of 1570 m/s: gelatin of 25 % [M-M: Shepherd 2009]",
    ),
    fact(
        "gel.volume.hugoniot_slope",
        "1.77",
        ApplicableModels::TwoNetwork,
        "shocks of 1570 m/s + 1.77 u: gelatin of 25 % [M-M: Shepherd 2009]",
    ),
    TENSION,
    LINEAR,
    QUADRATIC,
];

const SYNTHETIC_CLEAR: [PresetValue; 14] = [
    MATERIAL,
    fact("gel.density", "880.0", ApplicableModels::All, "[M-M: Bracq 2017]; 820 to 890 are sold"),
    fact(
        "gel.shear_modulus",
        "52e3",
        ApplicableModels::NeoHookean,
        "that of two-network, scaled; 30 to 100 kPa are in use for such gels",
    ),
    fact("gel.bulk_modulus", "5.2e6", ApplicableModels::NeoHookean, SOFT),
    SCALED_ELASTIC,
    STRETCH,
    DELAY,
    SCALED_BRANCH,
    fact(
        "gel.strength_scale",
        "2.6",
        ApplicableModels::TwoNetwork,
        "fitted to 38.1 mm of a BB of 179.8 m/s (predicted, not measured; maker's window 31.75 to 44.45 mm [R4]), in the scene fbi-bb, limit of fine cells",
    ),
    fact("gel.bulk_modulus", "1.82e9", ApplicableModels::TwoNetwork, "a sound speed of 1440 m/s, 1430 to 1450 [M-L]"),
    fact(
        "gel.volume.hugoniot_slope",
        "1.92",
        ApplicableModels::TwoNetwork,
        "assumed: that of water [M-H: Marsh]; that of Perma-Gel [R16] could not be read",
    ),
    TENSION,
    LINEAR,
    QUADRATIC,
];
