//! Finite elements: the potential energy of simplices in F-bar patches.
//!
//! `law` has the element kernels of the materials, written once over [`crate::math::Number`]: `simd` runs them with
//! eight patches in vector lanes, `scalar` with one. The scalar form is the reference that tests compare with
//! differences of the energy.

mod element_states;
mod facet_pressure;
mod group_kick;
mod history;
mod inversion_time;
mod law;
mod potential;
mod response;
mod scalar;
mod simd;
mod simplex;
mod simplex_potential;

pub use facet_pressure::{FacetPressure, push};
pub use group_kick::GroupKick;
pub use history::{HistoryLanes, HistoryVariables};
pub use inversion_time::{FORESEEN, TURNED};
pub use potential::Potential;
pub use response::{Dissipation, ElementResponse, ElementStates};
pub use scalar::element_fields::StressInvariants;
pub use scalar::simplices::Simplices;
pub use scalar::single_element::{SingleElementLaw, SingleElementResponse};
pub(crate) use simd::batch::on;
pub use simd::batch::{ElementBatch, LANES};
pub use simd::layout::{
    ElementBatches, ElementCorner, GroupKicks, GroupResponse, ReportPower, SweepInput, SweepOutput,
};
pub use simd::node_cache::{
    HeldNodes, MOST_LOCAL_NODES, NodeAccumulator, NodeCache, NodeMotion, NodeRow, NodeSource, rounding,
};
pub use simplex::{DEPTH, MAX_NODES, ReferenceShape, Section, max_patch_size};
