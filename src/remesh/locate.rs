//! Which triangles are near: boxes in a binary tree along a Morton curve, so that grading does no harm.

use super::Triangle;
use crate::algebra::Vector;

/// Triangles per leaf.
const LEAF: usize = 4;
/// Bits per direction of the Morton curve: two neighbours in a cell of 2⁻¹⁶ of the body may stand in any order.
const BITS: u32 = 16;

/// An upright box; the empty one has `low` above `high`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub low: Vector<2>,
    pub high: Vector<2>,
}

impl Bounds {
    const EMPTY: Self = Self {
        low: Vector::<2>::new(f64::INFINITY, f64::INFINITY),
        high: Vector::<2>::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// The least box around points.
    pub fn around(points: &[Vector<2>]) -> Self {
        points.iter().fold(Self::EMPTY, |bounds, p| bounds.joined(&Self { low: *p, high: *p }))
    }

    fn joined(&self, other: &Self) -> Self {
        let pick = |a: &Vector<2>, b: &Vector<2>, least: fn(f64, f64) -> f64| {
            Vector::<2>::new(least(a[0], b[0]), least(a[1], b[1]))
        };
        Self { low: pick(&self.low, &other.low, f64::min), high: pick(&self.high, &other.high, f64::max) }
    }

    fn meets(&self, other: &Self) -> bool {
        self.low[0] <= other.high[0]
            && other.low[0] <= self.high[0]
            && self.low[1] <= other.high[1]
            && other.low[1] <= self.high[1]
    }

    /// Squared distance of a point, 0 inside; infinite for the empty box.
    fn distance(&self, p: &Vector<2>) -> f64 {
        let outside = |i: usize| (self.low[i] - p[i]).max(p[i] - self.high[i]).max(0.0);
        outside(0) * outside(0) + outside(1) * outside(1)
    }
}

/// A place in a triangle: x = Σ weights x_a.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    /// Which of the triangles.
    pub triangle: usize,
    /// Weights of its corners, none negative, of sum 1.
    pub weights: [f64; 3],
    /// Squared distance from the point that was asked for, m².
    pub distance: f64,
}

/// A search tree over triangles.
pub(super) struct Locator<'a> {
    triangles: &'a [Triangle],
    /// The triangles along the curve.
    order: Vec<u32>,
    /// Box of every node of the tree: node k has the children 2k and 2k + 1, and the leaves stand last.
    boxes: Vec<Bounds>,
}

impl<'a> Locator<'a> {
    /// Of these triangles.
    pub fn new(triangles: &'a [Triangle]) -> Self {
        let order = along_a_curve(triangles);
        let leaves = order.len().div_ceil(LEAF).next_power_of_two();
        let mut boxes = vec![Bounds::EMPTY; 2 * leaves];
        for (leaf, members) in order.chunks(LEAF).enumerate() {
            boxes[leaves + leaf] =
                members.iter().fold(Bounds::EMPTY, |b, t| b.joined(&Bounds::around(&triangles[*t as usize].corners)));
        }
        for node in (1..leaves).rev() {
            boxes[node] = boxes[2 * node].joined(&boxes[2 * node + 1]);
        }
        Self { triangles, order, boxes }
    }

    /// Visits the triangles whose leaf meets a box, in the order of the curve.
    pub fn near(&self, wanted: &Bounds, mut visit: impl FnMut(usize)) {
        let all = self.walk(wanted, |t| {
            visit(t);
            None::<()>
        });
        debug_assert!(all.is_none(), "nothing ends the walk");
    }

    /// The place nearest to a point, of equal ones the first along the curve; none if there is no triangle.
    pub fn nearest(&self, p: &Vector<2>) -> Option<Place> {
        let here = Bounds { low: *p, high: *p };
        self.walk(&here, |t| self.triangles[t].place(p, t)).or_else(|| self.nearest_outside(p))
    }

    /// Visits the triangles whose leaf meets a box, in the order of the curve, until one gives an answer.
    fn walk<T>(&self, wanted: &Bounds, mut visit: impl FnMut(usize) -> Option<T>) -> Option<T> {
        let mut stack = [1_usize; usize::BITS as usize];
        let mut open = 1;
        while open > 0 {
            open -= 1;
            let node = stack[open];
            if !self.boxes[node].meets(wanted) {
                continue;
            }
            if let Some(members) = self.members(node) {
                let answer = members.iter().find_map(|t| visit(*t as usize));
                if answer.is_some() {
                    return answer;
                }
            } else {
                stack[open] = 2 * node + 1;
                stack[open + 1] = 2 * node;
                open += 2;
            }
        }
        None
    }

