//! What a transfer keeps and what it does not.

use crate::math::{Tensor3, Vector, Vector3, cofactor, det, embed, ordered_sum, restrict};

/// What moving masses have in all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Books<const D: usize> {
    /// Mass, kg.
    pub mass: f64,
    /// Momentum, N·s; in an axisymmetric body only its part along z is one.
    pub momentum: Vector<D>,
    /// Angular momentum about the origin, Σ m x × v, N·m·s: in the plane that about y; of an axisymmetric body it means
    /// nothing.
    pub angular: Vector3,
    /// Kinetic energy, J.
    pub kinetic: f64,
}

/// What a transfer did to the books.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Defects<const D: usize> {
    /// What the old mesh had.
    pub before: Books<D>,
    /// What the new one had before any correction.
    pub raw: Books<D>,
    /// What it has after the correction of the angular momentum.
    pub after: Books<D>,
    /// Momentum that held nodes took, N·s: `raw.momentum` is `before.momentum` less this, up to rounding.
    pub held_momentum: Vector<D>,
    /// Angular momentum about the origin that held nodes took, N·m·s; the correction does not give it back.
    pub held_angular: Vector3,
    /// Old mass that no new element lies over, and new elements lie over twice, kg: laid down at the nearest place.
    pub stray_mass: f64,
    /// Part of the new elements that are old ones.
    pub unchanged: f64,
    /// Nodes found outside the old mesh: they took over what is at the nearest place in it.
    pub misses: usize,
    /// Nodes without mass: a new mesh that has one must be refused.
    pub massless: usize,
}

impl<const D: usize> Books<D> {
    /// Of nodes where they are, with their masses and velocities.
    #[must_use]
    pub fn of(x: &[Vector<D>], mass: &[f64], velocity: &[Vector<D>]) -> Self {
        let n = mass.len();
        Self {
            mass: ordered_sum(n, 0.0, |i| mass[i]),
            momentum: ordered_sum(n, Vector::zeros(), |i| velocity[i] * mass[i]),
            angular: ordered_sum(n, Vector3::zeros(), |i| moment(&x[i], &velocity[i]) * mass[i]),
            kinetic: ordered_sum(n, 0.0, |i| 0.5 * mass[i] * velocity[i].norm_squared()),
        }
    }
}

/// Moment of a vector at a place, x × v.
fn moment<const D: usize>(x: &Vector<D>, v: &Vector<D>) -> Vector3 {
    embed(x).cross(&embed(v))
}

/// Some moving nodes of a planar or spatial body.
pub(super) struct Group<'a, const D: usize> {
    pub x: &'a [Vector<D>],
    pub mass: &'a [f64],
    /// Which of the nodes they are.
    pub members: &'a [usize],
}

impl<const D: usize> Group<'_, D> {
    /// Adds the rigid rotation about their centre of mass that has this angular momentum, N·m·s.
    ///
    /// It has no momentum. Nodes without extent do not turn, nor do nodes of space on one line.
    pub fn turn(&self, velocity: &mut [Vector<D>], angular: &Vector3) {
        let sum = |term: &dyn Fn(usize) -> f64| ordered_sum(self.members.len(), 0.0, |k| term(self.members[k]));
        let mass = sum(&|i| self.mass[i]);
        let centre = Vector::<D>::from_fn(|axis, _| sum(&|i| self.mass[i] * self.x[i][axis]) / mass);
        let rate = self.rate(&centre, angular);
        if !rate.iter().all(|rate| rate.is_finite()) || rate == Vector3::zeros() {
            return;
        }
        for i in self.members {
            velocity[*i] += restrict::<D>(&rate.cross(&embed(&(self.x[*i] - centre))));
        }
    }

    /// ω of Θ ω = L, Θ = Σ m (|r|² 1 − r ⊗ r) about the centre: in the plane ω_y = L_y/Σ m |r|².
    fn rate(&self, centre: &Vector<D>, angular: &Vector3) -> Vector3 {
        let arm = |k: usize| (self.mass[self.members[k]], embed(&(self.x[self.members[k]] - centre)));
        let n = self.members.len();
        let polar = ordered_sum(n, 0.0, |k| arm(k).0 * arm(k).1.norm_squared());
        if D == 2 {
            return Vector3::new(0.0, angular.y / polar, 0.0);
        }
        let spread = ordered_sum(n, Tensor3::zeros(), |k| arm(k).1 * arm(k).1.transpose() * arm(k).0);
        let inertia = Tensor3::identity() * polar - spread;
        cofactor(&inertia) * angular / det(&inertia)
    }
}

impl<const D: usize> Defects<D> {
    /// |Δm|/m before any mass was laid down where nothing lay over it.
    #[must_use]
    pub fn relative_mass(&self) -> f64 {
        self.stray_mass / self.before.mass
    }

    /// Momentum that appeared before any correction and that no held node gave, N·s: rounding, unless a node has no mass.
    #[must_use]
    pub fn momentum_defect(&self) -> Vector<D> {
        self.raw.momentum + self.held_momentum - self.before.momentum
    }

    /// Angular momentum about the origin that appeared before any correction and that no held node gave, N·m·s.
    #[must_use]
    pub fn angular_defect(&self) -> Vector3 {
        self.raw.angular + self.held_angular - self.before.angular
    }

    /// Kinetic energy that was lost, as a part of what there was.
    #[must_use]
    pub fn relative_loss(&self) -> f64 {
        1.0 - self.after.kinetic / self.before.kinetic
    }

    /// Of the books before and after, and what held nodes took; nothing is corrected yet.
    pub(super) fn new(before: Books<D>, raw: Books<D>, (x, taken): (&[Vector<D>], &[Vector<D>])) -> Self {
        let n = taken.len();
        Self {
            before,
            raw,
            after: raw,
            held_momentum: ordered_sum(n, Vector::zeros(), |i| taken[i]),
            held_angular: ordered_sum(n, Vector3::zeros(), |i| moment(&x[i], &taken[i])),
            stray_mass: 0.0,
            unchanged: 0.0,
            misses: 0,
            massless: 0,
        }
    }
}
