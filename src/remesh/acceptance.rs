//! Acceptance test of a new mesh: quality, conserved measure and unchanged topology.

use super::boundary_loops::crossing;
use super::{DeformedMesh, ProposedMesh};
use crate::math::{Vector, ordered_sum};
use crate::mesh::{Facet, NodeId, Simplex, boundary, shape_quality, signed_volume};

/// Limits that a new mesh must satisfy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AcceptanceLimits {
    /// Greatest relative change of area or volume.
    pub measure: f64,
    /// Least quality ([`shape_quality`]).
    pub quality: f64,
}

/// Quality of a new mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshQuality {
    /// Least quality of an element ([`shape_quality`]).
    pub least: f64,
    /// Relative change of area or volume.
    pub change: f64,
    /// Connected components of the body.
    pub parts: usize,
    /// Connected components of the boundary.
    pub loops: usize,
}

/// Reason why a new mesh is rejected.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum MeshRejected {
    /// No elements.
    #[error("the new mesh has no elements")]
    Empty,
    /// Degenerate or inverted element.
    #[error(
        "element {element} of the new mesh is degenerate or inverted: its area, m², or volume, m³, is {measure:.3e}"
    )]
    Inverted {
        /// Element of the new mesh.
        element: usize,
        /// Area, m², or volume, m³, of the element.
        measure: f64,
    },
    /// Element below the quality limit.
    #[error("the least element quality of the new mesh is {found:.3}, expected at least {least:.3}")]
    Poor {
        /// Least quality of the new mesh.
        found: f64,
        /// Least quality allowed.
        least: f64,
    },
    /// Change of area or volume above the limit.
    #[error("the relative change of the area or volume of the body is {change:.3e}, expected at most {most:.3e}")]
    Measure {
        /// Relative change.
        change: f64,
        /// Greatest relative change allowed.
        most: f64,
    },
    /// Changed number of components of the body.
    #[error("the body had {before} connected components and has {after}")]
    Parts {
        /// Components of the old mesh.
        before: usize,
        /// Components of the new mesh.
        after: usize,
    },
    /// Changed number of components of the boundary.
    #[error("the boundary had {before} connected components and has {after}: walls were merged or a hole was closed")]
    Loops {
        /// Components of the old mesh.
        before: usize,
        /// Components of the new mesh.
        after: usize,
    },
    /// Changed Euler characteristic of the boundary: handles or pinches were made or lost.
    #[error(
        "the Euler characteristic of the boundary was {before} and is {after}: a tunnel was opened or closed, or walls touch"
    )]
    Genus {
        /// V − F/2 of the old boundary.
        before: isize,
        /// V − F/2 of the new boundary.
        after: isize,
    },
    /// Self-intersection of the boundary.
    #[error(
        "the new boundary intersects itself: edge {:?} crosses edge {:?}",
        edges[0].map(|n| n.0), edges[1].map(|n| n.0)
    )]
    Crossing {
        /// Crossing edges, by nodes of the new mesh.
        edges: [[NodeId; 2]; 2],
    },
}

/// Tests a new mesh against the old one in its deformed configuration.
///
/// In the plane the boundary is tested for self-intersection. In space its Euler characteristic must be unchanged
/// instead.
///
/// # Errors
/// The first criterion that the new mesh violates.
pub fn check_acceptance<const D: usize>(
    old: &DeformedMesh<'_, D>,
    new: &ProposedMesh<D>,
    limits: &AcceptanceLimits,
) -> Result<MeshQuality, MeshRejected> {
    let shapes: Vec<f64> = new.elements.iter().map(|e| shape_quality(&new.position, e)).collect();
    check_acceptance_known(old, new, (limits, &KnownQuality { shapes: &shapes, facets: &boundary::<D>(&new.elements) }))
}

/// Properties of a new mesh that are known before the test.
#[derive(Debug, Clone, Copy)]
pub struct KnownQuality<'a> {
    /// Quality of each element ([`shape_quality`]); infinity for elements that are clearly better than others.
    pub shapes: &'a [f64],
    /// Boundary facets ([`boundary`]).
    pub facets: &'a [Facet],
}

