//! Requests to end: Ctrl-C, termination by the system, and the end of standard input.
//!
//! The first Ctrl-C ends the run after its current communication step. A termination request does the same, but the
//! program exits after [`GRACE_PERIOD`], or [`FINISHING_TIME`] later if the run is ending already. A second signal ends
//! the program at once.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Exit status of an interrupted command.
pub const INTERRUPTED: u8 = 130;

/// Time between a termination request and the forced exit; container and service managers wait ten seconds and more
/// before they kill.
const GRACE_PERIOD: Duration = Duration::from_secs(5);

/// Time for the summary and the report of a run that ends by itself after a termination request.
const FINISHING_TIME: Duration = Duration::from_mins(1);

// A signal handler reaches static data only.
static END_REQUESTED: AtomicBool = AtomicBool::new(false);
/// Set once the run has seen the request.
static REQUEST_SEEN: AtomicBool = AtomicBool::new(false);
static SCRATCH_FOLDER: Mutex<Option<PathBuf>> = Mutex::new(None);

/// Origin of a request to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum EndRequest {
    /// Interrupt from the keyboard, which the user can repeat.
    Interrupt,
    /// Termination by the system, or by a closed terminal.
    #[cfg_attr(not(unix), allow(dead_code, reason = "only a signal of Unix makes it"))]
    Terminate,
}

/// Installs the handlers; the first request is answered with `waiting` by way of `note`.
pub fn listen(waiting: &'static str, note: impl Fn(&str) + Send + 'static) -> io::Result<()> {
    spawn_signal_thread(move |request| {
        if END_REQUESTED.swap(true, Ordering::Relaxed) {
            exit_at_once();
        }
        match request {
            EndRequest::Interrupt => note(waiting),
            EndRequest::Terminate => {
                note(&format!(
                    "asked to terminate: {waiting}; it is ended without that in {} s",
                    GRACE_PERIOD.as_secs()
                ));
                std::thread::spawn(exit_after_grace);
            }
        }
    })
}

/// Ends the program like a termination request once standard input has ended: the program that held it is gone.
pub fn end_with_input() {
    std::thread::spawn(|| {
        // An input that cannot be read has ended, too.
        drop(io::copy(&mut io::stdin(), &mut io::sink()));
        END_REQUESTED.store(true, Ordering::Relaxed);
        exit_after_grace();
    });
}

/// Exits after the time that a run has to end by itself.
fn exit_after_grace() {
    std::thread::sleep(GRACE_PERIOD);
    if REQUEST_SEEN.load(Ordering::Relaxed) {
        // The run is ending by itself and writes its results.
        std::thread::sleep(FINISHING_TIME);
    }
    exit_at_once();
}

/// Makes a file size limit (`ulimit -f`) an error of the write; by default its signal ends the process.
pub fn ignore_file_size_signal() {
    #[cfg(unix)]
    {
        let heard = std::sync::Arc::new(AtomicBool::new(false));
        // Without a handler the signal ends the process, and only the final message is lost.
        drop(signal_hook::flag::register(signal_hook::consts::SIGXFSZ, heard));
    }
}

/// Returns true if a signal was ignored at the start of the program, as SIGHUP is under `nohup`.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask & (1 << (signal - 1)) != 0
}

/// Calls `answer` at each request, in a separate thread.
#[cfg(unix)]
fn spawn_signal_thread(answer: impl Fn(EndRequest) + Send + 'static) -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let heard = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| !is_ignored(*signal));
    let mut signals = signal_hook::iterator::Signals::new(heard)?;
    std::thread::spawn(move || {
        for signal in signals.forever() {
            answer(if signal == SIGINT { EndRequest::Interrupt } else { EndRequest::Terminate });
        }
    });
    Ok(())
}

/// Calls `answer` at each Ctrl-C, in a separate thread; at a shutdown, the system allows some time.
#[cfg(not(unix))]
fn spawn_signal_thread(answer: impl Fn(EndRequest) + Send + 'static) -> io::Result<()> {
    ctrlc::set_handler(move || answer(EndRequest::Interrupt)).map_err(io::Error::other)
}

/// Registers a folder that a forced exit removes.
pub fn remove_on_exit(folder: &Path) {
    *SCRATCH_FOLDER.lock().unwrap_or_else(PoisonError::into_inner) = Some(folder.to_path_buf());
}

/// Returns true if the user or the system asked the run to end.
pub fn asked() -> bool {
    let is_asked = END_REQUESTED.load(Ordering::Relaxed);
    REQUEST_SEEN.fetch_or(is_asked, Ordering::Relaxed);
    is_asked
}

fn exit_at_once() -> ! {
    if let Some(folder) = SCRATCH_FOLDER.lock().unwrap_or_else(PoisonError::into_inner).take() {
        // The folder may be gone already, and an error has no reader.
        let _ = fs::remove_dir_all(folder);
    }
    std::process::exit(i32::from(INTERRUPTED))
}
