//! Progress display on standard error: a bar with the time left on a terminal, a line every ten seconds elsewhere.

use crate::console::{self, Console};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Number of steps of the bar.
const BAR_STEPS: f64 = 1000.0;
/// Interval between two lines where there is no terminal.
const HEARTBEAT: Duration = Duration::from_secs(10);

/// Progress bar of one command.
#[derive(Debug)]
pub struct ProgressDisplay {
    bar: ProgressBar,
    heartbeat: Option<HeartbeatThread>,
}

impl ProgressDisplay {
    /// Creates a bar on a terminal, or a line every ten seconds elsewhere; a quiet console hides both.
    pub fn new(console: &Console) -> Self {
        let hidden = console.is_quiet();
        let target = if hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(BAR_STEPS as u64), target);
        let template = "{bar:40} {percent:>3} %  {msg}  {elapsed} elapsed, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        let note = console.listener();
        let heartbeat = (!hidden && !stderr().is_terminal()).then(|| HeartbeatThread::start(HEARTBEAT, note));
        Self { bar, heartbeat }
    }

    /// Shows the time reached and the latest end, s, and the completed fraction of the run by wall time.
    pub fn show(&self, time: f64, latest: f64, fraction: f64) {
        self.update(format!("{:.3} of at most {:.3} ms", time * 1e3, latest * 1e3), fraction);
    }

    /// Shows the current task and the completed fraction of all tasks.
    pub fn show_task(&self, task: &str, fraction: f64) {
        self.update(console::plain(task).into_owned(), fraction);
        self.bar.tick();
    }

    fn update(&self, task: String, fraction: f64) {
        if let Some(heartbeat) = &self.heartbeat {
            heartbeat.update(&task, fraction);
        }
        self.bar.set_message(task);
        self.bar.set_position((fraction * BAR_STEPS) as u64);
    }

    /// Removes the bar from the terminal.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

/// Thread that reports the progress at equal intervals until it is dropped.
#[derive(Debug)]
struct HeartbeatThread {
    snapshot: Arc<Mutex<ProgressSnapshot>>,
    /// Sender whose drop ends the thread.
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// Latest known progress.
#[derive(Debug, Default)]
struct ProgressSnapshot {
    task: String,
    fraction: f64,
}

impl HeartbeatThread {
    fn start(interval: Duration, note: impl Fn(&str) + Send + 'static) -> Self {
        let snapshot = Arc::new(Mutex::new(ProgressSnapshot::default()));
        let ((end, ended), began, watched) = (mpsc::channel(), Instant::now(), snapshot.clone());
        let beat = move || {
            while ended.recv_timeout(interval) == Err(RecvTimeoutError::Timeout) {
                let line = watched.lock().unwrap_or_else(PoisonError::into_inner).line(began.elapsed());
                note(&line);
            }
        };
        // A run goes on without the progress lines.
        let thread = std::thread::Builder::new().name("heartbeat".to_owned()).spawn(beat).ok();
        Self { snapshot, end: Some(end), thread }
    }

    fn update(&self, task: &str, fraction: f64) {
        let mut snapshot = self.snapshot.lock().unwrap_or_else(PoisonError::into_inner);
        task.clone_into(&mut snapshot.task);
        snapshot.fraction = fraction;
    }
}

impl Drop for HeartbeatThread {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            // The result of a panicked thread is not needed.
            drop(thread.join());
        }
    }
}

impl ProgressSnapshot {
    /// Formats the task, the percentage and the time left.
    fn line(&self, elapsed: Duration) -> String {
        let gone = elapsed.as_secs();
        if self.fraction <= 0.0 {
            return format!("at the start, {gone} s elapsed");
        }
        let left = elapsed.as_secs_f64() * (1.0 / self.fraction - 1.0).max(0.0);
        format!("{}, {:.0} %, {gone} s elapsed, {left:.0} s left", self.task, 100.0 * self.fraction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_without_a_terminal_reports_its_progress() {
        let (said, heard) = mpsc::channel();
        let heartbeat =
            HeartbeatThread::start(Duration::from_millis(5), move |line: &str| drop(said.send(line.to_owned())));
        assert!(heard.recv().unwrap().starts_with("at the start, 0 s elapsed"));
        heartbeat.update("5.000 of 20.000 ms", 0.25);
        let line = heard.iter().find(|line| !line.starts_with("at the start")).unwrap();
        assert!(line.starts_with("5.000 of 20.000 ms, 25 %, 0 s elapsed, 0 s left"), "{line}");
        drop(heartbeat);
        assert_eq!(heard.iter().filter(|line| line.as_str() == "").count(), 0, "it ends with the run");
    }

    #[test]
    fn the_time_left_is_extrapolated_from_the_completed_fraction() {
        let snapshot = ProgressSnapshot { task: "1.000 of 4.000 ms".to_owned(), fraction: 0.25 };
        assert_eq!(snapshot.line(Duration::from_secs(20)), "1.000 of 4.000 ms, 25 %, 20 s elapsed, 60 s left");
    }
}
