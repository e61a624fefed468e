//! Elements of an elastic gel in lanes: what they answer once they are strained.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::Section;
use super::batch::{LANES, Wide, cofactors, fetch, fused, wide};
use super::history::Remembering;
use super::rest_geometry::Shape;
use super::simd_material::{Eight, Pull, Slopes, Solid, Strains, Undeformed};
use crate::constitutive::{Hyperelastic, NeoHookean, Volume};
use crate::math::Number;
use fearless_simd::{Simd, SimdBase, f64x8};

/// How eight elements resist shear, from the gradients ∇N_a at rest: with it forces follow from edges, and F is not asked for.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct Metric<const D: usize> {
    /// w μ |∇N_a|² for a = 1..=D, N/m.
    diagonal: [Wide; D],
    /// w μ ∇N_a·∇N_b, N/m: in space without 1, without 2 and without 3; in the plane that of 1 and 2 alone.
    mixed: [Wide; D],
    /// w Σ_a |∇N_a|², without the share of a ring, m.
    spread: Wide,
}

impl<const D: usize> Default for Metric<D> {
    fn default() -> Self {
        let none = [0.0; LANES];
        Self { diagonal: [none; D], mixed: [none; D], spread: none }
    }
}

impl<const D: usize> Metric<D> {
    /// w μ ∇N_a·∇N_b for a, b from 0 as edges are counted.
    #[inline(always)]
    fn of(&self, a: usize, b: usize) -> &Wide {
        match (a == b, D) {
            (true, _) => &self.diagonal[a],
            (false, 3) => &self.mixed[3 - a - b],
            (false, _) => &self.mixed[0],
        }
    }
}

impl<const D: usize> Undeformed<D> for Metric<D> {
    #[inline(always)]
    fn fetch(&self) {
        for eight in self.diagonal.iter().chain(&self.mixed) {
            fetch(eight);
        }
        fetch(&self.spread);
    }

    /// The edges themselves: F of the simplex whose edges are of length 1 and at right angles, with its volume.
    #[inline(always)]
    fn deform<S: Simd>(&self, (_, scale): (f64x8<S>, f64x8<S>), _: &mut [[f64x8<S>; D]; D]) -> f64x8<S> {
        scale
    }
}

impl<const D: usize> Remembering<D> for NeoHookean {}

impl<const D: usize> Solid<D> for NeoHookean {
    type Rest = Metric<D>;
    const REMEMBERS: bool = false;

    #[inline(always)]
    fn rest<S: Simd>(&self, of: &Shape<D, f64x8<S>>) -> Metric<D> {
        let (mut rest, zero) = (Metric::default(), of.volume.constant(0.0));
        let (shape, gradients) = (of.volume * self.shear_modulus(), &of.gradients);
        let (mut first, mut spread) = ([zero; D], zero);
        for a in 0..D {
            let square = dot(&gradients[a], &gradients[a]);
            rest.diagonal[a] = (shape * square).into();
            spread += square;
            for i in 0..D {
                first[i] += gradients[a][i];
            }
        }
        let pairs: &[(usize, usize)] = if D == 3 { &[(1, 2), (0, 2), (0, 1)] } else { &[(0, 1)] };
        for (mixed, (a, b)) in rest.mixed.iter_mut().zip(pairs) {
            *mixed = (shape * dot(&gradients[*a], &gradients[*b])).into();
        }
        rest.spread = (of.volume * (spread + dot(&first, &first))).into();
        rest
    }

    #[inline(always)]
    fn volume(&self) -> impl Volume {
        Hyperelastic::volume(self)
    }

    /// f_a = −Σ_b w μ ∇N_a·∇N_b e_b − w U′ ∂J/∂x_a, w μ/2 (|F|² + λ² − 3), and κ as [`super::Simplices`] has it.
    #[inline(always)]
    fn pull<S: Simd>(
        &self,
        section: Section,
        (batch, rest, _, _): Eight<'_, Metric<D>>,
        (s, u): (&Strains<D, f64x8<S>>, &Slopes<f64x8<S>>),
    ) -> Pull<D, f64x8<S>> {
        let (simd, mu) = (s.inner.simd, self.shear_modulus());
        let zero = f64x8::splat(simd, 0.0);
        let (volume, scale) = (wide(simd, &batch.volume), wide(simd, &batch.scale));
        let squeeze = if D == 2 { scale * s.out } else { scale };
        let (pressure, shape) = (-(volume * u.slope), volume * mu);
        let (push, beside) = (pressure * squeeze, s.inner * s.hoop);
        let around = fused(pressure, s.inner, -(shape * s.out)) * s.hoop;
        let (cofactor, mut square, mut volumetric) = (cofactors(&s.f), zero, zero);
        let mut forces = [[zero; D]; D];
        for i in 0..D {
            let ring = if i == 0 { beside } else { zero };
            let mut first = zero;
            for a in 0..D {
                let mut shear = s.f[i][0] * wide(simd, rest.of(a, 0));
                for b in 1..D {
                    shear = fused(s.f[i][b], wide(simd, rest.of(a, b)), shear);
                }
                square = fused(s.f[i][a], shear, square);
                forces[a][i] = fused(push, cofactor[i][a], -shear);
                first -= cofactor[i][a];
                let b = if D == 2 { fused(cofactor[i][a], squeeze, ring) } else { cofactor[i][a] };
                volumetric = fused(b, b, volumetric);
            }
            let b = if D == 2 { fused(first, squeeze, ring) } else { first };
            volumetric = fused(b, b, volumetric);
        }
        let volumetric = if D == 2 { volumetric } else { volumetric * (squeeze * squeeze) };
        let turn = match section {
            // Said by D, so that nobody need look.
            _ if D == 3 => (square * scale * (12.0 / mu)).root(),
            Section::Planar { .. } | Section::Spatial => zero + 1.0,
            Section::Axisymmetric => {
                let strain = square * (s.hoop * scale) * (3.0 / (std::f64::consts::PI * mu));
                two_largest(strain, s.inner, s.out)
            }
        };
        let spread = wide(simd, &rest.spread);
        let spread = if D == 2 { fused(volume * 3.0, s.hoop * s.hoop, spread) } else { spread };
        let turning = fused(u.slope.absolute(), turn, zero + mu);
        let stiffness = fused(volume * u.curvature, volumetric, turning * spread);
        let square = if D == 2 { fused(shape * s.out, s.out, square) } else { square };
        Pull { forces, around, stiffness, energy: (square - shape * 3.0) * 0.5, lost: [zero; 3] }
    }
}

/// Scalar products, the first components first.
#[inline(always)]
fn dot<const D: usize, S: Simd>(a: &[f64x8<S>; D], b: &[f64x8<S>; D]) -> f64x8<S> {
    let mut sum = a[0] * b[0];
    for i in 1..D {
        sum += a[i] * b[i];
    }
    sum
}

/// Sum of the two largest of the singular values s₁ ≥ s₂ of the plane part and |λ|, from Σ s², s₁s₂ and λ.
#[inline(always)]
pub(super) fn two_largest<V: Number>(square: V, inner: V, out: V) -> V {
    let area = inner.absolute() * 2.0;
    let (sum, difference) = ((square + area).root(), (square - area).at_least(0.0).root());
    sum.or_greater((sum + difference) * 0.5 + out.absolute())
}
