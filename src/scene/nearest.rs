//! The known name that is nearest to a misspelt one.

use strsim::damerau_levenshtein;

/// Longer words are no misspelt names, and comparing them takes time.
const LONGEST: usize = 64;
/// Letters of a word for each of which one may be wrong, missing, too many or exchanged with the next: one in a short word.
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

/// The question after a name that is not known; nothing if no known name is near.
#[must_use]
pub fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, known).map_or(String::new(), |name| format!(" (did you mean `{name}`?)"))
}
