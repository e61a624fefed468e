//! The crate `fmi` (rust-fmi).

use std::{error::Error, process::ExitCode};

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common};
use fmi::traits::{FmiImport, FmiInstance};

use ballistic_gel_importers::{Drive, Outcome, WATCHED, main_with};

/// Unpacks, instantiates and steps the archive.
fn drive(drive: &Drive) -> Result<Outcome, Box<dyn Error>> {
    let import: Fmi2Import = fmi::import::from_path(&drive.archive)?;
    let description = import.model_description();
    let mut references = [0; 2];
    for (reference, name) in references.iter_mut().zip(WATCHED) {
        *reference = description.model_variable_by_name(name)?.value_reference;
    }
    let mut gel = import.instantiate_cs("gel", false, false)?;
    FmiInstance::enter_initialization_mode(&mut gel, None, 0.0, None)?;
    FmiInstance::exit_initialization_mode(&mut gel)?;
    for time in drive.times() {
        gel.do_step(time, drive.step, false)?;
    }
    let mut values = [0.0; 2];
    gel.get_real(&references, &mut values)?;
    let state = gel.get_fmu_state()?;
    let state = gel.serialize_fmu_state(&state)?;
    FmiInstance::terminate(&mut gel)?;
    Ok(Outcome { values, state })
}

fn main() -> ExitCode {
    main_with(drive)
}
