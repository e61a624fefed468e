//! Parameters of a gel: their values in a scene, the coordinates of a fit, and the lines of a scene.

use crate::options::GelKey;
use crate::rounding::rounded_to;
use ballistic_gel::scene::{BranchSpec, GelSpec, Override, PowerLawSpec};
use nalgebra::DVector;

/// Strain rate at which a dashpot's stress is the coordinate of a fit, 1/s.
///
/// The depth fixes the stress at the rate of the shot. With this stress as a coordinate, the exponent hardly changes
/// the depth, and the two are nearly independent: gels with exponents of 0.5 to 0.85 that stop a BB at the same depth
/// have this stress in common.
const REFERENCE_RATE: f64 = 1e4;

/// Value of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GelValue {
    /// Parameter.
    pub key: GelKey,
    /// Value, SI units.
    pub value: f64,
}

/// Returns the name of a parameter on the command line.
pub fn key_name(key: GelKey) -> &'static str {
    match key {
        GelKey::Stress => "stress",
        GelKey::Rate => "rate",
        GelKey::Exponent => "exponent",
        GelKey::ShearModulus => "shear_modulus",
        GelKey::BranchModulus => "branches.shear_modulus",
        GelKey::CriticalStretch => "critical_stretch",
        GelKey::Delay => "delay",
    }
}

/// Returns the value of a parameter of a gel, if the gel has it.
pub fn read_value(gel: &GelSpec, key: GelKey) -> Option<f64> {
    let power_law = gel.branches.iter().find_map(|branch| branch.power_law);
    match key {
        GelKey::Stress => power_law.map(|law| law.stress),
        GelKey::Rate => power_law.and_then(|law| law.rate),
        GelKey::Exponent => power_law.map(|law| law.exponent),
        GelKey::ShearModulus => (gel.shear_modulus > 0.0).then_some(gel.shear_modulus),
        GelKey::BranchModulus => gel.branches.first().map(|branch| branch.shear_modulus),
        GelKey::CriticalStretch => gel.damage.map(|damage| damage.critical_stretch),
        GelKey::Delay => gel.damage.map(|damage| damage.delay),
    }
}

/// Writes a value into a gel that has the parameter.
fn write_value(gel: &mut GelSpec, given: GelValue) {
    let GelValue { key, value } = given;
    let power_law = gel.branches.iter_mut().find_map(|branch| branch.power_law.as_mut());
    match key {
        GelKey::Stress => power_law.into_iter().for_each(|law| law.stress = value),
        GelKey::Rate => power_law.into_iter().for_each(|law| law.rate = Some(value)),
        GelKey::Exponent => power_law.into_iter().for_each(|law| law.exponent = value),
        GelKey::ShearModulus => gel.shear_modulus = value,
        GelKey::BranchModulus => gel.branches.iter_mut().take(1).for_each(|branch| branch.shear_modulus = value),
        GelKey::CriticalStretch => gel.damage.iter_mut().for_each(|damage| damage.critical_stretch = value),
        GelKey::Delay => gel.damage.iter_mut().for_each(|damage| damage.delay = value),
    }
}

/// Returns the overrides that give the gel of a scene these values.
pub fn gel_overrides(gel: &GelSpec, values: &[GelValue]) -> Vec<Override> {
    let mut changed = gel.clone();
    for value in values {
        write_value(&mut changed, *value);
    }
    let damage = changed
        .damage
        .filter(|_| changed.damage != gel.damage)
        .map(|damage| format!("{{ critical_stretch = {:?}, delay = {:?} }}", damage.critical_stretch, damage.delay));
    let texts = [
        ("shear_modulus", (changed.shear_modulus != gel.shear_modulus).then(|| format!("{:?}", changed.shear_modulus))),
        ("branches", (changed.branches != gel.branches).then(|| branches_text(&changed.branches))),
        ("damage", damage),
    ];
    let overrides = texts.into_iter().filter_map(|(key, text)| Some((key, text?)));
    overrides.map(|(key, value)| Override { key: format!("gel.{key}"), value }).collect()
}

