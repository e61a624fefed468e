//! Error-cost curve: reference values, errors of all runs, and the Pareto front.

use super::front::{FrontPoint, confirmed_errors, pareto_front};
use super::ladder::{LadderRung, MESH, REMESHED};
use super::richardson::{MeshValue, NoLimit, RefinementLimit, extrapolate_limit};
use super::row::TradeRow;

/// Compared figure of a run.
pub struct ComparedQuantity {
    /// Key in files.
    pub key: &'static str,
    /// Name in tables.
    pub name: &'static str,
    /// Displayed unit.
    pub unit: &'static str,
    /// Number of displayed units in the SI unit.
    pub units_per_si: f64,
    get: fn(&TradeRow) -> Option<f64>,
    /// Scale of the errors; `None` for the reference value itself.
    scale: fn(&TradeRow) -> Option<f64>,
}

/// Compared quantities: peak depth, contact duration, rebound speed and peak force.
///
/// Errors of the rebound are relative to the initial speed, as the rebound itself may be close to zero.
pub const QUANTITIES: [ComparedQuantity; 4] = [
    ComparedQuantity {
        key: "peak_depth",
        name: "depth",
        unit: "mm",
        units_per_si: 1e3,
        get: |row| Some(row.peak_depth),
        scale: no_scale,
    },
    ComparedQuantity {
        key: "contact_duration",
        name: "contact",
        unit: "ms",
        units_per_si: 1e3,
        get: |row| row.contact_duration,
        scale: no_scale,
    },
    ComparedQuantity {
        key: "final_speed",
        name: "rebound",
        unit: "m/s",
        units_per_si: 1.0,
        get: |row| Some(row.final_speed),
        scale: |row| (row.initial_speed > 0.0).then_some(row.initial_speed),
    },
    ComparedQuantity {
        key: "peak_force",
        name: "force",
        unit: "N",
        units_per_si: 1.0,
        get: |row| Some(row.peak_force),
        scale: no_scale,
    },
];

fn no_scale(_: &TradeRow) -> Option<f64> {
    None
}

impl ComparedQuantity {
    /// Returns the value, SI units; `None` if missing or if the run failed.
    pub fn value(&self, row: &TradeRow) -> Option<f64> {
        (self.get)(row).filter(|_| row.failure.is_none())
    }
}

/// Finished run of a ladder.
#[derive(Debug, Clone)]
pub struct TradeRun {
    /// Rung of the run.
    pub rung: LadderRung,
    /// Row of the run, or the reason why the scene cannot be run.
    pub row: Result<TradeRow, String>,
}

