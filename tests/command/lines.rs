//! Lines of printed texts that were broken at 80 columns.

/// Columns of a file or a pipe.
const WIDTH: usize = 80;

/// Joins the lines that the command has broken: those whose next word would not have fitted.
pub fn joined(text: &str) -> String {
    let mut lines: Vec<String> = vec![];
    let (mut last, mut indent) = (String::new(), 0);
    for line in text.split('\n') {
        let own = indent_of(line);
        let word = line.trim_start().split(' ').next().unwrap_or_default();
        let is_full = columns(&last) + 1 + columns(word) > WIDTH;
        let is_rest = own == if indent == 0 { 0 } else { indent + 2 };
        match lines.last_mut() {
            Some(whole) if is_full && is_rest && !word.is_empty() => {
                whole.push(' ');
                whole.push_str(line.trim_start());
            }
            _ => {
                lines.push(line.to_owned());
                indent = own;
            }
        }
        line.clone_into(&mut last);
    }
    lines.join("\n")
}

fn indent_of(line: &str) -> usize {
    line.len() - line.trim_start_matches(' ').len()
}

fn columns(text: &str) -> usize {
    text.chars().count()
}
