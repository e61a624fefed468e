//! `summary.json`: figures of a run under fixed keys.

use super::accounts::{SummaryAccount, as_object, energy_accounts, from_object};
use super::exit::ExitFigures;
use super::expansion::ExpansionFigures;
use super::overlap;
use super::penetration::PenetrationRecord;
use super::sensors::SensorFigures;
use super::wound::WoundFigures;
use crate::math::{Vector3, shared_cpu_time};
use crate::scene::{self, Dimension, FidelityKind, Scene};
use crate::simulation::{self, BodyReport, MeshFrame, Observation};
use cpu_time::ProcessTime;
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// Format of `summary.json`: it changes when a key goes or changes its meaning.
pub const SUMMARY_FORMAT: u32 = 2;

/// Interface that drove the simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum DriverInterface {
    /// FMI 2.0 C interface.
    Fmi2,
    /// Direct library calls.
    Direct,
}

/// Final state of a run, and the reason for an early stop.
#[derive(Debug, Clone, Copy)]
pub struct FinalState<'a> {
    /// Observation at the end.
    pub observation: &'a Observation,
    /// Mesh at the end.
    pub frame: &'a MeshFrame,
    /// Hash of the state at the end.
    pub digest: u128,
    /// Diagnosis of a run that stopped early.
    pub failure: Option<&'a str>,
}

/// Cause of the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum EndCause {
    /// The run reached `scene.end_time`.
    EndTime,
    /// The projectile left the gel: `scene.stop_after_exit` has passed since, and the cavity has turned.
    Exit,
    /// The projectile rests in the gel (`scene.stop_at_rest`).
    Rest,
    /// The simulation failed.
    Failure,
    /// The user or the importer ended the run.
    Interrupt,
}

impl EndCause {
    fn of(ending: &FinalState, end_time: f64) -> Self {
        match ending.observation {
            _ if ending.failure.is_some() => Self::Failure,
            observation if observation.time >= end_time * (1.0 - 1e-9) => Self::EndTime,
            observation if observation.is_over && observation.projectile().exit.is_none() => Self::Rest,
            observation if observation.is_over => Self::Exit,
            _ => Self::Interrupt,
        }
    }
}

