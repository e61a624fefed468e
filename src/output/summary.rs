//! `summary.json`: the figures of a run under fixed names.

use super::Ending;
use super::overlap;
use super::penetration::Penetration;
use super::sensors::SensorFigures;
use crate::math::Vector3;
use crate::scene::{self, Dimension, Fidelity, Scene};
use crate::simulation::{self, BodyReport, EnergyReport, Observation};
use serde::Serialize;
use std::time::Instant;

/// How the simulation was driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Interface {
    /// Through the FMI 2.0 C interface.
    Fmi2,
    /// By the library.
    Direct,
}

/// Cause of the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EndCause {
    /// It reached `scene.end_time`.
    EndTime,
    /// The projectile left the gel, `scene.stop_after_exit` before.
    Exit,
    /// It could not go on.
    Failure,
    /// The user or the importer ended it.
    Interrupt,
}

impl EndCause {
    fn of(ending: &Ending, end_time: f64) -> Self {
        match ending.observation {
            _ if ending.failure.is_some() => Self::Failure,
            seen if seen.time >= end_time * (1.0 - 1e-9) => Self::EndTime,
            seen if seen.is_over => Self::Exit,
            _ => Self::Interrupt,
        }
    }
}

/// The figures of a run, SI; `None` (null in JSON) where a figure does not exist.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the scene.
    pub scene: String,
    /// Version of this crate.
    pub version: &'static str,
    /// How the simulation was driven.
    pub interface: Interface,
    /// How accurate it was to be.
    pub fidelity: Fidelity,
    /// Greatest relative error of the motion of the projectile that was measured at this level, if the scene is as it was then.
    pub expected_error: Option<f64>,
    /// Whether it reached its end: the end time of the scene, or `scene.stop_after_exit` after the exit of the projectile.
    pub completed: bool,
    /// Cause of its end.
    pub ended_by: EndCause,
    /// Time that it reached, s.
    pub end_time: f64,
    /// Wall time between the first and the last record, s.
    pub wall_seconds: f64,
    /// Threads of the element phase.
    pub threads: usize,
    /// The space the gel lives in.
    pub dimension: Dimension,
    /// Elements.
    pub elements: usize,
    /// Nodes.
    pub nodes: usize,
    /// Element updates.
    pub element_updates: f64,
    /// Element updates per second of wall time.
    pub updates_per_second: f64,
    /// Updates that one global stable step of the assembled system would have cost.
    pub synchronous_updates: f64,
    /// Smallest element step at the end, s.
    pub smallest_step: f64,
    /// Largest element step at the end, s.
    pub largest_step: f64,
    /// Exchanges of the mesh.
    pub remeshes: u64,
    /// Part of the elements that are at rest not what their nodes say, at the end.
    pub remesh_fallback: f64,
    /// Volume of the gel that lies over other gel at the end, because its surfaces do not see each other, m³.
    pub overlapped_volume: f64,
    /// Smallest J = det F of the run.
    pub min_jacobian: f64,
    /// Greatest depth, m; it ends at the back face of a block or cylinder.
    pub peak_depth: f64,
    /// When it was reached, s.
    pub time_of_peak_depth: f64,
    /// Depth at the end, m; it ends at the back face, too.
    pub final_depth: f64,
    /// Whether and how it left the gel at the back.
    #[serde(flatten)]
    pub exit: ExitFigures,
    /// Speed against the velocity at the start, m/s; absent while in contact (numerics A14) and of a projectile that has perforated the gel.
    pub rebound_velocity: Option<f64>,
    /// Velocity at the end, m/s.
    pub final_velocity: [f64; 3],
    /// From the first to the last impulse, s.
    pub contact_duration: Option<f64>,
    /// Greatest mean force over a window of `force_window`, N.
    pub peak_force: f64,
    /// Width of that window, s.
    pub force_window: f64,
    /// Impulse on the projectile, N·s.
    pub total_impulse: [f64; 3],
    /// Greatest diameter of the cavity deeper than the projectile is long, m; this and the next three only of a projectile that has
    /// gone deeper than it is long along −z.
    pub greatest_cavity_diameter: Option<f64>,
    /// When it was that wide, s.
    pub time_of_greatest_cavity: Option<f64>,
    /// Greatest diameter of the cavity at the end, m.
    pub final_cavity_diameter: Option<f64>,
    /// Energy given to the gel in each centimetre of depth, J; the last one ends at the greatest depth.
    pub energy_per_centimetre: Option<Vec<f64>>,
    /// What became of each fragment.
    pub fragments: Vec<FragmentFigures>,
    /// What each sensor has measured.
    pub sensors: Vec<SensorFigures>,
    /// Energy by account, J.
    #[serde(rename = "energy", serialize_with = "as_object")]
    pub accounts: Vec<Account>,
    /// Energy that no account explains, relative to its throughput (numerics A6).
    pub energy_error: f64,
    /// The method's own error, relative to the energy at the start and what came in from outside (numerics A6).
    pub energy_defect: f64,
    /// Momentum that no account explains, relative to its throughput.
    pub momentum_error: f64,
    /// Angular momentum that no account explains, relative to its throughput, or to 2.2e-4 μ V t (shear modulus, volume of the gel, time),
    /// if that is more: the round-off of stresses is relative to the modulus, however little a light body brings.
    pub angular_momentum_error: f64,
    /// Change of the mass of the mesh at rest, relative.
    pub mass_error: Option<f64>,
    /// Mean penetration of touching nodes, in element sizes.
    pub mean_standing_penetration: f64,
    /// Hash of the stored state, 32 hexadecimal digits.
    pub digest: String,
    /// What the scene does not model.
    pub switched_off: Vec<String>,
    /// The diagnosis of a run that stopped early.
    pub failure: Option<String>,
    /// Reasons to doubt the figures of the run: what could be told of its scene, then what was seen of it.
    pub doubts: Vec<String>,
    /// All of them in one text, if there are any.
    pub doubt: Option<String>,
}

