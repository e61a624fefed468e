//! Scene: the user's input file, read, checked and returned with every default filled in.

mod bodies;
mod builtin;
mod doubts;
mod error;
mod exit;
mod explain;
mod gel;
mod fidelity;
mod files;
mod fill;
mod former_keys;
mod load;
mod material;
mod nearest;
mod overrides;
mod physics;
mod places;
mod preset;
mod projectile;
mod read;
mod remesh;
#[cfg(feature = "cli")]
mod schema;
mod sensor;
mod shape;
mod stl;
mod tables;
mod validate;

pub use bodies::{MOST_FRAGMENTS, body_name};
pub use builtin::{builtin, builtins};
pub use doubts::doubts;
pub use error::{SceneError, SceneErrorKind};
pub use exit::{NeverKeyword, StopAfterExit};
pub use gel::GelBox;
pub use fidelity::{FidelityKind, FidelityLevel, FidelityLevels};
pub use files::{FileSource, StlContent, no_files};
pub use fill::from_preset;
pub use former_keys::former_keys;
pub use load::*;
pub use material::*;
pub use nearest::{did_you_mean, nearest};
pub use overrides::{Override, OverrideError, read_with, rebase_scene, resolve, written};
pub use physics::{modelled_physics, switched_off};
pub(crate) use places::numbered;
pub use preset::{ApplicableModels, Preset, PresetValue, ShotRange};
pub use projectile::*;
pub use read::{MOST_BYTES, read, read_with_files};
pub use remesh::{RemeshMethod, RemeshSpec};
#[cfg(feature = "cli")]
pub use schema::schema;
pub use sensor::*;
pub use tables::*;
pub use validate::MOST_STEPS;