/// Figures of a run in SI units; `None` (null in JSON) for a figure without a value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct RunSummary {
    /// Format of this file: another one is read by another release.
    pub format: u32,
    /// Name of the scene.
    pub scene: String,
    /// Version of this crate.
    pub version: String,
    /// Interface that drove the simulation.
    pub interface: DriverInterface,
    /// Requested fidelity.
    pub fidelity: FidelityKind,
    /// Errors that the figures are known to have.
    #[serde(flatten)]
    pub errors: KnownErrors,
    /// True if the run reached the end time of the scene, or its end after the exit or the rest of the projectile.
    pub completed: bool,
    /// Cause of the end.
    pub ended_by: EndCause,
    /// Time at the end, s.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "end")))]
    pub end_time: f64,
    /// Wall time between the first and the last record, s.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "end")))]
    pub wall_seconds: f64,
    /// CPU time of the process between the first and the last record, s: within an importer, with what that computes.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "end")))]
    pub cpu_seconds: f64,
    /// Part of `cpu_seconds` outside of work that was shared among threads, s, with their waiting; with one thread all of it.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "end")))]
    pub serial_seconds: f64,
    /// Part of `cpu_seconds` in work that was shared among threads, s; 0 with one thread.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "end")))]
    pub parallel_seconds: f64,
    /// Threads of the element loop.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "start")))]
    pub threads: usize,
    /// Dimension of the scene.
    pub dimension: Dimension,
    /// Number of elements.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "end")))]
    pub elements: usize,
    /// Number of nodes.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "end")))]
    pub nodes: usize,
    /// Number of element updates.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "end")))]
    pub element_updates: f64,
    /// Element updates per second of wall time.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1/s", "x-sampled" = "end")))]
    pub updates_per_second: f64,
    /// Element updates of a synchronous integrator with the stable step of the assembled system.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "end")))]
    pub synchronous_updates: f64,
    /// Smallest element step at the end, s.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "end")))]
    pub smallest_step: f64,
    /// Largest element step at the end, s.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "end")))]
    pub largest_step: f64,
    /// Number of remeshings.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "end")))]
    pub remeshes: u64,
    /// Number of ticks at which the sweeps of the contact solver ended by their number, not by their residual.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "tick")))]
    pub unconverged_solves: u64,
    /// Fraction of incompatible elements at the end: their reference shape is not that of their nodes' rest
    /// positions.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "end")))]
    pub incompatible_fraction: f64,
    /// Volume of self-overlap of the gel at the end, m³: without self-contact surfaces pass through each other; with it
    /// they are stopped where they stand in each other, and not pushed out.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m3", "x-sampled" = "end")))]
    pub overlapped_volume: f64,
    /// Smallest J = det F of the run.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "update")))]
    pub min_jacobian: f64,
    /// Greatest depth in the block, m, limited by the back face of a block or cylinder.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "tick")))]
    pub peak_depth: f64,
    /// Time of the greatest depth, s.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "tick")))]
    pub time_of_peak_depth: f64,
    /// Depth in the block at the end, m, limited by the back face.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "end")))]
    pub final_depth: f64,
    /// Figures of the exit at the back face.
    #[serde(flatten)]
    pub exit: ExitFigures,
    /// Expansion of the projectile.
    #[serde(flatten)]
    pub expansion: ExpansionFigures,
    /// Rebound speed relative to the block, against the initial velocity, m/s (method A14); absent during contact and
    /// after a perforation.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m/s", "x-sampled" = "end")))]
    pub rebound_velocity: Option<f64>,
    /// Velocity at the end in the world frame, m/s.
    #[serde(deserialize_with = "super::numbers::vector")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m/s", "x-sampled" = "end")))]
    pub final_velocity: [f64; 3],
    /// Time from the first to the last contact impulse, s.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "tick")))]
    pub contact_duration: Option<f64>,
    /// Greatest mean force over a window of `force_window`, N.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "N", "x-sampled" = "tick")))]
    pub peak_force: f64,
    /// Width of the window of the peak force, s.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "start")))]
    pub force_window: f64,
    /// Contact impulse on the projectile, N·s.
    #[serde(deserialize_with = "super::numbers::vector")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "N s", "x-sampled" = "end")))]
    pub total_impulse: [f64; 3],
    /// Rest of the projectile, course of the cavity and permanent track.
    #[serde(flatten)]
    pub wound: WoundFigures,
    /// Energy given to the gel in each centimetre of depth, seen from the block, J; the last centimetre ends at the
    /// greatest depth. Needs a penetration along −z beyond the length of the projectile.
    #[serde(deserialize_with = "super::numbers::list")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "J", "x-sampled" = "step")))]
    pub energy_per_centimetre: Option<Vec<f64>>,
    /// Figures of each fragment.
    pub fragments: Vec<FragmentFigures>,
    /// Figures of each sensor.
    pub sensors: Vec<SensorFigures>,
    /// Energy accounts, J.
    #[serde(rename = "energy", serialize_with = "as_object", deserialize_with = "from_object")]
    #[cfg_attr(feature = "cli", schemars(with = "std::collections::BTreeMap<String, Option<f64>>"))]
    pub accounts: Vec<SummaryAccount>,
    /// Residual of the energy balance relative to its throughput (method A6).
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "end")))]
    pub energy_error: f64,
    /// Error of the method relative to the initial energy and the energy from outside (method A6).
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "end")))]
    pub energy_defect: f64,
    /// Residual of the momentum balance relative to its throughput.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "end")))]
    pub momentum_error: f64,
    /// Residual of the angular momentum balance relative to its throughput, or to 2.2e-4 μ V t if greater (shear
    /// modulus, volume of the gel, time). The second scale covers light bodies: the round-off of stresses is relative
    /// to the modulus.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "end")))]
    pub angular_momentum_error: f64,
    /// Relative change of the mass of the mesh at rest.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "end")))]
    pub mass_error: Option<f64>,
    /// Mean penetration of the nodes in contact, in element sizes.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "tick")))]
    pub mean_standing_penetration: f64,
    /// Hash of the stored state, 32 hexadecimal digits.
    pub digest: String,
    /// Effects switched off in the scene.
    pub switched_off: Vec<String>,
    /// Diagnosis of a run that stopped early.
    pub failure: Option<String>,
    /// Reasons to doubt the figures, from the scene first and from the run second.
    pub doubts: Vec<String>,
    /// All doubts in one text, if any.
    pub doubt: Option<String>,
}

