//! Gel of the reduced model in time: impulses on one body at ticks of its own, and the rings that its nose leaves.
//!
//! At a tick the body gets the impulse of the [penetration law](super::PenetrationLaw) over half of the step before and
//! half of the step ahead, with the force linear in the speed (Rosenbrock's midpoint rule). A step is an eighth of a
//! calibre of path. Ticks follow from the state alone, so that communication points leave no trace.

use super::penetration::{NoseMotion, Resistance};
use super::rings::{RingEnergy, RingStart};
use super::{IdentifiedClass, ReducedState};
use crate::contact::{BodyMotion, BodyState, ImpulseExchange, RigidBody};
use crate::integrator::{
    BalanceTotals, BlockMotion, BodyExit, EnergySums, ExitRule, GelFrame, ProvidedEnergy, rebase_body,
};
use crate::math::{Vector3, ordered_sum};
use crate::state::Tick;
use std::f64::consts::PI;

/// Length of a tick, s: 2⁻³⁰, so that all times are exact.
const TICK: f64 = 1.0 / (1u64 << 30) as f64;
/// Fraction of a tick by which a communication point may miss a tick and still include it, as in the full model.
const TICK_TOLERANCE: f64 = 1e-3;
/// Steps in a calibre of path.
const STEPS_PER_CALIBRE: f64 = 8.0;
/// Longest step, ticks: 15 µs, a thousandth of the swing of the spring.
const LONGEST: Tick = 1 << 14;
/// Rings in a calibre of path, and in the thickness of a gel at most.
const RINGS_PER_CALIBRE: f64 = 4.0;
const MOST_RINGS: f64 = 400.0;

/// Block of gel of the reduced model: a cylinder about the axis of the shot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetBlock {
    /// Radius, m.
    pub radius: f64,
    /// Thickness along the shot, m.
    pub thickness: f64,
    /// Density, kg/m³.
    pub density: f64,
    /// Frame of the block.
    pub frame: GelFrame,
    /// Exit rule; absent for a block that moves against its supports.
    pub exits: Option<ExitRule>,
    /// Window of the peak force, s.
    pub force_window: f64,
}

/// Energy and momentum at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
struct StartBalance {
    energy: f64,
    momentum: f64,
    mass: f64,
    scale: f64,
}

/// Gel of the reduced model, and the body that meets it.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedTarget {
    /// Body.
    pub body: RigidBody,
    /// Block.
    pub block: TargetBlock,
    /// Identified coefficients.
    class: IdentifiedClass,
    /// Calibre of the body, m.
    diameter: f64,
    start: StartBalance,
    state: ReducedState,
}

impl ReducedTarget {
    /// Creates the gel at time 0.
    #[must_use]
    pub fn new(block: TargetBlock, class: IdentifiedClass, body: RigidBody, at: BodyState) -> Self {
        let diameter = 2.0 * body.reach(&at, &Vector3::x());
        let mut target = Self {
            body,
            block,
            class,
            diameter,
            start: StartBalance { energy: 0.0, momentum: 0.0, mass: 0.0, scale: 0.0 },
            state: ReducedState::at_start(at),
        };
        let (gel, rigid) = (target.gel_mass() * block.frame.initial_velocity.z, target.body.momentum(&at).z);
        target.start = StartBalance {
            energy: target.block_energy() + target.body.kinetic_energy(&at),
            momentum: gel + rigid,
            mass: target.gel_mass() + target.body.counted_mass(&at),
            scale: gel.abs() + rigid.abs(),
        };
        target
    }

    /// Returns the dynamic state.
    #[must_use]
    pub fn state(&self) -> &ReducedState {
        &self.state
    }

    /// Returns the dynamic state, for changes between steps.
    pub fn state_mut(&mut self) -> &mut ReducedState {
        &mut self.state
    }

    /// Returns the mass of the gel, kg.
    #[must_use]
    pub fn gel_mass(&self) -> f64 {
        PI * self.block.radius * self.block.radius * self.block.thickness * self.block.density
    }

    /// Returns the time of a tick, s.
    #[must_use]
    pub fn time_of(tick: Tick) -> f64 {
        tick.cast_signed() as f64 * TICK
    }

    /// Returns the distance between rings, m.
    #[must_use]
    pub fn ring_spacing(&self) -> f64 {
        (self.diameter / RINGS_PER_CALIBRE).max(self.block.thickness / MOST_RINGS)
    }

