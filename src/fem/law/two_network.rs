//! Two-network elements: an elastic network, viscous branches, an equation of state and bulk viscosity (method 6.2).

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::element_law::{
    ElementDeformation, ElementForces, ElementLaw, LaneRatios, LawInput, RestOperator, VolumetricSlopes,
};
use super::kinematics::{GradientSums, ShapeGradients};
use super::rest_geometry::RestGeometry;
use crate::constitutive::{
    Branch, Dashpot, IsochoricDeformation, IsochoricShape, PowerLaw, TwoNetwork, VolumetricEnergy,
};
use crate::fem::history::{
    HistoryLanes, HistoryLayout, load_shape, load_tensor, shape_rows, store_shape, store_tensor,
};
use crate::fem::{HistoryVariables, Section};
use crate::math::{Number, SymmetricTensor, isochoric_mean};
use std::fmt::Debug;

/// History rows before the tensors: J at the last tick, the viscous part of U′, Pa, and the damage d.
///
/// The second one serves only re-evaluations at the same tick. Then follow A of the elastic network, if there is one;
/// C̄⁻¹ at the last tick, if a dashpot is linear; and C̄_i⁻¹ of each branch, of a power law with q at the last tick.
const NUMBERS: usize = 3;
/// Row of the viscous part of U′.
const VISCOUS: usize = 1;

impl TwoNetwork {
    /// Returns true if the gel has an elastic network.
    fn is_elastic(&self) -> bool {
        self.shear_modulus() > 0.0
    }

    /// Returns true if a dashpot is linear.
    fn is_linear(&self) -> bool {
        self.branches().iter().any(|branch| matches!(branch.dashpot(), Dashpot::Linear(_)))
    }

    /// Returns the number of history records: that of the element, C̄⁻¹ at the last tick if a dashpot is linear, and
    /// those of the branches.
    pub(crate) fn records(&self) -> usize {
        self.first_branch() + self.branches().len()
    }

    /// Returns the record of the first branch.
    pub(crate) fn first_branch(&self) -> usize {
        1 + usize::from(self.is_linear())
    }
}

impl Branch {
    /// Returns the number of history rows after those of C̄_i⁻¹.
    fn numbers(&self) -> usize {
        usize::from(matches!(self.dashpot(), Dashpot::PowerLaw(_)))
    }
}

impl<const D: usize> HistoryLayout<D> for TwoNetwork {
    fn rows(&self) -> usize {
        let tensors = usize::from(self.is_elastic()) + usize::from(self.is_linear()) + self.branches().len();
        NUMBERS + tensors * shape_rows::<D>() + self.branches().iter().map(Branch::numbers).sum::<usize>()
    }

    fn store_history(&self, rows: &mut [f64], memory: &[HistoryVariables<D>]) {
        let (numbers, mut rest) = rows.split_at_mut(NUMBERS);
        (numbers[0], numbers[2]) = (memory[0].jacobian, memory[0].damage);
        let stored = usize::from(!self.is_elastic())..self.first_branch();
        for record in &memory[stored] {
            store_shape(rest, record);
            rest = &mut rest[shape_rows::<D>()..];
        }
        for (branch, record) in self.branches().iter().zip(&memory[self.first_branch()..]) {
            store_shape(rest, record);
            rest = &mut rest[shape_rows::<D>()..];
            if branch.numbers() > 0 {
                rest[0] = record.stress;
                rest = &mut rest[1..];
            }
        }
    }

    fn load_history(&self, rows: &[f64], memory: &mut [HistoryVariables<D>]) {
        let (numbers, mut rest) = rows.split_at(NUMBERS);
        let stored = usize::from(!self.is_elastic())..self.first_branch();
        memory[0] = HistoryVariables::default();
        for record in &mut memory[stored] {
            *record = load_shape(rest);
            rest = &rest[shape_rows::<D>()..];
        }
        (memory[0].jacobian, memory[0].damage) = (numbers[0], numbers[2]);
        for (branch, record) in self.branches().iter().zip(&mut memory[self.first_branch()..]) {
            *record = load_shape(rest);
            rest = &rest[shape_rows::<D>()..];
            if branch.numbers() > 0 {
                record.stress = rest[0];
                rest = &rest[1..];
            }
        }
    }

