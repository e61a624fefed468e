//! The whole step with contact: a block that moves everywhere while the ball presses into it.

use super::Measurement;
use super::scenes::{advance, awake, elements, name_of, scene, simulation, size};
use super::settings::Settings;
use super::spent::{Effort, Spent};
use super::table::Row;
use crate::failure::Failure;
use crate::options::SectionName;
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
    pub patched: bool,
    /// When to measure, s.
    pub from: f64,
}

impl Subject {
    pub fn new(n_elements: usize, patched: bool, settings: &Settings) -> Self {
        Self { n_elements, patched, from: if settings.quick { QUICK_IN_CONTACT } else { IN_CONTACT } }
    }

    pub fn scene(&self) -> Result<Scene, Failure> {
        scene("sphere-block", &[awake(), size(self.n_elements), elements(self.patched)])
    }
}

/// The same stretch of the same run, by some threads.
pub struct Stepped {
    pub threads: usize,
    pub updates: f64,
    pub spent: Spent,
    /// Hash of the state at its end.
    pub digest: u128,
    /// Elements of the block.
    pub n_elements: usize,
    /// Area of the contact, m².
    pub area: f64,
}

pub fn plan(settings: &Settings) -> Vec<Measurement> {
    let subjects = settings.elements.iter().flat_map(|n| [(*n, false), (*n, true)]);
    let (effort, counts) = (settings.effort, settings.thread_counts());
    let of = |(n, patched): (usize, bool)| {
        let (subject, counts) = (Subject::new(n, patched, settings), counts.clone());
        Measurement {
            section: SectionName::Steps,
            what: format!("{n} elements, {}", name_of(patched)),
            cost: if settings.quick { 0.5 } else { 2.0 + n as f64 * 2e-5 },
            go: Box::new(move || Ok(rows(patched, &measure(&subject, &counts, effort)?))),
        }
    };
    subjects.map(of).collect()
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
            let least = stepped[i].as_ref().map_or(found.spent, |before| before.spent.or_less(found.spent));
            stepped[i] = Some(Stepped { spent: least, ..found });
        }
    }
    Ok(stepped.into_iter().flatten().collect())
}

fn once(simulation: &mut Simulation, threads: usize, end: f64) -> Result<Stepped, Failure> {
    let before = simulation.observe().cost.element_updates;
    let mut ended = Ok(());
    let spent = Spent::on(|| ended = advance(simulation, end));
    ended?;
    let observed = simulation.observe();
    Ok(Stepped {
        threads,
        updates: observed.cost.element_updates - before,
        spent,
        digest: simulation.digest(),
        n_elements: observed.cost.elements,
        area: observed.bodies[0].contact.area,
    })
}

fn refused(error: &ballistic_gel::simulation::RestoreError) -> Failure {
    Failure::Run(crate::job::RunError::Component { call: "Simulation::restore", reason: error.to_string() })
}

fn rows(patched: bool, all: &[Stepped]) -> Vec<Row> {
    let first = &all[0];
    let row = |it: &Stepped| {
        Row::default()
            .with("elements", it.n_elements)
            .with("element", name_of(patched))
            .with("threads", it.threads)
            .with("million_per_wall_s", it.updates / it.spent.wall / 1e6)
            .with("million_per_cpu_s", it.updates / it.spent.cpu / 1e6)
            .with("times_as_fast_as_one_thread", first.spent.wall / it.spent.wall)
            .with("same_bits", it.digest == first.digest)
            .and("updates", it.updates)
            .and("wall_s", it.spent.wall)
            .and("cpu_s", it.spent.cpu)
            .and("contact_area_m2", it.area)
    };
    all.iter().map(row).collect()
}
