//! Test surface: that of a cube of cells between given planes.

use super::surface::ContactSurface;
use crate::mesh::{BlockSpec, CellSplit, Mesh, block};

/// Creates a mesh of cells between the same planes along each axis, m.
pub(crate) fn mesh(planes: &[f64]) -> Mesh<3> {
    block(BlockSpec { planes: std::array::from_fn(|_| planes.to_vec()), split: CellSplit::Centred, faces: vec![] })
}

/// Returns the surface of a mesh, its facets of unit size.
pub(crate) fn surface(mesh: &Mesh<3>) -> ContactSurface {
    ContactSurface::new::<3>(mesh.rest.len(), mesh.facets.clone(), |_| (1.0, 1.0))
}

/// Returns a pseudo-random number from −1 to 1.
pub(crate) fn any(i: usize) -> f64 {
    (i as f64 * 12.9898).sin()
}
