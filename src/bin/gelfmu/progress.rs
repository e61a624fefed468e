//! Progress on standard error: a bar with the time left on a terminal, a line now and then elsewhere.

use crate::console::{self, Console};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Parts into which a run is divided for showing.
const PARTS: f64 = 1000.0;
/// Time between two lines where there is no terminal.
const HEARTBEAT: Duration = Duration::from_secs(10);

/// The bar of one run.
#[derive(Debug)]
pub struct Bar {
    bar: ProgressBar,
    heartbeat: Option<Heartbeat>,
}

impl Bar {
    /// A bar that draws itself on a terminal, or a line every ten seconds elsewhere; nothing where the user wants it quiet.
    pub fn new(console: &Console) -> Self {
        let hidden = console.is_quiet();
        let target = if hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(PARTS as u64), target);
        let template = "{bar:40} {percent:>3} %  {msg}  {elapsed} gone, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        let note = console.listener();
        let heartbeat = (!hidden && !stderr().is_terminal()).then(|| Heartbeat::start(HEARTBEAT, note));
        Self { bar, heartbeat }
    }

    /// Shows that the run is at `time` of `end`, s.
    pub fn show(&self, time: f64, end: f64) {
        self.see(format!("{:.3} of {:.3} ms", time * 1e3, end * 1e3), time / end);
    }

    /// Shows what is done now, and which part of all that is to be done is behind.
    pub fn show_part(&self, what: &str, part: f64) {
        self.see(console::plain(what).into_owned(), part);
        self.bar.tick();
    }

    fn see(&self, what: String, part: f64) {
        if let Some(heartbeat) = &self.heartbeat {
            heartbeat.see(&what, part);
        }
        self.bar.set_message(what);
        self.bar.set_position((part * PARTS) as u64);
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

/// A thread that tells in equal intervals how far a run is, until it is dropped.
#[derive(Debug)]
struct Heartbeat {
    seen: Arc<Mutex<SeenProgress>>,
    /// The thread ends when this is gone.
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// The last that was seen of a run.
#[derive(Debug, Default)]
struct SeenProgress {
    what: String,
    part: f64,
}

impl Heartbeat {
    fn start(interval: Duration, note: impl Fn(&str) + Send + 'static) -> Self {
        let seen = Arc::new(Mutex::new(SeenProgress::default()));
        let ((end, ended), began, looked_at) = (mpsc::channel(), Instant::now(), seen.clone());
        let beat = move || {
            while ended.recv_timeout(interval) == Err(RecvTimeoutError::Timeout) {
                let line = looked_at.lock().unwrap_or_else(PoisonError::into_inner).line(began.elapsed());
                note(&line);
            }
        };
        // Without the thread there are no lines: no reason to end a run.
        let thread = std::thread::Builder::new().name("heartbeat".to_owned()).spawn(beat).ok();
        Self { seen, end: Some(end), thread }
    }

    fn see(&self, what: &str, part: f64) {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        what.clone_into(&mut seen.what);
        seen.part = part;
    }
}

impl Drop for Heartbeat {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            // A thread that has panicked has nothing more to say.
            drop(thread.join());
        }
    }
}

impl SeenProgress {
    /// Time reached, percent and time left.
    fn line(&self, elapsed: Duration) -> String {
        let gone = elapsed.as_secs();
        if self.part <= 0.0 {
            return format!("at the start, {gone} s gone");
        }
        let left = elapsed.as_secs_f64() * (1.0 / self.part - 1.0).max(0.0);
        format!("{}, {:.0} %, {gone} s gone, {left:.0} s left", self.what, 100.0 * self.part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_without_a_terminal_tells_how_far_it_is() {
        let (said, heard) = mpsc::channel();
        let heartbeat = Heartbeat::start(Duration::from_millis(5), move |line: &str| drop(said.send(line.to_owned())));
        assert!(heard.recv().unwrap().starts_with("at the start, 0 s gone"));
        heartbeat.see("5.000 of 20.000 ms", 0.25);
        let line = heard.iter().find(|line| !line.starts_with("at the start")).unwrap();
        assert!(line.starts_with("5.000 of 20.000 ms, 25 %, 0 s gone, 0 s left"), "{line}");
        drop(heartbeat);
        assert_eq!(heard.iter().filter(|line| line.as_str() == "").count(), 0, "it ends with the run");
    }

    #[test]
    fn the_time_left_goes_by_the_part_that_is_behind() {
        let seen = SeenProgress { what: "1.000 of 4.000 ms".to_owned(), part: 0.25 };
        assert_eq!(seen.line(Duration::from_secs(20)), "1.000 of 4.000 ms, 25 %, 20 s gone, 60 s left");
    }
}
