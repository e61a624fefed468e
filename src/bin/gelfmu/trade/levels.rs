//! Choice of the runs of a curve that become the levels of `scene.fidelity`.

use super::curve::{AssessedRun, TradeCurve, TradeRun};
use super::ladder::{MESH, REMESHED};
use ballistic_gel::scene::{FidelityKind, FidelityLevel};

/// Returns the cost limit of a level, in element updates of the unmodified scene.
fn cost_limit(fidelity: FidelityKind) -> f64 {
    match fidelity {
        FidelityKind::Draft => 0.15,
        FidelityKind::Coarse => 0.4,
        FidelityKind::Standard => 1.0,
        FidelityKind::Fine => 4.0,
        FidelityKind::Reference => 16.0,
    }
}

/// Knobs that change the physics instead of the accuracy, or belong to the FMU's importer.
const EXCLUDED_KNOBS: [&str; 6] = ["bulk modulus", "restitution", "dimension", "coupling", "schedule", "lattice"];

/// Run with a known cost and error.
#[derive(Clone, Copy)]
struct CostedRun<'a> {
    run: &'a AssessedRun,
    /// Element updates.
    cost: f64,
    /// Confirmed relative error.
    error: f64,
}

/// Chooses the levels of a curve: the most accurate runs within 0.15, 0.4, 4 and 16 of the cost of the unmodified
/// scene, the standard.
///
/// A more expensive level is always more accurate.
pub fn choose_levels(curve: &TradeCurve) -> Vec<(FidelityKind, FidelityLevel)> {
    let Some(base) = curve.runs.iter().find(|assessed| assessed.run.rung.knob.is_empty()) else { return vec![] };
    let Some(standard) = costed_run(base) else { return vec![] };
    let mut chosen: Vec<(FidelityKind, CostedRun<'_>)> = vec![(FidelityKind::Standard, standard)];
    for fidelity in [FidelityKind::Coarse, FidelityKind::Draft] {
        let above = chosen[0].1;
        let budget = cost_limit(fidelity) * standard.cost;
        let fits = |run: &CostedRun<'_>| run.cost <= budget && run.cost < above.cost && run.error > above.error;
        chosen.splice(0..0, most_accurate(curve, fits).map(|run| (fidelity, run)));
    }
    for fidelity in [FidelityKind::Fine, FidelityKind::Reference] {
        let below = chosen[chosen.len() - 1].1;
        let budget = cost_limit(fidelity) * standard.cost;
        let fits = |run: &CostedRun<'_>| run.cost <= budget && run.cost > below.cost && run.error < below.error;
        chosen.extend(most_accurate(curve, fits).map(|run| (fidelity, run)));
    }
    chosen.into_iter().map(|(fidelity, run)| (fidelity, level(&run))).collect()
}

/// Returns a run with its cost and error if it may be a level.
fn costed_run(assessed: &AssessedRun) -> Option<CostedRun<'_>> {
    let is_numerical = !EXCLUDED_KNOBS.contains(&assessed.run.rung.knob);
    let row = assessed.run.row.as_ref().ok().filter(|_| is_numerical)?;
    Some(CostedRun { run: assessed, cost: row.element_updates, error: assessed.confirmed? })
}

/// Returns true if the error is confirmed: the reference is of the run's own family, or a finer run of its knob exists.
fn is_confirmed(assessed: &AssessedRun, curve: &TradeCurve) -> bool {
    let rung = &assessed.run.rung;
    let is_finer = |other: &AssessedRun| {
        other.run.rung.knob == rung.knob && other.run.rung.refinement > rung.refinement && other.error.is_some()
    };
    ["", MESH, REMESHED].contains(&rung.knob) || curve.runs.iter().any(is_finer)
}

