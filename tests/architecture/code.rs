//! Just enough of Rust's grammar to tell code from text, and to find functions and paths in it.

/// The code alone: comments and the insides of literals become spaces, lines stay.
pub fn without_comments(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = literal_or_comment(rest);
        if length == 0 {
            code.push(first);
            rest = &rest[first.len_utf8()..];
        } else {
            code.extend(rest[..length].chars().map(|c| if c == '\n' { c } else { ' ' }));
            rest = &rest[length..];
        }
    }
    code
}

/// Bytes of the literal or comment that starts here; 0 if none does.
fn literal_or_comment(text: &str) -> usize {
    let until = |from: usize, end: &str| text[from..].find(end).map_or(text.len(), |at| from + at + end.len());
    if text.starts_with("//") {
        text.find('\n').unwrap_or(text.len())
    } else if text.starts_with("/*") {
        until(2, "*/")
    } else if text.starts_with('"') {
        quoted(text, '"')
    } else if text.starts_with("r\"") || text.starts_with("r#") {
        let hashes = text[1..].bytes().take_while(|byte| *byte == b'#').count();
        if text[1 + hashes..].starts_with('"') { until(2 + hashes, &format!("\"{}", "#".repeat(hashes))) } else { 0 }
    } else if text.starts_with("'\\") || text.starts_with('\'') && text.chars().nth(2) == Some('\'') {
        quoted(text, '\'')
    } else {
        0
    }
}

/// Bytes up to the quote that ends what starts with one.
fn quoted(text: &str, quote: char) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        if c == quote && !escaped {
            return at + 1;
        }
        escaped = c == '\\' && !escaped;
    }
    text.len()
}

/// Identifiers and keywords.
pub fn words(code: &str) -> impl Iterator<Item = &str> {
    code.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

/// Modules of the crate that are named by `crate::…` or, in the command, by `ballistic_gel::…`.
pub fn used_modules(code: &str) -> Vec<String> {
    let paths = ["crate::", "ballistic_gel::"].into_iter().flat_map(|root| code.split(root).skip(1));
    paths.flat_map(|path| if path.starts_with('{') { heads(path) } else { vec![head(path)] }).collect()
}

/// The first name of each path in a braced list.
fn heads(list: &str) -> Vec<String> {
    let mut depth = 0;
    let mut names = Vec::new();
    for (at, c) in list.char_indices() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if depth == 0 {
            break;
        }
        if depth == 1 && (c == '{' || c == ',') {
            names.push(head(list[at + 1..].trim_start()));
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

fn head(path: &str) -> String {
    path.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// Name and number of lines of each function that has a body.
pub fn functions(code: &str) -> Vec<(String, usize)> {
    let starts =
        code.match_indices("fn ").filter(|(at, _)| !code[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_'));
    let functions = starts.filter_map(|(at, _)| Some((head(&code[at + 3..]), body_end(&code[at..])?, at)));
    functions.map(|(name, length, at)| (name, code[at..at + length].lines().count())).collect()
}

/// Bytes to the end of the body; none if the signature ends with a semicolon.
fn body_end(function: &str) -> Option<usize> {
    let (mut brackets, mut braces) = (0, 0);
    for (at, c) in function.char_indices() {
        match c {
            '(' | '[' => brackets += 1,
            ')' | ']' => brackets -= 1,
            ';' if brackets == 0 && braces == 0 => return None,
            '{' => braces += 1,
            '}' if braces == 1 => return Some(at + 1),
            '}' => braces -= 1,
            _ => {}
        }
    }
    None
}

/// Number and text of the first line of each doc comment.
pub fn first_doc_lines(text: &str) -> Vec<(usize, &str)> {
    let doc = |line: &'_ str| line.trim_start().strip_prefix("///").or(line.trim_start().strip_prefix("//!")).is_some();
    let lines: Vec<&str> = text.lines().collect();
    let opens = |at: &usize| doc(lines[*at]) && (*at == 0 || !doc(lines[*at - 1]));
    (0..lines.len()).filter(opens).map(|at| (at + 1, lines[at].trim_start()[3..].trim())).collect()
}

/// The code before the module of unit tests, which is the last of its file.
pub fn without_tests(code: &str) -> String {
    code.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default().to_owned()
}

/// Names of the structs, enums, traits and aliases of a file; of those associated with a trait none.
pub fn types(code: &str) -> Vec<String> {
    let declared = |line: &str| {
        let line = line.trim_start().trim_start_matches("pub ");
        let line = if line.starts_with("pub(") { line.split_once(") ")?.1 } else { line };
        let (keyword, rest) = line.split_once(' ')?;
        ["struct", "enum", "trait", "type"].contains(&keyword).then(|| head(rest))
    };
    code.lines().filter(|line| !line.starts_with(' ')).filter_map(declared).collect()
}

/// Paths that begin with `crate` or `super`, in imports and in the code, as their names.
pub fn paths(code: &str) -> Vec<Vec<String>> {
    let begins = |at: usize| !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':');
    let starts = ["crate::", "super::"].into_iter().flat_map(|root| code.match_indices(root)).map(|(at, _)| at);
    starts.filter(|at| begins(*at)).flat_map(|at| expanded(&code[at..], &[])).collect()
}

/// The paths of an import tree such as `a::{b, c::{d, e}}`, after a prefix.
fn expanded(tree: &str, prefix: &[String]) -> Vec<Vec<String>> {
    let (mut path, mut rest) = (prefix.to_vec(), tree.trim_start());
    loop {
        let name = head(rest);
        rest = &rest[name.len()..];
        if !name.is_empty() {
            path.push(name);
        }
        match rest.strip_prefix("::") {
            Some(more) if more.starts_with('{') => {
                return branches(more).flat_map(|tree| expanded(tree, &path)).collect();
            }
            Some(more) if more.starts_with(|c: char| c.is_alphanumeric() || c == '_') => rest = more,
            _ => return vec![path],
        }
    }
}

/// The trees between the braces of a list, which begins with one.
fn branches(list: &str) -> impl Iterator<Item = &str> {
    let (mut depth, mut first, mut found) = (0, 1, vec![]);
    for (at, c) in list.char_indices() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if depth == 0 || depth == 1 && c == ',' {
            found.push(&list[first..at]);
            first = at + 1;
        }
        if depth == 0 {
            break;
        }
    }
    found.into_iter().filter(|tree| !tree.trim().is_empty())
}

/// Names of the items at the top level of a file that other files may use.
pub fn items(code: &str) -> impl Iterator<Item = String> {
    const KINDS: [&str; 9] = ["struct", "enum", "trait", "type", "fn", "const", "static", "union", "macro_rules!"];
    let declared = |line: &str| {
        let mut words = line.split_whitespace().skip_while(|word| !KINDS.contains(word));
        let is_item = line.starts_with("pub") || line.starts_with("macro_rules!");
        words.by_ref().next().filter(|_| is_item)?;
        words.find(|word| !KINDS.contains(word)).map(head)
    };
    code.lines().filter_map(declared)
}
