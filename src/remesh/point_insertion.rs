//! Interior points: old nodes that are good, and quadtree cell centres where no point is near.

use super::boundary_resampling::NewBoundary;
use super::point_set::PointSet;
use super::quadtree::{RootSquare, leaves};
use super::triangle::{PlanarPoint, barycentric, clearance, distance};
use super::{DeformedMesh, NodeOrigin, RemeshError};
use crate::geometry::{BoundingBox, Bvh};
use crate::mesh::Simplex;

/// Least distances between points in target sizes: `KEPT` for old nodes, `NEW` for new points, `KEPT_INSIDE` and
/// `NEW_INSIDE` to the boundary. Old nodes may vary more than new points, so that a fresh mesh is not remeshed.
/// Right-angled lattices have nodes 0.71 cells apart and half a cell from the boundary: greater limits would thin them
/// out.
const KEPT: f64 = 0.6;
/// See `KEPT`.
pub(super) const NEW: f64 = 0.75;
const KEPT_INSIDE: f64 = 0.4;
/// See `KEPT`.
const NEW_INSIDE: f64 = 0.5;

/// Quality limits for old nodes.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(super) struct QualityLimits {
    /// Quality of an element below which its interior nodes are removed.
    pub poor: f64,
    /// Quality of all elements of a node from which it is chosen first.
    pub good: f64,
}

/// Chooses old interior nodes by the worst quality of their elements, the good ones first; held nodes stay.
pub(super) fn keep(
    old: &DeformedMesh<'_, 2>,
    worst: &[f64],
    limits: &QualityLimits,
    cloud: &mut PointSet,
    surface: &NewBoundary,
) {
    let x = old.position;
    let is_held = |n: usize| old.mesh.held[n] != [false; 2];
    let mut is_boundary = vec![false; x.len()];
    old.mesh.facets.iter().flat_map(|f| &f[..2]).for_each(|n| is_boundary[n.index()] = true);
    let can_stay = |n: &usize| !is_boundary[*n] && worst[*n] < f64::MAX && (worst[*n] > limits.poor || is_held(*n));
    let inside: Vec<usize> = (0..x.len()).filter(can_stay).collect();
    let bound = (0..cloud.position.len()).filter(|&p| cloud.chosen[p]);
    let all: Vec<usize> = bound.chain(inside.iter().copied()).collect();
    let near = Bvh::points(all.iter().map(|&p| cloud.position[p]));
    let is_good = |n: &usize| worst[*n] >= limits.good;
    let ranks: [&dyn Fn(&usize) -> bool; 3] =
        [&|n| is_held(*n), &|n| !is_held(*n) && is_good(n), &|n| !is_held(*n) && !is_good(n)];
    for rank in ranks {
        for &node in inside.iter().filter(|n| rank(n)) {
            let reach = KEPT * cloud.size[node];
            let is_taken = |i: usize| cloud.chosen[all[i]] && distance(&x[node], &cloud.position[all[i]]) < reach;
            cloud.chosen[node] = is_held(node)
                || !near.any(&BoundingBox::about(&x[node], reach), is_taken)
                    && !surface.is_near(&cloud.position, &x[node], KEPT_INSIDE * cloud.size[node]);
        }
    }
}

/// Inserts centres of quadtree cells in the open region, at most `most` cells.
///
/// # Errors
/// [`RemeshError::TooMany`] if there would be more cells.
pub(super) fn fill(
    part: &OpenRegion<'_>,
    (square, most): (&RootSquare, usize),
    cloud: &mut PointSet,
    limits: &NewBoundary,
) -> Result<(), RemeshError> {
    let leaves = leaves(square, |middle, half| part.least(middle, half), most)?;
    let candidates: Vec<(PlanarPoint, f64)> =
        leaves.into_iter().filter_map(|(middle, _)| part.size(&middle).map(|size| (middle, size))).collect();
    let taken: Vec<PlanarPoint> =
        (0..cloud.position.len()).filter(|&p| cloud.chosen[p]).map(|p| cloud.position[p]).collect();
    scatter(&candidates, &taken, cloud, limits);
    Ok(())
}

