//! Kinematics of eight deformed elements of a material with history variables.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::{LANES, LaneArray, cofactors, load_lanes, multiply_add, prefetch};
use super::rest_geometry::RestGeometry;
use super::simd_material::{BatchDeformation, RestOperator};
use super::symmetric_tensor::SymmetricTensor;
use crate::constitutive::NeoHookean;
use crate::math::{Number, exp, ln};
use fearless_simd::{Simd, SimdBase, f64x8};

/// Material gradients ∇N_a of eight elements for a = 1..=D, 1/m.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct ShapeGradients<const D: usize>([[LaneArray; D]; D]);

/// Kinematics of eight deformed elements.
pub(super) struct BatchKinematics<'a, const D: usize, V> {
    pub strain: &'a BatchDeformation<D, V>,
    /// cof F.
    pub cofactor: [[V; D]; D],
    /// J, clamped to the floor of the material law.
    pub jacobian: V,
    /// J^(−2/3).
    pub scale: V,
    /// Height of J above the floor, at most 0 in the continuation.
    pub above_floor: V,
}

/// Nodal sums of the gradients g_a = ∇N_a of eight elements.
pub(super) struct GradientSums<const D: usize, V> {
    /// Σ g_a ⊗ g_a, 1/m², with the hoop parts as the out-of-plane component.
    pub metric: SymmetricTensor<D, V>,
    /// Greatest |g_a|², 1/m².
    pub max_squared: V,
}

impl<const D: usize> Default for ShapeGradients<D> {
    fn default() -> Self {
        Self([[[0.0; LANES]; D]; D])
    }
}

impl<const D: usize> RestOperator<D> for ShapeGradients<D> {
    #[inline(always)]
    fn prefetch(&self) {
        for eight in self.0.iter().flatten() {
            prefetch(eight);
        }
    }

    /// Replaces the edges e_a by F = Σ e_a ⊗ ∇N_a; exactly 1 at rest, without rounding.
    #[inline(always)]
    fn deform<S: Simd>(&self, strained: f64x8<S>, _scale: f64x8<S>, f: &mut [[f64x8<S>; D]; D]) -> f64x8<S> {
        let (simd, edges) = (strained.simd, *f);
        let one = f64x8::splat(simd, 1.0);
        for i in 0..D {
            for j in 0..D {
                let mut sum = edges[i][0] * load_lanes(simd, &self.0[0][j]);
                for a in 1..D {
                    sum = multiply_add(edges[i][a], load_lanes(simd, &self.0[a][j]), sum);
                }
                f[i][j] = if i == j { multiply_add(sum, strained, one - strained) } else { sum * strained };
            }
        }
        one
    }
}

impl<const D: usize> ShapeGradients<D> {
    /// Takes the gradients from the rest geometry of eight elements.
    #[inline(always)]
    pub fn new<S: Simd>(shape: &RestGeometry<D, f64x8<S>>) -> Self {
        let mut new = Self::default();
        for a in 0..D {
            for i in 0..D {
                new.0[a][i] = shape.gradients[a][i].into();
            }
        }
        new
    }

    /// Loads the gradients as vectors.
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S) -> [[f64x8<S>; D]; D] {
        let mut all = [[f64x8::splat(simd, 0.0); D]; D];
        for a in 0..D {
            for i in 0..D {
                all[a][i] = load_lanes(simd, &self.0[a][i]);
            }
        }
        all
    }

    /// Returns the nodal sums of the material gradients.
    #[inline(always)]
    pub fn sums<S: Simd>(&self, hoop: f64x8<S>) -> GradientSums<D, f64x8<S>> {
        GradientSums::new(&self.load(hoop.simd), hoop)
    }
}

impl<const D: usize, S: Simd> GradientSums<D, f64x8<S>> {
    /// Sums the gradients of all nodes but the first, and of the first, minus their sum.
    #[inline(always)]
    fn new(gradients: &[[f64x8<S>; D]; D], hoop: f64x8<S>) -> Self {
        let zero = f64x8::splat(hoop.simd, 0.0);
        let ring = if D == 2 { hoop * hoop * (D + 1) as f64 } else { zero };
        let mut sum = Self { metric: SymmetricTensor::diagonal(zero, ring), max_squared: zero };
        let mut first = [zero; D];
        for a in 0..=D {
            let mut g = first;
            if a < D {
                g = gradients[a];
                for i in 0..D {
                    first[i] -= g[i];
                }
            }
            let mut length = zero;
            for i in 0..D {
                length = multiply_add(g[i], g[i], length);
                for j in i..D {
                    sum.metric.inner[i][j] = multiply_add(g[i], g[j], sum.metric.inner[i][j]);
                }
            }
            sum.max_squared = sum.max_squared.or_greater(length);
        }
        sum
    }
}

impl<const D: usize, V: Number> GradientSums<D, V> {
    /// Returns an upper bound of the second derivative of ½(tr b̄ − 3) by the nodal positions ([`super::simplex`]),
    /// 1/m².
    #[inline(always)]
    pub fn shear_bound(&self, elastic: &SymmetricTensor<D, V>) -> V {
        let (deviator, trace) = (elastic.deviator(), elastic.trace());
        let slant = trace.constant(2.0) / trace;
        elastic.dot(&self.metric)
            + deviator.squared().dot(&self.metric) * slant
            + self.metric.trace() * trace * (1.0 / 3.0)
    }
}

