//! What calls of the packed FMU cost, as an importer makes them.

use super::Measurement;
use super::scenes::{awake, size};
use super::settings::Settings;
use super::spent::{Effort, Spent};
use super::table::Row;
use crate::failure::Failure;
use crate::job::RunError;
use crate::options::SectionName;
use crate::source;
use crate::through_fmu::Importer;
use ballistic_gel::fmi2::LoadedState;
use ballistic_gel::scene::Override;
use serde_json::Value;

/// Communication step, s.
const STEP: f64 = 1e-5;
/// End of the experiment, s: further than any repetition goes.
const END: f64 = 100.0;
/// So long the gel that is to be saved has moved, s.
const MOVED: f64 = 1e-4;

/// An instance and how far it is, s.
struct Instance {
    importer: Importer,
    now: f64,
}

pub fn plan(settings: &Settings) -> Vec<Measurement> {
    let (n, effort) = (
        if settings.quick { settings.largest() } else { settings.elements[settings.elements.len() / 2] },
        settings.effort,
    );
    let cost = if settings.quick { 1.0 } else { 10.0 };
    let of = |what: &str, go: fn(usize, Effort) -> Result<Vec<Row>, Failure>| Measurement {
        section: SectionName::Calls,
        what: format!("{what}, {n} elements"),
        cost,
        go: Box::new(move || go(n, effort)),
    };
    vec![of("idle", idle), of("state", state)]
}

/// A gel at rest, far from the ball.
fn idle(n: usize, effort: Effort) -> Result<Vec<Row>, Failure> {
    let far = ("projectile.position", "[0.0, 0.0, 1.0]".to_owned());
    let mut it = Instance::new(&[size(n), far, ("projectile.velocity", "[0.0, 0.0, 0.0]".to_owned())])?;
    it.step(10.0 * STEP)?;
    let step = timed(effort, || it.step(STEP))?;
    let outputs = it.importer.outputs();
    let mut values = vec![0.0; outputs.len()];
    let get = timed(effort, || it.importer.check("fmi2GetReal", it.importer.fmu.get_reals(&outputs, &mut values)))?;
    let both = timed(effort, || {
        it.step(STEP)?;
        it.importer.check("fmi2GetReal", it.importer.fmu.get_reals(&outputs, &mut values))
    })?;
    let all = format!("fmi2GetReal of all {} outputs", outputs.len());
    Ok(vec![
        row("fmi2DoStep, nothing moves", step, None),
        row(&format!("{all}, again"), get, None),
        row(&format!("fmi2DoStep, nothing moves, and {all}"), both, None),
    ])
}

/// A gel that moves, saved and restored.
fn state(n: usize, effort: Effort) -> Result<Vec<Row>, Failure> {
    let mut it = Instance::new(&[size(n), awake()])?;
    it.step(MOVED)?;
    let Importer { fmu, .. } = &it.importer;
    let check = |call, status| it.importer.check(call, status);
    let mut kept = LoadedState::default();
    check("fmi2GetFMUstate", fmu.get_state(&mut kept))?;
    let mut size = 0;
    check("fmi2SerializedFMUstateSize", fmu.state_size(&kept, &mut size))?;
    let mut bytes = vec![0; size];
    let made = timed(effort, || {
        let mut new = LoadedState::default();
        check("fmi2GetFMUstate", fmu.get_state(&mut new))?;
        check("fmi2FreeFMUstate", fmu.free_state(&mut new))
    })?;
    let got = timed(effort, || check("fmi2GetFMUstate", fmu.get_state(&mut kept)))?;
    let set = timed(effort, || check("fmi2SetFMUstate", fmu.set_state(&kept)))?;
    let written = timed(effort, || check("fmi2SerializeFMUstate", fmu.write_state(&kept, &mut bytes)))?;
    let read = timed(effort, || check("fmi2DeSerializeFMUstate", fmu.read_state(&bytes, &mut kept)))?;
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

impl Instance {
    fn new(keys: &[(&str, String)]) -> Result<Self, Failure> {
        let overrides: Vec<Override> =
            keys.iter().map(|(key, value)| Override { key: (*key).to_owned(), value: value.clone() }).collect();
        let source = source::load("sphere-block", &overrides)?;
        let importer = Importer::new((&source.text, &source.folder), &source.scene, "bench")?;
        importer.initialize(1, END)?;
        Ok(Self { importer, now: 0.0 })
    }

    fn step(&mut self, length: f64) -> Result<(), RunError> {
        self.importer.check("fmi2DoStep", self.importer.fmu.do_step(self.now, length, false))?;
        self.now += length;
        Ok(())
    }
}

/// What one call takes, or the first error.
fn timed(effort: Effort, mut call: impl FnMut() -> Result<(), RunError>) -> Result<Spent, RunError> {
    let mut all = Ok(());
    let spent = Spent::per_turn(effort, || {
        if all.is_ok() {
            all = call();
        }
    });
    all.map(|()| spent)
}

fn row(call: &str, spent: Spent, bytes: Option<usize>) -> Row {
    let rate = bytes.map_or(Value::Null, |bytes| (bytes as f64 / spent.cpu / 1e9).into());
    Row::default()
        .with("call", call)
        .with("cpu_us", spent.cpu * 1e6)
        .with("wall_us", spent.wall * 1e6)
        .with("state_bytes", bytes)
        .with("gigabytes_per_cpu_s", rate)
}
