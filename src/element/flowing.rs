//! Elements of a gel that flows in lanes: as [`super::flow`] has them, eight side by side.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::Section;
use super::batch::{LANES, Wide, wide};
use super::eight::Shape;
use super::lanes::{Eight, Pull, Slopes, Solid, Strains, fused};
use super::recall::Recall;
use super::simplex::isochoric;
use crate::algebra::{Number, exp, ln};
use crate::material::{Flowing, NeoHookean, Returned, Volumetric};
use fearless_simd::{Simd, SimdBase, f64x8};

/// ∇N_a of eight elements at rest for a = 1..=D, 1/m.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct Gradients<const D: usize>([[Wide; D]; D]);

/// The elastic part of eight isochoric deformations, b̄ (components of i ≤ j) and its component out of the plane, 0 in space.
#[derive(Clone, Copy)]
struct Elastic<const D: usize, V> {
    inner: [[V; D]; D],
    out: V,
}

/// Eight strained elements: J no less than where the law is continued, J^(−2/3), and where that is above 0, none is continued.
struct Placed<'a, const D: usize, V> {
    strain: &'a Strains<D, V>,
    jacobian: V,
    scale: V,
    upright: V,
}

/// What eight elements remember, on its way.
#[derive(Clone, Copy)]
struct Memories<const D: usize, V> {
    inverse: [[V; D]; D],
    out: V,
    plastic: V,
    rate: V,
    left: V,
}

/// Sums over the nodes of eight elements, with g_a = ∇N_a where they are now: of the curvature in shear ([`super::simplex`]), of |g_a|²
/// with its hoop part and with that along r, and the greatest |g_a|².
struct AtNodes<V> {
    sheared: V,
    spread: V,
    dilated: V,
    sharpest: V,
}

impl<const D: usize> Default for Gradients<D> {
    fn default() -> Self {
        Self([[[0.0; LANES]; D]; D])
    }
}

impl<const D: usize> Solid<D> for Flowing {
    type Rest = Gradients<D>;
    const REMEMBERS: bool = true;

    #[inline(always)]
    fn put<S: Simd>(&self, rest: &mut Gradients<D>, shape: &Shape<D, f64x8<S>>) {
        for a in 0..D {
            for i in 0..D {
                rest.0[a][i] = shape.gradients[a][i].into();
            }
        }
    }

    /// F = Σ e_a ⊗ ∇N_a; 1 where nodes are at rest, not what rounding makes of it.
    #[inline(always)]
    fn deform<S: Simd>(
        rest: &Gradients<D>,
        (strained, _): (f64x8<S>, f64x8<S>),
        f: &mut [[f64x8<S>; D]; D],
    ) -> f64x8<S> {
        let (simd, edges) = (strained.simd, *f);
        let one = f64x8::splat(simd, 1.0);
        for i in 0..D {
            for j in 0..D {
                let mut sum = edges[i][0] * wide(simd, &rest.0[0][j]);
                for a in 1..D {
                    sum = fused(edges[i][a], wide(simd, &rest.0[a][j]), sum);
                }
                f[i][j] = if i == j { fused(sum, strained, one - strained) } else { sum * strained };
            }
        }
        one
    }

    #[inline(always)]
    fn volumetric<T: Number>(&self, j: T) -> Volumetric<T> {
        self.state.volumetric(j)
    }

    #[inline(always)]
    fn own<T: Number>(&self, j: T) -> Volumetric<T> {
        self.own(j)
    }

    #[inline(always)]
    fn shared<T: Number>(&self, mean: T) -> Volumetric<T> {
        self.shared(mean)
    }