    fn viscous(&self, rows: &[f64]) -> f64 {
        rows[VISCOUS]
    }

    fn hold_viscous(&self, rows: &mut [f64], viscous: f64) {
        rows[VISCOUS] = viscous;
    }
}

/// Rest data of two-network elements.
#[derive(Debug, Clone, Default)]
pub(crate) struct NetworkRest<const D: usize, L: Copy + Default = [f64; 8]> {
    gradients: ShapeGradients<D, L>,
    /// Density relative to that of the gel, over the relative strength: forces and stiffness are scaled by the strength
    /// afterwards, the viscous ones with them.
    density: L,
    /// Speed of sound relative to that of the gel, the root of the relative bulk modulus over the relative density.
    sound_speed: L,
}

impl<const D: usize, L: Copy + Default + Debug> RestOperator<D, L> for NetworkRest<D, L> {
    #[inline(always)]
    fn deform<V: Number<Lanes = L>>(&self, strained: V, scale: V, f: &mut [[V; D]; D]) -> V {
        self.gradients.deform(strained, scale, f)
    }
}

/// Deformation of an element, with the nodal sums of its gradients.
struct NetworkKinematics<const D: usize, V> {
    at: IsochoricDeformation<D, V>,
    /// Sums of the spatial gradients.
    nodes: GradientSums<D, V>,
    /// Sums of the material gradients; used below the floor of J only.
    still: GradientSums<D, V>,
    /// True if an element is below the floor of J.
    is_crushed: bool,
    /// Density at rest over the relative strength, kg/m³.
    density: V,
    /// Speed of sound at this density, m/s.
    sound_speed: V,
}

/// Sums over the networks: P = J^(−2/3) F M + p ∂J/∂F, M = Σ μ_k C_k, p = U′ − Σ μ_k tr b̄_k/(3J).
struct NetworkForces<const D: usize, V> {
    /// Rows of F M, Pa.
    pulled: [[V; D]; D],
    /// Out-of-plane component of M, Pa.
    out: V,
    /// Σ μ_k tr b̄_k, Pa.
    trace: V,
    /// Stored energy, J/m³.
    stored: V,
    /// Curvature of the stored energy, N/m⁴.
    curvature: V,
}

impl<const D: usize> ElementLaw<D> for TwoNetwork {
    type Rest<L: Copy + Default + Debug> = NetworkRest<D, L>;
    const HAS_HISTORY: bool = true;

    #[inline(always)]
    fn rest<V: Number>(&self, shape: &RestGeometry<D, V>) -> NetworkRest<D, V::Lanes> {
        let sound_speed = shape.bulk.root() / shape.density.root();
        NetworkRest {
            gradients: ShapeGradients::new(shape),
            density: (shape.density / shape.strength).store(),
            sound_speed: sound_speed.store(),
        }
    }

    #[inline(always)]
    fn volume(&self) -> impl VolumetricEnergy {
        *self
    }

    #[inline(always)]
    fn stabilisation<V: Number>(&self, ratios: &LaneRatios<V>) -> Option<V> {
        Some(self.relative_stabilisation(ratios.strength, ratios.bulk))
    }

