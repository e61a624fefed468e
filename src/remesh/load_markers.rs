//! Load markers of the facets of a new mesh, inherited from the old facets.

use super::NodeOrigin;
use crate::math::{Vector, Vector3, embed, map_in_order};
use crate::mesh::{CAVITY_MARK, ElementId, Facet, Mesh, NodeId, NodeIncidence, sorted};
use std::collections::{BTreeMap, BTreeSet};

/// Least number of facets whose markers a thread finds.
const FACETS_PER_THREAD: usize = 64;

/// Loads of each node that act on some of its facets only; empty where there are no loads. At such a node the loaded
/// face ends, and its facets may not be remade across it. The wall of a cavity ends at the edges of the entry surface,
/// where no air acts, and leaves the mesh as it is without a cavity.
pub(super) fn ends<const D: usize>(mesh: &Mesh<D>) -> Vec<u8> {
    if mesh.marks.is_empty() {
        return vec![];
    }
    let mut found = vec![(0_u8, u8::MAX); mesh.rest.len()];
    for (facet, mark) in mesh.facets.iter().zip(&mesh.marks) {
        for node in &facet[..D] {
            let (some, all) = &mut found[node.index()];
            (*some, *all) = (*some | mark, *all & mark);
        }
    }
    found.into_iter().map(|(some, all)| some & !all & !CAVITY_MARK).collect()
}

/// Computes the load markers of new facets from the origin and rest positions of their nodes; empty where there are no
/// loads.
///
/// A facet inherits the marker of the old facet nearest to its centroid at rest, among those that contain its nodes and
/// face the same way. Facets of a plane of symmetry or of an axis hand theirs on to facets that lie in it alone. A facet
/// that inherits none, inside before, belongs to the wall of the cavity if it adjoins it.
#[must_use]
pub fn facet_load_markers<const D: usize>(
    old: &Mesh<D>,
    (facets, rest): (&[Facet], &[Vector<D>]),
    origin: &[NodeOrigin],
) -> Vec<u8> {
    if old.marks.is_empty() {
        return vec![];
    }
    let around = NodeIncidence::new(old.rest.len(), old.facets.iter().map(|facet| &facet[..D]));
    let mark = |facet: &Facet| {
        let candidates = facet[..D].iter().flat_map(|node| lies_on::<D>(&origin[node.index()], (old, &around)));
        nearest_mark(old, facet, rest, candidates)
    };
    spread_cavity_mark::<D>(facets, &map_in_order(facets, FACETS_PER_THREAD, mark))
}

/// Computes the load markers of new facets that lie at rest where old facets lie; empty where there are no loads.
/// `unchanged` has the old node of each node between unchanged elements.
#[must_use]
pub fn facet_load_markers_at_rest<const D: usize>(
    old: &Mesh<D>,
    facets: &[Facet],
    rest: &[Vector<D>],
    unchanged: &[Option<NodeId>],
) -> Vec<u8> {
    if old.marks.is_empty() {
        return vec![];
    }
    let known: BTreeMap<Facet, u8> =
        old.facets.iter().zip(&old.marks).map(|(facet, mark)| (sorted::<D>(*facet), *mark)).collect();
    let mark = |facet: &Facet| {
        let was = facet.map(|node| unchanged[node.index()]);
        let same = was.iter().all(Option::is_some).then(|| sorted::<D>(was.map(Option::unwrap_or_default)));
        let all = (0..old.facets.len() as u32).map(ElementId);
        same.and_then(|same| known.get(&same).copied()).or_else(|| nearest_mark(old, facet, rest, all)).unwrap_or(0)
    };
    facets.iter().map(mark).collect()
}

/// Marker of the old facet among `candidates` that is nearest to a new one at rest and faces the same way.
fn nearest_mark<const D: usize>(
    old: &Mesh<D>,
    facet: &Facet,
    rest: &[Vector<D>],
    candidates: impl Iterator<Item = ElementId>,
) -> Option<u8> {
    let corners = |facet: &Facet, x: &[Vector<D>]| facet.map(|node| embed(&x[node.index()]));
    let own = FacetCorners::<D>(corners(facet, rest));
    let distance = |old_facet: ElementId| {
        let face = FacetCorners::<D>(corners(&old.facets[old_facet.index()], &old.rest));
        let apart = face.distance(&own.middle());
        (face.normal().dot(&own.normal()) <= 0.0, apart, old_facet)
    };
    let is_off = |axis: &usize| facet[..D].iter().any(|node| rest[node.index()][*axis] != 0.0);
    let off_planes: Vec<usize> = (0..D - 1).filter(is_off).collect();
    let is_in_other_plane = |old_facet: &ElementId| off_planes.iter().any(|axis| is_in_mirror(old, *old_facet, *axis));
    let before = |a: &(bool, f64, ElementId), b: &(bool, f64, ElementId)| {
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2))
    };
    let candidates: Vec<ElementId> = candidates.filter(|old_facet| !is_in_other_plane(old_facet)).collect();
    let mark = |old_facet: &ElementId| old.marks[old_facet.index()];
    // Most facets lie among others of their marker.
    if candidates.windows(2).all(|two| mark(&two[0]) == mark(&two[1])) {
        return candidates.first().map(mark);
    }
    candidates.into_iter().map(distance).min_by(before).map(|(.., nearest)| mark(&nearest))
}

