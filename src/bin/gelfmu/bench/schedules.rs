//! Comparison of schedules on uniform and graded meshes: bins, the queue and one global stable step.

use super::Measurement;
use super::scenes::{load_scene, new_override, new_simulation, step_to};
use super::settings::BenchSettings;
use super::spent::{MeasuredTime, RepeatPolicy};
use super::table::BenchRow;
use crate::failure::CommandError;
use crate::options::SectionName;

/// Fraction of the stable step for all schedules.
const CFL: f64 = 0.8;
/// End of the runs, s.
const END: f64 = 1e-3;
const QUICK_END: f64 = 0.1e-3;
/// Repetitions: a run is long, and a second one shows disturbances by other processes.
const REPEATS: usize = 2;

/// Meshes with the approximate seconds of their runs.
const MESHES: [(&str, f64); 4] =
    [("sphere-block", 2.0), ("sphere-graded-4", 2.0), ("sphere-graded-8", 6.0), ("sphere-graded-16", 25.0)];
const SCHEDULES: [&str; 3] = ["bins", "queue", "global"];

/// Plans one measurement for each mesh and schedule.
pub fn plan(settings: &BenchSettings) -> Vec<Measurement> {
    let meshes = if settings.quick { &MESHES[..2] } else { &MESHES[..] };
    let end = if settings.quick { QUICK_END } else { END };
    let pairs = meshes.iter().flat_map(|mesh| SCHEDULES.map(|schedule| (*mesh, schedule)));
    let quick = settings.quick;
    let measurement = |((mesh, cost), schedule): ((&'static str, f64), &'static str)| Measurement {
        section: SectionName::Schedules,
        what: format!("{mesh}, {schedule}"),
        cost: if quick { 0.1 } else { cost },
        go: Box::new(move || Ok(vec![measure(mesh, schedule, end)?])),
    };
    pairs.map(measurement).collect()
}

fn measure(mesh: &'static str, schedule: &'static str, end: f64) -> Result<BenchRow, CommandError> {
    let overrides =
        [new_override("integrator.schedule", format!("{schedule:?}")), new_override("integrator.cfl", CFL.to_string())];
    let scene = load_scene(mesh, &overrides)?;
    let (mut ended, mut last) = (Ok(()), None);
    let policy = RepeatPolicy { repeats: REPEATS, seconds: 0.0 };
    let begin = || new_simulation(&scene, 1);
    let spent = MeasuredTime::least(policy, begin, |simulation| {
        ended = simulation.and_then(|mut simulation| {
            step_to(&mut simulation, end)?;
            last = Some(simulation.observe());
            Ok(())
        });
    });
    ended?;
    let cost = last.expect("a run that has ended was looked at").cost;
    Ok(BenchRow::default()
        .with("mesh", mesh)
        .with("elements", cost.elements)
        .with("schedule", schedule)
        .with("million_updates", cost.element_updates / 1e6)
        .with("cpu_s", spent.cpu)
        .with("million_per_cpu_s", cost.element_updates / spent.cpu / 1e6)
        .with("of_one_assembled_step", cost.element_updates / cost.synchronous_updates)
        .and("updates", cost.element_updates)
        .and("synchronous_updates", cost.synchronous_updates)
        .and("wall_s", spent.wall)
        .and("end_s", end))
}
