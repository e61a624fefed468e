//! A scene: what the user wrote, read, checked and given back with every default filled in.

mod error;
mod read;
mod tables;
mod validate;

pub use error::{SceneError, SceneErrorKind};
pub use read::{Override, read, resolve};
pub use tables::*;
