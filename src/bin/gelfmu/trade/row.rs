//! One run of the ladder: what came out and what it cost. It has a process of its own, whose CPU time is nobody else's.

use super::importer::{self, Importer};
use crate::console;
use crate::failure::Failure;
use crate::job::{self, RunError};
use crate::options::RowOptions;
use crate::source;
use ballistic_gel::math::Vector3;
use ballistic_gel::output;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::Observation;
use cpu_time::ProcessTime;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// A finished run; SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Time that it reached, s.
    pub end_time: f64,
    /// Elements at the end.
    pub elements: usize,
    /// Exchanges of the mesh.
    pub remeshes: u64,
    /// Element updates.
    pub element_updates: f64,
    /// CPU time from the mesh to the last step, s.
    pub cpu_seconds: f64,
    /// The same on the wall, s.
    pub wall_seconds: f64,
    /// Greatest depth, m.
    pub peak_depth: f64,
    /// From the first to the last impulse, s; nothing while in contact.
    pub contact_duration: Option<f64>,
    /// Speed at the end against the velocity at the start, m/s: once it has left, the rebound.
    pub final_speed: f64,
    /// Speed at the start, m/s.
    pub initial_speed: f64,
    /// Greatest mean force over the window of the scene, N.
    pub peak_force: f64,
    /// The method's own error of the energy.
    pub energy_defect: f64,
    /// Hash of the stored state, 32 hexadecimal digits.
    pub digest: String,
    /// The diagnosis of a run that stopped early.
    pub failure: Option<String>,
}

/// Runs a scene file on one thread and prints the row.
pub fn print(options: &RowOptions) -> Result<(), Failure> {
    let scene = source::load_from(&options.scene, &options.folder)?;
    let mut row = run(&scene, options.importer)?;
    for _ in 1..options.repeat {
        let again = run(&scene, options.importer)?;
        row.cpu_seconds = row.cpu_seconds.min(again.cpu_seconds);
        row.wall_seconds = row.wall_seconds.min(again.wall_seconds);
    }
    let text = serde_json::to_string(&row).expect("numbers and text can be written");
    console::print(&text)
        .map_err(|source| Failure::Run(RunError::File { verb: "write to", path: "standard output".into(), source }))
}

fn run(scene: &Scene, importer: Importer) -> Result<Row, Failure> {
    let (cpu, wall) = (ProcessTime::now(), Instant::now());
    let mut simulation = job::built(scene, importer.mode(), 1)?;
    let failure = importer::drive(&mut simulation, scene, importer).err().map(|error| error.to_string());
    let (cpu_seconds, wall_seconds) = (cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64());
    let seen = simulation.observe();
    let row = Row::of(&seen, scene, failure);
    Ok(Row { cpu_seconds, wall_seconds, digest: format!("{:032x}", simulation.digest()), ..row })
}

impl Row {
    fn of(seen: &Observation, scene: &Scene, failure: Option<String>) -> Self {
        let (contact, start) = (&seen.projectile().contact, Vector3::from(scene.projectile.velocity));
        let lasted = contact.first.zip(contact.last).map(|(first, last)| last - first);
        Self {
            end_time: seen.time,
            elements: seen.cost.elements,
            remeshes: seen.cost.remeshes,
            element_updates: seen.cost.element_updates,
            cpu_seconds: 0.0,
            wall_seconds: 0.0,
            peak_depth: contact.peak_depth.0,
            contact_duration: lasted.filter(|_| output::rebound(seen, start).is_some()),
            final_speed: start.try_normalize(0.0).map_or(0.0, |way| -seen.projectile().kinematics.velocity.dot(&way)),
            initial_speed: start.norm(),
            peak_force: contact.peak_force,
            energy_defect: seen.energy.energy_defect,
            digest: String::new(),
            failure,
        }
    }
}