/// Reference value of a quantity.
#[derive(Debug, Clone, PartialEq)]
pub enum ReferenceValue {
    /// Limit of refinement, and the knob of its mesh family.
    Limit(RefinementLimit, &'static str),
    /// Limit that cannot be trusted.
    Refused(NoLimit),
    /// Fewer than three runs with a value.
    Missing,
}

/// Run with its errors and its position on the curve.
#[derive(Debug, Clone)]
pub struct AssessedRun {
    /// Finished run.
    pub run: TradeRun,
    /// Relative errors of the [`QUANTITIES`]; `None` without reference or value.
    pub errors: [Option<f64>; 4],
    /// Greatest of the errors.
    pub error: Option<f64>,
    /// Greatest error of this run and of all finer runs of its knob.
    pub confirmed: Option<f64>,
    /// True on the Pareto front: no other run is cheaper and more accurate.
    pub is_best: bool,
}

/// Error-cost curve of a scene.
#[derive(Debug, Clone)]
pub struct TradeCurve {
    /// Reference values of the [`QUANTITIES`].
    pub references: [ReferenceValue; 4],
    /// Runs in the order of the ladder.
    pub runs: Vec<AssessedRun>,
}

impl TradeCurve {
    /// Assesses finished runs.
    pub fn assess(runs: &[TradeRun]) -> Self {
        let references = QUANTITIES.map(|quantity| reference_value(&quantity, runs));
        let errors: Vec<[Option<f64>; 4]> = runs.iter().map(|run| relative_errors(run, &references)).collect();
        let worst: Vec<Option<f64>> = errors.iter().map(|all| greatest_error(all)).collect();
        let cost = |run: &TradeRun| run.row.as_ref().map_or(f64::INFINITY, |row| row.element_updates);
        let point = |(run, error): (&TradeRun, &Option<f64>)| {
            let LadderRung { knob, refinement, .. } = run.rung;
            // The unmodified scene belongs to its own mesh family.
            let knob = if knob.is_empty() { MESH } else { knob };
            FrontPoint { knob, refinement, cost: cost(run), error: *error }
        };
        let points: Vec<FrontPoint> = runs.iter().zip(&worst).map(point).collect();
        let confirmed = confirmed_errors(&points);
        let costs: Vec<f64> = points.iter().map(|point| point.cost).collect();
        let best = pareto_front(&costs, &confirmed);
        let all = runs.iter().cloned().zip(errors).zip(worst).zip(confirmed).zip(best);
        let assessed = all.map(|((((run, errors), error), confirmed), is_best)| AssessedRun {
            run,
            errors,
            error,
            confirmed,
            is_best,
        });
        Self { references, runs: assessed.collect() }
    }
}

/// Extrapolates the three finest meshes: of the scene's own family, else of the remeshed family.
fn reference_value(quantity: &ComparedQuantity, runs: &[TradeRun]) -> ReferenceValue {
    let families = [MESH, REMESHED].map(|family| (family, finest_three(quantity, runs, family)));
    let enough = families.into_iter().find_map(|(family, three)| three.map(|three| (family, three)));
    let scale = runs.iter().find_map(|run| (quantity.scale)(run.row.as_ref().ok()?));
    enough.map_or(ReferenceValue::Missing, |(family, three)| match extrapolate_limit(three, scale) {
        Ok(limit) => ReferenceValue::Limit(limit, family),
        Err(why) => ReferenceValue::Refused(why),
    })
}

/// Returns the three finest runs of a mesh family, finest last.
///
/// The unmodified scene belongs to the family of its own mesh. Remeshed runs must each be twice as fine as the one
/// before: a new mesh starts from a repeatedly halved square, and intermediate sizes belong to a different family.
fn finest_three(quantity: &ComparedQuantity, runs: &[TradeRun], family: &str) -> Option<[MeshValue; 3]> {
    let is_of_family = |run: &&TradeRun| run.rung.knob == family || (family == MESH && run.rung.knob.is_empty());
    let sized =
        |run: &TradeRun| Some((run.rung.relative_size?, run.row.as_ref().ok().and_then(|row| quantity.value(row))));
    let mut all: Vec<(f64, Option<f64>)> = runs.iter().filter(is_of_family).filter_map(sized).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let known = all.into_iter().filter_map(|(size, value)| Some(MeshValue { size, value: value? }));
    let known: Vec<MeshValue> = known.collect();
    let is_remeshed = runs.iter().filter(is_of_family).any(|run| run.row.as_ref().is_ok_and(|row| row.remeshes > 0));
    if !is_remeshed {
        return known.last_chunk::<3>().copied();
    }
    let last = *known.last()?;
    let coarser = |ratio: f64| known.iter().copied().find(|mesh| (mesh.size / last.size - ratio).abs() < 0.01 * ratio);
    Some([coarser(4.0)?, coarser(2.0)?, last])
}

/// Returns the relative error of each quantity.
fn relative_errors(run: &TradeRun, references: &[ReferenceValue; 4]) -> [Option<f64>; 4] {
    std::array::from_fn(|i| match (&references[i], &run.row) {
        (ReferenceValue::Limit(limit, _), Ok(row)) => {
            QUANTITIES[i].value(row).map(|value| (value - limit.value).abs() / limit.scale)
        }
        (ReferenceValue::Limit(..) | ReferenceValue::Refused(_) | ReferenceValue::Missing, _) => None,
    })
}

/// Returns the greatest known error; missing errors are ignored.
fn greatest_error(errors: &[Option<f64>]) -> Option<f64> {
    errors.iter().flatten().copied().reduce(f64::max)
}

#[cfg(test)]
pub mod tests {
    use super::{MESH, ReferenceValue, TradeCurve, TradeRow, TradeRun};
    use crate::trade::ladder::LadderRung;

