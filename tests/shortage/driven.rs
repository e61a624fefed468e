//! The importer that the campaign drives into shortages of memory: every kind of call that takes much of it.

use super::shim::Shim;
use ballistic_gel::fmi2::abi::*;
use ballistic_gel::fmi2::{ArchiveManifest, CallbackFunctions, LoggerCallback, VariablePorts};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr;

/// Length of a communication step, s.
const STEP: f64 = 1e-4;
/// Steps before the state that is gone back to, and after it.
const STEPS: u32 = 3;

/// A call: its name, and the bytes by which most was held in it.
pub type Spent = (&'static str, i64);

/// How a run ended.
#[derive(Debug, PartialEq, Eq)]
pub enum Ending {
    /// All calls were done.
    Completed,
    /// A call was refused with these words, and done when it was repeated without a shortage.
    Refused(String),
}

/// What the logger is called with.
struct Listener<'a> {
    shim: &'a Shim,
    lines: Vec<String>,
}

/// An importer with one instance.
pub struct Driven<'a> {
    shim: &'a Shim,
    listener: Box<Listener<'a>>,
    component: *mut c_void,
    pub spent: Vec<Spent>,
    refused: Option<String>,
}

unsafe extern "C" fn listen(
    environment: *mut c_void,
    _name: *const c_char,
    status: c_int,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the listener of a `Driven`, and a text.
    let (listener, text) = unsafe { (&mut *environment.cast::<Listener<'_>>(), CStr::from_ptr(message)) };
    let Listener { shim, lines } = listener;
    if status > 1 {
        shim.spared(|| lines.push(text.to_string_lossy().into_owned()));
    }
}

fn reference(name: &str) -> u32 {
    VariablePorts::all().scalars().find(|scalar| scalar.name() == name).expect(name).reference()
}

impl<'a> Driven<'a> {
    pub fn new(shim: &'a Shim) -> Self {
        let listener = Box::new(Listener { shim, lines: vec![] });
        Self { shim, listener, component: ptr::null_mut(), spent: vec![], refused: None }
    }

    /// Makes a call; one that is refused is repeated once the shortage is over.
    fn call(&mut self, name: &'static str, call: impl Fn(*mut c_void) -> c_int) {
        let c = self.component;
        let (status, bytes) = self.shim.watched(|| call(c));
        self.spent.push((name, bytes));
        if status > 1 {
            let words = self.listener.lines.pop();
            assert!(self.refused.is_none(), "{name}: refused without a shortage: {words:?}");
            self.refused = Some(format!("{name}: {}", words.expect("a refusal has words")));
            self.shim.relieve();
            assert!(call(c) < 2, "{name}: not done when it was repeated: {:?}", self.listener.lines);
        }
    }

    fn instantiate(&mut self, resources: &Path) {
        let listen = listen as *const ();
        let callbacks = CallbackFunctions {
            // SAFETY: on the platforms of the tests, fixed arguments are passed alike with and without an ellipsis.
            logger: Some(unsafe { std::mem::transmute::<*const (), LoggerCallback>(listen) }),
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            environment: ptr::from_mut(&mut *self.listener).cast(),
        };
        let uri = CString::new(format!("file://{}", resources.display())).unwrap();
        let manifest = std::fs::read_to_string(resources.join(ArchiveManifest::FILE)).unwrap();
        let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
        let guid = CString::new(manifest["guid"].as_str().unwrap()).unwrap();
        let mut made = ptr::null_mut();
        let made_at = &raw mut made;
        self.call("fmi2Instantiate", |_| {
            // SAFETY: texts and callbacks, and a pointer of this function.
            unsafe {
                *made_at = fmi2Instantiate(c"gel".as_ptr(), 1, guid.as_ptr(), uri.as_ptr(), &raw const callbacks, 0, 0);
                if (*made_at).is_null() { 3 } else { 0 }
            }
        });
        self.component = made;
    }

    /// The words with which a scene is refused that there is not enough memory for; the instance is freed.
    pub fn refusal(&mut self, resources: &Path) -> String {
        self.instantiate(resources);
        let c = self.component;
        // SAFETY: a live component, freed once.
        unsafe {
            self.call("fmi2SetupExperiment", |c| fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0));
            self.call("fmi2EnterInitializationMode", |c| fmi2EnterInitializationMode(c));
            assert_eq!(fmi2ExitInitializationMode(c), 3);
            fmi2FreeInstance(c);
        }
        self.listener.lines.pop().expect("a refusal has words")
    }

    /// The whole life of an instance that writes its results into a folder.
    pub fn run(&mut self, resources: &Path, results: &str) -> Ending {
        self.instantiate(resources);
        let folder = CString::new(results).unwrap();
        let output = reference("output_directory");
        let text = folder.as_ptr();
        // SAFETY: a live component; one value for one reference.
        unsafe {
            self.call("fmi2SetString", |c| fmi2SetString(c, &raw const output, 1, &raw const text));
            self.call("fmi2SetupExperiment", |c| fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0));
            self.call("fmi2EnterInitializationMode", |c| fmi2EnterInitializationMode(c));
            self.call("fmi2ExitInitializationMode", |c| fmi2ExitInitializationMode(c));
        }
        self.steps(0);
        self.states();
        self.read();
        // SAFETY: a live component, freed once.
        unsafe {
            self.call("fmi2Terminate", |c| fmi2Terminate(c));
            self.call("fmi2FreeInstance", |c| {
                fmi2FreeInstance(c);
                0
            });
        }
        self.refused.take().map_or(Ending::Completed, Ending::Refused)
    }

    fn steps(&mut self, first: u32) {
        for k in first..first + STEPS {
            let from = f64::from(k) * STEP;
            // SAFETY: a live component.
            self.call("fmi2DoStep", |c| unsafe { fmi2DoStep(c, from, STEP, 0) });
        }
    }

    /// A state, its bytes, a state of these, and back to it over other meshes.
    fn states(&mut self) {
        let (mut state, mut again, mut size) = (ptr::null_mut(), ptr::null_mut(), 0);
        let (own, other, length) = (&raw mut state, &raw mut again, &raw mut size);
        // SAFETY: a live component, states of it, and a buffer of the size asked for.
        unsafe {
            self.call("fmi2GetFMUstate", |c| fmi2GetFMUstate(c, own));
            self.call("fmi2SerializedFMUstateSize", |c| fmi2SerializedFMUstateSize(c, *own, length));
            let mut bytes = vec![0; *length];
            let at = bytes.as_mut_ptr();
            self.call("fmi2SerializeFMUstate", |c| fmi2SerializeFMUstate(c, *own, at, *length));
            self.call("fmi2DeSerializeFMUstate", |c| fmi2DeSerializeFMUstate(c, at, *length, other));
            self.steps(STEPS);
            self.call("fmi2SetFMUstate", |c| fmi2SetFMUstate(c, *other));
            self.call("fmi2FreeFMUstate", |c| fmi2FreeFMUstate(c, own));
            self.call("fmi2FreeFMUstate", |c| fmi2FreeFMUstate(c, other));
        }
        self.steps(STEPS);
    }

    fn read(&mut self) {
        let (depth, origin) = (reference("contact.penetration"), reference("scene"));
        let (mut value, mut text) = (0.0, ptr::null());
        let (value, text) = (&raw mut value, &raw mut text);
        // SAFETY: a live component; one value for one reference.
        unsafe {
            self.call("fmi2GetReal", |c| fmi2GetReal(c, &raw const depth, 1, value));
            self.call("fmi2GetString", |c| fmi2GetString(c, &raw const origin, 1, text));
        }
    }
}
