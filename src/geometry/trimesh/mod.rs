//! Rigid bodies bounded by a closed triangulated surface.

mod body;
mod chisel;
mod closest;
mod crossing;
mod exact;
mod field;
mod inner;
mod mass;
mod normals;
mod surface;
mod tips;
mod tree;
mod winding;

pub use body::TriangulatedBody;
pub use chisel::ChiselCylinder;
pub use surface::{SurfaceError, TriangleSurface};
