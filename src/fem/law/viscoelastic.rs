//! Viscoelastic elements: a neo-Hookean equilibrium response plus Maxwell branches (numerics 6.4).

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::element_law::{ElementDeformation, ElementForces, ElementLaw, LawInput, VolumetricSlopes};
use super::kinematics::{GradientSums, ShapeGradients};
use super::rest_geometry::RestGeometry;
use crate::constitutive::{
    BranchResponse, Hyperelastic, IsochoricDeformation, IsochoricShape, MaxwellBranch, NeoHookean, ShearResponse,
    Viscoelastic, VolumetricEnergy,
};
use crate::fem::history::{HistoryLayout, load_shape, load_tensor, shape_rows, store_shape, store_tensor};
use crate::fem::{HistoryVariables, Section};
use crate::math::{Number, SymmetricTensor};
use std::fmt::Debug;

/// Sums over the springs: P = K + U′ ∂J/∂F, K = F (μ + Σ μ_i J^(−2/3) C̄_i⁻¹).
struct SpringForces<const D: usize, V> {
    /// K, Pa.
    pulled: [[V; D]; D],
    /// Out-of-plane component of K over λ, Pa.
    out: V,
    /// U′, with the part that removes the trace of the branch stresses, Pa.
    slope: V,
    /// Stored energy, J/m³.
    stored: V,
    /// Curvature of the branches, N/m⁴.
    curvature: V,
}

impl<const D: usize> HistoryLayout<D> for Viscoelastic {
    /// Returns the number of rows: J and C̄⁻¹ at the last tick, then C̄_i⁻¹ of each branch.
    fn rows(&self) -> usize {
        1 + (1 + self.branches().len()) * shape_rows::<D>()
    }

    fn store_history(&self, rows: &mut [f64], memory: &[HistoryVariables<D>]) {
        let (jacobian, shapes) = rows.split_first_mut().expect("where it was is remembered");
        *jacobian = memory[0].jacobian;
        shapes.chunks_exact_mut(shape_rows::<D>()).zip(memory).for_each(|(rows, memory)| store_shape(rows, memory));
    }

    fn load_history(&self, rows: &[f64], memory: &mut [HistoryVariables<D>]) {
        let shapes = rows[1..].chunks_exact(shape_rows::<D>());
        memory.iter_mut().zip(shapes).for_each(|(memory, rows)| *memory = load_shape(rows));
        memory[0].jacobian = rows[0];
    }
}

impl<const D: usize> ElementLaw<D> for Viscoelastic {
    type Rest<L: Copy + Default + Debug> = ShapeGradients<D, L>;
    const HAS_HISTORY: bool = true;

    #[inline(always)]
    fn rest<V: Number>(&self, shape: &RestGeometry<D, V>) -> ShapeGradients<D, V::Lanes> {
        ShapeGradients::new(shape)
    }

    #[inline(always)]
    fn volume(&self) -> impl VolumetricEnergy {
        Hyperelastic::volume(self.equilibrium())
    }

    #[inline(always)]
    fn evaluate<V: Number>(
        &self,
        section: Section,
        input: LawInput<'_, V, ShapeGradients<D, V::Lanes>>,
        s: &ElementDeformation<D, V>,
        u: &VolumetricSlopes<V>,
    ) -> ElementForces<D, V> {
        let LawInput { volume, rest, elapsed, history, .. } = input;
        let (zero, at) = (volume.constant(0.0), s.isochoric());
        let (nodes, still) = (rest.spatial_sums(&at, s.hoop), rest.sums(s.hoop));
        let (jacobian, shapes) = history.split_first_mut().expect("where it was is remembered");
        let (last, branches) = shapes.split_at_mut(shape_rows::<D>());
        let before = IsochoricShape::before(load_tensor(zero, last), zero.load(&jacobian.0));
        let now = IsochoricShape::now(&at);
        let (mut springs, mut lost) = (SpringForces::new(self.equilibrium(), s, u.slope), zero);
        for (branch, rows) in self.branches().iter().zip(branches.chunks_exact_mut(shape_rows::<D>())) {
            let mut own = load_tensor(zero, rows);
            if elapsed > 0.0 {
                lost = lost + branch.relax(&mut own, [&before, &now], elapsed);
                store_tensor(&own, rows);
            }
            springs.add(&at, branch, &own, &nodes, &still);
        }
        store_tensor(&now.inverse.where_positive(now.above_floor, &before.inverse), last);
        jacobian.0 = s.jacobian().store();
        let turning = u.slope.absolute() * s.minor_bound(section) + self.equilibrium().shear_modulus();
        let bound = turning * still.metric.trace() + u.curvature * dilated(s, &at, &nodes) + springs.curvature;
        let (forces, hoop_force) =
            s.nodal_forces(rest, &at.cofactor, &springs.pulled, springs.out, -volume, -(volume * springs.slope));
        let (stiffness, energy) = (volume * bound, volume * springs.stored);
        ElementForces { forces, hoop_force, stiffness, energy, lost: [zero, volume * lost, zero] }
    }
}

impl<const D: usize, V: Number> SpringForces<D, V> {
    /// Creates the sums with the equilibrium spring alone.
    #[inline(always)]
    fn new(gel: &NeoHookean, s: &ElementDeformation<D, V>, slope: V) -> Self {
        let ShearResponse { energy, stress, out, .. } = gel.sheared(&s.f, s.out);
        Self { pulled: stress, out, slope, stored: energy, curvature: slope.constant(0.0) }
    }

    /// Adds a branch with its rest shape `own`.
    ///
    /// `nodes` and `still` are the sums of the spatial and the material gradients.
    #[inline(always)]
    fn add(
        &mut self,
        at: &IsochoricDeformation<D, V>,
        branch: &MaxwellBranch,
        own: &SymmetricTensor<D, V>,
        nodes: &GradientSums<D, V>,
        still: &GradientSums<D, V>,
    ) {
        let BranchResponse { energy, stress, out, pressure, elastic } = branch.respond(at, own);
        for i in 0..D {
            for j in 0..D {
                self.pulled[i][j] = self.pulled[i][j] + stress[i][j];
            }
        }
        (self.out, self.slope, self.stored) = (self.out + out, self.slope - pressure, self.stored + energy);
        let mut curvature = nodes.shear_bound(&elastic);
        if (-at.above_floor).any_positive() {
            // Below the floor J^(−2/3) is constant and W quadratic.
            curvature = at.above_floor.choose(curvature, own.dot(&still.metric) * at.scale);
        }
        self.curvature = self.curvature + curvature * branch.shear_modulus;
    }
}

/// Returns Σ |∂J/∂x_a|², 1/m².
#[inline(always)]
fn dilated<const D: usize, V: Number>(
    s: &ElementDeformation<D, V>,
    at: &IsochoricDeformation<D, V>,
    nodes: &GradientSums<D, V>,
) -> V {
    let ring = s.det_f * s.hoop;
    let mut sum = nodes.metric.inner[0][0];
    for i in 1..D {
        sum = sum + nodes.metric.inner[i][i];
    }
    let sum = sum * at.jacobian * at.jacobian;
    if D == 2 { sum + ring * ring * (D + 1) as f64 } else { sum }
}

#[cfg(test)]
mod tests;
