//! Elements of a gel that flows in lanes: as [`super::viscoplastic`] has them, eight side by side.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::wide;
use super::history::{Recall, Remembering, put_shape, rows_of_shape, shape};
use super::kinematics::{Gradients, Placed};
use super::rest_geometry::Shape;
use super::simd_material::{Eight, Pull, Slopes, Solid, Strains};
use super::simplex::isochoric;
use super::symmetric_tensor::Symmetric;
use super::{Memory, Section};
use crate::constitutive::{Flowing, Returned, Volume};
use crate::math::Number;
use fearless_simd::{Simd, SimdBase, f64x8};

/// What eight elements remember, on its way.
#[derive(Clone, Copy)]
struct Memories<const D: usize, V> {
    shape: Symmetric<D, V>,
    plastic: V,
    rate: V,
    left: V,
    stress: V,
    felt: V,
}

/// Numbers that an element remembers after its shape: ε_p, J, the rate of ε_p, what softening has left, q, U′ as it is felt, and what viscosity
/// added to U′ at the last own tick, Pa, which is of no use after it.
const NUMBERS: usize = 7;

impl<const D: usize> Remembering<D> for Flowing {
    fn rows(&self) -> usize {
        rows_of_shape::<D>() + NUMBERS
    }

    fn put_memory(&self, rows: &mut [Recall], lane: usize, memory: &[Memory<D>]) {
        let memory = &memory[0];
        put_shape(rows, lane, memory);
        let [plastic, jacobian, rate, left, stress, felt, _] = numbers::<D>(rows);
        (plastic.0[lane], jacobian.0[lane]) = (memory.plastic, memory.jacobian);
        (rate.0[lane], left.0[lane]) = (memory.rate, memory.left);
        (stress.0[lane], felt.0[lane]) = (memory.stress, memory.felt);
    }

    fn take_memory(&self, rows: &[Recall], lane: usize, memory: &mut [Memory<D>]) {
        let number = |i: usize| rows[rows_of_shape::<D>() + i].0[lane];
        let [plastic, jacobian, rate, left, stress, felt] = [0, 1, 2, 3, 4, 5].map(number);
        memory[0] = Memory { plastic, jacobian, rate, left, stress, felt, ..shape(rows, lane) };
    }

    fn viscous(&self, rows: &[Recall], lane: usize) -> f64 {
        rows[rows_of_shape::<D>() + NUMBERS - 1].0[lane]
    }
}

/// The numbers after the shape.
#[inline(always)]
fn numbers<const D: usize>(rows: &mut [Recall]) -> &mut [Recall; NUMBERS] {
    rows[rows_of_shape::<D>()..].first_chunk_mut().expect("what an element remembers is whole")
}

impl<const D: usize> Solid<D> for Flowing {
    type Rest = Gradients<D>;
    const REMEMBERS: bool = true;

    #[inline(always)]
    fn rest<S: Simd>(&self, shape: &Shape<D, f64x8<S>>) -> Gradients<D> {
        Gradients::new(shape)
    }

    #[inline(always)]
    fn volume(&self) -> impl Volume {
        *self
    }

