//! Elements of an elastic gel in lanes: what they answer once they are strained.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::lanes::{Batch, Element, Kick, Solid, Sums, fused, wide};
use super::recall::Recall;
use super::{MAX_NODES, Section};
use crate::algebra::Number;
use crate::material::{NeoHookean, Volumetric};
use fearless_simd::{Simd, SimdBase, f64x8};

impl<const D: usize> Solid<D> for NeoHookean {
    #[inline(always)]
    fn volumetric<T: Number>(&self, j: T) -> Volumetric<T> {
        self.volumetric(j)
    }

    #[inline(always)]
    fn own<T: Number>(&self, j: T) -> Volumetric<T> {
        self.own(j)
    }

    #[inline(always)]
    fn shared<T: Number>(&self, mean: T) -> Volumetric<T> {
        self.shared(mean)
    }

    /// As [`super::Simplices`] has them; what is stored is w μ/2 (|F|² + λ² − 3).
    #[inline(always)]
    fn forces<S: Simd>(
        &self,
        section: Section,
        (batch, Kick { length: weight, .. }, _): (&Batch<D>, Kick, &mut [Recall<D>]),
        (s, u, rows): Element<'_, D, f64x8<S>>,
        kicks: &mut [[f64x8<S>; 4]; MAX_NODES],
    ) -> Sums<f64x8<S>> {
        let (simd, mu) = (s.inner.simd, self.shear_modulus());
        let zero = f64x8::splat(simd, 0.0);
        let volume = wide(simd, &batch.volume);
        let (shape, pressure) = (volume * -mu, -(volume * u.slope));
        let (mut square, mut volumetric, mut power) = (zero, zero, zero);
        // What the ring adds to every node along r: to its force and to ∂J/∂x_a.
        let around = fused(pressure, s.inner, shape * s.out) * s.hoop;
        let beside = s.inner * s.hoop;
        for i in 0..D {
            let ring = D == 2 && i == 0;
            // −w P and λ cof F. At rest w μ and −w μ cancel: the sum comes before any product that would be rounded.
            let (mut stress, mut area) = ([zero; D], [zero; D]);
            for j in 0..D {
                area[j] = if D == 2 { s.cofactor[i][j] * s.out } else { s.cofactor[i][j] };
                stress[j] = fused(pressure, area[j], shape * s.f[i][j]);
                square = fused(s.f[i][j], s.f[i][j], square);
            }
            let (mut push, mut turned) = (zero, zero);
            for a in 0..D {
                let (mut force, mut b) =
                    (stress[0] * wide(simd, &batch.gradients[a][0]), area[0] * wide(simd, &batch.gradients[a][0]));
                for j in 1..D {
                    force = fused(stress[j], wide(simd, &batch.gradients[a][j]), force);
                    b = fused(area[j], wide(simd, &batch.gradients[a][j]), b);
                }
                (push, turned) = (push - force, turned - b);
                let (force, b) = if ring { (force + around, b + beside) } else { (force, b) };
                volumetric = fused(b, b, volumetric);
                power = fused(force, rows[a + 1][4 + i], power);
                kicks[a + 1][i] = force * weight;
            }
            let (force, b) = if ring { (push + around, turned + beside) } else { (push, turned) };
            volumetric = fused(b, b, volumetric);
            power = fused(force, rows[0][4 + i], power);
            kicks[0][i] = force * weight;
        }
        let turn = match section {
            Section::Planar { .. } => zero + 1.0,
            Section::Spatial => (square + square).root(),
            Section::Axisymmetric => two_largest(square, s.inner, s.out),
        };
        let spread = wide(simd, &batch.spread);
        let spread = if D == 2 { fused(s.hoop * s.hoop, zero + 3.0, spread) } else { spread };
        let turning = fused(u.slope.absolute(), turn, zero + mu);
        let stiffness = volume * fused(u.curvature, volumetric, turning * spread);
        for a in 0..=D {
            kicks[a][3] = stiffness;
        }
        let square = if D == 2 { fused(s.out, s.out, square) } else { square };
        Sums { energy: volume * (square - 3.0) * (0.5 * mu), power, lost: [zero; 3] }
    }
}

/// Sum of the two largest of the singular values s₁ ≥ s₂ of the plane part and |λ|, from Σ s², s₁s₂ and λ.
#[inline(always)]
fn two_largest<V: Number>(square: V, inner: V, out: V) -> V {
    let area = inner.absolute() * 2.0;
    let (sum, difference) = ((square + area).root(), (square - area).at_least(0.0).root());
    sum.or_greater((sum + difference) * 0.5 + out.absolute())
}