/// Adds the candidates, positions with sizes, that are near no taken point, no earlier candidate and no edge. Returns
/// their indices.
pub(super) fn scatter(
    candidates: &[(PlanarPoint, f64)],
    taken: &[PlanarPoint],
    cloud: &mut PointSet,
    limits: &NewBoundary,
) -> Vec<usize> {
    let place = |i: usize| taken.get(i).copied().unwrap_or_else(|| candidates[i - taken.len()].0);
    let all = taken.len() + candidates.len();
    let near = Bvh::points((0..all).map(place));
    let mut chosen = vec![true; taken.len()];
    let mut numbers = vec![];
    chosen.resize(all, false);
    for (i, (middle, size)) in (taken.len()..).zip(candidates) {
        let reach = NEW * size;
        let is_taken = |j: usize| chosen[j] && distance(middle, &place(j)) < reach;
        chosen[i] = !near.any(&BoundingBox::about(middle, reach), is_taken)
            && !limits.is_near(&cloud.position, middle, NEW_INSIDE * size);
        if chosen[i] {
            numbers.push(cloud.add(*middle, *size, NodeOrigin::Inside));
        }
    }
    numbers
}

impl NewBoundary {
    /// Returns true if a point is nearer than `reach` to one of the edges.
    pub fn is_near(&self, x: &[PlanarPoint], point: &PlanarPoint, reach: f64) -> bool {
        self.near.any(&BoundingBox::about(point, reach), |i| clearance(self.edges[i].map(|n| &x[n]), point) < reach)
    }
}

/// Open region: the old elements that are remeshed, with their target sizes.
pub(super) struct OpenRegion<'a> {
    x: &'a [PlanarPoint],
    size: &'a [f64],
    elements: Vec<Simplex>,
    near: Bvh<2>,
}

impl<'a> OpenRegion<'a> {
    /// Builds the region from elements in the order of their mesh.
    pub fn new(old: &DeformedMesh<'a, 2>, size: &'a [f64], elements: Vec<Simplex>) -> Self {
        let bounds: Vec<BoundingBox<2>> =
            elements.iter().map(|e| BoundingBox::around(e[..3].iter().map(|n| &old.position[n.index()]))).collect();
        Self { x: old.position, size, near: Bvh::new(&bounds), elements }
    }

    /// Nodes of its elements.
    pub fn nodes(&self) -> impl Iterator<Item = usize> {
        self.elements.iter().flat_map(|e| &e[..3]).map(|n| n.index())
    }

    /// Target size at a point, m, linear over its element; none outside.
    pub fn size(&self, point: &PlanarPoint) -> Option<f64> {
        let mut size = None;
        self.near.any(&BoundingBox::about(point, 0.0), |e| {
            size = self.size_in(e, point);
            size.is_some()
        });
        size
    }

    fn size_in(&self, e: usize, point: &PlanarPoint) -> Option<f64> {
        let (barycentric, sizes) = (self.barycentric(e, point), self.sizes(e));
        let is_inside = barycentric.iter().all(|share| *share >= 0.0);
        is_inside.then(|| sizes.iter().zip(barycentric).map(|(h, share)| h * share).sum())
    }

    /// Least target size on the elements about a square, m. Each element is evaluated at the centre, clamped to its
    /// nodal sizes. None where there are no elements.
    pub fn least(&self, middle: &PlanarPoint, half: f64) -> Option<f64> {
        let mut least: Option<f64> = None;
        self.near.any(&BoundingBox::about(middle, half), |e| {
            let (barycentric, sizes) = (self.barycentric(e, middle), self.sizes(e));
            let [low, high] = [sizes.iter().copied().fold(f64::MAX, f64::min), sizes.into_iter().fold(0.0, f64::max)];
            let there: f64 = sizes.iter().zip(barycentric).map(|(h, share)| h * share).sum();
            let there = if there.is_finite() { there.clamp(low, high) } else { low };
            least = Some(least.map_or(there, |least| least.min(there)));
            there < 2.0 * half
        });
        least
    }

    fn barycentric(&self, e: usize, point: &PlanarPoint) -> [f64; 3] {
        barycentric([0, 1, 2].map(|k| &self.x[self.elements[e][k].index()]), point)
    }

    fn sizes(&self, e: usize) -> [f64; 3] {
        [0, 1, 2].map(|k| self.size[self.elements[e][k].index()])
    }
}
