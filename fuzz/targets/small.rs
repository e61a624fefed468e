//! The scene that states are of: a planar gel of a few elements, quickly built.

use ballistic_gel::scene::{self, Scene};
use ballistic_gel::simulation::{CouplingMode, Simulation};

/// Its text.
pub const TEXT: &str = r#"[scene]
name = "small"
dimension = "planar"
end_time = 1e-3
communication_step = 1e-4
[gel]
shape.block.size = [0.04, 0.02]
material = "neo-hookean"
density = 1030.0
shear_modulus = 7e4
bulk_modulus = 7e5
supports.z_min = "fixed"
[projectile]
shape.sphere.radius = 0.01
mass = 0.033
position = [0.0, 0.0, 0.01]
velocity = [0.0, 0.0, -5.0]
[mesh]
size = 10e-3
"#;

/// The scene, read.
pub fn scene() -> Scene {
    scene::read(TEXT).expect("it is a scene")
}

/// The scene, built and stepped to a time, s.
#[allow(dead_code, reason = "not every target steps it")]
pub fn stepped(time: f64) -> Simulation {
    let mut simulation = Simulation::new(&scene(), CouplingMode::Integrated, 1).expect("it can be built");
    let inputs = simulation.inputs();
    simulation.step(&inputs, time).expect("it can be stepped");
    simulation
}
