//! Which old elements are taken over as they are, and the edges around the rest.

use super::Moved;
use super::boundary_loops::Surface;
use super::delaunay::WIDE;
use super::point_insertion::Limits;
use super::point_set::Cloud;
use super::triangle::{circumcircle, quality};
use crate::mesh::{ElementId, Incidence, NodeId, Simplex};

/// An element whose circumscribed circle is larger than this many target sizes is not taken over: a little larger than one that
/// gets a new point, so that a mesh that was just made is not made again.
const TOO_WIDE: f64 = 1.1 * WIDE;

/// The old elements by what becomes of them.
#[derive(Debug, Clone)]
pub(super) struct Parts {
    /// Those that are elements of the new mesh.
    pub kept: Vec<ElementId>,
    /// Those whose place is filled anew.
    pub open: Vec<ElementId>,
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
    for ((e, simplex), at_lost) in (0..).map(ElementId).zip(&old.mesh.elements).zip(at_lost) {
        let nodes = corners(simplex);
        let size = nodes.iter().map(|&n| cloud.size[n]).sum::<f64>() / 3.0;
        let (_, radius) = circumcircle(nodes.map(|n| &old.position[n]));
        let stays =
            !at_lost && radius <= TOO_WIDE * size && nodes.iter().all(|&n| cloud.chosen[n] && worst[n] >= limits.good);
        if stays { parts.kept.push(e) } else { parts.open.push(e) }
    }
    let kept: Vec<[usize; 3]> = parts.kept.iter().map(|e| corners(&old.mesh.elements[e.index()])).collect();
    parts.edges = odd(&kept, &surface.edges);
    parts
}

impl Parts {
    /// The elements of the new mesh: those that are elements of the old one in its order, then the others.
    pub fn joined(mut self, old: &Moved<'_, 2>, filled: &[[usize; 3]]) -> Vec<[usize; 3]> {
        let mut keys: Vec<([usize; 3], usize)> =
            filled.iter().enumerate().map(|(i, nodes)| (sorted(*nodes), i)).collect();
        keys.sort_unstable();
        let mut is_old = vec![false; filled.len()];
        for e in self.open {
            let key = sorted(corners(&old.mesh.elements[e.index()]));
            if let Ok(found) = keys.binary_search_by_key(&key, |(key, _)| *key) {
                is_old[keys[found].1] = true;
                self.kept.push(e);
            }
        }
        self.kept.sort_unstable();
        let new = filled.iter().zip(is_old).filter(|(_, is_old)| !is_old).map(|(nodes, _)| *nodes);
        self.kept.iter().map(|e| corners(&old.mesh.elements[e.index()])).chain(new).collect()
    }
}

/// Whether each old element has an edge of the old boundary that is none of the new one.
fn lost(old: &Moved<'_, 2>, surface: &Surface) -> Vec<bool> {
    let mut lost = vec![false; old.mesh.elements.len()];
    if surface.lost.is_empty() {
        return lost;
    }
    let incidence = Incidence::new(old.position.len(), old.mesh.elements.iter().map(|e| &e[..3]));
    for [a, b] in &surface.lost {
        let node = NodeId(*a as u32);
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

fn sorted(mut nodes: [usize; 3]) -> [usize; 3] {
    nodes.sort_unstable();
    nodes
}

fn corners(simplex: &Simplex) -> [usize; 3] {
    [0, 1, 2].map(|k| simplex[k].index())
}
