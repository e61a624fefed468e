//! Element kernels of the materials, over [`crate::math::Number`]: one element, or eight in vector lanes.

pub(super) mod element_law;
pub(super) mod isotropic;
pub(super) mod kinematics;
pub(super) mod neo_hookean;
pub(super) mod rest_geometry;
pub(super) mod two_network;
