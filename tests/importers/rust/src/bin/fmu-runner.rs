//! The crate `fmu-runner`.

use std::{error::Error, process::ExitCode};

use fmu_runner::{Fmu, FmuInstance, fmi2Type, model_description::ScalarVariable};

use ballistic_gel_importers::{Drive, Outcome, WATCHED, main_with};

/// Unpacks, instantiates and steps the archive.
fn drive(drive: &Drive) -> Result<Outcome, Box<dyn Error>> {
    let library = Fmu::unpack(&drive.archive)?.load(fmi2Type::fmi2CoSimulation)?;
    let find = |name: &str| library.variables().get(name).ok_or_else(|| format!("{name}: not among the variables"));
    let watched: [&ScalarVariable; 2] = [find(WATCHED[0])?, find(WATCHED[1])?];
    let gel = FmuInstance::instantiate(&library, false)?;
    gel.setup_experiment(0.0, None, None)?;
    gel.enter_initialization_mode()?;
    gel.exit_initialization_mode()?;
    for time in drive.times() {
        gel.do_step(time, drive.step, false)?;
    }
    let values = gel.get_reals(&watched)?;
    let serializer = gel.serialize_state_capability().ok_or("canSerializeFMUstate: found false, expected true")?;
    let state =
        gel.get_set_state_capability().ok_or("canGetAndSetFMUstate: found false, expected true")?.get_state()?;
    Ok(Outcome { values: watched.map(|variable| values[variable]), state: serializer.serialize_state(&state)? })
}

fn main() -> ExitCode {
    main_with(drive)
}
