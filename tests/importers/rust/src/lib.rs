//! Parts of the programs that each drive a packed FMU in one importer; `tests/importers/run.py` calls the programs.
//!
//! `PROGRAM FMU STEP STEPS FOLDER` writes the bits of the watched values to FOLDER/values, and the serialised state to
//! FOLDER/state. Everything that is printed is a message of the importer about the archive.

use std::{env, error::Error, fs, path::PathBuf, process::ExitCode};

/// Variables that every importer reads after the last step.
pub const WATCHED: [&str; 2] = ["contact.total_impulse[3]", "projectile.predicted_velocity[3]"];

/// Archive, and communication steps to take.
pub struct Drive {
    /// Path of the packed FMU.
    pub archive: PathBuf,
    /// Communication step, s.
    pub step: f64,
    steps: u32,
}

impl Drive {
    /// Returns the start times of the communication steps.
    pub fn times(&self) -> impl Iterator<Item = f64> {
        let step = self.step;
        (0..self.steps).map(move |number| f64::from(number) * step)
    }
}

/// Values of the watched variables and the serialised state after the last step.
pub struct Outcome {
    /// Values in the order of `WATCHED`.
    pub values: [f64; 2],
    /// Bytes of fmi2SerializeFMUstate.
    pub state: Vec<u8>,
}

/// Logger of the `log` crate: prints warnings and errors.
struct Printer;

impl log::Log for Printer {
    fn enabled(&self, metadata: &log::Metadata) -> bool {
        metadata.level() <= log::Level::Warn
    }

    fn log(&self, record: &log::Record) {
        if self.enabled(record.metadata()) {
            eprintln!("{} {}", record.level(), record.args());
        }
    }

    fn flush(&self) {}
}

/// Importer: drives the archive to its outcome.
type Importer = fn(&Drive) -> Result<Outcome, Box<dyn Error>>;

fn run(importer: Importer) -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [archive, step, steps, folder] = &arguments[..] else {
        return Err("found wrong arguments, expected FMU STEP STEPS FOLDER".into());
    };
    log::set_logger(&Printer)?;
    log::set_max_level(log::LevelFilter::Warn);
    let outcome = importer(&Drive { archive: archive.into(), step: step.parse()?, steps: steps.parse()? })?;
    let folder = PathBuf::from(folder);
    fs::write(folder.join("state"), &outcome.state)?;
    fs::write(folder.join("values"), outcome.values.map(|value| format!("{:016x}", value.to_bits())).join(" "))?;
    Ok(())
}

/// Runs the importer on the arguments of the program, and prints an error.
pub fn main_with(importer: Importer) -> ExitCode {
    match run(importer) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
