//! Width of the printed text: that of the terminal, and 80 columns in a file or a pipe.

use comfy_table::{ColumnConstraint, ContentArrangement, Table, TableStyle};

/// Width of a text where no terminal tells its own, columns.
const PAGE_WIDTH: u16 = 80;

/// Returns the width of standard output, columns.
pub fn output_width() -> u16 {
    known_width(Table::new().width())
}

/// Returns the width of standard error, columns.
pub fn note_width() -> u16 {
    known_width(Table::new().use_stderr().width())
}

/// Returns the width of a terminal, columns; one that tells none, or 0, counts as a page.
fn known_width(told: Option<u16>) -> u16 {
    told.filter(|width| *width > 0).unwrap_or(PAGE_WIDTH)
}

/// Creates a table whose long cells are broken at the width of standard output.
pub fn new_table(style: TableStyle) -> Table {
    let mut table = Table::new();
    table.load_style(style).set_content_arrangement(ContentArrangement::Dynamic).set_width(output_width());
    table
}

/// Sets the columns of a table before the last, which has the long texts, to the width of their content.
pub fn keep_names_whole(table: &mut Table) {
    let n_columns = table.column_count();
    for column in table.column_iter_mut().take(n_columns.saturating_sub(1)) {
        column.set_constraint(ColumnConstraint::ContentWidth);
    }
}

/// Breaks the lines of a text at spaces, to lines of at most `width` columns. The rest of an indented line is indented two
/// columns more. Longer words, such as paths, and commands, whose lines begin with four spaces, stay whole.
pub fn wrap(text: &str, width: u16) -> String {
    let lines: Vec<String> = text.split('\n').map(|line| wrap_line(line, usize::from(width))).collect();
    lines.join("\n")
}

fn wrap_line(line: &str, width: usize) -> String {
    let words = line.trim_start_matches(' ');
    if visible_width(line) <= width || line.starts_with(COMMAND) {
        return line.to_owned();
    }
    let indent = line.len() - words.len();
    let hanging = " ".repeat(if indent == 0 { 0 } else { indent + 2 });
    let mut wrapped = " ".repeat(indent);
    let mut column = indent;
    for (n, word) in words.split(' ').enumerate() {
        let length = visible_width(word);
        if n > 0 && column + 1 + length > width {
            wrapped.truncate(wrapped.trim_end_matches(' ').len());
            wrapped += "\n";
            wrapped += &hanging;
            column = hanging.len();
        } else if n > 0 {
            wrapped.push(' ');
            column += 1;
        }
        wrapped += word;
        column += length;
    }
    wrapped
}

/// Start of a line with a command to copy, which is never broken.
const COMMAND: &str = "    ";

/// Returns the number of columns of a text without its ANSI styles.
fn visible_width(text: &str) -> usize {
    let (mut is_style, mut columns) = (false, 0);
    for c in text.chars() {
        match c {
            '\u{1b}' => is_style = true,
            'm' if is_style => is_style = false,
            _ if is_style => {}
            _ => columns += 1,
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_broken_at_spaces() {
        assert_eq!(wrap("one two three\nfour", 8), "one two\nthree\nfour");
        assert_eq!(wrap("  one two three", 9), "  one two\n    three");
        assert_eq!(wrap("a /long/path/without/spaces b", 8), "a\n/long/path/without/spaces\nb");
        assert_eq!(wrap("    gelfmu run a.toml --fidelity draft", 8), "    gelfmu run a.toml --fidelity draft");
        assert_eq!(wrap("\u{1b}[1m1234\u{1b}[0m 5678", 9), "\u{1b}[1m1234\u{1b}[0m 5678");
    }

    #[test]
    fn a_pipe_has_eighty_columns() {
        let mut table = new_table(comfy_table::presets::NOTHING);
        table.add_row(["name", &"word ".repeat(40)]);
        assert!(table.to_string().lines().all(|line| line.chars().count() <= usize::from(output_width())));
    }
}
