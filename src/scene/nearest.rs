//! Known names like a given one, by their spelling (Damerau–Levenshtein distance) and by their parts.

use strsim::damerau_levenshtein;

/// Length of the longest word that is compared: longer words are not misspelt names, and take time.
const LONGEST: usize = 64;
/// Letters per allowed mistake (wrong, missing, extra or transposed letter); a short word may have one mistake.
const LETTERS_PER_MISTAKE: usize = 3;
/// Greatest number of suggested names.
const MOST_NAMES: usize = 3;
/// Least likeness of a suggested name.
const LEAST_LIKENESS: f64 = 0.6;
/// Difference of likeness to the best name that is none.
const SAME_LIKENESS: f64 = 0.05;
/// Likeness of a part that begins a part of the name, and of one in the description.
const PART_LIKENESS: [f64; 2] = [0.9, 0.7];

/// Known name with a description.
#[derive(Debug, Clone)]
pub struct KnownName<'a> {
    /// Name.
    pub name: &'a str,
    /// Words that a user may write for a part of the name; empty if there are none.
    pub description: String,
}

impl<'a> From<&'a str> for KnownName<'a> {
    fn from(name: &'a str) -> Self {
        Self { name, description: String::new() }
    }
}

/// Returns the known names that a user may have meant by `word`, at most three, the most like first.
///
/// # Examples
/// ```
/// use ballistic_gel::scene::suggestions;
///
/// assert_eq!(suggestions("sizes", ["size", "lattice"]), ["size"]);
/// assert_eq!(suggestions("9mm", ["9mm-fmj-115gr", "9mm-fmj", "bb"]), ["9mm-fmj", "9mm-fmj-115gr"]);
/// assert!(suggestions("speed", ["size", "lattice"]).is_empty());
/// ```
#[must_use]
pub fn suggestions<'a, K: Into<KnownName<'a>>>(word: &str, known: impl IntoIterator<Item = K>) -> Vec<&'a str> {
    if word.chars().count() > LONGEST {
        return vec![];
    }
    let lower = word.to_lowercase();
    let mut found: Vec<LikeName<'a>> = known.into_iter().map(|known| LikeName::of(&lower, &known.into())).collect();
    found.sort_by(|a, b| b.likeness.total_cmp(&a.likeness).then(a.distance.cmp(&b.distance)));
    let least = found.first().map_or(LEAST_LIKENESS, |best| (best.likeness - SAME_LIKENESS).max(LEAST_LIKENESS));
    found.iter().take_while(|like| like.likeness >= least).take(MOST_NAMES).map(|like| like.name).collect()
}

/// Question that names the known names like a word; empty if there are none.
#[must_use]
pub fn did_you_mean<'a, K: Into<KnownName<'a>>>(word: &str, known: impl IntoIterator<Item = K>) -> String {
    let names = suggestions(word, known);
    if names.is_empty() { String::new() } else { format!(" (did you mean `{}`?)", names.join("`, `")) }
}

/// Known name with its likeness to a word.
struct LikeName<'a> {
    name: &'a str,
    /// Likeness, from 0 to 1.
    likeness: f64,
    /// Number of mistakes.
    distance: usize,
}

impl<'a> LikeName<'a> {
    /// Compares a word in lower case with a known name.
    fn of(word: &str, known: &KnownName<'a>) -> Self {
        let (name, length) = (known.name.to_lowercase(), word.chars().count());
        let distance = damerau_levenshtein(word, &name);
        let is_near = distance <= (length / LETTERS_PER_MISTAKE).max(1);
        let spelling = if is_near { 1.0 - distance as f64 / length.max(1) as f64 } else { 0.0 };
        // One letter instead of another is a near name, too.
        let spelling = if is_near && distance == 1 { spelling.max(LEAST_LIKENESS) } else { spelling };
        Self { name: known.name, likeness: spelling.max(part_likeness(word, &name, &known.description)), distance }
    }
}

/// Returns the mean likeness of the parts of a word to those of a name, or to the words of its description.
fn part_likeness(word: &str, name: &str, description: &str) -> f64 {
    let (of_name, described) = (parts(name), parts(description));
    let [beginning, in_description] = PART_LIKENESS;
    let likeness = |part: &String| match part {
        part if of_name.contains(part) => 1.0,
        part if of_name.iter().any(|whole| begins_with(whole, part)) => beginning,
        part if described.contains(part) => in_description,
        _ => 0.0,
    };
    let all = parts(word);
    all.iter().map(likeness).sum::<f64>() / all.len().max(1) as f64
}

/// Returns the parts of a name in lower case, between characters other than letters and digits.
fn parts(name: &str) -> Vec<String> {
    let parts = name.split(|c: char| !c.is_alphanumeric()).filter(|part| !part.is_empty());
    parts.map(str::to_lowercase).collect()
}

/// Returns true if a part is the start of a whole one: three letters, or a number that ends there.
fn begins_with(whole: &str, part: &str) -> bool {
    let Some(rest) = whole.strip_prefix(part) else { return false };
    let is_number = part.chars().all(|c| c.is_ascii_digit()) && !rest.starts_with(|c: char| c.is_ascii_digit());
    is_number || part.chars().count() >= 3 && !part.ends_with(|c: char| c.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::known_projectiles;

    #[test]
    fn a_part_of_a_name_suggests_the_names_that_have_it() {
        let projectiles = |word: &str| suggestions(word, known_projectiles());
        assert_eq!(projectiles("9mm"), ["9mm-fmj", "9mm-115-jhp", "9mm-fmj-115gr"]);
        assert_eq!(projectiles("M80"), ["762-m80"]);
        assert_eq!(projectiles("hydra-shok")[0], "40sw-165-hydra-shok");
        assert_eq!(projectiles("buck")[0], "buckshot-1");
        assert!(projectiles("nothing").is_empty() && projectiles("").is_empty());
    }

    #[test]
    fn hollow_points_are_known_as_such_before_a_jacketed_ball_of_the_calibre() {
        let found = suggestions("45acp-jhp", known_projectiles());
        assert!(found.len() == 3 && !found.contains(&"45acp-fmj"), "{found:?}");
        assert!(found.iter().all(|name| name.starts_with("45acp-") && !name.ends_with("recovered")), "{found:?}");
        assert_eq!(suggestions("9 mm fmj", known_projectiles())[0], "9mm-fmj");
        assert_eq!(suggestions("762-fmj", known_projectiles()), ["762-m80"]);
    }

    #[test]
    fn a_misspelt_name_suggests_the_nearest_alone() {
        assert_eq!(suggestions("sphere-blok", ["sphere-720", "sphere-block", "sphere-deep"]), ["sphere-block"]);
        assert_eq!(suggestions("bbb", known_projectiles()), ["bb"]);
        assert_eq!(suggestions("siez", ["size", "lattice"]), ["size"]);
        assert_eq!(suggestions("gelatin-12", ["gelatin-20", "gelatin-10"]), ["gelatin-10"]);
        assert!(suggestions(&"size".repeat(20), ["size"]).is_empty());
    }
}