/// Exit of the projectile at the back face of the gel, SI.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExitFigures {
    /// Whether the rear end of the projectile has passed the undisturbed back face of the gel.
    pub perforated: bool,
    /// Velocity at the exit, m/s; this and the next two only of a projectile that has perforated the gel.
    pub exit_velocity: Option<[f64; 3]>,
    /// Time of the exit, s.
    pub exit_time: Option<f64>,
    /// Kinetic energy at the exit, J.
    pub residual_energy: Option<f64>,
    /// Energy given to the gel, J, up to the exit if there is one.
    pub energy_deposited: f64,
}

impl ExitFigures {
    fn of(projectile: &BodyReport) -> Self {
        let exit = projectile.exit.as_ref();
        Self {
            perforated: exit.is_some(),
            exit_velocity: exit.map(|exit| exit.velocity.into()),
            exit_time: exit.map(|exit| exit.time),
            residual_energy: exit.map(|exit| exit.residual_energy),
            energy_deposited: projectile.energy_deposited,
        }
    }
}

/// What became of a fragment.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FragmentFigures {
    /// Whether it took part at the end.
    pub active: bool,
    /// Greatest depth of its foremost point below z = 0, m, as far as it was seen in contact.
    pub peak_depth: f64,
    /// Depth at the end, m.
    pub final_depth: f64,
    /// Velocity at the end, m/s.
    pub final_velocity: [f64; 3],
    /// Greatest mean force over a window of `force_window`, N.
    pub peak_force: f64,
    /// Impulse on it, N·s.
    pub total_impulse: [f64; 3],
}

impl FragmentFigures {
    fn of(fragment: &BodyReport) -> Self {
        Self {
            active: fragment.active,
            peak_depth: fragment.contact.peak_depth.0,
            final_depth: fragment.depth,
            final_velocity: fragment.kinematics.velocity.into(),
            peak_force: fragment.contact.peak_force,
            total_impulse: fragment.contact.total_impulse.into(),
        }
    }
}

/// What a summary needs from the start of a run.
#[derive(Debug)]
pub(super) struct Run {
    pub(super) scene: Scene,
    pub(super) initial_mass: Option<f64>,
    interface: Interface,
    threads: usize,
    started: Instant,
}

impl Run {
    pub(super) fn start(scene: &Scene, interface: Interface, threads: usize) -> Self {
        let all = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let threads = if threads == 0 { all() } else { threads };
        Self { scene: scene.clone(), initial_mass: None, interface, threads, started: Instant::now() }
    }
}

impl Run {
    /// Change of a mass from that at the start, relative.
    fn mass_error(&self, mass: f64) -> Option<f64> {
        self.initial_mass.map(|initial| (mass / initial - 1.0).abs())
    }

    /// What makes figures doubtful, of the scene and of what was seen.
    fn doubts(&self, seen: &Observation) -> Vec<String> {
        [scene::doubts(&self.scene), simulation::doubts(&self.scene, seen)].concat()
    }

    /// Error that was measured at the level of the run, if there is one.
    fn expected_error(&self) -> Option<f64> {
        self.scene.fidelity.get(self.scene.scene.fidelity).and_then(|level| level.error)
    }
}

