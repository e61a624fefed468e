//! Scene: the user's input file, read, checked and returned with every default filled in.

mod bodies;
mod builtin;
mod cavity;
mod doubts;
mod error;
mod explain;
mod fidelity;
mod files;
mod fill;
mod former_keys;
mod gel;
mod library;
mod load;
mod material;
mod nearest;
mod overrides;
mod physics;
mod places;
mod preset;
mod projectile;
mod quantity;
mod read;
mod remesh;
#[cfg(feature = "cli")]
mod schema;
mod shape;
mod stl;
mod tables;
mod validate;

pub use bodies::{MOST_FRAGMENTS, body_name};
pub use builtin::{builtin, builtins};
pub use cavity::{AMBIENT_PRESSURE, CavitySpec};
pub use doubts::doubts;
pub use error::{SceneError, SceneErrorKind};
pub use fidelity::{FidelityKind, FidelityLevel, FidelityLevels};
pub use files::{FileSource, no_files};
pub use fill::from_preset;
pub use former_keys::former_keys;
pub use gel::*;
pub use library::{LibraryProjectile, ProjectileKind, library};
pub use load::*;
pub use material::*;
pub use nearest::{did_you_mean, nearest};
pub use overrides::{Override, rebase_scene, resolve, written};
pub use physics::{modelled_physics, switched_off};
pub(crate) use places::numbered;
pub use preset::{ApplicableModels, Preset, PresetValue, ShotRange};
pub use projectile::*;
pub use quantity::QuantityKind;
pub use read::{MOST_BYTES, OverriddenScene, OverrideError, read, read_with, read_with_files};
pub use remesh::{RemeshMethod, RemeshSpec};
#[cfg(feature = "cli")]
pub use schema::schema;
pub use tables::*;
pub use validate::MOST_STEPS;