    /// Returns a run of size h with first-order errors, 1 % at size 1, and a cost of h⁻³.
    pub fn run(knob: &'static str, refinement: f64, size: f64) -> TradeRun {
        let row = TradeRow {
            end_time: 1.0,
            elements: 100,
            remeshes: 0,
            element_updates: 1e6 * size.powi(-3),
            cpu_seconds: size.powi(-3),
            wall_seconds: size.powi(-3),
            peak_depth: 0.01 * (1.0 - 0.01 * size),
            contact_duration: None,
            final_speed: 3.0 + (9.0 * size).sin(),
            initial_speed: 5.0,
            peak_force: 100.0 * (1.0 + 0.005 * size * size),
            energy_defect: 1e-4,
            digest: String::new(),
            failure: None,
        };
        TradeRun {
            rung: LadderRung { knob, refinement, relative_size: Some(size), ..LadderRung::unmodified() },
            row: Ok(row),
        }
    }

    pub fn curve() -> TradeCurve {
        let mut failed = run("cfl", -1.0, 1.0);
        failed.row.as_mut().unwrap().failure = Some("inverted".to_owned());
        let refused = TradeRun { row: Err("too coarse".to_owned()), ..run(MESH, -2.0, 2.0) };
        TradeCurve::assess(&[
            run("", 0.0, 1.0),
            run(MESH, -1.0, 1.4),
            run(MESH, 1.0, 0.7),
            run(MESH, 2.0, 0.5),
            failed,
            refused,
        ])
    }

    #[test]
    fn errors_are_those_of_the_law_and_absent_without_a_limit() {
        let curve = curve();
        for (assessed, size) in curve.runs.iter().zip([1.0, 1.4, 0.7, 0.5]) {
            let [depth, contact, rebound, force] = assessed.errors;
            assert!((depth.unwrap() - 0.01 * size).abs() < 1e-9, "{assessed:?}");
            assert!((force.unwrap() - 0.005 * size * size).abs() < 1e-9);
            assert_eq!((contact, rebound), (None, None));
            assert_eq!((assessed.error, assessed.is_best), (depth, true));
        }
        assert_eq!(curve.references[1], ReferenceValue::Missing);
        assert!(matches!(curve.references[2], ReferenceValue::Refused(_)));
    }

    #[test]
    fn remeshed_runs_are_compared_with_runs_twice_as_fine() {
        let remeshed = |size: f64, off: f64| {
            let mut run = run(if size == 1.0 { "" } else { MESH }, -size.log2(), size);
            let row = run.row.as_mut().unwrap();
            (row.remeshes, row.peak_depth) = (1, row.peak_depth + off);
            run
        };
        let other = [2.8, 1.4, 0.7].map(|size| remeshed(size, 1e-4 * size.sin()));
        let runs = [[4.0, 2.0, 1.0, 0.5].map(|size| remeshed(size, 0.0)).as_slice(), &other].concat();
        let ReferenceValue::Limit(limit, _) = &TradeCurve::assess(&runs).references[0] else { panic!("a limit") };
        assert!((limit.value - 0.01).abs() < 1e-9 && (limit.order - 1.0).abs() < 1e-6, "{limit:?}");
        assert_eq!(TradeCurve::assess(&runs[1..3]).references[0], ReferenceValue::Missing);
    }

    #[test]
    fn failed_runs_are_listed_without_an_error() {
        let curve = curve();
        assert!(curve.runs[4..].iter().all(|assessed| assessed.error.is_none() && !assessed.is_best));
    }
}
