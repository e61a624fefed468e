//! Validation of a two-network gel: elastic network, damage, branches, equation of state and bulk viscosity.

use super::domain::{CheckResult, positive, require, within};
use crate::constitutive::TwoNetwork;
use crate::scene::{BranchSpec, GelSpec, PowerLawSpec, numbered};

/// Least exponent of a power law: with less the rate of a stress overflows.
const LEAST_EXPONENT: f64 = 0.01;

/// Checks a two-network gel; it may be a fluid, without moduli.
pub(super) fn check(gel: &GelSpec) -> CheckResult {
    let is_modulus = gel.shear_modulus >= 0.0 && gel.shear_modulus.is_finite();
    let expected = "the modulus of the elastic network, Pa: above 0, or 0 for none";
    require(is_modulus, "gel.shear_modulus", || format!("{:?}", gel.shear_modulus), expected)?;
    positive("gel.strength_scale", gel.strength_scale, "a positive factor; 1 leaves the moduli as they are")?;
    check_branches(gel)?;
    check_damage(gel)?;
    positive("gel.bulk_modulus", gel.bulk_modulus, "a positive modulus, Pa")?;
    let branches = gel.branches.iter().map(|branch| branch.shear_modulus).sum::<f64>();
    let least = 2.0 / 3.0 * gel.strength_scale * (gel.shear_modulus + branches);
    let expected = format!("more than 2/3 of all shear moduli together, {least:?} Pa");
    require(gel.bulk_modulus > least, "gel.bulk_modulus", || format!("{:?}", gel.bulk_modulus), &expected)?;
    let volume = gel.volume.unwrap_or_default();
    within("gel.volume.hugoniot_slope", volume.hugoniot_slope, 0.0..=10.0)?;
    if let Some(tension) = volume.tension_limit {
        positive("gel.volume.tension_limit", tension, "a positive stress, Pa")?;
    }
    let viscosity = gel.viscosity.unwrap_or_default();
    within("gel.viscosity.linear", viscosity.linear, 0.0..=1.0)?;
    within("gel.viscosity.quadratic", viscosity.quadratic, 0.0..=10.0)
}

/// Checks that a gel of another material has no keys of a two-network gel.
pub(super) fn check_absent(gel: &GelSpec) -> CheckResult {
    let tables = [
        ("damage", gel.damage.is_some()),
        ("branches", !gel.branches.is_empty()),
        ("strength_scale", gel.strength_scale != 1.0),
        ("volume", gel.volume.is_some()),
        ("viscosity", gel.viscosity.is_some()),
    ];
    tables.into_iter().try_for_each(|(table, is_given)| {
        let expected = "nothing: only a gel of material \"two-network\" has it";
        require(!is_given, &format!("gel.{table}"), || "a value".to_owned(), expected)
    })
}

fn check_branches(gel: &GelSpec) -> CheckResult {
    let (n, most) = (gel.branches.len(), TwoNetwork::MOST_BRANCHES);
    let expected = format!("at most {most} tables");
    require(n <= most, "gel.branches", || format!("{n} of them"), &expected)?;
    gel.branches.iter().enumerate().try_for_each(|(i, branch)| check_branch(branch, &numbered("gel.branches", i)))
}

fn check_branch(branch: &BranchSpec, key: &str) -> CheckResult {
    let own = |name: &str| format!("{key}.{name}");
    positive(&own("shear_modulus"), branch.shear_modulus, "a positive modulus, Pa: leave out an idle branch")?;
    let found = match (branch.time, branch.power_law) {
        (Some(time), None) => return positive(&own("time"), time, "a positive relaxation time, s"),
        (None, Some(law)) => return check_power_law(&law, &own("power_law")),
        (Some(_), Some(_)) => "both time and power_law",
        (None, None) => "neither time nor power_law",
    };
    let expected = "one of them: time for a linear dashpot, or power_law = { stress, rate, exponent }";
    require(false, key, || found.to_owned(), expected)
}

fn check_power_law(law: &PowerLawSpec, key: &str) -> CheckResult {
    let PowerLawSpec { stress, rate, exponent } = *law;
    let (most, expected) = if let Some(rate) = rate {
        positive(&format!("{key}.stress"), stress, "a positive stress at which the dashpot saturates, Pa")?;
        positive(&format!("{key}.rate"), rate, "a positive rate at which the dashpot saturates, 1/s")?;
        (10.0, "a number from 0.01 to 10")
    } else {
        positive(&format!("{key}.stress"), stress, "a positive stress at a rate of 1/s, Pa")?;
        (1.0, "a number from 0.01 to 1 (a linear dashpot); up to 10 with a rate at which the dashpot saturates")
    };
    let is_good = (LEAST_EXPONENT..=most).contains(&exponent);
    require(is_good, &format!("{key}.exponent"), || format!("{exponent:?}"), expected)
}

fn check_damage(gel: &GelSpec) -> CheckResult {
    let Some(damage) = gel.damage else { return Ok(()) };
    let stretch = damage.critical_stretch;
    let is_good = stretch > 1.0 && stretch.is_finite();
    require(is_good, "gel.damage.critical_stretch", || format!("{stretch:?}"), "a stretch above 1")?;
    let expected = "a positive time, s: damage without a delay depends on the mesh";
    positive("gel.damage.delay", damage.delay, expected)?;
    let expected = "at least one gel.branches: nothing would be left of a damaged gel";
    require(!gel.branches.is_empty(), "gel.damage", || "damage without a branch".to_owned(), expected)?;
    let expected = "a gel.shear_modulus above 0: damage is that of the elastic network";
    require(gel.shear_modulus > 0.0, "gel.damage", || "damage without an elastic network".to_owned(), expected)
}