    #[inline(always)]
    fn evaluate<V: Number>(
        &self,
        section: Section,
        input: LawInput<'_, V, NetworkRest<D, V::Lanes>>,
        s: &ElementDeformation<D, V>,
        u: &VolumetricSlopes<V>,
    ) -> ElementForces<D, V> {
        let LawInput { volume, rest: NetworkRest { gradients: rest, density, sound_speed }, kick, history, .. } = input;
        let elapsed = kick.elapsed;
        let (at, zero) = (s.isochoric(), volume.constant(0.0));
        let density = zero.load(density) * self.density();
        let sound_speed = zero.load(sound_speed) * self.sound_speed();
        let (nodes, is_crushed) = (rest.spatial_sums(&at, s.hoop), (-at.above_floor).any_positive());
        let still = if is_crushed { rest.sums(s.hoop) } else { nodes };
        let kinematics = NetworkKinematics { at, nodes, still, is_crushed, density, sound_speed };
        let (numbers, mut rows) = history.split_first_chunk_mut::<NUMBERS>().expect("the history of an element");
        let mut sum = NetworkForces::none(zero);
        let mut released = zero;
        if self.is_elastic() {
            let (own, others) = rows.split_at_mut(shape_rows::<D>());
            let (own, damage) = (load_tensor(zero, own), zero.load(&numbers[2].0));
            let after = sum.add_elastic(self, &kinematics, &own, damage, elapsed);
            numbers[2].0 = after.0.store();
            (released, rows) = (after.1, others);
        }
        let before = zero.load(&numbers[0].0);
        let lost = sum.add_branches(self, &kinematics, before, elapsed, rows);
        let (rate, viscous) =
            self.bulk_viscous(&kinematics, s.jacobian() - before, elapsed, zero.load(&numbers[VISCOUS].0));
        numbers[VISCOUS].0 = viscous.store();
        numbers[0].0 = s.jacobian().store();
        let slope = u.slope + viscous;
        let (at, nodes) = (&kinematics.at, &kinematics.nodes);
        let dilated = dilated(s, at, nodes);
        let swollen = u.curvature * dilated + slope.absolute() * kinematics.minor_curvature(section, s);
        let damping = self.resistance(&kinematics, rate * 2.0) * dilated / at.jacobian;
        let stiffness = damped::<D, _>(density, volume, volume * (sum.curvature + swollen), damping);
        let pushing = if kick.takes_back() { u.slope } else { slope };
        let pressure = pushing - at.above_floor.choose(sum.trace / (at.jacobian * 3.0), zero);
        let shape = -(volume * at.scale);
        let (forces, hoop_force) =
            s.nodal_forces(rest, &at.cofactor, &sum.pulled, sum.out, shape, -(volume * pressure));
        let bulk = viscous * (s.jacobian() - before);
        let lost = [volume * lost, volume * bulk, volume * released];
        ElementForces { forces, hoop_force, stiffness, energy: volume * sum.stored, lost }
    }
}

impl<const D: usize, V: Number> NetworkKinematics<D, V> {
    /// Returns a bound of the second derivative of J by the nodal positions, 1/m².
    ///
    /// δ²J = J [(tr L)² − tr(LL)] with L = δF F⁻¹, the bracket at most s |L|² with s = 1 in the plane, else 2.
    #[inline(always)]
    fn minor_curvature(&self, section: Section, s: &ElementDeformation<D, V>) -> V {
        let minors = if matches!(section, Section::Planar { .. }) { 1.0 } else { 2.0 };
        let bound = self.nodes.metric.trace() * self.at.jacobian * minors;
        if !self.is_crushed {
            return bound;
        }
        self.at.above_floor.choose(bound, s.minor_bound(section) * self.still.metric.trace())
    }
}

impl TwoNetwork {
    /// Returns ε̇ = J̇/J and the viscous part η ε̇ of U′, Pa, after the change `grown` of J in `elapsed` s; at the same
    /// tick `held`, Pa.
    #[inline(always)]
    fn bulk_viscous<const D: usize, V: Number>(
        &self,
        kinematics: &NetworkKinematics<D, V>,
        grown: V,
        elapsed: f64,
        held: V,
    ) -> (V, V) {
        if elapsed <= 0.0 {
            return (held.constant(0.0), held);
        }
        let rate = grown / (kinematics.at.jacobian * elapsed);
        (rate, self.resistance(kinematics, rate) * rate)
    }

    /// Returns η, Pa·s, for the density ρ₀/J and the least height, the inverse root of the greatest |g_a|².
    #[inline(always)]
    fn resistance<const D: usize, V: Number>(&self, kinematics: &NetworkKinematics<D, V>, rate: V) -> V {
        // An empty lane has no gradients.
        let height = rate.constant(1.0) / kinematics.nodes.max_squared.at_least(f64::MIN_POSITIVE).root();
        // With ρ₀ a torn web of 3 kg/m³ was damped 370 times too much, beyond what its step allowed.
        let density = kinematics.density / kinematics.at.jacobian;
        self.viscosity().at(density, kinematics.sound_speed, height, rate)
    }
}

