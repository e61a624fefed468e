//! Gels with history, of moduli about 1: soft and fast enough to flow, to fail and to relax in a few steps.

use ballistic_gel::constitutive::{
    Branch, BulkViscosity, Dashpot, EquationOfState, Material, StretchDamage, TwoNetwork,
};

/// Elastic network that is damaged from a small stretch on, beside a branch with a power law, which flows under a slow ball.
pub fn damaged() -> Material {
    let branch = Branch::new(0.7, Dashpot::power_law(0.06, 0.9));
    let state = EquationOfState::new(10.0, 1.5, 0.5);
    let damage = StretchDamage::new(1.02, 0.1);
    let viscosity = BulkViscosity { linear: 0.06, quadratic: 1.0 };
    TwoNetwork::new(0.3, &[branch], state, 1.0).with_damage(damage).with_viscosity(viscosity).into()
}

/// Elastic network beside linear branches of these shear moduli and relaxation times.
pub fn relaxing(branches: &[[f64; 2]]) -> Material {
    let branches: Vec<Branch> =
        branches.iter().map(|[modulus, time]| Branch::new(*modulus, Dashpot::linear(*time))).collect();
    TwoNetwork::new(0.6, &branches, EquationOfState::new(10.0, 0.0, f64::INFINITY), 1.0).into()
}
