//! Which runs of a curve become the levels of `scene.fidelity`.

use super::curve::{Assessed, Curve};
use ballistic_gel::scene::{Fidelity, Level};

/// Errors that are asked of a level, in those of the scene as it comes.
fn part(fidelity: Fidelity) -> f64 {
    match fidelity {
        Fidelity::Draft => 4.0,
        Fidelity::Coarse => 2.0,
        Fidelity::Standard => 1.0,
        Fidelity::Fine => 0.5,
        Fidelity::Reference => 0.25,
    }
}

/// Knobs that change what is computed, not how well, or that the FMU's importer turns.
const OTHERS: [&str; 6] = ["bulk modulus", "restitution", "dimension", "coupling", "schedule", "lattice"];

/// A level, its cost and its error.
type Chosen<'a> = (Fidelity, &'a Assessed, f64, f64);

/// The levels that the curve gives: of the runs worth their cost the cheapest with 4, 2, ½ and ¼ of the error of the scene as it
/// comes, which is the standard; where there is none as good as ¼, the best. Dearer levels are always the more accurate.
pub fn choose(curve: &Curve) -> Vec<(Fidelity, Level)> {
    let Some(base) = curve.runs.iter().find(|assessed| assessed.run.rung.knob.is_empty()) else { return vec![] };
    let Some((cost, error)) = figures(base) else { return vec![] };
    let mut chosen: Vec<Chosen<'_>> = vec![(Fidelity::Standard, base, cost, error)];
    for fidelity in [Fidelity::Coarse, Fidelity::Draft] {
        let below = chosen[0];
        let fits = |cost: f64, error: f64| cost < below.2 && error > below.3;
        let found = cheapest(curve, part(fidelity) * error, fits).or_else(|| best(curve, fits));
        chosen.splice(0..0, found.map(|(run, cost, error)| (fidelity, run, cost, error)));
    }
    for fidelity in [Fidelity::Fine, Fidelity::Reference] {
        let above = chosen[chosen.len() - 1];
        let fits = |cost: f64, error: f64| cost > above.2 && error < above.3;
        let found = cheapest(curve, part(fidelity) * error, fits).or_else(|| best(curve, fits));
        chosen.extend(found.map(|(run, cost, error)| (fidelity, run, cost, error)));
    }
    chosen.into_iter().map(|(fidelity, run, cost, error)| (fidelity, level(run, cost, error))).collect()
}

/// Cost and error of a run that may be a level.
fn figures(assessed: &Assessed) -> Option<(f64, f64)> {
    let numerical = !OTHERS.contains(&assessed.run.rung.knob);
    let row = assessed.run.row.as_ref().ok().filter(|_| numerical)?;
    Some((row.element_updates, assessed.held?))
}

fn candidates(curve: &Curve, fits: impl Fn(f64, f64) -> bool) -> impl Iterator<Item = (&Assessed, f64, f64)> {
    let known = |run| figures(run).map(|(cost, error)| (run, cost, error));
    curve.runs.iter().filter_map(known).filter(move |&(_, cost, error)| fits(cost, error))
}

fn cheapest(curve: &Curve, most: f64, fits: impl Fn(f64, f64) -> bool) -> Option<(&Assessed, f64, f64)> {
    candidates(curve, fits).filter(|(_, _, error)| *error <= most).min_by(|a, b| a.1.total_cmp(&b.1))
}

fn best(curve: &Curve, fits: impl Fn(f64, f64) -> bool) -> Option<(&Assessed, f64, f64)> {
    candidates(curve, fits).min_by(|a, b| a.2.total_cmp(&b.2))
}

fn level(assessed: &Assessed, cost: f64, error: f64) -> Level {
    let set = assessed.run.rung.overrides.iter().map(|o| format!("{}={}", o.key, o.value)).collect();
    let cpu_seconds = assessed.run.row.as_ref().ok().map(|row| rounded(row.cpu_seconds));
    Level { set, error: Some(rounded(error)), updates: Some(rounded(cost)), cpu_seconds }
}

/// Three digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// The table for the scene.
pub fn lines(levels: &[(Fidelity, Level)]) -> String {
    let number = |name: &str, value: Option<f64>| value.map_or(String::new(), |value| format!("{name} = {value:?}\n"));
    let table = |(fidelity, level): &(Fidelity, Level)| {
        let figures = [("error", level.error), ("updates", level.updates), ("cpu_seconds", level.cpu_seconds)];
        let figures: String = figures.into_iter().map(|(name, value)| number(name, value)).collect();
        format!("[fidelity.{}]\nset = {:?}\n{figures}", fidelity.as_str(), level.set)
    };
    levels.iter().map(table).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::{choose, lines};
    use crate::trade::curve::Curve;
    use crate::trade::curve::tests::run;
    use crate::trade::ladder::MESH;
    use ballistic_gel::scene::{Fidelity, Levels};

    fn levels(sizes: &[f64]) -> Vec<(Fidelity, f64)> {
        let of = |size: &f64| run(if *size == 1.0 { "" } else { MESH }, (1.0 - size).signum() * (1.0 / size).ln().abs(), *size);
        let chosen = choose(&Curve::of(sizes.iter().map(of).collect()));
        chosen.into_iter().map(|(fidelity, level)| (fidelity, level.error.unwrap())).collect()
    }

    #[test]
    fn levels_have_four_two_one_half_and_a_quarter_of_the_error() {
        let found = levels(&[6.0, 4.0, 3.0, 2.0, 1.5, 1.0, 0.7, 0.5, 0.3, 0.25, 0.2]);
        let expected = [0.04, 0.02, 0.01, 0.005, 0.0025];
        assert_eq!(found, Fidelity::ALL.into_iter().zip(expected).collect::<Vec<_>>());
    }

    #[test]
    fn where_nothing_is_as_good_the_best_is_taken_and_where_nothing_is_left_none() {
        let found = levels(&[1.4, 1.0, 0.8, 0.7]);
        assert_eq!(found.iter().map(|level| level.0).collect::<Vec<_>>(), [Fidelity::Coarse, Fidelity::Standard, Fidelity::Fine]);
    }

    #[test]
    fn the_lines_are_the_table_of_a_scene() {
        let chosen = choose(&crate::trade::curve::tests::curve());
        let text = lines(&chosen).replace("[fidelity.", "[");
        let read: Levels = toml::from_str(&text).unwrap();
        assert_eq!(read.known().map(|(fidelity, level)| (fidelity, level.clone())).collect::<Vec<_>>(), chosen);
        assert!(read.standard.is_some_and(|level| level.set.is_empty()));
    }
}
