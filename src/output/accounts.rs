//! Energy accounts of a summary, each with its meaning.

use crate::simulation::EnergyReport;
use serde::Deserialize;
use serde::de::Deserializer;
use std::collections::BTreeMap;

/// Named account of the energy balance.
#[derive(Debug, Clone, PartialEq)]
pub struct SummaryAccount {
    /// Name in `summary.json`.
    pub name: &'static str,
    /// Value, J.
    pub value: f64,
    /// Meaning in words.
    pub meaning: &'static str,
}

/// Writes the energy accounts as an object.
pub(super) fn as_object<S: serde::Serializer>(accounts: &[SummaryAccount], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(accounts.iter().map(|account| (account.name, account.value)))
}

/// Name, value in a report, and meaning of an energy account.
type AccountEntry = (&'static str, fn(&EnergyReport) -> f64, &'static str);

/// Energy accounts in the order of the report.
const ACCOUNTS: [AccountEntry; 22] = [
    ("initial", |energy| energy.initial, "total energy at the start"),
    ("kinetic", |energy| energy.kinetic, "kinetic energy of gel and bodies"),
    ("projectile", |energy| energy.projectile, "kinetic energy of projectile and fragments (part of kinetic)"),
    ("elastic", |energy| energy.elastic, "stored energy of the deformed gel"),
    ("contact", |energy| energy.contact, "work of the contact law; negative is dissipated"),
    (
        "self_contact",
        |energy| energy.self_contact,
        "work of the contact of the gel with itself; negative is dissipated",
    ),
    ("friction", |energy| energy.friction, "work of friction; negative is dissipated"),
    ("contact_bias", |energy| energy.contact_bias, "work of removing standing penetration"),
    ("integration", |energy| energy.integration, "trapezoidal residual of the time integration"),
    ("external", |energy| energy.external, "work of external forces and of a prescribed motion"),
    ("importer", |energy| energy.importer, "energy of state jumps of the bodies made by the importer"),
    ("expansion", |energy| energy.expansion, "work of the surface of an expanding body against the gel"),
    ("remesh", |energy| energy.remesh, "change of kinetic and stored energy by new meshes"),
    (
        "remesh_returned",
        |energy| energy.remesh_returned,
        "change by the correction that returns it to the motion of the new elements, of the other sign",
    ),
    ("load", |energy| energy.load, "work of the pressures on faces"),
    ("air", |energy| energy.air, "work of the air in the cavity"),
    ("damping", |energy| energy.damping, "work of the damping; negative is dissipated"),
    ("bulk_viscous", |energy| energy.bulk_viscous, "dissipated by bulk viscosity, which spreads shocks"),
    ("viscous", |energy| energy.viscous, "dissipated by the viscous branches of the gel"),
    ("eroded", |energy| energy.eroded, "energy of eroded mass"),
    ("damage", |energy| energy.damage, "stored energy dissipated by damage"),
    ("imbalance", |energy| energy.imbalance, "imbalance: change that no account explains"),
];

/// Iterates over name and meaning of the energy accounts, in the order of the report.
#[cfg(feature = "cli")]
pub(super) fn account_meanings() -> impl Iterator<Item = (&'static str, &'static str)> {
    ACCOUNTS.iter().map(|(name, _, meaning)| (*name, *meaning))
}

/// Returns every energy account in the order of the report.
pub(super) fn energy_accounts(energy: &EnergyReport) -> Vec<SummaryAccount> {
    ACCOUNTS.iter().map(|&(name, value, meaning)| SummaryAccount { name, value: value(energy), meaning }).collect()
}

/// Reads the energy accounts back; an account that is not in the summary is left out.
pub(super) fn from_object<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<SummaryAccount>, D::Error> {
    let values = BTreeMap::<String, Option<f64>>::deserialize(deserializer)?;
    let account = |&(name, _, meaning): &AccountEntry| {
        values.get(name).map(|value| SummaryAccount { name, value: value.unwrap_or(f64::NAN), meaning })
    };
    Ok(ACCOUNTS.iter().filter_map(account).collect())
}
