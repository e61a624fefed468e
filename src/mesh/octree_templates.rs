//! Conforming simplicial mesh of the leaves of a balanced octree, without hanging nodes: nodes are leaf corners and
//! centres.
//!
//! A face between two leaves is that of the smaller leaf. In space its edges, halved where a smaller leaf has a corner,
//! are joined to the centres on both sides. The line between these centres crosses the face in its interior, also where
//! one leaf is twice as large: the tetrahedra around it fill the two pyramids over the face. On the boundary the centre
//! of the face replaces the second centre; in the plane edges are joined to the centre of their cell. Between leaves of
//! one level this is the centred (body-centred cubic) lattice.

use super::builder::{HalfIndex, MeshBuilder, face_edges, shifted};
use crate::geometry::{FaceNeighbour, OrthCell, OrthTree};
use std::collections::HashSet;

/// Adds the simplices of all leaves to a mesh.
pub(super) fn fill<const D: usize>(builder: &mut MeshBuilder<'_, D>, leaves: &OrthTree<D>) {
    let corners = leaves.corners();
    for cell in leaves.in_order() {
        for (axis, up) in (0..D).flat_map(|axis| [(axis, false), (axis, true)]) {
            let face = shifted(cell.centre(), axis, if up { cell.reach() } else { -cell.reach() });
            let Some(end) = second_apex(leaves, &cell, axis, up, face) else { continue };
            for [a, b] in
                face_edges(face, axis, cell.reach()).into_iter().flat_map(|edge| split_at_hanging_node(edge, &corners))
            {
                builder.add_simplex(&[cell.centre(), a, b, end][..=D]);
            }
        }
    }
}

/// Second apex over the edges of a face, if this leaf is the one to fill the face.
fn second_apex<const D: usize>(
    leaves: &OrthTree<D>,
    cell: &OrthCell<D>,
    axis: usize,
    up: bool,
    face: HalfIndex<D>,
) -> Option<HalfIndex<D>> {
    if D == 2 {
        return Some(face);
    }
    match leaves.face_neighbour(cell, axis, up) {
        FaceNeighbour::Outside => Some(face),
        FaceNeighbour::Leaf(leaf) => (up || leaf.level > cell.level).then(|| leaf.centre()),
        FaceNeighbour::Smaller => None,
    }
}

/// Edge, or its two halves where its midpoint is a corner of a leaf.
fn split_at_hanging_node<const D: usize>(
    [a, b]: [HalfIndex<D>; 2],
    corners: &HashSet<HalfIndex<D>>,
) -> Vec<[HalfIndex<D>; 2]> {
    let midpoint = std::array::from_fn(|i| usize::midpoint(a[i], b[i]));
    if corners.contains(&midpoint) { vec![[a, midpoint], [midpoint, b]] } else { vec![[a, b]] }
}

#[cfg(test)]
mod tests {
    use super::super::{CellSplit, Facet, Mesh, OctreeGrading, RectilinearGrid, least_angle, uniform};
    use crate::math::embed;

    /// Half widths and depth, cells.
    const REACH: f64 = 16.0;

    fn grid<const D: usize>() -> RectilinearGrid<D> {
        let axis = |i: usize| if i + 1 == D { uniform(-REACH, 0.0, 1.0) } else { uniform(-REACH, REACH, 1.0) };
        RectilinearGrid { planes: std::array::from_fn(axis), filled: Box::new(|_| true) }
    }

    /// Fast and slow growth, from a point and from a ball.
    fn meshes<const D: usize>() -> Vec<Mesh<D>> {
        let trees = [(0.0, 1e9), (0.0, 0.3), (2.5, 1e9), (3.0, 0.5)].map(|(core, slope)| OctreeGrading {
            coarsest: 8,
            core,
            slope,
        });
        let mesh = |tree| {
            let (points, elements) = grid::<D>().split(CellSplit::Tree(tree));
            Mesh::new(points, elements)
        };
        trees.into_iter().map(mesh).collect()
    }

    fn area<const D: usize>(mesh: &Mesh<D>, facet: &Facet) -> f64 {
        let x = |i: usize| embed(&mesh.rest[facet[i].index()]);
        if D == 2 { (x(1) - x(0)).norm() } else { 0.5 * (x(1) - x(0)).cross(&(x(2) - x(0))).norm() }
    }

    fn is_on_a_side<const D: usize>(mesh: &Mesh<D>, facet: &Facet) -> bool {
        let on = |i: usize, at: f64| facet[..D].iter().all(|node| mesh.rest[node.index()][i] == at);
        (0..D).any(|i| on(i, -REACH) || on(i, if i + 1 == D { 0.0 } else { REACH }))
    }

    fn fills_its_box<const D: usize>(volume: f64, boundary: f64) {
        for mesh in meshes::<D>() {
            let found: f64 = mesh.elements.iter().map(|e| mesh.measure(e)).sum();
            assert!((found / volume - 1.0).abs() < 1e-13);
            // A facet that two elements do not share is one of the boundary: inside, it would be on no side of the box.
            assert!(mesh.facets.iter().all(|facet| is_on_a_side(&mesh, facet)));
            let found: f64 = mesh.facets.iter().map(|facet| area(&mesh, facet)).sum();
            assert!((found / boundary - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn simplices_fill_the_box_and_meet_face_to_face() {
        fills_its_box::<2>(2.0 * REACH * REACH, 6.0 * REACH);
        fills_its_box::<3>(4.0 * REACH.powi(3), 16.0 * REACH * REACH);
    }

    #[test]
    fn without_larger_cells_the_mesh_is_the_centred_one() {
        let tree = OctreeGrading { coarsest: 4, core: 1e9, slope: 1.0 };
        assert!(grid::<2>().split(CellSplit::Tree(tree)) == grid::<2>().split(CellSplit::Centred));
        assert!(grid::<3>().split(CellSplit::Tree(tree)) == grid::<3>().split(CellSplit::Centred));
    }

    #[test]
    fn the_same_tree_gives_the_same_mesh() {
        assert!(meshes::<3>() == meshes::<3>());
    }

    fn least_of_all<const D: usize>() -> f64 {
        let meshes = meshes::<D>();
        let angles = meshes.iter().flat_map(|mesh| mesh.elements.iter().map(|e| least_angle(&mesh.rest, e)));
        angles.fold(180.0, f64::min)
    }

    #[test]
    fn no_angle_is_below_45_degrees_in_the_plane_or_30_in_space() {
        assert!(least_of_all::<2>() > 44.9, "{}", least_of_all::<2>());
        assert!(least_of_all::<3>() > 29.9, "{}", least_of_all::<3>());
    }
}
