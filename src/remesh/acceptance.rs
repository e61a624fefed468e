//! Whether a new mesh may take the place of the old one.

use super::boundary_loops::crossing;
use super::{Moved, Proposal};
use crate::math::{Vector, ordered_sum};
use crate::mesh::{Facet, NodeId, Simplex, boundary, shape_quality, signed_volume};

/// What a new mesh must satisfy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Acceptance {
    /// Greatest |change of area, in space of volume| but for what was cleared, as a share of what it was.
    pub measure: f64,
    /// Least quality ([`shape_quality`]).
    pub quality: f64,
}

/// How good a new mesh is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Least quality of an element ([`shape_quality`]).
    pub least: f64,
    /// Change of area, in space of volume, as a share of what it was.
    pub change: f64,
    /// Connected parts of the body.
    pub parts: usize,
    /// Connected parts of its boundary.
    pub loops: usize,
}

/// Why a new mesh may not take the place of the old one.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Rejected {
    /// No elements.
    #[error("the new mesh has no elements")]
    Empty,
    /// An element that is flat or inverted.
    #[error("element {element} of the new mesh is flat or inside out: its area, m², or volume, m³, is {measure:.3e}")]
    Inverted {
        /// Which.
        element: usize,
        /// Its area, m², or volume, m³.
        measure: f64,
    },
    /// An element below the quality asked for.
    #[error("an element of the new mesh has the quality {found:.3}, less than {least:.3}")]
    Poor {
        /// The least quality found.
        found: f64,
        /// The least allowed.
        least: f64,
    },
    /// The area, or in space the volume, has changed.
    #[error("the area or volume of the body changes by {change:.3e} of itself, more than {most:.3e}")]
    Measure {
        /// Change, as a share.
        change: f64,
        /// The greatest allowed.
        most: f64,
    },
    /// Parts of the body were joined, divided or lost.
    #[error("the body had {before} parts and has {after}")]
    Parts {
        /// In the old mesh.
        before: usize,
        /// In the new one.
        after: usize,
    },
    /// Parts of the boundary were joined, divided or lost.
    #[error("the boundary had {before} parts and has {after}: a wall was welded or a hole closed")]
    Loops {
        /// In the old mesh.
        before: usize,
        /// In the new one.
        after: usize,
    },
    /// Handles or pinches of the boundary were made or lost.
    #[error(
        "the Euler characteristic of the boundary was {before} and is {after}: a tunnel was opened or closed, or walls touch"
    )]
    Genus {
        /// In the old mesh.
        before: isize,
        /// In the new one.
        after: isize,
    },
    /// The boundary crosses itself.
    #[error("the new boundary crosses itself: edge {:?} crosses edge {:?}", edges[0].map(|n| n.0), edges[1].map(|n| n.0))]
    Crossing {
        /// The edges, by nodes of the new mesh.
        edges: [[NodeId; 2]; 2],
    },
}

/// Measures a new mesh against the old one where that is.
///
/// In the plane the boundary is searched for crossings. In space it is not: there its Euler characteristic must be what it was.
///
/// # Errors
/// The first thing it does not satisfy.
pub fn judge<const D: usize>(old: &Moved<'_, D>, new: &Proposal<D>, limits: &Acceptance) -> Result<Quality, Rejected> {
    let shapes: Vec<f64> = new.elements.iter().map(|e| shape_quality(&new.position, e)).collect();
    judge_known(old, new, (limits, &Known { shapes: &shapes, facets: &boundary::<D>(&new.elements) }))
}

/// What is known of a new mesh before it is judged.
#[derive(Debug, Clone, Copy)]
pub struct Known<'a> {
    /// The quality of each element ([`shape_quality`]), infinite of those that are better than some others.
    pub shapes: &'a [f64],
    /// The boundary ([`boundary`]).
    pub facets: &'a [Facet],
}

