//! Symmetric tensors of eight elements in vector lanes.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::load_lanes;
use super::history::{HistoryLanes, shape_rows};
use crate::math::Number;
use fearless_simd::{Simd, SimdBase, f64x8};

/// Symmetric tensor: the components i ≤ j, and the out-of-plane component, 0 in space.
#[derive(Clone, Copy)]
pub(super) struct SymmetricTensor<const D: usize, V> {
    pub inner: [[V; D]; D],
    pub out: V,
}

impl<const D: usize, V: Number> SymmetricTensor<D, V> {
    /// Creates a diagonal tensor, `inner` on the diagonal and `out` out of the plane.
    #[inline(always)]
    pub fn diagonal(inner: V, out: V) -> Self {
        let mut all = [[inner.constant(0.0); D]; D];
        for i in 0..D {
            all[i][i] = inner;
        }
        Self { inner: all, out }
    }

    /// Returns component (i, j).
    #[inline(always)]
    pub fn of(&self, i: usize, j: usize) -> V {
        self.inner[i.min(j)][i.max(j)]
    }

    /// Returns the trace.
    #[inline(always)]
    pub fn trace(&self) -> V {
        let mut sum = self.out;
        for i in 0..D {
            sum = sum + self.inner[i][i];
        }
        sum
    }

    /// Returns the deviator b − tr b/3.
    #[inline(always)]
    pub fn deviator(&self) -> Self {
        let (mean, mut all) = (self.trace() * (1.0 / 3.0), *self);
        for i in 0..D {
            all.inner[i][i] = all.inner[i][i] - mean;
        }
        if D == 2 {
            all.out = all.out - mean;
        }
        all
    }

    /// Returns the double contraction a:b.
    #[inline(always)]
    pub fn dot(&self, other: &Self) -> V {
        let mut sum = self.out * other.out;
        for i in 0..D {
            sum = sum + self.inner[i][i] * other.inner[i][i];
            for j in i + 1..D {
                sum = sum + self.inner[i][j] * other.inner[i][j] * 2.0;
            }
        }
        sum
    }

    /// Returns the square a a.
    #[inline(always)]
    pub fn squared(&self) -> Self {
        let mut all = Self { out: self.out * self.out, ..*self };
        for i in 0..D {
            for j in i..D {
                let mut sum = self.of(i, 0) * self.of(0, j);
                for k in 1..D {
                    sum = sum + self.of(i, k) * self.of(k, j);
                }
                all.inner[i][j] = sum;
            }
        }
        all
    }

    /// Returns the determinant.
    #[inline(always)]
    pub fn determinant(&self) -> V {
        let b = &self.inner;
        if D == 2 {
            return (b[0][0] * b[1][1] - b[0][1] * b[0][1]) * self.out;
        }
        let (x, y, z) = (0, 1, 2 % D);
        b[x][x] * (b[y][y] * b[z][z] - b[y][z] * b[y][z]) - b[x][y] * (b[x][y] * b[z][z] - b[y][z] * b[x][z])
            + b[x][z] * (b[x][y] * b[y][z] - b[y][y] * b[x][z])
    }

    /// Returns the inverse of a tensor of unit determinant.
    #[inline(always)]
    pub fn inverse(&self) -> Self {
        let (b, mut all) = (&self.inner, *self);
        if D == 2 {
            (all.inner[0][0], all.inner[1][1]) = (b[1][1] * self.out, b[0][0] * self.out);
            all.inner[0][1] = -(b[0][1] * self.out);
            all.out = b[0][0] * b[1][1] - b[0][1] * b[0][1];
            return all;
        }
        for i in 0..D {
            for j in i..D {
                let (k, l, m, n) = ((i + 1) % D, (i + 2) % D, (j + 1) % D, (j + 2) % D);
                all.inner[i][j] = self.of(k, m) * self.of(l, n) - self.of(k, n) * self.of(l, m);
            }
        }
        all
    }

    /// Returns θ + s d, θ = `mean`, s = `part`.
    #[inline(always)]
    pub fn scaled(&self, part: V, mean: V) -> Self {
        let mut all = *self;
        for i in 0..D {
            for j in i..D {
                all.inner[i][j] = all.inner[i][j] * part;
            }
            all.inner[i][i] = all.inner[i][i] + mean;
        }
        if D == 2 {
            all.out = all.out * part + mean;
        }
        all
    }

    /// Returns the linear combination `part` · self + `other_part` · other.
    #[inline(always)]
    pub fn combined(&self, part: f64, other: &Self, other_part: V) -> Self {
        let mut all = *self;
        for i in 0..D {
            for j in i..D {
                all.inner[i][j] = self.inner[i][j] * part + other.inner[i][j] * other_part;
            }
        }
        if D == 2 {
            all.out = self.out * part + other.out * other_part;
        }
        all
    }

    /// Returns `self` in the lanes where `which` is positive, else `other`.
    #[inline(always)]
    pub fn where_positive(&self, which: V, other: &Self) -> Self {
        let mut all = *self;
        for i in 0..D {
            for j in i..D {
                all.inner[i][j] = which.choose(self.inner[i][j], other.inner[i][j]);
            }
        }
        if D == 2 {
            all.out = which.choose(self.out, other.out);
        }
        all
    }
}

impl<const D: usize, S: Simd> SymmetricTensor<D, f64x8<S>> {
    /// Loads the tensor from history rows.
    #[inline(always)]
    pub fn load(simd: S, rows: &[HistoryLanes]) -> Self {
        let rows = &rows[..shape_rows::<D>()];
        let zero = f64x8::splat(simd, 0.0);
        let (mut inner, mut at) = ([[zero; D]; D], 0);
        for i in 0..D {
            for j in i..D {
                inner[i][j] = load_lanes(simd, &rows[at].0);
                at += 1;
            }
        }
        Self { inner, out: if D == 2 { load_lanes(simd, &rows[at].0) } else { zero } }
    }

    /// Stores the tensor in history rows.
    #[inline(always)]
    pub fn store(&self, rows: &mut [HistoryLanes]) {
        let rows = &mut rows[..shape_rows::<D>()];
        let mut at = 0;
        for i in 0..D {
            for j in i..D {
                self.inner[i][j].store_slice(&mut rows[at].0);
                at += 1;
            }
        }
        if D == 2 {
            self.out.store_slice(&mut rows[at].0);
        }
    }
}
