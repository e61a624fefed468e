//! Points inside: old nodes that are good where they are, and middles of tree cells where nothing is near.

use super::boundary_loops::Surface;
use super::bounds::Bounds;
use super::box_tree::Near;
use super::point_set::Cloud;
use super::quadtree::{Square, leaves};
use super::triangle::{Point, clearance, distance, shares};
use super::{Moved, Origin, RemeshError};
use crate::mesh::Simplex;

/// No old node stays if another point is nearer than this many target sizes, and no new point is put where one is nearer than
/// `NEW`; to the boundary the limits are `KEPT_INSIDE` and `NEW_INSIDE`. Old nodes are given more room to vary than new ones,
/// so that a mesh that was just made is not made again. Right-angled lattices have their nodes 0.71 cells apart and half a
/// cell from the boundary: limits above these would thin them out.
const KEPT: f64 = 0.6;
/// See `KEPT`.
pub(super) const NEW: f64 = 0.75;
const KEPT_INSIDE: f64 = 0.4;
/// See `KEPT`.
const NEW_INSIDE: f64 = 0.5;

/// How good the elements of each old node are.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(super) struct Limits {
    /// Nodes of elements below this quality do not stay inside.
    pub poor: f64,
    /// Nodes all of whose elements are at least this good choose first.
    pub good: f64,
}

/// Chooses old nodes inside by the worst quality of their elements, the good ones first; nodes that are held stay.
pub(super) fn keep(old: &Moved<'_, 2>, worst: &[f64], limits: &Limits, cloud: &mut Cloud, surface: &Surface) {
    let x = old.position;
    let is_held = |n: usize| old.mesh.held[n] != [false; 2];
    let mut is_boundary = vec![false; x.len()];
    old.mesh.facets.iter().flat_map(|f| &f[..2]).for_each(|n| is_boundary[n.index()] = true);
    let can_stay = |n: &usize| !is_boundary[*n] && worst[*n] < f64::MAX && (worst[*n] > limits.poor || is_held(*n));
    let inside: Vec<usize> = (0..x.len()).filter(can_stay).collect();
    let bound = (0..cloud.position.len()).filter(|&p| cloud.chosen[p]);
    let all: Vec<usize> = bound.chain(inside.iter().copied()).collect();
    let near = Near::points(all.iter().map(|&p| cloud.position[p]));
    let is_good = |n: &usize| worst[*n] >= limits.good;
    let ranks: [&dyn Fn(&usize) -> bool; 3] =
        [&|n| is_held(*n), &|n| !is_held(*n) && is_good(n), &|n| !is_held(*n) && !is_good(n)];
    for rank in ranks {
        for &node in inside.iter().filter(|n| rank(n)) {
            let reach = KEPT * cloud.size[node];
            let is_taken = |i: usize| cloud.chosen[all[i]] && distance(&x[node], &cloud.position[all[i]]) < reach;
            cloud.chosen[node] = is_held(node)
                || !near.any(&Bounds::about(&x[node], reach), is_taken)
                    && !surface.is_near(&cloud.position, &x[node], KEPT_INSIDE * cloud.size[node]);
        }
    }
}

/// Chooses middles of tree cells in the part of the body that is filled anew, of so many cells at most.
///
/// # Errors
/// [`RemeshError::TooMany`] if there would be more.
pub(super) fn fill(
    part: &Part<'_>,
    (square, most): (&Square, usize),
    cloud: &mut Cloud,
    limits: &Surface,
) -> Result<(), RemeshError> {
    let leaves = leaves(square, |middle, half| part.least(middle, half), most)?;
    let candidates: Vec<(Point, f64)> =
        leaves.into_iter().filter_map(|(middle, _)| part.size(&middle).map(|size| (middle, size))).collect();
    let taken: Vec<Point> = (0..cloud.position.len()).filter(|&p| cloud.chosen[p]).map(|p| cloud.position[p]).collect();
    scatter(&candidates, &taken, cloud, limits);
    Ok(())
}