    /// Returns the greatest number of rings.
    #[must_use]
    pub fn most_rings(&self) -> usize {
        (self.block.thickness / self.ring_spacing()) as usize
    }

    /// Continues from another state.
    ///
    /// # Errors
    /// The contradiction found; nothing is changed then.
    pub fn restore(&mut self, state: &ReducedState) -> Result<(), &'static str> {
        state.check_invariants(self.most_rings())?;
        if !state.bodies.iter().all(|at| self.body.is_admissible(at)) {
            return Err("a body is off its axis");
        }
        self.state.clone_from(state);
        Ok(())
    }

    /// Replaces the state of the body between ticks; a body that is faster now has its next tick earlier.
    pub fn set_body(&mut self, at: &BodyState) {
        self.state.bodies[0] = *at;
        let first = (at.time / TICK).floor().max(0.0) as Tick;
        self.state.next = self.state.next.min((first + self.step(at)).max(self.state.now.map_or(0, |now| now + 1)));
    }

    /// Advances to time `until`, s, within a communication step that ends at `end`, s.
    pub fn advance(&mut self, until: f64, end: f64, exchange: &mut ImpulseExchange) {
        let last = (until / TICK + TICK_TOLERANCE).floor().max(0.0) as Tick;
        while self.state.next <= last && !self.state.record.at_rest {
            self.process_tick(end, exchange);
        }
    }

    /// Returns the motion of the block at a time, s.
    #[must_use]
    pub fn block_motion(&self, time: f64) -> BlockMotion {
        self.block.frame.motion(&self.state.record.outside, time)
    }

    /// Returns the exit of the body at a state.
    #[must_use]
    pub fn exit<'a>(&'a self, at: &'a BodyState) -> BodyExit<'a> {
        let record = &self.state.record;
        let (outside, contact) = (&record.outside, &record.contacts[0]);
        BodyExit { rigid: &self.body, at, frame: &self.block.frame, outside, contact }
    }

    /// Returns the step ahead of a state of the body, ticks.
    fn step(&self, at: &BodyState) -> Tick {
        let seen = self.block_motion(at.time).seen_from(at);
        let (depth, speed) = (self.body.depth(&seen), -seen.velocity.z);
        let path = if depth < 0.0 && speed > 0.0 { -depth } else { self.diameter / STEPS_PER_CALIBRE };
        let ticks = path / (speed.abs() * TICK);
        (ticks.min(LONGEST as f64).ceil() as Tick).clamp(1, LONGEST)
    }

    /// Processes the next tick.
    fn process_tick(&mut self, end: f64, exchange: &mut ImpulseExchange) {
        let (tick, time) = (self.state.next, Self::time_of(self.state.next));
        let at = self.state.bodies[0].at(&self.body, time);
        let step = self.step(&at);
        let passed = self.state.now.map_or(0, |now| tick - now);
        let resistance = self.resistance(&at).filter(|resistance| resistance.force != 0.0);
        if let Some(resistance) = resistance {
            let touched = self.state.record.contacts[0].touched.is_some();
            let width = 0.5 * (if touched { passed + step } else { step }) as f64 * TICK;
            self.kick(&at, &resistance, width, end, exchange);
        }
        self.state.record.updates += 1;
        (self.state.now, self.state.next) = (Some(tick), tick + step);
        self.find_exit(time);
    }

    /// Returns the resistance to a body in the gel, after a slip of the spring, and adds the rings that it has passed.
    fn resistance(&mut self, at: &BodyState) -> Option<Resistance> {
        let seen = self.block_motion(at.time).seen_from(at);
        let (depth, speed) = (self.body.depth(&seen), -seen.velocity.z);
        let is_in_gel = at.active && depth >= 0.0 && self.body.rear(&seen) > -self.block.thickness - self.diameter;
        if !is_in_gel || self.body.motion == BodyMotion::Fixed {
            return None;
        }
        let slip = self.class.penetration.slip(self.diameter);
        self.state.anchor = self.state.anchor.clamp(depth - slip, depth + slip);
        let behind = depth - self.block.thickness;
        let travel = if behind < 0.0 { depth - self.state.anchor } else { 0.0 };
        let (diameter, density) = (self.diameter, self.block.density);
        let nose = NoseMotion { diameter, density, speed, depth, behind, travel, mass: self.body.mass };
        let resistance = self.class.penetration.resistance(&nose);
        let passed = ((depth / self.ring_spacing()) as usize).min(self.most_rings());
        while speed > 0.0 && self.state.rings.len() < passed {
            let ring_depth = (self.state.rings.len() + 1) as f64 * self.ring_spacing();
            let time = (at.time - (depth - ring_depth) / speed).max(0.0);
            let start = RingStart { depth: ring_depth, speed, time, energy: resistance.inertia };
            let ring = self.class.rings.ring(self.diameter, &start);
            self.state.rings.push(ring);
        }
        Some(resistance)
    }

    /// Applies the impulse of a resistance over a time `width`, s, and books it.
    fn kick(&mut self, at: &BodyState, resistance: &Resistance, width: f64, end: f64, exchange: &mut ImpulseExchange) {
        let Resistance { force, slope, .. } = *resistance;
        let softening = if self.body.motion == BodyMotion::Free { 0.5 * width * slope / self.body.mass } else { 0.0 };
        let impulse = Vector3::z() * (width * force / (1.0 + softening));
        let state = &mut self.state;
        rebase_body(&self.body, &mut state.bodies[0], &mut state.ledger, at.time);
        self.body.strike(&mut state.bodies[0], &at.position, &impulse);
        let work = impulse.dot(&((at.velocity + state.bodies[0].velocity) / 2.0));
        exchange.impulse += impulse;
        exchange.impulse_moment += impulse * (end - at.time);
        exchange.energy_residual -= work;
        state.given -= work;
        if self.body.motion != BodyMotion::Free {
            state.ledger.energy.external -= work;
            state.ledger.momentum.external += -impulse;
        }
        if self.block.frame.mobility.z == 0.0 {
            state.ledger.momentum.restraint += impulse;
        }
        let seen = self.block_motion(at.time).seen_from(at);
        let depth = self.body.depth(&seen).min(self.block.thickness);
        let record = &mut self.state.record;
        record.outside.add(&-impulse, at.time);
        record.contacts[0].work += work;
        record.contacts[0].add_impulse(&impulse, at.time, depth, self.block.force_window);
    }

    /// Records the exit of the body, and puts the gel to rest once that is over.
    fn find_exit(&mut self, time: f64) {
        let Some(rule) = self.block.exits else { return };
        let at = self.state.bodies[0].at(&self.body, time);
        let found = self.exit(&at).after_tick(&rule);
        self.state.record.contacts[0].exit = found;
        let is_late = found.is_some_and(|exit| time - exit.time >= rule.rest_after);
        self.state.record.at_rest = is_late && self.exit(&at).is_away();
    }

    /// Returns the kinetic energy of the block as a whole, J.
    fn block_energy(&self) -> f64 {
        0.5 * self.gel_mass() * self.block.frame.motion(&self.state.record.outside, 0.0).velocity.norm_squared()
    }

    /// Returns the energies of the rings at a time, J.
    fn ring_energy(&self, time: f64) -> RingEnergy {
        let (rings, spacing) = (&self.state.rings, self.ring_spacing());
        let sum =
            |of: fn(&RingEnergy) -> f64| spacing * ordered_sum(rings.len(), 0.0, |i| of(&rings[i].energy_at(time)));
        RingEnergy { kinetic: sum(|energy| energy.kinetic), stored: sum(|energy| energy.stored) }
    }

    /// Returns energies, momenta and closures at a time, s.
    ///
    /// Heat is the rest of the energy given to the gel, less motion and stored energy: the closure tests the energies of
    /// the body alone.
    #[must_use]
    pub fn totals(&self, time: f64) -> BalanceTotals {
        let mut ledger = self.state.ledger;
        let at = self.state.bodies[0].at(&self.body, time);
        self.state.bodies[0].passage(&self.body, &at).post(&mut ledger);
        let (rings, record) = (self.ring_energy(time), &self.state.record);
        let spring = self.spring_energy();
        let gel_kinetic = self.block_energy() + rings.kinetic;
        let elastic = rings.stored + spring;
        let start = self.start;
        let block_start = 0.5 * self.gel_mass() * self.block.frame.initial_velocity.norm_squared();
        ledger.energy.viscous = gel_kinetic + elastic - block_start - self.state.given;
        let body_kinetic = self.body.kinetic_energy(&at);
        let energy = gel_kinetic + elastic + body_kinetic - start.energy - ledger.energy.total();
        let is_free = self.block.frame.mobility.z > 0.0;
        let gel_momentum =
            self.gel_mass() * self.block.frame.initial_velocity.z + if is_free { record.outside.sum.z } else { 0.0 };
        let momentum = gel_momentum + self.body.momentum(&at).z - start.momentum - ledger.momentum.total().z;
        let positive = |scale: f64| if scale > 0.0 { scale } else { 1.0 };
        let passed = start.scale + ledger.momentum.turnover() + record.contacts[0].impulse.norm();
        BalanceTotals {
            energies: EnergySums { gel_kinetic, body_kinetic, elastic, ahead: 0.0 },
            ledger,
            initial_energy: start.energy,
            provided: self.provided(&ledger.energy),
            energy_imbalance: (energy, energy.abs() / positive(start.energy + ledger.energy.turnover())),
            momentum_imbalance: (Vector3::z() * momentum, momentum.abs() / positive(passed)),
            angular_momentum_imbalance: (Vector3::zeros(), 0.0),
            angular_momentum_scale: 0.0,
        }
    }

    /// Returns the energy that has driven the run, in the frame in which the gel was at rest at the start.
    fn provided(&self, energy: &crate::ledger::EnergyAccounts) -> ProvidedEnergy {
        let (start, speed) = (self.start, self.block.frame.initial_velocity.z);
        let initial = start.energy - speed * start.momentum + 0.5 * start.mass * speed * speed;
        let momentum = &self.state.ledger.momentum;
        let moved = |energy: f64, momentum: Vector3| energy - speed * momentum.z;
        let accounts = crate::ledger::EnergyAccounts {
            external: moved(energy.external, momentum.external.value()),
            ..crate::ledger::EnergyAccounts::default()
        };
        ProvidedEnergy {
            work: accounts.scale_of_work(initial),
            importer: moved(energy.importer, momentum.importer.value()),
        }
    }

    /// Returns the energy of the spring at its travel at the last tick, J.
    fn spring_energy(&self) -> f64 {
        let at = &self.state.bodies[0];
        let depth = self.body.depth(&self.block_motion(at.time).seen_from(at));
        let is_in_gel = self.state.record.contacts[0].touched.is_some() && depth < self.block.thickness;
        let slip = self.class.penetration.slip(self.diameter);
        let travel = (depth - self.state.anchor).clamp(-slip, slip);
        if is_in_gel { 0.5 * self.class.penetration.stiffness(self.diameter) * travel * travel } else { 0.0 }
    }

    /// Returns the greatest diameter of the cavity at a time, s, between two depths, m; 0 without a cavity there.
    #[must_use]
    pub fn greatest_diameter(&self, time: f64, first: f64, last: f64) -> f64 {
        let (law, spacing) = (&self.class.rings, self.ring_spacing());
        let counted = self.state.rings.iter().zip(1..).filter(|(_, number)| {
            let depth = f64::from(*number) * spacing;
            depth > first && depth <= last
        });
        let squared = counted.map(|(ring, _)| law.radius_squared(ring, self.diameter, time)).fold(0.0, f64::max);
        2.0 * squared.sqrt()
    }

    /// Returns R² of the cavity, m², and R Ṙ, m²/s, at a depth, m, and a time, s; zero where the nose has not been.
    #[must_use]
    pub fn opening(&self, depth: f64, time: f64) -> CavityOpening {
        let place = depth / self.ring_spacing() - 1.0;
        let last = self.state.rings.len() as f64 - 1.0;
        if place > last || last < 0.0 {
            return CavityOpening::default();
        }
        let at = |i: usize| {
            let (ring, law) = (&self.state.rings[i], &self.class.rings);
            CavityOpening {
                squared_radius: law.radius_squared(ring, self.diameter, time),
                radial_flow: law.radial_flow(ring, self.diameter, time),
            }
        };
        let place = place.max(0.0);
        let (below, part) = (place as usize, place.fract());
        let (a, b) = (at(below), at((below + 1).min(self.state.rings.len() - 1)));
        CavityOpening {
            squared_radius: a.squared_radius + part * (b.squared_radius - a.squared_radius),
            radial_flow: a.radial_flow + part * (b.radial_flow - a.radial_flow),
        }
    }
}

/// Opening of the cavity at a depth.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CavityOpening {
    /// R², m².
    pub squared_radius: f64,
    /// R Ṙ, m²/s.
    pub radial_flow: f64,
}
