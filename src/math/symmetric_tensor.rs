//! Symmetric tensors over [`Number`]: one tensor, or eight in vector lanes.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::{Number, diagonalise};

/// Most Newton iterations for a unit determinant; a ninefold stretch takes 12 (from θ = 27 the first ones each remove
/// a third).
const MAX_ITERATIONS: usize = 64;

/// Symmetric tensor: the components i ≤ j, and the out-of-plane component, 0 in space.
#[derive(Clone, Copy)]
pub struct SymmetricTensor<const D: usize, V> {
    pub inner: [[V; D]; D],
    pub out: V,
}

/// Returns the greatest root θ of det(θ + s d) = θ³ − aθ + c = 1, with a = s²|d|²/2 and c = s³ det d.
///
/// Newton iterations from above fall monotonically to the root. A lane that has settled is left as it is, so that its bits
/// do not depend on the other lanes.
#[inline(always)]
pub fn isochoric_mean<V: Number>(above: V, a: V, c: V) -> V {
    let (mut mean, mut open) = (above, above.constant(1.0));
    for _ in 0..MAX_ITERATIONS {
        let decrement = (mean * (mean * mean - a) + c - 1.0) / (mean * 3.0 * mean - a);
        mean = open.choose(mean - decrement, mean);
        open = open.choose(decrement.absolute() - mean * f64::EPSILON, open);
        if !open.any_positive() {
            break;
        }
    }
    mean
}

impl<const D: usize> SymmetricTensor<D, f64> {
    /// Returns f(A): its eigenvalues, the out-of-plane one too, are mapped, its axes kept.
    pub fn mapped(&self, map: fn(f64) -> f64) -> Self {
        let (values, vectors) = diagonalise(self.rows());
        Self::of_spectrum(values.map(map), &vectors, if D == 2 { map(self.out) } else { 0.0 })
    }

    /// Creates the tensor of these eigenvalues, and eigenvectors as columns, with this out-of-plane component.
    pub fn of_spectrum(values: [f64; D], vectors: &[[f64; D]; D], out: f64) -> Self {
        let inner = std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..D).map(|k| vectors[i][k] * values[k] * vectors[j][k]).sum())
        });
        Self { inner, out }
    }
}

impl<const D: usize, V: Number> SymmetricTensor<D, V> {
    /// Creates the right Cauchy–Green tensor C = FᵀF, with the square of the out-of-plane stretch in the plane.
    #[inline(always)]
    pub fn right_cauchy_green(f: &[[V; D]; D], out: V) -> Self {
        let mut all = Self::diagonal(out.constant(0.0), if D == 2 { out * out } else { out.constant(0.0) });
        for i in 0..D {
            for j in i..D {
                let mut sum = f[0][i] * f[0][j];
                for k in 1..D {
                    sum = sum + f[k][i] * f[k][j];
                }
                all.inner[i][j] = sum;
            }
        }
        all
    }

    /// Returns the second invariant, the sum of the principal minors.
    #[inline(always)]
    pub fn second_invariant(&self) -> V {
        let b = &self.inner;
        let mut sum = b[0][0] * b[1][1] - b[0][1] * b[0][1];
        if D == 2 {
            return sum + (b[0][0] + b[1][1]) * self.out;
        }
        for i in 0..2 {
            sum = sum + (b[i][i] * b[2 % D][2 % D] - b[i][2 % D] * b[i][2 % D]);
        }
        sum
    }

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

    /// Returns the rows of the part in the plane, or in space.
    #[inline(always)]
    pub fn rows(&self) -> [[V; D]; D] {
        let mut all = self.inner;
        for i in 0..D {
            for j in 0..i {
                all[i][j] = self.inner[j][i];
            }
        }
        all
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

    /// Returns an upper bound of the eigenvalues, θ + √(2/3) |d| with θ a third of the trace and d the deviator.
    #[inline(always)]
    pub fn eigenvalue_bound(&self) -> V {
        let deviator = self.deviator();
        (deviator.dot(&deviator) * (2.0 / 3.0)).root() + self.trace() * (1.0 / 3.0)
    }

    /// Returns the greatest eigenvalue.
    #[inline(always)]
    pub fn greatest_eigenvalue(&self) -> V {
        let b = &self.inner;
        if D == 2 {
            let (mean, half) = ((b[0][0] + b[1][1]) * 0.5, (b[0][0] - b[1][1]) * 0.5);
            return ((half * half + b[0][1] * b[0][1]).root() + mean).or_greater(self.out);
        }
        let (values, _) = diagonalise(self.rows());
        values[0].or_greater(values[1]).or_greater(values[2 % D])
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

    /// Returns the tensor with its part in the plane, or in space, multiplied.
    #[inline(always)]
    pub fn scaled_inner(&self, factor: V) -> Self {
        Self { inner: self.inner.map(|row| row.map(|component| component * factor)), out: self.out }
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
    pub fn combined(&self, part: V, other: &Self, other_part: V) -> Self {
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
