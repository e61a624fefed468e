//! The table of docs/validation.md, written by what the tests found.

use super::row::{Row, Verdict};
use super::{coupling, impulse, locking, momentum, patch, resonance, striker, strip, vibration, wall, wave};
use std::fmt::Write as _;

const BEGIN: &str = "<!-- verification:begin -->";
const END: &str = "<!-- verification:end -->";
const DOCUMENT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/validation.md");

/// All rows in their order.
fn rows() -> impl Iterator<Item = &'static Row> {
    let parts = [
        patch::rows(),
        momentum::rows(),
        vibration::rows(),
        wave::rows(),
        wall::rows(),
        strip::rows(),
        striker::rows(),
        impulse::rows(),
        coupling::rows(),
        resonance::rows(),
        locking::rows(),
    ];
    parts.into_iter().flatten()
}

fn table() -> String {
    let mut text = String::from("| | what | expected | obtained | order | verdict |\n|---|---|---|---|---|---|\n");
    for row in rows() {
        let verdict = match row.verdict {
            Verdict::Met => "met",
            Verdict::Frozen => "as first measured",
            Verdict::Missed => "**missed**",
        };
        let cells =
            [row.id, &row.what, &row.expected, &row.obtained, &row.order, verdict].map(|cell| cell.replace('|', "\\|"));
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    text
}

/// The document with this block between its marks.
fn with_block(document: &str, block: &str) -> Option<String> {
    let (head, rest) = document.split_once(BEGIN)?;
    let (_, tail) = rest.split_once(END)?;
    Some(format!("{head}{BEGIN}\n{block}{END}{tail}"))
}

#[test]
fn the_document_shows_what_the_tests_found() {
    let document = std::fs::read_to_string(DOCUMENT).expect("docs/validation.md is there");
    let expected = with_block(&document, &table())
        .expect("docs/validation.md has the lines that begin and end the verification table");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(DOCUMENT, expected).expect("docs/validation.md can be written");
        return;
    }
    let differs = document.lines().zip(expected.lines()).find(|(found, wanted)| found != wanted);
    let (found, wanted) = differs.unwrap_or(("the end of the file", "another number of lines"));
    assert!(
        document == expected,
        "docs/validation.md does not show what the verification tests found. In the file:\n  {found}\nfound by the tests:\n  \
         {wanted}\nRun `BLESS=1 cargo test --release --test physics verification` to write the table, and look at the difference."
    );
}
