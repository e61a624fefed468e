//! Translates the errors of the TOML reader and of serde into the terms of a scene.

use super::places::{KeyLocations, join, line_at};
use super::{SceneError, SceneErrorKind, did_you_mean};
use std::ops::Range;

/// Error of a text that is not TOML.
pub(super) fn syntax_error(text: &str, span: Option<Range<usize>>, message: &str) -> SceneError {
    let line = line_at(text, span.map_or(0, |span| span.start));
    let found = quote(text.lines().nth(line - 1).unwrap_or(""));
    let kind = SceneErrorKind::Syntax { found, expected: message.to_owned() };
    SceneError { key: String::new(), line: Some(line), kind }
}

/// Error of a TOML text that is not a scene.
pub(super) fn content_error(text: &str, places: &KeyLocations<'_>, error: &toml::de::Error) -> SceneError {
    let span = error.span().unwrap_or(0..0);
    let whole_text = span.is_empty();
    let key = if whole_text { "" } else { places.key_at(&span) };
    let line = (!key.is_empty()).then(|| line_at(text, span.start));
    let message = error.message();
    if let Some(name) = quoted_after(message, "missing field ") {
        let found = "nothing".to_owned();
        return SceneError {
            key: join(key, name),
            line,
            kind: SceneErrorKind::Value { found, expected: missing_key_expectation(key) },
        };
    }
    SceneError { key: key.to_owned(), line, kind: error_kind(text, places, message, key, &span) }
}

/// Text between backquotes after a phrase.
fn quoted_after<'a>(message: &'a str, phrase: &str) -> Option<&'a str> {
    message.strip_prefix(phrase)?.split('`').nth(1)
}

fn missing_key_expectation(table: &str) -> String {
    if table.is_empty() {
        "a table of this name".to_owned()
    } else {
        "this key in the table that starts here".to_owned()
    }
}

fn error_kind(text: &str, places: &KeyLocations<'_>, message: &str, key: &str, span: &Range<usize>) -> SceneErrorKind {
    let found = quote(&text[span.clone()]);
    if let Some(rest) = message.strip_prefix("unexpected keys in table: ") {
        let (found, known) = rest.split_once(", available keys: ").unwrap_or((rest, "none"));
        let expected = format!("`{}`", known.replace(", ", "`, `"));
        return unknown_key(found, &expected);
    }
    let (complaint, expected) = message.split_once(", expected ").unwrap_or((message, message));
    if let Some(name) = quoted_after(complaint, "unknown field ") {
        return unknown_key(name, expected);
    }
    if let Some(name) = quoted_after(complaint, "unknown variant ") {
        let hint = did_you_mean(name, quoted_names(expected));
        return SceneErrorKind::Value { found: found + &hint, expected: translate_expectation(expected) };
    }
    if message.starts_with("wanted exactly 1 element") {
        return only_one_allowed(&places.names_in(key));
    }
    SceneErrorKind::Value { found, expected: translate_expectation(expected) }
}

fn unknown_key(name: &str, expected: &str) -> SceneErrorKind {
    let hint = did_you_mean(name, quoted_names(expected));
    SceneErrorKind::UnknownKey { found: name.to_owned(), hint, expected: expected.to_owned() }
}

/// Names between backquotes.
fn quoted_names(expected: &str) -> impl Iterator<Item = &str> {
    expected.split('`').skip(1).step_by(2)
}

fn only_one_allowed(names: &[&str]) -> SceneErrorKind {
    let found = if names.is_empty() { "an empty table".to_owned() } else { names.join(" and ") };
    SceneErrorKind::Value { found, expected: "only one of them".to_owned() }
}

/// First line of a piece of scene text, cut to fit a line.
fn quote(piece: &str) -> String {
    const LONGEST: usize = 60;
    let line = piece.lines().next().unwrap_or("").trim();
    if line.chars().count() <= LONGEST {
        return line.to_owned();
    }
    line.chars().take(LONGEST).chain("...".chars()).collect()
}

/// Translates serde's expectation from Rust types to words.
fn translate_expectation(expected: &str) -> String {
    match expected {
        "f64" => "a number",
        "usize" => "a whole number, 0 or more",
        "wanted string or table" => "a name in quotes, or a table",
        "an array of length 3" => "three numbers, [x, y, z]",
        "an array of length 4" => "four numbers, [w, x, y, z]",
        "an array of length 6" => "six numbers, [xx, yy, zz, xy, xz, yz]",
        "a sequence" => "a list",
        "a string" => "text in quotes",
        "a boolean" => "true or false",
        e if e.starts_with("struct variant") => "a table that gives its dimensions",
        e if e.starts_with("struct") => "a table",
        e => e,
    }
    .to_owned()
}
