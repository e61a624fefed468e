//! Velocities of a new mesh that have the momentum of the old one.

use super::Origin;
use super::barycentric::weighed;
use super::correspondence::{Pairing, Same};
use super::nodal_fields::{Carried, heights};
use super::overlap_integrals::inertia;
use super::supermesh::Part;
use crate::math::Vector;
use crate::mesh::Simplex;

/// Sweeps: one from the guess and three corrections (numerics 4.5).
const SWEEPS: usize = 4;

/// What the velocities of a new mesh have to satisfy, M v = b.
pub(super) struct Balance<'a, const D: usize> {
    /// Where the new nodes come from.
    pub origin: &'a [Origin],
    /// The old elements and what they carry.
    pub old: (&'a [Simplex], &'a Carried<'a, D>),
    /// The new elements and what they are.
    pub new: (&'a [Simplex], &'a Pairing),
    /// The new elements that are not old ones.
    pub parts: &'a [Part<D>],
    /// Masses of the new nodes, kg.
    pub mass: &'a [f64],
    /// Which directions of the new nodes are held.
    pub held: &'a [[bool; D]],
}

impl<const D: usize> Balance<'_, D> {
    /// Sweeps velocities, v ← v + m⁻¹ (b − M v), those of held directions and of nodes without mass excepted.
    ///
    /// Returns the b − M v of the last sweep in the held directions, N·s: what they took from the momentum.
    pub fn sweep(&self, velocity: &mut [Vector<D>]) -> Vec<Vector<D>> {
        let mut taken = vec![Vector::zeros(); velocity.len()];
        for _ in 0..SWEEPS {
            taken = self.missing(velocity);
            for (i, v) in velocity.iter_mut().enumerate() {
                for axis in (0..D).filter(|axis| !self.held[i][*axis]) {
                    v[axis] += self.kick(i, std::mem::take(&mut taken[i][axis]));
                }
            }
        }
        taken
    }

    /// The change of velocity of a node for what it misses; −0 where it misses nothing, so that no bit changes.
    fn kick(&self, node: usize, missing: f64) -> f64 {
        if missing == 0.0 || self.mass[node] <= 0.0 { -0.0 } else { missing / self.mass[node] }
    }

    /// b − M v, N·s. Of an unchanged element that is M (v_old − v), which is exactly nothing where v is the old one.
    fn missing(&self, velocity: &[Vector<D>]) -> Vec<Vector<D>> {
        let mut missing = vec![Vector::<D>::zeros(); velocity.len()];
        let lags = |(v, origin): (&Vector<D>, &Origin)| match origin {
            Origin::Kept(was) => self.old.1.velocity[was.index()] != *v,
            // No unchanged element has them.
            Origin::Surface(..) | Origin::Inside => false,
        };
        let lags: Vec<bool> = velocity.iter().zip(self.origin).map(lags).collect();
        let n_same = if lags.contains(&true) { self.new.0.len() } else { 0 };
        for (nodes, same) in self.new.0.iter().zip(&self.new.1.same).take(n_same) {
            let Some(same) = same.filter(|_| nodes[..=D].iter().any(|node| lags[node.index()])) else { continue };
            let lag = self.lag(nodes, same, velocity);
            if lag == [Vector::<D>::zeros(); 4] {
                continue;
            }
            let m = inertia::<D>(&heights::<D>(&same.turned(&self.old.1.corner_mass[same.element.index()])));
            for (node, row) in nodes[..=D].iter().zip(&m) {
                missing[node.index()] += weighed(&lag, row);
            }
        }
        for part in self.parts {
            let nodes = &self.new.0[part.element];
            let own = nodes.map(|node| velocity[node.index()]);
            for ((node, row), momentum) in nodes[..=D].iter().zip(&part.inertia).zip(part.momentum) {
                missing[node.index()] += momentum - weighed(&own, row);
            }
        }
        missing
    }

    /// v_old − v at the corners of an unchanged element; none at a fourth of the plane.
    fn lag(&self, nodes: &Simplex, same: Same, velocity: &[Vector<D>]) -> [Vector<D>; 4] {
        let old = same.turned(&self.old.0[same.element.index()]);
        let mut lag = [Vector::<D>::zeros(); 4];
        for (lag, (was, now)) in lag.iter_mut().zip(old.iter().zip(&nodes[..=D])) {
            *lag = self.old.1.velocity[was.index()] - velocity[now.index()];
        }
        lag
    }
}
