//! Eight strained elements of a gel that remembers: what their law needs of where they are, whatever it remembers.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::{LANES, Wide, cofactors, fetch, fused, wide};
use super::rest_geometry::Shape;
use super::simd_material::{Strains, Undeformed};
use super::symmetric_tensor::Symmetric;
use crate::constitutive::NeoHookean;
use crate::math::{Number, exp, ln};
use fearless_simd::{Simd, SimdBase, f64x8};

/// ∇N_a of eight elements at rest for a = 1..=D, 1/m.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct Gradients<const D: usize>([[Wide; D]; D]);

/// Eight strained elements: cof F, J no less than where the law is continued, J^(−2/3), and where that is above 0, none is continued.
pub(super) struct Placed<'a, const D: usize, V> {
    pub strain: &'a Strains<D, V>,
    pub cofactor: [[V; D]; D],
    pub jacobian: V,
    pub scale: V,
    pub upright: V,
}

/// Sums over the nodes of eight elements, with g_a = ∇N_a: of g_a ⊗ g_a, the hoop parts out of the plane, and the greatest |g_a|².
pub(super) struct AtNodes<const D: usize, V> {
    pub metric: Symmetric<D, V>,
    pub sharpest: V,
}

impl<const D: usize> Default for Gradients<D> {
    fn default() -> Self {
        Self([[[0.0; LANES]; D]; D])
    }
}

impl<const D: usize> Undeformed<D> for Gradients<D> {
    #[inline(always)]
    fn fetch(&self) {
        for eight in self.0.iter().flatten() {
            fetch(eight);
        }
    }

    /// F = Σ e_a ⊗ ∇N_a in the place of the edges e_a; 1 where nodes are at rest, not what rounding makes of it.
    #[inline(always)]
    fn deform<S: Simd>(&self, (strained, _): (f64x8<S>, f64x8<S>), f: &mut [[f64x8<S>; D]; D]) -> f64x8<S> {
        let (simd, edges) = (strained.simd, *f);
        let one = f64x8::splat(simd, 1.0);
        for i in 0..D {
            for j in 0..D {
                let mut sum = edges[i][0] * wide(simd, &self.0[0][j]);
                for a in 1..D {
                    sum = fused(edges[i][a], wide(simd, &self.0[a][j]), sum);
                }
                f[i][j] = if i == j { fused(sum, strained, one - strained) } else { sum * strained };
            }
        }
        one
    }
}

impl<const D: usize> Gradients<D> {
    /// Those of eight elements.
    #[inline(always)]
    pub fn new<S: Simd>(shape: &Shape<D, f64x8<S>>) -> Self {
        let mut new = Self::default();
        for a in 0..D {
            for i in 0..D {
                new.0[a][i] = shape.gradients[a][i].into();
            }
        }
        new
    }

    /// The gradients as vectors.
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S) -> [[f64x8<S>; D]; D] {
        let mut all = [[f64x8::splat(simd, 0.0); D]; D];
        for a in 0..D {
            for i in 0..D {
                all[a][i] = wide(simd, &self.0[a][i]);
            }
        }
        all
    }

    /// Of eight elements at rest.
    #[inline(always)]
    pub fn at_rest<S: Simd>(&self, hoop: f64x8<S>) -> AtNodes<D, f64x8<S>> {
        AtNodes::new(&self.load(hoop.simd), hoop)
    }
}

impl<const D: usize, S: Simd> AtNodes<D, f64x8<S>> {
    /// From the gradients of all nodes but the first, which has minus their sum.
    #[inline(always)]
    fn new(gradients: &[[f64x8<S>; D]; D], hoop: f64x8<S>) -> Self {
        let zero = f64x8::splat(hoop.simd, 0.0);
        let ring = if D == 2 { hoop * hoop * (D + 1) as f64 } else { zero };
        let mut sum = Self { metric: Symmetric::diagonal(zero, ring), sharpest: zero };
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
                length = fused(g[i], g[i], length);
                for j in i..D {
                    sum.metric.inner[i][j] = fused(g[i], g[j], sum.metric.inner[i][j]);
                }
            }
            sum.sharpest = sum.sharpest.or_greater(length);
        }
        sum
    }
}

