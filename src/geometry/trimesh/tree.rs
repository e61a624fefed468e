//! Bounding volume hierarchy of axis-aligned boxes over triangles.

use super::closest::{ClosestPoint, closest_point};
use crate::math::Vector3;

/// Bounding volume hierarchy over triangles.
#[derive(Debug, Clone)]
pub(super) struct TriangleTree {
    /// Branches in depth-first order: the left half of a branch is the next branch.
    branches: Vec<TreeBranch>,
    /// Triangles and their corners, leaf by leaf.
    leaves: Vec<(u32, [Vector3; 3])>,
}

/// Axis-aligned bounding box.
#[derive(Debug, Clone, Copy)]
struct AlignedBox {
    lower: Vector3,
    upper: Vector3,
}

#[derive(Debug, Clone, Copy)]
/// Node of the hierarchy.
struct TreeBranch {
    span: AlignedBox,
    content: BranchContent,
}

#[derive(Debug, Clone, Copy)]
/// Content of a branch.
enum BranchContent {
    /// Range of leaves.
    Leaves(usize, usize),
    /// Index of the right half; the left half follows the branch.
    Halves(usize),
}

/// Nearest triangle found so far.
#[derive(Debug, Clone, Copy)]
pub(super) struct NearestTriangle {
    pub triangle: u32,
    pub closest: ClosestPoint,
}

/// Triangles of a leaf at most. From 2 to 8 the time of a query differs by a tenth.
const LEAF: usize = 4;

impl AlignedBox {
    /// Bounding box of points.
    fn of(corners: &[Vector3]) -> Self {
        let (lower, upper) = corners.iter().fold((corners[0], corners[0]), |(l, u), p| (l.inf(p), u.sup(p)));
        Self { lower, upper }
    }

    /// Union of two boxes.
    fn union(&self, other: &Self) -> Self {
        Self { lower: self.lower.inf(&other.lower), upper: self.upper.sup(&other.upper) }
    }

    /// Squared distance of a point, m²; 0 inside.
    fn square_distance(&self, p: &Vector3) -> f64 {
        (p - p.sup(&self.lower).inf(&self.upper)).norm_squared()
    }

    /// Support function of the box along a direction.
    fn reach(&self, direction: &Vector3) -> f64 {
        (0..3).map(|i| (self.lower[i] * direction[i]).max(self.upper[i] * direction[i])).sum()
    }

    /// Returns true if two boxes overlap or touch.
    fn meets(&self, other: &Self) -> bool {
        (0..3).all(|i| self.lower[i] <= other.upper[i] && other.lower[i] <= self.upper[i])
    }
}

impl TriangleTree {
    /// Builds the hierarchy over at least one triangle.
    pub fn new(corners: impl Iterator<Item = [Vector3; 3]>) -> Self {
        let leaves: Vec<(u32, [Vector3; 3])> = (0..).zip(corners).collect();
        let mut tree = Self { branches: Vec::with_capacity(leaves.len()), leaves };
        tree.divide(0, tree.leaves.len());
        tree
    }

    /// Splits the leaves from `start` to `end` at the median of their centroids, across the longest side of their box.
    fn divide(&mut self, start: usize, end: usize) {
        let leaves = &mut self.leaves[start..end];
        let spans = leaves.iter().map(|(_, corners)| AlignedBox::of(corners));
        let span = spans.reduce(|all, one| all.union(&one)).expect("a branch has leaves");
        let own = self.branches.len();
        self.branches.push(TreeBranch { span, content: BranchContent::Leaves(start, end) });
        if leaves.len() <= LEAF {
            return;
        }
        let axis = (span.upper - span.lower).imax();
        let middle = |(_, corners): &(u32, [Vector3; 3])| corners.iter().map(|p| p[axis]).sum::<f64>();
        let half = leaves.len() / 2;
        leaves.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)).then(a.0.cmp(&b.0)));
        self.divide(start, start + half);
        self.branches[own].content = BranchContent::Halves(self.branches.len());
        self.divide(start + half, end);
    }

    /// Finds the triangle nearest to a point.
    pub fn nearest(&self, p: &Vector3) -> NearestTriangle {
        let (triangle, corners) = &self.leaves[0];
        let mut best = NearestTriangle { triangle: *triangle, closest: closest_point(corners, p) };
        self.descend_nearest(0, p, &mut best);
        best
    }

    fn descend_nearest(&self, branch: usize, p: &Vector3, best: &mut NearestTriangle) {
        match self.branches[branch].content {
            BranchContent::Leaves(start, end) => {
                for (triangle, corners) in &self.leaves[start..end] {
                    let found = closest_point(corners, p);
                    if found.square < best.closest.square {
                        *best = NearestTriangle { triangle: *triangle, closest: found };
                    }
                }
            }
            BranchContent::Halves(right) => {
                let mut halves = [branch + 1, right].map(|half| (self.branches[half].span.square_distance(p), half));
                if halves[1].0 < halves[0].0 {
                    halves.swap(0, 1);
                }
                for (square, half) in halves {
                    if square < best.closest.square {
                        self.descend_nearest(half, p, best);
                    }
                }
            }
        }
    }

    /// Support function: the greatest extent along a unit vector.
    pub fn reach(&self, direction: &Vector3) -> f64 {
        let mut best = f64::NEG_INFINITY;
        self.descend_reach(0, direction, &mut best);
        best
    }

    fn descend_reach(&self, branch: usize, direction: &Vector3, best: &mut f64) {
        match self.branches[branch].content {
            BranchContent::Leaves(start, end) => {
                let corners = self.leaves[start..end].iter().flat_map(|(_, corners)| corners);
                *best = corners.map(|p| p.dot(direction)).fold(*best, f64::max);
            }
            BranchContent::Halves(right) => {
                let mut halves = [branch + 1, right].map(|half| (self.branches[half].span.reach(direction), half));
                if halves[1].0 > halves[0].0 {
                    halves.swap(0, 1);
                }
                for (reach, half) in halves {
                    if reach > *best {
                        self.descend_reach(half, direction, best);
                    }
                }
            }
        }
    }

    /// Visits every triangle whose leaf box overlaps the box of `points`.
    pub fn visit_near(&self, points: &[Vector3], visit: &mut impl FnMut(u32, &[Vector3; 3])) {
        self.descend_near(0, &AlignedBox::of(points), visit);
    }

    fn descend_near(&self, branch: usize, span: &AlignedBox, visit: &mut impl FnMut(u32, &[Vector3; 3])) {
        if !self.branches[branch].span.meets(span) {
            return;
        }
        match self.branches[branch].content {
            BranchContent::Leaves(start, end) => {
                self.leaves[start..end].iter().for_each(|(triangle, corners)| visit(*triangle, corners));
            }
            BranchContent::Halves(right) => {
                self.descend_near(branch + 1, span, visit);
                self.descend_near(right, span, visit);
            }
        }
    }
}