/// Returns the most accurate confirmed run that fits.
fn most_accurate(curve: &TradeCurve, fits: impl Fn(&CostedRun<'_>) -> bool) -> Option<CostedRun<'_>> {
    let confirmed = curve.runs.iter().filter(|run| is_confirmed(run, curve));
    let fitting = confirmed.filter_map(costed_run).filter(|run| fits(run));
    fitting.min_by(|a, b| a.error.total_cmp(&b.error))
}

fn level(costed: &CostedRun<'_>) -> FidelityLevel {
    let TradeRun { rung, row } = &costed.run.run;
    let set = rung.overrides.iter().map(|o| format!("{}={}", o.key, o.value)).collect();
    let cpu_seconds = row.as_ref().ok().map(|row| round_to_three(row.cpu_seconds));
    FidelityLevel {
        set,
        error: Some(round_to_three(costed.error)),
        updates: Some(round_to_three(costed.cost)),
        cpu_seconds,
    }
}

/// Rounds a number to three digits.
fn round_to_three(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Formats the levels as tables of a scene file.
pub fn scene_lines(levels: &[(FidelityKind, FidelityLevel)]) -> String {
    let number = |name: &str, value: Option<f64>| value.map_or(String::new(), |value| format!("{name} = {value:?}\n"));
    let table = |(fidelity, level): &(FidelityKind, FidelityLevel)| {
        let figures = [("error", level.error), ("updates", level.updates), ("cpu_seconds", level.cpu_seconds)];
        let figures: String = figures.into_iter().map(|(name, value)| number(name, value)).collect();
        format!("[fidelity.{}]\nset = {:?}\n{figures}", fidelity.as_str(), level.set)
    };
    levels.iter().map(table).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::{choose_levels, scene_lines};
    use crate::trade::curve::tests::run;
    use crate::trade::curve::{TradeCurve, TradeRun};
    use crate::trade::ladder::MESH;
    use ballistic_gel::scene::{FidelityKind, FidelityLevels};

    fn levels(sizes: &[f64]) -> Vec<(FidelityKind, f64)> {
        let of = |size: &f64| {
            run(if *size == 1.0 { "" } else { MESH }, (1.0 - size).signum() * (1.0 / size).ln().abs(), *size)
        };
        let chosen = choose_levels(&TradeCurve::assess(&sizes.iter().map(of).collect::<Vec<_>>()));
        chosen.into_iter().map(|(fidelity, level)| (fidelity, level.error.unwrap())).collect()
    }

    #[test]
    fn a_level_is_the_best_for_its_cost() {
        let found = levels(&[6.0, 4.0, 3.0, 2.0, 1.5, 1.0, 0.8, 0.7, 0.5, 0.4, 0.3]);
        let expected = [0.02, 0.015, 0.01, 0.007, 0.004];
        assert_eq!(found, FidelityKind::ALL.into_iter().zip(expected).collect::<Vec<_>>());
    }

    #[test]
    fn a_run_without_a_finer_one_is_no_level() {
        let mesh = [run("", 0.0, 1.0), run(MESH, 1.0, 0.7), run(MESH, 2.0, 0.5)];
        let fine = |more: &[TradeRun]| {
            let levels = choose_levels(&TradeCurve::assess(&[mesh.as_slice(), more].concat()));
            levels.into_iter().find(|level| level.0 == FidelityKind::Fine).unwrap().1.error
        };
        assert_eq!(fine(&[run("grading", 1.0, 0.65)]), Some(0.007));
        assert_eq!(fine(&[run("grading", 1.0, 0.65), run("grading", 2.0, 0.6)]), Some(0.0065));
    }

    #[test]
    fn levels_without_a_fitting_run_are_absent() {
        let found = levels(&[1.4, 1.0, 0.8, 0.7]);
        assert_eq!(
            found.iter().map(|level| level.0).collect::<Vec<_>>(),
            [FidelityKind::Coarse, FidelityKind::Standard, FidelityKind::Fine]
        );
    }

    #[test]
    fn the_lines_are_the_table_of_a_scene() {
        let chosen = choose_levels(&crate::trade::curve::tests::curve());
        let text = scene_lines(&chosen).replace("[fidelity.", "[");
        let read: FidelityLevels = toml::from_str(&text).unwrap();
        assert_eq!(read.known().map(|(fidelity, level)| (fidelity, level.clone())).collect::<Vec<_>>(), chosen);
        assert!(read.standard.is_some_and(|level| level.set.is_empty()));
    }
}
