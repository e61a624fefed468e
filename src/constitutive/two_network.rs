#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::equation_of_state::logarithmic;
use super::{Branch, BulkViscosity, Dashpot, EquationOfState, StretchDamage, VolumetricEnergy, VolumetricResponse};
use crate::math::Number;

/// Two-network gel: an elastic network in parallel with viscous branches and a volumetric part (method 6.2).
///
/// The arrangement is that of Bergström and Boyce (1998), the flow of a power-law branch that of Simo and Hughes
/// (1998).
///
/// ψ = (1 − d) μ/2 (tr b̄ − 3) + Σ μ_i/2 (tr b̄_i − 3) + U(J), b̄ = J^(−2/3) F A Fᵀ and b̄_i = J^(−2/3) F C̄_i⁻¹ Fᵀ of
/// determinant 1.
///
/// - The elastic network is neo-Hookean in the whole deformation: A = 1 until a remeshing gives the element another
///   reference. Its delayed damage d ([`StretchDamage`]) is the permanent track of a shot.
/// - A branch is a neo-Hookean spring in series with a dashpot ([`Dashpot`]), linear or of a power law. Flow only
///   changes its rest shape C̄_i (multiplicative split; Reese and Govindjee 1998). There is no yield stress, and the
///   flow does not depend on the pressure.
/// - U is the equation of state; the bulk modulus neither relaxes nor fails.
///
/// With ∂(J^(−2/3))/∂F = −2/(3J) J^(−2/3) ∂J/∂F the stress is P = Σ μ_k [J^(−2/3) F C_k − tr b̄_k/(3J) ∂J/∂F] +
/// U′ ∂J/∂F over all networks k.
///
/// The equations are hyperbolic with a dissipative relaxation, and so well posed, as long as (1 − d) μ + Σ μ_i > 0:
/// waves shorter than c τ are damped at the rate 1/(2τ) on any mesh. A sudden damage (no delay) localises in one layer
/// of elements, hence τ_d > 0 and a branch are required where there is damage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoNetwork {
    shear_modulus: f64,
    damage: Option<StretchDamage>,
    branches: [Branch; Self::MOST_BRANCHES],
    n_branches: usize,
    state: EquationOfState,
    viscosity: BulkViscosity,
    density: f64,
}

impl TwoNetwork {
    /// Most branches of a material: three span the four decades from a wave crossing an element to a rebound.
    pub const MOST_BRANCHES: usize = 3;
    /// Part of the shear modulus with which the elements of a patch resist an exchange of volume between each other.
    ///
    /// Without this stabilisation an element near eroded material inverts while its patch keeps its volume (method
    /// A16).
    pub const SHARING: f64 = 0.4;
    /// Part of the bulk modulus that is the lower limit of the shear modulus in the stabilisation; a fluid has no
    /// shear modulus.
    ///
    /// The drag on a sphere of 180 m/s is the same with 0.003 and 0.01; with 0 the splashing elements invert at 0.08
    /// ms.
    pub const SOFTEST: f64 = 0.003;

    /// Creates a gel from the modulus of its elastic network, Pa, its branches, its equation of state and its density,
    /// kg/m³; without damage and bulk viscosity.
    ///
    /// # Panics
    /// If the modulus is negative, the density not positive, or there are more than [`Self::MOST_BRANCHES`] branches.
    #[must_use]
    pub fn new(shear_modulus: f64, branches: &[Branch], state: EquationOfState, density: f64) -> Self {
        let n_branches = branches.len();
        let is_valid = shear_modulus >= 0.0 && density > 0.0 && n_branches <= Self::MOST_BRANCHES;
        assert!(is_valid, "a two-network gel has mu >= 0, rho > 0 and at most 3 branches");
        let mut own = [Branch::new(1.0, Dashpot::linear(1.0)); Self::MOST_BRANCHES];
        own[..n_branches].copy_from_slice(branches);
        let viscosity = BulkViscosity::default();
        Self { shear_modulus, damage: None, branches: own, n_branches, state, viscosity, density }
    }

    /// Returns the gel with damage of its elastic network.
    ///
    /// # Panics
    /// If the gel has no branch, so that nothing would be left of its stiffness.
    #[must_use]
    pub fn with_damage(self, damage: StretchDamage) -> Self {
        assert!(self.n_branches > 0, "a gel that is damaged needs a branch");
        Self { damage: Some(damage), ..self }
    }

    /// Returns the gel with bulk viscosity, which spreads shocks over elements and damps their ringing.
    #[must_use]
    pub fn with_viscosity(self, viscosity: BulkViscosity) -> Self {
        Self { viscosity, ..self }
    }

    /// Returns μ of the elastic network, Pa; 0 for none.
    #[must_use]
    pub fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }

    /// Returns the damage law of the elastic network, if it has one.
    #[must_use]
    pub fn damage(&self) -> Option<&StretchDamage> {
        self.damage.as_ref()
    }

    /// Returns the branches.
    #[must_use]
    pub fn branches(&self) -> &[Branch] {
        &self.branches[..self.n_branches]
    }

    /// Returns the equation of state.
    #[must_use]
    pub fn state(&self) -> &EquationOfState {
        &self.state
    }

    /// Returns the bulk viscosity.
    #[must_use]
    pub fn viscosity(&self) -> &BulkViscosity {
        &self.viscosity
    }

    /// Returns ρ at rest, kg/m³.
    #[must_use]
    pub fn density(&self) -> f64 {
        self.density
    }

    /// Returns the instantaneous shear modulus μ + Σ μ_i, Pa, before anything flows or fails.
    #[must_use]
    pub fn instantaneous_modulus(&self) -> f64 {
        self.shear_modulus + self.branches().iter().map(Branch::shear_modulus).sum::<f64>()
    }

    /// Returns the bulk sound speed at rest, √(K/ρ), m/s.
    #[must_use]
    pub fn sound_speed(&self) -> f64 {
        (self.state.bulk_modulus() / self.density).sqrt()
    }

    /// Returns the stabilisation modulus k of a material of these ratios to the gel, relative to that of the gel.
    #[inline(always)]
    pub(crate) fn relative_stabilisation<T: Number>(&self, strength: T, bulk: T) -> T {
        let [shear, volume] = [self.instantaneous_modulus(), Self::SOFTEST * self.state.bulk_modulus()];
        (strength * shear).or_greater(bulk * volume) / strength.constant(shear.max(volume))
    }

    /// Returns the stabilisation modulus k, Pa.
    #[inline(always)]
    fn stabilisation_modulus(&self) -> f64 {
        Self::SHARING * self.instantaneous_modulus().max(Self::SOFTEST * self.state.bulk_modulus())
    }
}

impl VolumetricEnergy for TwoNetwork {
    #[inline(always)]
    fn volumetric<T: Number>(&self, j: T) -> VolumetricResponse<T> {
        self.state.volumetric(j)
    }

    /// Element part, −k ln J.
    #[inline(always)]
    fn own<T: Number>(&self, j: T) -> VolumetricResponse<T> {
        logarithmic(-self.stabilisation_modulus(), j)
    }

    /// Patch part, U(J̄) + k ln J̄: the sum with the element parts is U or more, and U where all J equal J̄.
    #[inline(always)]
    fn shared<T: Number>(&self, mean: T) -> VolumetricResponse<T> {
        let (state, own) = (self.state.volumetric(mean), logarithmic(self.stabilisation_modulus(), mean));
        VolumetricResponse {
            energy: state.energy + own.energy,
            slope: state.slope + own.slope,
            curvature: state.curvature + own.curvature,
        }
    }
}
