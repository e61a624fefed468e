//! Self-overlap of a body whose surfaces have passed through each other.

use super::DeformedMesh;
use super::barycentric::{DeformedElement, cells};
use super::overlap_integrals::OverlapIntegrator;
use super::point_location::ElementLocator;
use crate::geometry::BoundingBox;
use crate::math::Vector;
use crate::mesh::{Simplex, signed_volume};

/// Overlap, relative to an element, below which it is rounding.
const ROUNDING: f64 = 1e-9;
/// Weights of adjacent elements, which only touch, are below this.
const TOUCHING: f64 = 1e-12;

/// Integrates ∫ρ over the overlaps of all pairs of elements; the density is interpolated linearly in each. The search
/// runs only if a surface node is inside a foreign element: crossings at edges alone are missed.
#[must_use]
pub fn self_overlap_mass<const D: usize>(body: &DeformedMesh<'_, D>, density: impl Fn(&Vector<D>) -> f64) -> f64 {
    let elements = &body.mesh.elements;
    let cells = cells(body.position, elements.iter());
    let locator = ElementLocator::new(&cells);
    if !passes_through(body, &cells, &locator) {
        return 0.0;
    }
    let mut cutter = OverlapIntegrator::default();
    let mut sum = 0.0;
    for (e, (cell, nodes)) in cells.iter().zip(elements).enumerate().filter(|(_, (cell, _))| cell.is_upright) {
        let measure = signed_volume(body.position, nodes);
        let at = |a: usize| if a <= D { measure * density(&cell.corners[a]) } else { 0.0 };
        let heights = [0, 1, 2, 3].map(at);
        locator.near(&cell.bounds(), |other| {
            let apart = || cell.is_beside(&cells[other], TOUCHING) || cells[other].is_beside(cell, TOUCHING);
            if other > e && !are_neighbours::<D>(nodes, &elements[other]) && cells[other].is_upright && !apart() {
                let common = cutter.moments(cell, &heights, &cells[other]);
                let common = common.map_or(0.0, |common| common.corner_mass.iter().sum());
                sum += if common > ROUNDING * heights[0].abs() { common } else { 0.0 };
            }
        });
    }
    sum
}

/// Returns true if a surface node is well inside an element that does not contain it.
fn passes_through<const D: usize>(
    body: &DeformedMesh<'_, D>,
    cells: &[DeformedElement<D>],
    locator: &ElementLocator<'_, D>,
) -> bool {
    let mut nodes: Vec<u32> = body.mesh.facets.iter().flatten().map(|node| node.0).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.into_iter().any(|node| {
        let p = &body.position[node as usize];
        let mut is_inside = false;
        locator.near(&BoundingBox { low: *p, high: *p }, |t| {
            let own = body.mesh.elements[t][..=D].iter().any(|corner| corner.0 == node);
            let weights = cells[t].weights(p);
            is_inside |= !own && cells[t].is_upright && weights[..=D].iter().all(|weight| *weight > ROUNDING);
        });
        is_inside
    })
}

/// Returns true if two elements share all nodes but one.
fn are_neighbours<const D: usize>(a: &Simplex, b: &Simplex) -> bool {
    a[..=D].iter().filter(|node| b[..=D].contains(node)).count() >= D
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{BlockSpec, CellSplit, Mesh, block, uniform};

    /// Two blocks of edge 1, the second pushed into the first.
    fn two<const D: usize>(one: &Mesh<D>, into: &Vector<D>) -> (Mesh<D>, Vec<Vector<D>>) {
        let n = one.rest.len() as u32;
        let rest: Vec<Vector<D>> = one.rest.iter().copied().chain(one.rest.iter().map(|x| x + into)).collect();
        let shifted = |e: &Simplex| e.map(|node| crate::mesh::NodeId(node.0 + n));
        let elements = one.elements.iter().copied().chain(one.elements.iter().map(shifted)).collect();
        (Mesh::new(rest.clone(), elements), rest)
    }

    #[test]
    fn the_overlap_of_two_blocks_is_computed_exactly() {
        let planes = || uniform(0.0, 1.0, 0.25);
        let solid =
            block(BlockSpec { planes: [planes(), planes(), planes()], split: CellSplit::Centred, faces: vec![] });
        let flat = block(BlockSpec { planes: [planes(), planes()], split: CellSplit::Centred, faces: vec![] });
        for (shift, common) in [(0.6, 0.4), (0.9, 0.1), (1.0, 0.0), (1.3, 0.0)] {
            let (mesh, x) = two(&solid, &Vector::<3>::new(shift, 0.13, 0.0));
            let found = self_overlap_mass(&DeformedMesh { mesh: &mesh, position: &x }, |_| 1.0);
            assert!((found - 0.87 * common).abs() < 1e-12, "{shift}: {found}");
            let (mesh, x) = two(&flat, &Vector::<2>::new(shift, 0.13));
            let found = self_overlap_mass(&DeformedMesh { mesh: &mesh, position: &x }, |x| x[0]);
            // ∫ x over the part of the first block from `shift` on.
            let exact = 0.87 * 0.5 * (1.0 - shift.min(1.0) * shift.min(1.0));
            assert!((found - exact).abs() < 1e-12, "{shift}: {found} {exact}");
        }
    }
}