impl<const D: usize, V: Number> NetworkForces<D, V> {
    #[inline(always)]
    fn none(zero: V) -> Self {
        Self { pulled: [[zero; D]; D], out: zero, trace: zero, stored: zero, curvature: zero }
    }

    /// Adds a network of modulus `modulus`, Pa, with C = `own` and b̄ = `elastic`.
    ///
    /// Below the floor J^(−2/3) is constant and the energy quadratic.
    #[inline(always)]
    fn add(
        &mut self,
        kinematics: &NetworkKinematics<D, V>,
        modulus: V,
        own: &SymmetricTensor<D, V>,
        pulled: &[[V; D]; D],
        elastic: &SymmetricTensor<D, V>,
    ) {
        let NetworkKinematics { at, nodes, still, is_crushed, .. } = kinematics;
        for i in 0..D {
            for j in 0..D {
                self.pulled[i][j] = pulled[i][j].multiply_add(modulus, self.pulled[i][j]);
            }
        }
        let trace = elastic.trace();
        self.out = own.out.multiply_add(modulus, self.out);
        self.trace = trace.multiply_add(modulus, self.trace);
        self.stored = ((trace - 3.0) * 0.5).multiply_add(modulus, self.stored);
        let mut curvature = nodes.shear_bound(elastic);
        if *is_crushed {
            curvature = at.above_floor.choose(curvature, own.dot(&still.metric) * at.scale);
        }
        self.curvature = curvature.multiply_add(modulus, self.curvature);
    }

    /// Adds the elastic network with A = `own`; returns its damage after the step, and the energy released by it,
    /// J/m³.
    #[inline(always)]
    fn add_elastic(
        &mut self,
        gel: &TwoNetwork,
        kinematics: &NetworkKinematics<D, V>,
        own: &SymmetricTensor<D, V>,
        damage: V,
        elapsed: f64,
    ) -> (V, V) {
        let at = &kinematics.at;
        let pulled = at.times_inverse_shape(own);
        let elastic = at.elastic(&pulled, own.out);
        let mut after = damage;
        if let Some(law) = gel.damage().filter(|_| elapsed > 0.0) {
            let critical = law.critical_stretch();
            // What is broken does not break again; its stretch is not asked for.
            let unbroken = -(damage - 1.0);
            let excess = elastic.eigenvalue_bound() - critical * critical;
            let above = unbroken.choose(excess, damage.constant(0.0));
            if above.any_positive() {
                let stretch = elastic.greatest_eigenvalue().root();
                after = at.above_floor.choose(above.choose(law.after_step(damage, stretch, elapsed), damage), damage);
            }
        }
        let modulus = (-(after - 1.0)) * gel.shear_modulus();
        self.add(kinematics, modulus, own, &pulled, &elastic);
        (after, (after - damage) * (elastic.trace() - 3.0) * (0.5 * gel.shear_modulus()))
    }

    /// Adds the branches after their flow in `elapsed` s, and updates their rows; `jacobian` is J at the last tick.
    /// Returns the dissipation of the dashpots, J/m³.
    #[inline(always)]
    fn add_branches(
        &mut self,
        gel: &TwoNetwork,
        kinematics: &NetworkKinematics<D, V>,
        jacobian: V,
        elapsed: f64,
        mut rows: &mut [HistoryLanes<V::Lanes>],
    ) -> V {
        let (at, mut lost) = (&kinematics.at, jacobian.constant(0.0));
        if gel.branches().is_empty() {
            return lost;
        }
        let now = IsochoricShape::now(at);
        let mut before = now;
        if gel.is_linear() {
            let (last, others) = rows.split_at_mut(shape_rows::<D>());
            before = IsochoricShape::before(load_tensor(lost, last), jacobian);
            store_tensor(&now.inverse.where_positive(now.above_floor, &before.inverse), last);
            rows = others;
        }
        for branch in gel.branches() {
            let (own_rows, others) = rows.split_at_mut(shape_rows::<D>() + branch.numbers());
            let mut own = load_tensor(lost, own_rows);
            let modulus = branch.shear_modulus();
            let fall = match branch.dashpot() {
                Dashpot::Linear(_) if elapsed <= 0.0 => lost.constant(0.0),
                Dashpot::Linear(dashpot) => dashpot.relax(&mut own, [&before, &now], elapsed),
                Dashpot::PowerLaw(law) => {
                    let stress = &mut own_rows[shape_rows::<D>()];
                    let last = lost.load(&stress.0);
                    let flow = flow(law, modulus, at, &now, &mut own, last, elapsed);
                    stress.0 = flow.0.store();
                    flow.1
                }
            };
            lost = lost + fall * (0.5 * modulus);
            store_tensor(&own, own_rows);
            let pulled = at.times_inverse_shape(&own);
            let elastic = at.elastic(&pulled, own.out);
            self.add(kinematics, lost.constant(modulus), &own, &pulled, &elastic);
            rows = others;
        }
        lost
    }
}

