//! Campaign of runs: all shots at some points of a fit at once, each run on its own threads.

use super::gel_values::{GelValue, gel_overrides};
use super::least_squares::FitBreak;
use super::shot_file::{MeasuredShot, ShotMeasure};
use crate::calibrate::task;
use crate::calibrate::trial::{self, END_TIME_FACTOR, ShotEnd, ShotNeeds, ShotRun};
use crate::console::Console;
use crate::failure::CommandError;
use crate::new::scene_text;
use crate::progress::ProgressDisplay;
use crate::validate::measured_shots;
use crate::{interrupt, level, source};
use ballistic_gel::scene::{FidelityKind, GelSpec, MaterialModel, Override, Scene};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Shots with their runs.
pub struct ShotCampaign<'a> {
    pub shots: Vec<MeasuredShot>,
    runs: Vec<PlannedRun>,
    /// Runs of each shot: one, or two for a slope.
    runs_of: Vec<Vec<usize>>,
    threads: usize,
    pub console: &'a Console,
    /// Number of completed runs.
    pub n_completed: usize,
}

/// Run that one or more shots are measured in.
#[derive(Debug, Clone, PartialEq)]
struct PlannedRun {
    /// Name of its first shot, for messages.
    name: String,
    place: String,
    scene: String,
    overrides: Vec<Override>,
    gel: GelSpec,
    needs: ShotNeeds,
    /// Expected time of the end of the run, s.
    expected: f64,
}

/// Overrides that all shots have in common, and their level.
pub struct CommonSetting<'a> {
    /// Scene of the shots that name none.
    pub scene: &'a str,
    /// Overrides of the command line.
    pub set: &'a [Override],
    /// Accuracy level; the scene without a level if absent.
    pub level: Option<FidelityKind>,
}

/// Measurements of a run; `None` if the user interrupted it.
type RunResult = Result<Option<ShotRun>, CommandError>;

/// Computed values of the shots at a point; a text for a shot without a value.
pub type ComputedShots = Vec<Result<f64, String>>;

impl<'a> ShotCampaign<'a> {
    /// Plans the runs of the shots; shots of the same scene, overrides and speed share a run.
    pub fn plan(
        shots: Vec<MeasuredShot>,
        common: &CommonSetting<'_>,
        threads: usize,
        console: &'a Console,
    ) -> Result<Self, CommandError> {
        let mut campaign = Self { shots, runs: vec![], runs_of: vec![], threads, console, n_completed: 0 };
        for i in 0..campaign.shots.len() {
            let needs = ShotNeeds { rest: true, cavity: false };
            let (speeds, needs) = match campaign.shots[i].measure {
                ShotMeasure::Depth { speed } => (vec![speed], needs),
                ShotMeasure::Slope { speeds } => (speeds.map(Some).to_vec(), needs),
                ShotMeasure::Cavity { speed } => (vec![Some(speed)], ShotNeeds { rest: false, cavity: true }),
            };
            let of_shot: Result<Vec<usize>, CommandError> =
                speeds.into_iter().map(|speed| campaign.plan_run(i, speed, needs, common)).collect();
            campaign.runs_of.push(of_shot?);
        }
        Ok(campaign)
    }

    /// Plans a run, or adds needs to an equal one; returns its number.
    fn plan_run(
        &mut self,
        shot: usize,
        speed: Option<f64>,
        needs: ShotNeeds,
        common: &CommonSetting<'_>,
    ) -> Result<usize, CommandError> {
        let shot = &self.shots[shot];
        let scene = shot.scene.as_deref().unwrap_or(common.scene);
        let mut overrides: Vec<Override> = common.set.iter().chain(&shot.set).cloned().collect();
        overrides.extend(speed.map(task::speed_override));
        let known = self.runs.iter().position(|run| {
            run.scene == scene && run.overrides.iter().filter(|o| o.key != "scene.fidelity").eq(overrides.iter())
        });
        if let Some(known) = known {
            self.runs[known].needs.rest |= needs.rest;
            self.runs[known].needs.cavity |= needs.cavity;
            return Ok(known);
        }
        let run = PlannedRun::new(shot, scene, overrides, common.level, self.console)?;
        self.runs.push(PlannedRun { needs, ..run });
        Ok(self.runs.len() - 1)
    }

