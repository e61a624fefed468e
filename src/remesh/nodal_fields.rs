//! What a mesh carries, and what a new one carries after it.

use super::{Defects, Same, Source};
use crate::math::Vector;
use crate::mesh::Simplex;

/// What a mesh stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symmetry {
    /// A slice of a prism: (x, z).
    Planar,
    /// A body of revolution: (r, z), every element a ring.
    Axisymmetric,
    /// The body itself.
    Spatial,
}

/// What a mesh carries at an instant.
#[derive(Debug, Clone, Copy)]
pub struct Carried<'a, const D: usize> {
    /// What the mesh stands for.
    pub symmetry: Symmetry,
    /// Masses of the nodes, kg: the sums of the corner masses around them.
    pub mass: &'a [f64],
    /// Corner masses of the elements, kg ([`corner_masses`] at first, [`Transferred::corner_mass`] after a transfer).
    pub corner_mass: &'a [[f64; 4]],
    /// Velocities of the nodes, m/s.
    pub velocity: &'a [Vector<D>],
    /// Whether the density of what is gone is drawn to its mean where it would be below nothing; momentum stays.
    pub is_level: bool,
}

/// What a new mesh carries.
#[derive(Debug, Clone, PartialEq)]
pub struct Transferred<const D: usize> {
    /// Where the nodes were at rest, m.
    pub rest: Vec<Vector<D>>,
    /// Masses of the nodes, m_i = ∫ρ N_i, kg.
    pub mass: Vec<f64>,
    /// Corner masses of the elements, kg; 0 of a fourth corner in the plane.
    pub corner_mass: Vec<[f64; 4]>,
    /// Velocities of the nodes, m/s.
    pub velocity: Vec<Vector<D>>,
    /// Which directions of a node are held.
    pub held: Vec<[bool; D]>,
    /// By new element, the old one that it is.
    pub same: Vec<Option<Same>>,
    /// What the other new elements are made of, in their order.
    pub sources: Vec<Source>,
    /// What was lost on the way.
    pub defects: Defects<D>,
}

/// Corner masses σ_a = ∫ρ N_a of elements with given masses, kg: m/3, m (r_a + 3r̄)/(12r̄) of a ring, and m/4 in space; 0 of a
/// fourth corner in the plane.
///
/// As many corner masses as there are corners stand for a density that is linear in its element. That of a ring of one
/// material grows with its radius. With `x` at rest their sums are the lumped masses of the engine (numerics A1); with `x`
/// where the nodes are now, the density per volume is constant now.
#[must_use]
pub fn corner_masses<const D: usize>(
    x: &[Vector<D>],
    elements: &[Simplex],
    mass: &[f64],
    symmetry: Symmetry,
) -> Vec<[f64; 4]> {
    let shares = |nodes: &Simplex| match symmetry {
        Symmetry::Planar => [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0],
        Symmetry::Axisymmetric => {
            let radii: [f64; 3] = std::array::from_fn(|a| x[nodes[a].index()][0]);
            let sum: f64 = radii.iter().sum();
            let [a, b, c] = radii.map(|r| 0.25 * (r / sum + 1.0));
            [a, b, c, 0.0]
        }
        Symmetry::Spatial => [0.25; 4],
    };
    elements.iter().zip(mass).map(|(nodes, m)| shares(nodes).map(|share| m * share)).collect()
}

/// Corner masses of the same whole whose density is nowhere below nothing, if that weighs something: where it would be, it is drawn to its
/// mean until it is nothing at the worst corner. The mass stays, its centre does not. What weighs nothing or less stays as it is: its mean
/// is no better.
pub(super) fn levelled<const D: usize>(corner_mass: &[f64; 4]) -> [f64; 4] {
    let mut level = *corner_mass;
    if let Some(part) = bearable_part::<D>(corner_mass) {
        let mean = corner_mass[..=D].iter().sum::<f64>() / (D + 1) as f64;
        level[..=D].iter_mut().for_each(|corner| *corner = mean + part * (*corner - mean));
    }
    level
}

/// The part of what corners differ from their mean by that leaves a density below nothing at none of them, h̄/(h̄ − min h); nothing if
/// all of it does, or the whole weighs nothing or less.
pub(super) fn bearable_part<const D: usize>(corner_mass: &[f64; 4]) -> Option<f64> {
    // The mean of the density times measure is the mass.
    let (whole, least) = (corner_mass[..=D].iter().sum::<f64>(), least_height::<D>(corner_mass));
    (whole > 0.0 && least < 0.0).then(|| whole / (whole - least))
}

/// The least density at a corner of an element times its measure, kg.
pub(super) fn least_height<const D: usize>(corner_mass: &[f64; 4]) -> f64 {
    heights::<D>(corner_mass)[..=D].iter().copied().fold(f64::INFINITY, f64::min)
}

/// Masses of the nodes, kg: the sums of the corner masses around them.
#[must_use]
pub fn nodal_masses<const D: usize>(n_nodes: usize, elements: &[Simplex], corner_mass: &[[f64; 4]]) -> Vec<f64> {
    let mut mass = vec![0.0; n_nodes];
    for (nodes, corners) in elements.iter().zip(corner_mass) {
        for (node, corner) in nodes[..=D].iter().zip(corners) {
            mass[node.index()] += corner;
        }
    }
    mass
}

/// The least mass of a node of a changed element, as a part of an even share of what its elements weigh; 0 if a changed element weighs
/// nothing or less: its nodes have the mass of others around them then, and none as soon as those are gone.
#[must_use]
pub fn lightest<const D: usize>(elements: &[Simplex], new: &Transferred<D>) -> f64 {
    let even = |own: &[f64; 4]| [own[..=D].iter().sum::<f64>() / (D + 1) as f64; 4];
    let even: Vec<[f64; 4]> = new.corner_mass.iter().map(even).collect();
    let shares = nodal_masses::<D>(new.mass.len(), elements, &even);
    let changed = elements.iter().zip(&even).zip(&new.same).filter(|(_, same)| same.is_none()).map(|(own, _)| own);
    let least = |nodes: &Simplex| {
        let parts = nodes[..=D].iter().map(|node| new.mass[node.index()] / shares[node.index()]);
        parts.fold(f64::INFINITY, f64::min)
    };
    changed.map(|(nodes, even)| if even[0] > 0.0 { least(nodes) } else { 0.0 }).fold(f64::INFINITY, f64::min)
}

/// The density at the corners of an element times its measure, kg, from its corner masses: h_a = (D + 1)[(D + 2)σ_a − Σσ]; 0
/// of a fourth corner in the plane.
pub(super) fn heights<const D: usize>(corner_mass: &[f64; 4]) -> [f64; 4] {
    let [n, more] = [(D + 1) as f64, (D + 2) as f64];
    let sum: f64 = corner_mass[..=D].iter().sum();
    let mut heights = [0.0; 4];
    for (height, m) in heights[..=D].iter_mut().zip(corner_mass) {
        *height = n * more * m - n * sum;
    }
    heights
}
