//! Material models: stored energy, stress and stiffness bound, one file each.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

mod branch;
mod elastic_average;
mod equation_of_state;
mod hyperelastic;
mod isochoric;
mod isochoric_shape;
mod layers;
mod mooney_rivlin;
mod neo_hookean;
mod ogden;
mod power_law;
mod stretch_damage;
mod two_network;
mod viscosity;
mod volume;

pub use branch::{Branch, Dashpot, LinearDashpot};
pub use elastic_average::ElasticAverage;
pub(crate) use elastic_average::{LeftCauchyGreen, WeightedElastic, average_elastic};
pub use equation_of_state::EquationOfState;
pub use hyperelastic::{Hyperelastic, ShearResponse};
pub(crate) use isochoric::IsochoricDeformation;
pub(crate) use isochoric_shape::IsochoricShape;
pub use layers::{LayerStack, MOST_MATERIALS, MaterialLayer, MaterialParts, MaterialRatios, MixedModuli};
pub use mooney_rivlin::MooneyRivlin;
pub use neo_hookean::NeoHookean;
pub use ogden::{Ogden, OgdenTerm};
pub use power_law::PowerLaw;
pub use stretch_damage::StretchDamage;
pub use two_network::TwoNetwork;
pub use viscosity::BulkViscosity;
pub use volume::{LogarithmicEnergy, VolumetricEnergy, VolumetricResponse};

/// Material model of a gel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Material {
    /// Compressible neo-Hookean solid.
    NeoHookean(NeoHookean),
    /// Compressible Mooney–Rivlin solid of two constants.
    MooneyRivlin(MooneyRivlin),
    /// Compressible Ogden solid, powers of the principal stretches.
    Ogden(Ogden),
    /// Elastic network in parallel with viscous branches.
    TwoNetwork(TwoNetwork),
}

impl From<NeoHookean> for Material {
    fn from(gel: NeoHookean) -> Self {
        Self::NeoHookean(gel)
    }
}

impl From<TwoNetwork> for Material {
    fn from(gel: TwoNetwork) -> Self {
        Self::TwoNetwork(gel)
    }
}

impl Material {
    /// Returns the plane contact modulus E/(1 − ν²) at rest, Pa: 4μ (K + μ/3)/(K + 4μ/3).
    #[must_use]
    pub fn contact_modulus(&self) -> f64 {
        match self {
            Self::NeoHookean(gel) => gel.contact_modulus(),
            Self::TwoNetwork(gel) => contact_modulus(gel.state().bulk_modulus(), gel.instantaneous_modulus()),
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
            Self::TwoNetwork(gel) => gel.instantaneous_modulus(),
            Self::MooneyRivlin(gel) => gel.shear_modulus(),
            Self::Ogden(gel) => gel.shear_modulus(),
        };
        (shear / self.wave_modulus()).sqrt()
    }

    /// Returns the pressure wave modulus λ + 2μ at rest, Pa.
    #[must_use]
    pub fn wave_modulus(&self) -> f64 {
        match self {
            Self::NeoHookean(gel) => gel.wave_modulus(),
            Self::TwoNetwork(gel) => gel.state().bulk_modulus() + 4.0 / 3.0 * gel.instantaneous_modulus(),
            Self::MooneyRivlin(gel) => gel.bulk_modulus() + 4.0 / 3.0 * gel.shear_modulus(),
            Self::Ogden(gel) => gel.bulk_modulus() + 4.0 / 3.0 * gel.shear_modulus(),
        }
    }
}

/// Returns the plane contact modulus E/(1 − ν²) for K and μ.
fn contact_modulus(k: f64, mu: f64) -> f64 {
    4.0 * mu * (k + mu / 3.0) / (k + 4.0 / 3.0 * mu)
}
