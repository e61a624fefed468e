//! Momentum, angular momentum and energy by named, signed account (numerics A6).
//!
//! Every account is computed from its own formula, never as the difference of others: that the books close is a test
//! of every formula at once.

use crate::algebra::Vector3;
use crate::element::Spent;
use serde::{Deserialize, Serialize};

/// Energy, momentum and angular momentum that entered (positive) or left through each post since the start.
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
    /// Σ J (u⁻ + u⁺)/2 of the contact law, without the removal of penetration.
    pub contact: f64,
    /// Σ Jₜ·(uₜ⁻ + uₜ⁺)/2 of friction.
    pub friction: f64,
    /// Σ J b of the bias velocity b that removes standing penetration.
    pub contact_bias: f64,
    /// Σ r_K, trapezoidal residuals of the elements' steps, and of the projectile's rotation.
    pub integration: f64,
    /// Work of external force and torque, and of whoever prescribes the motion.
    pub external: f64,
    /// Jumps of the projectile's kinetic energy made by the importer.
    pub importer: f64,
    /// What kinetic and stored energy change by when a mesh is exchanged.
    pub remesh: f64,
    /// Σ J·(v⁻ + v⁺)/2 of the pressures on faces.
    pub load: f64,
    /// Σ J·(v⁻ + v⁺)/2 of the damping.
    pub damping: f64,
    /// What plastic flow sets free at the strength that is left, negative (numerics 6.2).
    pub plastic: f64,
    /// −Σ q ΔJ w of bulk viscosity, and what branches have stored and forgotten.
    pub viscous: f64,
    /// What breaks off has taken along.
    pub splash: f64,
    /// Stored energy lost to softening, negative (numerics 6.2).
    pub damage: f64,
}

/// Momentum accounts.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct MomentumAccounts {
    /// Taken up by held nodes.
    pub restraint: Vector3,
    /// External force or torque, and the reaction of a fixed or prescribed projectile.
    pub external: Vector3,
    /// Jumps made by the importer.
    pub importer: Vector3,
    /// What changes when a mesh is exchanged.
    pub remesh: Vector3,
    /// Of the pressures on faces.
    pub load: Vector3,
    /// Of the damping.
    pub damping: Vector3,
    /// What breaks off has taken along.
    pub splash: Vector3,
}

impl EnergyAccounts {
    /// Sum of all accounts.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.accounts().iter().sum()
    }

    /// Sum of the sizes of all accounts.
    #[must_use]
    pub fn turnover(&self) -> f64 {
        self.accounts().iter().map(|account| account.abs()).sum()
    }

    /// Books what a patch has lost; the residual of its step, which is made of what it stores, has that, too.
    pub fn lose(&mut self, spent: &Spent) {
        self.plastic -= spent.plastic;
        self.viscous -= spent.viscous;
        self.damage -= spent.damage;
        self.integration += spent.plastic + spent.viscous + spent.damage;
    }

    fn accounts(&self) -> [f64; 13] {
        let Self { contact, friction, contact_bias, integration, external, importer, .. } = *self;
        let Self { remesh, load, damping, plastic, viscous, splash, damage, .. } = *self;
        [
            contact,
            friction,
            contact_bias,
            integration,
            external,
            importer,
            remesh,
            load,
            damping,
            plastic,
            viscous,
            splash,
            damage,
        ]
    }
}

impl MomentumAccounts {
    /// Sum of all accounts.
    #[must_use]
    pub fn total(&self) -> Vector3 {
        self.accounts().iter().sum()
    }

    /// Sum of the sizes of all accounts.
    #[must_use]
    pub fn turnover(&self) -> f64 {
        self.accounts().iter().map(Vector3::norm).sum()
    }

    fn accounts(&self) -> [Vector3; 7] {
        let Self { restraint, external, importer, remesh, load, damping, splash } = *self;
        [restraint, external, importer, remesh, load, damping, splash]
    }
}
