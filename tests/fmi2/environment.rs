//! The floating-point environment of the importer: it changes no bit, kills nobody, and is there again afterwards.

use super::host::{OK, Resources};
use ballistic_gel::fmi2::abi::*;
use ballistic_gel::fmi2::{CallbackFunctions, LoggerCallback};
use ballistic_gel::scene;
use std::arch::asm;
use std::ffi::{c_char, c_int, c_void};
use std::ptr;

/// MXCSR of four importers. The first has an exception flag set, and no trap on it.
const ENVIRONMENTS: [(&str, u32); 4] = [
    ("the default", 0x1FA0),
    ("rounding upwards", 0x5F80),
    ("subnormal numbers flushed to zero", 0x9FC0),
    ("all traps enabled", 0x0000),
];

/// Length of a communication step, s.
const STEP: f64 = 1.0 / 8192.0;

fn mxcsr() -> u32 {
    let mut value = 0_u32;
    // SAFETY: writes four bytes.
    unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut value) };
    value
}

fn set_mxcsr(value: u32) {
    // SAFETY: reads four bytes; no reserved bit is set.
    unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const value) };
}

/// An importer with an environment, and those in which its logger was called.
struct Importer {
    component: *mut c_void,
    environment: u32,
    #[allow(clippy::box_collection)] // its address is handed out
    logged_in: Box<Vec<u32>>,
}

unsafe extern "C" fn note(
    environment: *mut c_void,
    _name: *const c_char,
    _status: c_int,
    _category: *const c_char,
    _message: *const c_char,
) {
    // SAFETY: the list of an `Importer`.
    unsafe { (*environment.cast::<Vec<u32>>()).push(mxcsr()) };
}

/// Makes one call in an environment, which must be there afterwards.
fn within<R>(environment: u32, call: impl FnOnce() -> R) -> R {
    let ours = mxcsr();
    set_mxcsr(environment);
    let answer = call();
    let left = mxcsr();
    set_mxcsr(ours);
    assert_eq!(left, environment, "the environment afterwards");
    answer
}

impl Importer {
    fn new(environment: u32, archive: &Resources) -> Self {
        let mut logged_in = Box::new(vec![]);
        let note = note as *const ();
        let callbacks = CallbackFunctions {
            // SAFETY: on the platforms of the tests, fixed arguments are passed alike with and without an ellipsis.
            logger: Some(unsafe { std::mem::transmute::<*const (), LoggerCallback>(note) }),
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            environment: ptr::from_mut(&mut *logged_in).cast(),
        };
        let (name, guid, at) = (c"gel".as_ptr(), archive.guid.as_ptr(), archive.uri.as_ptr());
        // SAFETY: texts and callbacks.
        let component =
            within(environment, || unsafe { fmi2Instantiate(name, 1, guid, at, &raw const callbacks, 0, 1) });
        assert!(!component.is_null());
        Self { component, environment, logged_in }
    }

    fn call(&self, call: impl FnOnce(*mut c_void) -> c_int) {
        assert_eq!(within(self.environment, || call(self.component)), OK);
    }

    /// The run: two threads, steps, a state and its bytes. Returns these.
    fn run(&self) -> Vec<u8> {
        // SAFETY: a live component, and one value for one reference.
        unsafe {
            let threads = super::host::reference("threads");
            self.call(|c| fmi2SetInteger(c, &raw const threads, 1, &2));
            self.call(|c| fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0));
            self.call(|c| fmi2EnterInitializationMode(c));
            self.call(|c| fmi2ExitInitializationMode(c));
            for k in 0..8 {
                let from = f64::from(k) * STEP;
                self.call(|c| fmi2DoStep(c, from, STEP, 0));
            }
            let depth = super::host::reference("contact.penetration");
            let mut value = 0.0;
            self.call(|c| fmi2GetReal(c, &raw const depth, 1, &raw mut value));
            self.bytes()
        }
    }

    fn bytes(&self) -> Vec<u8> {
        let (mut state, mut again, mut size) = (ptr::null_mut(), ptr::null_mut(), 0);
        // SAFETY: a live component, states of it, and a buffer of the size asked for.
        unsafe {
            self.call(|c| fmi2GetFMUstate(c, &raw mut state));
            self.call(|c| fmi2SerializedFMUstateSize(c, state, &raw mut size));
            let mut bytes = vec![0; size];
            self.call(|c| fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size));
            self.call(|c| fmi2DeSerializeFMUstate(c, bytes.as_ptr(), size, &raw mut again));
            self.call(|c| fmi2SetFMUstate(c, again));
            self.call(|c| fmi2FreeFMUstate(c, &raw mut again));
            self.call(|c| fmi2FreeFMUstate(c, &raw mut state));
            bytes
        }
    }

    /// Ends the run; the environments in which lines were logged.
    fn end(self) -> Vec<u32> {
        // SAFETY: a live component, freed once.
        unsafe {
            self.call(|c| fmi2Terminate(c));
            self.call(|c| fmi2Reset(c));
            within(self.environment, || fmi2FreeInstance(self.component));
        }
        *self.logged_in
    }
}

#[test]
fn four_environments_give_the_same_bits_and_are_found_again() {
    let archive = Resources::packed(scene::builtin("sphere-block").unwrap(), &[]);
    let runs = ENVIRONMENTS.map(|(name, environment)| {
        let importer = Importer::new(environment, &archive);
        let bytes = importer.run();
        let logged_in = importer.end();
        assert!(!logged_in.is_empty() && logged_in.iter().all(|found| *found == environment), "{name}: {logged_in:x?}");
        (name, bytes)
    });
    for (name, bytes) in &runs[1..] {
        assert!(*bytes == runs[0].1, "{name} changes bits");
    }
}
