//! Conservation report of a field transfer: mass, momentum, angular momentum and kinetic energy.

use crate::math::{Tensor3, Vector, Vector3, cofactor, det, embed, ordered_sum, restrict};

/// Totals of moving masses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConservedTotals<const D: usize> {
    /// Mass, kg.
    pub mass: f64,
    /// Momentum, N·s; in an axisymmetric body only its z component is meaningful.
    pub momentum: Vector<D>,
    /// Angular momentum about the origin, Σ m x × v, N·m·s: in the plane that about y; meaningless in an axisymmetric
    /// body.
    pub angular: Vector3,
    /// Kinetic energy, J.
    pub kinetic: f64,
}

/// Conservation defects of a transfer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConservationDefects<const D: usize> {
    /// Totals of the old mesh.
    pub before: ConservedTotals<D>,
    /// Totals of the new mesh before any correction.
    pub raw: ConservedTotals<D>,
    /// Totals of the new mesh after the correction of the angular momentum.
    pub after: ConservedTotals<D>,
    /// Momentum absorbed by held nodes, N·s: `before.momentum − raw.momentum`, up to rounding.
    pub held_momentum: Vector<D>,
    /// Angular momentum about the origin absorbed by held nodes, N·m·s; the correction does not restore it.
    pub held_angular: Vector3,
    /// Old mass that new elements leave uncovered or cover twice, kg; it is deposited at the nearest position.
    pub stray_mass: f64,
    /// Fraction of new elements that are unchanged old elements.
    pub unchanged: f64,
    /// Number of new nodes outside the old mesh; they take the fields of its nearest point.
    pub misses: usize,
    /// Number of nodes without mass; a mesh that has one must be rejected.
    pub massless: usize,
}

impl<const D: usize> ConservedTotals<D> {
    /// Computes the totals of nodes with masses and velocities.
    #[must_use]
    pub fn of(x: &[Vector<D>], mass: &[f64], velocity: &[Vector<D>]) -> Self {
        let n = mass.len();
        Self {
            mass: ordered_sum(n, 0.0, |i| mass[i]),
            momentum: ordered_sum(n, Vector::zeros(), |i| velocity[i] * mass[i]),
            angular: ordered_sum(n, Vector3::zeros(), |i| moment_about_origin(&x[i], &velocity[i]) * mass[i]),
            kinetic: ordered_sum(n, 0.0, |i| 0.5 * mass[i] * velocity[i].norm_squared()),
        }
    }
}

/// Moment of a vector about the origin, x × v.
fn moment_about_origin<const D: usize>(x: &Vector<D>, v: &Vector<D>) -> Vector3 {
    embed(x).cross(&embed(v))
}

/// Group of moving nodes of a planar or spatial body.
pub(super) struct NodeGroup<'a, const D: usize> {
    pub x: &'a [Vector<D>],
    pub mass: &'a [f64],
    /// Indices of the nodes.
    pub members: &'a [usize],
}

impl<const D: usize> NodeGroup<'_, D> {
    /// Adds the rigid rotation about the centre of mass that has this angular momentum, N·m·s.
    ///
    /// The rotation carries no momentum. Coincident nodes do not turn, nor do collinear nodes in space.
    pub fn add_rotation(&self, velocity: &mut [Vector<D>], angular: &Vector3) {
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

    /// Angular velocity ω of Θ ω = L, Θ = Σ m (|r|² 1 − r ⊗ r) about the centre; in the plane ω_y = L_y/Σ m |r|².
    pub fn rate(&self, centre: &Vector<D>, angular: &Vector3) -> Vector3 {
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

impl<const D: usize> ConservationDefects<D> {
    /// Relative mass defect |Δm|/m before uncovered mass was deposited.
    #[must_use]
    pub fn relative_mass(&self) -> f64 {
        self.stray_mass / self.before.mass
    }

    /// Momentum defect, N·s, before any correction and beyond the momentum of held nodes: rounding, unless a node has
    /// no mass.
    #[must_use]
    pub fn momentum_defect(&self) -> Vector<D> {
        self.raw.momentum + self.held_momentum - self.before.momentum
    }

    /// Angular momentum defect about the origin, N·m·s, before any correction and beyond that of held nodes.
    #[must_use]
    pub fn angular_defect(&self) -> Vector3 {
        self.raw.angular + self.held_angular - self.before.angular
    }

    /// Relative loss of kinetic energy.
    #[must_use]
    pub fn relative_loss(&self) -> f64 {
        1.0 - self.after.kinetic / self.before.kinetic
    }

    /// Builds the report from the totals before and after, and the momentum that held nodes absorbed; nothing is
    /// corrected yet.
    pub(super) fn new(
        before: ConservedTotals<D>,
        raw: ConservedTotals<D>,
        (x, taken): (&[Vector<D>], &[Vector<D>]),
    ) -> Self {
        let n = taken.len();
        Self {
            before,
            raw,
            after: raw,
            held_momentum: ordered_sum(n, Vector::zeros(), |i| taken[i]),
            held_angular: ordered_sum(n, Vector3::zeros(), |i| moment_about_origin(&x[i], &taken[i])),
            stray_mass: 0.0,
            unchanged: 0.0,
            misses: 0,
            massless: 0,
        }
    }
}