/// Adds those of the candidates, places and sizes, that are near none of the points taken, none before them and no edge; gives
/// their numbers.
pub(super) fn scatter(candidates: &[(Point, f64)], taken: &[Point], cloud: &mut Cloud, limits: &Surface) -> Vec<usize> {
    let place = |i: usize| taken.get(i).copied().unwrap_or_else(|| candidates[i - taken.len()].0);
    let all = taken.len() + candidates.len();
    let near = Near::points((0..all).map(place));
    let mut chosen = vec![true; taken.len()];
    let mut numbers = vec![];
    chosen.resize(all, false);
    for (i, (middle, size)) in (taken.len()..).zip(candidates) {
        let reach = NEW * size;
        let is_taken = |j: usize| chosen[j] && distance(middle, &place(j)) < reach;
        chosen[i] = !near.any(&Bounds::about(middle, reach), is_taken)
            && !limits.is_near(&cloud.position, middle, NEW_INSIDE * size);
        if chosen[i] {
            numbers.push(cloud.add(*middle, *size, Origin::Inside));
        }
    }
    numbers
}

impl Surface {
    /// Whether a point is nearer than `reach` to one of its edges.
    pub fn is_near(&self, x: &[Point], point: &Point, reach: f64) -> bool {
        self.near.any(&Bounds::about(point, reach), |i| clearance(self.edges[i].map(|n| &x[n]), point) < reach)
    }
}

/// The old elements that are not taken over, and the sizes on them.
pub(super) struct Part<'a> {
    x: &'a [Point],
    size: &'a [f64],
    elements: Vec<Simplex>,
    near: Near<2>,
}

impl<'a> Part<'a> {
    /// The part of these elements, in the order of their mesh.
    pub fn new(old: &Moved<'a, 2>, size: &'a [f64], elements: Vec<Simplex>) -> Self {
        let bounds: Vec<Bounds<2>> =
            elements.iter().map(|e| Bounds::around(e[..3].iter().map(|n| &old.position[n.index()]))).collect();
        Self { x: old.position, size, near: Near::new(&bounds), elements }
    }

    /// The nodes of its elements.
    pub fn nodes(&self) -> impl Iterator<Item = usize> {
        self.elements.iter().flat_map(|e| &e[..3]).map(|n| n.index())
    }

    /// Target size at a point, m, linear over its element; none outside.
    pub fn size(&self, point: &Point) -> Option<f64> {
        let mut size = None;
        self.near.any(&Bounds::about(point, 0.0), |e| {
            size = self.size_in(e, point);
            size.is_some()
        });
        size
    }

    fn size_in(&self, e: usize, point: &Point) -> Option<f64> {
        let (shares, sizes) = (self.shares(e, point), self.sizes(e));
        let is_inside = shares.iter().all(|share| *share >= 0.0);
        is_inside.then(|| sizes.iter().zip(shares).map(|(h, share)| h * share).sum())
    }

    /// The least of the sizes on the elements about a square, m: of each that at its middle, within those of its nodes. None
    /// where there are no elements.
    pub fn least(&self, middle: &Point, half: f64) -> Option<f64> {
        let mut least: Option<f64> = None;
        self.near.any(&Bounds::about(middle, half), |e| {
            let (shares, sizes) = (self.shares(e, middle), self.sizes(e));
            let [low, high] = [sizes.iter().copied().fold(f64::MAX, f64::min), sizes.into_iter().fold(0.0, f64::max)];
            let there: f64 = sizes.iter().zip(shares).map(|(h, share)| h * share).sum();
            let there = if there.is_finite() { there.clamp(low, high) } else { low };
            least = Some(least.map_or(there, |least| least.min(there)));
            there < 2.0 * half
        });
        least
    }

    fn shares(&self, e: usize, point: &Point) -> [f64; 3] {
        shares([0, 1, 2].map(|k| &self.x[self.elements[e][k].index()]), point)
    }

    fn sizes(&self, e: usize) -> [f64; 3] {
        [0, 1, 2].map(|k| self.size[self.elements[e][k].index()])
    }
}
