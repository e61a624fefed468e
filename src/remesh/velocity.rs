//! Consistent-mass projection of the old momentum to the velocities of a new mesh.

use super::NodeOrigin;
use super::barycentric::interpolate;
use super::correspondence::{MeshCorrespondence, UnchangedElement};
use super::nodal_fields::{NodalFields, heights};
use super::overlap_moments::mass_matrix;
use super::supermesh::ElementMoments;
use crate::math::Vector;
use crate::mesh::Simplex;

/// Number of Jacobi sweeps: one from the initial velocities and three corrections (method 4.5).
const SWEEPS: usize = 4;

/// Consistent-mass projection M v = b with the lumped mass as preconditioner.
pub(super) struct MomentumProjection<'a, const D: usize> {
    /// Origins of the new nodes.
    pub origin: &'a [NodeOrigin],
    /// Old elements and their fields.
    pub old: (&'a [Simplex], &'a NodalFields<'a, D>),
    /// New elements and their correspondence to the old ones.
    pub new: (&'a [Simplex], &'a MeshCorrespondence),
    /// Integrals over the changed elements.
    pub parts: &'a [ElementMoments<D>],
    /// Masses of the new nodes, kg.
    pub mass: &'a [f64],
    /// Held directions of the new nodes.
    pub held: &'a [[bool; D]],
}

impl<const D: usize> MomentumProjection<'_, D> {
    /// Runs four Jacobi sweeps, v ← v + m⁻¹ (b − M v), except in held directions and at massless nodes; conserves Σ b.
    ///
    /// Returns the residual b − M v of the last sweep in the held directions, N·s: the momentum that they absorb.
    pub fn project_momentum(&self, velocity: &mut [Vector<D>]) -> Vec<Vector<D>> {
        let mut taken = vec![Vector::zeros(); velocity.len()];
        for _ in 0..SWEEPS {
            taken = self.residual(velocity);
            for (i, v) in velocity.iter_mut().enumerate() {
                for axis in (0..D).filter(|axis| !self.held[i][*axis]) {
                    v[axis] += self.kick(i, std::mem::take(&mut taken[i][axis]));
                }
            }
        }
        taken
    }

    /// Velocity increment of a node for its residual; −0 for a zero residual, so that no bit changes.
    fn kick(&self, node: usize, residual: f64) -> f64 {
        if residual == 0.0 || self.mass[node] <= 0.0 { -0.0 } else { residual / self.mass[node] }
    }

    /// Residual b − M v, N·s. For an unchanged element it is M (v_old − v), exactly zero where v is the old velocity.
    fn residual(&self, velocity: &[Vector<D>]) -> Vec<Vector<D>> {
        let mut residual = vec![Vector::<D>::zeros(); velocity.len()];
        let lags = |(v, origin): (&Vector<D>, &NodeOrigin)| match origin {
            NodeOrigin::Kept(was) => self.old.1.velocity[was.index()] != *v,
            // No unchanged element has boundary or interior points as nodes.
            NodeOrigin::Surface(..) | NodeOrigin::Inside => false,
        };
        let lags: Vec<bool> = velocity.iter().zip(self.origin).map(lags).collect();
        let n_same = if lags.contains(&true) { self.new.0.len() } else { 0 };
        for (nodes, same) in self.new.0.iter().zip(&self.new.1.same).take(n_same) {
            let Some(same) = same.filter(|_| nodes[..=D].iter().any(|node| lags[node.index()])) else { continue };
            let velocity_lag = self.velocity_lag(nodes, same, velocity);
            if velocity_lag == [Vector::<D>::zeros(); 4] {
                continue;
            }
            let m = mass_matrix::<D>(&heights::<D>(&same.turned(&self.old.1.corner_mass[same.element.index()])));
            for (node, row) in nodes[..=D].iter().zip(&m) {
                residual[node.index()] += interpolate(&velocity_lag, row);
            }
        }
        for part in self.parts {
            let nodes = &self.new.0[part.element];
            let own = nodes.map(|node| velocity[node.index()]);
            for ((node, row), momentum) in nodes[..=D].iter().zip(&part.mass_matrix).zip(part.momentum) {
                residual[node.index()] += momentum - interpolate(&own, row);
            }
        }
        residual
    }

    /// v_old − v at the corners of an unchanged element; zero at the fourth in the plane.
    fn velocity_lag(&self, nodes: &Simplex, same: UnchangedElement, velocity: &[Vector<D>]) -> [Vector<D>; 4] {
        let old = same.turned(&self.old.0[same.element.index()]);
        let mut velocity_lag = [Vector::<D>::zeros(); 4];
        for (velocity_lag, (was, now)) in velocity_lag.iter_mut().zip(old.iter().zip(&nodes[..=D])) {
            *velocity_lag = self.old.1.velocity[was.index()] - velocity[now.index()];
        }
        velocity_lag
    }
}