/// Tests a new mesh whose qualities and boundary are known; see [`check_acceptance`].
///
/// # Errors
/// The first criterion that the new mesh violates.
pub fn check_acceptance_known<const D: usize>(
    old: &DeformedMesh<'_, D>,
    new: &ProposedMesh<D>,
    (limits, known): (&AcceptanceLimits, &KnownQuality<'_>),
) -> Result<MeshQuality, MeshRejected> {
    if new.elements.is_empty() {
        return Err(MeshRejected::Empty);
    }
    let x = &new.position;
    let measures: Vec<f64> = new.elements.iter().map(|e| signed_volume(x, e)).collect();
    if let Some(element) = measures.iter().position(|measure| measure.is_nan() || *measure <= 0.0) {
        return Err(MeshRejected::Inverted { element, measure: measures[element] });
    }
    let least = known.shapes.iter().copied().fold(f64::INFINITY, f64::min);
    let exactly = || new.elements.iter().map(|e| shape_quality(x, e)).fold(f64::MAX, f64::min);
    let least = if least < f64::INFINITY { least } else { exactly() };
    if least < limits.quality {
        return Err(MeshRejected::Poor { found: least, least: limits.quality });
    }
    let before = ordered_sum(old.mesh.elements.len(), 0.0, |e| signed_volume(old.position, &old.mesh.elements[e]));
    let change = ordered_sum(measures.len(), 0.0, |e| measures[e]) / before - 1.0;
    if change.is_nan() || change.abs() > limits.measure {
        return Err(MeshRejected::Measure { change, most: limits.measure });
    }
    let [parts, loops] = compare(old, new, known.facets)?;
    Ok(MeshQuality { least, change, parts, loops })
}

/// Compares the topology with that of the old mesh and returns the numbers of components of the body and of its
/// boundary. Components must be equal; the plane boundary must not cross itself, the surface in space must keep its
/// handles.
fn compare<const D: usize>(
    old: &DeformedMesh<'_, D>,
    new: &ProposedMesh<D>,
    facets: &[Facet],
) -> Result<[usize; 2], MeshRejected> {
    let count = |elements: &[Simplex], n_nodes: usize| components(elements.iter().map(|e| &e[..=D]), n_nodes);
    let parts = [count(&old.mesh.elements, old.position.len()), count(&new.elements, new.position.len())];
    if parts[0] != parts[1] {
        return Err(MeshRejected::Parts { before: parts[0], after: parts[1] });
    }
    let loops = [(old.mesh.facets.as_slice(), old.position.len()), (facets, new.position.len())]
        .map(|(facets, n_nodes)| components(facets.iter().map(|f| &f[..D]), n_nodes));
    if loops[0] != loops[1] {
        return Err(MeshRejected::Loops { before: loops[0], after: loops[1] });
    }
    if D == 2 {
        free_of_crossings(facets, &new.position)?;
    } else {
        let [before, after] = [&old.mesh.facets, facets].map(characteristic);
        if before != after {
            return Err(MeshRejected::Genus { before, after });
        }
    }
    Ok([parts[1], loops[1]])
}

/// Checks that no edge of a plane boundary crosses another.
fn free_of_crossings<const D: usize>(facets: &[Facet], x: &[Vector<D>]) -> Result<(), MeshRejected> {
    let edges: Vec<[usize; 2]> = facets.iter().map(|f| [f[0].index(), f[1].index()]).collect();
    let flat: Vec<Vector<2>> = x.iter().map(|x| Vector::<2>::new(x[0], x[1])).collect();
    match crossing(&edges, &flat) {
        Some(edges) => Err(MeshRejected::Crossing { edges: edges.map(|e| e.map(|n| NodeId(n as u32))) }),
        None => Ok(()),
    }
}

/// Euler characteristic V − E + F = V − F/2 of a closed triangulated surface with 3/2 edges per triangle: 2 for a ball,
/// 0 for a torus. An edge along which the surface touches itself counts once per passage.
fn characteristic(facets: &[Facet]) -> isize {
    let mut nodes: Vec<NodeId> = facets.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.len().cast_signed() - (facets.len() / 2).cast_signed()
}

/// Number of connected components of the groups of nodes; isolated nodes do not count.
fn components<'a>(groups: impl Iterator<Item = &'a [NodeId]>, n_nodes: usize) -> usize {
    let mut above: Vec<usize> = vec![usize::MAX; n_nodes];
    let mut count = 0;
    for group in groups {
        for node in group {
            let node = node.index();
            if above[node] == usize::MAX {
                above[node] = node;
                count += 1;
            }
            if above[node] == above[group[0].index()] {
                continue;
            }
            let [first, other] = [group[0].index(), node].map(|n| root(&mut above, n));
            if first != other {
                above[other] = first;
                count -= 1;
            }
        }
    }
    count
}

