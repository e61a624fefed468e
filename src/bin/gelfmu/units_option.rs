//! `--units`: system of units of the figures on the console.

use ballistic_gel::output::UnitSystem;
use clap::{Args, ValueEnum};

/// System of units on the command line.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum UnitsChoice {
    /// Millimetres, metres per second, grams, joules
    #[default]
    Si,
    /// Inches, feet per second, grains, foot-pounds
    Us,
}

/// Option of the commands that print figures.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct UnitsOptions {
    /// Units of the printed figures; files, JSON and the report keep SI
    #[arg(long, value_name = "UNITS", env = "GELFMU_UNITS", hide_env_values = true, value_enum, default_value_t)]
    pub units: UnitsChoice,
}

impl UnitsOptions {
    /// Returns the system of units.
    pub fn system(self) -> UnitSystem {
        match self.units {
            UnitsChoice::Si => UnitSystem::Si,
            UnitsChoice::Us => UnitSystem::Us,
        }
    }
}
