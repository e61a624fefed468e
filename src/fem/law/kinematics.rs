//! Kinematics of elements, over [`Number`]: gradients, their nodal sums, and nodal forces.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::element_law::{ElementDeformation, RestOperator};
use super::rest_geometry::RestGeometry;
use crate::constitutive::IsochoricDeformation;
use crate::fem::Section;
use crate::math::{Number, SymmetricTensor, array};
use std::fmt::Debug;

/// Material gradients ∇N_a for a = 1..=D, 1/m.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(crate) struct ShapeGradients<const D: usize, L = [f64; 8]>([[L; D]; D]);

/// Nodal sums of the gradients g_a = ∇N_a.
#[derive(Clone, Copy)]
pub(crate) struct GradientSums<const D: usize, V> {
    /// Σ g_a ⊗ g_a, 1/m², with the hoop parts as the out-of-plane component.
    pub metric: SymmetricTensor<D, V>,
    /// Greatest |g_a|², 1/m².
    pub max_squared: V,
}

impl<const D: usize, L: Copy + Default> Default for ShapeGradients<D, L> {
    fn default() -> Self {
        Self([[L::default(); D]; D])
    }
}

impl<const D: usize, L: Copy + Default + Debug> RestOperator<D, L> for ShapeGradients<D, L> {
    /// Replaces the edges e_a by F = Σ e_a ⊗ ∇N_a; exactly 1 at rest, without rounding.
    #[inline(always)]
    fn deform<V: Number<Lanes = L>>(&self, strained: V, _scale: V, f: &mut [[V; D]; D]) -> V {
        let (edges, one) = (*f, strained.constant(1.0));
        for i in 0..D {
            for j in 0..D {
                let mut sum = edges[i][0] * one.load(&self.0[0][j]);
                for a in 1..D {
                    sum = edges[i][a].multiply_add(one.load(&self.0[a][j]), sum);
                }
                f[i][j] = if i == j { sum.multiply_add(strained, one - strained) } else { sum * strained };
            }
        }
        one
    }
}

impl<const D: usize, L: Copy + Default> ShapeGradients<D, L> {
    /// Takes the gradients from the rest geometry.
    #[inline(always)]
    pub fn new<V: Number<Lanes = L>>(shape: &RestGeometry<D, V>) -> Self {
        let mut new = Self::default();
        for a in 0..D {
            for i in 0..D {
                new.0[a][i] = shape.gradients[a][i].store();
            }
        }
        new
    }

    /// Loads the gradients.
    #[inline(always)]
    fn load<V: Number<Lanes = L>>(&self, zero: V) -> [[V; D]; D] {
        let mut all = [[zero; D]; D];
        for a in 0..D {
            for i in 0..D {
                all[a][i] = zero.load(&self.0[a][i]);
            }
        }
        all
    }

    /// Returns the nodal sums of the material gradients.
    #[inline(always)]
    pub fn sums<V: Number<Lanes = L>>(&self, hoop: V) -> GradientSums<D, V> {
        GradientSums::new(&self.load(hoop), hoop)
    }

    /// Returns the nodal sums of the spatial gradients.
    #[inline(always)]
    pub fn spatial_sums<V: Number<Lanes = L>>(&self, at: &IsochoricDeformation<D, V>, hoop: V) -> GradientSums<D, V> {
        let part = at.out / at.jacobian;
        let mut all = self.load(part);
        for a in 0..D {
            let gradient = all[a];
            for i in 0..D {
                let mut sum = at.cofactor[i][0] * gradient[0];
                for j in 1..D {
                    sum = at.cofactor[i][j].multiply_add(gradient[j], sum);
                }
                all[a][i] = sum * part;
            }
        }
        GradientSums::new(&all, if D == 2 { hoop / at.out } else { part })
    }
}

