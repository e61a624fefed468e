//! Which strength to try next: a root of ln depth against ln strength, kept between a gel that is too weak and one that is too strong.

/// The depth is met within this part of it: a tenth of what a change of the mesh does to it.
const TOLERANCE: f64 = 1e-3;
/// Runs after which it is given up; a smooth depth takes three to five.
const MOST_TRIALS: usize = 20;
/// d ln depth / d ln strength until two runs tell: -1/2 lies between a gel without inertia (-1) and one at its cap (0).
const SLOPE: f64 = -0.5;
/// Slopes that two runs may tell; beyond, they tell of noise.
const SLOPES: (f64, f64) = (-2.0, -0.1);
/// Most by which ln strength moves at once while no bracket is known: a factor of four.
const STRIDE: f64 = 1.4;
/// Least strength that is tried, in strengths to begin with.
const WEAKEST: f64 = 1e-3;
/// A bracket of ln strength as narrow as this holds a jump of the depth.
const NARROWEST: f64 = 1e-4;
/// How far beside a jump other strengths are tried, in ln strength. The depth is about half of that away there, and where meshes are
/// exchanged it scatters by 0.3 %.
const BESIDE: [f64; 3] = [4e-4, 1.6e-3, 6.4e-3];
/// Failures without a run between them after which it is given up.
const MOST_FAILURES: usize = 5;

/// What a strength gave.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// The projectile stopped.
    Stopped {
        /// How deep, m.
        depth: f64,
        /// When, s.
        time: f64,
    },
    /// It went on beyond the depth, or through the gel.
    Through,
    /// The run did not get so far: why.
    Failed(String),
}

/// A strength and what it gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Strength at 1/s, Pa.
    pub yield_stress: f64,
    /// What it gave.
    pub outcome: Outcome,
}

/// What to do next.
#[derive(Debug, Clone, PartialEq)]
pub enum Next {
    /// Try this strength, Pa.
    Try(f64),
    /// The best trial fits.
    Fitted,
    /// There is no strength that gives the depth: found and expected.
    OutOfReach(String),
    /// It goes no further: why.
    GivenUp(String),
}

/// The strengths tried so far.
#[derive(Debug)]
pub struct Search {
    target: f64,
    first: f64,
    strongest: f64,
    /// In the order in which they were made.
    pub trials: Vec<Trial>,
}

/// ln strength, and ln depth relative to the target, infinite for a projectile that goes through.
type Point = (f64, f64);

impl Search {
    /// For a depth, m, from a first strength, Pa, up to the cap of the law, Pa.
    pub fn new(target: f64, first: f64, strongest: f64) -> Self {
        Self { target, first, strongest, trials: vec![] }
    }

    /// The trial whose depth is nearest.
    pub fn best(&self) -> Option<(&Trial, f64)> {
        let stopped = self.trials.iter().filter_map(|trial| match trial.outcome {
            Outcome::Stopped { depth, .. } => Some((trial, depth)),
            Outcome::Through | Outcome::Failed(_) => None,
        });
        stopped.min_by(|a, b| self.miss(a.1).total_cmp(&self.miss(b.1)))
    }

    /// Distance of a depth from the one that is wanted, as a part of it.
    pub fn miss(&self, depth: f64) -> f64 {
        (depth / self.target - 1.0).abs()
    }

    /// When the projectile stopped last, s.
    pub fn time_to_stop(&self) -> Option<f64> {
        self.trials.iter().rev().find_map(|trial| match trial.outcome {
            Outcome::Stopped { time, .. } => Some(time),
            Outcome::Through | Outcome::Failed(_) => None,
        })
    }

    /// What to do next.
    pub fn next(&self) -> Next {
        if self.best().is_some_and(|(_, depth)| self.miss(depth) <= TOLERANCE) {
            return Next::Fitted;
        }
        let points = self.points();
        match points.windows(2).find(|pair| pair[0].1 > 0.0 && pair[1].1 <= 0.0) {
            Some(pair) if pair[1].0 - pair[0].0 < NARROWEST => self.beside(pair[0].0, pair[1].0),
            _ if self.is_at_its_end() => Next::GivenUp(format!("found none in {MOST_TRIALS} runs")),
            Some(pair) => self.between(pair[0], pair[1]),
            None if points.is_empty() => self.begin(),
            None => self.onwards(&points),
        }
    }

    /// Runs that tell something, from the weakest gel to the strongest.
    fn points(&self) -> Vec<Point> {
        let point = |trial: &Trial| match trial.outcome {
            Outcome::Stopped { depth, .. } => Some((trial.yield_stress.ln(), (depth / self.target).ln())),
            Outcome::Through => Some((trial.yield_stress.ln(), f64::INFINITY)),
            Outcome::Failed(_) => None,
        };
        let mut points: Vec<Point> = self.trials.iter().filter_map(point).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    }