    #[inline(always)]
    fn pull<S: Simd>(
        &self,
        section: Section,
        (batch, rest, kick, memory): Eight<'_, D, Gradients<D>>,
        (s, u): (&Strains<D, f64x8<S>>, &Slopes<f64x8<S>>),
    ) -> Pull<D, f64x8<S>> {
        let (simd, memory) = (s.inner.simd, &mut memory[0]);
        let (zero, volume) = (f64x8::splat(simd, 0.0), wide(simd, &batch.volume));
        let at = Placed::new(s);
        let mut own = Memories::load(simd, memory);
        let sound = own.left;
        let (elastic, lost) = returned(self, &at, kick.elapsed, &mut own);
        if let Some(softening) = &self.softening {
            own.left = softening.left(sound, own.plastic, kick.elapsed);
        }
        let stored = (elastic.trace() - 3.0) * (0.5 * self.shear_modulus);
        let nodes = at.spread(rest, &elastic);
        let before = wide(simd, &memory.jacobian);
        let mut viscous = (zero, zero);
        if kick.elapsed > 0.0 {
            let rate = (s.jacobian - before) / (at.jacobian * kick.elapsed);
            viscous = (rate, resistance(self, nodes.sharpest, rate) * rate);
        }
        let (mu, slope) = (own.left * self.shear_modulus, u.slope + viscous.1);
        let lost = [
            volume * lost * ((sound + own.left) * 0.5),
            volume * viscous.1 * (s.jacobian - before),
            volume * stored * (sound - own.left),
        ];
        let minors = if matches!(section, Section::Planar { .. }) { 1.0 } else { 2.0 };
        let swollen = u.curvature * at.jacobian * at.jacobian * nodes.dilated
            + slope.absolute() * at.jacobian * nodes.spread * minors;
        let sheared = mu * (nodes.sheared + elastic.trace() * nodes.spread * (1.0 / 3.0));
        let damping = resistance(self, nodes.sharpest, viscous.0 * 2.0) * at.jacobian * nodes.dilated;
        let stiffness = damped::<D, _>(self.density, (volume, volume * (sheared + swollen)), damping);
        let (forces, around) = at.push((rest, volume), (&own, mu, elastic.trace()), slope);
        own.store(memory);
        s.jacobian.store_slice(&mut memory.jacobian);
        viscous.1.store_slice(&mut memory.viscous);
        Pull { forces, around, stiffness, energy: volume * stored * own.left, lost }
    }
}

/// b̄ with what is remembered, brought back to the strength if a step has passed and it is beyond; and what was lost, J/m³.
#[inline(always)]
fn returned<const D: usize, V: Number>(
    gel: &Flowing,
    at: &Placed<'_, D, V>,
    step: f64,
    memory: &mut Memories<D, V>,
) -> (Elastic<D, V>, V) {
    let (trial, mu, none) = (at.elastic(memory), gel.shear_modulus, at.jacobian.constant(0.0));
    let Some(strength) = &gel.strength else { return (trial, none) };
    if step <= 0.0 {
        return (trial, none);
    }
    let (deviator, trace) = (trial.deviator(), trial.trace());
    let square = deviator.norm_squared();
    let stress = (square * 1.5).root() * mu;
    let Returned { stress: left, strain } = strength.returned(stress, trace * mu, (step, memory.rate));
    let flown = at.upright.choose(strain, none);
    if !flown.any_positive() {
        return (trial, none);
    }
    let part = flown.choose(left / stress, none + 1.0);
    let squared = part * part;
    let mean = isochoric(trace * (1.0 / 3.0), (square * squared * 0.5, squared * part * deviator.determinant()));
    let back = deviator.scaled(part, mean);
    let (inverse, out) = at.remembered(&back);
    let mut elastic = trial;
    for i in 0..D {
        for j in i..D {
            elastic.inner[i][j] = flown.choose(back.inner[i][j], trial.inner[i][j]);
            memory.inverse[i][j] = flown.choose(inverse[i][j], memory.inverse[i][j]);
        }
    }
    if D == 2 {
        elastic.out = flown.choose(back.out, trial.out);
        memory.out = flown.choose(out, memory.out);
    }
    memory.plastic = memory.plastic + flown;
    memory.rate = flown.choose(flown * (1.0 / step), memory.rate);
    let lost = (trace - elastic.trace()) * mu * left / (left + stress);
    (elastic, flown.choose(lost, none))
}

/// η, Pa·s, of the least height, 1/√ of the greatest |g_a|².
#[inline(always)]
fn resistance<V: Number>(gel: &Flowing, sharpest: V, rate: V) -> V {
    // An empty lane has no gradients.
    let height = sharpest.constant(1.0) / sharpest.at_least(f64::MIN_POSITIVE).root();
    gel.viscosity.at(gel.density, (gel.sound_speed(), height), rate)
}

/// The stiffness without viscosity that would ask for the step that κ leaves with the viscous c = w η J Σ|b|².
#[inline(always)]
fn damped<const D: usize, V: Number>(density: f64, (volume, kappa): (V, V), damping: V) -> V {
    let mass = (volume * (density / (D + 1) as f64)).at_least(f64::MIN_POSITIVE);
    let s = volume * damping * 0.5 / mass.root();
    let root = (kappa + s * s).root() + s;
    root * root
}

impl<const D: usize, S: Simd> Memories<D, f64x8<S>> {
    #[inline(always)]
    fn load(simd: S, from: &Recall<D>) -> Self {
        let mut inverse = [[f64x8::splat(simd, 0.0); D]; D];
        for i in 0..D {
            for j in i..D {
                inverse[i][j] = wide(simd, &from.inverse[i][j]);
            }
        }
        let [out, plastic] = [wide(simd, &from.out), wide(simd, &from.plastic)];
        Self { inverse, out, plastic, rate: wide(simd, &from.rate), left: wide(simd, &from.left) }
    }

