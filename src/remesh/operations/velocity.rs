//! Velocities after an operation: momentum by a uniform shift, angular momentum by a rotation, and kinetic energy by
//! one factor on the velocities relative to both.

use super::editable_mesh::EditableMesh;
use crate::math::Vector;
use crate::mesh::NodeId;
use crate::remesh::BodySymmetry;
use crate::remesh::conservation::{ConservedTotals, NodeGroup};

/// Greatest factor on the relative velocities, and the inverse of the least. The prototype's value
/// ([`super::improvement`]); assumed, not measured.
const MAX_FACTOR: f64 = 1.5;

impl<const D: usize> EditableMesh<'_, D> {
    /// Momentum and kinetic energy of these nodes.
    pub(super) fn motion(&self, nodes: &[NodeId]) -> ConservedTotals<D> {
        // A node that is about to be made moves nothing yet.
        let all = || nodes.iter().map(|node| node.index()).filter(|node| *node < self.nodes.len());
        let position: Vec<_> = all().map(|node| self.nodes[node].position).collect();
        let velocity: Vec<_> = all().map(|node| self.nodes[node].velocity).collect();
        let mass: Vec<f64> = all().map(|node| self.mass[node]).collect();
        ConservedTotals::of(&position, &mass, &velocity)
    }
}

/// Gives the nodes of a cavity the momentum, the angular momentum and the kinetic energy that they had `before`;
/// returns the change of kinetic energy that remains, J. Held nodes keep their velocity in held directions.
pub(super) fn keep_motion<const D: usize>(
    mesh: &mut EditableMesh<'_, D>,
    touched: &[NodeId],
    before: &ConservedTotals<D>,
) -> f64 {
    let nodes: Vec<NodeId> = touched.iter().copied().filter(|node| mesh.mass[node.index()] > 0.0).collect();
    let mut cavity = CavityMotion::of(mesh, &nodes);
    let momentum = cavity.totals().momentum;
    for axis in 0..D {
        let free = || (0..nodes.len()).filter(|k| !mesh.held[nodes[*k].index()][axis]);
        let mass = free().map(|k| cavity.mass[k]).sum::<f64>();
        let defect = before.momentum[axis] - momentum[axis];
        if mass > 0.0 {
            free().for_each(|k| cavity.velocity[k][axis] += defect / mass);
        }
    }
    if cavity.turns {
        let now = cavity.totals().angular;
        let mut velocity = std::mem::take(&mut cavity.velocity);
        cavity.group().add_rotation(&mut velocity, &(before.angular - now));
        cavity.velocity = velocity;
    }
    cavity.scale_relative(before.kinetic);
    let change = cavity.totals().kinetic - before.kinetic;
    for (node, velocity) in nodes.iter().zip(cavity.velocity) {
        mesh.nodes[node.index()].velocity = velocity;
    }
    change
}

/// Motion of the nodes of a cavity.
struct CavityMotion<const D: usize> {
    position: Vec<Vector<D>>,
    velocity: Vec<Vector<D>>,
    mass: Vec<f64>,
    members: Vec<usize>,
    /// True for each axis along which the cavity can move as a whole.
    is_free: [bool; D],
    /// True if it can turn as a whole.
    turns: bool,
}

impl<const D: usize> CavityMotion<D> {
    fn of(mesh: &EditableMesh<'_, D>, nodes: &[NodeId]) -> Self {
        let is_ring = mesh.symmetry == BodySymmetry::Axisymmetric;
        let is_held = |axis: usize| nodes.iter().any(|node| mesh.held[node.index()][axis]);
        let is_free = std::array::from_fn(|axis| !(is_held(axis) || is_ring && axis == 0));
        Self {
            position: nodes.iter().map(|node| mesh.nodes[node.index()].position).collect(),
            velocity: nodes.iter().map(|node| mesh.nodes[node.index()].velocity).collect(),
            mass: nodes.iter().map(|node| mesh.mass[node.index()]).collect(),
            members: (0..nodes.len()).collect(),
            is_free,
            turns: is_free == [true; D],
        }
    }

    fn totals(&self) -> ConservedTotals<D> {
        ConservedTotals::of(&self.position, &self.mass, &self.velocity)
    }

    fn group(&self) -> NodeGroup<'_, D> {
        NodeGroup { x: &self.position, mass: &self.mass, members: &self.members }
    }

    /// Scales the velocities relative to the rigid motion of the cavity, so that its kinetic energy is `kinetic`, J.
    fn scale_relative(&mut self, kinetic: f64) {
        let rigid = self.rigid_velocities();
        let energy = |velocity: &dyn Fn(usize) -> Vector<D>| {
            self.members.iter().map(|k| 0.5 * self.mass[*k] * velocity(*k).norm_squared()).sum::<f64>()
        };
        let (of_rigid, of_relative) = (energy(&|k| rigid[k]), energy(&|k| self.velocity[k] - rigid[k]));
        let factor = ((kinetic - of_rigid).max(0.0) / of_relative).sqrt().clamp(1.0 / MAX_FACTOR, MAX_FACTOR);
        if factor.is_finite() {
            for (velocity, rigid) in self.velocity.iter_mut().zip(rigid) {
                *velocity = rigid + (*velocity - rigid) * factor;
            }
        }
    }

    /// Velocities of the rigid motion with the momentum and the angular momentum of the cavity.
    fn rigid_velocities(&self) -> Vec<Vector<D>> {
        let whole = self.mass.iter().sum::<f64>();
        let momentum = self.totals().momentum;
        let mean = Vector::<D>::from_fn(|axis, _| if self.is_free[axis] { momentum[axis] / whole } else { 0.0 });
        let mut rigid = vec![mean; self.velocity.len()];
        if self.turns {
            let relative: Vec<Vector<D>> = self.velocity.iter().map(|v| v - mean).collect();
            let spin = ConservedTotals::of(&self.position, &self.mass, &relative).angular;
            self.group().add_rotation(&mut rigid, &spin);
        }
        rigid
    }
}
