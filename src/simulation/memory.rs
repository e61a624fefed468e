//! Memory that a scene needs, estimated from the grid of its mesh before any element is made.
//!
//! The figures are upper bounds for the peak of a phase. `tests/shortage.rs` holds them against an allocator that counts: no phase
//! takes more, and none of a mesh that matters takes less than a third.

use super::build::{BuildError, MOST_CELLS, check_planes, n_cells, plane_block, section_block, space_block};
use super::{Saved, Simulation};
use crate::mesh::{Block, Split};
use crate::scene::{Dimension, GelShape, Scene};

/// Memory that a scene needs, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemoryEstimate {
    /// Elements of its first mesh.
    pub elements: u64,
    /// Peak while it is built; a third to a half of it is kept.
    pub building: u64,
    /// Peak that an exchange of that mesh adds; 0 where meshes are never exchanged. A finer mesh takes more.
    pub remeshing: u64,
}

/// Bytes that any scene takes.
const BASE: f64 = 0.5e6;
/// Peak of the bytes per element while a mesh is made and laid out, in the plane and in space.
const BUILDING: [f64; 2] = [2400.0, 1500.0];
/// Peak of the bytes per old element in an exchange of the mesh, in the plane and in space.
const REMESHING: [f64; 2] = [6000.0, 6000.0];
/// Bytes that the report takes whatever the mesh, and the bytes per element of its pictures and of a frame.
const REPORT: f64 = 16e6;
const WRITING: f64 = 1000.0;
/// Elements per cell of a tree, which is not balanced yet when its cells are counted, in the plane and in space.
const PER_LEAF: [f64; 2] = [6.0, 20.0];

/// Estimates the memory that a scene needs, without building it.
///
/// # Errors
/// [`BuildError`] if its mesh is larger than any that is built.
pub fn memory_estimate(scene: &Scene) -> Result<MemoryEstimate, BuildError> {
    check_planes(scene)?;
    let elements = match scene.scene.dimension {
        Dimension::Planar => n_elements(&plane_block(scene))?,
        Dimension::Axisymmetric => n_elements(&section_block(scene))?,
        Dimension::Spatial => n_elements(&space_block(scene))?,
    };
    let elements = elements * filled_part(scene);
    Ok(MemoryEstimate {
        elements: elements as u64,
        building: building(elements, spatial(scene)),
        remeshing: scene.remesh.as_ref().map_or(0, |_| remeshing(elements, spatial(scene))),
    })
}

impl Simulation {
    /// Bytes that an exchange of the mesh takes at most beside what is held; 0 where meshes are never exchanged.
    #[must_use]
    pub fn memory_of_remeshing(&self) -> u64 {
        if self.model.can_remesh() { remeshing(self.model.n_elements() as f64, self.model.is_spatial()) } else { 0 }
    }

    /// Bytes that a frame of the results, or the report at the end, takes at most beside what is held.
    #[must_use]
    pub fn memory_of_writing(&self) -> u64 {
        (REPORT + self.model.n_elements() as f64 * WRITING) as u64
    }

    /// Bytes of a state.
    #[must_use]
    pub fn memory_of_state(&self) -> u64 {
        self.model.state_bytes() as u64
    }

    /// Bytes that going to a state takes at most beside what is held: a mesh that is not the present one is laid out again.
    #[must_use]
    pub fn memory_of_restoring(&self, saved: &Saved) -> u64 {
        let elements = saved.n_elements().max(self.model.n_elements());
        if self.model.can_remesh() { building(elements as f64, self.model.is_spatial()) } else { 0 }
    }
}

fn spatial(scene: &Scene) -> bool {
    scene.scene.dimension == Dimension::Spatial
}

fn building(elements: f64, is_spatial: bool) -> u64 {
    (BASE + elements * BUILDING[usize::from(is_spatial)]) as u64
}

fn remeshing(elements: f64, is_spatial: bool) -> u64 {
    (BASE + elements * REMESHING[usize::from(is_spatial)]) as u64
}

/// Elements that fill a grid.
fn n_elements<const D: usize>(block: &Block<D>) -> Result<f64, BuildError> {
    let cells = n_cells(block);
    if cells > MOST_CELLS {
        return Err(BuildError::TooLarge { cells, limit: MOST_CELLS });
    }
    Ok(match (block.split, D) {
        (Split::Kuhn, 2) => 2.0 * cells,
        (Split::Kuhn, _) => 6.0 * cells,
        (Split::Centred, 2) => 4.0 * cells,
        // Four at each face of a cell.
        (Split::Centred, _) => {
            let counts = block.planes.iter().map(|planes| planes.len() as f64 - 1.0);
            4.0 * counts.map(|n| cells + cells / n).sum::<f64>()
        }
        (Split::Tree(_), _) => cells * PER_LEAF[D - 2],
    })
}

/// Part of the grid that is filled: of the square around the legs of a beam, those.
fn filled_part(scene: &Scene) -> f64 {
    match scene.gel.shape {
        GelShape::LBeam { leg, thickness, .. } => {
            let empty = 1.0 - thickness / leg;
            1.0 - empty * empty
        }
        GelShape::Block { .. } | GelShape::Cylinder { .. } | GelShape::Shell { .. } => 1.0,
    }
}
