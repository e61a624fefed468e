//! Which call is allowed when, every function of an instance but the one that frees it, the illegal ones included.

use super::host::{ERROR, Host, coarse};
use ballistic_gel::fmi2::abi::*;
use std::ffi::{c_int, c_void};
use std::ptr;

/// A function with arguments that are good if it is allowed at all.
type Row = (&'static str, fn(*mut c_void) -> c_int, [bool; 5]);

const YES: bool = true;
const NO: bool = false;

/// Columns: instantiated, initialization mode, step complete, step failed, terminated.
const TABLE: [Row; 29] = [
    ("SetDebugLogging", |c| unsafe { fmi2SetDebugLogging(c, 1, 0, ptr::null()) }, [YES; 5]),
    ("SetupExperiment", |c| unsafe { fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) }, [YES, NO, NO, NO, NO]),
    ("EnterInitializationMode", |c| unsafe { fmi2EnterInitializationMode(c) }, [YES, NO, NO, NO, NO]),
    ("ExitInitializationMode", |c| unsafe { fmi2ExitInitializationMode(c) }, [NO, YES, NO, NO, NO]),
    ("Terminate", |c| unsafe { fmi2Terminate(c) }, [NO, NO, YES, YES, NO]),
    ("Reset", |c| unsafe { fmi2Reset(c) }, [YES; 5]),
    ("GetReal", |c| unsafe { fmi2GetReal(c, ptr::null(), 0, ptr::null_mut()) }, [NO, YES, YES, YES, YES]),
    ("GetInteger", |c| unsafe { fmi2GetInteger(c, ptr::null(), 0, ptr::null_mut()) }, [NO, YES, YES, YES, YES]),
    ("GetBoolean", |c| unsafe { fmi2GetBoolean(c, ptr::null(), 0, ptr::null_mut()) }, [NO, YES, YES, YES, YES]),
    ("GetString", |c| unsafe { fmi2GetString(c, ptr::null(), 0, ptr::null_mut()) }, [NO, YES, YES, YES, YES]),
    ("SetReal", |c| unsafe { fmi2SetReal(c, ptr::null(), 0, ptr::null()) }, [YES, YES, YES, NO, NO]),
    ("SetInteger", |c| unsafe { fmi2SetInteger(c, ptr::null(), 0, ptr::null()) }, [YES, YES, YES, NO, NO]),
    ("SetBoolean", |c| unsafe { fmi2SetBoolean(c, ptr::null(), 0, ptr::null()) }, [YES, YES, YES, NO, NO]),
    ("SetString", |c| unsafe { fmi2SetString(c, ptr::null(), 0, ptr::null()) }, [YES, YES, YES, NO, NO]),
    ("GetFMUstate", get_and_free_state, [YES; 5]),
    ("SetFMUstate", set_state, [YES; 5]),
    ("SerializedFMUstateSize", |c| unsafe { fmi2SerializedFMUstateSize(c, nothing(), ptr::null_mut()) }, [YES; 5]),
    ("SerializeFMUstate", |c| unsafe { fmi2SerializeFMUstate(c, nothing(), ptr::null_mut(), 0) }, [YES; 5]),
    ("DeSerializeFMUstate", |c| unsafe { fmi2DeSerializeFMUstate(c, ptr::null(), 0, ptr::null_mut()) }, [YES; 5]),
    ("GetStatus", |c| unsafe { fmi2GetStatus(c, 0, &mut 0) }, [YES; 5]),
    ("GetRealStatus", |c| unsafe { fmi2GetRealStatus(c, 2, &mut 0.0) }, [YES; 5]),
    ("GetIntegerStatus", |c| unsafe { fmi2GetIntegerStatus(c, 0, &mut 0) }, [YES; 5]),
    ("GetBooleanStatus", |c| unsafe { fmi2GetBooleanStatus(c, 3, &mut 0) }, [YES; 5]),
    ("GetStringStatus", |c| unsafe { fmi2GetStringStatus(c, 1, &mut ptr::null()) }, [YES; 5]),
    ("GetDirectionalDerivative", directional, [NO, YES, YES, YES, YES]),
    ("SetRealInputDerivatives", input_rates, [YES, YES, YES, NO, NO]),
    ("GetRealOutputDerivatives", output_rates, [NO, NO, YES, YES, YES]),
    ("CancelStep", |c| unsafe { fmi2CancelStep(c) }, [NO; 5]),
    ("DoStep", |c| unsafe { fmi2DoStep(c, 0.0, 1e-6, 0) }, [NO, NO, YES, YES, NO]),
];