/// Relative errors that are known for shots of the kind of a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct KnownErrors {
    /// Greatest relative error of the projectile motion measured at this fidelity, for an unmodified scene.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "start")))]
    pub expected_error: Option<f64>,
    /// Model error of the gel for shots like this one: root mean square of the relative deviations of their depths from
    /// measured or derived ones.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "start")))]
    pub model_error: Option<f64>,
}

impl KnownErrors {
    fn of(scene: &Scene) -> Self {
        let class = scene::shot_class(scene, 0);
        Self { expected_error: scene.level_error(), model_error: class.map(|class| class.error) }
    }
}

/// Figures of a fragment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct FragmentFigures {
    /// True if the fragment was active at the end.
    pub active: bool,
    /// Greatest depth of the foremost point in the block, m, over the contact.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "tick")))]
    pub peak_depth: f64,
    /// Depth in the block at the end, m.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "end")))]
    pub final_depth: f64,
    /// Velocity at the end, m/s.
    #[serde(deserialize_with = "super::numbers::vector")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m/s", "x-sampled" = "end")))]
    pub final_velocity: [f64; 3],
    /// Greatest mean force over a window of `force_window`, N.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "N", "x-sampled" = "tick")))]
    pub peak_force: f64,
    /// Contact impulse on the fragment, N·s.
    #[serde(deserialize_with = "super::numbers::vector")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "N s", "x-sampled" = "end")))]
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

/// Data of a summary known at the start of a run.
#[derive(Debug)]
pub(super) struct RunInfo {
    pub(super) scene: Scene,
    pub(super) initial_mass: Option<f64>,
    /// Velocity of the block at the start, m/s.
    pub(super) block_velocity: Vector3,
    interface: DriverInterface,
    threads: usize,
    started: Instant,
    started_cpu: Option<ProcessTime>,
    /// CPU time of shared work at the start.
    started_shared: Duration,
}

impl RunInfo {
    /// Returns the wall time since the start of the run, s.
    fn wall_seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Returns the CPU time of the process since the start of the run, s; not a number where the system has none.
    fn cpu_seconds(&self) -> f64 {
        let spent = self.started_cpu.and_then(|start| start.try_elapsed().ok());
        spent.map_or(f64::NAN, |spent| spent.as_secs_f64())
    }

    /// Returns the CPU time of the work that was shared among threads, s.
    fn parallel_seconds(&self) -> f64 {
        shared_cpu_time().saturating_sub(self.started_shared).as_secs_f64()
    }

    pub(super) fn start(scene: &Scene, interface: DriverInterface, threads: usize) -> Self {
        let all = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let threads = if threads == 0 { all() } else { threads };
        Self {
            scene: scene.clone(),
            initial_mass: None,
            block_velocity: Vector3::zeros(),
            interface,
            threads,
            started: Instant::now(),
            started_cpu: ProcessTime::try_now().ok(),
            started_shared: shared_cpu_time(),
        }
    }
}

impl RunInfo {
    /// Returns the velocity of the projectile relative to the block at the start, m/s.
    fn impact_velocity(&self) -> Vector3 {
        Vector3::from(self.scene.projectile.velocity) - self.block_velocity
    }

    /// Returns the change of a mass relative to the initial mass.
    fn mass_error(&self, mass: f64) -> Option<f64> {
        self.initial_mass.map(|initial| (mass / initial - 1.0).abs())
    }

    /// Returns the reasons to doubt the figures, from the scene and from the observation.
    fn doubts(&self, observation: &Observation) -> Vec<String> {
        [scene::doubts(&self.scene), simulation::doubts(&self.scene, observation)].concat()
    }
}