impl<const D: usize, V: Number> BatchKinematics<'_, D, V> {
    /// Returns F C̄⁻¹ for the rest shape of the history variables.
    #[inline(always)]
    pub fn times_inverse_shape(&self, memory: &SymmetricTensor<D, V>) -> [[V; D]; D] {
        let f = &self.strain.f;
        let mut all = *f;
        for i in 0..D {
            for j in 0..D {
                let mut sum = f[i][0] * memory.of(0, j);
                for k in 1..D {
                    sum = sum + f[i][k] * memory.of(k, j);
                }
                all[i][j] = sum;
            }
        }
        all
    }

    /// Returns b̄ = J^(−2/3) F C̄⁻¹ Fᵀ from F C̄⁻¹ and the out-of-plane component of C̄⁻¹.
    #[inline(always)]
    pub fn elastic(&self, pulled: &[[V; D]; D], out: V) -> SymmetricTensor<D, V> {
        let (f, zero) = (&self.strain.f, self.scale.constant(0.0));
        let mut inner = [[zero; D]; D];
        for i in 0..D {
            for j in i..D {
                let mut sum = pulled[i][0] * f[j][0];
                for k in 1..D {
                    sum = pulled[i][k] * f[j][k] + sum;
                }
                inner[i][j] = sum * self.scale;
            }
        }
        let out = if D == 2 { self.strain.out * self.strain.out * out * self.scale } else { zero };
        SymmetricTensor { inner, out }
    }

    /// Returns the pull-back C̄⁻¹ = J^(2/3) F⁻¹ b̄ F⁻ᵀ of b̄.
    #[inline(always)]
    pub fn pull_back(&self, elastic: &SymmetricTensor<D, V>) -> SymmetricTensor<D, V> {
        let (c, s) = (&self.cofactor, self.strain);
        let zero = self.scale.constant(0.0);
        let over = self.scale.constant(1.0) / (s.det_f * s.det_f * self.scale);
        let (mut half, mut inner) = ([[zero; D]; D], [[zero; D]; D]);
        for i in 0..D {
            for j in 0..D {
                half[i][j] = c[0][i] * elastic.of(0, j);
                for k in 1..D {
                    half[i][j] = half[i][j] + c[k][i] * elastic.of(k, j);
                }
            }
        }
        for i in 0..D {
            for j in i..D {
                let mut sum = half[i][0] * c[0][j];
                for k in 1..D {
                    sum = sum + half[i][k] * c[k][j];
                }
                inner[i][j] = sum * over;
            }
        }
        let out = if D == 2 { elastic.out / (s.out * s.out * self.scale) } else { zero };
        SymmetricTensor { inner, out }
    }
}

impl<'a, const D: usize, S: Simd> BatchKinematics<'a, D, f64x8<S>> {
    /// Computes the kinematics from the deformation.
    #[inline(always)]
    pub fn new(strain: &'a BatchDeformation<D, f64x8<S>>) -> Self {
        let jacobian = strain.jacobian().at_least(NeoHookean::FLOOR);
        let above_floor = strain.jacobian() - NeoHookean::FLOOR;
        let scale = exp(ln(jacobian) * (-2.0 / 3.0));
        Self { strain, cofactor: cofactors(&strain.f), jacobian, scale, above_floor }
    }

    /// Returns the nodal sums of the spatial gradients.
    #[inline(always)]
    pub fn gradient_sums(&self, rest: &ShapeGradients<D>) -> GradientSums<D, f64x8<S>> {
        let (s, simd) = (self.strain, self.jacobian.simd);
        let part = s.out / self.jacobian;
        let mut all = rest.load(simd);
        for a in 0..D {
            let gradient = all[a];
            for i in 0..D {
                let mut sum = self.cofactor[i][0] * gradient[0];
                for j in 1..D {
                    sum = multiply_add(self.cofactor[i][j], gradient[j], sum);
                }
                all[a][i] = sum * part;
            }
        }
        GradientSums::new(&all, if D == 2 { s.hoop / s.out } else { part })
    }

    /// Returns the nodal forces −w P ∇N_a, a = 1..=D, and the hoop force −w P_θθ/(3R̄), for P = K + p ∂J/∂F.
    ///
    /// K is a multiple of `pulled`, with the out-of-plane component `out`; `shape` is −w times the multiple,
    /// `pressure` −w p.
    #[inline(always)]
    pub fn forces(
        &self,
        rest: &ShapeGradients<D>,
        pulled: &[[f64x8<S>; D]; D],
        out: f64x8<S>,
        shape: f64x8<S>,
        pressure: f64x8<S>,
    ) -> ([[f64x8<S>; D]; D], f64x8<S>) {
        let (s, simd) = (self.strain, self.jacobian.simd);
        let hoop_force = multiply_add(pressure, s.det_f, shape * s.out * out) * s.hoop;
        let area = pressure * s.out;
        let mut forces = [[f64x8::splat(simd, 0.0); D]; D];
        for i in 0..D {
            for a in 0..D {
                for j in 0..D {
                    let stress = multiply_add(area, self.cofactor[i][j], shape * pulled[i][j]);
                    forces[a][i] = multiply_add(stress, load_lanes(simd, &rest.0[a][j]), forces[a][i]);
                }
            }
        }
        (forces, hoop_force)
    }
}