    #[inline(always)]
    fn store(&self, to: &mut Recall<D>) {
        for i in 0..D {
            for j in i..D {
                self.inverse[i][j].store_slice(&mut to.inverse[i][j]);
            }
        }
        put(self.out, &mut to.out);
        put(self.plastic, &mut to.plastic);
        put(self.rate, &mut to.rate);
        put(self.left, &mut to.left);
    }
}

#[inline(always)]
fn put<S: Simd>(eight: f64x8<S>, to: &mut Wide) {
    eight.store_slice(to);
}

impl<'a, const D: usize, V: Number> Placed<'a, D, V> {
    #[inline(always)]
    fn new(strain: &'a Strains<D, V>) -> Self {
        let jacobian = strain.jacobian.at_least(NeoHookean::FLOOR);
        let upright = strain.jacobian - NeoHookean::FLOOR;
        Self { strain, jacobian, scale: exp(ln(jacobian) * (-2.0 / 3.0)), upright }
    }

    /// b̄ = J^(−2/3) F C̄_p⁻¹ Fᵀ.
    #[inline(always)]
    fn elastic(&self, memory: &Memories<D, V>) -> Elastic<D, V> {
        let (f, none) = (&self.strain.f, self.scale.constant(0.0));
        let pulled = pulled(f, &memory.inverse);
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
        let out = if D == 2 { self.strain.out * self.strain.out * memory.out * self.scale } else { none };
        Elastic { inner, out }
    }

    /// C̄_p⁻¹ = J^(2/3) F⁻¹ b̄ F⁻ᵀ, its components of i ≤ j, and that out of the plane.
    #[inline(always)]
    fn remembered(&self, elastic: &Elastic<D, V>) -> ([[V; D]; D], V) {
        let (c, s) = (&self.strain.cofactor, self.strain);
        let none = self.scale.constant(0.0);
        let over = self.scale.constant(1.0) / (s.inner * s.inner * self.scale);
        let (mut half, mut inverse) = ([[none; D]; D], [[none; D]; D]);
        for i in 0..D {
            for j in 0..D {
                half[i][j] = c[0][i] * elastic.inner[0][j];
                for k in 1..D {
                    half[i][j] = half[i][j] + c[k][i] * elastic.inner[k.min(j)][k.max(j)];
                }
            }
        }
        for i in 0..D {
            for j in i..D {
                let mut sum = half[i][0] * c[0][j];
                for k in 1..D {
                    sum = sum + half[i][k] * c[k][j];
                }
                inverse[i][j] = sum * over;
            }
        }
        (inverse, elastic.out / (s.out * s.out * self.scale))
    }
}

