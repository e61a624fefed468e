//! Single run of a ladder in a process of its own, whose CPU time counts nothing else.

use super::importer::{self, CouplingVariant};
use crate::console;
use crate::failure::{CommandError, RunError};
use crate::job;
use crate::options::TradeRowOptions;
use crate::source;
use ballistic_gel::math::Vector3;
use ballistic_gel::output;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::Observation;
use cpu_time::ProcessTime;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Results and cost of a finished run, SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TradeRow {
    /// Time reached, s.
    pub end_time: f64,
    /// Number of elements at the end.
    pub elements: usize,
    /// Number of remeshes.
    pub remeshes: u64,
    /// Number of element updates.
    pub element_updates: f64,
    /// CPU time from meshing to the last step, s.
    pub cpu_seconds: f64,
    /// Wall-clock time from meshing to the last step, s.
    pub wall_seconds: f64,
    /// Greatest depth, m.
    pub peak_depth: f64,
    /// Time from the first to the last impulse, s; `None` while in contact.
    pub contact_duration: Option<f64>,
    /// Speed at the end relative to the block, against the initial direction, m/s: the rebound speed once out of
    /// contact.
    pub final_speed: f64,
    /// Initial speed, m/s.
    pub initial_speed: f64,
    /// Greatest force, averaged over the force window of the scene, N.
    pub peak_force: f64,
    /// Energy error of the time integration.
    pub energy_defect: f64,
    /// Hash of the final state, 32 hexadecimal digits.
    pub digest: String,
    /// Diagnosis of a run that stopped early.
    pub failure: Option<String>,
}

/// Runs a scene file on one thread and prints its row as JSON; the least times of all repetitions count.
pub fn print_row(options: &TradeRowOptions) -> Result<(), CommandError> {
    let scene = source::load_file(&options.scene, &options.folder)?;
    let mut row = run_scene(&scene, options.importer)?;
    for _ in 1..options.repeat {
        let again = run_scene(&scene, options.importer)?;
        row.cpu_seconds = row.cpu_seconds.min(again.cpu_seconds);
        row.wall_seconds = row.wall_seconds.min(again.wall_seconds);
    }
    let text = serde_json::to_string(&row).expect("numbers and text can be written");
    console::print(&text).map_err(|source| {
        CommandError::Run(RunError::File { verb: "write to", path: "standard output".into(), source })
    })
}

fn run_scene(scene: &Scene, importer: CouplingVariant) -> Result<TradeRow, CommandError> {
    let (cpu, wall) = (ProcessTime::now(), Instant::now());
    let mut simulation = job::build_simulation(scene, importer.mode(), 1)?;
    let start = Vector3::from(scene.projectile.velocity) - simulation.block_motion().velocity;
    let failure = importer::run_simulation(&mut simulation, scene, importer).err().map(|error| error.to_string());
    let (cpu_seconds, wall_seconds) = (cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64());
    let observation = simulation.observe();
    let row = TradeRow::from_observation(&observation, &start, failure);
    Ok(TradeRow { cpu_seconds, wall_seconds, digest: format!("{:032x}", simulation.digest()), ..row })
}

impl TradeRow {
    /// Creates a row; `start` is the velocity of the projectile relative to the block at the start, m/s.
    fn from_observation(observation: &Observation, start: &Vector3, failure: Option<String>) -> Self {
        let contact = &observation.projectile().contact;
        let velocity = observation.projectile().kinematics.velocity - observation.block.velocity;
        let duration = contact.first.zip(contact.last).map(|(first, last)| last - first);
        Self {
            end_time: observation.time,
            elements: observation.cost.elements,
            remeshes: observation.cost.remeshes,
            element_updates: observation.cost.element_updates,
            cpu_seconds: 0.0,
            wall_seconds: 0.0,
            peak_depth: contact.peak_depth.0,
            contact_duration: duration.filter(|_| output::rebound(observation, *start).is_some()),
            final_speed: start.try_normalize(0.0).map_or(0.0, |way| -velocity.dot(&way)),
            initial_speed: start.norm(),
            peak_force: contact.peak_force,
            energy_defect: observation.energy.energy_defect,
            digest: String::new(),
            failure,
        }
    }
}