    #[inline(always)]
    fn pull<S: Simd>(
        &self,
        section: Section,
        (batch, rest, kick, memory): Eight<'_, Gradients<D>>,
        (s, u): (&Strains<D, f64x8<S>>, &Slopes<f64x8<S>>),
    ) -> Pull<D, f64x8<S>> {
        let simd = s.inner.simd;
        let (zero, volume) = (f64x8::splat(simd, 0.0), wide(simd, &batch.volume));
        let at = Placed::new(s);
        let (mut own, before) = Memories::load(simd, memory);
        let sound = own.left;
        let (elastic, lost) = returned(self, &at, (kick.elapsed, u.slope), &mut own);
        if let Some(softening) = &self.softening {
            own.left = softening.left(sound, own.plastic, kick.elapsed);
        }
        let stored = (elastic.trace() - 3.0) * (0.5 * self.shear_modulus);
        let nodes = at.at_nodes(rest);
        let spread = nodes.metric.trace();
        let mut viscous = (zero, zero);
        if kick.elapsed > 0.0 {
            let rate = (s.jacobian() - before) / (at.jacobian * kick.elapsed);
            viscous = (rate, resistance(self, nodes.sharpest, rate) * rate);
        }
        let (mu, slope) = (own.left * self.shear_modulus, u.slope + viscous.1);
        let lost = [
            volume * lost * ((sound + own.left) * 0.5),
            volume * viscous.1 * (s.jacobian() - before),
            volume * stored * (sound - own.left),
        ];
        let minors = if matches!(section, Section::Planar { .. }) { 1.0 } else { 2.0 };
        let swollen = (u.curvature * at.jacobian + slope.absolute() * minors) * at.jacobian * spread;
        let sheared = mu * nodes.shear_bound(&elastic);
        let damping = resistance(self, nodes.sharpest, viscous.0 * 2.0) * at.jacobian * spread;
        let stiffness = damped::<D, _>(self.density, (volume, volume * (sheared + swollen)), damping);
        // P = μ J^(−2/3) F C̄_p⁻¹ + (U′ − μ Ī₁/(3J)) ∂J/∂F.
        let pressure = slope - at.upright.choose(mu * elastic.trace() / (at.jacobian * 3.0), zero);
        let pulled = (&at.pulled(&own.shape), own.shape.out);
        let (forces, around) = at.forces(rest, pulled, (-(volume * mu * at.scale), -(volume * pressure)));
        own.store(memory, (s.jacobian(), viscous.1));
        Pull { forces, around, stiffness, energy: volume * stored * own.left, lost }
    }
}

/// b̄ with what is remembered, brought back to the strength if a step has passed and it is beyond; and what was lost, J/m³. `slope`
/// is U′, Pa.
#[inline(always)]
fn returned<const D: usize, V: Number>(
    gel: &Flowing,
    at: &Placed<'_, D, V>,
    (step, slope): (f64, V),
    memory: &mut Memories<D, V>,
) -> (Symmetric<D, V>, V) {
    let trial = at.elastic(&at.pulled(&memory.shape), memory.shape.out);
    let (mu, none) = (gel.shear_modulus, at.jacobian.constant(0.0));
    let Some(strength) = &gel.strength else { return (trial, none) };
    let (deviator, trace) = (trial.deviator(), trial.trace());
    let square = deviator.dot(&deviator);
    let stress = (square * 1.5).root() * mu;
    let before = std::mem::replace(&mut memory.stress, stress);
    memory.felt = strength.felt(memory.felt, slope, step);
    if step <= 0.0 {
        return (trial, none);
    }
    let Returned { stress: left, strain } = strength.returned((stress, trace * mu), memory.felt, (step, memory.rate));
    let flown = at.upright.choose(strain, none);
    if !flown.any_positive() {
        return (trial, none);
    }
    let part = flown.choose(left / stress, none + 1.0);
    let squared = part * part;
    let mean = isochoric(trace * (1.0 / 3.0), (square * squared * 0.5, squared * part * deviator.determinant()));
    let back = deviator.scaled(part, mean);
    memory.shape = at.remembered(&back).chosen(flown, &memory.shape);
    let elastic = back.chosen(flown, &trial);
    memory.plastic = memory.plastic + flown;
    memory.rate = flown.choose(flown * (1.0 / step), memory.rate);
    memory.stress = flown.choose(left, stress);
    let lost = (trace - elastic.trace()) * (0.5 * mu) * (before + left) / (left + stress);
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
    /// And J at the last own tick.
    #[inline(always)]
    fn load(simd: S, from: &mut [Recall]) -> (Self, f64x8<S>) {
        let shape = Symmetric::load(simd, from);
        let [plastic, jacobian, rate, left, stress, felt, _] = numbers::<D>(from);
        let [plastic, rate, left, stress, felt] = [plastic, rate, left, stress, felt].map(|row| wide(simd, &row.0));
        (Self { shape, plastic, rate, left, stress, felt }, wide(simd, &jacobian.0))
    }

    #[inline(always)]
    fn store(&self, to: &mut [Recall], (now, added): (f64x8<S>, f64x8<S>)) {
        self.shape.store(to);
        let [plastic, jacobian, rate, left, stress, felt, viscous] = numbers::<D>(to);
        self.plastic.store_slice(&mut plastic.0);
        now.store_slice(&mut jacobian.0);
        self.rate.store_slice(&mut rate.0);
        self.left.store_slice(&mut left.0);
        self.stress.store_slice(&mut stress.0);
        self.felt.store_slice(&mut felt.0);
        added.store_slice(&mut viscous.0);
    }
}
