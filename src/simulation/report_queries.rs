//! Report queries of a simulation, one by one: their costs differ by orders of magnitude.

use super::model::{MeshCounts, StepRange};
use super::observe::{BalanceReport, BodyReport, ContactReport, CostReport, EnergyReport, Observation, SensorReport};
use super::run::Simulation;
use super::saved::SavedSimulation;
use crate::contact::ShapeMotion;
use crate::integrator::BalanceTotals;
use crate::math::Vector3;
use crate::scene::CouplingMode;

/// Fraction of μ V t below which a throughput of angular momentum counts as round-off of stresses.
///
/// Round-off ε of the shear modulus breaks the symmetry of stresses, so that their torques may leave ε μ V t: 1e-12
/// of this. A body of 1e-9 kg leaves 0.02 of it (test `light_bodies_leave_the_books_closed`).
const ANGULAR_ROUND_OFF: f64 = f64::EPSILON / 1e-12;

impl Simulation {
    /// Complete report; it visits the whole mesh, so that single queries are cheaper.
    #[must_use]
    pub fn observe(&self) -> Observation {
        let books = self.books();
        Observation {
            time: self.time,
            bodies: (0..self.n_bodies()).map(|body| self.report(body)).collect(),
            sensors: self.sensors(),
            energy: books.energy,
            momentum_imbalance: books.momentum_imbalance,
            angular_momentum_imbalance: books.angular_momentum_imbalance,
            momentum_error: books.momentum_error,
            angular_momentum_error: books.angular_momentum_error,
            cost: self.cost(),
            block: self.block_motion(),
            is_over: self.is_over(),
        }
    }

    /// Energy and momentum balance; sums over the gel.
    #[must_use]
    pub fn books(&self) -> BalanceReport {
        let totals = self.model.totals(self.time);
        BalanceReport {
            energy: energy_report(&totals, self.constants.energy_round_off),
            momentum_imbalance: totals.momentum_imbalance.0,
            angular_momentum_imbalance: totals.angular_momentum_imbalance.0,
            momentum_error: totals.momentum_imbalance.1,
            angular_momentum_error: totals.angular_momentum_imbalance.0.norm()
                / totals.angular_momentum_scale.max(ANGULAR_ROUND_OFF * self.constants.shear_torque * self.time),
        }
    }

    /// Report of a body and its contact.
    fn report(&self, i: usize) -> BodyReport {
        let now = self.now(i);
        BodyReport {
            kinematics: self.kinematics(i),
            active: now.active,
            shape_motion: now.shape_motion,
            depth: self.depth(i),
            exchange: self.exchanges[i],
            contact: self.contact(i),
            exit: self.exit(i),
            energy_deposited: self.energy_deposited(i),
        }
    }

    /// Opening of an expanding body, from 0, unopened, to 1, opened; 0 for any other body.
    #[must_use]
    pub fn expansion(&self, body: usize) -> f64 {
        ShapeMotion::opening_of(self.now(body).shape_motion.as_ref())
    }

    /// Depth of the foremost point of a body below the undeformed entry surface, m (negative above), which moves with
    /// the [block](Self::block_motion).
    #[must_use]
    pub fn depth(&self, body: usize) -> f64 {
        self.model.body(body).0.depth(&self.seen(body))
    }

    /// Greatest depth of a body, m, at most that of the back face, and the time at which it was reached, s.
    fn peak_depth(&self, body: usize) -> (f64, f64) {
        let (seen, record) = (self.seen(body), self.model.record().contacts[body].peak_depth);
        let depth = self.depth(body);
        let thickness = self.constants.gel_box.map_or(f64::INFINITY, |gel| -gel.lower.z);
        if depth.min(thickness) <= record.0 {
            return record;
        }
        // A body that met nothing at the back face reached it before now.
        let beyond = (depth - thickness).max(0.0);
        let since = if seen.velocity.z < 0.0 { -beyond / seen.velocity.z } else { 0.0 };
        (depth.min(thickness), (self.time - since).max(0.0))
    }

    /// Reports of the sensors, in the order of the scene.
    #[must_use]
    pub fn sensors(&self) -> Vec<SensorReport> {
        self.model.sensors(self.time)
    }

    /// Impulse on a body since the start, N·s.
    #[must_use]
    pub fn total_impulse(&self, body: usize) -> Vector3 {
        self.model.record().contacts[body].impulse
    }

    /// Element updates since the start.
    #[must_use]
    pub fn updates(&self) -> f64 {
        self.model.record().updates as f64
    }

