//! Stable time step of the assembled system: the nodal rule of the critical step (method 1.3).

use super::element_order::ElementLayout;
use super::{DiscreteGel, TickGrid, UnusableStep};
use crate::fem::Potential;
use crate::math::least;
use crate::mesh::{ElementId, NodeId};

/// Returns the stable step of each element, CFL · min over its nodes a of 2/√λ_a, s, with λ_a = Σ_{K∋a} κ_K/m_a.
///
/// λ_a bounds the spectrum of the *assembled* system (1.3c): K = Σ K_K ≤ Σ κ_K 1_K = diag(λ_a m_a).
pub(super) fn stable_steps<const D: usize, P: Potential<D>>(
    gel: &DiscreteGel<D, P>,
    stiffness: &[f64],
    cfl: f64,
) -> Vec<f64> {
    let sum = |node| gel.star.of(node).iter().map(|element| stiffness[element.index()]).sum();
    let limit_of = |a: usize| cfl * nodal_step_limit(sum(NodeId(a as u32)), gel.mass[a]);
    let limits: Vec<f64> = (0..gel.mass.len()).map(limit_of).collect();
    let least_limit = |nodes: &[NodeId]| nodes.iter().map(|node| limits[node.index()]).fold(f64::INFINITY, f64::min);
    (0..gel.potential.len() as u32).map(|element| least_limit(gel.potential.nodes(ElementId(element)))).collect()
}

/// Returns the nodal stability limit 2/√λ_a, s, from Σ κ_K and m_a.
#[inline]
pub(super) fn nodal_step_limit(stiffness: f64, mass: f64) -> f64 {
    2.0 / (stiffness / mass).sqrt()
}

/// Returns the nodal stability limit 2/√λ_a, s, summed over the elements of the node in ascending order (A8).
pub(super) fn nodal_limit<const D: usize, P: Potential<D>>(
    gel: &DiscreteGel<D, P>,
    stiffness: &[f64],
    layout: &ElementLayout,
    node: NodeId,
) -> f64 {
    nodal_step_limit(
        gel.star.of(node).iter().map(|element| stiffness[layout.slot(*element)]).sum(),
        gel.mass[node.index()],
    )
}

/// Returns the given grid, or a new one for these stable steps, s, and the shortest step, ticks.
pub(super) fn tick_grid(steps: &[f64], grid: Option<TickGrid>) -> Result<(TickGrid, f64), UnusableStep> {
    let step = steps.iter().copied().fold(f64::INFINITY, least);
    if !step.is_normal() {
        return Err(UnusableStep { step, corners: vec![] });
    }
    let grid = grid.unwrap_or_else(|| TickGrid::new(steps));
    Ok((grid, grid.ticks(step)))
}
