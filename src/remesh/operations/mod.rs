//! Local operations: split, collapse, flip and move (Wicke et al. 2010, Lahiri et al. 2008).
//!
//! Every node carries its rest position X beside its position x, and every element made here has F = ∂x/∂X of its own
//! nodes: a gel that is unloaded takes its first shape again. An operation replaces the elements of a cavity by others
//! that fill the same gel, positive in both spaces. The stress of a gel that flows, with history variables, does not
//! follow from X: its operations are judged in its present configuration (`ReferenceConfiguration`).
//!
//! - `editable_mesh`: the mesh, its elements replaced one cavity at a time.
//! - `operation`, `construction`: the four operations, in the plane and in space; `commit` performs one.
//! - `element_model`: the law of the elements; `edit_scene`: the surroundings of the gel.
//! - `trial`: legality of an operation, and the states and greatest hindrance of its new elements; `topology`: legality
//!   of changes of the surface.
//! - `velocity`: the velocities after an operation, which keep momentum and kinetic energy.
//! - `improvement`: which elements are remade, and by which operation; `refinement` and `coarsening` by the
//!   `edge_rules`; `nodal_sizes` bound the lengths of most edges.

mod coarsening;
mod commit;
mod construction;
mod edge_rules;
mod edit_scene;
mod editable_mesh;
mod element_model;
mod improvement;
mod nodal_sizes;
mod operation;
mod refinement;
mod regrouping;
#[cfg(test)]
mod tests;
mod topology;
mod trial;
mod velocity;

pub use edit_scene::EditScene;
pub use editable_mesh::{EditSource, EditableMesh, EditedMesh, ReferenceConfiguration};
pub use element_model::{ElementModel, ElementState};
pub use improvement::{EditCounts, EditLimits, improve};
