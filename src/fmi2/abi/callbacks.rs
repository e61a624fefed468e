//! Callback functions of the importer: a logger, and unused functions.

use crate::fmi2::logger::{LogLine, escape_format};
use crate::fmi2::status::CallStatus;
use std::ffi::{CStr, CString, c_char, c_int, c_void};

/// Function that writes a log line: environment, instance, status, category, format and arguments.
pub type LoggerCallback = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// Callback functions of the importer (`fmi2CallbackFunctions`).
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct CallbackFunctions {
    /// Logger; may be absent.
    pub logger: Option<LoggerCallback>,
    /// Unused.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Unused.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Unused: no step is asynchronous.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    /// Component environment, handed back to the logger unchanged.
    pub environment: *mut c_void,
}

/// Logger of the importer with its arguments.
#[derive(Debug, Clone)]
pub(super) struct ImporterLogger {
    /// Callback function, if any.
    pub callback: Option<LoggerCallback>,
    /// Component environment, handed back unchanged.
    pub environment: *mut c_void,
    /// Name of the instance.
    pub name: CString,
}

/// Message of a shortage too severe for an allocated log line.
const SHORTAGE: &CStr =
    c"memory: less than 1 MB is left to this process: nothing was done. Free memory and repeat the call";

impl CallbackFunctions {
    /// Reports a shortage to the importer without an allocation.
    pub(super) fn report_shortage(&self, name: *const c_char) {
        let Some(callback) = self.logger else { return };
        let name = if name.is_null() { c"".as_ptr() } else { name };
        // SAFETY: the importer's function with its own environment; the format consumes no argument.
        unsafe {
            callback(self.environment, name, CallStatus::Error as c_int, c"logStatusError".as_ptr(), SHORTAGE.as_ptr());
        }
    }
}

impl ImporterLogger {
    /// Reports a shortage to the importer without an allocation.
    pub(super) fn report_shortage(&self) {
        let Self { callback: logger, environment, ref name } = *self;
        let none =
            CallbackFunctions { logger, environment, allocate_memory: None, free_memory: None, step_finished: None };
        none.report_shortage(name.as_ptr());
    }

    /// Hands the lines to the importer.
    pub(super) fn write(&self, lines: &[LogLine]) {
        let Some(callback) = self.callback else { return };
        for line in lines {
            let category = CString::new(line.category).unwrap_or_default();
            let message = CString::new(escape_format(&line.message)).unwrap_or_default();
            let status = line.status as c_int;
            // SAFETY: the importer's function with its own environment; the format consumes no argument.
            unsafe {
                callback(self.environment, self.name.as_ptr(), status, category.as_ptr(), message.as_ptr());
            }
        }
    }
}
