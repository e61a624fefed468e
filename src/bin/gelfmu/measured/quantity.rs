//! Quantities of a laboratory's table, by the names and units of its columns.

use ballistic_gel::output::{CurveAbscissa, FOOT, FOOT_POUND, INCH, POUND_FORCE};

/// Unit with the factor to SI.
pub struct MeasuredUnit {
    /// Name at the end of a column's name, in lower case with `_` between its words.
    name: &'static str,
    /// Usual symbol.
    symbol: &'static str,
    factor: f64,
}

const fn unit(name: &'static str, symbol: &'static str, factor: f64) -> MeasuredUnit {
    MeasuredUnit { name, symbol, factor }
}

const TIMES: [MeasuredUnit; 4] =
    [unit("s", "s", 1.0), unit("ms", "ms", 1e-3), unit("us", "µs", 1e-6), unit("ns", "ns", 1e-9)];
const LENGTHS: [MeasuredUnit; 6] = [
    unit("m", "m", 1.0),
    unit("cm", "cm", 1e-2),
    unit("mm", "mm", 1e-3),
    unit("um", "µm", 1e-6),
    unit("in", "in", INCH),
    unit("inch", "in", INCH),
];
const SPEEDS: [MeasuredUnit; 6] = [
    unit("m_per_s", "m/s", 1.0),
    unit("m_s", "m/s", 1.0),
    unit("mps", "m/s", 1.0),
    unit("km_per_s", "km/s", 1e3),
    unit("ft_per_s", "ft/s", FOOT),
    unit("fps", "ft/s", FOOT),
];
const FORCES: [MeasuredUnit; 3] = [unit("n", "N", 1.0), unit("kn", "kN", 1e3), unit("lbf", "lbf", POUND_FORCE)];
const ENERGIES: [MeasuredUnit; 4] =
    [unit("j", "J", 1.0), unit("kj", "kJ", 1e3), unit("mj", "mJ", 1e-3), unit("ft_lb", "ft lb", FOOT_POUND)];
/// Units of the energy in a centimetre.
const ENERGIES_PER_LENGTH: [MeasuredUnit; 7] = [
    unit("j_per_cm", "J/cm", 1.0),
    unit("j_cm", "J/cm", 1.0),
    unit("j_per_mm", "J/mm", 10.0),
    unit("j_per_m", "J/m", 1e-2),
    unit("kj_per_m", "kJ/m", 10.0),
    unit("j", "J in a centimetre", 1.0),
    unit("ft_lb_per_in", "ft lb/in", FOOT_POUND / 2.54),
];
const ANGLES: [MeasuredUnit; 3] =
    [unit("rad", "rad", 1.0), unit("deg", "°", 0.017_453_292_519_943_295), unit("mrad", "mrad", 1e-3)];

/// Quantity that a table can hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeasuredQuantity {
    Time,
    Depth,
    Velocity,
    Force,
    Energy,
    Yaw,
    CavityDiameter,
    TrackDiameter,
    EnergyPerCentimetre,
}

impl MeasuredQuantity {
    pub const ALL: [Self; 9] = [
        Self::Time,
        Self::Depth,
        Self::Velocity,
        Self::Force,
        Self::Energy,
        Self::Yaw,
        Self::CavityDiameter,
        Self::TrackDiameter,
        Self::EnergyPerCentimetre,
    ];

