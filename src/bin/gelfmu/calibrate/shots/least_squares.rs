//! Damped Gauss–Newton method for shots: the secant version of the Levenberg–Marquardt method (Madsen, Nielsen and
//! Tingleff 2004, Methods for non-linear least squares problems, 3.2 and 3.5).
//!
//! The Jacobian of the computed values is that of finite differences at the start, and Broyden's rank-one update
//! corrects it between. Steps are longer than the scatter of remeshed runs. A residual is zero within a window: each step is the
//! least squares of the linear model with its windows, by a Newton method with an active set.

use super::target::FitTarget;
use crate::failure::CommandError;
use nalgebra::{DMatrix, DVector};

/// Step of the finite differences, in logarithms: remeshed runs scatter by 0.1 to 0.3 %.
const DIFFERENCE: f64 = 0.07;
/// Least step that updates the Jacobian, in logarithms; that of a shorter step would be the scatter's.
const LEAST_SECANT: f64 = 0.03;
/// Longest step of a coordinate, in logarithms: a factor of two.
const LONGEST_STEP: f64 = 0.7;
/// Residual, in bands, below which a shot is met.
const MET: f64 = 0.1;
/// Predicted decrease of half of the sum of squares below which a step is not worth its runs.
const LEAST_DECREASE: f64 = 0.005;
/// Damping of the first step, relative to the greatest diagonal element of the normal equations.
const FIRST_DAMPING: f64 = 1e-4;
/// Most iterations.
const MOST_ITERATIONS: usize = 15;
/// Rejected steps in a row after which the Jacobian is computed anew, and after which the fit ends.
const REJECTED_STEPS: [usize; 2] = [2, 4];
/// Most changes of the active set in one step.
const MOST_ACTIVE_SETS: usize = 30;

/// Reason to leave a fit at once.
#[derive(Debug)]
pub enum FitBreak {
    /// The user interrupted it.
    Interrupted,
    /// A run cannot be carried out.
    Command(CommandError),
}

impl From<CommandError> for FitBreak {
    fn from(error: CommandError) -> Self {
        Self::Command(error)
    }
}

/// Computed values of the shots at a point, or the refusal of a shot without a value.
pub type PointOutcome = Result<DVector<f64>, String>;

/// Computes the shots at some points at once; the text says where the fit is.
pub type ShotModel<'a> = dyn FnMut(&str, &[DVector<f64>]) -> Result<Vec<PointOutcome>, FitBreak> + 'a;

/// Ending of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FitEnd {
    /// All shots are met, or no step promises a smaller sum of squares.
    Converged,
    /// No tried step gave a smaller sum of squares.
    Stalled,
    /// The number of iterations is spent.
    Exhausted,
    /// The user interrupted the fit.
    Interrupted,
}

/// Best point of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitResult {
    /// Coordinates.
    pub point: DVector<f64>,
    /// Computed values; `None` if the fit was interrupted in its first runs.
    pub computed: Option<DVector<f64>>,
    /// Ending.
    pub end: FitEnd,
    /// Number of steps.
    pub iterations: usize,
}

/// Fit in progress.
struct MarquardtFit<'a> {
    targets: &'a [FitTarget],
    /// Upper bounds of the coordinates.
    upper: &'a DVector<f64>,
    point: DVector<f64>,
    computed: Option<DVector<f64>>,
    iterations: usize,
}

/// Accepted values and their linear model.
struct LinearModel {
    computed: DVector<f64>,
    jacobian: DMatrix<f64>,
    damping: f64,
    /// Factor on the damping after a rejected step.
    growth: f64,
    /// True for a Jacobian of finite differences at the accepted point.
    is_fresh: bool,
    /// Rejected steps in a row.
    rejected: usize,
}

/// Fits coordinates to targets from a start point, each coordinate at most its upper bound.
///
/// # Errors
/// The error of a run, and a shot without a value at the start point.
pub fn fit(
    targets: &[FitTarget],
    upper: &DVector<f64>,
    start: DVector<f64>,
    model: &mut ShotModel<'_>,
) -> Result<FitResult, CommandError> {
    let mut fit = MarquardtFit { targets, upper, point: start, computed: None, iterations: 0 };
    let end = match fit.iterate(model) {
        Ok(end) => end,
        Err(FitBreak::Interrupted) => FitEnd::Interrupted,
        Err(FitBreak::Command(error)) => return Err(error),
    };
    Ok(FitResult { point: fit.point, computed: fit.computed, end, iterations: fit.iterations })
}

