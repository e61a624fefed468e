//! A drawn scene from its beginning to its end, and what there is to say of it.

#[path = "../../studies/src/cpu.rs"]
mod cpu;

use ballistic_gel::scene;
use ballistic_gel::simulation::{CouplingMode, Observation, Simulation};
use cpu::seconds;
use serde::{Deserialize, Serialize};

/// Steps in which a run is looked at.
const LOOKS: u32 = 100;
/// A run that takes more CPU time has come to nothing, s.
const LONGEST: f64 = 600.0;

/// A run and what it took.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ride {
    /// The diagnosis, if it did not reach its end.
    pub stop: Option<String>,
    /// Part of its time that it went.
    pub part: f64,
    /// Remeshings.
    pub remeshings: u64,
    /// Remeshings in which the mesh was made as a whole, as local operations did not suffice.
    pub whole: usize,
    /// Times at which no new mesh was taken, and why each attempt was refused the last time.
    pub refused: usize,
    /// The words of that.
    pub why: String,
    /// Greatest closure of the energy, of momentum and of angular momentum at any look.
    pub closure: [f64; 3],
    /// What the mass of the gel changed by, as a part of it.
    pub mass: f64,
    /// Mass of the eroded gel, as a part of all.
    pub eroded: f64,
    /// Least J.
    pub least: f64,
    /// Defect of the energy, and what remeshings made of it, as parts of it.
    pub defect: f64,
    /// Energy booked as remeshing, as a part of that.
    pub remesh: f64,
    /// Elements at the end.
    pub elements: usize,
    /// Element updates.
    pub updates: f64,
    /// CPU time, s.
    pub seconds: f64,
}

impl Ride {
    /// One of which only the end is known.
    pub fn lost(stop: &str) -> Self {
        Self {
            stop: Some(stop.to_owned()),
            part: 0.0,
            remeshings: 0,
            whole: 0,
            refused: 0,
            why: String::new(),
            closure: [f64::NAN; 3],
            mass: f64::NAN,
            eroded: f64::NAN,
            least: f64::NAN,
            defect: f64::NAN,
            remesh: f64::NAN,
            elements: 0,
            updates: 0.0,
            seconds: 0.0,
        }
    }
}

/// Runs the scene of a text on one thread.
pub fn ride(text: &str) -> Ride {
    let scene = scene::read(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let begun = seconds();
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let mass = simulation.frame().mass;
    let mut closure = [0.0; 3];
    let mut stop = None;
    for look in 1..=LOOKS {
        let inputs = simulation.inputs();
        let end = simulation.step(&inputs, scene.scene.end_time * f64::from(look) / f64::from(LOOKS));
        closure = worst(closure, &simulation.observe());
        stop = end.err().map(|failure| failure.to_string());
        let (late, last) = (seconds() - begun > LONGEST, look == LOOKS);
        if stop.is_none() && late && !last {
            stop = Some(format!("it was not done after {LONGEST} s on a core"));
        }
        if stop.is_some() {
            break;
        }
    }
    let seen = simulation.observe();
    let why = simulation.failed_remeshings().last().map(ToString::to_string);
    Ride {
        stop,
        part: simulation.time() / scene.scene.end_time,
        remeshings: seen.cost.remeshes,
        whole: simulation.remeshings().iter().filter(|made| made.edits.total() == 0).count(),
        refused: simulation.failed_remeshings().len(),
        why: why.unwrap_or_default(),
        closure,
        mass: ((simulation.frame().mass + seen.cost.eroded_mass) / mass - 1.0).abs(),
        eroded: seen.cost.eroded_mass / mass,
        least: seen.cost.min_jacobian,
        defect: seen.energy.energy_defect,
        remesh: seen.energy.remesh_net() / seen.energy.initial,
        elements: seen.cost.elements,
        updates: seen.cost.element_updates,
        seconds: seconds() - begun,
    }
}

fn worst(closure: [f64; 3], seen: &Observation) -> [f64; 3] {
    let now = [seen.energy.energy_error, seen.momentum_error, seen.angular_momentum_error];
    std::array::from_fn(|i| if now[i].is_nan() { f64::NAN } else { closure[i].max(now[i]) })
}
