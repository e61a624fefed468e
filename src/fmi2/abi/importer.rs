//! Importer of the command: loads the library of an unpacked FMU and calls it through C, as every importer does.
//!
//! Existing FMU import crates bring several archive formats, an XML schema and a second standard; the command needs
//! these calls alone.

use super::callbacks::{CallbackFunctions, LoggerCallback};
use super::pointers::{OpaquePointer, TextPointer};
use crate::fmi2::status::CallStatus;
use crate::fmi2::uri;
use libloading::Library;
use std::ffi::{CStr, CString, c_int};
use std::path::Path;
use std::ptr;
use std::sync::{Mutex, PoisonError};

/// Error of loading or instantiating an FMU.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// Missing library, or missing function of the library.
    #[error("the library of the FMU: {0}")]
    Library(#[from] libloading::Error),
    /// Null byte in an argument.
    #[error("{0}: a null byte in a text")]
    Text(#[from] std::ffi::NulError),
    /// `fmi2Instantiate` returned a null pointer.
    #[error("fmi2Instantiate: {messages}")]
    Refused {
        /// Messages of the FMU.
        messages: String,
    },
}

type ComponentFunction = unsafe extern "C" fn(OpaquePointer) -> c_int;
type SetUpFunction = unsafe extern "C" fn(OpaquePointer, c_int, f64, f64, c_int, f64) -> c_int;
type DoStepFunction = unsafe extern "C" fn(OpaquePointer, f64, f64, c_int) -> c_int;
type InstantiateFunction = unsafe extern "C" fn(
    TextPointer,
    c_int,
    TextPointer,
    TextPointer,
    *const CallbackFunctions,
    c_int,
    c_int,
) -> OpaquePointer;

/// Imported functions of a library.
#[derive(Debug)]
struct ImportedFunctions {
    instantiate: InstantiateFunction,
    free_instance: unsafe extern "C" fn(OpaquePointer),
    set_up_experiment: SetUpFunction,
    enter_initialization: ComponentFunction,
    exit_initialization: ComponentFunction,
    terminate: ComponentFunction,
    do_step: DoStepFunction,
    get_real: unsafe extern "C" fn(OpaquePointer, *const u32, usize, *mut f64) -> c_int,
    get_boolean: unsafe extern "C" fn(OpaquePointer, *const u32, usize, *mut c_int) -> c_int,
    set_integer: unsafe extern "C" fn(OpaquePointer, *const u32, usize, *const c_int) -> c_int,
    set_string: unsafe extern "C" fn(OpaquePointer, *const u32, usize, *const TextPointer) -> c_int,
}

impl ImportedFunctions {
    fn of(library: &Library) -> Result<Self, libloading::Error> {
        // SAFETY: the standard fixes the type of each function.
        unsafe {
            Ok(Self {
                instantiate: *library.get(b"fmi2Instantiate")?,
                free_instance: *library.get(b"fmi2FreeInstance")?,
                set_up_experiment: *library.get(b"fmi2SetupExperiment")?,
                enter_initialization: *library.get(b"fmi2EnterInitializationMode")?,
                exit_initialization: *library.get(b"fmi2ExitInitializationMode")?,
                terminate: *library.get(b"fmi2Terminate")?,
                do_step: *library.get(b"fmi2DoStep")?,
                get_real: *library.get(b"fmi2GetReal")?,
                get_boolean: *library.get(b"fmi2GetBoolean")?,
                set_integer: *library.get(b"fmi2SetInteger")?,
                set_string: *library.get(b"fmi2SetString")?,
            })
        }
    }
}

/// Log messages of an FMU, in order.
#[derive(Debug, Default)]
struct MessageLog(Mutex<Vec<String>>);

/// Instance of an FMU with its loaded library. A drop frees the instance and unloads the library.
#[derive(Debug)]
pub struct LoadedFmu {
    component: OpaquePointer,
    functions: ImportedFunctions,
    log: Box<MessageLog>,
    /// Callbacks kept alive for the FMU, which stores a pointer to them.
    _callbacks: Box<CallbackFunctions>,
    _library: Library,
}

impl LoadedFmu {
    /// Loads the library of an unpacked FMU and instantiates it with a name, its GUID and its folder of resources.
    ///
    /// # Errors
    /// [`ImportError`] with the messages of the FMU.
    pub fn new(library: &Path, name: &str, guid: &str, resources: &Path) -> Result<Self, ImportError> {
        // SAFETY: the library is an FMU and responsible for its own initialisers.
        let library = unsafe { Library::new(library) }?;
        let functions = ImportedFunctions::of(&library)?;
        let log = Box::new(MessageLog::default());
        let store_message = store_message as *const ();
        let callbacks = Box::new(CallbackFunctions {
            // SAFETY: fixed arguments are passed alike with and without an ellipsis, and no others are read.
            logger: Some(unsafe { std::mem::transmute::<*const (), LoggerCallback>(store_message) }),
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            environment: ptr::from_ref(&*log).cast_mut().cast(),
        });
        let [name, guid, uri] = [name.to_owned(), guid.to_owned(), uri::from_path(resources)].map(CString::new);
        let (name, guid, uri) = (name?, guid?, uri?);
        let functions_at = &raw const *callbacks;
        // SAFETY: texts that end with a null byte, and callbacks that live as long as the instance.
        let component =
            unsafe { (functions.instantiate)(name.as_ptr(), 1, guid.as_ptr(), uri.as_ptr(), functions_at, 0, 0) };
        if component.is_null() {
            return Err(ImportError::Refused { messages: log.take() });
        }
        Ok(Self { component, functions, log, _callbacks: callbacks, _library: library })
    }

    /// Takes the messages since the last call, in one line.
    #[must_use]
    pub fn take_messages(&self) -> String {
        self.log.take()
    }

    /// Calls `fmi2SetupExperiment` for the time from 0 to an end, s.
    #[must_use]
    pub fn set_up_experiment(&self, end: f64) -> CallStatus {
        // SAFETY: a live component, here and below.
        to_status(unsafe { (self.functions.set_up_experiment)(self.component, 0, 0.0, 0.0, 1, end) })
    }

    /// Calls `fmi2EnterInitializationMode`.
    #[must_use]
    pub fn enter_initialization(&self) -> CallStatus {
        to_status(unsafe { (self.functions.enter_initialization)(self.component) })
    }

    /// Calls `fmi2ExitInitializationMode`.
    #[must_use]
    pub fn exit_initialization(&self) -> CallStatus {
        to_status(unsafe { (self.functions.exit_initialization)(self.component) })
    }

    /// Calls `fmi2Terminate`.
    #[must_use]
    pub fn terminate(&self) -> CallStatus {
        to_status(unsafe { (self.functions.terminate)(self.component) })
    }

    /// Calls `fmi2DoStep` from a time over a length, s. The importer never returns to an earlier time, unless
    /// `may_return`.
    #[must_use]
    pub fn do_step(&self, from: f64, length: f64, may_return: bool) -> CallStatus {
        to_status(unsafe { (self.functions.do_step)(self.component, from, length, c_int::from(!may_return)) })
    }

    /// Calls `fmi2GetReal` for as many references as `values` has elements.
    #[must_use]
    pub fn get_reals(&self, references: &[u32], values: &mut [f64]) -> CallStatus {
        let n = references.len().min(values.len());
        // SAFETY: both have n items.
        to_status(unsafe { (self.functions.get_real)(self.component, references.as_ptr(), n, values.as_mut_ptr()) })
    }

    /// Calls `fmi2GetBoolean` for one variable.
    #[must_use]
    pub fn get_boolean(&self, reference: u32, value: &mut bool) -> CallStatus {
        let mut found = 0;
        // SAFETY: one reference and room for one value.
        let status =
            to_status(unsafe { (self.functions.get_boolean)(self.component, &raw const reference, 1, &raw mut found) });
        *value = found != 0;
        status
    }

    /// Calls `fmi2SetInteger` for one variable.
    #[must_use]
    pub fn set_integer(&self, reference: u32, value: i32) -> CallStatus {
        // SAFETY: one reference and one value.
        to_status(unsafe { (self.functions.set_integer)(self.component, &raw const reference, 1, &raw const value) })
    }

    /// Calls `fmi2SetString` for one variable; a null byte ends the text.
    #[must_use]
    pub fn set_string(&self, reference: u32, value: &str) -> CallStatus {
        let text = CString::new(value.split('\0').next().unwrap_or_default()).unwrap_or_default();
        // SAFETY: one reference and one text.
        to_status(unsafe { (self.functions.set_string)(self.component, &raw const reference, 1, &text.as_ptr()) })
    }
}

impl Drop for LoadedFmu {
    fn drop(&mut self) {
        // SAFETY: a live component, not used again; its library is unloaded after it.
        unsafe { (self.functions.free_instance)(self.component) };
    }
}

impl MessageLog {
    fn take(&self) -> String {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner)).join(" ")
    }
}

/// Logger callback: stores a message, a format without arguments.
unsafe extern "C" fn store_message(
    environment: OpaquePointer,
    _name: TextPointer,
    _status: c_int,
    _category: TextPointer,
    message: TextPointer,
) {
    if environment.is_null() || message.is_null() {
        return;
    }
    // SAFETY: the log of a `LoadedFmu`, and a text that ends with a null byte.
    let (log, text) = unsafe { (&*environment.cast::<MessageLog>(), CStr::from_ptr(message)) };
    let text = text.to_string_lossy().replace("%%", "%");
    log.0.lock().unwrap_or_else(PoisonError::into_inner).push(text);
}

fn to_status(returned: c_int) -> CallStatus {
    match returned {
        0 => CallStatus::Ok,
        1 => CallStatus::Warning,
        2 => CallStatus::Discard,
        4 => CallStatus::Fatal,
        _ => CallStatus::Error,
    }
}
