//! Balance report: sums of energies and momenta over the state, and the closure of the ledger (method A6).

use super::DiscreteGel;
use super::blocks::ElementBlocks;
use super::stability::stable_steps;
use super::system::DiscreteSystem;
use crate::contact::{BodyState, RigidBody};
use crate::fem::{ElementStates, GroupResponse, Potential};
use crate::ledger::{CompensatedSum, EnergyAccounts, Ledger};
use crate::math::{Vector, Vector3, embed, ordered_sum};
use crate::mesh::{ElementId, NodeId, Simplex};
use crate::state::{DynamicState, GroupClock, Tick};
use std::iter::Sum;

/// Energy sums at one instant, J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergySums {
    /// Σ ½ m v² of the gel, half-step velocities.
    pub gel_kinetic: f64,
    /// Kinetic energy of the bodies.
    pub body_kinetic: f64,
    /// Σ V_K at each patch's own last tick.
    pub elastic: f64,
    /// Σ A + Σ Q, work of the last kicks that belongs to the steps ahead: discrete energy = kinetic − ahead +
    /// elastic.
    pub ahead: f64,
}

impl EnergySums {
    /// Returns the discrete energy E* = T − Σ A − Σ Q + V + T_body, J; with equal steps ½ v⁻·M v⁺ + V, which is
    /// constant for a linear gel.
    #[must_use]
    pub fn discrete(&self) -> f64 {
        self.gel_kinetic - self.ahead + self.elastic + self.body_kinetic
    }
}

/// Balance totals: the energies, the ledger, the initial energy and the closures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BalanceTotals {
    /// Energies now.
    pub energies: EnergySums,
    /// Ledger up to now, with the work of the wrench since the last event.
    pub ledger: Ledger,
    /// Energy at the start, J.
    pub initial_energy: f64,
    /// Energy that has driven the run.
    pub provided: ProvidedEnergy,
    /// Change of the discrete energy that no account explains, J, and relative to the throughput.
    pub energy_imbalance: (f64, f64),
    /// Change of momentum that no account explains, N·s, and relative to the throughput.
    pub momentum_imbalance: (Vector3, f64),
    /// Change of angular momentum about the origin that no account explains, N·m·s, and relative to the throughput.
    pub angular_momentum_imbalance: (Vector3, f64),
    /// Throughput of angular momentum that its closure is relative to, N·m·s.
    pub angular_momentum_scale: f64,
}

/// Energy that has driven a run, in the inertial frame in which the gel was at rest at the start: there it does not
/// count the motion that all have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProvidedEnergy {
    /// Initial energy and external work since, [`EnergyAccounts::scale_of_work`], J.
    pub work: f64,
    /// Jumps made by the importer, J.
    pub importer: f64,
}

impl ProvidedEnergy {
    /// Returns the sum of the magnitudes, an upper bound of the available energy, J.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.work + self.importer.abs()
    }

    /// Transforms start and accounts to a frame of this velocity, m/s: E′ = E − V·P + ½MV².
    fn of(start: &BalanceReference, ledger: &Ledger, velocity: &Vector3) -> Self {
        let (energy, momentum) = (&ledger.energy, &ledger.momentum);
        let moved = |energy: f64, momentum: &CompensatedSum| energy - velocity.dot(&momentum.value());
        let accounts = EnergyAccounts {
            external: moved(energy.external, &momentum.external),
            load: moved(energy.load, &momentum.load),
            air: moved(energy.air, &momentum.air),
            ..EnergyAccounts::default()
        };
        let initial = start.energy - velocity.dot(&start.momentum) + 0.5 * start.mass * velocity.norm_squared();
        Self { work: accounts.scale_of_work(initial), importer: moved(energy.importer, &momentum.importer) }
    }
}

/// Sums the energies of the gel and of the bodies.
fn energy_sums<const D: usize, P>(
    gel: &DiscreteGel<D, P>,
    state: &DynamicState<D>,
    bodies: &[RigidBody],
    at: &[BodyState],
) -> EnergySums {
    let kinetic = |i: usize| 0.5 * gel.mass[i] * state.velocity[i].norm_squared();
    EnergySums {
        gel_kinetic: ordered_sum(state.velocity.len(), 0.0, kinetic),
        body_kinetic: sum_bodies(bodies, at, RigidBody::kinetic_energy),
        elastic: ordered_sum(state.clocks.len(), 0.0, |i| state.clocks[i].energy),
        ahead: ordered_sum(state.clocks.len(), 0.0, |i| state.clocks[i].ahead)
            + ordered_sum(state.excess.len(), 0.0, |i| state.excess[i]),
    }
}

