//! Forecast of a run: its end, by the exit or the rest of the projectile, and the wall time until then.

use ballistic_gel::scene::Scene;

/// Time from the greatest depth to the end of a run that ends at rest, s, of the calibration shot: the gel pushes the
/// projectile back, the cavity closes, and both stand still for 2 ms.
const SETTLING: f64 = 9e-3;
/// Time from the exit to the turn of a cavity, s: that of a 9 mm bullet of 350 m/s widens for more than 5 ms.
const OPENING: f64 = 6e-3;
/// Part of the elapsed wall time over which the cost of scene time is averaged.
const RECENT_PART: f64 = 1.0 / 3.0;
/// Greatest number of points of the course: the others are dropped.
const MOST_POINTS: f64 = 4000.0;
/// Number of intervals of a quadrature along the path.
const N_INTERVALS: u32 = 32;

/// State of the projectile after a communication step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunPoint {
    /// Time, s.
    pub time: f64,
    /// Depth of the foremost point, m.
    pub depth: f64,
    /// Time of the exit, s.
    pub exit: Option<f64>,
}

/// Forecast of the end of a run from its course so far.
#[derive(Debug)]
pub struct RunForecast {
    end_time: f64,
    /// Time from the exit to the end, s.
    after_exit: f64,
    stops_at_rest: bool,
    /// Depth of the back face, m; infinite for a gel without one.
    back_face: f64,
    /// Points so far, each with the wall time at it, s; the last one is the present one.
    course: Vec<(RunPoint, f64)>,
    /// Point of the greatest depth.
    deepest: Option<RunPoint>,
}

/// Extrapolated path: kinetic energy per mass, v²/2, by depth.
#[derive(Debug, Clone, Copy)]
struct EnergyPath {
    depth: f64,
    /// Energy at that depth, J/kg.
    energy: f64,
    /// Energy that an endless path tends to, J/kg.
    limit: f64,
    /// Rate of that decay, 1/m.
    rate: f64,
}

impl EnergyPath {
    /// Returns the path through three points at equal distances: Poncelet's law, dE/dx = −(a + b E), has an exponential
    /// solution. A retardation that grows along the path, of a bullet that turns over, is continued as a constant.
    fn through(energies: [f64; 3], depth: f64, distance: f64) -> Option<Self> {
        let [first, last] = [energies[0] - energies[1], energies[1] - energies[2]];
        // A nearly constant retardation is the limit of a small rate.
        let ratio = (last / first).min(1.0 - 1e-3);
        let falls = first > 0.0 && last > 0.0 && distance > 0.0;
        let energy = energies[2];
        falls.then(|| Self {
            depth,
            energy,
            limit: energy - last * ratio / (1.0 - ratio),
            rate: -ratio.ln() / distance,
        })
    }

    /// Returns the depth at which the energy is used up, m; infinite if it never is.
    fn stop(&self) -> f64 {
        let parts = (self.energy - self.limit) / -self.limit;
        if self.limit < 0.0 { self.depth + parts.ln() / self.rate } else { f64::INFINITY }
    }

    /// Returns the time to a depth not beyond the stop, s: ∫ dx/v with x = x₁ − s², regular at the stop.
    fn time_to(&self, depth: f64) -> f64 {
        let width = (depth - self.depth).max(0.0).sqrt() / f64::from(N_INTERVALS);
        let middles = (0..N_INTERVALS).map(|k| (f64::from(k) + 0.5) * width);
        let energy = |x: f64| self.limit + (self.energy - self.limit) * (-(x - self.depth) * self.rate).exp();
        middles.map(|s| 2.0 * s * width / (2.0 * energy(depth - s * s)).max(f64::MIN_POSITIVE).sqrt()).sum()
    }
}

