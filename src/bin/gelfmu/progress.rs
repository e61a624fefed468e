//! A bar with the time left, on standard error, only on a terminal.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Parts into which a run is divided for showing.
const PARTS: f64 = 1000.0;

/// The bar of one run.
#[derive(Debug)]
pub struct Bar(ProgressBar);

impl Bar {
    /// A bar that draws itself on a terminal, unless it shall be hidden.
    pub fn new(hidden: bool) -> Self {
        let target = if hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(PARTS as u64), target);
        let template = "{bar:40} {percent:>3} %  {msg}  {elapsed} gone, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Self(bar)
    }

    /// Shows that the run is at `time` of `end`, s.
    pub fn show(&self, time: f64, end: f64) {
        self.0.set_message(format!("{:.3} of {:.3} ms", time * 1e3, end * 1e3));
        self.0.set_position((time / end * PARTS) as u64);
    }

    /// Shows what is done now, and which part of all that is to be done is behind.
    pub fn show_part(&self, what: &str, part: f64) {
        self.0.set_message(what.to_owned());
        self.0.set_position((part * PARTS) as u64);
        self.0.tick();
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        self.0.finish_and_clear();
    }
}
