//! Error against cost: references, errors of every run, and which runs are worth their cost.

use super::front::{Point, held, pareto};
use super::ladder::{MESH, REMESHED, Rung};
use super::richardson::{Limit, NoLimit, limit};
use super::row::Row;

/// A figure of a run that has an error.
pub struct Quantity {
    /// Name in files.
    pub key: &'static str,
    /// For people.
    pub name: &'static str,
    /// What it is shown in, and how many of them make one of the SI.
    pub unit: (&'static str, f64),
    get: fn(&Row) -> Option<f64>,
    /// What its errors are relative to, where that is not itself.
    scale: fn(&Row) -> Option<f64>,
}

/// What is compared: how deep, how long, how fast back (of the speed at the start: its own may be next to nothing), how hard.
pub const QUANTITIES: [Quantity; 4] = [
    Quantity { key: "peak_depth", name: "depth", unit: ("mm", 1e3), get: |row| Some(row.peak_depth), scale: itself },
    Quantity {
        key: "contact_duration",
        name: "contact",
        unit: ("ms", 1e3),
        get: |row| row.contact_duration,
        scale: itself,
    },
    Quantity {
        key: "final_speed",
        name: "rebound",
        unit: ("m/s", 1.0),
        get: |row| Some(row.final_speed),
        scale: |row| (row.initial_speed > 0.0).then_some(row.initial_speed),
    },
    Quantity { key: "peak_force", name: "force", unit: ("N", 1.0), get: |row| Some(row.peak_force), scale: itself },
];

fn itself(_: &Row) -> Option<f64> {
    None
}

impl Quantity {
    /// Its value, SI; nothing of a run that failed or has none.
    pub fn of(&self, row: &Row) -> Option<f64> {
        (self.get)(row).filter(|_| row.failure.is_none())
    }
}

/// A run that was made.
#[derive(Debug, Clone)]
pub struct Run {
    /// What was asked for.
    pub rung: Rung,
    /// What came out; or why the scene cannot be run.
    pub row: Result<Row, String>,
}

/// What a quantity is compared with.
#[derive(Debug, Clone, PartialEq)]
pub enum Reference {
    /// Its limit, and which runs it is of.
    Limit(Limit, &'static str),
    /// There is none that can be trusted.
    Refused(NoLimit),
    /// Fewer than three runs have it.
    Missing,
}

/// A run on the curve.
#[derive(Debug, Clone)]
pub struct Assessed {
    /// The run.
    pub run: Run,
    /// Relative error of each of [`QUANTITIES`]; nothing without reference or value.
    pub errors: [Option<f64>; 4],
    /// The greatest of them.
    pub error: Option<f64>,
    /// The greatest of that and of those of all finer runs of its knob.
    pub held: Option<f64>,
    /// Whether no other run is cheaper and better.
    pub best: bool,
}

/// All that was measured.
#[derive(Debug, Clone)]
pub struct Curve {
    /// What each of [`QUANTITIES`] is compared with.
    pub references: [Reference; 4],
    /// The runs, in the order of the ladder.
    pub runs: Vec<Assessed>,
}

impl Curve {
    /// Of finished runs.
    pub fn of(runs: &[Run]) -> Self {
        let references = QUANTITIES.map(|quantity| reference(&quantity, runs));
        let errors: Vec<[Option<f64>; 4]> = runs.iter().map(|run| errors(run, &references)).collect();
        let worst: Vec<Option<f64>> = errors.iter().map(|all| worst(all)).collect();
        let cost = |run: &Run| run.row.as_ref().map_or(f64::INFINITY, |row| row.element_updates);
        let point = |(run, error): (&Run, &Option<f64>)| {
            let Rung { knob, place, .. } = run.rung;
            // The scene as it comes is one of its own mesh.
            let knob = if knob.is_empty() { MESH } else { knob };
            Point { knob, place, cost: cost(run), error: *error }
        };
        let points: Vec<Point> = runs.iter().zip(&worst).map(point).collect();
        let held = held(&points);
        let best = pareto(&points.iter().zip(&held).map(|(point, held)| (point.cost, *held)).collect::<Vec<_>>());
        let all = runs.iter().cloned().zip(errors).zip(worst).zip(held).zip(best);
        let assessed = all.map(|((((run, errors), error), held), best)| Assessed { run, errors, error, held, best });
        Self { references, runs: assessed.collect() }
    }
}

/// The limit of the three finest meshes: of the scene's own, else of those that are exchanged.
fn reference(quantity: &Quantity, runs: &[Run]) -> Reference {
    let families = [MESH, REMESHED].map(|family| (family, finest(quantity, runs, family)));
    let enough = families.into_iter().find_map(|(family, three)| three.map(|three| (family, three)));
    let scale = runs.iter().find_map(|run| (quantity.scale)(run.row.as_ref().ok()?));
    enough.map_or(Reference::Missing, |(family, three)| match limit(three, scale) {
        Ok(limit) => Reference::Limit(limit, family),
        Err(why) => Reference::Refused(why),
    })
}

/// Sizes and values of the three finest runs of a family, finest last; the scene as it comes is one of its own mesh. Where the mesh
/// is exchanged, each is twice as fine as the one before: the cells of new meshes are a square that is halved again and again,
/// so that meshes between are not of their family.
fn finest(quantity: &Quantity, runs: &[Run], family: &str) -> Option<[(f64, f64); 3]> {
    let own = |run: &&Run| run.rung.knob == family || (family == MESH && run.rung.knob.is_empty());
    let value = |run: &Run| Some((run.rung.size?, run.row.as_ref().ok().and_then(|row| quantity.of(row))));
    let mut all: Vec<(f64, Option<f64>)> = runs.iter().filter(own).filter_map(value).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let known: Vec<(f64, f64)> = all.into_iter().filter_map(|(size, value)| Some((size, value?))).collect();
    let exchanged = runs.iter().filter(own).any(|run| run.row.as_ref().is_ok_and(|row| row.remeshes > 0));
    if !exchanged {
        return known.last_chunk::<3>().copied();
    }
    let last = *known.last()?;
    let coarser = |times: f64| known.iter().copied().find(|(size, _)| (size / last.0 - times).abs() < 0.01 * times);
    Some([coarser(4.0)?, coarser(2.0)?, last])
}

fn errors(run: &Run, references: &[Reference; 4]) -> [Option<f64>; 4] {
    std::array::from_fn(|i| match (&references[i], &run.row) {
        (Reference::Limit(limit, _), Ok(row)) => {
            QUANTITIES[i].of(row).map(|value| (value - limit.value).abs() / limit.scale)
        }
        (Reference::Limit(..) | Reference::Refused(_) | Reference::Missing, _) => None,
    })
}

/// The greatest of the errors; a run that lacks one that others have is not compared by the rest.
fn worst(errors: &[Option<f64>]) -> Option<f64> {
    errors.iter().flatten().copied().reduce(f64::max)
}

#[cfg(test)]
pub mod tests {
    use super::{Curve, MESH, Reference, Row, Run};
    use crate::trade::ladder::Rung;

