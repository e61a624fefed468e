//! Erosion on failure: removes elements that no mesh can follow before the run ends by them.

use super::adaptive_gel::AdaptiveGel;
use super::erosion::{MAX_ERODED_FRACTION, MAX_EROSIONS, erode};
use super::refusal::RemeshRefusal;
use crate::integrator::{StepError, UnusableStep};
use crate::math::{Vector, Vector3, embed};
use crate::mesh::{NodeId, Simplex, signed_volume};
use crate::remesh::RemeshError;

/// Erodes the elements that stop the run, and the parts that detach; returns true if elements were removed.
///
/// The elements are:
/// - inverted or [massless](is_massless) elements;
/// - the stiffest element around each node without a stable step, and the element behind a leaking facet;
/// - elements at nodes where a mesh was refused because the boundary touches itself;
/// - elements by which a new mesh, or the remaining one, could not be stepped.
pub(super) fn erode_on_failure<const D: usize>(gel: &mut AdaptiveGel<D>, refused: &[RemeshRefusal]) -> bool {
    let old = gel.current_mesh();
    let position = &gel.engine.state().position;
    let elements = &old.mesh.elements;
    let is_lost = |(nodes, own)| signed_volume(position, nodes) <= 0.0 || is_massless::<D>(nodes, own, &old.mass);
    let mut eroded: Vec<bool> = elements.iter().zip(&old.corner_mass).map(is_lost).collect();
    gel.engine.stepless().for_each(|element| eroded[element.index()] = true);
    // An element may have collapsed by the sums of its block, not by its own; only the failure reports a leak.
    if let Some(StepError::StepCollapsed { element, .. } | StepError::Leak { element, .. }) = gel.engine.failure() {
        eroded[*element] = true;
    }
    mark_elements::<D>(&mut eroded, elements, refused.iter().flat_map(|why| blamed_nodes(why, position)));
    for _ in 0..MAX_EROSIONS {
        let corners = match erode(gel, &old, &eroded, MAX_ERODED_FRACTION) {
            Ok(has_eroded) => return has_eroded,
            Err(why) => stepless_nodes(&why, &gel.engine.state().position),
        };
        if !mark_elements::<D>(&mut eroded, elements, [corners]) {
            break;
        }
    }
    false
}

/// Returns true if an element's mass is negligible beside its lightest node, or negative. An element created outside
/// the old gel overlaps the old gel by round-off only; its nodes get their masses from adjacent elements.
fn is_massless<const D: usize>(nodes: &Simplex, own: &[f64; 4], mass: &[f64]) -> bool {
    const NEGLIGIBLE: f64 = 1e-12;
    let lightest = nodes[..=D].iter().map(|node| mass[node.index()]).fold(f64::INFINITY, f64::min);
    own[..=D].iter().sum::<f64>() <= NEGLIGIBLE * lightest
}

/// Marks the elements that have all nodes of one of these sets; returns true if one was not marked before.
fn mark_elements<const D: usize>(
    eroded: &mut [bool],
    elements: &[Simplex],
    blamed: impl IntoIterator<Item = Vec<NodeId>>,
) -> bool {
    let mut has_marked = false;
    for corners in blamed {
        for (_, eroded) in elements.iter().zip(&mut *eroded).filter(|(nodes, _)| has_nodes::<D>(nodes, &corners)) {
            has_marked |= !std::mem::replace(eroded, true);
        }
    }
    has_marked
}

/// Sets of old nodes that a refusal blames: those where the boundary touches itself, and the corners of elements that could
/// not be stepped.
fn blamed_nodes<const D: usize>(why: &RemeshRefusal, position: &[Vector<D>]) -> Vec<Vec<NodeId>> {
    let at = |place: &[f64; 2]| {
        let there = position.iter().position(|x| x[0] == place[0] && x[1] == place[1]);
        there.map(|node| NodeId(node as u32))
    };
    match why {
        RemeshRefusal::Steps(why) => vec![stepless_nodes(why, position)],
        RemeshRefusal::Made(RemeshError::Coincident { place }) => vec![at(place).into_iter().collect()],
        _ => vec![],
    }
}

/// Nodes of the element by which a mesh could not be stepped; empty if not all of them are old nodes.
fn stepless_nodes<const D: usize>(why: &UnusableStep, position: &[Vector<D>]) -> Vec<NodeId> {
    let corner = |place: &Vector3| position.iter().position(|x| embed(x) == *place).map(|node| NodeId(node as u32));
    why.corners.iter().map(corner).collect::<Option<Vec<_>>>().unwrap_or_default()
}

/// Returns true if an element has all of these nodes, and there are any.
fn has_nodes<const D: usize>(element: &Simplex, nodes: &[NodeId]) -> bool {
    !nodes.is_empty() && nodes.iter().all(|node| element[..=D].contains(node))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_element_outside_the_old_gel_is_massless_up_to_round_off() {
        let nodes = [0, 1, 2, 3].map(NodeId);
        let weighs = |own: [f64; 4], lightest: f64| !is_massless::<3>(&nodes, &own, &[1.0, lightest, 2.0, 3.0]);
        assert!(weighs([1e-6, -2e-7, 0.0, 1e-6], 1.0) && weighs([1e-15; 4], 1e-3));
        assert!(
            !weighs([1e-57, 2e-57, 0.0, 1e-57], 1.0) && !weighs([0.0; 4], 1.0) && !weighs([1e-3, -2e-3, 0.0, 0.0], 1.0)
        );
        // In the plane the fourth corner is ignored.
        assert!(is_massless::<2>(&nodes, &[0.0, 0.0, 0.0, 1.0], &[1.0; 4]));
    }

    #[test]
    fn elements_erode_where_the_boundary_touches_itself_and_where_no_step_is_stable() {
        let position = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vector::<2>::from);
        let of = |why: RemeshError| blamed_nodes(&RemeshRefusal::Made(why), &position);
        let [a, b, c, d] = [0, 1, 2, 3].map(NodeId);
        assert_eq!(of(RemeshError::Coincident { place: [1.0, 0.0] }), [vec![b]]);
        assert_eq!(of(RemeshError::Coincident { place: [0.2, 0.3] }), [vec![]; 1]);
        assert!(blamed_nodes(&RemeshRefusal::Massless { nodes: 1 }, &position).is_empty());
        let stepless = |corners: [[f64; 3]; 3]| {
            let corners = corners.map(Vector3::from).into();
            blamed_nodes(&RemeshRefusal::Steps(UnusableStep { step: 1e-12, corners }), &position)
        };
        assert_eq!(stepless([[1.0, 0.0, 1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), [vec![c, a, d]]);
        assert_eq!(stepless([[1.0, 0.0, 1.0], [0.0, 0.0, 0.0], [0.5, 0.0, 1.0]]), [vec![]; 1]);
        let element = [a, b, c, NodeId(0)];
        assert!(
            has_nodes::<2>(&element, &[a, c]) && !has_nodes::<2>(&element, &[a, d]) && !has_nodes::<2>(&element, &[])
        );
    }
}