impl RunForecast {
    /// Creates the forecast of a run that has not begun.
    pub fn new(scene: &Scene) -> Self {
        let header = &scene.scene;
        let stop = header.stop_after_exit.time();
        let back_face = scene.gel.shape.bounding_box().map_or(f64::INFINITY, |gel| -gel.lower.z);
        Self {
            end_time: header.end_time,
            after_exit: if header.await_cavity { stop.max(OPENING) } else { stop },
            stops_at_rest: header.stop_at_rest,
            back_face,
            course: vec![],
            deepest: None,
        }
    }

    /// Adds a point of the run at a wall time, s, and returns the completed fraction of the run, by wall time.
    pub fn add(&mut self, point: RunPoint, wall: f64) -> f64 {
        let is_dense = |(before, _): &(RunPoint, f64)| point.time - before.time < self.end_time / MOST_POINTS;
        if self.course.len() > 1 && is_dense(&self.course[self.course.len() - 2]) {
            self.course.pop();
        }
        self.course.push((point, wall));
        if self.deepest.is_none_or(|deepest| point.depth > deepest.depth) {
            self.deepest = Some(point);
        }
        // Before the first tick nothing is known of the cost of scene time.
        if point.time > 0.0 && wall > 0.0 { wall / (wall + self.wall_time_left()) } else { 0.0 }
    }

    /// Returns the wall time to the end, s, at the cost of scene time of late.
    fn wall_time_left(&self) -> f64 {
        let Some((now, wall)) = self.course.last() else { return 0.0 };
        let since = (1.0 - RECENT_PART) * wall;
        let (from, then) = &self.course[self.course.partition_point(|(_, at)| *at < since).min(self.course.len() - 1)];
        let (from, then) = if from.time < now.time { (from.time, *then) } else { (0.0, 0.0) };
        (self.end() - now.time).max(0.0) * (wall - then) / (now.time - from)
    }

    /// Returns the time of the end, s.
    fn end(&self) -> f64 {
        let Some((now, _)) = self.course.last() else { return self.end_time };
        // An event that is overdue is expected after the same time again.
        let wait = |since: f64, length: f64| (since + length).max(2.0 * now.time - since - length);
        let end = match (now.exit, self.deepest.filter(|deepest| deepest.time < now.time)) {
            (Some(exit), _) => wait(exit, self.after_exit),
            (None, Some(deepest)) if self.stops_at_rest => wait(deepest.time, SETTLING),
            (None, Some(_)) => self.end_time,
            (None, None) => self.end_of_path().unwrap_or(self.end_time),
        };
        end.min(self.end_time)
    }

