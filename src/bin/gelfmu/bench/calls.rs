//! Cost of the FMI calls of the packed FMU, made like those of an importer.

use super::Measurement;
use super::options::SectionName;
use super::scenes::{cell_size, drifting_gel, new_override};
use super::settings::BenchSettings;
use super::spent::{MeasuredTime, RepeatPolicy};
use super::table::BenchRow;
use crate::failure::{CommandError, RunError};
use crate::source;
use crate::through_fmu::FmuImporter;
use ballistic_gel::fmi2::LoadedState;
use ballistic_gel::scene::Override;
use serde_json::Value;

/// Communication step, s.
const COMMUNICATION_STEP: f64 = 1e-5;
/// End of the experiment, s: beyond every repetition.
const END_TIME: f64 = 100.0;
/// Simulated time before the state is saved, s.
const SETTLING_TIME: f64 = 1e-4;

/// FMU instance and its current time, s.
struct TimedInstance {
    importer: FmuImporter,
    now: f64,
}

/// Plans the measurements of an idle and of a moving gel.
pub fn plan(settings: &BenchSettings) -> Vec<Measurement> {
    let (n, policy) = (
        if settings.quick { settings.largest() } else { settings.elements[settings.elements.len() / 2] },
        settings.policy,
    );
    let cost = if settings.quick { 1.0 } else { 10.0 };
    let measurement = |what: &str, go: fn(usize, RepeatPolicy) -> Result<Vec<BenchRow>, CommandError>| Measurement {
        section: SectionName::Calls,
        what: format!("{what}, {n} elements"),
        cost,
        go: Box::new(move || go(n, policy)),
    };
    vec![measurement("idle", measure_idle), measurement("state", measure_state)]
}

/// Measures steps and outputs of a gel at rest, far from the ball.
fn measure_idle(n: usize, policy: RepeatPolicy) -> Result<Vec<BenchRow>, CommandError> {
    let far = new_override("projectile.position", "[0.0, 0.0, 1.0]");
    let at_rest = new_override("projectile.velocity", "[0.0, 0.0, 0.0]");
    let mut instance = TimedInstance::new(&[cell_size(n), far, at_rest])?;
    instance.step(10.0 * COMMUNICATION_STEP)?;
    let step = time_call(policy, || instance.step(COMMUNICATION_STEP))?;
    let outputs = instance.importer.outputs();
    let mut values = vec![0.0; outputs.len()];
    let get = time_call(policy, || {
        instance.importer.check("fmi2GetReal", instance.importer.fmu.get_reals(&outputs, &mut values))
    })?;
    let both = time_call(policy, || {
        instance.step(COMMUNICATION_STEP)?;
        instance.importer.check("fmi2GetReal", instance.importer.fmu.get_reals(&outputs, &mut values))
    })?;
    let all = format!("fmi2GetReal of all {} outputs", outputs.len());
    Ok(vec![
        row("fmi2DoStep, nothing moves", step, None),
        row(&format!("{all}, again"), get, None),
        row(&format!("fmi2DoStep, nothing moves, and {all}"), both, None),
    ])
}

/// Measures saving and restoring the state of a moving gel.
fn measure_state(n: usize, policy: RepeatPolicy) -> Result<Vec<BenchRow>, CommandError> {
    let mut instance = TimedInstance::new(&[cell_size(n), drifting_gel()])?;
    instance.step(SETTLING_TIME)?;
    let FmuImporter { fmu, .. } = &instance.importer;
    let check = |call, status| instance.importer.check(call, status);
    let mut kept = LoadedState::default();
    check("fmi2GetFMUstate", fmu.get_state(&mut kept))?;
    let mut size = 0;
    check("fmi2SerializedFMUstateSize", fmu.state_size(&kept, &mut size))?;
    let mut bytes = vec![0; size];
    let made = time_call(policy, || {
        let mut new = LoadedState::default();
        check("fmi2GetFMUstate", fmu.get_state(&mut new))?;
        check("fmi2FreeFMUstate", fmu.free_state(&mut new))
    })?;
    let got = time_call(policy, || check("fmi2GetFMUstate", fmu.get_state(&mut kept)))?;
    let set = time_call(policy, || check("fmi2SetFMUstate", fmu.set_state(&kept)))?;
    let written = time_call(policy, || check("fmi2SerializeFMUstate", fmu.write_state(&kept, &mut bytes)))?;
    let read = time_call(policy, || check("fmi2DeSerializeFMUstate", fmu.read_state(&bytes, &mut kept)))?;
    check("fmi2FreeFMUstate", fmu.free_state(&mut kept))?;
    let calls = [
        ("fmi2GetFMUstate and fmi2FreeFMUstate, a new one", made),
        ("fmi2GetFMUstate, into an old one", got),
        ("fmi2SetFMUstate", set),
        ("fmi2SerializeFMUstate", written),
        ("fmi2DeSerializeFMUstate, into an old one", read),
    ];
    Ok(calls.map(|(call, spent)| row(call, spent, Some(size))).into())
}

impl TimedInstance {
    fn new(overrides: &[Override]) -> Result<Self, CommandError> {
        let source = source::load("sphere-block", overrides)?;
        let importer = FmuImporter::new(&source, "bench")?;
        importer.initialize(1, END_TIME)?;
        Ok(Self { importer, now: 0.0 })
    }

    fn step(&mut self, length: f64) -> Result<(), RunError> {
        self.importer.check("fmi2DoStep", self.importer.fmu.do_step(self.now, length, false))?;
        self.now += length;
        Ok(())
    }
}

/// Measures a call; returns the first error.
fn time_call(policy: RepeatPolicy, mut call: impl FnMut() -> Result<(), RunError>) -> Result<MeasuredTime, RunError> {
    let mut outcome = Ok(());
    let spent = MeasuredTime::per_turn(policy, || {
        if outcome.is_ok() {
            outcome = call();
        }
    });
    outcome.map(|()| spent)
}

fn row(call: &str, spent: MeasuredTime, bytes: Option<usize>) -> BenchRow {
    let rate = bytes.map_or(Value::Null, |bytes| (bytes as f64 / spent.cpu.least / 1e9).into());
    BenchRow::new(call, spent.cpu.least * 1e6, "µs of CPU time")
        .spread(spent.cpu.spread())
        .with("call", call)
        .with("cpu_us", spent.cpu.least * 1e6)
        .with("wall_us", spent.wall.least * 1e6)
        .with("state_bytes", bytes)
        .with("gigabytes_per_cpu_s", rate)
}
