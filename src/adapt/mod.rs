//! Adaptation of the mesh: when and how a run gets another mesh.
//!
//! - `driver`: replaces a distorted mesh, and continues on the new one; `restore`: continues from a saved state.
//! - `adaptive_gel`: the gel with its engine and present mesh, by its `gel_definition` and `settings`.
//! - `candidate`: one `attempt` at a mesh of target `sizes`, its acceptance, and the transfer of the fields.
//! - `local_edits`: remeshing by local operations, where elements are a `hindrance`.
//! - `history`: transfer of rest shapes and history variables from the `source_mesh`, by `state_averaging`, or
//!   `network_transfer` for a two-network gel, `rest_volumes` and `patch_volume_share`.
//! - `layer_parts`: materials of a layered gel in its elements.
//! - `erosion`, `erosion_on_failure`: removal of gel that no mesh can follow.
//! - `record`, `refusal`, `preview`: reports of remeshings.
//!
//! The clock is read only to time a remeshing.

mod adaptive_gel;
mod attempt;
mod candidate;
mod driver;
mod erosion;
mod erosion_on_failure;
mod gel_definition;
mod hindrance;
mod history;
mod layer_parts;
mod local_edits;
mod network_transfer;
mod patch_volume_share;
mod preview;
mod record;
mod refusal;
mod rest_volumes;
mod restore;
#[cfg(test)]
mod round_trip_tests;
mod settings;
mod sizes;
mod source_mesh;
mod state_averaging;

pub(crate) use adaptive_gel::AdaptiveGel;
pub(crate) use driver::RemeshDriver;
pub(crate) use gel_definition::GelDefinition;
pub use preview::{PreviewMesh, RemeshTrial};
pub use record::RemeshRecord;
pub use refusal::{FailedRemesh, RemeshRefusal};
pub use restore::RestoreError;
pub(crate) use settings::AdaptSettings;
pub use settings::RemeshMethod;