    /// Until a run tells something: the first strength, then some beside it, each further away.
    fn begin(&self) -> Next {
        let n = self.trials.len();
        if n >= MOST_FAILURES {
            return Next::GivenUp(format!("found {n} runs that failed with strengths about {:e} Pa", self.first));
        }
        let away = 0.2 * n.div_ceil(2) as f64;
        let way = if n.is_multiple_of(2) { -away } else { away };
        self.attempt(self.first.ln() + way)
    }

    /// Between a gel that is too weak and one that is too strong.
    fn between(&self, weak: Point, strong: Point) -> Next {
        let width = strong.0 - weak.0;
        let straight = if weak.1.is_finite() { weak.1 / (weak.1 - strong.1) } else { 0.5 };
        // A bracket of which one end stays is halved.
        let straight = if self.stays(weak, strong) { 0.5 } else { straight.clamp(0.05, 0.95) };
        let places = [straight, 0.5, 0.25, 0.75, 0.125, 0.875].map(|share| weak.0 + share * width);
        let clear = places.into_iter().find(|place| self.is_clear(*place, 0.1 * width) && self.is_new(*place));
        clear.map_or_else(|| Next::GivenUp("found runs that fail on all sides of it".to_owned()), |y| self.attempt(y))
    }

    /// On both sides of a jump, further and further away: where one strength misses the depth by the jump, another may meet it.
    fn beside(&self, weak: f64, strong: f64) -> Next {
        let mut places = BESIDE.iter().flat_map(|away| [weak - away, strong + away]);
        let found = if self.is_at_its_end() { None } else { places.find(|place| self.is_new(*place)) };
        let why = "the depth jumps across the one that is wanted; a finer mesh makes it smoother";
        let jumps = || Next::GivenUp(format!("between {:e} and {:e} Pa {why}", weak.exp(), strong.exp()));
        found.map_or_else(jumps, |place| self.attempt(place))
    }

    /// Whether the strength there was not tried yet.
    fn is_new(&self, place: f64) -> bool {
        let stress = self.within(place);
        self.trials.iter().all(|trial| trial.yield_stress != stress)
    }

    fn is_at_its_end(&self) -> bool {
        self.trials.len() >= MOST_TRIALS
    }

    /// Whether the two last runs lie on the same side of a bracket that both made narrower.
    fn stays(&self, weak: Point, strong: Point) -> bool {
        let [.., a, b] = self.trials.as_slice() else { return false };
        let (a, b) = (a.yield_stress.ln(), b.yield_stress.ln());
        (b == weak.0 && a < b) || (b == strong.0 && a > b)
    }

    /// Further on while all runs are too deep, or all too shallow.
    fn onwards(&self, points: &[Point]) -> Next {
        let deep = points[0].1 > 0.0;
        let (last, other) =
            if deep { (points[points.len() - 1], points.iter().rev().nth(1)) } else { (points[0], points.get(1)) };
        if deep && last.0 >= self.strongest.ln() - NARROWEST {
            return Next::OutOfReach(self.beyond("less than that with the greatest strength, its cap", last));
        }
        if !deep && last.0 <= (WEAKEST * self.first).ln() + NARROWEST {
            return Next::OutOfReach(self.beyond("more than that with the least strength that is tried", last));
        }
        let told = other.map(|other| (last.1 - other.1) / (last.0 - other.0)).filter(|slope| slope.is_finite());
        let slope = told.unwrap_or(SLOPE).clamp(SLOPES.0, SLOPES.1);
        let stride = if last.1.is_finite() { -last.1 / slope } else { STRIDE };
        let mut place = last.0 + stride.clamp(-STRIDE, STRIDE);
        while !self.is_clear(place, 0.1 * (place - last.0).abs()) && (place - last.0).abs() > NARROWEST {
            place = 0.5 * (place + last.0);
        }
        self.attempt(place)
    }

    fn beyond(&self, what: &str, last: Point) -> String {
        let there = if last.1.is_finite() {
            format!("{:.2} mm", 1e3 * self.target * last.1.exp())
        } else {
            "through the gel".to_owned()
        };
        let strength = last.0.exp();
        format!(
            "found {:?} m, {what} ({strength:.4e} Pa: {there}), expected a depth that some strength gives",
            self.target
        )
    }

    /// Whether no run has failed near a place.
    fn is_clear(&self, place: f64, margin: f64) -> bool {
        let failed = self.trials.iter().filter(|trial| matches!(trial.outcome, Outcome::Failed(_)));
        failed.into_iter().all(|trial| (trial.yield_stress.ln() - place).abs() >= margin)
    }

    fn attempt(&self, place: f64) -> Next {
        Next::Try(self.within(place))
    }

