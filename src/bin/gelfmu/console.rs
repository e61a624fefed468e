//! What is printed where: results on standard output, notes and errors on standard error.

use crate::failure::Failure;
use crate::options::{Color, Options};
use clap::builder::styling::{AnsiColor, Style};
use serde_json::{Value, json};
use std::fmt::Display;
use std::io::{IsTerminal, Write, stderr, stdout};

/// The terminal and what the user wants to see on it.
#[derive(Debug)]
pub struct Console {
    json: bool,
    quiet: bool,
    color: Color,
}

impl Console {
    pub fn new(options: &Options) -> Self {
        Self { json: options.json, quiet: options.quiet, color: options.color }
    }

    /// Whether progress and notes are wanted.
    pub fn is_quiet(&self) -> bool {
        self.quiet
    }

    /// Prints a result: `value` if JSON is wanted, else the text.
    pub fn result(&self, value: &dyn Display, text: &str) {
        if self.json {
            print(&format!("{value:#}"));
        } else if !self.quiet {
            print(text.trim_end());
        }
    }

    /// Prints a result that is wanted for itself, as a file or a pipe takes it, also when quiet.
    pub fn document(&self, value: &Value, text: &str) {
        if self.json { print(&format!("{value:#}")) } else { print(text.trim_end()) }
    }

    /// A line on standard error that is good to know.
    pub fn note(&self, text: &str) {
        if !self.quiet {
            complain(text);
        }
    }

    /// [`Console::note`] for another thread.
    pub fn listener(&self) -> impl Fn(&str) + Send + 'static {
        let quiet = self.quiet;
        move |text| {
            if !quiet {
                complain(text);
            }
        }
    }

    /// A line on standard error of what was done, but must not be taken as it is.
    pub fn warning(&self, text: &str) {
        let label = self.painted("warning:", AnsiColor::Yellow, stderr().is_terminal());
        complain(&format!("{label} {text}"));
    }

    /// A line on standard error that must be seen.
    pub fn error(&self, text: &str) {
        let label = self.painted("error:", AnsiColor::Red, stderr().is_terminal());
        complain(&format!("{label} {text}"));
    }

    /// The end of a command that failed.
    pub fn failure(&self, failure: &Failure) {
        self.error(&failure.to_string());
        if self.json {
            print(&format!("{:#}", json!({ "error": failure.to_string() })));
        }
    }

    /// A heading inside a result.
    pub fn heading(&self, text: &str) -> String {
        self.painted(text, AnsiColor::Green, stdout().is_terminal())
    }

    fn painted(&self, text: &str, color: AnsiColor, terminal: bool) -> String {
        let unwanted = || std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
        let painted = match self.color {
            Color::Always => true,
            Color::Never => false,
            Color::Auto => terminal && !unwanted(),
        };
        let style = if painted { Style::new().bold().fg_color(Some(color.into())) } else { Style::new() };
        format!("{style}{text}{style:#}")
    }
}

/// Prints what the command line reader has to say, help or a complaint, and says with which status to end.
pub fn usage(error: &clap::Error) -> u8 {
    // Nobody is left to tell of a pipe that was closed.
    let _ = error.print();
    if error.use_stderr() && std::env::args_os().any(|argument| argument == "--json") {
        let text = error.to_string();
        print(&format!("{:#}", json!({ "error": text.trim().trim_start_matches("error: ") })));
    }
    u8::try_from(error.exit_code()).unwrap_or(1)
}

/// A reader that has gone away (`gelfmu scenes | head -1`) is no error.
fn print(text: &str) {
    let _ = writeln!(stdout(), "{text}");
}

fn complain(text: &str) {
    let _ = writeln!(stderr(), "{text}");
}
