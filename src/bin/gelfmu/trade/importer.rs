//! Who moves the projectile, and in which steps.

use crate::job::times;
use ballistic_gel::integrator::StepError;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};
use clap::ValueEnum;

/// An importer: how it couples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Importer {
    /// The component integrates the motion
    #[default]
    Integrated,
    /// The importer owns the body, and lands by J and S: x′ = x + v H + S/M
    Corrected,
    /// The importer prescribes v of the step, and moves on by J with the mean of v and v′
    Prescribed,
}

impl Importer {
    /// Its name on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Integrated => "integrated",
            Self::Corrected => "corrected",
            Self::Prescribed => "prescribed",
        }
    }

    /// The mode that it asks for.
    pub fn mode(self) -> CouplingMode {
        match self {
            Self::Integrated => CouplingMode::Integrated,
            Self::Corrected => CouplingMode::Corrected,
            Self::Prescribed => CouplingMode::Prescribed,
        }
    }
}

/// Steps a scene to its end, in communication steps, as the importer does.
pub fn drive(simulation: &mut Simulation, scene: &Scene, importer: Importer) -> Result<(), StepError> {
    let mass = simulation.inertia(0).0;
    let (mut position, mut velocity) = (simulation.kinematics(0).position, simulation.kinematics(0).velocity);
    let mut time = 0.0;
    for next in times(scene, scene.scene.communication_step) {
        let mut inputs = simulation.inputs();
        if importer != Importer::Integrated {
            inputs[0].kinematics.position = position;
            inputs[0].kinematics.velocity = velocity;
        }
        simulation.step(&inputs, next)?;
        let (exchange, h) = (simulation.exchanges()[0], next - time);
        let after = velocity + exchange.impulse / mass;
        position += match importer {
            Importer::Integrated | Importer::Corrected => h * velocity + exchange.impulse_moment / mass,
            Importer::Prescribed => 0.5 * h * (velocity + after),
        };
        (velocity, time) = (after, next);
    }
    Ok(())
}