impl<const D: usize, V: Number> GradientSums<D, V> {
    /// Sums the gradients of all nodes but the first, and of the first, minus their sum.
    #[inline(always)]
    fn new(gradients: &[[V; D]; D], hoop: V) -> Self {
        let zero = hoop.constant(0.0);
        let ring = if D == 2 { hoop * hoop * (D + 1) as f64 } else { zero };
        let mut sum = Self { metric: SymmetricTensor::diagonal(zero, ring), max_squared: zero };
        let mut first = [zero; D];
        for a in 0..=D {
            let mut g = first;
            if a < D {
                g = gradients[a];
                for i in 0..D {
                    first[i] = first[i] - g[i];
                }
            }
            let mut length = zero;
            for i in 0..D {
                length = g[i].multiply_add(g[i], length);
                for j in i..D {
                    sum.metric.inner[i][j] = g[i].multiply_add(g[j], sum.metric.inner[i][j]);
                }
            }
            sum.max_squared = sum.max_squared.or_greater(length);
        }
        sum
    }

    /// Returns an upper bound of the second derivative of ½(tr b̄ − 3) by the nodal positions, 1/m².
    ///
    /// With L = δF F⁻¹ = Σ δx_a ⊗ g_a, g_a the spatial gradients (with the hoop parts of a ring), the second
    /// derivative is L:Lb̄ − 4/3 tr L b̄:L + 2/9 Ī₁ (tr L)² + Ī₁/3 tr(LL). The terms with tr L are together at most 2
    /// (d:L)²/Ī₁, d = dev b̄. Each term is a square of a sum over the nodes, so at most the sum of the squares.
    #[inline(always)]
    pub fn shear_bound(&self, elastic: &SymmetricTensor<D, V>) -> V {
        let (deviator, trace) = (elastic.deviator(), elastic.trace());
        let slant = trace.constant(2.0) / trace;
        elastic.dot(&self.metric)
            + deviator.squared().dot(&self.metric) * slant
            + self.metric.trace() * trace * (1.0 / 3.0)
    }
}

impl<const D: usize, V: Number> ElementDeformation<D, V> {
    /// Returns the isochoric deformation.
    #[inline(always)]
    pub fn isochoric(&self) -> IsochoricDeformation<D, V> {
        IsochoricDeformation::new(&self.f, self.out, self.det_f)
    }

    /// Returns the nodal forces −w P ∇N_a, a = 1..=D, and the hoop force −w P_θθ/(3R̄), for P = K + p ∂J/∂F.
    ///
    /// K is a multiple of `pulled`, with the out-of-plane component `out` over λ; `shape` is −w times the multiple,
    /// `pressure` −w p.
    #[inline(always)]
    pub fn nodal_forces(
        &self,
        rest: &ShapeGradients<D, V::Lanes>,
        cofactor: &[[V; D]; D],
        pulled: &[[V; D]; D],
        out: V,
        shape: V,
        pressure: V,
    ) -> ([[V; D]; D], V) {
        let hoop_force = pressure.multiply_add(self.det_f, shape * self.out * out) * self.hoop;
        let area = pressure * self.out;
        let mut forces = [[area.constant(0.0); D]; D];
        for i in 0..D {
            for a in 0..D {
                for j in 0..D {
                    let stress = area.multiply_add(cofactor[i][j], shape * pulled[i][j]);
                    forces[a][i] = stress.multiply_add(area.load(&rest.0[a][j]), forces[a][i]);
                }
            }
        }
        (forces, hoop_force)
    }

    /// Returns the factor s of κ ([`crate::fem::Simplices`]).
    #[inline(always)]
    pub fn minor_bound(&self, section: Section) -> V {
        match section {
            Section::Planar { .. } => self.out.constant(1.0),
            Section::Spatial => (array::norm_squared(&self.f) * 2.0).root(),
            Section::Axisymmetric => two_largest(array::norm_squared(&self.f), self.det_f, self.out),
        }
    }
}

/// Returns the sum of the two largest of the singular values s₁ ≥ s₂ of the plane part and |λ|, from Σ s², s₁s₂ and λ.
#[inline(always)]
pub(crate) fn two_largest<V: Number>(square: V, inner: V, out: V) -> V {
    let area = inner.absolute() * 2.0;
    let (sum, difference) = ((square + area).root(), (square - area).at_least(0.0).root());
    sum.or_greater((sum + difference) * 0.5 + out.absolute())
}
