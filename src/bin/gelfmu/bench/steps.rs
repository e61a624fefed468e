//! Whole step with contact: a block that moves everywhere while the ball presses into timing.

use super::Measurement;
use super::options::{ElementName, SectionName};
use super::scenes::{cell_size, drifting_gel, element_kind, load_scene, new_simulation, step_to};
use super::settings::{BenchMesh, BenchSettings};
use super::spent::{MeasuredTime, RepeatPolicy};
use super::table::BenchRow;
use super::threads::ThreadTimes;
use crate::failure::CommandError;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::Simulation;

/// Time of the measurement, s: at 5 m/s the ball is 5 mm deep; quick, 1 mm.
const IN_CONTACT: f64 = 1e-3;
const QUICK_IN_CONTACT: f64 = 0.2e-3;
/// Element updates of one repetition, and the least and greatest number of its steps.
const UPDATES_PER_REPETITION: usize = 4_000_000;
const STEP_RANGE: (usize, usize) = (4, 60);

/// Block to measure.
#[derive(Debug, Clone, Copy)]
pub struct MeasuredBlock {
    /// Approximate number of elements.
    pub n_elements: usize,
    /// Kind of elements.
    pub kind: ElementName,
    /// Time of the measurement, s.
    pub from: f64,
}

impl MeasuredBlock {
    /// Creates a block with the ball.
    pub fn new(mesh: BenchMesh, settings: &BenchSettings) -> Self {
        let from = if settings.quick { QUICK_IN_CONTACT } else { IN_CONTACT };
        Self { n_elements: mesh.n_elements, kind: mesh.kind, from }
    }

    fn scene(&self) -> Result<Scene, CommandError> {
        load_scene("sphere-block", &[drifting_gel(), cell_size(self.n_elements), element_kind(self.kind)])
    }
}

/// Measured steps of one run, by a number of threads.
pub struct StepTiming {
    /// Number of threads.
    pub threads: usize,
    /// Element updates.
    pub updates: f64,
    /// Wall-clock and CPU time.
    pub spent: MeasuredTime,
    /// CPU time of the caller and of the busiest other thread, s; `None` if the system does not report thread times.
    pub path: Option<f64>,
    /// Hash of the final state.
    pub digest: u128,
    /// Number of elements of the block.
    pub n_elements: usize,
    /// Contact area, m².
    pub area: f64,
}

/// Plans one measurement for each mesh.
pub fn plan(settings: &BenchSettings) -> Vec<Measurement> {
    let (policy, counts) = (settings.policy, settings.thread_counts());
    let measurement = |mesh: BenchMesh| {
        let (block, counts) = (MeasuredBlock::new(mesh, settings), counts.clone());
        Measurement {
            section: SectionName::Steps,
            what: mesh.describe(),
            cost: if settings.quick { 0.5 } else { 2.0 + mesh.n_elements as f64 * 2e-5 },
            go: Box::new(move || Ok(rows(mesh.kind, &measure(&block, &counts, policy)?))),
        }
    };
    settings.meshes().into_iter().map(measurement).collect()
}

/// Measures the same steps from the same state by each number of threads in turn, repeatedly.
pub fn measure(block: &MeasuredBlock, counts: &[usize], policy: RepeatPolicy) -> Result<Vec<StepTiming>, CommandError> {
    let scene = block.scene()?;
    let mut all =
        counts.iter().map(|threads| new_simulation(&scene, *threads)).collect::<Result<Vec<Simulation>, _>>()?;
    let fastest = all.len() - 1;
    step_to(&mut all[fastest], block.from)?;
    let saved = all[fastest].save();
    let cost = all[fastest].observe().cost;
    let steps = (UPDATES_PER_REPETITION / cost.elements).clamp(STEP_RANGE.0, STEP_RANGE.1);
    let (settled, end) = (block.from + cost.largest_step, block.from + (steps + 1) as f64 * cost.largest_step);
    let mut timings: Vec<Option<StepTiming>> = counts.iter().map(|_| None).collect();
    for _ in 0..policy.repeats {
        for (i, simulation) in all.iter_mut().enumerate() {
            simulation.restore(&saved).map_err(|error| restore_failure(&error))?;
            step_to(simulation, settled)?;
            let found = measure_once(simulation, counts[i], end)?;
            timings[i] = Some(match timings[i].take() {
                Some(before) => found.union(&before),
                None => found,
            });
        }
    }
    Ok(timings.into_iter().flatten().collect())
}

impl StepTiming {
    /// Returns the range of the times of both.
    fn union(self, other: &Self) -> Self {
        let path = self.path.zip(other.path).map(|(a, b)| a.min(b));
        Self { spent: self.spent.union(other.spent), path, ..self }
    }
}

fn measure_once(simulation: &mut Simulation, threads: usize, end: f64) -> Result<StepTiming, CommandError> {
    let before = simulation.observe().cost.element_updates;
    let mut ended = Ok(());
    let threads_before = ThreadTimes::now();
    let spent = MeasuredTime::measure(|| ended = step_to(simulation, end));
    let path = ThreadTimes::now().zip(threads_before).map(|(after, before)| after.path_since(&before));
    ended?;
    let observed = simulation.observe();
    Ok(StepTiming {
        threads,
        updates: observed.cost.element_updates - before,
        spent,
        path,
        digest: simulation.digest(),
        n_elements: observed.cost.elements,
        area: observed.bodies[0].contact.area,
    })
}

fn restore_failure(error: &ballistic_gel::simulation::RestoreError) -> CommandError {
    CommandError::Run(crate::failure::RunError::Component { call: "Simulation::restore", reason: error.to_string() })
}

fn rows(kind: ElementName, all: &[StepTiming]) -> Vec<BenchRow> {
    let first = &all[0];
    let row = |timing: &StepTiming| {
        let (wall, cpu, is_same) = (timing.spent.wall, timing.spent.cpu, timing.digest == first.digest);
        let (n_elements, threads) = (timing.n_elements, timing.threads);
        let threads = if threads == 1 { "1 thread".to_owned() } else { format!("{threads} threads") };
        let bits = if is_same { "" } else { ", OTHER BITS" };
        let what = format!("steps of {n_elements} elements, {}, {threads}{bits}", kind.as_str());
        BenchRow::new(what, timing.updates / wall.least / 1e6, "million element updates per s")
            .spread(wall.spread())
            .with("elements", n_elements)
            .with("element", kind.as_str())
            .with("threads", timing.threads)
            .with("million_per_wall_s", timing.updates / wall.least / 1e6)
            .with("million_per_cpu_s", timing.updates / cpu.least / 1e6)
            .with("times_as_fast_as_one_thread", first.spent.wall.least / wall.least)
            .with("if_cores_were_free", first.path.zip(timing.path).map(|(one, all)| one / all))
            .with("same_bits", is_same)
            .with("updates", timing.updates)
            .with("wall_s", wall.least)
            .with("cpu_s", cpu.least)
            .with("path_cpu_s", timing.path)
            .with("contact_area_m2", timing.area)
    };
    all.iter().map(row).collect()
}
