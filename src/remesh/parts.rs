//! Which old elements are taken over as they are, and the edges around the rest.

use super::Moved;
use super::cloud::Cloud;
use super::delaunay::WIDE;
use super::points::Limits;
use super::shape::{circumcircle, quality};
use super::surface::Surface;
use crate::mesh::{Incidence, Simplex};

/// An element whose circumscribed circle is larger than this many target sizes is not taken over: a little larger than one that
/// gets a new point, so that a mesh that was just made is not made again.
const TOO_WIDE: f64 = 1.1 * WIDE;

/// The old elements by what becomes of them.
#[derive(Debug, Clone)]
pub(super) struct Parts {
    /// Those that are elements of the new mesh, by their nodes.
    pub kept: Vec<[usize; 3]>,
    /// Those whose place is filled anew.
    pub open: Vec<Simplex>,
    /// The edges around what is filled anew.
    pub edges: Vec<[usize; 2]>,
}

/// The worst quality of the elements of each old node where it is.
pub(super) fn worst(old: &Moved<'_, 2>) -> Vec<f64> {
    let mut worst = vec![f64::MAX; old.position.len()];
    for nodes in old.mesh.elements.iter().map(corners) {
        let q = quality(nodes.map(|n| &old.position[n]));
        for n in nodes {
            worst[n] = worst[n].min(q);
        }
    }
    worst
}

/// Takes over the elements whose nodes are all chosen, none of which touches one that is not good, and which are not too
/// large. What is left is bounded by the edges that are odd in number among theirs and those of the new boundary.
pub(super) fn divide(old: &Moved<'_, 2>, worst: &[f64], limits: &Limits, cloud: &Cloud, surface: &Surface) -> Parts {
    let at_lost = lost(old, surface);
    let mut parts = Parts { kept: vec![], open: vec![], edges: vec![] };
    for (simplex, at_lost) in old.mesh.elements.iter().zip(at_lost) {
        let nodes = corners(simplex);
        let size = nodes.iter().map(|&n| cloud.size[n]).sum::<f64>() / 3.0;
        let (_, radius) = circumcircle(nodes.map(|n| &old.position[n]));
        let stays =
            !at_lost && radius <= TOO_WIDE * size && nodes.iter().all(|&n| cloud.chosen[n] && worst[n] >= limits.good);
        if stays {
            parts.kept.push(nodes);
        } else {
            parts.open.push(*simplex);
        }
    }
    parts.edges = odd(&parts.kept, &surface.edges);
    parts
}

/// Whether each old element has an edge of the old boundary that is none of the new one.
fn lost(old: &Moved<'_, 2>, surface: &Surface) -> Vec<bool> {
    let mut lost = vec![false; old.mesh.elements.len()];
    if surface.lost.is_empty() {
        return lost;
    }
    let incidence = Incidence::new(old.position.len(), old.mesh.elements.iter().map(|e| &e[..3]));
    for [a, b] in &surface.lost {
        let node = crate::mesh::NodeId(*a as u32);
        for e in incidence.of(node) {
            lost[e.index()] |= corners(&old.mesh.elements[e.index()]).contains(b);
        }
    }
    lost
}

/// Edges that are odd in number among those of the boundary and of these elements, in order.
fn odd(elements: &[[usize; 3]], boundary: &[[usize; 2]]) -> Vec<[usize; 2]> {
    let sides = elements.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut edges: Vec<[usize; 2]> = sides.chain(boundary.iter().copied()).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).filter(|same| same.len() % 2 == 1).map(|same| same[0]).collect()
}

fn corners(simplex: &Simplex) -> [usize; 3] {
    [0, 1, 2].map(|k| simplex[k].index())
}
