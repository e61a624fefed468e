//! Neo-Hookean elements, P = μ F + U′ ∂J/∂F: forces from the edges, without F.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::element_law::{ElementDeformation, ElementForces, ElementLaw, LawInput, RestOperator, VolumetricSlopes};
use super::kinematics::two_largest;
use super::rest_geometry::RestGeometry;
use crate::constitutive::{Hyperelastic, NeoHookean, VolumetricEnergy};
use crate::fem::Section;
use crate::fem::history::HistoryLayout;
use crate::math::{Number, array};
use std::fmt::Debug;

/// Shear stiffness from ∇N_a: forces follow from the edges without F.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(crate) struct ShearStiffness<const D: usize, L = [f64; 8]> {
    /// w μ |∇N_a|² for a = 1..=D, N/m.
    diagonal: [L; D],
    /// w μ ∇N_a·∇N_b, N/m: in space for the pairs without node 1, 2 and 3; in the plane for nodes 1 and 2 alone.
    mixed: [L; D],
    /// w Σ_a |∇N_a|² without the hoop part, m.
    spread: L,
}

impl<const D: usize, L: Copy + Default> Default for ShearStiffness<D, L> {
    fn default() -> Self {
        let none = L::default();
        Self { diagonal: [none; D], mixed: [none; D], spread: none }
    }
}

impl<const D: usize, L> ShearStiffness<D, L> {
    /// Returns w μ ∇N_a·∇N_b, with a and b from 0 as indices of edges.
    #[inline(always)]
    fn of(&self, a: usize, b: usize) -> &L {
        match (a == b, D) {
            (true, _) => &self.diagonal[a],
            (false, 3) => &self.mixed[3 - a - b],
            (false, _) => &self.mixed[0],
        }
    }
}

impl<const D: usize, L: Copy + Default + Debug> RestOperator<D, L> for ShearStiffness<D, L> {
    /// Keeps the edges: they are F relative to the unit right-angled simplex; the scale corrects the determinant.
    #[inline(always)]
    fn deform<V: Number<Lanes = L>>(&self, _strained: V, scale: V, _edges: &mut [[V; D]; D]) -> V {
        scale
    }
}

impl<const D: usize> HistoryLayout<D> for NeoHookean {}

impl<const D: usize> ElementLaw<D> for NeoHookean {
    type Rest<L: Copy + Default + Debug> = ShearStiffness<D, L>;
    const HAS_HISTORY: bool = false;

    #[inline(always)]
    fn rest<V: Number>(&self, of: &RestGeometry<D, V>) -> ShearStiffness<D, V::Lanes> {
        let (mut rest, zero) = (ShearStiffness::default(), of.volume.constant(0.0));
        let (shape, gradients) = (of.volume * self.shear_modulus(), &of.gradients);
        let (mut first, mut spread) = ([zero; D], zero);
        for a in 0..D {
            let square = dot(&gradients[a], &gradients[a]);
            rest.diagonal[a] = (shape * square).store();
            spread = spread + square;
            for i in 0..D {
                first[i] = first[i] + gradients[a][i];
            }
        }
        let pairs: &[(usize, usize)] = if D == 3 { &[(1, 2), (0, 2), (0, 1)] } else { &[(0, 1)] };
        for (mixed, (a, b)) in rest.mixed.iter_mut().zip(pairs) {
            *mixed = (shape * dot(&gradients[*a], &gradients[*b])).store();
        }
        rest.spread = (of.volume * (spread + dot(&first, &first))).store();
        rest
    }

    #[inline(always)]
    fn volume(&self) -> impl VolumetricEnergy {
        Hyperelastic::volume(self)
    }

    /// Computes f_a = −Σ_b w μ ∇N_a·∇N_b e_b − w U′ ∂J/∂x_a, w μ/2 (|F|² + λ² − 3), and κ of [`crate::fem::Simplices`].
    #[inline(always)]
    fn evaluate<V: Number>(
        &self,
        section: Section,
        input: LawInput<'_, V, ShearStiffness<D, V::Lanes>>,
        s: &ElementDeformation<D, V>,
        u: &VolumetricSlopes<V>,
    ) -> ElementForces<D, V> {
        let LawInput { volume, scale, rest, .. } = input;
        let (mu, zero) = (self.shear_modulus(), volume.constant(0.0));
        let squeeze = if D == 2 { scale * s.out } else { scale };
        let (pressure, shape) = (-(volume * u.slope), volume * mu);
        let (push, beside) = (pressure * squeeze, s.det_f * s.hoop);
        let hoop_force = pressure.multiply_add(s.det_f, -(shape * s.out)) * s.hoop;
        let (cofactor, mut square, mut volumetric) = (array::fused_cofactors(&s.f), zero, zero);
        let mut forces = [[zero; D]; D];
        for i in 0..D {
            let ring = if i == 0 { beside } else { zero };
            let mut first = zero;
            for a in 0..D {
                let mut shear = s.f[i][0] * zero.load(rest.of(a, 0));
                for b in 1..D {
                    shear = s.f[i][b].multiply_add(zero.load(rest.of(a, b)), shear);
                }
                square = s.f[i][a].multiply_add(shear, square);
                forces[a][i] = push.multiply_add(cofactor[i][a], -shear);
                first = first - cofactor[i][a];
                let b = if D == 2 { cofactor[i][a].multiply_add(squeeze, ring) } else { cofactor[i][a] };
                volumetric = b.multiply_add(b, volumetric);
            }
            let b = if D == 2 { first.multiply_add(squeeze, ring) } else { first };
            volumetric = b.multiply_add(b, volumetric);
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
        let spread = zero.load(&rest.spread);
        let spread = if D == 2 { (volume * 3.0).multiply_add(s.hoop * s.hoop, spread) } else { spread };
        let turning = u.slope.absolute().multiply_add(turn, zero + mu);
        let stiffness = (volume * u.curvature).multiply_add(volumetric, turning * spread);
        let square = if D == 2 { (shape * s.out).multiply_add(s.out, square) } else { square };
        ElementForces { forces, hoop_force, stiffness, energy: (square - shape * 3.0) * 0.5, lost: [zero; 3] }
    }
}

/// Returns the scalar product, summed from the first component.
#[inline(always)]
fn dot<const D: usize, V: Number>(a: &[V; D], b: &[V; D]) -> V {
    let mut sum = a[0] * b[0];
    for i in 1..D {
        sum = sum + a[i] * b[i];
    }
    sum
}
