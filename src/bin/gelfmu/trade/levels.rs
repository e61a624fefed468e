//! Which runs of a curve become the levels of `scene.fidelity`.

use super::curve::{Assessed, Curve};
use super::ladder::{MESH, REMESHED};
use ballistic_gel::scene::{Fidelity, Level};

/// What a level may cost, in element updates of the scene as it comes.
fn budget(fidelity: Fidelity) -> f64 {
    match fidelity {
        Fidelity::Draft => 0.15,
        Fidelity::Coarse => 0.4,
        Fidelity::Standard => 1.0,
        Fidelity::Fine => 4.0,
        Fidelity::Reference => 16.0,
    }
}

/// Knobs that change what is computed, not how well, or that the FMU's importer turns.
const OTHERS: [&str; 6] = ["bulk modulus", "restitution", "dimension", "coupling", "schedule", "lattice"];

/// A level, its cost and its error.
type Chosen<'a> = (Fidelity, &'a Assessed, f64, f64);

/// The levels that the curve gives: the most accurate runs for 0.15, 0.4, 4 and 16 of the cost of the scene as it comes, which is the
/// standard. Dearer levels are always the more accurate.
pub fn choose(curve: &Curve) -> Vec<(Fidelity, Level)> {
    let Some(base) = curve.runs.iter().find(|assessed| assessed.run.rung.knob.is_empty()) else { return vec![] };
    let Some((cost, error)) = figures(base) else { return vec![] };
    let mut chosen: Vec<Chosen<'_>> = vec![(Fidelity::Standard, base, cost, error)];
    for fidelity in [Fidelity::Coarse, Fidelity::Draft] {
        let above = chosen[0];
        let fits = |own: f64, error: f64| own <= budget(fidelity) * cost && own < above.2 && error > above.3;
        let found = best(curve, fits).map(|(run, cost, error)| (fidelity, run, cost, error));
        chosen.splice(0..0, found);
    }
    for fidelity in [Fidelity::Fine, Fidelity::Reference] {
        let below = chosen[chosen.len() - 1];
        let fits = |own: f64, error: f64| own <= budget(fidelity) * cost && own > below.2 && error < below.3;
        chosen.extend(best(curve, fits).map(|(run, cost, error)| (fidelity, run, cost, error)));
    }
    chosen.into_iter().map(|(fidelity, run, cost, error)| (fidelity, level(run, cost, error))).collect()
}

/// Cost and error of a run that may be a level.
fn figures(assessed: &Assessed) -> Option<(f64, f64)> {
    let numerical = !OTHERS.contains(&assessed.run.rung.knob);
    let row = assessed.run.row.as_ref().ok().filter(|_| numerical)?;
    Some((row.element_updates, assessed.held?))
}

/// Whether its error is no chance: the reference is of its own family, or a finer run of its knob was made.
fn is_confirmed(assessed: &Assessed, curve: &Curve) -> bool {
    let rung = &assessed.run.rung;
    let finer = |other: &Assessed| {
        other.run.rung.knob == rung.knob && other.run.rung.place > rung.place && other.error.is_some()
    };
    ["", MESH, REMESHED].contains(&rung.knob) || curve.runs.iter().any(finer)
}

/// The run of least error among those that fit.
fn best(curve: &Curve, fits: impl Fn(f64, f64) -> bool) -> Option<(&Assessed, f64, f64)> {
    let known = |run| figures(run).map(|(cost, error)| (run, cost, error));
    let confirmed = curve.runs.iter().filter(|run| is_confirmed(run, curve));
    let fitting = confirmed.filter_map(known).filter(|&(_, cost, error)| fits(cost, error));
    fitting.min_by(|a, b| a.2.total_cmp(&b.2))
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
    use crate::trade::curve::tests::run;
    use crate::trade::curve::{Curve, Run};
    use crate::trade::ladder::MESH;
    use ballistic_gel::scene::{Fidelity, Levels};

    fn levels(sizes: &[f64]) -> Vec<(Fidelity, f64)> {
        let of = |size: &f64| {
            run(if *size == 1.0 { "" } else { MESH }, (1.0 - size).signum() * (1.0 / size).ln().abs(), *size)
        };
        let chosen = choose(&Curve::of(&sizes.iter().map(of).collect::<Vec<_>>()));
        chosen.into_iter().map(|(fidelity, level)| (fidelity, level.error.unwrap())).collect()
    }

    #[test]
    fn a_level_is_the_best_for_its_cost() {
        let found = levels(&[6.0, 4.0, 3.0, 2.0, 1.5, 1.0, 0.8, 0.7, 0.5, 0.4, 0.3]);
        let expected = [0.02, 0.015, 0.01, 0.007, 0.004];
        assert_eq!(found, Fidelity::ALL.into_iter().zip(expected).collect::<Vec<_>>());
    }

    #[test]
    fn what_no_finer_run_confirms_is_no_level() {
        let mesh = [run("", 0.0, 1.0), run(MESH, 1.0, 0.7), run(MESH, 2.0, 0.5)];
        let fine = |more: &[Run]| {
            let levels = choose(&Curve::of(&[mesh.as_slice(), more].concat()));
            levels.into_iter().find(|level| level.0 == Fidelity::Fine).unwrap().1.error
        };
        assert_eq!(fine(&[run("grading", 1.0, 0.65)]), Some(0.007));
        assert_eq!(fine(&[run("grading", 1.0, 0.65), run("grading", 2.0, 0.6)]), Some(0.0065));
    }

    #[test]
    fn where_no_run_is_left_there_is_no_level() {
        let found = levels(&[1.4, 1.0, 0.8, 0.7]);
        assert_eq!(
            found.iter().map(|level| level.0).collect::<Vec<_>>(),
            [Fidelity::Coarse, Fidelity::Standard, Fidelity::Fine]
        );
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
