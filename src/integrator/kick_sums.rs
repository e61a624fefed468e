//! Sums over the kicks of a tick: work, reactions of held directions, losses to damping.

use crate::contact::FreeDirections;
use crate::ledger::Ledger;
use crate::math::{Vector, Vector3, embed, restrict};
use crate::state::OutsideImpulse;

/// Sums over the kicked nodes.
#[derive(Debug, Clone, Copy)]
pub(super) struct KickSums {
    /// Least stable limit, s.
    pub limit: f64,
    /// Work of the kicks less the change of the carried kick work, Σ p·(v⁻ + v⁺)/2 − Σ ΔQ (A6), J.
    pub work: f64,
    /// Greatest |v|², m²/s².
    pub max_speed_squared: f64,
    /// Reaction of the held directions.
    pub reaction: ConstraintReaction,
    /// Loss to damping.
    pub damping: DampingLoss,
}

impl Default for KickSums {
    fn default() -> Self {
        Self {
            limit: f64::INFINITY,
            work: 0.0,
            max_speed_squared: 0.0,
            reaction: ConstraintReaction::default(),
            damping: DampingLoss::default(),
        }
    }
}

impl KickSums {
    /// Adds the sums of other nodes.
    pub fn merge(self, other: &Self) -> Self {
        Self {
            limit: self.limit.min(other.limit),
            work: self.work + other.work,
            max_speed_squared: self.max_speed_squared.max(other.max_speed_squared),
            reaction: self.reaction + other.reaction,
            damping: self.damping + other.damping,
        }
    }

    /// Posts reaction and loss at a time, s, to the ledger and to the impulse on the gel.
    pub fn post(&self, ledger: &mut Ledger, outside: &mut OutsideImpulse, time: f64) {
        self.reaction.post(ledger);
        self.damping.post(ledger, outside, time);
    }
}

/// Reaction of the held directions: linear and angular momentum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ConstraintReaction {
    momentum: Vector3,
    angular_momentum: Vector3,
}

impl Default for ConstraintReaction {
    fn default() -> Self {
        Self { momentum: Vector3::zeros(), angular_momentum: Vector3::zeros() }
    }
}

impl std::ops::Add for ConstraintReaction {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            momentum: self.momentum + other.momentum,
            angular_momentum: self.angular_momentum + other.angular_momentum,
        }
    }
}

impl ConstraintReaction {
    /// Adds the reaction of the held directions of a node at `at`, m, to an impulse, N·s.
    pub fn add<const D: usize>(&mut self, free: &Vector<D>, freedom: FreeDirections, at: Vector3, push: Vector3) {
        if free.min() == 0.0 {
            let reaction = embed(&restrict::<D>(&push).component_mul(free)) - push;
            self.add_reaction(freedom, at, reaction);
        }
    }

    /// Adds a reaction impulse on a node at `at`, m.
    pub fn add_reaction(&mut self, freedom: FreeDirections, at: Vector3, push: Vector3) {
        self.momentum += freedom.translation(&push);
        self.angular_momentum += freedom.rotation(&at.cross(&push));
    }

    /// Posts the reaction to the ledger.
    pub fn post(&self, ledger: &mut Ledger) {
        ledger.momentum.restraint += self.momentum;
        ledger.angular_momentum.restraint += self.angular_momentum;
    }
}

/// Loss of energy and momentum to damping.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DampingLoss {
    /// Work of the damping impulses, Σ J·(v⁻ + v⁺)/2, J.
    pub energy: f64,
    momentum: Vector3,
    angular_momentum: Vector3,
}

impl Default for DampingLoss {
    fn default() -> Self {
        Self { energy: 0.0, momentum: Vector3::zeros(), angular_momentum: Vector3::zeros() }
    }
}

impl std::ops::Add for DampingLoss {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            energy: self.energy + other.energy,
            momentum: self.momentum + other.momentum,
            angular_momentum: self.angular_momentum + other.angular_momentum,
        }
    }
}

impl DampingLoss {
    /// Adds the damping impulse on a node at `at`, m.
    pub fn add_impulse<const D: usize>(&mut self, freedom: FreeDirections, at: &Vector<D>, impulse: &Vector<D>) {
        let impulse = embed(impulse);
        self.momentum += freedom.translation(&impulse);
        self.angular_momentum += freedom.rotation(&embed(at).cross(&impulse));
    }

    /// Posts the loss at a time, s, to the ledger and to the impulse on the gel.
    pub fn post(&self, ledger: &mut Ledger, outside: &mut OutsideImpulse, time: f64) {
        outside.add(&self.momentum, time);
        ledger.energy.damping += self.energy;
        ledger.momentum.damping += self.momentum;
        ledger.angular_momentum.damping += self.angular_momentum;
    }
}

/// Returns the relative change of velocity by damping over a time, s: exp(−αt) − 1.
#[inline]
pub(super) fn decay(rate: f64, time: f64) -> f64 {
    libm::expm1(-rate * time)
}
