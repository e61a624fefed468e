//! The preloaded allocator of `alloc_shim.c`: how it is made, and its functions as this process has them.

use std::ffi::{CStr, CString, c_char, c_int, c_long, c_void};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::ptr;

unsafe extern "C" {
    fn dlsym(handle: *mut c_void, name: *const c_char) -> *mut c_void;
}

/// Compiles the shim into a folder; `None` without a C compiler.
pub fn compiled(folder: &Path) -> Option<PathBuf> {
    let (source, library) =
        (concat!(env!("CARGO_MANIFEST_DIR"), "/tests/shortage/alloc_shim.c"), folder.join("alloc_shim.so"));
    let made = Command::new("cc").args(["-O2", "-shared", "-fPIC", source, "-o"]).arg(&library).status();
    made.ok()?.success().then_some(library)
}

/// The functions of the shim.
pub struct Shim {
    plan: extern "C" fn(c_long, c_int),
    arm: extern "C" fn(),
    disarm: extern "C" fn() -> c_long,
    pause: extern "C" fn(c_int),
    relieve: extern "C" fn(),
    requests: extern "C" fn() -> c_long,
    refused: extern "C" fn() -> c_long,
    profile: extern "C" fn(*const c_char),
    end_profile: extern "C" fn(),
}

fn function(name: &CStr) -> Option<*mut c_void> {
    // SAFETY: null is the handle of all that is loaded.
    let at = unsafe { dlsym(ptr::null_mut(), name.as_ptr()) };
    (!at.is_null()).then_some(at)
}

impl Shim {
    /// Those that were preloaded, if they were.
    pub fn preloaded() -> Option<Self> {
        // SAFETY: the signatures are those in `alloc_shim.c`.
        unsafe {
            Some(Self {
                plan: std::mem::transmute::<*mut c_void, extern "C" fn(c_long, c_int)>(function(c"gel_alloc_plan")?),
                arm: std::mem::transmute::<*mut c_void, extern "C" fn()>(function(c"gel_alloc_arm")?),
                disarm: std::mem::transmute::<*mut c_void, extern "C" fn() -> c_long>(function(c"gel_alloc_disarm")?),
                pause: std::mem::transmute::<*mut c_void, extern "C" fn(c_int)>(function(c"gel_alloc_pause")?),
                relieve: std::mem::transmute::<*mut c_void, extern "C" fn()>(function(c"gel_alloc_relieve")?),
                requests: std::mem::transmute::<*mut c_void, extern "C" fn() -> c_long>(function(
                    c"gel_alloc_requests",
                )?),
                refused: std::mem::transmute::<*mut c_void, extern "C" fn() -> c_long>(function(c"gel_alloc_refused")?),
                profile: std::mem::transmute::<*mut c_void, extern "C" fn(*const c_char)>(function(
                    c"gel_alloc_profile",
                )?),
                end_profile: std::mem::transmute::<*mut c_void, extern "C" fn()>(function(c"gel_alloc_end_profile")?),
            })
        }
    }

    /// Refuses the request with this number; with `is_limit`, from then on all that add to what is held.
    pub fn plan(&self, number: i64, is_limit: bool) {
        (self.plan)(number as c_long, c_int::from(is_limit));
    }

    /// Watches a call; its answer, and the bytes by which most was held in it.
    pub fn watched<R>(&self, call: impl FnOnce() -> R) -> (R, i64) {
        (self.arm)();
        let answer = call();
        (answer, (self.disarm)())
    }

    /// Leaves the allocations of a callback alone.
    pub fn spared(&self, callback: impl FnOnce()) {
        (self.pause)(1);
        callback();
        (self.pause)(0);
    }

    /// Refuses nothing any more, and lifts a limit of the address space.
    pub fn relieve(&self) {
        (self.relieve)();
        limit_space(None);
    }

    /// Requests so far.
    pub fn requests(&self) -> i64 {
        (self.requests)()
    }

    /// Requests that were refused.
    pub fn refused(&self) -> i64 {
        (self.refused)()
    }

    /// Writes every request to a file.
    pub fn profile(&self, file: &Path) {
        let path = CString::new(file.to_str().unwrap()).unwrap();
        (self.profile)(path.as_ptr());
    }

    /// Completes that file.
    pub fn end_profile(&self) {
        (self.end_profile)();
    }
}

/// Leaves so many bytes of address space to this process, or as many as it may have.
pub fn limit_space(left: Option<u64>) {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let maximum = getrlimit(Resource::As).maximum;
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    let taken = 4096 * pages.split(' ').next().unwrap().parse::<u64>().unwrap();
    let current = left.map(|left| taken + left).or(maximum);
    setrlimit(Resource::As, Rlimit { current, maximum }).unwrap();
}
