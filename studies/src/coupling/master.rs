//! Importers that differ in how they move the projectile.

use ballistic_gel::integrator::StepError;
use ballistic_gel::math::Vector3;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};

/// How an importer moves the projectile from the impulse of a step; v′ = v + J/M except where it is said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Master {
    /// Prescribes x + v s and moves on to x + H v.
    Explicit,
    /// Prescribes x + v s and moves on to x + H v′.
    SemiImplicit,
    /// Prescribes x + v s and moves on to x + H (v + v′)/2.
    Trapezoidal,
    /// As `Trapezoidal`, and extrapolates: prescribes x + v s + a s²/2 with the mean acceleration a of the last step.
    Extrapolated,
    /// As `Extrapolated` with a = (v′ − v)/H of this very step, found by stepping again from the saved state.
    Iterated,
    /// Owns the body: hands over its state, moves on to x + H v + S/M.
    Corrected,
    /// Looks on, and sums up J and S for itself.
    Integrated,
}

impl Master {
    pub const ALL: [Self; 7] = [
        Self::Explicit,
        Self::SemiImplicit,
        Self::Trapezoidal,
        Self::Extrapolated,
        Self::Iterated,
        Self::Corrected,
        Self::Integrated,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Explicit => "explicit",
            Self::SemiImplicit => "semi-implicit",
            Self::Trapezoidal => "trapezoidal",
            Self::Extrapolated => "derivatives",
            Self::Iterated => "iterated",
            Self::Corrected => "corrected",
            Self::Integrated => "integrated",
        }
    }

    fn mode(self) -> CouplingMode {
        match self {
            Self::Explicit | Self::SemiImplicit | Self::Trapezoidal | Self::Extrapolated | Self::Iterated => {
                CouplingMode::Prescribed
            }
            Self::Corrected => CouplingMode::Corrected,
            Self::Integrated => CouplingMode::Integrated,
        }
    }
}

/// The end of a run under a master.
pub struct Outcome {
    /// Velocity of the master's body, m/s.
    pub velocity: Vector3,
    /// Kinetic and elastic energy of the gel and of the master's body, J.
    pub energy: f64,
    /// What the coupling brought into them, J: ledger accounts `external` and `importer`, last jump included.
    pub brought: f64,
    /// Σε, power-bond residual, J.
    pub residual: f64,
    /// Times that steps were computed, per step.
    pub tries: f64,
    /// Smallest step of an element at the end, s.
    pub element_step: f64,
    /// Hash of the simulation's state.
    pub digest: u128,
}

/// An importer's body and the gel that it meets.
struct Course {
    simulation: Simulation,
    master: Master,
    mass: f64,
    position: Vector3,
    velocity: Vector3,
    acceleration: Vector3,
    residual: f64,
    tries: u32,
}

/// Residual of the end velocity, relative to the velocity at the start, at which an iteration has converged.
const CONVERGED: f64 = 1e-10;
/// The contact law has kinks; an iteration that hangs on one is taken as it is.
const MOST_TRIES: u32 = 25;

/// Runs a scene to its end in `steps` communication steps.
pub fn run(scene: &Scene, master: Master, steps: u32) -> Outcome {
    let simulation = Simulation::new(scene, master.mode(), 0).expect("a scene that can be built");
    let (start, mass, zero) = (simulation.kinematics(0), simulation.inertia(0).0, Vector3::zeros());
    let (position, velocity, acceleration) = (start.position, start.velocity, zero);
    let mut course = Course { simulation, master, mass, position, velocity, acceleration, residual: 0.0, tries: 0 };
    let time = |i: u32| scene.scene.end_time * f64::from(i) / f64::from(steps);
    for i in 0..steps {
        course.advance(time(i + 1) - time(i), time(i + 1)).expect("a gel that can follow");
    }
    course.outcome(steps)
}

impl Course {
    fn advance(&mut self, h: f64, end: f64) -> Result<(), StepError> {
        match self.master {
            Master::Iterated => self.iterate(h, end)?,
            Master::Extrapolated => self.attempt(self.acceleration, end)?,
            Master::Explicit | Master::SemiImplicit | Master::Trapezoidal | Master::Corrected | Master::Integrated => {
                self.attempt(Vector3::zeros(), end)?;
            }
        }
        let (exchange, v) = (self.simulation.exchanges()[0], self.velocity);
        let after = v + exchange.impulse / self.mass;
        self.position += match self.master {
            Master::Explicit => h * v,
            Master::SemiImplicit => h * after,
            Master::Trapezoidal | Master::Extrapolated | Master::Iterated => h * (v + after) / 2.0,
            Master::Corrected | Master::Integrated => h * v + exchange.impulse_moment / self.mass,
        };
        self.acceleration = (after - v) / h;
        self.velocity = after;
        self.residual += exchange.energy_residual;
        Ok(())
    }

    /// One step of the gel with the body at its place, moving with its velocity and this acceleration.
    fn attempt(&mut self, acceleration: Vector3, end: f64) -> Result<(), StepError> {
        let mut inputs = self.simulation.inputs();
        inputs[0].kinematics.position = self.position;
        inputs[0].kinematics.velocity = self.velocity;
        inputs[0].acceleration = acceleration;
        self.tries += 1;
        self.simulation.step(&inputs, end)
    }

    /// Steps from the same state until the change of velocity that is prescribed is the one that the impulse gives, by
    /// Aitken's relaxation ω′ = −ω r·(r′ − r)/|r′ − r|².
    fn iterate(&mut self, h: f64, end: f64) -> Result<(), StepError> {
        let saved = self.simulation.save();
        let speed = self.velocity.norm();
        let (mut guess, mut weight) = (self.acceleration * h, 1.0);
        let mut last: Option<Vector3> = None;
        for _ in 0..MOST_TRIES {
            self.simulation.restore(&saved).expect("a state of this simulation");
            self.attempt(guess / h, end)?;
            let residual = self.simulation.exchanges()[0].impulse / self.mass - guess;
            if residual.norm() <= CONVERGED * speed {
                break;
            }
            if let Some(change) = last.map(|last| residual - last).filter(|change| change.norm() > 0.0) {
                weight *= -(residual - change).dot(&change) / change.norm_squared();
            }
            guess += weight * residual;
            last = Some(residual);
        }
        Ok(())
    }

    fn outcome(&self, steps: u32) -> Outcome {
        let (seen, inside) = (self.simulation.observe(), self.simulation.kinematics(0).velocity);
        let jump = 0.5 * self.mass * (self.velocity.norm_squared() - inside.norm_squared());
        Outcome {
            velocity: self.velocity,
            energy: seen.energy.kinetic + seen.energy.elastic + jump,
            brought: seen.energy.external + seen.energy.importer + jump,
            residual: self.residual,
            tries: f64::from(self.tries) / f64::from(steps),
            element_step: seen.cost.smallest_step,
            digest: self.simulation.digest(),
        }
    }
}
