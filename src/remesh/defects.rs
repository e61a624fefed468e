//! What a transfer keeps and what it does not.

use crate::algebra::{Vector, ordered_sum};

/// What moving masses have in all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Books {
    /// Mass, kg.
    pub mass: f64,
    /// Momentum, N·s; in an axisymmetric body only its part along z is one.
    pub momentum: Vector<2>,
    /// Angular momentum about the origin, Σ m (z v_x − x v_z), N·m·s; means something in `planar` only.
    pub angular: f64,
    /// Kinetic energy, J.
    pub kinetic: f64,
}

/// What a transfer did to the books.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Defects {
    /// What the old mesh had.
    pub before: Books,
    /// What the new one had before any correction.
    pub raw: Books,
    /// What it has after the correction of the angular momentum.
    pub after: Books,
    /// Momentum that held nodes took, N·s: `raw.momentum` is `before.momentum` less this, up to rounding.
    pub held_momentum: Vector<2>,
    /// Angular momentum about the origin that held nodes took, N·m·s; the correction does not give it back.
    pub held_angular: f64,
    /// Old mass that no new element lies over, and new elements lie over twice, kg: laid down at the nearest place.
    pub stray_mass: f64,
    /// Part of the new elements that are old ones.
    pub unchanged: f64,
    /// Nodes found outside the old mesh: they took over what is at the nearest place in it.
    pub misses: usize,
    /// Nodes without mass: a new mesh that has one must be refused.
    pub massless: usize,
}

impl Books {
    /// Of nodes where they are, with their masses and velocities.
    #[must_use]
    pub fn of(x: &[Vector<2>], mass: &[f64], velocity: &[Vector<2>]) -> Self {
        let n = mass.len();
        Self {
            mass: ordered_sum(n, 0.0, |i| mass[i]),
            momentum: ordered_sum(n, Vector::zeros(), |i| velocity[i] * mass[i]),
            angular: ordered_sum(n, 0.0, |i| mass[i] * moment(&x[i], &velocity[i])),
            kinetic: ordered_sum(n, 0.0, |i| 0.5 * mass[i] * velocity[i].norm_squared()),
        }
    }
}

/// Moment about the y axis of a vector at a place, z v_x − x v_z.
fn moment(x: &Vector<2>, v: &Vector<2>) -> f64 {
    x[1] * v[0] - x[0] * v[1]
}

/// Some moving nodes of a planar body.
pub(super) struct Group<'a> {
    pub x: &'a [Vector<2>],
    pub mass: &'a [f64],
    /// Which of the nodes they are.
    pub members: &'a [usize],
}

impl Group<'_> {
    /// Adds the rigid rotation about their centre of mass that has this angular momentum, N·m·s.
    ///
    /// It has no momentum. Nodes without extent do not turn.
    pub fn turn(&self, velocity: &mut [Vector<2>], angular: f64) {
        let sum = |term: &dyn Fn(usize) -> f64| ordered_sum(self.members.len(), 0.0, |k| term(self.members[k]));
        let mass = sum(&|i| self.mass[i]);
        let centre = Vector::<2>::from_fn(|axis, _| sum(&|i| self.mass[i] * self.x[i][axis]) / mass);
        let inertia = sum(&|i| self.mass[i] * (self.x[i] - centre).norm_squared());
        let rate = angular / inertia;
        if !rate.is_finite() || rate == 0.0 {
            return;
        }
        for i in self.members {
            let arm = self.x[*i] - centre;
            velocity[*i] += Vector::<2>::new(arm[1], -arm[0]) * rate;
        }
    }
}

impl Defects {
    /// |Δm|/m before any mass was laid down where nothing lay over it.
    #[must_use]
    pub fn relative_mass(&self) -> f64 {
        self.stray_mass / self.before.mass
    }

    /// Momentum that appeared before any correction and that no held node gave, N·s: rounding, unless a node has no mass.
    #[must_use]
    pub fn momentum_defect(&self) -> Vector<2> {
        self.raw.momentum + self.held_momentum - self.before.momentum
    }

    /// Angular momentum about the origin that appeared before any correction and that no held node gave, N·m·s.
    #[must_use]
    pub fn angular_defect(&self) -> f64 {
        self.raw.angular + self.held_angular - self.before.angular
    }

    /// Kinetic energy that was lost, as a part of what there was.
    #[must_use]
    pub fn relative_loss(&self) -> f64 {
        1.0 - self.after.kinetic / self.before.kinetic
    }

    /// Of the books before and after, and what held nodes took; nothing is corrected yet.
    pub(super) fn new(before: Books, raw: Books, (x, taken): (&[Vector<2>], &[Vector<2>])) -> Self {
        let n = taken.len();
        Self {
            before,
            raw,
            after: raw,
            held_momentum: ordered_sum(n, Vector::zeros(), |i| taken[i]),
            held_angular: ordered_sum(n, 0.0, |i| moment(&x[i], &taken[i])),
            stray_mass: 0.0,
            unchanged: 0.0,
            misses: 0,
            massless: 0,
        }
    }
}