/// Sums a quantity over the bodies with their states.
fn sum_bodies<T: Sum>(bodies: &[RigidBody], at: &[BodyState], value: impl Fn(&RigidBody, &BodyState) -> T) -> T {
    bodies.iter().zip(at).map(|(body, at)| value(body, at)).sum()
}

/// Returns momentum and angular momentum about the origin, in the directions that the dimension conserves.
fn momenta<const D: usize, P>(
    gel: &DiscreteGel<D, P>,
    state: &DynamicState<D>,
    bodies: &[RigidBody],
    at: &[BodyState],
) -> (Vector3, Vector3) {
    let momentum = |i: usize| embed(&state.velocity[i]) * gel.mass[i];
    // x × mv does not change while a node drifts.
    let angular = |i: usize| embed(&state.position[i]).cross(&momentum(i));
    let n = state.velocity.len();
    let linear = ordered_sum(n, Vector3::zeros(), momentum) + sum_bodies(bodies, at, RigidBody::momentum);
    let turning = ordered_sum(n, Vector3::zeros(), angular) + sum_bodies(bodies, at, RigidBody::total_angular_momentum);
    let freedom = bodies[0].freedom;
    (freedom.translation(&linear), freedom.rotation(&turning))
}

/// Throughputs that closures are relative to.
struct BalanceScales {
    energy: f64,
    momentum: f64,
    angular_momentum: f64,
}

/// Initial energy and momentum, the reference of the balances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BalanceReference {
    pub energy: f64,
    pub momentum: Vector3,
    pub angular_momentum: Vector3,
    /// Mass of gel and bodies, kg.
    pub mass: f64,
    /// Σ m|v| and Σ |x × mv|, scales of momentum and angular momentum.
    pub scale: (f64, f64),
}

impl BalanceReference {
    /// Sums the initial energy, momenta and scales of a state.
    pub(super) fn of<const D: usize, P>(
        gel: &DiscreteGel<D, P>,
        bodies: &[RigidBody],
        state: &DynamicState<D>,
    ) -> Self {
        let at = state.bodies.as_slice();
        let (momentum, angular_momentum) = momenta(gel, state, bodies, at);
        let speed = |i: usize| gel.mass[i] * state.velocity[i].norm();
        let turning = |i: usize| gel.mass[i] * embed(&state.position[i]).cross(&embed(&state.velocity[i])).norm();
        let n = state.velocity.len();
        let scale = (
            ordered_sum(n, 0.0, speed) + sum_bodies(bodies, at, |body, at| body.momentum(at).norm()),
            ordered_sum(n, 0.0, turning) + sum_bodies(bodies, at, |body, at| body.total_angular_momentum(at).norm()),
        );
        let mass = ordered_sum(n, 0.0, |i| gel.mass[i]) + sum_bodies(bodies, at, RigidBody::counted_mass);
        Self { energy: energy_sums(gel, state, bodies, at).discrete(), momentum, angular_momentum, mass, scale }
    }
}

/// Returns energies, momenta and closures at time `t`, s.
pub(super) fn totals<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    start: &BalanceReference,
    t: f64,
) -> BalanceTotals {
    let state = &system.state;
    let mut ledger = state.ledger;
    let moved = system.model.bodies.iter().zip(&state.bodies).map(|(body, last)| {
        let now = last.at(body, t);
        last.passage(body, &now).post(&mut ledger);
        now
    });
    let at: Vec<BodyState> = moved.collect();
    let energies = energy_sums(&system.model.gel, state, &system.model.bodies, &at);
    let (momentum, angular) = momenta(&system.model.gel, state, &system.model.bodies, &at);
    let energy = energies.discrete() - start.energy - ledger.energy.total();
    let freedom = system.model.freedom();
    let linear = momentum - start.momentum - freedom.translation(&ledger.momentum.total());
    let turning = angular - start.angular_momentum - freedom.rotation(&ledger.angular_momentum.total());
    let scales = scales(system, &ledger, start);
    BalanceTotals {
        energies,
        ledger,
        initial_energy: start.energy,
        provided: ProvidedEnergy::of(start, &ledger, &system.model.frame.initial_velocity),
        energy_imbalance: (energy, energy.abs() / scales.energy),
        momentum_imbalance: (linear, linear.norm() / scales.momentum),
        angular_momentum_imbalance: (turning, turning.norm() / scales.angular_momentum),
        angular_momentum_scale: scales.angular_momentum,
    }
}