impl Summary {
    pub(super) fn of(run: &Run, ending: &Ending, penetration: Option<&Penetration>) -> Self {
        let Observation { time, energy, cost, .. } = ending.observation;
        let BodyReport { kinematics, depth, contact, .. } = ending.observation.projectile();
        let wall_seconds = run.started.elapsed().as_secs_f64();
        let (doubts, ended_by) = (run.doubts(ending.observation), EndCause::of(ending, run.scene.scene.end_time));
        Self {
            scene: run.scene.scene.name.clone(),
            version: env!("CARGO_PKG_VERSION"),
            interface: run.interface,
            fidelity: run.scene.scene.fidelity,
            expected_error: run.expected_error(),
            completed: matches!(ended_by, EndCause::EndTime | EndCause::Exit),
            ended_by,
            end_time: *time,
            wall_seconds,
            threads: run.threads,
            dimension: run.scene.scene.dimension,
            elements: cost.elements,
            nodes: cost.nodes,
            element_updates: cost.element_updates,
            updates_per_second: cost.element_updates / wall_seconds,
            synchronous_updates: cost.synchronous_updates,
            smallest_step: cost.smallest_step,
            largest_step: cost.largest_step,
            remeshes: cost.remeshes,
            remesh_fallback: cost.fallback,
            overlapped_volume: overlap::volume(&run.scene, ending.frame),
            min_jacobian: cost.min_jacobian,
            peak_depth: contact.peak_depth.0,
            time_of_peak_depth: contact.peak_depth.1,
            final_depth: depth.min(run.scene.gel.shape.thickness().unwrap_or(f64::INFINITY)),
            exit: ExitFigures::of(ending.observation.projectile()),
            rebound_velocity: rebound(ending.observation, run.scene.projectile.velocity.into()),
            final_velocity: kinematics.velocity.into(),
            contact_duration: contact.first.zip(contact.last).map(|(first, last)| last - first),
            peak_force: contact.peak_force,
            force_window: run.scene.force_window(),
            total_impulse: contact.total_impulse.into(),
            greatest_cavity_diameter: penetration.map(|shot| shot.cavity.greatest.0),
            time_of_greatest_cavity: penetration.map(|shot| shot.cavity.greatest.1),
            final_cavity_diameter: penetration.map(|shot| shot.cavity.last_diameter),
            energy_per_centimetre: penetration.map(|shot| shot.track.energy_per_centimetre()),
            fragments: ending.observation.bodies[1..].iter().map(FragmentFigures::of).collect(),
            sensors: vec![],
            accounts: accounts(energy).into(),
            energy_error: energy.energy_error,
            energy_defect: energy.energy_defect,
            momentum_error: ending.observation.momentum_error,
            angular_momentum_error: ending.observation.angular_momentum_error,
            mass_error: run.mass_error(ending.frame.mass + cost.splashed),
            mean_standing_penetration: contact.mean_standing_penetration,
            digest: format!("{:032x}", ending.digest),
            switched_off: scene::switched_off(&run.scene),
            failure: ending.failure.map(str::to_string),
            doubt: (!doubts.is_empty()).then(|| doubts.join("; ")),
            doubts,
        }
    }

    /// Energy at the start, J.
    pub(super) fn initial_energy(&self) -> f64 {
        self.accounts.iter().find(|account| account.name == "initial").map_or(0.0, |account| account.value)
    }

    pub(super) fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("names and numbers can always be written") + "\n"
    }
}

/// A named account of the energy ledger.
#[derive(Debug, Clone, PartialEq)]
pub struct Account {
    /// Its name in `summary.json`.
    pub name: &'static str,
    /// Its value, J.
    pub value: f64,
    /// What it holds, in words.
    pub meaning: &'static str,
}

fn as_object<S: serde::Serializer>(accounts: &[Account], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(accounts.iter().map(|account| (account.name, account.value)))
}

/// Every energy account, in the order of the report.
fn accounts(energy: &EnergyReport) -> [Account; 18] {
    let account = |name, value, meaning| Account { name, value, meaning };
    [
        account("initial", energy.initial, "all energy at the start"),
        account("kinetic", energy.kinetic, "motion of gel and bodies"),
        account("projectile", energy.projectile, "motion of projectile and fragments alone (part of kinetic)"),
        account("elastic", energy.elastic, "stored in the deformed gel"),
        account("contact", energy.contact, "work of the contact law; negative is dissipated"),
        account("friction", energy.friction, "work of friction; negative is dissipated"),
        account("contact_bias", energy.contact_bias, "work of removing standing penetration"),
        account("integration", energy.integration, "residual of the time integration"),
        account("external", energy.external, "work of external forces and of a prescribed motion"),
        account("importer", energy.importer, "jumps of the bodies made by the importer"),
        account("remesh", energy.remesh, "what kinetic and stored energy change by when the mesh is exchanged"),
        account("load", energy.load, "work of the pressures on faces"),
        account("damping", energy.damping, "work of the damping; negative is dissipated"),
        account("plastic", energy.plastic, "lost to plastic flow"),
        account("viscous", energy.viscous, "lost to viscosity"),
        account("splash", energy.splash, "taken along by what has broken off"),
        account("damage", energy.damage, "stored energy lost to softening"),
        account("closure", energy.closure, "what no account explains"),
    ]
}

/// Speed against the initial velocity once the last impulse is past by 10 % of the contact, m/s (numerics A14); none of a body that has left
/// the gel at its back.
#[must_use]
pub fn rebound(observation: &Observation, initial: Vector3) -> Option<f64> {
    let (first, last) = observation.projectile().contact.first.zip(observation.projectile().contact.last)?;
    let direction = initial.try_normalize(0.0).filter(|_| observation.projectile().exit.is_none())?;
    let over = observation.time - last > 0.1 * (last - first);
    over.then(|| -observation.projectile().kinematics.velocity.dot(&direction))
}