impl<const D: usize, S: Simd> Placed<'_, D, f64x8<S>> {
    /// g_a for a = 1..=D, where the elements are now.
    #[inline(always)]
    fn gradients(&self, rest: &Gradients<D>) -> [[f64x8<S>; D]; D] {
        let (s, simd) = (self.strain, self.jacobian.simd);
        let part = s.out / self.jacobian;
        let mut all = [[part; D]; D];
        for a in 0..D {
            for i in 0..D {
                let mut sum = s.cofactor[i][0] * wide(simd, &rest.0[a][0]);
                for j in 1..D {
                    sum = fused(s.cofactor[i][j], wide(simd, &rest.0[a][j]), sum);
                }
                all[a][i] = sum * part;
            }
        }
        all
    }

    #[inline(always)]
    fn spread(&self, rest: &Gradients<D>, elastic: &Elastic<D, f64x8<S>>) -> AtNodes<f64x8<S>> {
        let zero = f64x8::splat(self.jacobian.simd, 0.0);
        let hoop = if D == 2 { self.strain.hoop / self.strain.out } else { zero };
        let square = hoop * hoop;
        let (gradients, deviator) = (self.gradients(rest), elastic.deviator());
        let slant = (zero + 2.0) / elastic.trace();
        // What each node has of the ring, and the same of all.
        let ring = fused(slant, deviator.out * deviator.out, elastic.out) * square;
        let mut sum = AtNodes { sheared: zero, spread: zero, dilated: zero, sharpest: zero };
        let mut first = [zero; D];
        for a in 0..=D {
            let mut g = first;
            if a < D {
                g = gradients[a];
                for i in 0..D {
                    first[i] -= g[i];
                }
            }
            let (mut length, mut along, mut turned) = (zero, zero, zero);
            for i in 0..D {
                length = fused(g[i], g[i], length);
                let (mut b, mut d) = (zero, zero);
                for j in 0..D {
                    b = fused(elastic.inner[i.min(j)][i.max(j)], g[j], b);
                    d = fused(deviator.inner[i.min(j)][i.max(j)], g[j], d);
                }
                along = fused(b, g[i], along);
                turned = fused(d, d, turned);
            }
            sum.sheared += fused(slant, turned, along) + ring;
            sum.spread += length + square;
            sum.dilated += length + square + g[0] * hoop * 2.0;
            sum.sharpest = sum.sharpest.or_greater(length);
        }
        sum
    }

    /// −w P ∇N_a for a = 1..=D and −w P_θθ/(3R̄), with P = μ J^(−2/3) F C̄_p⁻¹ + (U′ − μ Ī₁/(3J)) ∂J/∂F.
    #[inline(always)]
    fn push(
        &self,
        (rest, volume): (&Gradients<D>, f64x8<S>),
        (memory, mu, trace): (&Memories<D, f64x8<S>>, f64x8<S>, f64x8<S>),
        slope: f64x8<S>,
    ) -> ([[f64x8<S>; D]; D], f64x8<S>) {
        let (s, simd) = (self.strain, self.jacobian.simd);
        let zero = f64x8::splat(simd, 0.0);
        let sheared = self.upright.choose(mu * trace / (self.jacobian * 3.0), zero);
        // −w of both parts.
        let (shape, pressure) = (-(volume * mu * self.scale), volume * (sheared - slope));
        let around = fused(pressure, s.inner, shape * s.out * memory.out) * s.hoop;
        let (pulled, area) = (pulled(&s.f, &memory.inverse), pressure * s.out);
        let mut forces = [[zero; D]; D];
        for i in 0..D {
            for a in 0..D {
                for j in 0..D {
                    let stress = fused(area, s.cofactor[i][j], shape * pulled[i][j]);
                    forces[a][i] = fused(stress, wide(simd, &rest.0[a][j]), forces[a][i]);
                }
            }
        }
        (forces, around)
    }
}

/// F C̄_p⁻¹.
#[inline(always)]
fn pulled<const D: usize, V: Number>(f: &[[V; D]; D], inverse: &[[V; D]; D]) -> [[V; D]; D] {
    let mut all = *f;
    for i in 0..D {
        for j in 0..D {
            let mut sum = f[i][0] * inverse[0][j];
            for k in 1..D {
                sum = sum + f[i][k] * inverse[k.min(j)][k.max(j)];
            }
            all[i][j] = sum;
        }
    }
    all
}

impl<const D: usize, V: Number> Elastic<D, V> {
    #[inline(always)]
    fn trace(&self) -> V {
        let mut sum = self.out;
        for i in 0..D {
            sum = sum + self.inner[i][i];
        }
        sum
    }

    /// b̄ − tr b̄/3.
    #[inline(always)]
    fn deviator(&self) -> Self {
        let (mean, mut all) = (self.trace() * (1.0 / 3.0), *self);
        for i in 0..D {
            all.inner[i][i] = all.inner[i][i] - mean;
        }
        if D == 2 {
            all.out = all.out - mean;
        }
        all
    }

    #[inline(always)]
    fn norm_squared(&self) -> V {
        let mut sum = self.out * self.out;
        for i in 0..D {
            sum = sum + self.inner[i][i] * self.inner[i][i];
            for j in i + 1..D {
                sum = sum + self.inner[i][j] * self.inner[i][j] * 2.0;
            }
        }
        sum
    }

    #[inline(always)]
    fn determinant(&self) -> V {
        let b = &self.inner;
        if D == 2 {
            return (b[0][0] * b[1][1] - b[0][1] * b[0][1]) * self.out;
        }
        let (x, y, z) = (0, 1, 2 % D);
        b[x][x] * (b[y][y] * b[z][z] - b[y][z] * b[y][z]) - b[x][y] * (b[x][y] * b[z][z] - b[y][z] * b[x][z])
            + b[x][z] * (b[x][y] * b[y][z] - b[y][y] * b[x][z])
    }

    /// θ + s d.
    #[inline(always)]
    fn scaled(&self, part: V, mean: V) -> Self {
        let mut all = *self;
        for i in 0..D {
            for j in i..D {
                all.inner[i][j] = all.inner[i][j] * part;
            }
            all.inner[i][i] = all.inner[i][i] + mean;
        }
        if D == 2 {
            all.out = all.out * part + mean;
        }
        all
    }
}
