//! Thin features: sheets of gel that erode.

use super::DeformedMesh;
use super::barycentric::edges;
use crate::math::{Vector3, embed};
use crate::mesh::{ElementId, Facet, facet_measure, signed_volume};

/// Greatest edge of a sheet, in thicknesses.
const LONGEST: f64 = 4.0;

/// Marks the elements across a sheet thinner than `below`, m: elements that reach from a surface facet to a node on
/// another side. `across` holds the face neighbours of each element.
///
/// In the plane an inverted element is thinner than any limit; an element with two surface facets is a corner or a
/// bend, not a sheet. In space an element is across a sheet if all its nodes are on the surface and the surface normals
/// at two of them oppose each other. A splash of one or two elements is as thin as their least heights.
#[must_use]
pub fn thin_elements<const D: usize>(
    moved: &DeformedMesh<'_, D>,
    (facets, across): (&[Facet], &[[Option<ElementId>; 4]]),
    below: f64,
) -> Vec<bool> {
    let mut thin = vec![false; across.len()];
    let all: Vec<(usize, f64)> =
        if D == 2 { heights(moved, facets, across).collect() } else { widths(moved, facets).collect() };
    for (e, height) in all.into_iter().chain(splash_heights(moved, across)) {
        thin[e] |= height < below && is_long::<D>(moved, e, height);
    }
    thin
}

/// Limits target sizes on sheets to a multiple of their thickness: chords of longer edges would cross the opposite
/// side, and the elements between would be degenerate. In the plane only: in space a tetrahedron at an edge of a block
/// cannot be told from a sheet.
#[must_use]
pub fn limit_sheet_sizes<const D: usize>(
    moved: &DeformedMesh<'_, D>,
    (facets, across): (&[Facet], &[[Option<ElementId>; 4]]),
    mut size: Vec<f64>,
    least: f64,
) -> Vec<f64> {
    if D == 3 {
        return size;
    }
    for (e, height) in heights(moved, facets, across).filter(|(_, height)| *height > 0.0) {
        for node in &moved.mesh.elements[e][..=D] {
            let size = &mut size[node.index()];
            *size = size.min((LONGEST * height).max(least));
        }
    }
    size
}

/// Elements across a sheet, and its thickness there, m; negative for an inverted element.
fn heights<const D: usize>(
    moved: &DeformedMesh<'_, D>,
    facets: &[Facet],
    across: &[[Option<ElementId>; 4]],
) -> impl Iterator<Item = (usize, f64)> {
    let mut outer = vec![false; moved.position.len()];
    facets.iter().flat_map(|facet| &facet[..D]).for_each(|node| outer[node.index()] = true);
    moved.mesh.elements.iter().enumerate().filter_map(move |(e, nodes)| {
        let mut bare = (0..=D).filter(|k| across[e][*k].is_none());
        let (Some(opposite), None) = (bare.next(), bare.next()) else { return None };
        let base: Facet = [1, 2, 3].map(|k| nodes[(opposite + k) % (D + 1)]);
        let height = D as f64 * signed_volume(moved.position, nodes) / facet_measure(moved.position, &base);
        nodes[..=D].iter().all(|node| outer[node.index()]).then_some((e, height))
    })
}

/// Elements of detached parts of one or two elements, and their least heights, m: drawn out in flight, they step ever
/// less, and no mesh makes them thicker.
fn splash_heights<const D: usize>(
    moved: &DeformedMesh<'_, D>,
    across: &[[Option<ElementId>; 4]],
) -> impl Iterator<Item = (usize, f64)> {
    let neighbours = |e: usize| across[e][..=D].iter().flatten();
    let is_end = move |e: usize| neighbours(e).count() <= 1;
    let is_splash = move |e: &usize| is_end(*e) && neighbours(*e).all(|other| is_end(other.index()));
    (0..across.len()).filter(is_splash).map(|e| {
        let nodes = &moved.mesh.elements[e];
        let facet = |k: usize| facet_measure(moved.position, &[1, 2, 3].map(|i| nodes[(k + i) % (D + 1)]));
        let greatest = (0..=D).map(facet).fold(0.0, f64::max);
        (e, D as f64 * signed_volume(moved.position, nodes) / greatest)
    })
}

/// Cosine between the surface normals at two nodes below which they oppose each other. Under a ball in cells of a
/// quarter of its radius, adjacent normals have 0.9.
const AWAY: f64 = -0.3;

/// Elements across a sheet in space, and its thickness there, m: the greatest distance, along the difference of their
/// normals, of two nodes with opposing normals.
fn widths<const D: usize>(moved: &DeformedMesh<'_, D>, facets: &[Facet]) -> impl Iterator<Item = (usize, f64)> {
    let normals = normals(moved, facets);
    moved.mesh.elements.iter().enumerate().filter_map(move |(e, nodes)| {
        let mut width: Option<f64> = None;
        for (i, j) in (0..=D).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let [(a, x), (b, y)] =
                [i, j].map(|k| (normals[nodes[k].index()], embed(&moved.position[nodes[k].index()])));
            if a.dot(&b) < AWAY {
                let across = ((x - y).dot(&(a - b)) / (a - b).norm()).abs();
                width = Some(width.map_or(across, |width| width.max(across)));
            }
        }
        let is_bare = nodes[..=D].iter().all(|node| normals[node.index()] != Vector3::zeros());
        width.filter(|_| is_bare).map(|width| (e, width))
    })
}

