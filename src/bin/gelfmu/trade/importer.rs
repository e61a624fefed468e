//! Coupling variants of an importer, and a driver that steps a simulation with them.

use crate::job::step_ends;
use ballistic_gel::integrator::StepError;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};
use clap::ValueEnum;

/// Coupling variant: the side that integrates the motion of the projectile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum CouplingVariant {
    /// The component integrates the motion
    #[default]
    Integrated,
    /// The importer integrates the body, corrected by the impulse J and its moment S: x′ = x + v H + S/M
    Corrected,
    /// The importer prescribes v during the step, and moves the body by J with the mean of v and v′
    Prescribed,
}

impl CouplingVariant {
    /// Returns the name on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Integrated => "integrated",
            Self::Corrected => "corrected",
            Self::Prescribed => "prescribed",
        }
    }

    /// Returns the coupling mode of the component.
    pub fn mode(self) -> CouplingMode {
        match self {
            Self::Integrated => CouplingMode::Integrated,
            Self::Corrected => CouplingMode::Corrected,
            Self::Prescribed => CouplingMode::Prescribed,
        }
    }
}

/// Steps a scene to its end time, with the coupling variant of the importer.
pub fn run_simulation(simulation: &mut Simulation, scene: &Scene, importer: CouplingVariant) -> Result<(), StepError> {
    let mass = simulation.inertia(0).0;
    let (mut position, mut velocity) = (simulation.kinematics(0).position, simulation.kinematics(0).velocity);
    let mut time = 0.0;
    for next in step_ends(scene, scene.scene.communication_step) {
        let mut inputs = simulation.inputs();
        if importer != CouplingVariant::Integrated {
            inputs[0].kinematics.position = position;
            inputs[0].kinematics.velocity = velocity;
        }
        simulation.step(&inputs, next)?;
        let (exchange, h) = (simulation.exchanges()[0], next - time);
        let after = velocity + exchange.impulse / mass;
        position += match importer {
            CouplingVariant::Integrated | CouplingVariant::Corrected => h * velocity + exchange.impulse_moment / mass,
            CouplingVariant::Prescribed => 0.5 * h * (velocity + after),
        };
        (velocity, time) = (after, next);
    }
    Ok(())
}
