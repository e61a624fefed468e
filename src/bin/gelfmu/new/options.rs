//! Options of `gelfmu new`.

use super::block::BlockSize;
use super::layer::ShotLayer;
use crate::help_headings::{GEL, SHOT};
use crate::option_values::{PROJECTILE_NAME, parse_speed};
use crate::units_option::UnitsOptions;
use ballistic_gel::scene::{Preset, QuantityKind};
use clap::Args;
use std::path::PathBuf;

/// Options of `gelfmu new`.
#[derive(Debug, Args)]
pub struct NewOptions {
    /// Projectile of the library, e.g. 9mm-fmj; `gelfmu projectiles` lists them
    #[arg(
        long,
        value_name = "NAME",
        required_unless_present = "from_exit",
        value_parser = PROJECTILE_NAME,
        hide_possible_values = true,
        help_heading = SHOT
    )]
    pub projectile: Option<String>,
    /// Folder of a finished run whose projectile has left the gel: projectile, speed and attitude are those after that exit
    #[arg(long, value_name = "DIR", help_heading = SHOT)]
    pub from_exit: Option<PathBuf>,
    /// Air between the gel of --from-exit and the block, m or with a unit, e.g. 3m; no drag and no gravity there
    #[arg(
        long,
        value_name = "LENGTH",
        default_value = "0",
        requires = "from_exit",
        value_parser = parse_gap,
        allow_hyphen_values = true,
        help_heading = SHOT
    )]
    pub gap: f64,
    /// Speed at the gel, m/s or with a unit, e.g. "1150 ft/s" (the usual speed of the projectile if absent)
    #[arg(
        long,
        value_name = "SPEED",
        value_parser = parse_speed,
        allow_hyphen_values = true,
        help_heading = SHOT
    )]
    pub speed: Option<f64>,
    /// Angle between the axis of the projectile and its path, degrees (2 for service bullets, else 0, if absent)
    #[arg(
        long,
        value_name = "ANGLE",
        value_parser = parse_angle,
        allow_hyphen_values = true,
        help_heading = SHOT
    )]
    pub yaw: Option<f64>,
    /// Angle of the plane of the yaw about the path, degrees (0 if absent); other than a multiple of 90 the whole block is meshed
    #[arg(
        long,
        value_name = "ANGLE",
        value_parser = parse_angle,
        allow_hyphen_values = true,
        help_heading = SHOT
    )]
    pub roll: Option<f64>,
    /// Block: width, height and length along the path, e.g. 15x15x40cm; m without a unit
    #[arg(
        long,
        value_name = "AxBxC",
        default_value = "15x15x40cm",
        value_parser = BlockSize::parse,
        help_heading = GEL
    )]
    pub block: BlockSize,
    /// Gel: 10%, 20%, clear, or the name of a preset
    #[arg(long, value_name = "GEL", default_value = "10%", value_parser = parse_gel, help_heading = GEL)]
    pub gel: Preset,
    /// Layer on the front of the gel, bonded, part of the length of the block: thickness and keys of `[[layer]]`, e.g.
    /// 2mm,name=skin,strength_scale=3,density=1100 or 5mm,preset=gelatin-20; repeat it for those below
    #[arg(long, value_name = "THICKNESS,KEY=VALUE,...", value_parser = ShotLayer::parse, help_heading = GEL)]
    pub layer: Vec<ShotLayer>,
    /// File to write, which must not exist (without this option the scene is printed)
    #[arg(long, value_name = "FILE.toml")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub units: UnitsOptions,
}

/// Parses a length that may be zero, with or without a unit.
fn parse_gap(text: &str) -> Result<f64, String> {
    let expected = || "expected a length, m, or with a unit, such as 3m or \"50 cm\"".to_owned();
    QuantityKind::Length.parse(text).ok().filter(|gap| *gap >= 0.0).ok_or_else(expected)
}

/// Parses an angle in degrees, or with a unit.
fn parse_angle(text: &str) -> Result<f64, String> {
    let parsed = QuantityKind::Angle.parse(text).map_err(|expected| format!("expected {expected}"))?;
    if parsed.abs() <= 180.0 { Ok(parsed) } else { Err("expected an angle from -180 to 180 degrees".to_owned()) }
}

fn parse_gel(text: &str) -> Result<Preset, String> {
    match text {
        "10%" | "10 %" => Ok(Preset::Gelatin10),
        "20%" | "20 %" => Ok(Preset::Gelatin20),
        "clear" => Ok(Preset::SyntheticClear),
        name => Preset::named(name).ok_or_else(|| {
            let names = Preset::ALL.map(Preset::name);
            format!("expected 10%, 20%, clear, or a preset: {}", names.join(", "))
        }),
    }
}
