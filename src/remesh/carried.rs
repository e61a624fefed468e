//! What a mesh of the plane carries, and what a new one carries after it.

use super::{Defects, Same, Source};
use crate::algebra::Vector;
use crate::mesh::Simplex;

/// What a mesh of the plane stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symmetry {
    /// A slice of a prism: (x, z).
    Planar,
    /// A body of revolution: (r, z), every element a ring.
    Axisymmetric,
}

/// What a mesh carries at an instant.
#[derive(Debug, Clone, Copy)]
pub struct Carried<'a> {
    /// Planar or axisymmetric.
    pub symmetry: Symmetry,
    /// Masses of the nodes, kg: the sums of the corner masses around them.
    pub mass: &'a [f64],
    /// Corner masses of the elements, kg ([`corner_masses`] at first, [`Transferred::corner_mass`] after a transfer).
    pub corner_mass: &'a [[f64; 3]],
    /// Velocities of the nodes, m/s.
    pub velocity: &'a [Vector<2>],
}

/// What a new mesh carries.
#[derive(Debug, Clone, PartialEq)]
pub struct Transferred {
    /// Where the nodes were at rest, m.
    pub rest: Vec<Vector<2>>,
    /// Masses of the nodes, m_i = ∫ρ N_i, kg.
    pub mass: Vec<f64>,
    /// Corner masses of the elements, kg.
    pub corner_mass: Vec<[f64; 3]>,
    /// Velocities of the nodes, m/s.
    pub velocity: Vec<Vector<2>>,
    /// Which directions of a node are held.
    pub held: Vec<[bool; 2]>,
    /// By new element, the old one that it is.
    pub same: Vec<Option<Same>>,
    /// What the other new elements are made of, in their order.
    pub sources: Vec<Source>,
    /// What was lost on the way.
    pub defects: Defects,
}

/// Corner masses σ_a = ∫ρ N_a of elements with given masses, kg: m/3, and m (r_a + 3r̄)/(12r̄) for a ring.
///
/// Three corner masses stand for a density that is linear in its element. That of a ring of one material grows with
/// its radius. With `x` at rest their sums are the lumped masses of the engine (numerics A1); with `x` where the nodes
/// are now, the density per volume is constant now.
#[must_use]
pub fn corner_masses(x: &[Vector<2>], elements: &[Simplex], mass: &[f64], symmetry: Symmetry) -> Vec<[f64; 3]> {
    let shares = |nodes: &Simplex| match symmetry {
        Symmetry::Planar => [1.0 / 3.0; 3],
        Symmetry::Axisymmetric => {
            let radii: [f64; 3] = std::array::from_fn(|a| x[nodes[a].index()][0]);
            let sum: f64 = radii.iter().sum();
            radii.map(|r| 0.25 * (r / sum + 1.0))
        }
    };
    elements.iter().zip(mass).map(|(nodes, m)| shares(nodes).map(|share| m * share)).collect()
}

/// Masses of the nodes, kg: the sums of the corner masses around them.
#[must_use]
pub fn nodal_masses(n_nodes: usize, elements: &[Simplex], corner_mass: &[[f64; 3]]) -> Vec<f64> {
    let mut mass = vec![0.0; n_nodes];
    for (nodes, corners) in elements.iter().zip(corner_mass) {
        for (node, corner) in nodes.iter().zip(corners) {
            mass[node.index()] += corner;
        }
    }
    mass
}

/// The density at the corners of an element times its area, kg, from its corner masses: h_a = 12σ_a − 3Σσ.
pub(super) fn heights(corner_mass: &[f64; 3]) -> [f64; 3] {
    let sum: f64 = corner_mass.iter().sum();
    corner_mass.map(|m| 12.0 * m - 3.0 * sum)
}
