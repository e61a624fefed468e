//! Elements of the hyperelastic laws that are given by their energy of F alone: P = ∂ψ_s/∂F + U′ ∂J/∂F.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::element_law::{ElementDeformation, ElementForces, ElementLaw, LawInput, VolumetricSlopes};
use super::kinematics::ShapeGradients;
use super::rest_geometry::RestGeometry;
use crate::constitutive::{Hyperelastic, MooneyRivlin, Ogden, VolumetricEnergy};
use crate::fem::Section;
use crate::fem::history::HistoryLayout;
use crate::math::{Number, SymmetricTensor, array};
use std::fmt::Debug;

/// Makes an element law of a hyperelastic law.
macro_rules! isotropic {
    ($law:ty) => {
        impl<const D: usize> HistoryLayout<D> for $law {}

        impl<const D: usize> ElementLaw<D> for $law {
            type Rest<L: Copy + Default + Debug> = ShapeGradients<D, L>;
            const HAS_HISTORY: bool = false;

            #[inline(always)]
            fn rest<V: Number>(&self, shape: &RestGeometry<D, V>) -> ShapeGradients<D, V::Lanes> {
                ShapeGradients::new(shape)
            }

            #[inline(always)]
            fn volume(&self) -> impl VolumetricEnergy {
                Hyperelastic::volume(self)
            }

            #[inline(always)]
            fn evaluate<V: Number>(
                &self,
                section: Section,
                input: LawInput<'_, V, ShapeGradients<D, V::Lanes>>,
                s: &ElementDeformation<D, V>,
                u: &VolumetricSlopes<V>,
            ) -> ElementForces<D, V> {
                evaluate(self, section, &input, s, u)
            }
        }
    };
}

isotropic!(MooneyRivlin);
isotropic!(Ogden);

/// Evaluates an element, with κ of [`crate::fem::Simplices`].
///
/// With M = Σ ∇N_a ⊗ ∇N_a, Σ |F∇N_a|² = C:M and Σ |b_a|² = λ² (cof F)ᵀcof F:M, each with its hoop part: mixed terms
/// vanish, since the gradients have the sum 0.
#[inline(always)]
fn evaluate<const D: usize, V: Number>(
    gel: &impl Hyperelastic,
    section: Section,
    input: &LawInput<'_, V, ShapeGradients<D, V::Lanes>>,
    s: &ElementDeformation<D, V>,
    u: &VolumetricSlopes<V>,
) -> ElementForces<D, V> {
    let (volume, zero) = (input.volume, input.volume.constant(0.0));
    let (sheared, cofactor) = (gel.sheared(&s.f, s.out), array::fused_cofactors(&s.f));
    let metric = input.rest.sums(s.hoop).metric;
    let [a, b] = sheared.curvature;
    let stretched = SymmetricTensor::right_cauchy_green(&s.f, s.out).dot(&metric);
    let mut squeezed = SymmetricTensor::right_cauchy_green(&cofactor, s.det_f);
    if D == 2 {
        squeezed = squeezed.scaled_inner(s.out * s.out);
    }
    let turning = (a + u.slope.absolute() * s.minor_bound(section)) * metric.trace();
    let bound = turning + b * stretched + u.curvature * squeezed.dot(&metric);
    let (forces, hoop_force) =
        s.nodal_forces(input.rest, &cofactor, &sheared.stress, sheared.out, -volume, -(volume * u.slope));
    ElementForces { forces, hoop_force, stiffness: volume * bound, energy: volume * sheared.energy, lost: [zero; 3] }
}
