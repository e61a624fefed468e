//! The whole step with contact: a block that moves everywhere while the ball presses into it.

use super::Measurement;
use super::scenes::{advance, awake, elements, scene, simulation, size};
use super::settings::Settings;
use super::spent::{Effort, Spent};
use super::table::Row;
use super::threads::Threads;
use crate::failure::Failure;
use crate::options::{ElementName, SectionName};
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::Simulation;

/// When the ball is in the gel, s: at 5 m/s it is then 5 mm deep; quick, 1 mm.
const IN_CONTACT: f64 = 1e-3;
const QUICK_IN_CONTACT: f64 = 0.2e-3;
/// Updates of one repetition, but at least and at most so many steps.
const UPDATES: usize = 4_000_000;
const STEPS: (usize, usize) = (4, 60);

/// A block to step.
#[derive(Debug, Clone, Copy)]
pub struct Subject {
    /// About so many elements.
    pub n_elements: usize,
    /// In patches, or plain.
    pub kind: ElementName,
    /// When to measure, s.
    pub from: f64,
    /// Whether the ball is there.
    pub with_ball: bool,
}

impl Subject {
    pub fn new((n_elements, kind): (usize, ElementName), settings: &Settings) -> Self {
        Self { n_elements, kind, from: if settings.quick { QUICK_IN_CONTACT } else { IN_CONTACT }, with_ball: true }
    }

    /// The same without the ball.
    pub fn without_ball(self) -> Self {
        Self { with_ball: false, ..self }
    }

    fn scene(&self) -> Result<Scene, Failure> {
        let ball = ("projectile.active", self.with_ball.to_string());
        scene("sphere-block", &[awake(), size(self.n_elements), elements(self.kind), ball])
    }
}

/// The same stretch of the same run, by some threads.
pub struct Stepped {
    pub threads: usize,
    pub updates: f64,
    pub spent: Spent,
    /// CPU time of the caller and the busiest thread, s, where the system tells.
    pub path: Option<f64>,
    /// Hash of the state at its end.
    pub digest: u128,
    /// Elements of the block.
    pub n_elements: usize,
    /// Area of the contact, m².
    pub area: f64,
}

pub fn plan(settings: &Settings) -> Vec<Measurement> {
    let (effort, counts) = (settings.effort, settings.thread_counts());
    let of = |(n, kind): (usize, ElementName)| {
        let (subject, counts) = (Subject::new((n, kind), settings), counts.clone());
        Measurement {
            section: SectionName::Steps,
            what: format!("{n} elements, {}", kind.as_str()),
            cost: if settings.quick { 0.5 } else { 2.0 + n as f64 * 2e-5 },
            go: Box::new(move || Ok(rows(kind, &measure(&subject, &counts, effort)?))),
        }
    };
    settings.subjects().into_iter().map(of).collect()
}

/// Steps by each number of threads in turn, again and again from the same state.
pub fn measure(subject: &Subject, counts: &[usize], effort: Effort) -> Result<Vec<Stepped>, Failure> {
    let scene = subject.scene()?;
    let mut all = counts.iter().map(|threads| simulation(&scene, *threads)).collect::<Result<Vec<Simulation>, _>>()?;
    let fastest = all.len() - 1;
    advance(&mut all[fastest], subject.from)?;
    let saved = all[fastest].save();
    let cost = all[fastest].observe().cost;
    let steps = (UPDATES / cost.elements).clamp(STEPS.0, STEPS.1);
    let (settled, end) = (subject.from + cost.largest_step, subject.from + (steps + 1) as f64 * cost.largest_step);
    let mut stepped: Vec<Option<Stepped>> = counts.iter().map(|_| None).collect();
    for _ in 0..effort.repeats {
        for (i, simulation) in all.iter_mut().enumerate() {
            simulation.restore(&saved).map_err(|error| refused(&error))?;
            advance(simulation, settled)?;
            let found = once(simulation, counts[i], end)?;
            stepped[i] = Some(match stepped[i].take() {
                Some(before) => found.or_less(&before),
                None => found,
            });
        }
    }
    Ok(stepped.into_iter().flatten().collect())
}

impl Stepped {
    /// The lesser of each time.
    fn or_less(self, other: &Self) -> Self {
        let path = self.path.zip(other.path).map(|(a, b)| a.min(b));
        Self { spent: self.spent.or_less(other.spent), path, ..self }
    }
}

fn once(simulation: &mut Simulation, threads: usize, end: f64) -> Result<Stepped, Failure> {
    let before = simulation.observe().cost.element_updates;
    let mut ended = Ok(());
    let threads_before = Threads::now();
    let spent = Spent::on(|| ended = advance(simulation, end));
    let path = Threads::now().zip(threads_before).map(|(after, before)| after.path_since(&before));
    ended?;
    let observed = simulation.observe();
    Ok(Stepped {
        threads,
        updates: observed.cost.element_updates - before,
        spent,
        path,
        digest: simulation.digest(),
        n_elements: observed.cost.elements,
        area: observed.bodies[0].contact.area,
    })
}

fn refused(error: &ballistic_gel::simulation::RestoreError) -> Failure {
    Failure::Run(crate::job::RunError::Component { call: "Simulation::restore", reason: error.to_string() })
}

fn rows(kind: ElementName, all: &[Stepped]) -> Vec<Row> {
    let first = &all[0];
    let row = |it: &Stepped| {
        Row::default()
            .with("elements", it.n_elements)
            .with("element", kind.as_str())
            .with("threads", it.threads)
            .with("million_per_wall_s", it.updates / it.spent.wall / 1e6)
            .with("million_per_cpu_s", it.updates / it.spent.cpu / 1e6)
            .with("times_as_fast_as_one_thread", first.spent.wall / it.spent.wall)
            .with("if_cores_were_free", first.path.zip(it.path).map(|(one, all)| one / all))
            .with("same_bits", it.digest == first.digest)
            .and("updates", it.updates)
            .and("wall_s", it.spent.wall)
            .and("cpu_s", it.spent.cpu)
            .and("path_cpu_s", it.path)
            .and("contact_area_m2", it.area)
    };
    all.iter().map(row).collect()
}
