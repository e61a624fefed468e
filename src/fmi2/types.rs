//! The C types of FMI 2.0.

use std::ffi::{c_char, c_int, c_void};

/// What a call came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(i32)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// Done, with a remark in the log.
    Warning = 1,
    /// Not done; the instance is still good.
    Discard = 2,
    /// Refused; nothing was changed.
    Error = 3,
    /// The instance is lost.
    Fatal = 4,
    /// Still running.
    Pending = 5,
}

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
