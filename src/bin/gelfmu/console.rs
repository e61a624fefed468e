//! Console output: results go to standard output, notes and errors to standard error.

use crate::failure::CommandError;
use crate::options::{ColorChoice, CommandLine};
use crate::text_width::{note_width, output_width, wrap};
use ballistic_gel::output::UnitSystem;
use ballistic_gel::scene::SceneError;
use clap::builder::styling::{AnsiColor, Color as Color16, Style};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::fmt::Display;
use std::io::{self, ErrorKind, IsTerminal, Write, stderr, stdout};
use std::path::Path;
use std::sync::OnceLock;

/// Output streams and the user's choices of format, verbosity and colour.
#[derive(Debug)]
pub struct Console {
    json: bool,
    quiet: bool,
    color: ColorChoice,
    /// Error of the first result that could not be printed.
    unprinted: OnceLock<String>,
}

/// ANSI style of headings.
const HEADING: Style = Style::new().bold().fg_color(Some(Color16::Ansi(AnsiColor::Green)));

impl Console {
    pub fn new(options: &CommandLine) -> Self {
        Self { json: options.json, quiet: options.quiet, color: options.color, unprinted: OnceLock::new() }
    }

    /// Returns true if progress and notes are suppressed.
    pub fn is_quiet(&self) -> bool {
        self.quiet
    }

    /// Prints a result: `value` in its alternate, indented form with `--json`; otherwise `text`, broken into lines, unless
    /// the console is quiet.
    pub fn result(&self, value: &dyn Display, text: &str) {
        if self.json {
            self.print(&format!("{value:#}"));
        } else if !self.quiet {
            self.print(&wrap(text.trim_end(), output_width()));
        }
    }

    /// Prints a result whose text is a path, which is never broken; otherwise like [`Console::result`].
    pub fn path_result(&self, value: &dyn Display, path: &Path) {
        if self.json {
            self.print(&format!("{value:#}"));
        } else if !self.quiet {
            self.print(&path.display().to_string());
        }
    }

    /// Returns the units of the printed figures: SI in JSON, else those that the user wants.
    pub fn figure_units(&self, wanted: UnitSystem) -> UnitSystem {
        if self.json { UnitSystem::Si } else { wanted }
    }

    /// Prints a document for a file or a pipe, even if quiet, with the lines that it has, e.g. a schema.
    pub fn document(&self, value: &Value, text: &str) {
        if self.json { self.print(&format!("{value:#}")) } else { self.print(text.trim_end()) }
    }

    fn print(&self, text: &str) {
        if let Err(error) = print(text) {
            self.unprinted.get_or_init(|| error.to_string());
        }
    }

    /// Returns the final exit status: 1 instead of 0 if a result could not be printed.
    pub fn status(&self, code: u8) -> u8 {
        let Some(error) = self.unprinted.get() else { return code };
        self.error(&unprinted_text(error));
        if code == 0 { 1 } else { code }
    }

    /// Prints an informative line on standard error, unless quiet.
    pub fn note(&self, text: &str) {
        if !self.quiet {
            write_note(text, self.json);
        }
    }

    /// Prints informative lines on standard error, unless quiet.
    pub fn notes(&self, lines: &[String]) {
        for line in lines {
            self.note(line);
        }
    }