    /// Computes all shots at points of a fit; `stage` says where the fit is.
    pub fn compute(&mut self, stage: &str, points: &[Vec<GelValue>]) -> Result<Vec<ComputedShots>, FitBreak> {
        let n = self.runs.len();
        let mut jobs: Vec<(usize, Scene)> = vec![];
        for values in points {
            for (i, run) in self.runs.iter().enumerate() {
                jobs.push((i, run.load(values)?));
            }
        }
        let results = self.run_all(stage, jobs)?;
        self.n_completed += results.len();
        for (run, result) in self.runs.iter_mut().zip(&results) {
            run.expected = result.time;
        }
        Ok(results.chunks(n).map(|results| self.values_of(results)).collect())
    }

    /// Returns the values of the shots from the runs at one point.
    fn values_of(&self, results: &[ShotRun]) -> ComputedShots {
        let rest = |i: usize| self.rest_depth(i, &results[i]);
        let value = |shot: &MeasuredShot, runs: &Vec<usize>| match shot.measure {
            ShotMeasure::Depth { .. } => rest(runs[0]),
            ShotMeasure::Slope { speeds } => Ok((rest(runs[1])? - rest(runs[0])?) / (speeds[1] - speeds[0])),
            ShotMeasure::Cavity { .. } => self.cavity(runs[0], &results[runs[0]]),
        };
        let limit = |shot: &MeasuredShot, runs| match value(shot, runs) {
            Ok(value) => Ok(shot.limit * value),
            Err(why) => Err(format!("{}{}: {why}", shot.place, shot.name)),
        };
        self.shots.iter().zip(&self.runs_of).map(|(shot, runs)| limit(shot, runs)).collect()
    }

    /// Returns the rest depth of a run, m, or the reason and the remedy.
    fn rest_depth(&self, run: usize, result: &ShotRun) -> Result<f64, String> {
        let velocity = self.runs[run].velocity_text();
        match &result.end {
            ShotEnd::AtRest { depth, .. } => Ok(*depth),
            ShotEnd::Perforated => Err(format!(
                "found a projectile{velocity} that perforates the gel of {:.0} mm, expected one that comes to rest: \
                 give the scene a deeper gel.shape, or measure its cavity",
                1e3 * result.thickness
            )),
            ShotEnd::ThrownBack => Err(format!(
                "found a projectile{velocity} that is thrown back out of the gel, expected one that comes to rest: \
                 give it more speed or the gel less strength, or measure its cavity"
            )),
            ShotEnd::Moving { depth, speed } => Err(format!(
                "found a projectile{velocity} that still moves at {speed:.3} m/s after {:.3} ms, {:.2} mm deep, \
                 expected rest within {END_TIME_FACTOR} times scene.end_time: give the scene a longer scene.end_time",
                1e3 * result.time,
                1e3 * depth
            )),
            ShotEnd::Failed(why) => Err(format!("found a run that failed: {why}, expected one that completes")),
        }
    }

    /// Returns the greatest diameter of the cavity of a run, m, or the reason.
    fn cavity(&self, run: usize, result: &ShotRun) -> Result<f64, String> {
        match &result.end {
            ShotEnd::Failed(why) => Err(format!("found a run that failed: {why}, expected one that completes")),
            _ if result.cavity > 0.0 => Ok(result.cavity),
            _ => {
                let velocity = self.runs[run].velocity_text();
                Err(format!("found no cavity behind the projectile{velocity}, expected a shot along −z into the gel"))
            }
        }
    }

    /// Carries out all runs, as many at a time as there are threads; the results are in the order of the jobs.
    fn run_all(&self, stage: &str, jobs: Vec<(usize, Scene)>) -> Result<Vec<ShotRun>, FitBreak> {
        let n_jobs = jobs.len();
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let threads = if self.threads == 0 { cores } else { self.threads };
        let workers = threads.min(n_jobs).max(1);
        let board = RunBoard::new(stage, n_jobs, self.console);
        let (next, jobs) = (AtomicUsize::new(0), jobs.into_iter().map(Some).map(Mutex::new).collect::<Vec<_>>());
        let results: Vec<Mutex<Option<RunResult>>> = (0..n_jobs).map(|_| Mutex::new(None)).collect();
        let work = || {
            loop {
                let at = next.fetch_add(1, Ordering::Relaxed);
                let Some((run, scene)) = jobs.get(at).and_then(|job| lock(job).take()) else { return };
                *lock(&results[at]) = Some(self.run_one(run, scene, threads / workers, &|time, depth| {
                    board.show(at, time / self.runs[run].expected, &self.runs[run].name, depth);
                }));
            }
        };
        std::thread::scope(|scope| (0..workers).for_each(|_| drop(scope.spawn(work))));
        board.clear();
        let finished = results.into_iter().map(|result| result.into_inner().unwrap_or_else(PoisonError::into_inner));
        finished.map(|result| result.unwrap_or(Ok(None))?.ok_or(FitBreak::Interrupted)).collect()
    }

