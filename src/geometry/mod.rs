//! Geometry of rigid bodies, and search trees over boxes and cells.
//!
//! Bodies are signed distance functions in their own frame: analytic ones (`bodies`) and closed triangle surfaces
//! (`trimesh`). `spatial` has one bounding volume hierarchy and one orthtree for bodies and meshes.

mod bodies;
mod shape;
mod signed_distance;
mod spatial;
mod trimesh;

pub use bodies::{Dome, ExpandingProfile, HalfSpace, ProfileBody, ProfileOutline, ProfileSweep, RoundedCuboid, Sphere};
pub use shape::ShapeGeometry;
pub use signed_distance::{Gap, SharpEnd, SignedDistance};
pub(crate) use spatial::{
    BoundingBox, Bvh, CellContact, CellDivision, FaceNeighbour, OrthCell, OrthTree, cell_indices, morton_code,
    morton_order, subdivide,
};
pub use trimesh::{ChiselCylinder, SurfaceError, TriangleSurface, TriangulatedBody};