/// Unit normals of the surface at its nodes, weighted by area; zero at the other nodes.
fn normals<const D: usize>(moved: &DeformedMesh<'_, D>, facets: &[Facet]) -> Vec<Vector3> {
    let mut normals = vec![Vector3::zeros(); moved.position.len()];
    for facet in facets {
        let [a, b, c] = [0, 1, 2].map(|k| embed(&moved.position[facet[k].index()]));
        let area = (b - a).cross(&(c - a));
        facet.iter().take(D).for_each(|node| normals[node.index()] += area);
    }
    normals.iter().map(|normal| normal.try_normalize(0.0).unwrap_or_else(Vector3::zeros)).collect()
}

/// Returns true if an element is longer than it is thick; shorter ones are corners.
fn is_long<const D: usize>(moved: &DeformedMesh<'_, D>, element: usize, height: f64) -> bool {
    let nodes = &moved.mesh.elements[element];
    let length = |[a, b]: &[usize; 2]| (moved.position[nodes[*a].index()] - moved.position[nodes[*b].index()]).norm();
    edges::<D>().iter().map(length).fold(0.0, f64::max) > LONGEST * height
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;
    use crate::mesh::{BlockSpec, CellSplit, Mesh, block, boundary, face_neighbours};

    /// Block with a fin of this thickness along its side.
    fn finned(thickness: f64) -> Mesh<3> {
        let planes = [vec![0.0, thickness, 0.25, 0.5], vec![0.0, 0.25, 0.5], vec![0.0, 0.25, 0.5, 0.75, 1.0]];
        let mesh = block(BlockSpec { planes, split: CellSplit::Kuhn, faces: vec![] });
        let middle = |e: &crate::mesh::Simplex| e.iter().map(|n| mesh.rest[n.index()]).sum::<Vector<3>>() / 4.0;
        let is_there = |e: &&crate::mesh::Simplex| middle(e).z < 0.5 || middle(e).x < thickness;
        let elements: Vec<_> = mesh.elements.iter().filter(is_there).copied().collect();
        Mesh { facets: boundary::<3>(&elements), elements, ..mesh }
    }

    #[test]
    fn a_thin_fin_on_a_block_in_space_breaks_off_and_nothing_else() {
        let mesh = finned(0.02);
        let moved = DeformedMesh { mesh: &mesh, position: &mesh.rest };
        let surface = (&mesh.facets[..], &face_neighbours::<3>(&mesh.elements)[..]);
        let gone = thin_elements(&moved, surface, 0.05);
        let reaches = |e: usize, z: f64| mesh.elements[e].iter().any(|n| mesh.rest[n.index()].z > z);
        assert!((0..gone.len()).all(|e| !gone[e] || reaches(e, 0.5)), "the block stays");
        assert!((0..gone.len()).all(|e| gone[e] || !reaches(e, 0.75)), "the upper half of the fin goes");
        assert!(!thin_elements(&moved, surface, 0.01).contains(&true), "a fin that is thick enough stays");
    }

    #[test]
    fn a_needle_that_flies_alone_or_with_another_breaks_off() {
        let rest = [[0.0, 0.0], [10.0, 0.0], [4.0, 0.1], [6.0, -0.1]].map(Vector::<2>::from).to_vec();
        let both = [[0, 1, 2, 2], [1, 0, 3, 3]].map(|e| e.map(crate::mesh::NodeId));
        for (n, below, is_gone) in [(1, 0.2, true), (2, 0.2, true), (2, 0.05, false)] {
            let elements = both[..n].to_vec();
            let facets = boundary::<2>(&elements);
            let mesh = Mesh { rest: rest.clone(), elements, facets, held: vec![[false; 2]; 4], marks: vec![] };
            let moved = DeformedMesh { mesh: &mesh, position: &mesh.rest };
            let surface = (&mesh.facets[..], &face_neighbours::<2>(&mesh.elements)[..]);
            assert_eq!(thin_elements(&moved, surface, below), vec![is_gone; n]);
        }
    }

    #[test]
    fn a_fin_of_the_plane_whose_side_went_through_the_other_one_breaks_off() {
        let planes = [vec![0.0, 0.25, 0.5, 1.0], vec![0.0, 0.25, 0.5, 0.75, 1.0]];
        let mesh = block::<2>(BlockSpec { planes, split: CellSplit::Kuhn, faces: vec![] });
        let rest = mesh.rest.clone();
        let middle = |e: &crate::mesh::Simplex| e[..3].iter().map(|n| rest[n.index()]).sum::<Vector<2>>() / 3.0;
        let is_there = |e: &&crate::mesh::Simplex| middle(e)[1] < 0.5 || middle(e)[0] < 0.25;
        let elements: Vec<_> = mesh.elements.iter().filter(is_there).copied().collect();
        let mesh = Mesh { facets: boundary::<2>(&elements), elements, ..mesh };
        let through = |x: &Vector<2>| *x == Vector::<2>::new(0.25, 0.75);
        let of = |to: f64| {
            let position: Vec<_> =
                mesh.rest.iter().map(|x| if through(x) { Vector::<2>::new(to, 0.75) } else { *x }).collect();
            let surface = (&mesh.facets[..], &face_neighbours::<2>(&mesh.elements)[..]);
            thin_elements(&DeformedMesh { mesh: &mesh, position: &position }, surface, 1e-6)
        };
        assert!(!of(0.25).contains(&true) && !of(0.01).contains(&true));
        let gone = of(-0.01);
        assert!(gone.contains(&true) && (0..gone.len()).all(|e| !gone[e] || middle(&mesh.elements[e])[1] > 0.5));
    }
}
