//! Viscoplastic elements in vector lanes; the scalar form is [`crate::fem::scalar::viscoplastic`].

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::element_law::{ElementDeformation, ElementForces, ElementLaw, LawInput, VolumetricSlopes};
use super::kinematics::ShapeGradients;
use super::rest_geometry::RestGeometry;
use crate::constitutive::{IsochoricDeformation, StressReturn, Viscoplastic, VolumetricEnergy};
use crate::fem::history::{
    HistoryLanes, HistoryLayout, load_shape, load_tensor, shape_rows, store_shape, store_tensor,
};
use crate::fem::{HistoryVariables, Section};
use crate::math::{Number, SymmetricTensor, isochoric_mean};
use std::fmt::Debug;

/// History variables of eight elements during an evaluation.
#[derive(Clone, Copy)]
struct PlasticHistory<const D: usize, V> {
    shape: SymmetricTensor<D, V>,
    plastic: V,
    rate: V,
    left: V,
    stress: V,
    felt: V,
}

/// History rows after C̄_p⁻¹: ε_p, J, the rate of ε_p, the damage factor, q, the filtered U′, and the viscous part of
/// U′, Pa.
///
/// The last one serves only re-evaluations at the same tick.
const NUMBERS: usize = 7;

impl<const D: usize> HistoryLayout<D> for Viscoplastic {
    fn rows(&self) -> usize {
        shape_rows::<D>() + NUMBERS
    }

    fn store_history(&self, rows: &mut [f64], memory: &[HistoryVariables<D>]) {
        let HistoryVariables { plastic, jacobian, rate, left, stress, felt, .. } = memory[0];
        store_shape(rows, &memory[0]);
        rows[shape_rows::<D>()..][..6].copy_from_slice(&[plastic, jacobian, rate, left, stress, felt]);
    }

    fn load_history(&self, rows: &[f64], memory: &mut [HistoryVariables<D>]) {
        let number = |i: usize| rows[shape_rows::<D>() + i];
        let [plastic, jacobian, rate, left, stress, felt] = [0, 1, 2, 3, 4, 5].map(number);
        memory[0] = HistoryVariables { plastic, jacobian, rate, left, stress, felt, ..load_shape(rows) };
    }

    fn viscous(&self, rows: &[f64]) -> f64 {
        rows[shape_rows::<D>() + NUMBERS - 1]
    }
}

/// Returns the history rows after C̄_p⁻¹.
#[inline(always)]
fn numbers<const D: usize, L>(rows: &mut [HistoryLanes<L>]) -> &mut [HistoryLanes<L>; NUMBERS] {
    rows[shape_rows::<D>()..].first_chunk_mut().expect("what an element remembers is whole")
}

impl<const D: usize> ElementLaw<D> for Viscoplastic {
    type Rest<L: Copy + Default + Debug> = ShapeGradients<D, L>;
    const HAS_HISTORY: bool = true;

    #[inline(always)]
    fn rest<V: Number>(&self, shape: &RestGeometry<D, V>) -> ShapeGradients<D, V::Lanes> {
        ShapeGradients::new(shape)
    }

    #[inline(always)]
    fn volume(&self) -> impl VolumetricEnergy {
        *self
    }

