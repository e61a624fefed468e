//! Material models: stored energy, stress and stiffness bound, one file each.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

mod damage;
mod equation_of_state;
mod hyperelastic;
mod mooney_rivlin;
mod neo_hookean;
mod ogden;
mod viscoelastic;
mod viscosity;
mod volume;
mod yield_law;

use crate::math::Number;

pub use damage::Softening;
pub use equation_of_state::EquationOfState;
pub use hyperelastic::{Hyperelastic, Logarithmic, Sheared};
pub use mooney_rivlin::MooneyRivlin;
pub use neo_hookean::NeoHookean;
pub use ogden::{Ogden, Term};
pub use viscoelastic::{Branch, Viscoelastic};
pub use viscosity::BulkViscosity;
pub use volume::{Volume, Volumetric};
pub use yield_law::{Confinement, Returned, Strength};

/// What a gel is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Material {
    /// Elastic at every strain and rate.
    NeoHookean(NeoHookean),
    /// Elastic at every strain and rate, in two constants.
    MooneyRivlin(MooneyRivlin),
    /// Elastic at every strain and rate, in powers of the stretches.
    Ogden(Ogden),
    /// Elastic up to a strength that depends on the rate, then it flows.
    Flowing(Flowing),
    /// Elastic in the long run, stiffer the faster it is strained.
    Viscoelastic(Viscoelastic),
}

/// A gel that flows: neo-Hookean in shear, pressure by an equation of state, a strength, bulk viscosity (numerics A16, 5b).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flowing {
    /// μ, Pa; 0 of a fluid.
    pub shear_modulus: f64,
    /// Pressure of a change of volume.
    pub state: EquationOfState,
    /// What it bears in shear; none of one that never flows.
    pub strength: Option<Strength>,
    /// What flow leaves of both; all if none.
    pub softening: Option<Softening>,
    /// What spreads shocks over elements and damps their ringing.
    pub viscosity: BulkViscosity,
    /// ρ at rest, kg/m³.
    pub density: f64,
}

impl Flowing {
    /// Part of the shear modulus with which elements of a patch resist that one of them gives its volume to another: without it an
    /// element in a splash is turned inside out while its patch keeps its volume (numerics A16).
    pub const SHARING: f64 = 0.4;
    /// Part of the bulk modulus that stands for the shear modulus there, if that is less: a fluid has none. Its drag on a sphere of
    /// 180 m/s is the same with 0.003 and 0.01 of it; with none the elements of the splash are turned inside out at 0.08 ms.
    pub const SOFTEST: f64 = 0.003;

    /// Speed of the pressure wave at rest without shear, √(K/ρ), m/s.
    #[must_use]
    pub fn sound_speed(&self) -> f64 {
        (self.state.bulk_modulus() / self.density).sqrt()
    }

    /// k, Pa.
    #[inline(always)]
    fn sharing(&self) -> f64 {
        Self::SHARING * self.shear_modulus.max(Self::SOFTEST * self.state.bulk_modulus())
    }
}

impl Volume for Flowing {
    #[inline(always)]
    fn volumetric<T: Number>(&self, j: T) -> Volumetric<T> {
        self.state.volumetric(j)
    }

    /// −k ln J.
    #[inline(always)]
    fn own<T: Number>(&self, j: T) -> Volumetric<T> {
        equation_of_state::logarithmic(-self.sharing(), j)
    }

    /// U(J̄) + k ln J̄: with what its elements have of their own never negative, and nothing more where all J are J̄.
    #[inline(always)]
    fn shared<T: Number>(&self, mean: T) -> Volumetric<T> {
        let (state, own) = (self.state.volumetric(mean), equation_of_state::logarithmic(self.sharing(), mean));
        Volumetric {
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
    /// E/(1 − ν²), modulus of a plane contact at rest, Pa: 4μ (K + μ/3)/(K + 4μ/3).
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

    /// √(μ/(λ + 2μ)), speed of a wave of shear at rest as a part of that of one of pressure: a change of volume by as much stores what a shear of
    /// one does.
    #[must_use]
    pub fn slowness_of_shear(&self) -> f64 {
        let shear = match self {
            Self::NeoHookean(gel) => gel.shear_modulus(),
            Self::Flowing(gel) => gel.shear_modulus,
            Self::MooneyRivlin(gel) => gel.shear_modulus(),
            Self::Ogden(gel) => gel.shear_modulus(),
            Self::Viscoelastic(gel) => gel.instantaneous().shear_modulus(),
        };
        (shear / self.wave_modulus()).sqrt()
    }

    /// λ + 2μ, modulus of the pressure wave at rest, Pa.
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

/// E/(1 − ν²) of K and μ.
fn contact_modulus(k: f64, mu: f64) -> f64 {
    4.0 * mu * (k + mu / 3.0) / (k + 4.0 / 3.0 * mu)
}
