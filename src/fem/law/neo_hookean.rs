//! Neo-Hookean elements in vector lanes.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::Section;
use super::batch::{LANES, LaneArray, cofactors, load_lanes, multiply_add, prefetch};
use super::history::HistoryLayout;
use super::rest_geometry::RestGeometry;
use super::simd_material::{BatchDeformation, BatchInput, ElementForces, RestOperator, SimdMaterial, VolumetricSlopes};
use crate::constitutive::{Hyperelastic, NeoHookean, VolumetricEnergy};
use crate::math::Number;
use fearless_simd::{Simd, SimdBase, f64x8};

/// Shear stiffness of eight elements from ∇N_a: forces follow from the edges without F.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct ShearStiffness<const D: usize> {
    /// w μ |∇N_a|² for a = 1..=D, N/m.
    diagonal: [LaneArray; D],
    /// w μ ∇N_a·∇N_b, N/m: in space for the pairs without node 1, 2 and 3; in the plane for nodes 1 and 2 alone.
    mixed: [LaneArray; D],
    /// w Σ_a |∇N_a|² without the hoop part, m.
    spread: LaneArray,
}

impl<const D: usize> Default for ShearStiffness<D> {
    fn default() -> Self {
        let none = [0.0; LANES];
        Self { diagonal: [none; D], mixed: [none; D], spread: none }
    }
}

impl<const D: usize> ShearStiffness<D> {
    /// Returns w μ ∇N_a·∇N_b, with a and b from 0 as indices of edges.
    #[inline(always)]
    fn of(&self, a: usize, b: usize) -> &LaneArray {
        match (a == b, D) {
            (true, _) => &self.diagonal[a],
            (false, 3) => &self.mixed[3 - a - b],
            (false, _) => &self.mixed[0],
        }
    }
}

impl<const D: usize> RestOperator<D> for ShearStiffness<D> {
    #[inline(always)]
    fn prefetch(&self) {
        for eight in self.diagonal.iter().chain(&self.mixed) {
            prefetch(eight);
        }
        prefetch(&self.spread);
    }

    /// Keeps the edges: they are F relative to the unit right-angled simplex; the scale corrects the determinant.
    #[inline(always)]
    fn deform<S: Simd>(&self, _strained: f64x8<S>, scale: f64x8<S>, _edges: &mut [[f64x8<S>; D]; D]) -> f64x8<S> {
        scale
    }
}

impl<const D: usize> HistoryLayout<D> for NeoHookean {}

impl<const D: usize> SimdMaterial<D> for NeoHookean {
    type Rest = ShearStiffness<D>;
    const HAS_HISTORY: bool = false;

    #[inline(always)]
    fn rest<S: Simd>(&self, of: &RestGeometry<D, f64x8<S>>) -> ShearStiffness<D> {
        let (mut rest, zero) = (ShearStiffness::default(), of.volume.constant(0.0));
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
    fn volume(&self) -> impl VolumetricEnergy {
        Hyperelastic::volume(self)
    }

    /// Computes f_a = −Σ_b w μ ∇N_a·∇N_b e_b − w U′ ∂J/∂x_a, w μ/2 (|F|² + λ² − 3), and κ of [`super::Simplices`].
    #[inline(always)]
    fn evaluate<S: Simd>(
        &self,
        section: Section,
        input: BatchInput<'_, ShearStiffness<D>>,
        s: &BatchDeformation<D, f64x8<S>>,
        u: &VolumetricSlopes<f64x8<S>>,
    ) -> ElementForces<D, f64x8<S>> {
        let BatchInput { batch, rest, .. } = input;
        let (simd, mu) = (s.det_f.simd, self.shear_modulus());
        let zero = f64x8::splat(simd, 0.0);
        let (volume, scale) = (load_lanes(simd, &batch.volume), load_lanes(simd, &batch.scale));
        let squeeze = if D == 2 { scale * s.out } else { scale };
        let (pressure, shape) = (-(volume * u.slope), volume * mu);
        let (push, beside) = (pressure * squeeze, s.det_f * s.hoop);
        let hoop_force = multiply_add(pressure, s.det_f, -(shape * s.out)) * s.hoop;
        let (cofactor, mut square, mut volumetric) = (cofactors(&s.f), zero, zero);
        let mut forces = [[zero; D]; D];
        for i in 0..D {
            let ring = if i == 0 { beside } else { zero };
            let mut first = zero;
            for a in 0..D {
                let mut shear = s.f[i][0] * load_lanes(simd, rest.of(a, 0));
                for b in 1..D {
                    shear = multiply_add(s.f[i][b], load_lanes(simd, rest.of(a, b)), shear);
                }
                square = multiply_add(s.f[i][a], shear, square);
                forces[a][i] = multiply_add(push, cofactor[i][a], -shear);
                first -= cofactor[i][a];
                let b = if D == 2 { multiply_add(cofactor[i][a], squeeze, ring) } else { cofactor[i][a] };
                volumetric = multiply_add(b, b, volumetric);
            }
            let b = if D == 2 { multiply_add(first, squeeze, ring) } else { first };
            volumetric = multiply_add(b, b, volumetric);
        }
        let volumetric = if D == 2 { volumetric } else { volumetric * (squeeze * squeeze) };
        let turn = match section {
            // Decided by D, a constant, so no branch remains.
            _ if D == 3 => (square * scale * (12.0 / mu)).root(),
            Section::Planar { .. } | Section::Spatial => zero + 1.0,
            Section::Axisymmetric => {
                let strain = square * (s.hoop * scale) * (3.0 / (std::f64::consts::PI * mu));
                two_largest(strain, s.det_f, s.out)
            }
        };
        let spread = load_lanes(simd, &rest.spread);
        let spread = if D == 2 { multiply_add(volume * 3.0, s.hoop * s.hoop, spread) } else { spread };
        let turning = multiply_add(u.slope.absolute(), turn, zero + mu);
        let stiffness = multiply_add(volume * u.curvature, volumetric, turning * spread);
        let square = if D == 2 { multiply_add(shape * s.out, s.out, square) } else { square };
        ElementForces { forces, hoop_force, stiffness, energy: (square - shape * 3.0) * 0.5, lost: [zero; 3] }
    }
}

/// Returns the scalar products, summed from the first component.
#[inline(always)]
fn dot<const D: usize, S: Simd>(a: &[f64x8<S>; D], b: &[f64x8<S>; D]) -> f64x8<S> {
    let mut sum = a[0] * b[0];
    for i in 1..D {
        sum += a[i] * b[i];
    }
    sum
}

/// Returns the sum of the two largest of the singular values s₁ ≥ s₂ of the plane part and |λ|, from Σ s², s₁s₂ and λ.
#[inline(always)]
pub(super) fn two_largest<V: Number>(square: V, inner: V, out: V) -> V {
    let area = inner.absolute() * 2.0;
    let (sum, difference) = ((square + area).root(), (square - area).at_least(0.0).root());
    sum.or_greater((sum + difference) * 0.5 + out.absolute())
}
