//! Log lines, kept until the call returns and then handed to the importer on its own thread.

use super::call::CallError;
use super::status::CallStatus;

/// Log categories and their descriptions, as declared in `modelDescription.xml`.
pub const CATEGORIES: [(&str, &str); 5] = [
    ("logStatusWarning", "Calls that were carried out, with reasons to doubt the result"),
    ("logStatusDiscard", "Reasons why a step could not be completed"),
    ("logStatusError", "Reasons why a call was refused"),
    ("logStatusFatal", "Reasons why an instance was lost"),
    (EVENTS, "Actions of the instance: scene, mesh, overrides, files"),
];

const EVENTS: &str = "logEvents";

/// Log line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct LogLine {
    /// Status of the line.
    pub status: CallStatus,
    /// Declared category.
    pub category: &'static str,
    /// Text before format escapes.
    pub message: String,
}

/// Log of the current call, with the selection of lines.
#[derive(Debug, Default)]
pub(super) struct CallLog {
    events: bool,
    lines: Vec<LogLine>,
}

impl CallLog {
    /// Returns a log with debug logging on or off; warnings and errors are always written.
    pub(super) fn new(debug: bool) -> Self {
        Self { events: debug, lines: Vec::new() }
    }

    /// Switches debug logging, for the given categories if any.
    pub(super) fn select(&mut self, debug: bool, categories: &[String]) -> Result<(), CallError> {
        if let Some(unknown) = categories.iter().find(|c| CATEGORIES.iter().all(|(name, _)| name != c)) {
            let known: Vec<&str> = CATEGORIES.iter().map(|(name, _)| *name).collect();
            return Err(CallError::value("categories", unknown, known.join(", ")));
        }
        self.events = debug && (categories.is_empty() || categories.iter().any(|c| c == EVENTS));
        Ok(())
    }

    /// Logs an event.
    pub(super) fn event(&mut self, message: impl Into<String>) {
        if self.events {
            self.lines.push(LogLine { status: CallStatus::Ok, category: EVENTS, message: message.into() });
        }
    }

    /// Logs a warning.
    pub(super) fn warning(&mut self, message: impl Into<String>) {
        self.push(CallStatus::Warning, message.into());
    }

    /// Logs the error of a refused call.
    pub(super) fn refusal(&mut self, error: &CallError) {
        self.push(error.status(), error.to_string());
    }

    /// Logs a panic.
    pub(super) fn fatal(&mut self, message: String) {
        self.push(CallStatus::Fatal, message);
    }

    /// Takes the lines so far out of the log.
    pub(super) fn take(&mut self) -> Vec<LogLine> {
        std::mem::take(&mut self.lines)
    }

    fn push(&mut self, status: CallStatus, message: String) {
        let category = match status {
            CallStatus::Ok => EVENTS,
            CallStatus::Warning => "logStatusWarning",
            CallStatus::Discard => "logStatusDiscard",
            CallStatus::Error => "logStatusError",
            CallStatus::Fatal => "logStatusFatal",
        };
        self.lines.push(LogLine { status, category, message });
    }
}

/// Escapes a message as a format string: one line, no control characters, each `%` doubled.
pub(super) fn escape_format(message: &str) -> String {
    message.replace(char::is_control, " ").replace('%', "%%")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_category_that_is_used_is_declared() {
        let mut log = CallLog::new(true);
        log.event("a");
        log.warning("b");
        log.fatal("c".to_string());
        log.refusal(&CallError::value("x", 1, "2"));
        log.refusal(&CallError::NotAvailable { what: "x" });
        for line in log.take() {
            assert!(CATEGORIES.iter().any(|(name, _)| *name == line.category), "{}", line.category);
        }
    }

    #[test]
    fn debug_logging_is_chosen_by_category_and_errors_always_pass() {
        let mut log = CallLog::new(true);
        log.select(true, &["logStatusError".to_string()]).unwrap();
        log.event("not wanted");
        log.refusal(&CallError::value("x", 1, "2"));
        assert_eq!(log.take().len(), 1);
        log.select(true, &[]).unwrap();
        log.event("wanted");
        assert_eq!(log.take().len(), 1);
        assert!(log.select(true, &["logAll".to_string()]).unwrap_err().to_string().contains("logEvents"));
    }

    #[test]
    fn a_message_prints_itself_as_a_format() {
        assert_eq!(escape_format("100 % of\n\"%s\"\0"), "100 %% of \"%%s\" ");
        assert_eq!(escape_format("a\u{1b}[2Jb"), "a [2Jb");
    }
}
