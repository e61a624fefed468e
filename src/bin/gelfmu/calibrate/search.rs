//! Search for the strength that gives a target depth: a safeguarded regula falsi in ln depth against ln strength.
//!
//! The bracket lies between a gel that is too weak and a gel that is too strong.

/// Most runs before the search gives up; a smooth depth takes three to five.
const MOST_TRIALS: usize = 20;
/// First guess of d ln depth / d ln strength: -1/2 lies between a gel without inertia (-1) and a gel
/// without strength (0).
const DEFAULT_SLOPE: f64 = -0.5;
/// Least and greatest slope taken from two runs; a slope outside this range is noise.
const SLOPE_RANGE: (f64, f64) = (-2.0, -0.1);
/// Largest step of ln strength while no bracket is known: a factor of four.
const LONGEST_STRIDE: f64 = 1.4;
/// Least strength tried, relative to the first one.
const WEAKEST: f64 = 1e-3;
/// Width of the bracket, in ln strength, below which the depth is taken to jump inside it.
const NARROWEST_BRACKET: f64 = 1e-4;
/// Distances from a jump, in ln strength, at which strengths are tried.
///
/// The depth changes by about half of the distance; on remeshed gels it scatters by 0.3 %.
const OFFSETS_BESIDE_JUMP: [f64; 3] = [4e-4, 1.6e-3, 6.4e-3];
/// Most failed runs before the search gives up if no run has succeeded.
const MOST_FAILURES: usize = 5;

/// Outcome of a run with one strength.
#[derive(Debug, Clone, PartialEq)]
pub enum ShotOutcome {
    /// The projectile came to rest in the gel.
    Stopped {
        /// Rest depth, m.
        depth: f64,
        /// Time of rest, s.
        time: f64,
    },
    /// The projectile reached the back face of the gel, or is below the target depth and not at rest.
    Through,
    /// The projectile was thrown back out of the gel, which is too strong.
    ThrownBack,
    /// The run failed; the reason.
    Failed(String),
}

/// Tried strength and its outcome.
#[derive(Debug, Clone, PartialEq)]
pub struct StrengthTrial {
    /// Factor on the moduli and dashpot stresses of the gel.
    pub strength: f64,
    /// Outcome of the run.
    pub outcome: ShotOutcome,
}

/// Next action of the search.
#[derive(Debug, Clone, PartialEq)]
pub enum SearchStep {
    /// Run with this strength.
    Try(f64),
    /// End: the best trial fits.
    Fitted,
    /// End: no strength gives the depth; the values found and expected.
    OutOfReach(String),
    /// End without a fit; the reason.
    GivenUp(String),
}

/// Search state: the target and all trials so far.
#[derive(Debug)]
pub struct StrengthSearch {
    target: f64,
    /// Relative error of the depth that is accepted.
    tolerance: f64,
    first: f64,
    strongest: f64,
    /// Trials in chronological order.
    pub trials: Vec<StrengthTrial>,
}

/// Successful trial in logarithmic coordinates.
#[derive(Debug, Clone, Copy)]
struct LogPoint {
    /// ln strength.
    strength: f64,
    /// ln (depth / target): ∞ for a projectile that goes through, −∞ for one that is thrown back.
    depth: f64,
}

impl StrengthSearch {
    /// Starts a search for a depth, m, within a relative tolerance, from a first strength up to a strongest one.
    pub fn new(target: f64, tolerance: f64, first: f64, strongest: f64) -> Self {
        Self { target, tolerance, first, strongest, trials: vec![] }
    }

    /// Returns the trial whose depth is nearest to the target, and that depth, m.
    pub fn best(&self) -> Option<(&StrengthTrial, f64)> {
        let stopped = self.trials.iter().filter_map(|trial| match trial.outcome {
            ShotOutcome::Stopped { depth, .. } => Some((trial, depth)),
            ShotOutcome::Through | ShotOutcome::ThrownBack | ShotOutcome::Failed(_) => None,
        });
        stopped.min_by(|a, b| self.relative_error(a.1).total_cmp(&self.relative_error(b.1)))
    }

    /// Returns the distance of a depth from the target, relative to the target.
    pub fn relative_error(&self, depth: f64) -> f64 {
        (depth / self.target - 1.0).abs()
    }

    /// Returns the time of rest of the latest successful trial, s.
    pub fn time_to_stop(&self) -> Option<f64> {
        self.trials.iter().rev().find_map(|trial| match trial.outcome {
            ShotOutcome::Stopped { time, .. } => Some(time),
            ShotOutcome::Through | ShotOutcome::ThrownBack | ShotOutcome::Failed(_) => None,
        })
    }