impl<const D: usize, V: Number> AtNodes<D, V> {
    /// Bound of the curvature of ½(tr b̄ − 3) in the places of the nodes ([`super::simplex`]), 1/m².
    #[inline(always)]
    pub fn shear_bound(&self, elastic: &Symmetric<D, V>) -> V {
        let (deviator, trace) = (elastic.deviator(), elastic.trace());
        let slant = trace.constant(2.0) / trace;
        elastic.dot(&self.metric)
            + deviator.squared().dot(&self.metric) * slant
            + self.metric.trace() * trace * (1.0 / 3.0)
    }
}

impl<const D: usize, V: Number> Placed<'_, D, V> {
    /// F C̄⁻¹ of what is remembered.
    #[inline(always)]
    pub fn pulled(&self, memory: &Symmetric<D, V>) -> [[V; D]; D] {
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

    /// b̄ = J^(−2/3) F C̄⁻¹ Fᵀ, from F C̄⁻¹ and the component of C̄⁻¹ out of the plane.
    #[inline(always)]
    pub fn elastic(&self, pulled: &[[V; D]; D], out: V) -> Symmetric<D, V> {
        let (f, none) = (&self.strain.f, self.scale.constant(0.0));
        let mut inner = [[none; D]; D];
        for i in 0..D {
            for j in i..D {
                let mut sum = pulled[i][0] * f[j][0];
                for k in 1..D {
                    sum = pulled[i][k] * f[j][k] + sum;
                }
                inner[i][j] = sum * self.scale;
            }
        }
        let out = if D == 2 { self.strain.out * self.strain.out * out * self.scale } else { none };
        Symmetric { inner, out }
    }

    /// J^(2/3) F⁻¹ b̄ F⁻ᵀ, the C̄⁻¹ of a b̄.
    #[inline(always)]
    pub fn remembered(&self, elastic: &Symmetric<D, V>) -> Symmetric<D, V> {
        let (c, s) = (&self.cofactor, self.strain);
        let none = self.scale.constant(0.0);
        let over = self.scale.constant(1.0) / (s.inner * s.inner * self.scale);
        let (mut half, mut inner) = ([[none; D]; D], [[none; D]; D]);
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
        let out = if D == 2 { elastic.out / (s.out * s.out * self.scale) } else { none };
        Symmetric { inner, out }
    }
}

impl<'a, const D: usize, S: Simd> Placed<'a, D, f64x8<S>> {
    #[inline(always)]
    pub fn new(strain: &'a Strains<D, f64x8<S>>) -> Self {
        let jacobian = strain.jacobian().at_least(NeoHookean::FLOOR);
        let upright = strain.jacobian() - NeoHookean::FLOOR;
        let scale = exp(ln(jacobian) * (-2.0 / 3.0));
        Self { strain, cofactor: cofactors(&strain.f), jacobian, scale, upright }
    }

    /// Of the elements where they are now.
    #[inline(always)]
    pub fn at_nodes(&self, rest: &Gradients<D>) -> AtNodes<D, f64x8<S>> {
        let (s, simd) = (self.strain, self.jacobian.simd);
        let part = s.out / self.jacobian;
        let mut all = rest.load(simd);
        for a in 0..D {
            let gradient = all[a];
            for i in 0..D {
                let mut sum = self.cofactor[i][0] * gradient[0];
                for j in 1..D {
                    sum = fused(self.cofactor[i][j], gradient[j], sum);
                }
                all[a][i] = sum * part;
            }
        }
        AtNodes::new(&all, if D == 2 { s.hoop / s.out } else { part })
    }

    /// −w P ∇N_a for a = 1..=D and −w P_θθ/(3R̄) of P = K + p ∂J/∂F: `pulled` is K over a number, `shape` −w times that and `pressure` −w p.
    #[inline(always)]
    pub fn forces(
        &self,
        rest: &Gradients<D>,
        (pulled, out): (&[[f64x8<S>; D]; D], f64x8<S>),
        (shape, pressure): (f64x8<S>, f64x8<S>),
    ) -> ([[f64x8<S>; D]; D], f64x8<S>) {
        let (s, simd) = (self.strain, self.jacobian.simd);
        let around = fused(pressure, s.inner, shape * s.out * out) * s.hoop;
        let area = pressure * s.out;
        let mut forces = [[f64x8::splat(simd, 0.0); D]; D];
        for i in 0..D {
            for a in 0..D {
                for j in 0..D {
                    let stress = fused(area, self.cofactor[i][j], shape * pulled[i][j]);
                    forces[a][i] = fused(stress, wide(simd, &rest.0[a][j]), forces[a][i]);
                }
            }
        }
        (forces, around)
    }
}