    /// Returns a [`Console::note`] that another thread can own.
    pub fn listener(&self) -> impl Fn(&str) + Send + 'static {
        let (quiet, json) = (self.quiet, self.json);
        move |text| {
            if !quiet {
                write_note(text, json);
            }
        }
    }

    /// Prints a warning on standard error, even if quiet: the result exists, but is doubtful.
    pub fn warning(&self, text: &str) {
        let label = self.style_text("warning:", bold_style(AnsiColor::Yellow), stderr().is_terminal());
        write_lines(&format!("{label} {}", plain(text)), self.json);
    }

    /// Prints an error on standard error, even if quiet.
    pub fn error(&self, text: &str) {
        let label = self.style_text("error:", bold_style(AnsiColor::Red), stderr().is_terminal());
        write_lines(&format!("{label} {}", plain(text)), self.json);
    }

    /// Prints the failure of a command, on standard error and as JSON if the user wants it.
    pub fn failure(&self, failure: &CommandError) {
        self.error(&failure.to_string());
        if self.json {
            self.print(&format!("{:#}", failure_json(failure)));
        }
    }

    /// Formats a heading inside a result.
    pub fn heading(&self, text: &str) -> String {
        self.style_text(text, HEADING, stdout().is_terminal())
    }

    fn style_text(&self, text: &str, style: Style, is_terminal: bool) -> String {
        let is_colour_off = || std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
        let is_coloured = match self.color {
            ColorChoice::Always => true,
            ColorChoice::Never => false,
            ColorChoice::Auto => is_terminal && !is_colour_off(),
        };
        let style = if is_coloured { style } else { Style::new() };
        format!("{style}{text}{style:#}")
    }
}

/// Describes a failure: its message, and of an invalid scene the key, the line, the value found and the values expected.
fn failure_json(failure: &CommandError) -> Value {
    let mut object = json!({ "error": failure.to_string() });
    if let CommandError::Scene { error, .. } = failure {
        let SceneError { key, line, kind } = &**error;
        object["key"] = json!(key);
        object["line"] = json!(line);
        object["found"] = json!(kind.found());
        object["expected"] = json!(kind.expected());
    }
    object
}

/// Prints the help or the complaint of the argument parser, and returns the exit status.
pub fn usage(error: &clap::Error) -> u8 {
    let printed = error.print().and_then(|()| stdout().flush());
    // A standard error that cannot be written to has no substitute.
    let printed = if error.use_stderr() { Ok(()) } else { printed };
    if error.use_stderr() && std::env::args_os().any(|argument| argument == "--json") {
        let text = error.to_string();
        drop(print(&format!("{:#}", json!({ "error": text.trim().trim_start_matches("error: ") }))));
    }
    if let Err(error) = ignore_closed_pipe(printed) {
        write_note(&format!("error: {}", unprinted_text(&error.to_string())), false);
        return 1;
    }
    u8::try_from(error.exit_code()).unwrap_or(1)
}

fn unprinted_text(error: &str) -> String {
    format!("cannot write to standard output: {error}. Give it a file or a pipe that takes all of it")
}

/// Prints a line on standard output and flushes it.
pub fn print(text: &str) -> io::Result<()> {
    let mut out = stdout().lock();
    ignore_closed_pipe(writeln!(out, "{}", escape_text(text)).and_then(|()| out.flush()))
}

/// Treats a closed pipe (`gelfmu scenes | head -1`) as success.
fn ignore_closed_pipe(printed: io::Result<()>) -> io::Result<()> {
    match printed {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

fn write_note(text: &str, is_for_program: bool) {
    write_lines(&plain(text), is_for_program);
}

/// Writes a text on standard error, broken into lines for people; a program that reads JSON gets each text as one line.
fn write_lines(text: &str, is_for_program: bool) {
    let lines = if is_for_program { text.to_owned() } else { wrap(text, note_width()) };
    // A line that standard error refuses has no substitute.
    let _ = writeln!(stderr(), "{lines}");
}

fn bold_style(color: AnsiColor) -> Style {
    Style::new().bold().fg_color(Some(color.into()))
}

/// Escapes control characters, which a terminal would obey, as JSON does; line feeds and tabs stay.
pub fn plain(text: &str) -> Cow<'_, str> {
    if !text.contains(is_control_character) {
        return Cow::Borrowed(text);
    }
    let shown = |c: char| if is_control_character(c) { format!("\\u{:04x}", u32::from(c)) } else { c.to_string() };
    Cow::Owned(text.chars().map(shown).collect())
}

fn is_control_character(c: char) -> bool {
    c.is_control() && c != '\n' && c != '\t'
}

/// Escapes control characters like [`plain`], except the style of our own headings.
fn escape_text(text: &str) -> String {
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
        assert_eq!(escape_text(&heading), format!("{HEADING}models{HEADING:#} \\u001b[2J"));
    }
}
