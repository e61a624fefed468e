//! Material models: stored energy, stress and stiffness bound, one file each.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

mod damage;
mod equation_of_state;
mod hyperelastic;
mod isochoric;
mod mooney_rivlin;
mod neo_hookean;
mod ogden;
mod viscoelastic;
mod viscosity;
mod volume;
mod yield_law;

use crate::math::Number;

pub use damage::DamageLaw;
pub use equation_of_state::EquationOfState;
pub use hyperelastic::{Hyperelastic, ShearResponse};
pub(crate) use isochoric::IsochoricDeformation;
pub use mooney_rivlin::MooneyRivlin;
pub use neo_hookean::NeoHookean;
pub use ogden::{Ogden, OgdenTerm};
pub(crate) use viscoelastic::{BranchResponse, IsochoricShape};
pub use viscoelastic::{MaxwellBranch, Viscoelastic};
pub use viscosity::BulkViscosity;
pub use volume::{LogarithmicEnergy, VolumetricEnergy, VolumetricResponse};
pub use yield_law::{PressureHardening, StressReturn, YieldLaw};

/// Material model of a gel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Material {
    /// Compressible neo-Hookean solid.
    NeoHookean(NeoHookean),
    /// Compressible Mooney–Rivlin solid of two constants.
    MooneyRivlin(MooneyRivlin),
    /// Compressible Ogden solid, powers of the principal stretches.
    Ogden(Ogden),
    /// Viscoplastic solid with a rate-dependent yield stress.
    Flowing(Viscoplastic),
    /// Neo-Hookean solid with Maxwell branches.
    Viscoelastic(Viscoelastic),
}

/// Viscoplastic material: neo-Hookean shear, equation of state, yield law, damage and bulk viscosity (numerics A16,
/// 5b).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viscoplastic {
    /// μ, Pa; 0 for a fluid.
    pub shear_modulus: f64,
    /// Equation of state: the pressure as a function of J.
    pub state: EquationOfState,
    /// Yield law; none for a material that never yields.
    pub strength: Option<YieldLaw>,
    /// Damage by plastic flow, of shear modulus and yield stress; none for an undamaged material.
    pub softening: Option<DamageLaw>,
    /// Bulk viscosity, which spreads shocks over elements and damps their ringing.
    pub viscosity: BulkViscosity,
    /// ρ at rest, kg/m³.
    pub density: f64,
}

impl Viscoplastic {
    /// Part of the shear modulus with which the elements of a patch resist an exchange of volume between each other.
    ///
    /// Without this stabilisation an element near eroded material inverts while its patch keeps its volume (numerics
    /// A16).
    pub const SHARING: f64 = 0.4;
    /// Part of the bulk modulus that is the lower limit of the shear modulus in the stabilisation; a fluid has no
    /// shear modulus.
    ///
    /// The drag on a sphere of 180 m/s is the same with 0.003 and 0.01; with 0 the splashing elements invert at 0.08
    /// ms.
    pub const SOFTEST: f64 = 0.003;

    /// Returns the bulk sound speed at rest, √(K/ρ), m/s.
    #[must_use]
    pub fn sound_speed(&self) -> f64 {
        (self.state.bulk_modulus() / self.density).sqrt()
    }

    /// Returns the stabilisation modulus k, Pa.
    #[inline(always)]
    fn stabilisation_modulus(&self) -> f64 {
        Self::SHARING * self.shear_modulus.max(Self::SOFTEST * self.state.bulk_modulus())
    }
}

impl VolumetricEnergy for Viscoplastic {
    #[inline(always)]
    fn volumetric<T: Number>(&self, j: T) -> VolumetricResponse<T> {
        self.state.volumetric(j)
    }

    /// Element part, −k ln J.
    #[inline(always)]
    fn own<T: Number>(&self, j: T) -> VolumetricResponse<T> {
        equation_of_state::logarithmic(-self.stabilisation_modulus(), j)
    }

    /// Patch part, U(J̄) + k ln J̄: the sum with the element parts is U or more, and U where all J equal J̄.
    #[inline(always)]
    fn shared<T: Number>(&self, mean: T) -> VolumetricResponse<T> {
        let (state, own) =
            (self.state.volumetric(mean), equation_of_state::logarithmic(self.stabilisation_modulus(), mean));
        VolumetricResponse {
            energy: state.energy + own.energy,
            slope: state.slope + own.slope,
            curvature: state.curvature + own.curvature,
        }
    }
}

impl From<NeoHookean> for Material {
    fn from(gel: NeoHookean) -> Self {
        Self::NeoHookean(gel)
    }
}

impl Material {
    /// Returns the plane contact modulus E/(1 − ν²) at rest, Pa: 4μ (K + μ/3)/(K + 4μ/3).
    #[must_use]
    pub fn contact_modulus(&self) -> f64 {
        match self {
            Self::NeoHookean(gel) => gel.contact_modulus(),
            Self::Viscoelastic(gel) => gel.instantaneous().contact_modulus(),
            Self::Flowing(gel) => contact_modulus(gel.state.bulk_modulus(), gel.shear_modulus),
            Self::MooneyRivlin(gel) => contact_modulus(gel.bulk_modulus(), gel.shear_modulus()),
            Self::Ogden(gel) => contact_modulus(gel.bulk_modulus(), gel.shear_modulus()),
        }
    }

    /// Returns the ratio √(μ/(λ + 2μ)) of the shear wave speed to the pressure wave speed at rest.
    ///
    /// A volume change of this size stores the energy of a unit shear.
    #[must_use]
    pub fn shear_wave_ratio(&self) -> f64 {
        let shear = match self {
            Self::NeoHookean(gel) => gel.shear_modulus(),
            Self::Flowing(gel) => gel.shear_modulus,
            Self::MooneyRivlin(gel) => gel.shear_modulus(),
            Self::Ogden(gel) => gel.shear_modulus(),
            Self::Viscoelastic(gel) => gel.instantaneous().shear_modulus(),
        };
        (shear / self.wave_modulus()).sqrt()
    }

    /// Returns the pressure wave modulus λ + 2μ at rest, Pa.
    #[must_use]
    pub fn wave_modulus(&self) -> f64 {
        match self {
            Self::NeoHookean(gel) => gel.wave_modulus(),
            Self::Flowing(gel) => gel.state.bulk_modulus() + 4.0 / 3.0 * gel.shear_modulus,
            Self::MooneyRivlin(gel) => gel.bulk_modulus() + 4.0 / 3.0 * gel.shear_modulus(),
            Self::Ogden(gel) => gel.bulk_modulus() + 4.0 / 3.0 * gel.shear_modulus(),
            Self::Viscoelastic(gel) => gel.instantaneous().wave_modulus(),
        }
    }
}

/// Returns the plane contact modulus E/(1 − ν²) for K and μ.
fn contact_modulus(k: f64, mu: f64) -> f64 {
    4.0 * mu * (k + mu / 3.0) / (k + 4.0 / 3.0 * mu)
}
