//! Ctrl-C, and the request of a system to terminate.
//!
//! The first Ctrl-C ends the run after its communication step, however long that is. A request to terminate does the same, but gives
//! the run [`PATIENCE`] for it: who sends one waits for the end and seldom sends another. A second one of either ends the run at
//! once.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Exit status of an interrupted command.
pub const INTERRUPTED: u8 = 130;

/// Time after a request to terminate at which the program ends at once; container and service managers wait ten seconds and more
/// before they kill.
const PATIENCE: Duration = Duration::from_secs(5);

/// Time for the summary and the report of a run that ends by itself after a request to terminate.
const LAST_WORDS: Duration = Duration::from_mins(1);

// A signal reaches the process, not a value in it.
static ASKED: AtomicBool = AtomicBool::new(false);
/// The run knows that its end was asked for.
static HEARD: AtomicBool = AtomicBool::new(false);
static SCRATCH: Mutex<Option<PathBuf>> = Mutex::new(None);

/// Who wants the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Request {
    /// A person at the keyboard, who can ask again.
    Interrupt,
    /// A system, or a terminal that was closed.
    Terminate,
}

/// Listens from now on; the first request is answered with `waiting` by way of `note`.
pub fn listen(waiting: &'static str, note: impl Fn(&str) + Send + 'static) -> std::io::Result<()> {
    hear(move |request| {
        if ASKED.swap(true, Ordering::Relaxed) {
            leave();
        }
        match request {
            Request::Interrupt => note(waiting),
            Request::Terminate => {
                note(&format!("asked to terminate, at once in {} s; {waiting}", PATIENCE.as_secs()));
                std::thread::spawn(|| {
                    std::thread::sleep(PATIENCE);
                    if HEARD.load(Ordering::Relaxed) {
                        // The run is ending by itself, and writes what it has.
                        std::thread::sleep(LAST_WORDS);
                    }
                    leave();
                });
            }
        }
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

/// Returns true if a signal was ignored when the program began, as that of a closed terminal is under `nohup`.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask & (1 << (signal - 1)) != 0
}

/// Calls `answer` at each request, in a thread of its own.
#[cfg(unix)]
fn hear(answer: impl Fn(Request) + Send + 'static) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let heard = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| !is_ignored(*signal));
    let mut signals = signal_hook::iterator::Signals::new(heard)?;
    std::thread::spawn(move || {
        for signal in signals.forever() {
            answer(if signal == SIGINT { Request::Interrupt } else { Request::Terminate });
        }
    });
    Ok(())
}

/// Calls `answer` at each Ctrl-C, in a thread of its own; the system gives a program that it closes a time of its own.
#[cfg(not(unix))]
fn hear(answer: impl Fn(Request) + Send + 'static) -> std::io::Result<()> {
    ctrlc::set_handler(move || answer(Request::Interrupt)).map_err(std::io::Error::other)
}

/// A folder that must not stay behind when the program ends at once.
pub fn remove_on_exit(folder: &Path) {
    *SCRATCH.lock().unwrap_or_else(PoisonError::into_inner) = Some(folder.to_path_buf());
}

/// Returns true if the end of the run was asked for.
pub fn asked() -> bool {
    let is_asked = ASKED.load(Ordering::Relaxed);
    HEARD.fetch_or(is_asked, Ordering::Relaxed);
    is_asked
}

fn leave() -> ! {
    if let Some(folder) = SCRATCH.lock().unwrap_or_else(PoisonError::into_inner).take() {
        // It may be gone already; there is nobody to tell otherwise.
        let _ = fs::remove_dir_all(folder);
    }
    std::process::exit(i32::from(INTERRUPTED))
}