    /// Contact of a body since the start, and its current reach; visits the surface of the gel.
    #[must_use]
    pub fn contact(&self, i: usize) -> ContactReport {
        let (record, reach) = (&self.model.record().contacts[i], self.model.reach(i, self.time));
        let mass = self.model.body(i).0.mass;
        let stiffness = 2.0 * self.constants.contact_modulus * (reach.area / std::f64::consts::PI).sqrt();
        let impedance = self.constants.specific_impedance * reach.area;
        let stable = (0.3 * mass / impedance).min(0.2 * (mass / stiffness).sqrt());
        let limited = self.mode == CouplingMode::Prescribed && reach.area > 0.0;
        let mean = |(sum, n): (f64, u64)| if n > 0 { sum / n as f64 } else { 0.0 };
        let longest = if reach.area > 0.0 { reach.longest_step } else { self.model.steps().smallest };
        ContactReport {
            total_impulse: record.impulse,
            active: self.exchanges[i].is_contact(),
            area: reach.area,
            penetration: reach.penetration,
            stiffness,
            impedance,
            direction: record.direction,
            first: record.touched.map(|touched| touched.0),
            last: record.touched.map(|touched| touched.1),
            peak_force: record.window.2 / self.constants.force_window,
            peak_depth: self.peak_depth(i),
            mean_standing_penetration: mean(record.standing),
            deepest_penetration: record.deepest,
            step_advice: if limited { stable.min(self.constants.end_time) } else { self.constants.end_time },
            step_min: 4.0 * longest,
        }
    }

    /// Number of remeshings since the start.
    #[must_use]
    pub fn remeshes(&self) -> u64 {
        self.model.record().remeshes
    }

    /// Fraction of the elements whose rest shape is not that of their nodes' rest positions, as remeshing leaves
    /// them.
    #[must_use]
    pub fn incompatible_fraction(&self) -> f64 {
        self.model.incompatible_fraction()
    }

    /// Cost of the run so far; visits the groups of elements.
    #[must_use]
    pub fn cost(&self) -> CostReport {
        let StepRange { smallest: smallest_step, largest: largest_step } = self.model.steps();
        let MeshCounts { elements, nodes, crushed: crushed_elements } = self.model.counts();
        CostReport {
            element_updates: self.updates(),
            synchronous_updates: self.model.synchronous_updates(self.time),
            smallest_step,
            largest_step,
            elements,
            nodes,
            min_jacobian: self.model.record().min_jacobian,
            crushed_elements,
            remeshes: self.remeshes(),
            unconverged_solves: self.model.record().unconverged_solves,
            eroded_mass: self.model.record().eroded_mass,
            incompatible_fraction: self.incompatible_fraction(),
        }
    }

    /// Masses of the materials of the gel at the last remeshing, kg: those of its layers front to back, and that of the gel
    /// below them. Eroded gel does not count.
    #[must_use]
    pub fn material_masses(&self) -> Vec<f64> {
        self.model.material_masses()
    }

    /// Additional bytes of a remeshing at most; 0 without remeshing.
    #[must_use]
    pub fn memory_of_remeshing(&self) -> u64 {
        if self.model.can_remesh() && !self.is_at_rest() { self.model.mesh_size().remeshing() as u64 } else { 0 }
    }

    /// Additional bytes of a look at the cavity at most; 0 while the end of the run does not depend on it.
    #[must_use]
    pub fn memory_of_looks(&self) -> u64 {
        let is_near = || self.constants.gel_box.is_some_and(|gel| self.depth(0) > -gel.lower.z);
        let looks = self.next_look().is_some() && (self.constants.end_rules.stops_at_rest || is_near());
        if looks { self.model.mesh_size().looking() as u64 } else { 0 }
    }

    /// Additional bytes of a frame of the results, or of the final report, at most.
    #[must_use]
    pub fn memory_of_writing(&self) -> u64 {
        self.model.mesh_size().writing() as u64
    }

    /// Bytes of a state.
    #[must_use]
    pub fn memory_of_state(&self) -> u64 {
        self.model.state_bytes() as u64
    }

    /// Additional bytes of restoring a state at most: a mesh other than the current one is laid out again.
    #[must_use]
    pub fn memory_of_restoring(&self, saved: &SavedSimulation) -> u64 {
        let needed = || self.model.mesh_size().restoring(saved.n_elements() as f64) as u64;
        if self.model.can_remesh() { needed() } else { 0 }
    }
}

fn energy_report(totals: &BalanceTotals, energy_round_off: f64) -> EnergyReport {
    let (books, energies, provided) = (&totals.ledger.energy, &totals.energies, &totals.provided);
    let defect = books.integration.abs() + books.contact_bias.abs() + provided.importer.abs() + books.remesh.abs();
    let scale = provided.work;
    let scale = if scale > energy_round_off { scale } else { 1.0 };
    EnergyReport {
        kinetic: energies.gel_kinetic + energies.body_kinetic,
        projectile: energies.body_kinetic,
        elastic: energies.elastic,
        contact: books.contact,
        self_contact: books.self_contact,
        friction: books.friction,
        contact_bias: books.contact_bias,
        integration: books.integration,
        external: books.external,
        expansion: books.expansion,
        importer: books.importer,
        remesh: books.remesh - books.remesh_returned,
        remesh_returned: books.remesh_returned,
        load: books.load,
        air: books.air,
        damping: books.damping,
        bulk_viscous: books.bulk_viscous,
        viscous: books.viscous,
        eroded: books.eroded,
        damage: books.damage,
        imbalance: totals.energy_imbalance.0,
        initial: totals.initial_energy,
        energy_error: totals.energy_imbalance.1,
        energy_defect: defect / scale,
        provided: provided.total(),
    }
}