/// Returns the throughputs that closures are relative to: initial amounts, turnover of the accounts, exchange
/// between gel and body.
fn scales<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    ledger: &Ledger,
    start: &BalanceReference,
) -> BalanceScales {
    /// Least scale: products of smaller numbers lose digits, and a closure is then not relative.
    const MIN_SCALE: f64 = f64::MIN_POSITIVE / f64::EPSILON;
    let positive = |scale: f64| if scale > MIN_SCALE { scale } else { 1.0 };
    let passed: f64 = system.state.record.contacts.iter().map(|contact| contact.impulse.norm()).sum();
    let passed = passed + system.state.record.pressed;
    let linear = start.scale.0 + ledger.momentum.turnover() + passed;
    let arm =
        system.model.gel.surface.nodes.iter().map(|s| system.state.position[s.node.index()].norm()).fold(0.0, f64::max);
    let turning = start.scale.1 + ledger.angular_momentum.turnover() + passed * arm;
    BalanceScales {
        energy: positive(start.energy.abs() + ledger.energy.turnover()),
        momentum: positive(linear),
        angular_momentum: positive(turning),
    }
}

/// Returns the present step of each patch, s; before the first tick the stable one.
pub(super) fn steps<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>) -> Vec<f64> {
    if system.state.now.is_none() {
        let rounded =
            |limit: f64| system.model.grid.time(system.model.settings.schedule.step(system.model.grid.ticks(limit)));
        return element_stable_steps(system).into_iter().map(rounded).collect();
    }
    let step =
        |element| system.model.grid.time(system.state.clocks[system.model.layout.group(ElementId(element))].step);
    (0..system.model.gel.potential.len() as u32).map(step).collect()
}

/// Returns the stable step of each element by itself, not rounded to the steps of the schedule, s (method 1.3).
pub(super) fn element_stable_steps<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>) -> Vec<f64> {
    let stiffness = |element| system.state.stiffness[system.model.layout.slot(ElementId(element))];
    let stiffness: Vec<f64> = (0..system.model.gel.potential.len() as u32).map(stiffness).collect();
    stable_steps(&system.model.gel, &stiffness, system.model.settings.cfl)
}

/// Evaluates the elements with the nodes at their positions at time `t`, s.
pub(super) fn measure_at<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, t: f64) -> ElementStates {
    let t = system.time_in_gel(t);
    let x: Vec<Vector<D>> = (0..system.model.gel.mass.len() as u32).map(|a| system.position_at(NodeId(a), t)).collect();
    system.model.gel.measure(&x, &system.state.memory)
}

/// Returns the bytes that a gel of this size takes in the engine: elements, nodes, state and derived data.
pub(super) fn bytes<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>) -> usize {
    let (nodes, state) = (system.model.gel.mass.len(), &system.state);
    let fields = size_of::<Vector<D>>() * 4 + size_of::<f64>() * 3 + size_of::<Tick>() + 2;
    let groups = size_of::<GroupClock>() + size_of::<GroupResponse>();
    let blocks = system.blocks.as_ref().map_or(0, ElementBlocks::bytes);
    let elements = size_of::<Simplex>() + size_of::<ElementId>() * (D + 1) + size_of::<f64>();
    nodes * fields
        + state.clocks.len() * groups
        + system.model.layout.bytes()
        + blocks
        + system.model.gel.potential.len() * elements
}

/// Returns the number of element updates that one global stable step would have cost up to a time in ticks, from its
/// reference in the record and the number of elements.
pub(super) fn synchronous_until(reference: (f64, Tick, f64), ticks: f64, n_elements: usize) -> f64 {
    let (length, counted, updates) = reference;
    updates + (ticks - counted as f64).max(0.0) / length * n_elements as f64
}