    /// A strength in five digits, Pa, as it is written into a scene, in the range of strengths.
    fn within(&self, place: f64) -> f64 {
        let within = place.exp().clamp(WEAKEST * self.first, self.strongest);
        format!("{within:.4e}").parse::<f64>().map_or(within, |rounded| rounded.min(self.strongest))
    }
}

#[cfg(test)]
mod tests {
    use super::{Next, Outcome, Search, Trial};

    /// Tries strengths of a law of depth until the search ends.
    fn searched(target: f64, law: impl Fn(f64) -> Outcome) -> (Search, Next) {
        let mut search = Search::new(target, 0.1e6, 1.6e6);
        loop {
            match search.next() {
                Next::Try(yield_stress) => search.trials.push(Trial { yield_stress, outcome: law(yield_stress) }),
                end => return (search, end),
            }
        }
    }

    fn stopped(depth: f64) -> Outcome {
        Outcome::Stopped { depth, time: 1e-3 }
    }

    /// 80 mm at 0.1 MPa.
    fn power(yield_stress: f64) -> Outcome {
        stopped(0.08 * (yield_stress / 0.1e6).powf(-0.3))
    }

    #[test]
    fn a_smooth_depth_is_met_in_a_few_runs() {
        for target in [0.02, 0.05, 0.08, 0.085, 0.15, 0.4] {
            let expected: f64 = 0.1e6 * (target / 0.08f64).powf(-1.0 / 0.3);
            let (search, end) = searched(target, power);
            if expected > 1.6e6 {
                assert!(matches!(end, Next::OutOfReach(_)), "{target}: {end:?}");
                continue;
            }
            let (best, depth) = search.best().unwrap();
            assert_eq!(end, Next::Fitted, "{target}");
            assert!((depth / target - 1.0).abs() <= 1e-3, "{target}: {depth}");
            assert!((best.yield_stress / expected - 1.0).abs() < 5e-3, "{target}: {best:?}");
            assert!(search.trials.len() <= 8, "{target}: {:?}", search.trials);
        }
    }

    #[test]
    fn a_gel_that_is_shot_through_bounds_the_strength() {
        let law = |y: f64| if y < 0.09e6 { Outcome::Through } else { power(y) };
        let (search, end) = searched(0.06, law);
        assert_eq!(end, Next::Fitted, "{:?}", search.trials);
        let through = |y: f64| if y < 0.5e6 { Outcome::Through } else { power(y) };
        let (search, end) = searched(0.045, through);
        assert_eq!(end, Next::Fitted, "{:?}", search.trials);
    }

    #[test]
    fn runs_that_fail_are_gone_around() {
        for (from, to) in [(0.09e6, 0.11e6), (0.05e6, 0.07e6), (0.12e6, 0.2e6)] {
            let law = |y: f64| if y > from && y < to { Outcome::Failed("inverted".to_owned()) } else { power(y) };
            let (search, end) = searched(0.0875, law);
            let expected = 0.1e6 * (0.0875f64 / 0.08).powf(-1.0 / 0.3);
            let hidden = expected > from && expected < to;
            assert_eq!(end == Next::Fitted, !hidden, "{from}: {end:?} {:?}", search.trials);
        }
    }

    #[test]
    fn what_cannot_be_met_ends_with_a_reason() {
        let (_, end) = searched(0.01, power);
        assert!(matches!(&end, Next::OutOfReach(why) if why.contains("its cap (1.6000e6 Pa: 34.8")), "{end:?}");
        let (_, end) = searched(50.0, power);
        assert!(matches!(&end, Next::OutOfReach(why) if why.contains("least strength")), "{end:?}");
        let (search, end) = searched(0.08, |_| Outcome::Failed("inverted".to_owned()));
        assert!(matches!(&end, Next::GivenUp(why) if why.contains("5 runs that failed")), "{end:?}");
        assert!(search.best().is_none());
        let (_, end) = searched(0.08, |y| stopped(if y < 0.123e6 { 0.09 } else { 0.07 }));
        assert!(matches!(&end, Next::GivenUp(why) if why.contains("jumps")), "{end:?}");
    }

    #[test]
    fn beside_a_jump_of_the_depth_another_strength_is_found() {
        // A jump by a hundredth where the depth is met, and a stretch of strengths beside it that are spared.
        let jumping = |y: f64| {
            let Outcome::Stopped { depth, .. } = power(y) else { unreachable!("it stops") };
            stopped(depth * if y < 0.1e6 { 1.005 } else { 0.995 })
        };
        let law = |y: f64| if (0.10012e6..0.10022e6).contains(&y) { power(y) } else { jumping(y) };
        let (search, end) = searched(0.08, law);
        assert_eq!(end, Next::Fitted, "{:?}", search.trials);
        let (_, end) = searched(0.08, jumping);
        assert!(matches!(&end, Next::GivenUp(why) if why.contains("jumps")), "{end:?}");
    }
}
