//! Validation of the cavity: a pressure of 0 or more, a discharge coefficient, an entry surface, and a free load marker.

use super::domain::{CheckResult, require, within};
use crate::scene::{CavitySpec, MOST_LOADS, Scene};

/// Greatest pressure in a cavity, Pa: far above that of propellant gases.
const MOST_PRESSURE: f64 = 1e12;

pub(super) fn check(scene: &Scene) -> CheckResult {
    let name = match scene.gel.cavity {
        CavitySpec::Vented => return Ok(()),
        CavitySpec::Sealed { pressure } => {
            check_pressure(pressure)?;
            "sealed"
        }
        CavitySpec::Inflow { discharge } => {
            within("gel.cavity.inflow.discharge", discharge, 0.0..=1.0)?;
            "inflow"
        }
    };
    let has_entry = scene.gel.shape.thickness().is_some();
    let expected = "\"vented\": only a block or a cylinder has an entry surface, from which a cavity starts";
    require(has_entry, "gel.cavity", || format!("\"{name}\""), expected)?;
    let most = format!("at most {} beside a cavity that is not vented (gel.cavity)", MOST_LOADS - 1);
    require(scene.load.len() < MOST_LOADS, "load", || format!("{} loads", scene.load.len()), &most)
}

fn check_pressure(pressure: f64) -> CheckResult {
    let key = "gel.cavity.sealed.pressure";
    let expected = "an absolute pressure of 0 or more, Pa: 0 for a vacuum, 101325 for the air around the gel";
    require(pressure.is_finite() && pressure >= 0.0, key, || format!("{pressure:?}"), expected)?;
    within(key, pressure, 0.0..=MOST_PRESSURE)
}