impl RunSummary {
    pub(super) fn of(run: &RunInfo, ending: &FinalState, penetration: Option<&PenetrationRecord>) -> Self {
        let (seen, body) = (ending.observation, ending.observation.projectile());
        let (doubts, ended_by) = (run.doubts(seen), EndCause::of(ending, run.scene.scene.end_time));
        Self {
            format: SUMMARY_FORMAT,
            scene: run.scene.scene.name.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            interface: run.interface,
            fidelity: run.scene.scene.fidelity,
            errors: KnownErrors::of(&run.scene),
            completed: matches!(ended_by, EndCause::EndTime | EndCause::Exit | EndCause::Rest),
            ended_by,
            end_time: seen.time,
            wall_seconds: run.wall_seconds(),
            cpu_seconds: run.cpu_seconds(),
            serial_seconds: run.cpu_seconds() - run.parallel_seconds(),
            parallel_seconds: run.parallel_seconds(),
            threads: run.threads,
            dimension: run.scene.scene.dimension,
            elements: seen.cost.elements,
            nodes: seen.cost.nodes,
            element_updates: seen.cost.element_updates,
            updates_per_second: seen.cost.element_updates / run.wall_seconds(),
            synchronous_updates: seen.cost.synchronous_updates,
            smallest_step: seen.cost.smallest_step,
            largest_step: seen.cost.largest_step,
            remeshes: seen.cost.remeshes,
            unconverged_solves: seen.cost.unconverged_solves,
            incompatible_fraction: seen.cost.incompatible_fraction,
            overlapped_volume: overlap::volume(&run.scene, ending.frame),
            min_jacobian: seen.cost.min_jacobian,
            peak_depth: body.contact.peak_depth.0,
            time_of_peak_depth: body.contact.peak_depth.1,
            final_depth: body.depth.min(run.scene.gel.shape.thickness().unwrap_or(f64::INFINITY)),
            exit: ExitFigures::of(body),
            expansion: ExpansionFigures::of(&run.scene, seen),
            rebound_velocity: rebound(seen, run.impact_velocity()),
            final_velocity: body.kinematics.velocity.into(),
            contact_duration: body.contact.first.zip(body.contact.last).map(|(first, last)| last - first),
            peak_force: body.contact.peak_force,
            force_window: run.scene.force_window(),
            total_impulse: body.contact.total_impulse.into(),
            wound: WoundFigures::default(),
            energy_per_centimetre: penetration.map(|shot| shot.track.energy_per_centimetre()),
            fragments: seen.bodies[1..].iter().map(FragmentFigures::of).collect(),
            sensors: vec![],
            accounts: energy_accounts(&seen.energy),
            energy_error: seen.energy.energy_error,
            energy_defect: seen.energy.energy_defect,
            momentum_error: seen.momentum_error,
            angular_momentum_error: seen.angular_momentum_error,
            mass_error: run.mass_error(ending.frame.mass + seen.cost.eroded_mass),
            mean_standing_penetration: body.contact.mean_standing_penetration,
            digest: format!("{:032x}", ending.digest),
            switched_off: scene::switched_off(&run.scene),
            failure: ending.failure.map(str::to_string),
            doubt: (!doubts.is_empty()).then(|| doubts.join("; ")),
            doubts,
        }
    }

    #[cfg(feature = "cli")]
    /// Returns the initial energy, J.
    pub(super) fn initial_energy(&self) -> f64 {
        self.accounts.iter().find(|account| account.name == "initial").map_or(0.0, |account| account.value)
    }

    pub(super) fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("names and numbers can always be written") + "\n"
    }
}

/// Returns the rebound speed relative to the block, against the initial velocity relative to it, m/s (method A14).
/// The last impulse must be older than 10 % of the contact time; a perforating body has no rebound.
#[must_use]
pub fn rebound(observation: &Observation, initial: Vector3) -> Option<f64> {
    let (first, last) = observation.projectile().contact.first.zip(observation.projectile().contact.last)?;
    let direction = initial.try_normalize(0.0).filter(|_| observation.projectile().exit.is_none())?;
    let over = observation.time - last > 0.1 * (last - first);
    let velocity = || observation.projectile().kinematics.velocity - observation.block.velocity;
    over.then(|| -velocity().dot(&direction))
}
