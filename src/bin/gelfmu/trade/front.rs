//! Pareto front of runs in cost and error.

/// Run in the order of its knob, from coarse to fine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrontPoint<'a> {
    /// Knob of the run.
    pub knob: &'a str,
    /// Refinement: 0 for the unmodified scene, positive towards fine.
    pub refinement: f64,
    /// Cost, element updates.
    pub cost: f64,
    /// Relative error; `None` if the run failed.
    pub error: Option<f64>,
}

/// Returns confirmed errors: the greatest error of a run and of all finer runs of its knob.
///
/// Errors of opposite sign can cancel, so that a coarse run hits the reference by chance.
pub fn confirmed_errors(points: &[FrontPoint<'_>]) -> Vec<Option<f64>> {
    let is_finer = |a: &FrontPoint<'_>, b: &FrontPoint<'_>| {
        b.refinement > a.refinement && (b.knob == a.knob || b.refinement == 0.0)
    };
    let greatest = |point: &FrontPoint<'_>, own: f64| {
        let errors = points.iter().filter(|other| is_finer(point, other)).filter_map(|other| other.error);
        errors.fold(own, f64::max)
    };
    points.iter().map(|point| point.error.map(|own| greatest(point, own))).collect()
}

/// Marks the runs on the Pareto front: no other run is at least as good in cost and error and better in either.
pub fn pareto_front(costs: &[f64], errors: &[Option<f64>]) -> Vec<bool> {
    let dominates = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
    let points = || costs.iter().copied().zip(errors.iter().copied());
    let known = || points().filter_map(|(cost, error)| Some((cost, error?)));
    let is_on_front = |point: (f64, f64)| !known().any(|other| dominates(other, point));
    points().map(|(cost, error)| error.is_some_and(|error| is_on_front((cost, error)))).collect()
}

#[cfg(test)]
mod tests {
    use super::{FrontPoint, confirmed_errors, pareto_front};

    #[test]
    fn dominated_runs_are_not_on_the_front() {
        let costs = [1.0, 2.0, 2.0, 3.0, 4.0, 0.5];
        let errors = [Some(8.0), Some(4.0), Some(5.0), Some(4.0), Some(1.0), None];
        assert_eq!(pareto_front(&costs, &errors), [true, true, false, false, true, false]);
    }

    #[test]
    fn all_runs_of_a_monotone_law_are_on_the_front() {
        let costs: Vec<f64> = (1..20).map(f64::from).collect();
        let errors: Vec<Option<f64>> = costs.iter().map(|cost| Some(1.0 / cost)).collect();
        assert!(pareto_front(&costs, &errors).into_iter().all(|front| front));
    }

    #[test]
    fn a_chance_hit_takes_the_error_of_finer_runs() {
        let point = |knob, refinement, error| FrontPoint { knob, refinement, cost: 1.0, error };
        let points = [
            point("mesh", -2.0, Some(0.01)),
            point("mesh", -1.0, Some(0.09)),
            point("", 0.0, Some(0.04)),
            point("mesh", 1.0, Some(0.02)),
            point("cfl", -1.0, Some(0.03)),
            point("cfl", 1.0, Some(0.05)),
            point("cfl", -2.0, None),
        ];
        assert_eq!(
            confirmed_errors(&points),
            [Some(0.09), Some(0.09), Some(0.04), Some(0.02), Some(0.05), Some(0.05), None]
        );
    }
}
