//! Ctrl-C, and a request to terminate: the first ends the run after its communication step, the second at once.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Exit status of an interrupted command.
pub const INTERRUPTED: u8 = 130;

// A signal reaches the process, not a value in it.
static ASKED: AtomicBool = AtomicBool::new(false);
static SCRATCH: Mutex<Option<PathBuf>> = Mutex::new(None);

/// Listens from now on; `answer` is called at the first request.
pub fn listen(answer: impl Fn() + Send + 'static) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(move || {
        if ASKED.swap(true, Ordering::Relaxed) {
            leave();
        }
        answer();
    })
}

/// Makes a limit of the size of files (`ulimit -f`) an error of the write that meets it: its signal would end the process.
pub fn outlive_file_limits() {
    #[cfg(unix)]
    {
        let heard = std::sync::Arc::new(AtomicBool::new(false));
        // Without a handler the run is as it was before: nothing is lost but the words at its end.
        drop(signal_hook::flag::register(signal_hook::consts::SIGXFSZ, heard));
    }
}

/// A folder that must not stay behind when the program ends at once.
pub fn remove_on_exit(folder: &Path) {
    *SCRATCH.lock().unwrap_or_else(PoisonError::into_inner) = Some(folder.to_path_buf());
}

/// Whether the user has asked to stop.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

fn leave() -> ! {
    if let Some(folder) = SCRATCH.lock().unwrap_or_else(PoisonError::into_inner).take() {
        // It may be gone already; there is nobody to tell otherwise.
        let _ = fs::remove_dir_all(folder);
    }
    std::process::exit(i32::from(INTERRUPTED))
}