/// Returns the load markers with those of the facets that were inside before: that of the cavity if a row of such facets
/// connects them with its wall, none otherwise.
#[must_use]
pub fn spread_cavity_mark<const D: usize>(facets: &[Facet], inherited: &[Option<u8>]) -> Vec<u8> {
    let mut marks: Vec<u8> = inherited.iter().map(|mark| mark.unwrap_or(0)).collect();
    let mut fresh: Vec<usize> = (0..facets.len()).filter(|i| inherited[*i].is_none()).collect();
    if fresh.is_empty() || marks.iter().all(|mark| mark & CAVITY_MARK == 0) {
        return marks;
    }
    let is_wall = |mark: u8| mark & CAVITY_MARK != 0;
    let walls = facets.iter().zip(&marks).filter(|(_, mark)| is_wall(**mark));
    let mut nodes: BTreeSet<NodeId> = walls.flat_map(|(facet, _)| facet[..D].iter().copied()).collect();
    loop {
        let (joined, apart): (Vec<usize>, Vec<usize>) =
            fresh.into_iter().partition(|i| facets[*i][..D].iter().any(|node| nodes.contains(node)));
        if joined.is_empty() {
            return marks;
        }
        for i in joined {
            marks[i] |= CAVITY_MARK;
            nodes.extend(&facets[i][..D]);
        }
        fresh = apart;
    }
}

/// Returns true if a facet lies at rest in the plane through the origin normal to an axis, and is held there.
fn is_in_mirror<const D: usize>(mesh: &Mesh<D>, facet: ElementId, axis: usize) -> bool {
    let is_there = |node: &NodeId| mesh.held[node.index()][axis] && mesh.rest[node.index()][axis] == 0.0;
    mesh.facets[facet.index()][..D].iter().all(is_there)
}

/// Old facets that contain a new node.
fn lies_on<const D: usize>(origin: &NodeOrigin, (old, around): (&Mesh<D>, &NodeIncidence)) -> Vec<ElementId> {
    let (first, others): (NodeId, Vec<NodeId>) = match *origin {
        NodeOrigin::Kept(node) => (node, vec![]),
        NodeOrigin::Surface(nodes, weights) => {
            let mut parents = nodes.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0).map(|(node, _)| node);
            let Some(first) = parents.next() else { return vec![] };
            (first, parents.collect())
        }
        NodeOrigin::Inside => return vec![],
    };
    let has_all = |facet: &&ElementId| others.iter().all(|node| old.facets[facet.index()][..D].contains(node));
    around.of(first).iter().filter(has_all).copied().collect()
}

/// Corners of a facet; an edge of the plane repeats its second corner.
struct FacetCorners<const D: usize>([Vector3; 3]);

impl<const D: usize> FacetCorners<D> {
    fn middle(&self) -> Vector3 {
        self.0[..D].iter().sum::<Vector3>() / D as f64
    }

    /// Normal in the outward direction, not normalised.
    fn normal(&self) -> Vector3 {
        let [a, b, c] = &self.0;
        if D == 2 { Vector3::y().cross(&(b - a)) } else { (b - a).cross(&(c - a)) }
    }

    /// Distance of a point, m.
    fn distance(&self, p: &Vector3) -> f64 {
        let [a, b, c] = &self.0;
        let sides = if D == 2 { &[(a, b)][..] } else { &[(a, b), (b, c), (c, a)] };
        let to_sides = sides.iter().map(|(a, b)| to_segment(p, a, b)).fold(f64::INFINITY, f64::min);
        let n = self.normal();
        let is_over = D == 3 && sides.iter().all(|(a, b)| (*b - *a).cross(&(p - *a)).dot(&n) >= 0.0);
        if is_over { (p - a).dot(&n).abs() / n.norm() } else { to_sides }
    }
}