/// Returns the lines of a scene with the elastic modulus and the branches of a gel with these values.
pub fn scene_lines(gel: &GelSpec, values: &[GelValue]) -> String {
    let mut fitted = gel.clone();
    for value in values {
        write_value(&mut fitted, *value);
    }
    format!("[gel]\nshear_modulus = {:?}\nbranches = {}", fitted.shear_modulus, branches_text(&fitted.branches))
}

/// Returns the TOML text of branches.
fn branches_text(branches: &[BranchSpec]) -> String {
    let text = |branch: &BranchSpec| {
        let power_law = branch.power_law.map(|PowerLawSpec { stress, rate, exponent }| {
            let rate = rate.map(|rate| format!(" rate = {rate:?},")).unwrap_or_default();
            format!("power_law = {{ stress = {stress:?},{rate} exponent = {exponent:?} }}")
        });
        let dashpot = power_law.or(branch.time.map(|time| format!("time = {time:?}"))).unwrap_or_default();
        format!("{{ shear_modulus = {:?}, {dashpot} }}", branch.shear_modulus)
    };
    format!("[{}]", branches.iter().map(text).collect::<Vec<_>>().join(", "))
}

/// Coordinates of a fit: logarithms of the parameters; with the exponent of a power law that does not saturate, its
/// stress at [`REFERENCE_RATE`] in the place of the stress at 1/s.
#[derive(Debug, Clone, PartialEq)]
pub struct FitCoordinates {
    /// Fitted parameters, without repetitions.
    pub keys: Vec<GelKey>,
    /// True if the power law saturates.
    pub saturates: bool,
}

impl FitCoordinates {
    /// Returns the coordinates of values, in the order of the keys.
    pub fn of_values(&self, values: &[GelValue]) -> DVector<f64> {
        let exponent = self.shift(values);
        let coordinate = |given: &GelValue| match given.key {
            GelKey::Stress => given.value.ln() + exponent * REFERENCE_RATE.ln(),
            _ => given.value.ln(),
        };
        DVector::from_iterator(values.len(), values.iter().map(coordinate))
    }

    /// Returns the values at coordinates, rounded to five digits as in a scene.
    pub fn to_values(&self, coordinates: &DVector<f64>) -> Vec<GelValue> {
        let plain =
            self.keys.iter().zip(coordinates.iter()).map(|(&key, ln)| GelValue { key, value: rounded(ln.exp()) });
        let mut values: Vec<GelValue> = plain.collect();
        let exponent = self.shift(&values);
        for (given, coordinate) in values.iter_mut().zip(coordinates.iter()) {
            match given.key {
                GelKey::Stress => given.value = rounded((coordinate - exponent * REFERENCE_RATE.ln()).exp()),
                GelKey::Exponent => given.value = given.value.min(greatest_exponent(self.saturates)),
                _ => {}
            }
        }
        values
    }

    /// Returns the upper bounds of the coordinates: that of an exponent.
    pub fn upper_bounds(&self) -> DVector<f64> {
        let most = greatest_exponent(self.saturates).ln();
        let bound = |key: &GelKey| if *key == GelKey::Exponent { most } else { f64::INFINITY };
        DVector::from_iterator(self.keys.len(), self.keys.iter().map(bound))
    }

    /// Returns the fitted exponent of a power law that does not saturate; 0 if it is not fitted.
    fn shift(&self, values: &[GelValue]) -> f64 {
        let exponent = values.iter().find(|given| given.key == GelKey::Exponent).filter(|_| !self.saturates);
        exponent.map_or(0.0, |given| given.value.min(greatest_exponent(false)))
    }
}

/// Returns the greatest exponent of a power law.
pub fn greatest_exponent(saturates: bool) -> f64 {
    if saturates { 10.0 } else { 1.0 }
}

/// Rounds a value to five digits.
pub fn rounded(value: f64) -> f64 {
    rounded_to(5, value)
}
