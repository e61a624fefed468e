//! Which loads act on the facets of a new mesh: those of the old facets that they take the place of.

use super::Origin;
use crate::algebra::{Vector, Vector3, embed};
use crate::mesh::{ElementId, Facet, Incidence, Mesh, NodeId};

/// The loads of each node that act on some of its facets and not on others; empty where there are no loads. Where one is named
/// the loaded face ends, and the surface may not be made of other facets across it.
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
    found.into_iter().map(|(some, all)| some & !all).collect()
}

/// The marks of new facets, whose nodes come from there and were at rest there; empty where there are no loads.
///
/// A facet has the mark of the old one that its middle was nearest to at rest, among those that its nodes lie on and that face
/// as it does.
#[must_use]
pub fn marks<const D: usize>(old: &Mesh<D>, (facets, rest): (&[Facet], &[Vector<D>]), origin: &[Origin]) -> Vec<u8> {
    if old.marks.is_empty() {
        return vec![];
    }
    let around = Incidence::new(old.rest.len(), old.facets.iter().map(|facet| &facet[..D]));
    let corners = |facet: &Facet, x: &[Vector<D>]| facet.map(|node| embed(&x[node.index()]));
    let mark = |facet: &Facet| {
        let own = Face::<D>(corners(facet, rest));
        let distance = |old_facet: ElementId| {
            let face = Face::<D>(corners(&old.facets[old_facet.index()], &old.rest));
            let apart = face.distance(&own.middle());
            (face.normal().dot(&own.normal()) <= 0.0, apart, old_facet)
        };
        let candidates = facet[..D].iter().flat_map(|node| lies_on::<D>(&origin[node.index()], (old, &around)));
        let before = |a: &(bool, f64, ElementId), b: &(bool, f64, ElementId)| {
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2))
        };
        candidates.map(distance).min_by(before).map_or(0, |(.., nearest)| old.marks[nearest.index()])
    };
    facets.iter().map(mark).collect()
}

/// The old facets that a new node lies on.
fn lies_on<const D: usize>(origin: &Origin, (old, around): (&Mesh<D>, &Incidence)) -> Vec<ElementId> {
    let (first, others): (NodeId, Vec<NodeId>) = match *origin {
        Origin::Kept(node) => (node, vec![]),
        Origin::Surface(nodes, weights) => {
            let mut parents = nodes.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0).map(|(node, _)| node);
            let Some(first) = parents.next() else { return vec![] };
            (first, parents.collect())
        }
        Origin::Inside => return vec![],
    };
    let has_all = |facet: &&ElementId| others.iter().all(|node| old.facets[facet.index()][..D].contains(node));
    around.of(first).iter().filter(has_all).copied().collect()
}

/// A facet by its corners; an edge of the plane has the third where the second is.
struct Face<const D: usize>([Vector3; 3]);

impl<const D: usize> Face<D> {
    fn middle(&self) -> Vector3 {
        self.0[..D].iter().sum::<Vector3>() / D as f64
    }

    /// Along the outward normal; not of length 1.
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