/// Root of a node in the union-find forest.
fn root(above: &mut [usize], mut node: usize) -> usize {
    while above[node] != node {
        above[node] = above[above[node]];
        node = above[node];
    }
    node
}

#[cfg(test)]
mod tests {
    use super::super::test_meshes::{rings, square};
    use super::super::{DeformedMesh, NodeOrigin};
    use super::*;
    use crate::mesh::{CellSplit, Mesh, RectilinearGrid, uniform};

    /// Cube of 3 × 3 × 3 cells without the cells in `empty`.
    fn cubes(empty: &'static [[usize; 3]]) -> Mesh<3> {
        let axis = || uniform(0.0, 3.0, 1.0);
        let filled = |cell: [usize; 3]| !empty.contains(&cell);
        let (points, elements) =
            RectilinearGrid { planes: [axis(), axis(), axis()], filled: Box::new(filled) }.split(CellSplit::Kuhn);
        Mesh::new(points, elements)
    }

    const STRICT: AcceptanceLimits = AcceptanceLimits { measure: 1e-12, quality: 0.5 };

    fn same<const D: usize>(mesh: &Mesh<D>) -> ProposedMesh<D> {
        let origin = (0..mesh.rest.len() as u32).map(|n| NodeOrigin::Kept(NodeId(n))).collect();
        ProposedMesh { position: mesh.rest.clone(), origin, elements: mesh.elements.clone(), over: vec![] }
    }

    fn judged<const D: usize>(
        mesh: &Mesh<D>,
        new: &ProposedMesh<D>,
        limits: &AcceptanceLimits,
    ) -> Result<MeshQuality, MeshRejected> {
        check_acceptance(&DeformedMesh { mesh, position: &mesh.rest }, new, limits)
    }

    #[test]
    fn the_same_mesh_is_as_good_as_it_was() {
        let mesh = rings(2, 0.5);
        let found = judged(&mesh, &same(&mesh), &STRICT).unwrap();
        assert!((found.least - 0.75_f64.sqrt()).abs() < 1e-12, "{}", found.least);
        assert_eq!((found.change, found.parts, found.loops), (0.0, 2, 4));
    }

    #[test]
    fn flat_poor_and_missing_elements_are_refused() {
        let mesh = square(4);
        let mut new = same(&mesh);
        new.elements[3].swap(0, 1);
        assert!(matches!(judged(&mesh, &new, &STRICT), Err(MeshRejected::Inverted { element: 3, .. })));
        let mut new = same(&mesh);
        let middle = new.position.iter().position(|x| *x == Vector::<2>::new(0.5, 0.5)).unwrap();
        new.position[middle] += Vector::<2>::new(0.12, 0.12);
        assert!(matches!(judged(&mesh, &new, &STRICT), Err(MeshRejected::Poor { found, .. }) if found < 0.1));
        let mut new = same(&mesh);
        new.elements.pop();
        assert!(matches!(judged(&mesh, &new, &STRICT), Err(MeshRejected::Measure { change, .. }) if change < -0.01));
        new.elements.clear();
        assert_eq!(judged(&mesh, &new, &STRICT), Err(MeshRejected::Empty));
    }

