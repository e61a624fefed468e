//! Viscoelastic elements: a neo-Hookean equilibrium response plus Maxwell branches (numerics 6.4).

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::element_law::{ElementDeformation, ElementForces, ElementLaw, LawInput, VolumetricSlopes};
use super::kinematics::{GradientSums, IsochoricKinematics, ShapeGradients};
use super::rest_geometry::RestGeometry;
use crate::constitutive::{Hyperelastic, NeoHookean, ShearResponse, Viscoelastic, VolumetricEnergy};
use crate::fem::history::{HistoryLayout, load_shape, load_tensor, shape_rows, store_shape, store_tensor};
use crate::fem::{HistoryVariables, Section};
use crate::math::{Number, SymmetricTensor, array, isochoric_mean};
use std::fmt::Debug;

/// Isochoric shapes C̄⁻¹ and C̄; a branch relaxes where `above_floor` is positive.
#[derive(Clone, Copy)]
struct IsochoricShape<const D: usize, V> {
    inverse: SymmetricTensor<D, V>,
    shape: SymmetricTensor<D, V>,
    above_floor: V,
}

/// Relaxation of a branch at a constant strain: dev(C̄ C̄_i⁻¹) before it, with its out-of-plane component and square.
struct BranchRelaxation<const D: usize, V> {
    inner: [[V; D]; D],
    out: V,
    square: V,
    /// Decrease of tr b̄.
    fall: V,
}

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
        let (zero, at) = (volume.constant(0.0), IsochoricKinematics::new(s));
        let (nodes, still) = (at.gradient_sums(rest), rest.sums(s.hoop));
        let (jacobian, shapes) = history.split_first_mut().expect("where it was is remembered");
        let (last, branches) = shapes.split_at_mut(shape_rows::<D>());
        let before = IsochoricShape::before(load_tensor(zero, last), zero.load(&jacobian.0));
        let now = IsochoricShape::now(&at);
        let (mut springs, mut lost) = (SpringForces::new(self.equilibrium(), s, u.slope), zero);
        for (branch, rows) in self.branches().iter().zip(branches.chunks_exact_mut(shape_rows::<D>())) {
            let mut own = load_tensor(zero, rows);
            if elapsed > 0.0 {
                let fall = relax_branch(&mut own, [&before, &now], branch.relaxation_factors(elapsed));
                lost = lost + fall * (0.5 * branch.shear_modulus);
                store_tensor(&own, rows);
            }
            springs.add(&at, branch.shear_modulus, &own, &nodes, &still);
        }
        store_tensor(&now.inverse.where_positive(now.above_floor, &before.inverse), last);
        jacobian.0 = s.jacobian().store();
        let turning = u.slope.absolute() * s.minor_bound(section) + self.equilibrium().shear_modulus();
        let bound = turning * still.metric.trace() + u.curvature * dilated(&at, &nodes) + springs.curvature;
        let (forces, hoop_force) =
            s.nodal_forces(rest, &at.cofactor, &springs.pulled, springs.out, -volume, -(volume * springs.slope));
        let (stiffness, energy) = (volume * bound, volume * springs.stored);
        ElementForces { forces, hoop_force, stiffness, energy, lost: [zero, volume * lost, zero] }
    }
}

/// Relaxes a branch by the factors `parts`, at the strain before the step, then at the strain now; returns the loss
/// of tr b̄.
///
/// The loss is the fall of tr b̄ at both strains, corrected for the work of the branch between them. The nodes do
/// work against the mean of the first and the last stress; the excess of the two relaxed stresses over this mean is,
/// to second order, ½ (d_b − d_a):[(1 − s_b) d_b − (1 − s_a) d], d_a = s_a d.
#[inline(always)]
fn relax_branch<const D: usize, V: Number>(
    branch: &mut SymmetricTensor<D, V>,
    [before, now]: [&IsochoricShape<D, V>; 2],
    parts: [f64; 2],
) -> V {
    let [first, second] = [before.relax(branch, parts[0]), now.relax(branch, parts[1])];
    let mut both = first.out * second.out;
    for i in 0..D {
        for j in 0..D {
            both = both + first.inner[i][j] * second.inner[j][i];
        }
    }
    // (d_b − s_a d_a):[(1 − s_b) d_b − (1 − s_a) d_a].
    let (left, gone) = (parts[0], parts.map(|part| 1.0 - part));
    let excess = second.square * gone[1] - both * (gone[0] + left * gone[1]) + first.square * (left * gone[0]);
    let zero = excess.constant(0.0);
    first.fall + second.fall - before.above_floor.choose(now.above_floor, zero).choose(excess * 0.5, zero)
}

impl<const D: usize, V: Number> IsochoricShape<D, V> {
    /// Returns the shapes at the last tick from the history variables.
    #[inline(always)]
    fn before(inverse: SymmetricTensor<D, V>, jacobian: V) -> Self {
        Self { shape: inverse.inverse(), inverse, above_floor: jacobian - NeoHookean::FLOOR }
    }

