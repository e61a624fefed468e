//! Validation of the constants of a Mooney–Rivlin or Ogden gel: stability at every strain.

use super::domain::{CheckResult, finite, positive, require};
use crate::constitutive::{MooneyRivlin, Ogden};
use crate::scene::{ConstantsSpec, GelSpec, MaterialModel, SceneError, TermSpec};

/// Relative tolerance of a given shear modulus against the one that follows from the constants.
const ROUND_OFF: f64 = 1e-9;

/// Refuses constants of a gel whose model has none.
pub(super) fn check_belonging(gel: &GelSpec) -> CheckResult {
    let constants = gel.constants.is_none() || gel.material == MaterialModel::MooneyRivlin;
    let expected = "nothing: only a gel of material \"mooney-rivlin\" has constants";
    require(constants, "gel.constants", || "a table".to_owned(), expected)?;
    let terms = gel.terms.is_empty() || gel.material == MaterialModel::Ogden;
    let expected = "nothing: only a gel of material \"ogden\" has terms";
    require(terms, "gel.terms", || format!("{} of them", gel.terms.len()), expected)
}

/// Checks stability, and that the shear modulus follows from the constants.
pub(super) fn check(gel: &GelSpec) -> CheckResult {
    let shear_modulus = match gel.material {
        MaterialModel::MooneyRivlin => mooney_rivlin(gel)?,
        MaterialModel::Ogden => ogden(gel)?,
        MaterialModel::NeoHookean | MaterialModel::TwoNetwork => return Ok(()),
    };
    let own = (gel.shear_modulus / shear_modulus - 1.0).abs() < ROUND_OFF;
    let expected = format!("nothing: it follows from the constants of the gel and is {shear_modulus:?} Pa");
    require(own, "gel.shear_modulus", || format!("{:?}", gel.shear_modulus), &expected)
}

fn mooney_rivlin(gel: &GelSpec) -> Result<f64, SceneError> {
    let Some(ConstantsSpec { c1, c2 }) = gel.constants else {
        let expected = "the constants of a gel of material \"mooney-rivlin\", { c1 = ..., c2 = ... }, Pa";
        return Err(SceneError::value("gel.constants", "nothing", expected));
    };
    positive("gel.constants.c1", c1, "a positive constant, Pa")?;
    let expected = "a constant of 0 or more, Pa: with less the gel is unstable in biaxial tension";
    require(c2 >= 0.0 && c2.is_finite(), "gel.constants.c2", || format!("{c2:?}"), expected)?;
    let least = MooneyRivlin::least_bulk_modulus([c1, c2]);
    let expected = format!("more than 4/3 c1 + 16/3 c2, {least:?} Pa: the volumetric energy must be stable by itself");
    require(gel.bulk_modulus > least, "gel.bulk_modulus", || format!("{:?}", gel.bulk_modulus), &expected)?;
    Ok(MooneyRivlin::shear_modulus_of([c1, c2]))
}

fn ogden(gel: &GelSpec) -> Result<f64, SceneError> {
    let (n, most) = (gel.terms.len(), Ogden::MOST_TERMS);
    let expected = format!("1 to {most} tables {{ modulus, exponent }}");
    require((1..=most).contains(&n), "gel.terms", || format!("{n} of them"), &expected)?;
    gel.terms.iter().try_for_each(term)?;
    Ok(Ogden::shear_modulus_of(&gel.ogden_terms()))
}

fn term(term: &TermSpec) -> CheckResult {
    let TermSpec { modulus, exponent } = *term;
    let (least, most) = (Ogden::EXPONENTS.start(), Ogden::EXPONENTS.end());
    let expected = format!("a number of a magnitude from {least:?} to {most:?}");
    let known = Ogden::EXPONENTS.contains(&exponent.abs());
    require(known, "gel.terms.exponent", || format!("{exponent:?}"), &expected)?;
    finite("gel.terms.modulus", modulus)?;
    let sign = if exponent > 0.0 { "positive" } else { "negative" };
    let expected = format!(
        "a {sign} modulus, Pa, as the exponent, {exponent:?}: a term whose modulus times exponent is not positive makes the gel \
         unstable at some strain"
    );
    require(modulus * exponent > 0.0, "gel.terms.modulus", || format!("{modulus:?}"), &expected)
}