    /// Chooses the next strength, or ends the search.
    pub fn next_step(&self) -> SearchStep {
        if self.best().is_some_and(|(_, depth)| self.relative_error(depth) <= self.tolerance) {
            return SearchStep::Fitted;
        }
        let points = self.log_points();
        match points.windows(2).find(|pair| pair[0].depth > 0.0 && pair[1].depth <= 0.0) {
            Some(pair) if pair[1].strength - pair[0].strength < NARROWEST_BRACKET => {
                self.step_beside_jump(pair[0].strength, pair[1].strength)
            }
            _ if self.is_exhausted() => {
                SearchStep::GivenUp(format!("found none in {MOST_TRIALS} runs; --tolerance 1% accepts more"))
            }
            Some(pair) => self.step_in_bracket(pair[0], pair[1]),
            None if points.is_empty() => self.step_without_points(),
            None => self.extrapolate(&points),
        }
    }

    /// Returns the successful trials in logarithmic coordinates, from the weakest gel to the strongest.
    fn log_points(&self) -> Vec<LogPoint> {
        let point = |trial: &StrengthTrial| {
            let depth = match trial.outcome {
                ShotOutcome::Stopped { depth, .. } => (depth / self.target).ln(),
                ShotOutcome::Through => f64::INFINITY,
                ShotOutcome::ThrownBack => f64::NEG_INFINITY,
                ShotOutcome::Failed(_) => return None,
            };
            Some(LogPoint { strength: trial.strength.ln(), depth })
        };
        let mut points: Vec<LogPoint> = self.trials.iter().filter_map(point).collect();
        points.sort_by(|a, b| a.strength.total_cmp(&b.strength));
        points
    }

    /// Chooses a strength while no run has succeeded: the first strength, then strengths at growing distances.
    fn step_without_points(&self) -> SearchStep {
        let n = self.trials.len();
        if n >= MOST_FAILURES {
            return SearchStep::GivenUp(format!("found {n} runs that failed with strengths about {:e}", self.first));
        }
        let distance = 0.2 * n.div_ceil(2) as f64;
        let offset = if n.is_multiple_of(2) { -distance } else { distance };
        self.try_strength(self.first.ln() + offset)
    }

    /// Chooses a strength inside a bracket: regula falsi, or bisection if one end of the bracket stays.
    fn step_in_bracket(&self, weak: LogPoint, strong: LogPoint) -> SearchStep {
        let width = strong.strength - weak.strength;
        let secant = if weak.depth.is_finite() && strong.depth.is_finite() {
            weak.depth / (weak.depth - strong.depth)
        } else {
            0.5
        };
        let share = if self.one_end_stays(weak, strong) { 0.5 } else { secant.clamp(0.05, 0.95) };
        let candidates = [share, 0.5, 0.25, 0.75, 0.125, 0.875].map(|share| weak.strength + share * width);
        let clear = candidates.into_iter().find(|ln| self.is_clear_of_failures(*ln, 0.1 * width) && self.is_new(*ln));
        clear.map_or_else(
            || SearchStep::GivenUp("found runs that fail on all sides of it".to_owned()),
            |ln_strength| self.try_strength(ln_strength),
        )
    }

    /// Chooses a strength on either side of a jump, further and further away: the scatter of the depth may meet the
    /// target.
    fn step_beside_jump(&self, weak: f64, strong: f64) -> SearchStep {
        let mut candidates = OFFSETS_BESIDE_JUMP.iter().flat_map(|offset| [weak - offset, strong + offset]);
        let found = if self.is_exhausted() { None } else { candidates.find(|ln_strength| self.is_new(*ln_strength)) };
        let why = "the depth jumps across the one that is wanted; a finer mesh makes it smoother, --tolerance takes it as it is";
        let jumps = || SearchStep::GivenUp(format!("between {:e} and {:e} {why}", weak.exp(), strong.exp()));
        found.map_or_else(jumps, |ln_strength| self.try_strength(ln_strength))
    }

    /// Returns true if the strength has not been tried yet.
    fn is_new(&self, ln_strength: f64) -> bool {
        let strength = self.rounded_strength(ln_strength);
        self.trials.iter().all(|trial| trial.strength != strength)
    }

    /// Returns true if the number of runs is spent.
    fn is_exhausted(&self) -> bool {
        self.trials.len() >= MOST_TRIALS
    }