    /// Returns the names of a column, the usual one first.
    pub fn names(self) -> &'static [&'static str] {
        match self {
            Self::Time => &["time", "t"],
            Self::Depth => &["depth", "penetration", "penetration_depth"],
            Self::Velocity => &["velocity", "speed", "v"],
            Self::Force => &["force"],
            Self::Energy => &["energy", "energy_deposited", "deposited_energy"],
            Self::Yaw => &["yaw", "yaw_angle"],
            Self::CavityDiameter => {
                &["cavity_diameter", "cavity", "temporary_cavity", "temporary_cavity_diameter", "diameter"]
            }
            Self::TrackDiameter => {
                &["track_diameter", "permanent_track", "permanent_track_diameter", "permanent_cavity"]
            }
            Self::EnergyPerCentimetre => {
                &["energy_per_cm", "energy_per_centimetre", "energy_in_centimetre", "energy", "deposited_energy"]
            }
        }
    }

    /// Returns the symbols of the units that a column may have.
    pub fn unit_symbols(self) -> String {
        let mut symbols: Vec<&str> = self.units().iter().map(|unit| unit.symbol).collect();
        symbols.dedup();
        symbols.join(", ")
    }

    fn units(self) -> &'static [MeasuredUnit] {
        match self {
            Self::Time => &TIMES,
            Self::Depth | Self::CavityDiameter | Self::TrackDiameter => &LENGTHS,
            Self::Velocity => &SPEEDS,
            Self::Force => &FORCES,
            Self::Energy => &ENERGIES,
            Self::EnergyPerCentimetre => &ENERGIES_PER_LENGTH,
            Self::Yaw => &ANGLES,
        }
    }

    /// Returns the SI unit.
    pub fn si_unit(self) -> &'static str {
        match self {
            Self::Time => "s",
            Self::Depth | Self::CavityDiameter | Self::TrackDiameter => "m",
            Self::Velocity => "m/s",
            Self::Force => "N",
            Self::Energy | Self::EnergyPerCentimetre => "J",
            Self::Yaw => "rad",
        }
    }

    /// Returns the key in `summary.json`.
    pub fn key(self) -> &'static str {
        self.names()[0]
    }

    /// Returns the title of the comparison.
    pub fn title(self, by: CurveAbscissa) -> &'static str {
        let is_by_time = by == CurveAbscissa::Time;
        match (self, is_by_time) {
            (Self::Time, _) => "Time",
            (Self::Depth, _) => "Depth of the projectile by time",
            (Self::Velocity, true) => "Speed of the projectile by time",
            (Self::Velocity, false) => "Speed of the projectile by depth",
            (Self::Force, true) => "Force on the projectile by time",
            (Self::Force, false) => "Force on the projectile by depth",
            (Self::Energy, true) => "Energy given to the gel by time",
            (Self::Energy, false) => "Energy given to the gel down to each depth",
            (Self::Yaw, true) => "Yaw of the projectile by time",
            (Self::Yaw, false) => "Yaw of the projectile by depth",
            (Self::CavityDiameter, true) => "Diameter of the cavity by time",
            (Self::CavityDiameter, false) => "Diameter of the temporary cavity at its widest by depth",
            (Self::TrackDiameter, _) => "Diameter of the permanent track by depth",
            (Self::EnergyPerCentimetre, _) => "Energy in each centimetre by depth",
        }
    }
}

/// Column of a table: quantity, and factor to SI.
#[derive(Debug, Clone, PartialEq)]
pub struct MatchedColumn {
    pub quantity: MeasuredQuantity,
    pub factor: f64,
    /// Unit as understood; `None` if the name has none and SI is assumed.
    pub unit: Option<&'static str>,
}

/// Returns the quantity and the unit of a column's name, such as `depth_mm`, `Velocity (m/s)` or `time`; `None` for an
/// unknown name.
pub fn match_column(name: &str) -> Option<MatchedColumn> {
    let plain = plain_name(name);
    MeasuredQuantity::ALL.into_iter().find_map(|quantity| {
        quantity.names().iter().find_map(|known| {
            let rest = plain.strip_prefix(known)?;
            if rest.is_empty() {
                return Some(MatchedColumn { quantity, factor: 1.0, unit: None });
            }
            let suffix = rest.strip_prefix('_')?;
            let unit = quantity.units().iter().find(|unit| unit.name == suffix)?;
            Some(MatchedColumn { quantity, factor: unit.factor, unit: Some(unit.symbol) })
        })
    })
}

/// Returns a name in lower case with `_` between its words: `Velocity (m/s)` gives `velocity_m_per_s`.
fn plain_name(name: &str) -> String {
    let text = name.trim().to_lowercase().replace(['µ', 'μ'], "u").replace('°', "deg").replace('/', "_per_");
    let words = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_matched_by_name_and_unit() {
        let found = |name: &str| match_column(name).map(|column| (column.quantity, column.factor));
        assert_eq!(found("time"), Some((MeasuredQuantity::Time, 1.0)));
        assert_eq!(found("Depth (mm)"), Some((MeasuredQuantity::Depth, 1e-3)));
        assert_eq!(found("velocity [m/s]"), Some((MeasuredQuantity::Velocity, 1.0)));
        assert_eq!(found("t_µs"), Some((MeasuredQuantity::Time, 1e-6)));
        assert_eq!(found("temporary cavity diameter, cm"), Some((MeasuredQuantity::CavityDiameter, 1e-2)));
        let per_length = ["energy_per_cm_J", "energy_J_per_cm", "Energy [J/cm]", "energy_per_cm (J/cm)"];
        assert!(per_length.iter().all(|name| found(name) == Some((MeasuredQuantity::EnergyPerCentimetre, 1.0))));
        assert_eq!(found("energy (kJ/m)"), Some((MeasuredQuantity::EnergyPerCentimetre, 10.0)));
        assert_eq!(found("energy_J"), Some((MeasuredQuantity::Energy, 1.0)));
        assert!((found("energy (ft-lb)").unwrap().1 - 1.355_818).abs() < 1e-6);
        assert_eq!(found("yaw °").unwrap().0, MeasuredQuantity::Yaw);
        assert_eq!([found("temperature"), found("depth_furlong"), found("")], [None, None, None]);
    }
}