impl MarquardtFit<'_> {
    /// Iterates until the fit ends.
    fn iterate(&mut self, model: &mut ShotModel<'_>) -> Result<FitEnd, FitBreak> {
        let start = evaluate_one(model, "start", &self.point)?;
        let computed = start.map_err(|why| FitBreak::Command(CommandError::BadInput(why)))?;
        self.computed = Some(computed.clone());
        if self.is_met(&computed) {
            return Ok(FitEnd::Converged);
        }
        let jacobian = self.difference(&computed, model)?;
        let damping = FIRST_DAMPING * self.greatest_diagonal(&jacobian);
        let mut linear = LinearModel { computed, jacobian, damping, growth: 2.0, is_fresh: true, rejected: 0 };
        while self.iterations < MOST_ITERATIONS {
            let step = self.step(&linear);
            let decrease = self.half_squares(&linear.computed) - self.half_squares(&linear.predict(&step));
            if self.is_met(&linear.computed) || (decrease < LEAST_DECREASE && linear.is_fresh) {
                return Ok(FitEnd::Converged);
            }
            if linear.rejected >= REJECTED_STEPS[1] && linear.is_fresh {
                return Ok(FitEnd::Stalled);
            }
            if !linear.is_fresh && (decrease < LEAST_DECREASE || linear.rejected >= REJECTED_STEPS[0]) {
                linear.jacobian = self.difference(&linear.computed, model)?;
                (linear.is_fresh, linear.rejected) = (true, 0);
                continue;
            }
            self.iterations += 1;
            let trial = evaluate_one(model, &format!("step {}", self.iterations), &(&self.point + &step))?;
            self.take(&mut linear, &step, decrease, trial.ok());
        }
        Ok(if self.is_met(&linear.computed) { FitEnd::Converged } else { FitEnd::Exhausted })
    }

    /// Accepts or rejects a step by its gain ratio, and updates damping (Nielsen 1999) and Jacobian.
    fn take(&mut self, linear: &mut LinearModel, step: &DVector<f64>, decrease: f64, trial: Option<DVector<f64>>) {
        let before = self.half_squares(&linear.computed);
        let gain = trial.as_ref().map_or(-1.0, |computed| (before - self.half_squares(computed)) / decrease);
        if let Some(computed) = &trial
            && step.amax() >= LEAST_SECANT
        {
            linear.update_jacobian(step, computed);
        }
        match trial {
            Some(computed) if gain > 0.0 => {
                self.point += step;
                self.computed = Some(computed.clone());
                linear.computed = computed;
                linear.damping *= (1.0 - (2.0 * gain - 1.0).powi(3)).max(1.0 / 3.0);
                (linear.growth, linear.rejected, linear.is_fresh) = (2.0, 0, false);
            }
            _ => {
                linear.damping *= linear.growth;
                linear.growth *= 2.0;
                linear.rejected += 1;
            }
        }
    }

    /// Returns true if every shot is met.
    fn is_met(&self, computed: &DVector<f64>) -> bool {
        self.targets.iter().zip(computed).all(|(target, computed)| target.residual(*computed).abs() <= MET)
    }

    /// Returns half of the sum of the squared residuals.
    fn half_squares(&self, computed: &DVector<f64>) -> f64 {
        let squares = self.targets.iter().zip(computed).map(|(target, computed)| target.residual(*computed).powi(2));
        0.5 * squares.sum::<f64>()
    }

    /// Returns the Jacobian of the computed values by forward differences, or backward ones at a bound and where a shot
    /// has no value.
    fn difference(&self, computed: &DVector<f64>, model: &mut ShotModel<'_>) -> Result<DMatrix<f64>, FitBreak> {
        let n = self.point.len();
        let shift = |i: usize, step: f64| {
            let mut point = self.point.clone();
            point[i] += step;
            point
        };
        let mut steps: Vec<f64> = (0..n)
            .map(|i| if self.point[i] + DIFFERENCE <= self.upper[i] { DIFFERENCE } else { -DIFFERENCE })
            .collect();
        let points: Vec<DVector<f64>> = (0..n).map(|i| shift(i, steps[i])).collect();
        let mut columns = vec![];
        for (i, outcome) in model("differences", &points)?.into_iter().enumerate() {
            let shifted = match outcome {
                Ok(shifted) => shifted,
                Err(_) if steps[i] > 0.0 => {
                    steps[i] = -DIFFERENCE;
                    let other = evaluate_one(model, "differences", &shift(i, steps[i]))?;
                    other.map_err(|why| FitBreak::Command(CommandError::BadInput(why)))?
                }
                Err(why) => return Err(FitBreak::Command(CommandError::BadInput(why))),
            };
            columns.push((shifted - computed) / steps[i]);
        }
        Ok(DMatrix::from_columns(&columns))
    }

    /// Returns the greatest diagonal element of the normal equations of all targets.
    fn greatest_diagonal(&self, jacobian: &DMatrix<f64>) -> f64 {
        let scaled = self.scale_rows(jacobian, &vec![true; self.targets.len()]);
        scaled.column_iter().map(|column| column.norm_squared()).fold(f64::MIN_POSITIVE, f64::max)
    }

    /// Returns the rows of the active targets, divided by their bands; other rows are zero.
    fn scale_rows(&self, jacobian: &DMatrix<f64>, is_active: &[bool]) -> DMatrix<f64> {
        let mut scaled = jacobian.clone();
        for ((mut row, target), is_active) in scaled.row_iter_mut().zip(self.targets).zip(is_active) {
            row *= if *is_active { 1.0 / target.band } else { 0.0 };
        }
        scaled
    }

    /// Returns the step within the bounds, at most [`LONGEST_STEP`] long.
    fn step(&self, linear: &LinearModel) -> DVector<f64> {
        let room = self.upper - &self.point;
        let mut held: Vec<Option<f64>> = vec![None; room.len()];
        loop {
            let step = self.windowed_step(linear, &held);
            let beyond = (0..room.len()).find(|&i| held[i].is_none() && step[i] > room[i]);
            let Some(i) = beyond else {
                return &step * (LONGEST_STEP / step.amax().max(LONGEST_STEP));
            };
            held[i] = Some(room[i]);
        }
    }

    /// Returns the damped step of the linear model with its windows; the held coordinates are given.
    fn windowed_step(&self, linear: &LinearModel, held: &[Option<f64>]) -> DVector<f64> {
        let fixed = DVector::from_iterator(held.len(), held.iter().map(|step| step.unwrap_or(0.0)));
        let objective =
            |step: &DVector<f64>| self.half_squares(&linear.predict(step)) + 0.5 * linear.damping * step.norm_squared();
        let mut best = fixed.clone();
        let mut last = best.clone();
        for _ in 0..MOST_ACTIVE_SETS {
            let predicted = linear.predict(&last);
            let edges: Vec<Option<f64>> =
                self.targets.iter().zip(predicted.iter()).map(|(target, value)| target.violated_edge(*value)).collect();
            let next = self.active_step(linear, &edges, held, &fixed);
            if objective(&next) < objective(&best) {
                best.clone_from(&next);
            }
            if (&next - &last).amax() < 1e-12 {
                break;
            }
            last = next;
        }
        best
    }

    /// Returns the damped least-squares step of the targets with a violated edge.
    fn active_step(
        &self,
        linear: &LinearModel,
        edges: &[Option<f64>],
        held: &[Option<f64>],
        fixed: &DVector<f64>,
    ) -> DVector<f64> {
        let is_active: Vec<bool> = edges.iter().map(Option::is_some).collect();
        let mut rows = self.scale_rows(&linear.jacobian, &is_active);
        let at_fixed = linear.predict(fixed);
        let misses = edges.iter().zip(at_fixed.iter()).zip(self.targets);
        let misses = misses.map(|((edge, value), target)| edge.map_or(0.0, |edge| (value - edge) / target.band));
        let misses = DVector::from_iterator(edges.len(), misses);
        for (mut column, held) in rows.column_iter_mut().zip(held) {
            if held.is_some() {
                column.fill(0.0);
            }
        }
        let normal = rows.tr_mul(&rows) + DMatrix::identity(held.len(), held.len()) * linear.damping;
        let free = normal.cholesky().map(|factor| factor.solve(&-rows.tr_mul(&misses)));
        free.map_or_else(|| fixed.clone(), |free| free + fixed)
    }
}

impl LinearModel {
    /// Returns the computed values that the model predicts after a step.
    fn predict(&self, step: &DVector<f64>) -> DVector<f64> {
        &self.computed + &self.jacobian * step
    }

    /// Broyden's rank-one update: afterwards the Jacobian explains the change of the computed values over a step.
    fn update_jacobian(&mut self, step: &DVector<f64>, computed: &DVector<f64>) {
        let unexplained = computed - self.predict(step);
        self.jacobian += unexplained * step.transpose() / step.norm_squared();
    }
}

/// Computes the shots at one point.
fn evaluate_one(model: &mut ShotModel<'_>, stage: &str, point: &DVector<f64>) -> Result<PointOutcome, FitBreak> {
    let mut outcomes = model(stage, std::slice::from_ref(point))?;
    Ok(outcomes.pop().expect("one outcome for each point"))
}

#[cfg(test)]
mod tests;
