//! Responses of elements and patches: forces, stiffness bound, energy and dissipation.

use super::MAX_NODES;
use crate::math::Vector;

/// Energy of a patch, and its dissipation since its last tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Dissipation {
    /// Energy V, J.
    pub energy: f64,
    /// Dissipation by the dashpots of branches, J.
    pub viscous: f64,
    /// Dissipation by bulk viscosity, J.
    pub bulk: f64,
    /// Stored energy released by damage, J.
    pub damage: f64,
}

impl std::ops::AddAssign for Dissipation {
    fn add_assign(&mut self, other: Self) {
        self.energy += other.energy;
        self.viscous += other.viscous;
        self.bulk += other.bulk;
        self.damage += other.damage;
    }
}

/// Response of an element at one position of its nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementResponse<const D: usize> {
    /// Nodal forces −∂V/∂x, N: the share of this element in the energy V of its patch.
    pub forces: [Vector<D>; MAX_NODES],
    /// Upper bound κ of the greatest eigenvalue of the element's share of the stiffness matrix ∂²V/∂x∂x, N/m.
    pub stiffness: f64,
    /// J = det F.
    pub jacobian: f64,
}

impl<const D: usize> Default for ElementResponse<D> {
    fn default() -> Self {
        Self { forces: [Vector::zeros(); MAX_NODES], stiffness: 0.0, jacobian: 1.0 }
    }
}

/// Responses of all elements at one position of the nodes, without the forces.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementStates {
    /// κ of each element, N/m.
    pub stiffness: Vec<f64>,
    /// J of each element.
    pub jacobian: Vec<f64>,
    /// V of each patch, J.
    pub energy: Vec<f64>,
}

impl ElementStates {
    /// Creates the states of `n_elements` elements in `n_patches` patches, all at rest.
    pub(super) fn at_rest(n_elements: usize, n_patches: usize) -> Self {
        Self { stiffness: vec![0.0; n_elements], jacobian: vec![1.0; n_elements], energy: vec![0.0; n_patches] }
    }
}