/// Lets the dashpot of a power law flow for `elapsed` s: radial return of dev b̄_i to its part s (Simo and Hughes 1998).
///
/// b̄_i = θ + d becomes θ′ + s d of determinant 1, hence C̄_i⁻¹ becomes s C̄_i⁻¹ + (θ′ − sθ) C̄⁻¹. Returns q, Pa, and the
/// fall of tr b̄_i that is dissipated: the flow works at the mean of the last and the present stress, the one that acts
/// on the nodes in between. `last` is q at the last tick, Pa.
#[inline(always)]
fn flow<const D: usize, V: Number>(
    law: &PowerLaw,
    modulus: f64,
    at: &IsochoricDeformation<D, V>,
    now: &IsochoricShape<D, V>,
    own: &mut SymmetricTensor<D, V>,
    last: V,
    elapsed: f64,
) -> (V, V) {
    let trial = at.elastic(&at.times_inverse_shape(own), own.out);
    let (deviator, trace) = (trial.deviator(), trial.trace());
    let (square, zero) = (deviator.dot(&deviator), last.constant(0.0));
    let stress = (square * 1.5).root() * modulus;
    if elapsed <= 0.0 {
        return (stress, zero);
    }
    let one = zero + 1.0;
    let part = now.above_floor.choose(law.part_left(stress, trace * modulus, elapsed), one);
    let flows = one - part;
    if !flows.any_positive() {
        return (stress, zero);
    }
    let (squared, mean) = (part * part, trace * (1.0 / 3.0));
    let after = isochoric_mean(mean, square * squared * 0.5, squared * part * deviator.determinant());
    let returned = own.combined(part, &now.inverse, after - mean * part);
    *own = returned.where_positive(flows, own);
    let left = stress * part;
    // The difference of two means near 1 is round-off where the deviator is small; over a stress near 0 it was any energy.
    let small = square * (one - squared) * 0.5;
    let fall = (square - SMALL * SMALL).choose((mean - after) * 3.0, small);
    (left, flows.choose(fall * (last + left) / (stress + left), zero))
}

/// |dev b̄|, below which the fall of tr b̄ is that of small strains, |dev b̄|² (1 − s²)/2: relative errors of both are near 1e-5.
const SMALL: f64 = 1e-5;

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

/// Returns the undamped stiffness with the stable step of κ with viscosity, N/m.
///
/// The viscous forces are −C v with |C| ≤ c = w `damping`, `damping` being twice η Σ|∂J/∂x_a|²/J for the quadratic
/// part. With the velocity of half a step before, a node of mass m is stable up to (2/ω)(√(1 + ξ²) − ξ), ω² = κ/m,
/// ξ = c/(2mω) (method 1.3g). This limit is 2√m/(√(κ + s²) + s) with s = c/(2√m).
#[inline(always)]
fn damped<const D: usize, V: Number>(density: V, volume: V, kappa: V, damping: V) -> V {
    let mass = (volume * (density / density.constant((D + 1) as f64))).at_least(f64::MIN_POSITIVE);
    let s = volume * damping * 0.5 / mass.root();
    let root = (kappa + s * s).root() + s;
    root * root
}

#[cfg(test)]
mod tests;
