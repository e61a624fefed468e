//! What the importer offers: a logger, and what is not used.

use crate::fmi2::component::Logger;
use crate::fmi2::logger::{Line, as_format};
use crate::fmi2::status::Status;
use std::ffi::{CStr, CString, c_char, c_int, c_void};

/// Writes one line of log: environment, instance, status, category, format and its arguments.
pub type LoggerCallback = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// The functions that the importer offers.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Callbacks {
    /// Writes one line of log; may be absent.
    pub logger: Option<LoggerCallback>,
    /// Not used.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Not used.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Not used: no step is asynchronous.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    /// Handed back to the logger as it is.
    pub environment: *mut c_void,
}

/// A shortage in which not even a line of log can be made.
const SHORTAGE: &CStr =
    c"memory: less than 1 MB is left to this process: nothing was done. Free memory and repeat the call";

impl Callbacks {
    /// Tells the importer of a shortage, without an allocation.
    pub(super) fn complain(&self, name: *const c_char) {
        let Some(callback) = self.logger else { return };
        let name = if name.is_null() { c"".as_ptr() } else { name };
        // SAFETY: the importer's function with its own environment; the format consumes no argument.
        unsafe {
            callback(self.environment, name, Status::Error as c_int, c"logStatusError".as_ptr(), SHORTAGE.as_ptr());
        }
    }
}

impl Logger {
    /// Tells the importer of a shortage, without an allocation.
    pub(super) fn complain(&self) {
        let Self { callback: logger, environment, ref name } = *self;
        let none = Callbacks { logger, environment, allocate_memory: None, free_memory: None, step_finished: None };
        none.complain(name.as_ptr());
    }

    /// Hands the lines to the importer.
    pub(super) fn write(&self, lines: &[Line]) {
        let Some(callback) = self.callback else { return };
        for line in lines {
            let category = CString::new(line.category).unwrap_or_default();
            let message = CString::new(as_format(&line.message)).unwrap_or_default();
            let status = line.status as c_int;
            // SAFETY: the importer's function with its own environment; the format consumes no argument.
            unsafe {
                callback(self.environment, self.name.as_ptr(), status, category.as_ptr(), message.as_ptr());
            }
        }
    }
}
