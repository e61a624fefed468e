//! Balance ledger: momentum, angular momentum and energy by named, signed account (method A6).
//!
//! Every account is computed from its own formula, never as the difference of others: the closure of the balance
//! tests every formula at once.

use crate::fem::Dissipation;
use crate::math::Vector3;
use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// Ledger of the energy, momentum and angular momentum that entered (positive) or left through each account since the
/// start.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Ledger {
    /// Energy, J.
    pub energy: EnergyAccounts,
    /// Momentum, N·s.
    pub momentum: MomentumAccounts,
    /// Angular momentum about the origin, N·m·s.
    pub angular_momentum: MomentumAccounts,
}

/// Energy accounts, J.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct EnergyAccounts {
    /// Σ J (u⁻ + u⁺)/2 of the contact with bodies, without the removal of penetration, and of the symmetry contact.
    pub contact: f64,
    /// Σ J (u⁻ + u⁺)/2 of the contact of the gel with itself.
    pub self_contact: f64,
    /// Σ Jₜ·(uₜ⁻ + uₜ⁺)/2 of friction.
    pub friction: f64,
    /// Σ J b of the bias velocity b that removes standing penetration.
    pub contact_bias: f64,
    /// Σ r_K, trapezoidal residuals of the elements' steps, and energy error of the projectile's rotation.
    pub integration: f64,
    /// Work of external force and torque, and of a prescribed motion.
    pub external: f64,
    /// Work of the surface of an expanding body as it moves in the frame of the body, and the change of its energy of
    /// rotation by its inertia.
    pub expansion: f64,
    /// Jumps of the projectile's kinetic energy made by the importer.
    pub importer: f64,
    /// Changes of kinetic and stored energy by remeshing, with what was returned.
    pub remesh: f64,
    /// Part of `remesh` by the correction that returns energy to the motion of the new elements, or takes it, no account of its
    /// own: the change by the meshes alone is the difference.
    pub remesh_returned: f64,
    /// Σ J·(v⁻ + v⁺)/2 of the pressures on faces.
    pub load: f64,
    /// Σ J·(v⁻ + v⁺)/2 of the air in the cavity.
    pub air: f64,
    /// Σ J·(v⁻ + v⁺)/2 of the damping.
    pub damping: f64,
    /// Dissipation by bulk viscosity, −Σ q ΔJ w, negative (method 6.2).
    pub bulk_viscous: f64,
    /// Relaxed energy of the viscous branches, negative.
    pub viscous: f64,
    /// Energy of the eroded mass.
    pub eroded: f64,
    /// Stored energy lost to damage, negative (method 6.2).
    pub damage: f64,
}

/// Momentum accounts.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct MomentumAccounts {
    /// Reaction of held nodes, and of the planes of symmetry.
    pub restraint: CompensatedSum,
    /// External force or torque, and the reaction of a fixed or prescribed projectile.
    pub external: CompensatedSum,
    /// Jumps made by the importer.
    pub importer: CompensatedSum,
    /// Changes by remeshing.
    pub remesh: CompensatedSum,
    /// Impulse of the pressures on faces.
    pub load: CompensatedSum,
    /// Impulse of the air in the cavity.
    pub air: CompensatedSum,
    /// Impulse of the damping.
    pub damping: CompensatedSum,
    /// Momentum of the eroded mass.
    pub eroded: CompensatedSum,
}

/// Compensated sum of millions of vectors: its rounding error is kept beside it (Knuth's two-sum, by component).
///
/// A pressure adds the same impulse at every tick, rounded the same way as often as not. That makes 6e-12 of the sum
/// after 10⁵ ticks, where the momentum itself is kept to 1e-14.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct CompensatedSum {
    sum: Vector3,
    lost: Vector3,
}

impl CompensatedSum {
    /// Returns the sum.
    #[must_use]
    pub fn value(&self) -> Vector3 {
        self.sum + self.lost
    }
}

impl AddAssign<Vector3> for CompensatedSum {
    fn add_assign(&mut self, part: Vector3) {
        let sum = self.sum + part;
        let taken = sum - self.sum;
        self.lost += (self.sum - (sum - taken)) + (part - taken);
        self.sum = sum;
    }
}

impl EnergyAccounts {
    /// Returns the sum of all accounts, J.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.accounts().iter().sum()
    }

    /// Returns the sum of the magnitudes of all accounts, J.
    #[must_use]
    pub fn turnover(&self) -> f64 {
        self.accounts().iter().map(|account| account.abs()).sum()
    }

    /// Returns the initial energy and the external work since, |E₀| + |external| + |load| + |air| + |expansion|, J: the
    /// scale of an imbalance. Accounts are net: energy put in and taken back does not count.
    #[must_use]
    pub fn scale_of_work(&self, initial: f64) -> f64 {
        initial.abs() + self.external.abs() + self.load.abs() + self.air.abs() + self.expansion.abs()
    }

    /// Returns [`Self::scale_of_work`] with the jumps made by the importer, which no method answers for, J: an upper bound
    /// of the available energy.
    #[must_use]
    pub fn provided(&self, initial: f64) -> f64 {
        self.scale_of_work(initial) + self.importer.abs()
    }

    /// Books the dissipation of a patch, and adds it to the residual of its step, which is computed from the stored
    /// energy.
    pub fn book_dissipation(&mut self, spent: &Dissipation) {
        self.bulk_viscous -= spent.bulk;
        self.viscous -= spent.viscous;
        self.damage -= spent.damage;
        self.integration += spent.bulk + spent.viscous + spent.damage;
    }

    /// Returns all accounts, J.
    fn accounts(&self) -> [f64; 16] {
        let Self { contact, self_contact, friction, contact_bias, integration, external, importer, .. } = *self;
        let Self { remesh, load, air, damping, bulk_viscous, viscous, eroded, damage, expansion, .. } = *self;
        [
            contact,
            self_contact,
            friction,
            contact_bias,
            integration,
            external,
            importer,
            remesh,
            load,
            air,
            damping,
            bulk_viscous,
            viscous,
            eroded,
            damage,
            expansion,
        ]
    }
}

impl MomentumAccounts {
    /// Returns the sum of all accounts.
    #[must_use]
    pub fn total(&self) -> Vector3 {
        self.accounts().iter().sum()
    }

    /// Returns the sum of the magnitudes of all accounts.
    #[must_use]
    pub fn turnover(&self) -> f64 {
        self.accounts().iter().map(Vector3::norm).sum()
    }

    fn accounts(&self) -> [Vector3; 8] {
        let Self { restraint, external, importer, remesh, load, air, damping, eroded } = self;
        [restraint, external, importer, remesh, load, air, damping, eroded].map(CompensatedSum::value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_available_energy_counts_jumps_of_the_importer_and_nothing_that_the_method_makes() {
        let books =
            EnergyAccounts { external: -3.0, load: 0.25, air: -0.25, importer: -0.25, ..EnergyAccounts::default() };
        let made = EnergyAccounts { integration: 9.0, contact_bias: 9.0, remesh: 9.0, bulk_viscous: -9.0, ..books };
        for books in [books, made] {
            assert_eq!((books.scale_of_work(-2.0), books.provided(-2.0)), (5.5, 5.75));
        }
    }

    #[test]
    fn a_million_equal_parts_add_up_to_round_off() {
        let (part, mut account, mut plain) = (Vector3::repeat(0.1), CompensatedSum::default(), Vector3::zeros());
        for _ in 0..1_000_000 {
            account += part;
            plain += part;
        }
        assert!((account.value() - Vector3::repeat(1e5)).norm() < 1e-10 && (plain.x - 1e5).abs() > 1e-6);
    }
}