    /// Returns the time of the end of a run whose projectile still goes deeper, s.
    fn end_of_path(&self) -> Option<f64> {
        let now = self.course.last().map(|(now, _)| *now).filter(|now| now.depth > 0.0)?;
        let energy_at = |depth: f64| {
            let reached = self.course.partition_point(|(point, _)| point.depth < depth);
            let (to, from) = (self.course.get(reached.max(1))?.0, self.course[reached.max(1) - 1].0);
            Some(0.5 * ((to.depth - from.depth) / (to.time - from.time)).powi(2))
        };
        let energies = [energy_at(0.0)?, energy_at(0.5 * now.depth)?, energy_at(now.depth)?];
        let path = EnergyPath::through(energies, now.depth, 0.5 * now.depth)?;
        match path.stop() {
            stop if stop > self.back_face => Some(now.time + path.time_to(self.back_face) + self.after_exit),
            stop if self.stops_at_rest && stop.is_finite() => Some(now.time + path.time_to(stop) + SETTLING),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballistic_gel::scene;

    /// Retardation of Poncelet's law: strength, m/s², and drag, 1/m.
    const STRENGTH: f64 = 3e5;
    const DRAG: f64 = 12.0;
    const STEP: f64 = 1e-5;

    fn scene(depth: f64) -> Scene {
        let changes = ["scene.end_time=0.06", "scene.stop_at_rest=true", "gel.supports.z_min=free"].map(str::to_owned);
        let shape = format!("gel.shape.cylinder={{radius=0.075,height={depth}}}");
        let changes: Vec<_> = changes.into_iter().chain([shape]).map(|change| change.parse().unwrap()).collect();
        scene::read(&scene::resolve(scene::builtin("fbi-bb").unwrap(), &changes).unwrap()).unwrap()
    }

    /// Points of a run at 350 m/s through a block of this depth, m, each with its wall time: that of scene time is
    /// ten times as much at the impact as at rest.
    fn course(depth: f64, after: f64) -> Vec<(RunPoint, f64)> {
        let mut point = RunPoint { time: 0.0, depth: 0.0, exit: None };
        let (mut speed, mut wall, mut end): (f64, f64, f64) = (350.0, 0.0, f64::INFINITY);
        let mut course = vec![(point, wall)];
        while point.time < end {
            let retardation = if point.exit.is_some() { 0.0 } else { STRENGTH + DRAG * speed * speed };
            speed = (speed - retardation * STEP).max(0.0);
            point.depth += speed * STEP;
            point.time += STEP;
            wall += STEP * (1e5 + 9e5 * speed / 350.0);
            if point.exit.is_none() && point.depth > depth {
                (point.exit, end) = (Some(point.time), point.time + after);
            } else if speed == 0.0 && end.is_infinite() {
                end = point.time + after;
            }
            course.push((point, wall));
        }
        course
    }

    #[test]
    fn the_time_left_knows_exit_and_rest() {
        // A path of 71 mm comes to rest in 150 mm of gel, and leaves 50 mm.
        for (depth, after) in [(0.15, SETTLING), (0.05, OPENING)] {
            let course = course(depth, after);
            let (end, whole) = (course.len(), course.last().unwrap().1);
            let mut forecast = RunForecast::new(&scene(depth));
            for (k, (point, wall)) in course.into_iter().enumerate() {
                let fraction = forecast.add(point, wall);
                let (left, truth) = (wall * (1.0 / fraction - 1.0), whole - wall);
                if k > end / 3 && k < end - 3 {
                    assert!(
                        left < 2.0 * truth + 1.0 && left > 0.5 * truth - 1.0,
                        "{left} s for {truth} s at step {k} of {end}"
                    );
                }
            }
        }
    }

    #[test]
    fn nothing_is_forecast_before_the_first_tick() {
        let mut forecast = RunForecast::new(&scene(0.15));
        let start = RunPoint { time: 0.0, depth: 0.0, exit: None };
        assert_eq!([0.0, 20.0].map(|wall| forecast.add(start, wall)), [0.0; 2]);
        let fraction = forecast.add(RunPoint { time: 1e-6, depth: 3e-4, ..start }, 30.0);
        assert!((1e-5..1e-2).contains(&fraction), "{fraction}");
    }

    #[test]
    fn the_path_of_poncelets_law_is_continued_to_its_stop() {
        let energy = |x: f64| {
            let limit = -STRENGTH / (2.0 * DRAG);
            limit + (0.5 * 350.0 * 350.0 - limit) * (-2.0 * DRAG * x).exp()
        };
        let path = EnergyPath::through([0.0, 0.02, 0.04].map(energy), 0.04, 0.02).unwrap();
        let stop = (1.0 + DRAG * 350.0 * 350.0 / STRENGTH).ln() / (2.0 * DRAG);
        assert!((path.stop() / stop - 1.0).abs() < 1e-9, "{} for {stop} m", path.stop());
        let speed = (2.0 * energy(0.04)).sqrt();
        let time = (speed * (DRAG / STRENGTH).sqrt()).atan() / (DRAG * STRENGTH).sqrt();
        assert!((path.time_to(stop) / time - 1.0).abs() < 1e-3, "{} for {time} s", path.time_to(stop));
        // A bullet that turns over is retarded the more; one that is not retarded goes on.
        let turning = EnergyPath::through([100.0, 90.0, 60.0], 0.1, 0.05).unwrap();
        assert!((turning.stop() - 0.2).abs() < 1e-3, "{}", turning.stop());
        assert!(EnergyPath::through([100.0; 3], 0.1, 0.05).is_none());
    }
}