/// The same where that is known.
///
/// # Errors
/// The first thing that the new mesh does not satisfy.
pub fn judge_known<const D: usize>(
    old: &Moved<'_, D>,
    new: &Proposal<D>,
    (limits, known): (&Acceptance, &Known<'_>),
) -> Result<Quality, Rejected> {
    if new.elements.is_empty() {
        return Err(Rejected::Empty);
    }
    let x = &new.position;
    let measures: Vec<f64> = new.elements.iter().map(|e| signed_volume(x, e)).collect();
    if let Some(element) = measures.iter().position(|measure| measure.is_nan() || *measure <= 0.0) {
        return Err(Rejected::Inverted { element, measure: measures[element] });
    }
    let least = known.shapes.iter().copied().fold(f64::INFINITY, f64::min);
    let exactly = || new.elements.iter().map(|e| shape_quality(x, e)).fold(f64::MAX, f64::min);
    let least = if least < f64::INFINITY { least } else { exactly() };
    if least < limits.quality {
        return Err(Rejected::Poor { found: least, least: limits.quality });
    }
    let before = ordered_sum(old.mesh.elements.len(), 0.0, |e| signed_volume(old.position, &old.mesh.elements[e]));
    let change = (ordered_sum(measures.len(), 0.0, |e| measures[e]) + new.cleared) / before - 1.0;
    if change.is_nan() || change.abs() > limits.measure {
        return Err(Rejected::Measure { change, most: limits.measure });
    }
    let [parts, loops] = compare(old, new, known.facets)?;
    Ok(Quality { least, change, parts, loops })
}

/// The numbers of parts of the body and of its boundary, if they are those of the old mesh, and the boundary is free of
/// crossings, or in space has the handles that it had.
fn compare<const D: usize>(old: &Moved<'_, D>, new: &Proposal<D>, facets: &[Facet]) -> Result<[usize; 2], Rejected> {
    let count = |elements: &[Simplex], n_nodes: usize| components(elements.iter().map(|e| &e[..=D]), n_nodes);
    let parts = [count(&old.mesh.elements, old.position.len()), count(&new.elements, new.position.len())];
    if parts[0] != parts[1] {
        return Err(Rejected::Parts { before: parts[0], after: parts[1] });
    }
    let loops = [(old.mesh.facets.as_slice(), old.position.len()), (facets, new.position.len())]
        .map(|(facets, n_nodes)| components(facets.iter().map(|f| &f[..D]), n_nodes));
    if loops[0] != loops[1] {
        return Err(Rejected::Loops { before: loops[0], after: loops[1] });
    }
    if D == 2 {
        free_of_crossings(facets, &new.position)?;
    } else {
        let [before, after] = [&old.mesh.facets, facets].map(characteristic);
        if before != after {
            return Err(Rejected::Genus { before, after });
        }
    }
    Ok([parts[1], loops[1]])
}

/// Whether no edge of a boundary of the plane crosses another.
fn free_of_crossings<const D: usize>(facets: &[Facet], x: &[Vector<D>]) -> Result<(), Rejected> {
    let edges: Vec<[usize; 2]> = facets.iter().map(|f| [f[0].index(), f[1].index()]).collect();
    let flat: Vec<Vector<2>> = x.iter().map(|x| Vector::<2>::new(x[0], x[1])).collect();
    match crossing(&edges, &flat) {
        Some(edges) => Err(Rejected::Crossing { edges: edges.map(|e| e.map(|n| NodeId(n as u32))) }),
        None => Ok(()),
    }
}

/// V − F/2 of a closed surface of triangles: its Euler characteristic V − E + F, 2 of a ball's and 0 of a torus, because there
/// are 3/2 edges per triangle; where it touches itself along edges these count as often as it passes there.
fn characteristic(facets: &[Facet]) -> isize {
    let mut nodes: Vec<NodeId> = facets.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.len().cast_signed() - (facets.len() / 2).cast_signed()
}

/// Number of groups of nodes that these groups connect; nodes in none do not count.
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

/// The node that stands for all that are connected to this one.
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
    use super::super::{Moved, Origin};
    use super::*;
    use crate::mesh::{Grid, Mesh, Split, uniform};

    /// A cube of 3 × 3 × 3 cells without these.
    fn cubes(empty: &'static [[usize; 3]]) -> Mesh<3> {
        let axis = || uniform(0.0, 3.0, 1.0);
        let filled = |cell: [usize; 3]| !empty.contains(&cell);
        let (points, elements) = Grid { planes: [axis(), axis(), axis()], filled: Box::new(filled) }.split(Split::Kuhn);
        Mesh::new(points, elements)
    }

    const STRICT: Acceptance = Acceptance { measure: 1e-12, quality: 0.5 };

    fn same<const D: usize>(mesh: &Mesh<D>) -> Proposal<D> {
        let origin = (0..mesh.rest.len() as u32).map(|n| Origin::Kept(NodeId(n))).collect();
        Proposal { position: mesh.rest.clone(), origin, elements: mesh.elements.clone(), over: vec![], cleared: 0.0 }
    }

    fn judged<const D: usize>(mesh: &Mesh<D>, new: &Proposal<D>, limits: &Acceptance) -> Result<Quality, Rejected> {
        judge(&Moved { mesh, position: &mesh.rest }, new, limits)
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
        assert!(matches!(judged(&mesh, &new, &STRICT), Err(Rejected::Inverted { element: 3, .. })));
        let mut new = same(&mesh);
        let middle = new.position.iter().position(|x| *x == Vector::<2>::new(0.5, 0.5)).unwrap();
        new.position[middle] += Vector::<2>::new(0.12, 0.12);
        assert!(matches!(judged(&mesh, &new, &STRICT), Err(Rejected::Poor { found, .. }) if found < 0.1));
        let mut new = same(&mesh);
        new.elements.pop();
        assert!(matches!(judged(&mesh, &new, &STRICT), Err(Rejected::Measure { change, .. }) if change < -0.01));
        new.elements.clear();
        assert_eq!(judged(&mesh, &new, &STRICT), Err(Rejected::Empty));
    }

    #[test]
    fn what_was_welded_or_opened_is_refused() {
        let any = Acceptance { measure: 1.0, quality: 0.0 };
        let (two, whole) = (rings(2, 0.5), square(8));
        let mut less = same(&two);
        less.elements.retain(|e| two.rest[e[0].index()][0] < 3.5);
        assert_eq!(judged(&two, &less, &any), Err(Rejected::Parts { before: 2, after: 1 }));
        let mut holed = same(&whole);
        let in_middle = |n: &NodeId| (whole.rest[n.index()] - Vector::<2>::new(0.5, 0.5)).norm() < 0.01;
        holed.elements.retain(|e| !e[..3].iter().any(in_middle));
        assert_eq!(judged(&whole, &holed, &any), Err(Rejected::Loops { before: 1, after: 2 }));
    }

    #[test]
    fn bodies_that_overlap_are_refused() {
        let two = rings(2, 0.5);
        let mut new = same(&two);
        new.position.iter_mut().filter(|x| x[0] > 3.5).for_each(|x| *x -= Vector::<2>::new(1.2, 0.1));
        assert!(matches!(judged(&two, &new, &STRICT), Err(Rejected::Crossing { .. })));
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
        assert!(matches!(judged(&mesh, &new, &STRICT), Err(Rejected::Inverted { element: 3, .. })));
        let mut new = same(&mesh);
        let inner = new.position.iter().position(|x| *x == Vector::<3>::repeat(1.0)).unwrap();
        new.position[inner].z += 0.8;
        assert!(matches!(judged(&mesh, &new, &STRICT), Err(Rejected::Poor { found, .. }) if found < 0.4));
        let mut new = same(&mesh);
        new.elements.pop();
        assert!(matches!(judged(&mesh, &new, &STRICT), Err(Rejected::Measure { change, .. }) if change < -0.005));
    }

    #[test]
    fn tunnels_and_pinches_that_were_opened_or_closed_are_refused() {
        let any = Acceptance { measure: 1.0, quality: 0.0 };
        let through: &[[usize; 3]] = &[[1, 1, 0], [1, 1, 1], [1, 1, 2]];
        let [whole, dented, tunnelled, hollow] =
            [cubes(&[]), cubes(&through[..2]), cubes(through), cubes(&through[1..2])];
        let found = |old: &Mesh<3>, new: &Mesh<3>| judged(old, &same(new), &any);
        assert!(found(&whole, &dented).is_ok() && found(&dented, &whole).is_ok());
        assert_eq!(found(&dented, &tunnelled), Err(Rejected::Genus { before: 2, after: 0 }));
        assert_eq!(found(&tunnelled, &whole), Err(Rejected::Genus { before: 0, after: 2 }));
        assert_eq!(found(&whole, &hollow), Err(Rejected::Loops { before: 1, after: 2 }));
        // Two dents that touch along an edge.
        let pinched = cubes(&[[0, 0, 2], [1, 1, 2]]);
        assert_eq!(found(&whole, &pinched), Err(Rejected::Genus { before: 2, after: 1 }));
    }
}
