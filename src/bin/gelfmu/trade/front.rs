//! Which of many runs nobody would change for another: cheaper at the same error, or better at the same cost.

/// A run among those of its knob, from coarse to fine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point<'a> {
    /// What was turned.
    pub knob: &'a str,
    /// How far towards fine; the scene as it comes is at 0 of every knob.
    pub place: f64,
    /// Element updates.
    pub cost: f64,
    /// Relative error; nothing if the run failed.
    pub error: Option<f64>,
}

/// Errors that hold: the greatest of a run's own and of those of all finer runs of its knob.
///
/// Errors of opposite sign can cancel, and a coarse run then hits by chance; it counts only as far as each finer one hits too.
pub fn held(points: &[Point<'_>]) -> Vec<Option<f64>> {
    let finer = |a: &Point<'_>, b: &Point<'_>| b.place > a.place && (b.knob == a.knob || b.place == 0.0);
    let greatest = |point: &Point<'_>, own: f64| {
        let errors = points.iter().filter(|other| finer(point, other)).filter_map(|other| other.error);
        errors.fold(own, f64::max)
    };
    points.iter().map(|point| point.error.map(|own| greatest(point, own))).collect()
}

/// For each of (cost, error) whether no other is as cheap and as good, and better in one of the two.
pub fn pareto(points: &[(f64, Option<f64>)]) -> Vec<bool> {
    let beats = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
    let known = || points.iter().filter_map(|&(cost, error)| Some((cost, error?)));
    let best = |point: (f64, f64)| !known().any(|other| beats(other, point));
    points.iter().map(|&(cost, error)| error.is_some_and(|error| best((cost, error)))).collect()
}

#[cfg(test)]
mod tests {
    use super::{Point, held, pareto};

    #[test]
    fn only_what_is_beaten_in_nothing_is_on_the_front() {
        let points =
            [(1.0, Some(8.0)), (2.0, Some(4.0)), (2.0, Some(5.0)), (3.0, Some(4.0)), (4.0, Some(1.0)), (0.5, None)];
        assert_eq!(pareto(&points), [true, true, false, false, true, false]);
    }

    #[test]
    fn the_curve_of_an_exact_law_is_on_the_front_whole() {
        let law: Vec<(f64, Option<f64>)> = (1..20).map(|n| (f64::from(n), Some(1.0 / f64::from(n)))).collect();
        assert!(pareto(&law).into_iter().all(|front| front));
    }

    #[test]
    fn a_chance_hit_has_the_error_of_what_is_finer() {
        let point = |knob, place, error| Point { knob, place, cost: 1.0, error };
        let points = [
            point("mesh", -2.0, Some(0.01)),
            point("mesh", -1.0, Some(0.09)),
            point("", 0.0, Some(0.04)),
            point("mesh", 1.0, Some(0.02)),
            point("cfl", -1.0, Some(0.03)),
            point("cfl", 1.0, Some(0.05)),
            point("cfl", -2.0, None),
        ];
        assert_eq!(held(&points), [Some(0.09), Some(0.09), Some(0.04), Some(0.02), Some(0.05), Some(0.05), None]);
    }
}