    fn nearest_outside(&self, p: &Vector<2>) -> Option<Place> {
        let mut best: Option<Place> = None;
        let mut stack = vec![1_usize];
        while let Some(node) = stack.pop() {
            if best.is_some_and(|best| self.boxes[node].distance(p) >= best.distance) {
                continue;
            }
            if let Some(members) = self.members(node) {
                for t in members {
                    let place = self.triangles[*t as usize].nearest(p, *t as usize);
                    best = Some(best.filter(|best| best.distance <= place.distance).unwrap_or(place));
                }
            } else {
                let [first, second] = [2 * node, 2 * node + 1];
                let swap = self.boxes[second].distance(p) < self.boxes[first].distance(p);
                stack.extend(if swap { [first, second] } else { [second, first] });
            }
        }
        best
    }

    /// The triangles of a leaf; none for a node that is not one.
    fn members(&self, node: usize) -> Option<&[u32]> {
        let leaf = node.checked_sub(self.boxes.len() / 2)?;
        let end = self.order.len();
        Some(&self.order[(leaf * LEAF).min(end)..((leaf + 1) * LEAF).min(end)])
    }
}

/// The triangles along a Morton curve through their middles.
fn along_a_curve(triangles: &[Triangle]) -> Vec<u32> {
    let middle = |t: &Triangle| t.corners.iter().sum::<Vector<2>>() / 3.0;
    let all = triangles.iter().fold(Bounds::EMPTY, |b, t| b.joined(&Bounds::around(&t.corners)));
    let extent = (all.high - all.low).amax().max(f64::MIN_POSITIVE);
    let cells = f64::from(1_u32 << BITS);
    let code = |t: &Triangle| {
        let at = (middle(t) - all.low) * (cells / extent);
        [at[0], at[1]].map(|i| i.clamp(0.0, cells - 1.0) as u32)
    };
    let mut keys: Vec<(u32, u32)> =
        triangles.iter().enumerate().map(|(i, t)| (interleaved(code(t)), i as u32)).collect();
    keys.sort_unstable();
    keys.into_iter().map(|(_, i)| i).collect()
}

/// The bits of two numbers below 2¹⁶ in turn.
fn interleaved([x, z]: [u32; 2]) -> u32 {
    let spread = |n: u32| {
        let n = (n | n << 8) & 0x00ff_00ff;
        let n = (n | n << 4) & 0x0f0f_0f0f;
        let n = (n | n << 2) & 0x3333_3333;
        (n | n << 1) & 0x5555_5555
    };
    spread(x) | spread(z) << 1
}

#[cfg(test)]
mod tests {
    use super::super::bodies::{Random, jittered_square};
    use super::*;
    use crate::mesh::Mesh;

    fn triangles(mesh: &Mesh<2>) -> Vec<Triangle> {
        mesh.elements.iter().map(|e| Triangle::of(&mesh.rest, e)).collect()
    }

    #[test]
    fn near_finds_every_triangle_whose_box_meets_the_wanted_one() {
        let mut random = Random::new(3);
        let all = triangles(&jittered_square(9, &mut random));
        let locator = Locator::new(&all);
        for _ in 0..200 {
            let [a, b] = [(); 2].map(|()| Vector::<2>::new(random.next(), random.next()));
            let wanted = Bounds::around(&[a, a + (b - a) * 0.2]);
            let mut found = vec![];
            locator.near(&wanted, |t| found.push(t));
            for (t, triangle) in all.iter().enumerate() {
                let times = found.iter().filter(|&&f| f == t).count();
                let meets = Bounds::around(&triangle.corners).meets(&wanted);
                assert!(times == 1 || (times == 0 && !meets), "triangle {t} found {times} times");
            }
        }
    }

    #[test]
    fn the_nearest_place_is_the_nearest_of_all() {
        let mut random = Random::new(5);
        let all = triangles(&jittered_square(7, &mut random));
        let locator = Locator::new(&all);
        for _ in 0..300 {
            let p = Vector::<2>::new(3.0 * random.next() - 1.0, 3.0 * random.next() - 1.0);
            let place = locator.nearest(&p).unwrap();
            let least = all.iter().map(|t| t.nearest(&p, 0).distance).fold(f64::INFINITY, f64::min);
            assert_eq!(place.distance, least);
            let inside = (0.0..=1.0).contains(&p[0]) && (0.0..=1.0).contains(&p[1]);
            assert_eq!(inside, place.distance < 1e-24, "{p}");
        }
        assert!(Locator::new(&[]).nearest(&Vector::<2>::zeros()).is_none());
    }
}