    #[test]
    fn a_mesh_with_other_numbers_of_parts_or_boundary_loops_is_refused() {
        let any = AcceptanceLimits { measure: 1.0, quality: 0.0 };
        let (two, whole) = (rings(2, 0.5), square(8));
        let mut less = same(&two);
        less.elements.retain(|e| two.rest[e[0].index()][0] < 3.5);
        assert_eq!(judged(&two, &less, &any), Err(MeshRejected::Parts { before: 2, after: 1 }));
        let mut holed = same(&whole);
        let in_middle = |n: &NodeId| (whole.rest[n.index()] - Vector::<2>::new(0.5, 0.5)).norm() < 0.01;
        holed.elements.retain(|e| !e[..3].iter().any(in_middle));
        assert_eq!(judged(&whole, &holed, &any), Err(MeshRejected::Loops { before: 1, after: 2 }));
    }

    #[test]
    fn bodies_that_overlap_are_refused() {
        let two = rings(2, 0.5);
        let mut new = same(&two);
        new.position.iter_mut().filter(|x| x[0] > 3.5).for_each(|x| *x -= Vector::<2>::new(1.2, 0.1));
        assert!(matches!(judged(&two, &new, &STRICT), Err(MeshRejected::Crossing { .. })));
    }

    #[test]
    fn a_mesh_of_space_that_is_the_same_is_as_good_as_it_was() {
        let mesh = cubes(&[[1, 1, 1]]);
        let found = judged(&mesh, &same(&mesh), &STRICT).unwrap();
        // A tetrahedron of Kuhn has the edges 1, 1, 1, √2, √2 and √3.
        assert!((found.least - 12.0 * 0.25_f64.cbrt() / 10.0).abs() < 1e-12, "{}", found.least);
        assert_eq!((found.change, found.parts, found.loops), (0.0, 1, 2));
    }

    #[test]
    fn flat_poor_and_missing_tetrahedra_are_refused() {
        let mesh = cubes(&[]);
        let mut new = same(&mesh);
        new.elements[3].swap(0, 1);
        assert!(matches!(judged(&mesh, &new, &STRICT), Err(MeshRejected::Inverted { element: 3, .. })));
        let mut new = same(&mesh);
        let inner = new.position.iter().position(|x| *x == Vector::<3>::repeat(1.0)).unwrap();
        new.position[inner].z += 0.8;
        assert!(matches!(judged(&mesh, &new, &STRICT), Err(MeshRejected::Poor { found, .. }) if found < 0.4));
        let mut new = same(&mesh);
        new.elements.pop();
        assert!(matches!(judged(&mesh, &new, &STRICT), Err(MeshRejected::Measure { change, .. }) if change < -0.005));
    }

    #[test]
    fn tunnels_and_pinches_that_were_opened_or_closed_are_refused() {
        let any = AcceptanceLimits { measure: 1.0, quality: 0.0 };
        let through: &[[usize; 3]] = &[[1, 1, 0], [1, 1, 1], [1, 1, 2]];
        let [whole, dented, tunnelled, hollow] =
            [cubes(&[]), cubes(&through[..2]), cubes(through), cubes(&through[1..2])];
        let found = |old: &Mesh<3>, new: &Mesh<3>| judged(old, &same(new), &any);
        assert!(found(&whole, &dented).is_ok() && found(&dented, &whole).is_ok());
        assert_eq!(found(&dented, &tunnelled), Err(MeshRejected::Genus { before: 2, after: 0 }));
        assert_eq!(found(&tunnelled, &whole), Err(MeshRejected::Genus { before: 0, after: 2 }));
        assert_eq!(found(&whole, &hollow), Err(MeshRejected::Loops { before: 1, after: 2 }));
        // Two dents that touch along an edge.
        let pinched = cubes(&[[0, 0, 2], [1, 1, 2]]);
        assert_eq!(found(&whole, &pinched), Err(MeshRejected::Genus { before: 2, after: 1 }));
    }
}
