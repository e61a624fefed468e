//! What the importer offers: a logger, and what is not used.

use crate::fmi2::component::Logger;
use crate::fmi2::logger::{Line, as_format};
use std::ffi::{CString, c_char, c_int, c_void};

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

impl Logger {
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
