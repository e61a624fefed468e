//! Nodal fields of a mesh before and after a transfer.

use super::{ConservationDefects, OverlapSource, UnchangedElement};
use crate::math::Vector;
use crate::mesh::Simplex;

/// Symmetry of the body that the mesh represents.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodySymmetry {
    /// Slice of a prism: (x, z).
    Planar,
    /// Body of revolution: (r, z), every element a ring.
    Axisymmetric,
    /// Body in space.
    Spatial,
}

/// Fields of a mesh at one time.
#[derive(Debug, Clone, Copy)]
pub struct NodalFields<'a, const D: usize> {
    /// Symmetry of the body.
    pub symmetry: BodySymmetry,
    /// Nodal masses, kg: the sums of the adjacent corner masses.
    pub mass: &'a [f64],
    /// Corner masses of the elements, kg: [`corner_masses`] initially, [`TransferredFields::corner_mass`] after a transfer.
    pub corner_mass: &'a [[f64; 4]],
    /// Nodal velocities, m/s.
    pub velocity: &'a [Vector<D>],
    /// True to limit negative densities of removed elements towards their mean; momentum is conserved.
    pub is_level: bool,
}

/// Fields of a new mesh after a transfer.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferredFields<const D: usize> {
    /// Rest positions of the nodes, m.
    pub rest: Vec<Vector<D>>,
    /// Nodal masses, m_i = ∫ρ N_i, kg.
    pub mass: Vec<f64>,
    /// Corner masses of the elements, kg; the fourth is 0 in the plane.
    pub corner_mass: Vec<[f64; 4]>,
    /// Nodal velocities, m/s.
    pub velocity: Vec<Vector<D>>,
    /// Held directions of the nodes.
    pub held: Vec<[bool; D]>,
    /// Old element of each unchanged new element.
    pub same: Vec<Option<UnchangedElement>>,
    /// Sources of the changed elements, in their order.
    pub sources: Vec<OverlapSource>,
    /// Conservation defects of the transfer.
    pub defects: ConservationDefects<D>,
}

/// Corner masses σ_a = ∫ρ N_a of elements with given masses, kg: m/3, m (r_a + 3r̄)/(12r̄) of a ring, and m/4 in space;
/// the fourth is 0 in the plane.
///
/// The corner masses represent a density that is linear in the element; that of a homogeneous ring grows with its
/// radius. With `x` at rest their sums are the lumped masses of the solver (method A1); with current positions `x`
/// the current volumetric density is constant.
#[must_use]
pub fn corner_masses<const D: usize>(
    x: &[Vector<D>],
    elements: &[Simplex],
    mass: &[f64],
    symmetry: BodySymmetry,
) -> Vec<[f64; 4]> {
    let shares = |nodes: &Simplex| match symmetry {
        BodySymmetry::Planar => [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0],
        BodySymmetry::Axisymmetric => {
            let radii: [f64; 3] = std::array::from_fn(|a| x[nodes[a].index()][0]);
            let sum: f64 = radii.iter().sum();
            let [a, b, c] = radii.map(|r| 0.25 * (r / sum + 1.0));
            [a, b, c, 0.0]
        }
        BodySymmetry::Spatial => [0.25; 4],
    };
    elements.iter().zip(mass).map(|(nodes, m)| shares(nodes).map(|share| m * share)).collect()
}

/// Limits corner masses to a nowhere negative density if their sum is positive: the density is scaled about its mean
/// until its minimum is zero. Mass is conserved, the centre of mass is not. An element of zero or negative mass is left
/// unchanged.
pub(super) fn limited_corner_masses<const D: usize>(corner_mass: &[f64; 4]) -> [f64; 4] {
    let mut level = *corner_mass;
    if let Some(part) = limiting_scale::<D>(corner_mass) {
        let mean = corner_mass[..=D].iter().sum::<f64>() / (D + 1) as f64;
        level[..=D].iter_mut().for_each(|corner| *corner = mean + part * (*corner - mean));
    }
    level
}

/// Greatest scale about the mean that leaves no corner density negative, h̄/(h̄ − min h); none if no scaling is needed
/// or the mass is not positive.
pub(super) fn limiting_scale<const D: usize>(corner_mass: &[f64; 4]) -> Option<f64> {
    // The mean of density times measure is the mass.
    let (whole, least) = (corner_mass[..=D].iter().sum::<f64>(), least_height::<D>(corner_mass));
    (whole > 0.0 && least < 0.0).then(|| whole / (whole - least))
}

/// Least corner density times the measure of the element, kg.
pub(super) fn least_height<const D: usize>(corner_mass: &[f64; 4]) -> f64 {
    heights::<D>(corner_mass)[..=D].iter().copied().fold(f64::INFINITY, f64::min)
}

/// Nodal masses, kg: the sums of the adjacent corner masses.
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

/// Least mass of a node of a changed element, relative to an even share of its elements' masses. It is 0 if a changed
/// element has no positive mass: its nodes then borrow mass from their neighbours, and lose it when those are removed.
#[must_use]
pub fn least_relative_mass<const D: usize>(elements: &[Simplex], new: &TransferredFields<D>) -> f64 {
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

/// Corner densities times measure, kg, from corner masses: h_a = (D + 1)[(D + 2)σ_a − Σσ]; the fourth is 0 in the
/// plane.
pub(super) fn heights<const D: usize>(corner_mass: &[f64; 4]) -> [f64; 4] {
    let [n, more] = [(D + 1) as f64, (D + 2) as f64];
    let sum: f64 = corner_mass[..=D].iter().sum();
    let mut heights = [0.0; 4];
    for (height, m) in heights[..=D].iter_mut().zip(corner_mass) {
        *height = n * more * m - n * sum;
    }
    heights
}