fn get_and_free_state(c: *mut c_void) -> c_int {
    let mut state = ptr::null_mut();
    unsafe { fmi2GetFMUstate(c, &raw mut state).max(fmi2FreeFMUstate(c, &raw mut state)) }
}

fn set_state(c: *mut c_void) -> c_int {
    let mut state = ptr::null_mut();
    unsafe {
        assert_eq!(fmi2GetFMUstate(c, &raw mut state), 0);
        let status = fmi2SetFMUstate(c, state);
        assert_eq!(fmi2FreeFMUstate(c, &raw mut state), 0);
        status
    }
}

/// What is refused where a state is expected, but not for its order.
fn nothing() -> *mut c_void {
    ptr::null_mut()
}

fn directional(c: *mut c_void) -> c_int {
    let (none, nowhere) = (ptr::null(), ptr::null_mut());
    unsafe { fmi2GetDirectionalDerivative(c, none, 0, none, 0, ptr::null(), nowhere) }
}

fn input_rates(c: *mut c_void) -> c_int {
    unsafe { fmi2SetRealInputDerivatives(c, ptr::null(), 0, ptr::null(), ptr::null()) }
}

fn output_rates(c: *mut c_void) -> c_int {
    unsafe { fmi2GetRealOutputDerivatives(c, ptr::null(), 0, ptr::null(), ptr::null_mut()) }
}

/// A fresh instance in each phase.
fn in_phase(phase: usize) -> Host {
    let mut host = if phase == 3 { failed() } else { Host::with(&coarse()) };
    match phase {
        1 => host.enter(),
        2 | 4 => host.start(),
        _ => {}
    }
    if phase == 4 {
        assert_eq!(unsafe { fmi2Terminate(host.c) }, 0);
    }
    host.lines();
    host
}

/// An instance whose mesh could not follow.
pub fn failed() -> Host {
    let mut host = Host::with(&coarse().replace("-5.0]", "-2000.0]"));
    host.start();
    for k in 0..100 {
        let status = unsafe { fmi2DoStep(host.c, f64::from(k) * 1e-6, 1e-6, 0) };
        if status != 0 {
            assert_eq!(status, super::host::DISCARD, "{:?}", host.lines());
            return host;
        }
    }
    panic!("the mesh followed a ball at 2 km/s");
}

#[test]
fn each_call_is_allowed_exactly_where_the_table_says() {
    for (name, call, allowed) in TABLE {
        for (phase, expected) in allowed.into_iter().enumerate() {
            let mut host = in_phase(phase);
            let status = call(host.c);
            let lines = host.lines();
            let refused = lines.iter().any(|l| l.2.contains("is not allowed now"));
            assert_eq!(refused, !expected, "fmi2{name} in phase {phase}: status {status}, {lines:?}");
            if refused {
                assert_eq!((status, lines.len()), (ERROR, 1), "fmi2{name} in phase {phase}");
                assert!(lines[0].2.starts_with(&format!("fmi2{name} ")), "{lines:?}");
            }
        }
    }
}

#[test]
fn a_refused_call_leaves_the_instance_as_it_was() {
    let mut host = Host::started();
    let before = host.bytes();
    assert_eq!(unsafe { fmi2EnterInitializationMode(host.c) }, ERROR);
    assert_eq!(unsafe { fmi2SetupExperiment(host.c, 0, 0.0, 0.0, 0, 0.0) }, ERROR);
    assert_eq!(host.bytes(), before);
    host.steps(0.0, 1e-5, 2);
}
