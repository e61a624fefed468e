//! Division of the old mesh into the retained region and the open region.

use super::DeformedMesh;
use super::boundary_resampling::NewBoundary;
use super::delaunay::WIDE;
use super::point_insertion::QualityLimits;
use super::point_set::PointSet;
use super::triangle::{circumcircle, quality};
use crate::mesh::{ElementId, NodeId, NodeIncidence, Simplex};

/// Circumradius, in target sizes, above which an element is not retained: slightly larger than the refinement limit, so
/// that a fresh mesh is not remeshed.
const TOO_WIDE: f64 = 1.1 * WIDE;

/// Retained and open elements of the old mesh.
#[derive(Debug, Clone)]
pub(super) struct RegionDivision {
    /// Elements retained in the new mesh.
    pub kept: Vec<ElementId>,
    /// Elements that are remeshed.
    pub open: Vec<ElementId>,
    /// Boundary edges of the open region.
    pub edges: Vec<[usize; 2]>,
}

/// Worst quality of the deformed elements of each old node.
pub(super) fn worst(old: &DeformedMesh<'_, 2>) -> Vec<f64> {
    let mut worst = vec![f64::MAX; old.position.len()];
    for nodes in old.mesh.elements.iter().map(corners) {
        let q = quality(nodes.map(|n| &old.position[n]));
        for n in nodes {
            worst[n] = worst[n].min(q);
        }
    }
    worst
}

/// Retains the elements whose nodes are all chosen, that touch good elements only, are not too wide and lost no
/// boundary edge. The open region is bounded by the edges that occur an odd number of times among those elements and
/// the new boundary.
pub(super) fn divide_regions(
    old: &DeformedMesh<'_, 2>,
    worst: &[f64],
    limits: &QualityLimits,
    cloud: &PointSet,
    surface: &NewBoundary,
) -> RegionDivision {
    let at_lost = lost(old, surface);
    let mut parts = RegionDivision { kept: vec![], open: vec![], edges: vec![] };
    for ((e, simplex), at_lost) in (0..).map(ElementId).zip(&old.mesh.elements).zip(at_lost) {
        let nodes = corners(simplex);
        let size = nodes.iter().map(|&n| cloud.size[n]).sum::<f64>() / 3.0;
        let (_, radius) = circumcircle(nodes.map(|n| &old.position[n]));
        let stays =
            !at_lost && radius <= TOO_WIDE * size && nodes.iter().all(|&n| cloud.chosen[n] && worst[n] >= limits.good);
        if stays { parts.kept.push(e) } else { parts.open.push(e) }
    }
    let kept: Vec<[usize; 3]> = parts.kept.iter().map(|e| corners(&old.mesh.elements[e.index()])).collect();
    parts.edges = odd_edges(&kept, &surface.edges);
    parts
}

impl RegionDivision {
    /// Joins the elements of the new mesh: retained ones in their old order, then the others.
    pub fn joined(mut self, old: &DeformedMesh<'_, 2>, filled: &[[usize; 3]]) -> Vec<[usize; 3]> {
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

/// Marks the old elements with a boundary edge that the new boundary lacks.
fn lost(old: &DeformedMesh<'_, 2>, surface: &NewBoundary) -> Vec<bool> {
    let mut lost = vec![false; old.mesh.elements.len()];
    if surface.lost.is_empty() {
        return lost;
    }
    let incidence = NodeIncidence::new(old.position.len(), old.mesh.elements.iter().map(|e| &e[..3]));
    for [a, b] in &surface.lost {
        let node = NodeId(*a as u32);
        for e in incidence.of(node) {
            lost[e.index()] |= corners(&old.mesh.elements[e.index()]).contains(b);
        }
    }
    lost
}

/// Edges that occur an odd number of times among the boundary and these elements, in order.
fn odd_edges(elements: &[[usize; 3]], boundary: &[[usize; 2]]) -> Vec<[usize; 2]> {
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
