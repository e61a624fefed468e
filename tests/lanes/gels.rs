//! Gels that remember, of parts of 1: fast enough to flow and to relax in a few steps.

use ballistic_gel::constitutive::{
    BulkViscosity, DamageLaw, EquationOfState, Material, MaxwellBranch, NeoHookean, PressureHardening, Viscoelastic,
    Viscoplastic, YieldLaw,
};

/// One that flows under a slow ball and softens; it may bear more under pressure.
pub fn flowing(confined: Option<PressureHardening>) -> Material {
    let strength = YieldLaw::new(0.02, 0.9, 0.06).with_reference_rate(0.3);
    let strength = confined.map_or(strength, |confinement| strength.with_confinement(confinement));
    Material::Flowing(Viscoplastic {
        shear_modulus: 1.0,
        state: EquationOfState::new(10.0, 1.5, 0.5),
        strength: Some(strength),
        softening: Some(DamageLaw::new(0.05, 0.3, 0.2)),
        viscosity: BulkViscosity { linear: 0.06, quadratic: 1.0 },
        density: 1.0,
    })
}

/// One with branches of these shear moduli and relaxation times.
pub fn relaxing(branches: &[(f64, f64)]) -> Material {
    let branches: Vec<MaxwellBranch> = branches
        .iter()
        .map(|(shear_modulus, time)| MaxwellBranch { shear_modulus: *shear_modulus, time: *time })
        .collect();
    Material::Viscoelastic(Viscoelastic::new(NeoHookean::new(0.6, 10.0), &branches))
}