    /// Carries out one run; `None` if the user interrupted it.
    fn run_one(&self, run: usize, scene: Scene, threads: usize, show: &dyn Fn(f64, f64)) -> RunResult {
        trial::run(scene, self.runs[run].needs, threads.max(1), &mut |time, depth| {
            show(time, depth);
            if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    }
}

/// Loads the scene of a shot: a built-in one, that of a shot of `gelfmu validate`, or a file.
fn load_scene(name: &str, overrides: &[Override]) -> Result<Scene, CommandError> {
    let source = match measured_shots().into_iter().find(|shot| shot.name == name) {
        Some(shot) => source::load_text(name, &scene_text(&shot.shot(shot.yaw, 0.0))?, overrides),
        None => source::load(name, overrides),
    };
    source.map(|source| source.scene)
}

impl PlannedRun {
    /// Checks the scene of a shot, and chooses its level.
    fn new(
        shot: &MeasuredShot,
        name: &str,
        mut overrides: Vec<Override>,
        level: Option<FidelityKind>,
        console: &Console,
    ) -> Result<Self, CommandError> {
        let place = format!("{}{}: ", shot.place, shot.name);
        let prefixed = |error: CommandError| error.placed(&place);
        let mut scene = load_scene(name, &overrides).map_err(prefixed)?;
        let refuse = |key: &str, why: String| Err(CommandError::BadInput(format!("{place}scene {name}: {key}: {why}")));
        if scene.gel.material != MaterialModel::TwoNetwork {
            return refuse("gel.material", "found another one, expected \"two-network\"".to_owned());
        }
        if scene.projectile.velocity[2] >= 0.0 {
            let expected = "a projectile that runs into the gel along -z";
            return refuse(
                "projectile.velocity",
                format!("found {:?}, expected {expected}", scene.projectile.velocity),
            );
        }
        if let Some(level) = level.filter(|level| *level != scene.scene.fidelity) {
            if level == FidelityKind::Standard || scene.fidelity.get(level).is_some() {
                overrides.push(level::level_override(level));
                scene = load_scene(name, &overrides).map_err(prefixed)?;
            } else {
                let own = scene.scene.fidelity.as_str();
                let level = level.as_str();
                console.warning(&format!("{place}scene {name} has no level {level}: it is run at its own, {own}"));
            }
        }
        let (needs, gel) = (ShotNeeds::default(), scene.gel);
        let (name, shot, expected) = (name.to_owned(), shot.name.clone(), scene.scene.end_time);
        Ok(Self { name: shot, place: place.clone(), scene: name, overrides, gel, needs, expected })
    }

    /// Loads the scene with values of the gel.
    fn load(&self, values: &[GelValue]) -> Result<Scene, CommandError> {
        let overrides: Vec<Override> = self.overrides.iter().cloned().chain(gel_overrides(&self.gel, values)).collect();
        load_scene(&self.scene, &overrides).map_err(|error| error.placed(&self.place))
    }

    /// Returns the velocity for a message.
    fn velocity_text(&self) -> String {
        let velocity = self.overrides.iter().rev().find(|override_| override_.key == "projectile.velocity");
        velocity.map_or(String::new(), |velocity| format!(" of velocity {} m/s", velocity.value))
    }
}

/// Progress of the runs of one stage.
struct RunBoard<'a> {
    stage: &'a str,
    /// Completed fraction of each run.
    fractions: Mutex<Vec<f64>>,
    bar: ProgressDisplay,
}

impl<'a> RunBoard<'a> {
    fn new(stage: &'a str, n_runs: usize, console: &Console) -> Self {
        Self { stage, fractions: Mutex::new(vec![0.0; n_runs]), bar: ProgressDisplay::new(console) }
    }

    /// Shows the progress of a run.
    fn show(&self, run: usize, fraction: f64, name: &str, depth: f64) {
        let mut fractions = lock(&self.fractions);
        fractions[run] = fraction.min(1.0);
        let (n, all) = (fractions.len(), fractions.iter().sum::<f64>());
        let task = format!("{}, run {} of {n}, {name}: {:.1} mm deep", self.stage, run + 1, 1e3 * depth);
        self.bar.show_task(&task, all / n as f64);
    }

    fn clear(&self) {
        self.bar.clear();
    }
}

/// Locks a mutex; a panic of another run ends the program anyway.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