fn to_segment(p: &Vector3, a: &Vector3, b: &Vector3) -> f64 {
    let along = b - a;
    let share = ((p - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    if share.is_finite() { (p - (a + along * share)).norm() } else { (p - a).norm() }
}

#[cfg(test)]
mod tests {
    use super::super::test_meshes::{edited, square};
    use super::super::{BodySymmetry, DeformedMesh, ProposedMesh, immerse};
    use super::*;
    use crate::mesh::{BlockSpec, CellSplit, block, boundary, facet_measure, uniform};

    /// Marks the first half of the side of least last coordinate with 1, the side of greatest first coordinate with 2.
    fn marked<const D: usize>(mut mesh: Mesh<D>) -> Mesh<D> {
        let all = |facet: &Facet, is_there: &dyn Fn(&Vector<D>) -> bool| {
            facet[..D].iter().all(|node| is_there(&mesh.rest[node.index()]))
        };
        let mark = |facet: &Facet| {
            u8::from(all(facet, &|x| x[D - 1] == 0.0 && x[0] <= 0.5)) + 2 * u8::from(all(facet, &|x| x[0] == 1.0))
        };
        mesh.marks = mesh.facets.iter().map(mark).collect();
        mesh
    }

    /// Measure at rest that each load acts on after a remesh.
    fn loaded<const D: usize>(old: &Mesh<D>, new: &ProposedMesh<D>) -> [f64; 2] {
        let rest = |origin: &NodeOrigin| match origin {
            NodeOrigin::Kept(node) => old.rest[node.index()],
            NodeOrigin::Surface(nodes, weights) => {
                nodes.iter().zip(weights).map(|(n, w)| old.rest[n.index()] * *w).sum()
            }
            NodeOrigin::Inside => Vector::<D>::zeros(),
        };
        let (facets, rest) = (boundary::<D>(&new.elements), new.origin.iter().map(rest).collect::<Vec<_>>());
        let marks = facet_load_markers(old, (&facets, &rest), &new.origin);
        let sum = |bit: u8| {
            let own = facets.iter().zip(&marks).filter(|(_, mark)| **mark >> bit & 1 == 1);
            own.map(|(facet, _)| facet_measure(&rest, facet)).sum()
        };
        [0, 1].map(sum)
    }

    #[test]
    fn loaded_sides_stay_loaded_and_no_others_in_the_plane() {
        let mesh = marked(square(12));
        let position: Vec<_> =
            mesh.rest.iter().map(|x| Vector::<2>::new(x[0] * (1.0 + 0.3 * x[1]), x[1] + 0.2 * x[0] * x[0])).collect();
        let old = DeformedMesh { mesh: &mesh, position: &position };
        for size in [0.04, 0.11, 0.3] {
            let sizes = vec![size; position.len()];
            let edited = edited(&old, BodySymmetry::Planar, &|_| size);
            let immersed = immerse(&old, &sizes).unwrap().proposal;
            // An immersed body may lose the tip of a corner, up to an edge.
            for (new, most) in [(edited, 1e-12), (immersed, 1.1 * size)] {
                let [half, whole] = loaded(&mesh, &new);
                assert!((half - 0.5).abs() < 1e-12 && (whole - 1.0).abs() < most, "{size}: {half} {whole}");
            }
        }
    }

    #[test]
    fn loaded_sides_stay_loaded_and_no_others_in_space() {
        let planes = std::array::from_fn(|_| uniform(0.0, 1.0, 0.125));
        let mesh = marked(block::<3>(BlockSpec { planes, split: CellSplit::Centred, faces: vec![] }));
        let position: Vec<_> =
            mesh.rest.iter().map(|x| Vector3::new(x.x * (1.0 + 0.3 * x.z), x.y, x.z * (1.0 + 0.2 * x.y))).collect();
        let old = DeformedMesh { mesh: &mesh, position: &position };
        for size in [0.07, 0.12, 0.3] {
            let new = edited(&old, BodySymmetry::Spatial, &|_| size);
            let [half, whole] = loaded(&mesh, &new);
            assert!((half - 0.5).abs() < 1e-9 && (whole - 1.0).abs() < 1e-9, "{size}: {half} {whole}");
            assert!(new.elements != mesh.elements || size == 0.12, "{size}: nothing was changed");
        }
    }

    #[test]
    fn the_wall_of_a_cavity_grows_over_facets_that_were_inside_and_adjoin_it() {
        let chain = |from: u32| [NodeId(from), NodeId(from + 1), NodeId(from + 1)];
        // A side, a row of three fresh facets, the wall; a fresh facet elsewhere.
        let facets = [chain(0), chain(1), chain(2), chain(3), chain(4), chain(8)];
        let inherited = [Some(1), None, None, None, Some(CAVITY_MARK | 2), None];
        let marks = spread_cavity_mark::<2>(&facets, &inherited);
        assert_eq!(marks, [1, CAVITY_MARK, CAVITY_MARK, CAVITY_MARK, CAVITY_MARK | 2, 0]);
        // Loads do not spread.
        let loaded = inherited.map(|mark| mark.map(|mark| mark & !CAVITY_MARK));
        assert_eq!(spread_cavity_mark::<2>(&facets, &loaded), [1, 0, 0, 0, 2, 0]);
    }
}
