//! Which triangles are near: boxes around halves of halves of them.

use super::closest::{Closest, closest};
use crate::math::Vector3;

/// A hierarchy of boxes around triangles.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    /// Depth first: the left half of a branch is the next one.
    branches: Vec<Branch>,
    /// The triangles with their corners, leaf by leaf.
    leaves: Vec<(u32, [Vector3; 3])>,
}

/// A box along the axes.
#[derive(Debug, Clone, Copy)]
struct Span {
    lower: Vector3,
    upper: Vector3,
}

#[derive(Debug, Clone, Copy)]
struct Branch {
    span: Span,
    content: Content,
}

#[derive(Debug, Clone, Copy)]
enum Content {
    /// The leaves from one up to another.
    Leaves(usize, usize),
    /// The branch that is the right half.
    Halves(usize),
}

/// The nearest triangle found so far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearest {
    pub triangle: u32,
    pub closest: Closest,
}

/// Triangles in the last box. From 2 to 8 the time of a query differs by a tenth.
const LEAF: usize = 4;

impl Span {
    fn of(corners: &[Vector3]) -> Self {
        let (lower, upper) = corners.iter().fold((corners[0], corners[0]), |(l, u), p| (l.inf(p), u.sup(p)));
        Self { lower, upper }
    }

    fn with(&self, other: &Self) -> Self {
        Self { lower: self.lower.inf(&other.lower), upper: self.upper.sup(&other.upper) }
    }

    /// Square of the distance of a point; 0 inside.
    fn square(&self, p: &Vector3) -> f64 {
        (p - p.sup(&self.lower).inf(&self.upper)).norm_squared()
    }

    /// Greatest extent along a direction.
    fn reach(&self, direction: &Vector3) -> f64 {
        (0..3).map(|i| (self.lower[i] * direction[i]).max(self.upper[i] * direction[i])).sum()
    }

    fn meets(&self, other: &Self) -> bool {
        (0..3).all(|i| self.lower[i] <= other.upper[i] && other.lower[i] <= self.upper[i])
    }
}

impl Tree {
    /// The tree of these triangles, of which there is at least one.
    pub fn new(corners: impl Iterator<Item = [Vector3; 3]>) -> Self {
        let leaves: Vec<(u32, [Vector3; 3])> = (0..).zip(corners).collect();
        let mut tree = Self { branches: Vec::with_capacity(leaves.len()), leaves };
        tree.divide(0, tree.leaves.len());
        tree
    }

    /// Halves the leaves from `start` to `end` at the median of their middles, across the longest side of their box.
    fn divide(&mut self, start: usize, end: usize) {
        let leaves = &mut self.leaves[start..end];
        let spans = leaves.iter().map(|(_, corners)| Span::of(corners));
        let span = spans.reduce(|all, one| all.with(&one)).expect("a branch has leaves");
        let own = self.branches.len();
        self.branches.push(Branch { span, content: Content::Leaves(start, end) });
        if leaves.len() <= LEAF {
            return;
        }
        let axis = (span.upper - span.lower).imax();
        let middle = |(_, corners): &(u32, [Vector3; 3])| corners.iter().map(|p| p[axis]).sum::<f64>();
        let half = leaves.len() / 2;
        leaves.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)).then(a.0.cmp(&b.0)));
        self.divide(start, start + half);
        self.branches[own].content = Content::Halves(self.branches.len());
        self.divide(start + half, end);
    }

    /// The triangle nearest to a point.
    pub fn nearest(&self, p: &Vector3) -> Nearest {
        let (triangle, corners) = &self.leaves[0];
        let mut best = Nearest { triangle: *triangle, closest: closest(corners, p) };
        self.descend(0, p, &mut best);
        best
    }

    fn descend(&self, branch: usize, p: &Vector3, best: &mut Nearest) {
        match self.branches[branch].content {
            Content::Leaves(start, end) => {
                for (triangle, corners) in &self.leaves[start..end] {
                    let found = closest(corners, p);
                    if found.square < best.closest.square {
                        *best = Nearest { triangle: *triangle, closest: found };
                    }
                }
            }
            Content::Halves(right) => {
                let mut halves = [branch + 1, right].map(|half| (self.branches[half].span.square(p), half));
                if halves[1].0 < halves[0].0 {
                    halves.swap(0, 1);
                }
                for (square, half) in halves {
                    if square < best.closest.square {
                        self.descend(half, p, best);
                    }
                }
            }
        }
    }

    /// Greatest extent along a unit vector.
    pub fn reach(&self, direction: &Vector3) -> f64 {
        let mut best = f64::NEG_INFINITY;
        self.stretch(0, direction, &mut best);
        best
    }

    fn stretch(&self, branch: usize, direction: &Vector3, best: &mut f64) {
        match self.branches[branch].content {
            Content::Leaves(start, end) => {
                let corners = self.leaves[start..end].iter().flat_map(|(_, corners)| corners);
                *best = corners.map(|p| p.dot(direction)).fold(*best, f64::max);
            }
            Content::Halves(right) => {
                let mut halves = [branch + 1, right].map(|half| (self.branches[half].span.reach(direction), half));
                if halves[1].0 > halves[0].0 {
                    halves.swap(0, 1);
                }
                for (reach, half) in halves {
                    if reach > *best {
                        self.stretch(half, direction, best);
                    }
                }
            }
        }
    }

    /// Shows every triangle whose box meets that of these points.
    pub fn around(&self, points: &[Vector3], visit: &mut impl FnMut(u32, &[Vector3; 3])) {
        self.meeting(0, &Span::of(points), visit);
    }

    fn meeting(&self, branch: usize, span: &Span, visit: &mut impl FnMut(u32, &[Vector3; 3])) {
        if !self.branches[branch].span.meets(span) {
            return;
        }
        match self.branches[branch].content {
            Content::Leaves(start, end) => {
                self.leaves[start..end].iter().for_each(|(triangle, corners)| visit(*triangle, corners));
            }
            Content::Halves(right) => {
                self.meeting(branch + 1, span, visit);
                self.meeting(right, span, visit);
            }
        }
    }
}
