//! Where a new triangle lies over an old one, and the exact integrals over that.

use super::Triangle;

/// A corner of an overlap: its weights in the old triangle and in the new one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Corner {
    old: [f64; 3],
    new: [f64; 3],
}

/// Corners at most: rounding may bend a polygon of n corners so that a cut leaves k + 2 min(k, n − k) of them, 4 after
/// the first of three, 6 after the second and 9 after the third.
const MOST: usize = 9;

/// The convex polygon that an old and a new triangle have in common.
///
/// Its corners are known by their weights in both triangles alone, so that what is linear in either is at hand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Overlap {
    corners: [Corner; MOST],
    n_corners: usize,
}

/// Integrals over an overlap, of the old density ρ, the new shape functions N and the old ones λ.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Moments {
    /// ∫ρ N_i N_j, kg.
    pub inertia: [[f64; 3]; 3],
    /// ∫ρ N_i λ_a, kg.
    pub mixed: [[f64; 3]; 3],
}

impl Overlap {
    /// Of an upright old triangle and a new one; none if they have no area in common.
    ///
    /// The new triangle is cut along the sides of the old one, λ_a = 0, one after the other.
    pub fn of(old: &Triangle, new: &Triangle) -> Option<Self> {
        const UNIT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let weights = new.corners.map(|p| old.weights(&p));
        if (0..3).any(|side| weights.iter().all(|w| w[side] <= 0.0)) {
            return None;
        }
        let mut overlap = Self { corners: [Corner::default(); MOST], n_corners: 0 };
        for (old, new) in weights.into_iter().zip(UNIT) {
            overlap.push(Corner { old, new });
        }
        for side in 0..3 {
            if weights.iter().any(|w| w[side] < 0.0) {
                overlap = overlap.cut(side);
            }
        }
        (overlap.n_corners > 2).then_some(overlap)
    }

    fn push(&mut self, corner: Corner) {
        self.corners[self.n_corners] = corner;
        self.n_corners += 1;
    }

    fn corners(&self) -> &[Corner] {
        &self.corners[..self.n_corners]
    }

    /// The part where the weight of this corner of the old triangle is not negative.
    fn cut(&self, side: usize) -> Self {
        let mut rest = Self { n_corners: 0, ..*self };
        let inside = |corner: &Corner| corner.old[side] >= 0.0;
        let followers = self.corners().iter().cycle().skip(1);
        for (here, next) in self.corners().iter().zip(followers) {
            if inside(here) {
                rest.push(*here);
            }
            match (inside(here), inside(next)) {
                (true, false) => rest.push(here.towards(next, side)),
                (false, true) => rest.push(next.towards(here, side)),
                (true, true) | (false, false) => {}
            }
        }
        rest
    }

    /// The integrals, of a density whose values at the corners of the old triangle times its area are `heights`, kg.
    ///
    /// In a triangle of area A ∫ρ f g = Σ_pq W_pq f_p g_q for linear ρ, f and g, with the values h_p = Aρ_p at its
    /// corners: W_pp = h_p/10 + (h_q + h_r)/30 and W_pq = (h_p + h_q)/30 + h_r/60.
    pub fn moments(&self, heights: &[f64; 3]) -> Moments {
        let mut sum = Moments::default();
        let corners = self.corners();
        for pair in corners[1..].windows(2) {
            let triangle = [corners[0], pair[0], pair[1]];
            let part = share(&triangle);
            let h = triangle.map(|corner| part * dot(&corner.old, heights));
            sum.add(&triangle, &inertia(&h));
        }
        sum
    }
}

impl Corner {
    /// Where the way to a corner beyond a side meets the side.
    fn towards(&self, beyond: &Self, side: usize) -> Self {
        let t = self.old[side] / (self.old[side] - beyond.old[side]);
        let between = |a: &[f64; 3], b: &[f64; 3]| std::array::from_fn(|i| a[i] + t * (b[i] - a[i]));
        let mut met = Self { old: between(&self.old, &beyond.old), new: between(&self.new, &beyond.new) };
        met.old[side] = 0.0;
        met
    }
}

impl Moments {
    fn add(&mut self, triangle: &[Corner; 3], w: &[[f64; 3]; 3]) {
        for i in 0..3 {
            let shape = triangle.map(|corner| corner.new[i]);
            let weighted = w.map(|row| dot(&row, &shape));
            for (p, corner) in triangle.iter().enumerate() {
                for j in 0..3 {
                    self.inertia[i][j] += weighted[p] * corner.new[j];
                    self.mixed[i][j] += weighted[p] * corner.old[j];
                }
            }
        }
    }
}

/// ∫ρ N_i N_j of a triangle whose density times its area is `heights` at its corners, kg.
pub(super) fn inertia(heights: &[f64; 3]) -> [[f64; 3]; 3] {
    let sum: f64 = heights.iter().sum();
    let entry = |i: usize, j: usize| {
        if i == j { (sum + 2.0 * heights[i]) / 30.0 } else { (sum + heights[i] + heights[j]) / 60.0 }
    };
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

/// Area of a triangle as a part of that of the old one.
fn share(triangle: &[Corner; 3]) -> f64 {
    let [a, b, c] = triangle.map(|corner| corner.old);
    let [u, v] = [b, c].map(|other| [other[1] - a[1], other[2] - a[2]]);
    u[0] * v[1] - u[1] * v[0]
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