    #[inline(always)]
    fn evaluate<V: Number>(
        &self,
        section: Section,
        input: LawInput<'_, V, ShapeGradients<D, V::Lanes>>,
        s: &ElementDeformation<D, V>,
        u: &VolumetricSlopes<V>,
    ) -> ElementForces<D, V> {
        let LawInput { volume, rest, elapsed, history: memory, .. } = input;
        let (zero, at) = (volume.constant(0.0), s.isochoric());
        let (mut own, before) = PlasticHistory::load(zero, memory);
        let sound = own.left;
        let (elastic, lost) = returned(self, &at, (elapsed, u.slope), &mut own);
        if let Some(softening) = &self.softening {
            own.left = softening.after_step(sound, own.plastic, elapsed);
        }
        let stored = (elastic.trace() - 3.0) * (0.5 * self.shear_modulus);
        let nodes = rest.spatial_sums(&at, s.hoop);
        let spread = nodes.metric.trace();
        let mut viscous = (zero, zero);
        if elapsed > 0.0 {
            let rate = (s.jacobian() - before) / (at.jacobian * elapsed);
            viscous = (rate, resistance(self, nodes.max_squared, rate) * rate);
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
        let damping = resistance(self, nodes.max_squared, viscous.0 * 2.0) * at.jacobian * spread;
        let stiffness = damped::<D, _>(self.density, (volume, volume * (sheared + swollen)), damping);
        // P = μ J^(−2/3) F C̄_p⁻¹ + (U′ − μ Ī₁/(3J)) ∂J/∂F.
        let pressure = slope - at.above_floor.choose(mu * elastic.trace() / (at.jacobian * 3.0), zero);
        let pulled = at.times_inverse_shape(&own.shape);
        let (forces, hoop_force) =
            s.nodal_forces(rest, &at.cofactor, &pulled, own.shape.out, -(volume * mu * at.scale), -(volume * pressure));
        own.store(memory, (s.jacobian(), viscous.1));
        ElementForces { forces, hoop_force, stiffness, energy: volume * stored * own.left, lost }
    }
}

/// Radial return mapping of b̄ after a step, s; returns b̄ and the dissipation, J/m³; `slope` is U′, Pa.
#[inline(always)]
fn returned<const D: usize, V: Number>(
    gel: &Viscoplastic,
    at: &IsochoricDeformation<D, V>,
    (step, slope): (f64, V),
    memory: &mut PlasticHistory<D, V>,
) -> (SymmetricTensor<D, V>, V) {
    let trial = at.elastic(&at.times_inverse_shape(&memory.shape), memory.shape.out);
    let (mu, none) = (gel.shear_modulus, at.jacobian.constant(0.0));
    let Some(strength) = &gel.strength else { return (trial, none) };
    let (deviator, trace) = (trial.deviator(), trial.trace());
    let square = deviator.dot(&deviator);
    let stress = (square * 1.5).root() * mu;
    let before = std::mem::replace(&mut memory.stress, stress);
    memory.felt = strength.filtered_slope(memory.felt, slope, step);
    if step <= 0.0 {
        return (trial, none);
    }
    let StressReturn { stress: left, strain } =
        strength.return_stress(stress, trace * mu, memory.felt, step, memory.rate);
    let flown = at.above_floor.choose(strain, none);
    if !flown.any_positive() {
        return (trial, none);
    }
    let part = flown.choose(left / stress, none + 1.0);
    let squared = part * part;
    let mean = isochoric_mean(trace * (1.0 / 3.0), square * squared * 0.5, squared * part * deviator.determinant());
    let back = deviator.scaled(part, mean);
    memory.shape = at.pull_back(&back).where_positive(flown, &memory.shape);
    let elastic = back.where_positive(flown, &trial);
    memory.plastic = memory.plastic + flown;
    memory.rate = flown.choose(flown * (1.0 / step), memory.rate);
    memory.stress = flown.choose(left, stress);
    let lost = (trace - elastic.trace()) * (0.5 * mu) * (before + left) / (left + stress);
    (elastic, flown.choose(lost, none))
}

/// Returns η, Pa·s, for the least height, the inverse root of the greatest |g_a|².
#[inline(always)]
fn resistance<V: Number>(gel: &Viscoplastic, sharpest: V, rate: V) -> V {
    // An empty lane has no gradients.
    let height = sharpest.constant(1.0) / sharpest.at_least(f64::MIN_POSITIVE).root();
    gel.viscosity.at(gel.density, gel.sound_speed(), height, rate)
}

/// Returns the undamped stiffness with the stable step of κ and the viscous c = w η J Σ|b|².
#[inline(always)]
fn damped<const D: usize, V: Number>(density: f64, (volume, kappa): (V, V), damping: V) -> V {
    let mass = (volume * (density / (D + 1) as f64)).at_least(f64::MIN_POSITIVE);
    let s = volume * damping * 0.5 / mass.root();
    let root = (kappa + s * s).root() + s;
    root * root
}

impl<const D: usize, V: Number> PlasticHistory<D, V> {
    /// Loads the history variables, and J at the last tick.
    #[inline(always)]
    fn load(zero: V, from: &mut [HistoryLanes<V::Lanes>]) -> (Self, V) {
        let shape = load_tensor(zero, from);
        let [plastic, jacobian, rate, left, stress, felt, _] = numbers::<D, _>(from);
        let [plastic, rate, left, stress, felt] = [plastic, rate, left, stress, felt].map(|row| zero.load(&row.0));
        (Self { shape, plastic, rate, left, stress, felt }, zero.load(&jacobian.0))
    }

    #[inline(always)]
    fn store(&self, to: &mut [HistoryLanes<V::Lanes>], (now, added): (V, V)) {
        store_tensor(&self.shape, to);
        let [plastic, jacobian, rate, left, stress, felt, viscous] = numbers::<D, _>(to);
        plastic.0 = self.plastic.store();
        jacobian.0 = now.store();
        rate.0 = self.rate.store();
        left.0 = self.left.store();
        stress.0 = self.stress.store();
        felt.0 = self.felt.store();
        viscous.0 = added.store();
    }
}