    /// Returns true if the two latest runs narrowed the bracket from the same side.
    fn one_end_stays(&self, weak: LogPoint, strong: LogPoint) -> bool {
        let [.., a, b] = self.trials.as_slice() else { return false };
        let (a, b) = (a.strength.ln(), b.strength.ln());
        (b == weak.strength && a < b) || (b == strong.strength && a > b)
    }

    /// Chooses a strength beyond all runs while all of them are too deep, or all too shallow.
    fn extrapolate(&self, points: &[LogPoint]) -> SearchStep {
        let is_deep = points[0].depth > 0.0;
        let (last, other) =
            if is_deep { (points[points.len() - 1], points.iter().rev().nth(1)) } else { (points[0], points.get(1)) };
        if is_deep && last.strength >= self.strongest.ln() - NARROWEST_BRACKET {
            return SearchStep::OutOfReach(
                self.describe_limit("less than that with the greatest strength that is tried", last),
            );
        }
        if !is_deep && last.strength <= (WEAKEST * self.first).ln() + NARROWEST_BRACKET {
            return SearchStep::OutOfReach(
                self.describe_limit("more than that with the least strength that is tried", last),
            );
        }
        let secant = other.map(|other| (last.depth - other.depth) / (last.strength - other.strength));
        let slope = secant.filter(|slope| slope.is_finite()).unwrap_or(DEFAULT_SLOPE);
        let slope = slope.clamp(SLOPE_RANGE.0, SLOPE_RANGE.1);
        let stride = if last.depth.is_finite() { -last.depth / slope } else { LONGEST_STRIDE.copysign(last.depth) };
        let mut ln_strength = last.strength + stride.clamp(-LONGEST_STRIDE, LONGEST_STRIDE);
        let distance = |ln_strength: f64| (ln_strength - last.strength).abs();
        while !self.is_clear_of_failures(ln_strength, 0.1 * distance(ln_strength))
            && distance(ln_strength) > NARROWEST_BRACKET
        {
            ln_strength = 0.5 * (ln_strength + last.strength);
        }
        self.try_strength(ln_strength)
    }

    /// Explains that the target lies beyond the depth at the last possible strength.
    fn describe_limit(&self, relation: &str, last: LogPoint) -> String {
        let reached = if last.depth.is_finite() {
            format!("{:.2} mm", 1e3 * self.target * last.depth.exp())
        } else if last.depth > 0.0 {
            "through the gel".to_owned()
        } else {
            "thrown back".to_owned()
        };
        let strength = last.strength.exp();
        format!(
            "found {:?} m, {relation} ({strength:.4e}: {reached}), expected a depth that some strength gives",
            self.target
        )
    }

    /// Returns true if no run has failed within a margin of ln strength.
    fn is_clear_of_failures(&self, ln_strength: f64, margin: f64) -> bool {
        let failed = self.trials.iter().filter(|trial| matches!(trial.outcome, ShotOutcome::Failed(_)));
        failed.into_iter().all(|trial| (trial.strength.ln() - ln_strength).abs() >= margin)
    }

    fn try_strength(&self, ln_strength: f64) -> SearchStep {
        SearchStep::Try(self.rounded_strength(ln_strength))
    }

    /// Returns the strength clamped to the allowed range and rounded to five digits, as in a scene file.
    fn rounded_strength(&self, ln_strength: f64) -> f64 {
        let clamped = ln_strength.exp().clamp(WEAKEST * self.first, self.strongest);
        format!("{clamped:.4e}").parse::<f64>().map_or(clamped, |rounded| rounded.min(self.strongest))
    }
}

#[cfg(test)]
mod tests {
    use super::{SearchStep, ShotOutcome, StrengthSearch, StrengthTrial};

    /// Runs a search on a law of depth until it ends.
    fn run_search(target: f64, law: impl Fn(f64) -> ShotOutcome) -> (StrengthSearch, SearchStep) {
        let mut search = StrengthSearch::new(target, 1e-3, 0.1e6, 1.6e6);
        loop {
            match search.next_step() {
                SearchStep::Try(strength) => {
                    search.trials.push(StrengthTrial { strength, outcome: law(strength) });
                }
                end => return (search, end),
            }
        }
    }

    fn stopped(depth: f64) -> ShotOutcome {
        ShotOutcome::Stopped { depth, time: 1e-3 }
    }

    /// Power law of depth: 80 mm at a strength of 1e5.
    fn power_law(strength: f64) -> ShotOutcome {
        stopped(0.08 * (strength / 0.1e6).powf(-0.3))
    }

