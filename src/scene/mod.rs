//! Scene: the user's input file, read, checked and returned with every default filled in.

mod block_fit;
mod bodies;
mod builtin;
mod cavity;
mod doubts;
mod error;
mod expansion;
mod explain;
mod fidelity;
mod files;
mod fill;
mod gel;
mod instant;
mod layer;
mod library;
mod load;
mod material;
mod model_error;
mod named_body;
mod nearest;
mod overrides;
mod physics;
mod places;
mod preset;
mod projectile;
mod quantity;
mod read;
mod remesh;
mod removed_keys;
#[cfg(feature = "cli")]
mod schema;
mod shape;
mod shape_in_gel;
mod stl;
mod tables;
mod validate;

pub use block_fit::{CAVITY_DRAG, CAVITY_MARGIN, GEL_RESISTANCE, block_doubts, cavity_estimate};
pub use bodies::{MOST_FRAGMENTS, body_name};
pub use builtin::{builtin, builtins};
pub use cavity::{AMBIENT_PRESSURE, CavitySpec};
pub use doubts::doubts;
pub use error::{SceneError, SceneErrorKind};
pub use expansion::{ExpansionSpec, MushroomSpec};
pub use fidelity::{FidelityKind, FidelityLevel, FidelityLevels};
pub use files::{FileSource, no_files};
pub use fill::from_preset;
pub use gel::*;
pub use instant::{describe_instant, shipped_coefficients};
pub use layer::{LayerSpec, layer_name, layer_stack};
pub use library::{
    DifferingValue, LIBRARY_VERSION, LibraryProjectile, LibraryValue, ProjectileKind, known_projectiles, library,
};
pub use load::*;
pub use material::*;
pub use model_error::shot_class;
pub use nearest::{KnownName, did_you_mean, suggestions};
pub use overrides::{Override, fill_bodies, rebase_scene, resolve, written};
pub use physics::{modelled_physics, switched_off};
pub(crate) use places::numbered;
pub use preset::{ApplicableModels, Preset, PresetValue, ShotClass, ShotData};
pub use projectile::*;
pub use quantity::QuantityKind;
pub use read::{MOST_BYTES, OverriddenScene, OverrideError, read, read_with, read_with_files};
pub use remesh::{RemeshMethod, RemeshSpec};
#[cfg(feature = "cli")]
pub use schema::schema;
pub use tables::*;
pub use validate::MOST_STEPS;
