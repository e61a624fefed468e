//! Nearest known name to a misspelt one, by Damerau–Levenshtein distance.

use strsim::damerau_levenshtein;

/// Length of the longest word that is compared: longer words are not misspelt names, and take time.
const LONGEST: usize = 64;
/// Letters per allowed mistake (wrong, missing, extra or transposed letter); a short word may have one mistake.
const LETTERS_PER_MISTAKE: usize = 3;

/// Returns the known name that a user may have meant by `word`, if one is near.
///
/// # Examples
/// ```
/// use ballistic_gel::scene::nearest;
///
/// assert_eq!(nearest("sizes", ["size", "lattice"]), Some("size"));
/// assert_eq!(nearest("speed", ["size", "lattice"]), None);
/// ```
#[must_use]
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let length = word.chars().count();
    if length > LONGEST {
        return None;
    }
    let lower = word.to_lowercase();
    let distance = |name: &str| damerau_levenshtein(&lower, &name.to_lowercase());
    let near = known.into_iter().map(|name| (distance(name), name));
    let best = near.min_by_key(|(distance, _)| *distance)?;
    (best.0 <= (length / LETTERS_PER_MISTAKE).max(1)).then_some(best.1)
}

/// Question that names the nearest known name; empty if none is near.
#[must_use]
pub fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, known).map_or(String::new(), |name| format!(" (did you mean `{name}`?)"))
}
