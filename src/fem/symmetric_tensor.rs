//! Symmetric tensors of eight elements, side by side.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::wide;
use super::history::{Recall, rows_of_shape};
use crate::math::Number;
use fearless_simd::{Simd, SimdBase, f64x8};

/// Components of i ≤ j, and that out of the plane, 0 in space.
#[derive(Clone, Copy)]
pub(super) struct Symmetric<const D: usize, V> {
    pub inner: [[V; D]; D],
    pub out: V,
}

impl<const D: usize, V: Number> Symmetric<D, V> {
    /// The same number `inner` in the diagonal and `out` out of the plane.
    #[inline(always)]
    pub fn diagonal(inner: V, out: V) -> Self {
        let mut all = [[inner.constant(0.0); D]; D];
        for i in 0..D {
            all[i][i] = inner;
        }
        Self { inner: all, out }
    }

    #[inline(always)]
    pub fn of(&self, i: usize, j: usize) -> V {
        self.inner[i.min(j)][i.max(j)]
    }

    #[inline(always)]
    pub fn trace(&self) -> V {
        let mut sum = self.out;
        for i in 0..D {
            sum = sum + self.inner[i][i];
        }
        sum
    }

    /// b − tr b/3.
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

    /// a:b.
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

    /// a a.
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

    /// b⁻¹ of a determinant of 1.
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

    /// θ + s d.
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

    /// So much of this one and so much of another.
    #[inline(always)]
    pub fn combined(&self, part: f64, (other, its): (&Self, V)) -> Self {
        let mut all = *self;
        for i in 0..D {
            for j in i..D {
                all.inner[i][j] = self.inner[i][j] * part + other.inner[i][j] * its;
            }
        }
        if D == 2 {
            all.out = self.out * part + other.out * its;
        }
        all
    }

    /// This one where `which` is more than 0, else another.
    #[inline(always)]
    pub fn chosen(&self, which: V, other: &Self) -> Self {
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

impl<const D: usize, S: Simd> Symmetric<D, f64x8<S>> {
    /// From what eight elements remember.
    #[inline(always)]
    pub fn load(simd: S, rows: &[Recall]) -> Self {
        let rows = &rows[..rows_of_shape::<D>()];
        let zero = f64x8::splat(simd, 0.0);
        let (mut inner, mut at) = ([[zero; D]; D], 0);
        for i in 0..D {
            for j in i..D {
                inner[i][j] = wide(simd, &rows[at].0);
                at += 1;
            }
        }
        Self { inner, out: if D == 2 { wide(simd, &rows[at].0) } else { zero } }
    }

    /// To what they remember.
    #[inline(always)]
    pub fn store(&self, rows: &mut [Recall]) {
        let rows = &mut rows[..rows_of_shape::<D>()];
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