    /// A run of size h of a law with errors of first order, 1 % at size 1, and a cost of h⁻³.
    pub fn run(knob: &'static str, place: f64, size: f64) -> Run {
        let row = Row {
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
        Run { rung: Rung { knob, place, size: Some(size), ..Rung::base() }, row: Ok(row) }
    }

    pub fn curve() -> Curve {
        let mut failed = run("cfl", -1.0, 1.0);
        failed.row.as_mut().unwrap().failure = Some("inverted".to_owned());
        let refused = Run { row: Err("too coarse".to_owned()), ..run(MESH, -2.0, 2.0) };
        Curve::of(&[run("", 0.0, 1.0), run(MESH, -1.0, 1.4), run(MESH, 1.0, 0.7), run(MESH, 2.0, 0.5), failed, refused])
    }

    #[test]
    fn errors_are_those_of_the_law_and_what_has_no_limit_has_none() {
        let curve = curve();
        for (assessed, size) in curve.runs.iter().zip([1.0, 1.4, 0.7, 0.5]) {
            let [depth, contact, rebound, force] = assessed.errors;
            assert!((depth.unwrap() - 0.01 * size).abs() < 1e-9, "{assessed:?}");
            assert!((force.unwrap() - 0.005 * size * size).abs() < 1e-9);
            assert_eq!((contact, rebound), (None, None));
            assert_eq!((assessed.error, assessed.best), (depth, true));
        }
        assert_eq!(curve.references[1], Reference::Missing);
        assert!(matches!(curve.references[2], Reference::Refused(_)));
    }

    #[test]
    fn meshes_that_are_exchanged_are_compared_with_those_twice_as_fine() {
        let exchanged = |size: f64, off: f64| {
            let mut run = run(if size == 1.0 { "" } else { MESH }, -size.log2(), size);
            let row = run.row.as_mut().unwrap();
            (row.remeshes, row.peak_depth) = (1, row.peak_depth + off);
            run
        };
        let other = [2.8, 1.4, 0.7].map(|size| exchanged(size, 1e-4 * size.sin()));
        let runs = [[4.0, 2.0, 1.0, 0.5].map(|size| exchanged(size, 0.0)).as_slice(), &other].concat();
        let Reference::Limit(limit, _) = &Curve::of(&runs).references[0] else { panic!("a limit") };
        assert!((limit.value - 0.01).abs() < 1e-9 && (limit.order - 1.0).abs() < 1e-6, "{limit:?}");
        assert_eq!(Curve::of(&runs[1..3]).references[0], Reference::Missing);
    }

    #[test]
    fn runs_that_failed_are_there_without_an_error() {
        let curve = curve();
        assert!(curve.runs[4..].iter().all(|assessed| assessed.error.is_none() && !assessed.best));
    }
}
