//! What is printed where: results on standard output, notes and errors on standard error.

use crate::failure::Failure;
use crate::options::{Color, Options};
use clap::builder::styling::{AnsiColor, Color as Color16, Style};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::fmt::Display;
use std::io::{self, ErrorKind, IsTerminal, Write, stderr, stdout};
use std::sync::OnceLock;

/// The terminal and what the user wants to see on it.
#[derive(Debug)]
pub struct Console {
    json: bool,
    quiet: bool,
    color: Color,
    /// Why a result could not be printed.
    unprinted: OnceLock<String>,
}

/// Style of headings.
const HEADING: Style = Style::new().bold().fg_color(Some(Color16::Ansi(AnsiColor::Green)));

impl Console {
    pub fn new(options: &Options) -> Self {
        Self { json: options.json, quiet: options.quiet, color: options.color, unprinted: OnceLock::new() }
    }

    /// Whether progress and notes are wanted.
    pub fn is_quiet(&self) -> bool {
        self.quiet
    }

    /// Prints a result: `value` if JSON is wanted, else the text.
    pub fn result(&self, value: &dyn Display, text: &str) {
        if self.json {
            self.print(&format!("{value:#}"));
        } else if !self.quiet {
            self.print(text.trim_end());
        }
    }

    /// Prints a result that is wanted for itself, as a file or a pipe takes it, also when quiet.
    pub fn document(&self, value: &Value, text: &str) {
        if self.json { self.print(&format!("{value:#}")) } else { self.print(text.trim_end()) }
    }

    fn print(&self, text: &str) {
        if let Err(error) = print(text) {
            self.unprinted.get_or_init(|| error.to_string());
        }
    }

    /// The status to end with instead of `code`: results that could not be printed are an error.
    pub fn status(&self, code: u8) -> u8 {
        let Some(error) = self.unprinted.get() else { return code };
        self.error(&unprinted(error));
        if code == 0 { 1 } else { code }
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
        let label = self.painted("warning:", colored(AnsiColor::Yellow), stderr().is_terminal());
        write_line(&format!("{label} {}", plain(text)));
    }

    /// A line on standard error that must be seen.
    pub fn error(&self, text: &str) {
        let label = self.painted("error:", colored(AnsiColor::Red), stderr().is_terminal());
        write_line(&format!("{label} {}", plain(text)));
    }

    /// The end of a command that failed.
    pub fn failure(&self, failure: &Failure) {
        self.error(&failure.to_string());
        if self.json {
            self.print(&format!("{:#}", json!({ "error": failure.to_string() })));
        }
    }

    /// A heading inside a result.
    pub fn heading(&self, text: &str) -> String {
        self.painted(text, HEADING, stdout().is_terminal())
    }

    fn painted(&self, text: &str, wanted: Style, terminal: bool) -> String {
        let unwanted = || std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
        let painted = match self.color {
            Color::Always => true,
            Color::Never => false,
            Color::Auto => terminal && !unwanted(),
        };
        let style = if painted { wanted } else { Style::new() };
        format!("{style}{text}{style:#}")
    }
}

/// Prints what the command line reader has to say, help or a complaint, and says with which status to end.
pub fn usage(error: &clap::Error) -> u8 {
    let printed = error.print().and_then(|()| stdout().flush());
    // There is no other place to tell of a standard error that is gone.
    let printed = if error.use_stderr() { Ok(()) } else { printed };
    if error.use_stderr() && std::env::args_os().any(|argument| argument == "--json") {
        let text = error.to_string();
        drop(print(&format!("{:#}", json!({ "error": text.trim().trim_start_matches("error: ") }))));
    }
    if let Err(error) = but_for_closed_pipes(printed) {
        complain(&format!("error: {}", unprinted(&error.to_string())));
        return 1;
    }
    u8::try_from(error.exit_code()).unwrap_or(1)
}

fn unprinted(error: &str) -> String {
    format!("cannot write to standard output: {error}. Give it a file or a pipe that takes all of it")
}

/// Prints a line on standard output.
pub fn print(text: &str) -> io::Result<()> {
    let mut out = stdout().lock();
    but_for_closed_pipes(writeln!(out, "{}", shown(text)).and_then(|()| out.flush()))
}

/// A reader that has gone away (`gelfmu scenes | head -1`) is no error.
fn but_for_closed_pipes(printed: io::Result<()>) -> io::Result<()> {
    match printed {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

fn complain(text: &str) {
    write_line(&plain(text));
}

fn write_line(line: &str) {
    // There is no other place to tell of it.
    let _ = writeln!(stderr(), "{line}");
}

fn colored(color: AnsiColor) -> Style {
    Style::new().bold().fg_color(Some(color.into()))
}

/// The text without characters that a terminal takes for commands, as a file or a scene may have them: they are shown as
/// JSON writes them. Lines and tabs stay.
pub fn plain(text: &str) -> Cow<'_, str> {
    if !text.contains(is_command) {
        return Cow::Borrowed(text);
    }
    let shown = |c: char| if is_command(c) { format!("\\u{:04x}", u32::from(c)) } else { c.to_string() };
    Cow::Owned(text.chars().map(shown).collect())
}

fn is_command(c: char) -> bool {
    c.is_control() && c != '\n' && c != '\t'
}

/// [`plain`], but for the style of our own headings.
fn shown(text: &str) -> String {
    let marks = [HEADING.to_string(), format!("{HEADING:#}")];
    let (mut shown, mut rest) = (String::with_capacity(text.len()), text);
    while let Some(at) = rest.find('\u{1b}') {
        shown += &plain(&rest[..at]);
        let mark = marks.iter().find(|mark| rest[at..].starts_with(mark.as_str()));
        let length = mark.map_or(1, String::len);
        shown += &mark.map_or_else(|| plain("\u{1b}"), |mark| Cow::Borrowed(mark.as_str()));
        rest = &rest[at + length..];
    }
    shown + &plain(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_to_a_terminal_are_shown_and_not_sent() {
        assert_eq!(plain("a\u{1b}]0;title\u{7}\r\u{9b}2J\tb\nc"), "a\\u001b]0;title\\u0007\\u000d\\u009b2J\tb\nc");
        let heading = format!("{HEADING}models{HEADING:#} \u{1b}[2J");
        assert_eq!(shown(&heading), format!("{HEADING}models{HEADING:#} \\u001b[2J"));
    }
}
