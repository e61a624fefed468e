//! Face adjacency of a new mesh, updated from that of the old one.

use super::correspondence::MeshCorrespondence;
use crate::mesh::{ElementId, Facet, Simplex, facet, sorted};

/// Face neighbours of each element, across the facets opposite its nodes.
pub type ElementNeighbours = Vec<[Option<ElementId>; 4]>;

/// Computes the face neighbours of the new elements from those of the old ones; equal to [`crate::mesh::face_neighbours`].
///
/// An unchanged element keeps its neighbours that are unchanged too. All other sides are matched: sides of new
/// elements, sides that lost their neighbour, and old boundary sides between nodes of new elements.
#[must_use]
pub fn neighbours_after<const D: usize>(
    elements: &[Simplex],
    pairing: &MeshCorrespondence,
    old: &[[Option<ElementId>; 4]],
) -> ElementNeighbours {
    let new_of = new_indices(pairing, old.len());
    let is_touched = touched::<D>(elements, pairing);
    let mut across = vec![[None; 4]; elements.len()];
    let mut open: Vec<(Facet, u32)> = vec![];
    for (e, (nodes, same)) in elements.iter().zip(&pairing.same).enumerate() {
        for (k, own) in across[e][..=D].iter_mut().enumerate() {
            let was = same.map(|same| old[same.element.index()][usize::from(same.corners[k])]);
            let side = facet::<D>(nodes, k);
            *own = was.flatten().and_then(|other| new_of[other.index()]);
            let stays_bare = was == Some(None) && !side[..D].iter().all(|node| is_touched[node.index()]);
            if own.is_none() && !stays_bare {
                open.push((sorted::<D>(side), (4 * e + k) as u32));
            }
        }
    }
    open.sort_unstable();
    for pair in open.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 2) {
        let [(e, i), (f, j)] = [pair[0], pair[1]].map(|(_, side)| (side / 4, side as usize % 4));
        across[e as usize][i] = Some(ElementId(f));
        across[f as usize][j] = Some(ElementId(e));
    }
    across
}

/// New index of each old element.
fn new_indices(pairing: &MeshCorrespondence, n_old: usize) -> Vec<Option<ElementId>> {
    let mut new_of = vec![None; n_old];
    for (new, same) in (0..).map(ElementId).zip(&pairing.same) {
        if let Some(same) = same {
            new_of[same.element.index()] = Some(new);
        }
    }
    new_of
}

/// Marks the nodes of changed elements.
fn touched<const D: usize>(elements: &[Simplex], pairing: &MeshCorrespondence) -> Vec<bool> {
    let mut touched = vec![false; pairing.unchanged.len()];
    pairing.changed().flat_map(|e| &elements[e][..=D]).for_each(|node| touched[node.index()] = true);
    touched
}

#[cfg(test)]
mod tests {
    use super::super::test_bodies::TestRandom;
    use super::super::test_meshes::{edited, square};
    use super::super::{BodySymmetry, DeformedMesh, immerse};
    use super::*;
    use crate::math::{Vector, Vector3};
    use crate::mesh::{
        BlockSpec, CellSplit, Mesh, block, boundary, boundary_from_neighbours, face_neighbours, uniform,
    };
    use crate::remesh::ProposedMesh;

    /// Checks that the updated adjacency equals one built from scratch, and returns the number of unchanged elements.
    fn check<const D: usize>(mesh: &Mesh<D>, new: &ProposedMesh<D>) -> usize {
        let pairing = MeshCorrespondence::of(mesh, new);
        let found = neighbours_after::<D>(&new.elements, &pairing, &face_neighbours::<D>(&mesh.elements));
        assert!(found == face_neighbours::<D>(&new.elements), "face_neighbours differ");
        assert_eq!(boundary_from_neighbours::<D>(&new.elements, &found), boundary::<D>(&new.elements));
        pairing.same.iter().flatten().count()
    }

    #[test]
    fn neighbours_after_operations_and_in_an_immersed_mesh_are_those_found_from_nothing() {
        let mut random = TestRandom::new(17);
        let planes = std::array::from_fn(|_| uniform(0.0, 1.0, 0.125));
        let solid = block::<3>(BlockSpec { planes, split: CellSplit::Centred, faces: vec![] });
        let flat = square(12);
        for round in 0..6 {
            let fine = 0.02 + 0.01 * f64::from(round);
            let (coarse, waves) = (0.05 + 0.1 * random.next(), 5.0 * random.next());
            let bent = |x: &Vector<3>| Vector3::new(x.x * (1.0 + 0.3 * x.z), x.y, x.z * (1.0 + 0.2 * x.y));
            let position: Vec<_> = solid.rest.iter().map(bent).collect();
            let old = DeformedMesh { mesh: &solid, position: &position };
            let size = |x: &Vector<3>| (coarse + 0.3 * x.x) * (1.0 + 0.1 * (waves * x.y).sin());
            let new = edited(&old, BodySymmetry::Spatial, &size);
            let stay = check(&solid, &new);
            assert!(stay > 0 && stay < new.elements.len(), "{stay} of {} stay", new.elements.len());
            let position: Vec<_> =
                flat.rest.iter().map(|x| Vector::<2>::new(x[0] * (1.0 + 0.3 * x[1]), x[1])).collect();
            let old = DeformedMesh { mesh: &flat, position: &position };
            let size = |x: &Vector<2>| fine + 0.1 * x[0];
            let new = edited(&old, BodySymmetry::Planar, &size);
            let stay = check(&flat, &new);
            assert!(stay > 0 && stay < new.elements.len(), "{stay} of {} stay", new.elements.len());
            let sizes: Vec<f64> = position.iter().map(size).collect();
            check(&flat, &immerse(&old, &sizes).unwrap().proposal);
        }
    }
}
