//! Simulation: builds a gel and its bodies from a scene, steps them in time, and reports on them.
//!
//! - `build`: the engine of a scene on its first `grid`, with its `gel`, `scene_bodies`, `loads` and `sensors`.
//! - `model`: the gel of either dimension behind one interface: this room alone erases the dimension.
//! - `reduced_model`: the reduced model behind the same interface, with its `reduced_section` for frames.
//! - `run`, `exit`, `report_queries`: the simulation, with reports (`observe`, `fields`) and `doubts` about them;
//!   `rest`: rest depth from reports;
//!   `end_watch`: the end of a run, with the `opening` of the cavity in its `cross_section`s.
//! - `saved`: a state as a value and as bytes; `memory`: bytes needed, before they are.
//!
//! Nothing here reads a file, the environment or the clock.

mod build;
mod build_error;
mod cross_section;
mod doubts;
mod end_watch;
mod exit;
mod fields;
mod gel;
mod grid;
mod kinematics;
mod loads;
mod memory;
mod model;
mod observe;
mod opening;
mod reduced_model;
mod reduced_section;
mod report_queries;
mod rest;
mod run;
mod saved;
mod scene_bodies;
mod sensors;

pub use crate::adapt::{FailedRemesh, PreviewMesh, RemeshRecord, RemeshRefusal, RemeshTrial, RestoreError};
pub use crate::contact::{DomeMotion, ExpansionMotion, ImpulseExchange, ShapeMotion, Wrench};
pub use crate::integrator::BlockMotion;
pub use crate::scene::CouplingMode;
pub use build_error::BuildError;
pub use cross_section::signed_area;
pub use doubts::doubts;
pub use end_watch::{EndSample, EndWatch, is_shot};
pub use kinematics::{BodyKinematics, StepInputs};
pub use memory::{MemoryEstimate, memory_estimate};
pub use observe::{
    BalanceReport, BodyPose, BodyReport, ContactReport, CostReport, EnergyReport, ExitReport, FrameCells, FrameField,
    MeshFrame, Observation, RemeshPreview, SensorReport,
};
pub use opening::{DepthGrid, GelSection, void_radii};
pub use rest::{PeakDepth, RestDepth, RestDetector};
pub use run::Simulation;
pub use saved::{SavedSimulation, SavedState};
pub use scene_bodies::free_body;
