//! The crate `fmi-rs` (CATIA-Systems), with its validation of the model description.

use std::{error::Error, process::ExitCode, ptr};

use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::fmi2::types::{fmi2False, fmi2Status};

use ballistic_gel_importers::{Drive, Outcome, WATCHED, main_with};

/// Returns an error unless the call of the function succeeded.
fn check(function: &str, status: fmi2Status) -> Result<(), String> {
    if status == fmi2Status::Ok { Ok(()) } else { Err(format!("{function}: found {status:?}, expected fmi2OK")) }
}

/// Validates, unpacks, instantiates and steps the archive.
fn drive(drive: &Drive) -> Result<Outcome, Box<dyn Error>> {
    let builder = FMU2Builder::new(&drive.archive)?;
    let description = &builder.model_description;
    let problems: Vec<String> = description.validate().into_iter().map(|problem| problem.message).collect();
    if !problems.is_empty() {
        return Err(format!("modelDescription.xml: {}", problems.join("\n")).into());
    }
    let mut references = [0; 2];
    for (reference, name) in references.iter_mut().zip(WATCHED) {
        *reference = description.variable_by_name(name)?.valueReference;
    }
    let gel = builder.instantiate_cs("gel")?;
    check("fmi2SetupExperiment", gel.setupExperiment(None, 0.0, None))?;
    check("fmi2EnterInitializationMode", gel.enterInitializationMode())?;
    check("fmi2ExitInitializationMode", gel.exitInitializationMode())?;
    for time in drive.times() {
        check("fmi2DoStep", gel.doStep(time, drive.step, fmi2False))?;
    }
    let mut values = [0.0; 2];
    check("fmi2GetReal", gel.getReal(&references, &mut values))?;
    let (mut pointer, mut size) = (ptr::null_mut(), 0);
    check("fmi2GetFMUstate", gel.getFMUstate(&raw mut pointer))?;
    check("fmi2SerializedFMUstateSize", gel.serializedFMUstateSize(pointer, &mut size))?;
    let mut state = vec![0; size];
    check("fmi2SerializeFMUstate", gel.serializeFMUstate(pointer, &mut state))?;
    check("fmi2FreeFMUstate", gel.freeFMUstate(&raw mut pointer))?;
    check("fmi2Terminate", gel.terminate())?;
    Ok(Outcome { values, state })
}

fn main() -> ExitCode {
    main_with(drive)
}