    #[test]
    fn a_smooth_depth_is_met_in_a_few_runs() {
        for target in [0.02, 0.05, 0.08, 0.085, 0.15, 0.4] {
            let expected: f64 = 0.1e6 * (target / 0.08f64).powf(-1.0 / 0.3);
            let (search, end) = run_search(target, power_law);
            if expected > 1.6e6 {
                assert!(matches!(end, SearchStep::OutOfReach(_)), "{target}: {end:?}");
                continue;
            }
            let (best, depth) = search.best().unwrap();
            assert_eq!(end, SearchStep::Fitted, "{target}");
            assert!((depth / target - 1.0).abs() <= 1e-3, "{target}: {depth}");
            assert!((best.strength / expected - 1.0).abs() < 5e-3, "{target}: {best:?}");
            assert!(search.trials.len() <= 8, "{target}: {:?}", search.trials);
        }
    }

    #[test]
    fn a_gel_that_is_shot_through_bounds_the_strength() {
        let law = |y: f64| if y < 0.09e6 { ShotOutcome::Through } else { power_law(y) };
        let (search, end) = run_search(0.06, law);
        assert_eq!(end, SearchStep::Fitted, "{:?}", search.trials);
        let through = |y: f64| if y < 0.5e6 { ShotOutcome::Through } else { power_law(y) };
        let (search, end) = run_search(0.045, through);
        assert_eq!(end, SearchStep::Fitted, "{:?}", search.trials);
    }

    #[test]
    fn a_gel_that_throws_the_projectile_back_bounds_the_strength() {
        for limit in [0.11e6, 0.3e6] {
            let law = |y: f64| if y > limit { ShotOutcome::ThrownBack } else { power_law(y) };
            let (search, end) = run_search(0.079, law);
            assert_eq!(end, SearchStep::Fitted, "{limit}: {:?}", search.trials);
        }
        let thrown = |y: f64| if y > 0.03e6 { ShotOutcome::ThrownBack } else { power_law(y) };
        let (search, end) = run_search(0.13, thrown);
        assert_eq!(end, SearchStep::Fitted, "{:?}", search.trials);
    }

    #[test]
    fn strengths_of_failed_runs_are_avoided() {
        for (from, to) in [(0.09e6, 0.11e6), (0.05e6, 0.07e6), (0.12e6, 0.2e6)] {
            let law =
                |y: f64| if y > from && y < to { ShotOutcome::Failed("inverted".to_owned()) } else { power_law(y) };
            let (search, end) = run_search(0.0875, law);
            let expected = 0.1e6 * (0.0875f64 / 0.08).powf(-1.0 / 0.3);
            let hidden = expected > from && expected < to;
            assert_eq!(end == SearchStep::Fitted, !hidden, "{from}: {end:?} {:?}", search.trials);
        }
    }

    #[test]
    fn an_unreachable_depth_ends_with_a_reason() {
        let (_, end) = run_search(0.01, power_law);
        assert!(
            matches!(&end, SearchStep::OutOfReach(why) if why.contains("that is tried (1.6000e6: 34.8")),
            "{end:?}"
        );
        let (_, end) = run_search(50.0, power_law);
        assert!(matches!(&end, SearchStep::OutOfReach(why) if why.contains("least strength")), "{end:?}");
        let (search, end) = run_search(0.08, |_| ShotOutcome::Failed("inverted".to_owned()));
        assert!(matches!(&end, SearchStep::GivenUp(why) if why.contains("5 runs that failed")), "{end:?}");
        assert!(search.best().is_none());
        let (_, end) = run_search(0.08, |y| stopped(if y < 0.123e6 { 0.09 } else { 0.07 }));
        assert!(matches!(&end, SearchStep::GivenUp(why) if why.contains("jumps")), "{end:?}");
    }

    #[test]
    fn beside_a_jump_of_the_depth_another_strength_is_found() {
        // A jump by a hundredth where the depth is met, and a stretch of strengths beside it that are spared.
        let jumping = |y: f64| {
            let ShotOutcome::Stopped { depth, .. } = power_law(y) else { unreachable!("it stops") };
            stopped(depth * if y < 0.1e6 { 1.005 } else { 0.995 })
        };
        let law = |y: f64| if (0.10012e6..0.10022e6).contains(&y) { power_law(y) } else { jumping(y) };
        let (search, end) = run_search(0.08, law);
        assert_eq!(end, SearchStep::Fitted, "{:?}", search.trials);
        let (_, end) = run_search(0.08, jumping);
        assert!(matches!(&end, SearchStep::GivenUp(why) if why.contains("jumps")), "{end:?}");
    }
}