    /// Returns the present shapes.
    #[inline(always)]
    fn now(at: &IsochoricKinematics<'_, D, V>) -> Self {
        let (s, zero) = (at.strain, at.scale.constant(0.0));
        let over = at.scale.constant(1.0) / (s.det_f * s.det_f * at.scale);
        let square = s.out * s.out * at.scale;
        let mut now = Self {
            inverse: SymmetricTensor::diagonal(zero, if D == 2 { square.constant(1.0) / square } else { zero }),
            shape: SymmetricTensor::diagonal(zero, if D == 2 { square } else { zero }),
            above_floor: s.det_f.choose(at.above_floor, zero),
        };
        for i in 0..D {
            for j in i..D {
                let (mut inverse, mut shape) = (at.cofactor[0][i] * at.cofactor[0][j], s.f[0][i] * s.f[0][j]);
                for k in 1..D {
                    inverse = inverse + at.cofactor[k][i] * at.cofactor[k][j];
                    shape = shape + s.f[k][i] * s.f[k][j];
                }
                (now.inverse.inner[i][j], now.shape.inner[i][j]) = (inverse * over, shape * at.scale);
            }
        }
        now
    }

    /// Relaxes dev b̄ of a branch to its part s at this constant shape.
    ///
    /// b̄ = θ + d, tr d = 0, becomes θ' + s d with θ'³ − θ' s²|d|²/2 + s³ det d = 1, hence C̄_i⁻¹ becomes s C̄_i⁻¹ +
    /// (θ' − sθ) C̄⁻¹; θ, |d|² and det d are those of C̄ C̄_i⁻¹, too, which has the eigenvalues of b̄.
    #[inline(always)]
    fn relax(&self, branch: &mut SymmetricTensor<D, V>, left: f64) -> BranchRelaxation<D, V> {
        let zero = branch.out.constant(0.0);
        let mut inner = [[zero; D]; D];
        let mut out = if D == 2 { self.shape.out * branch.out } else { zero };
        let mut trace = out;
        for i in 0..D {
            for j in 0..D {
                let mut sum = self.shape.of(i, 0) * branch.of(0, j);
                for k in 1..D {
                    sum = sum + self.shape.of(i, k) * branch.of(k, j);
                }
                inner[i][j] = sum;
            }
            trace = trace + inner[i][i];
        }
        let before = trace * (1.0 / 3.0);
        if D == 2 {
            out = out - before;
        }
        let mut square = out * out;
        for i in 0..D {
            inner[i][i] = inner[i][i] - before;
            square = square + inner[i][i] * inner[i][i];
            for j in 0..i {
                square = square + inner[i][j] * inner[j][i] * 2.0;
            }
        }
        let determinant = determinant(&inner, out);
        let after = isochoric_mean(before, square * (0.5 * left * left), determinant * (left * left * left));
        let relaxed = branch.combined(left, &self.inverse, after - before * left);
        *branch = relaxed.where_positive(self.above_floor, branch);
        BranchRelaxation { inner, out, square, fall: self.above_floor.choose((before - after) * 3.0, zero) }
    }
}

/// Returns the determinant of a tensor with its out-of-plane component.
#[inline(always)]
fn determinant<const D: usize, V: Number>(a: &[[V; D]; D], out: V) -> V {
    let inner = array::det(a);
    if D == 2 { inner * out } else { inner }
}

impl<const D: usize, V: Number> SpringForces<D, V> {
    /// Creates the sums with the equilibrium spring alone.
    #[inline(always)]
    fn new(gel: &NeoHookean, s: &ElementDeformation<D, V>, slope: V) -> Self {
        let ShearResponse { energy, stress, out, .. } = gel.sheared(&s.f, s.out);
        Self { pulled: stress, out, slope, stored: energy, curvature: slope.constant(0.0) }
    }

    /// Adds a branch of modulus `mu`, Pa, and rest shape `own`.
    ///
    /// `nodes` and `still` are the sums of the spatial and the material gradients.
    #[inline(always)]
    fn add(
        &mut self,
        at: &IsochoricKinematics<'_, D, V>,
        mu: f64,
        own: &SymmetricTensor<D, V>,
        nodes: &GradientSums<D, V>,
        still: &GradientSums<D, V>,
    ) {
        let (pulled, part, zero) = (at.times_inverse_shape(own), at.scale * mu, at.scale.constant(0.0));
        let elastic = at.elastic(&pulled, own.out);
        let trace = elastic.trace();
        for i in 0..D {
            for j in 0..D {
                self.pulled[i][j] = self.pulled[i][j] + pulled[i][j] * part;
            }
        }
        self.out = self.out + own.out * part;
        self.slope = self.slope - at.above_floor.choose(trace * (1.0 / 3.0) * mu / at.jacobian, zero);
        self.stored = self.stored + (trace - 3.0) * (0.5 * mu);
        let mut curvature = nodes.shear_bound(&elastic);
        if (-at.above_floor).any_positive() {
            // Below the floor J^(−2/3) is constant and W quadratic.
            curvature = at.above_floor.choose(curvature, own.dot(&still.metric) * at.scale);
        }
        self.curvature = self.curvature + curvature * mu;
    }
}

/// Returns Σ |∂J/∂x_a|², 1/m².
#[inline(always)]
fn dilated<const D: usize, V: Number>(at: &IsochoricKinematics<'_, D, V>, nodes: &GradientSums<D, V>) -> V {
    let ring = at.strain.det_f * at.strain.hoop;
    let mut sum = nodes.metric.inner[0][0];
    for i in 1..D {
        sum = sum + nodes.metric.inner[i][i];
    }
    let sum = sum * at.jacobian * at.jacobian;
    if D == 2 { sum + ring * ring * (D + 1) as f64 } else { sum }
}

#[cfg(test)]
mod tests;
