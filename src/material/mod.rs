//! Material models: stored energy, stress and stiffness bound, one file each.

mod neo_hookean;

pub use neo_hookean::{NeoHookean, Volumetric};
