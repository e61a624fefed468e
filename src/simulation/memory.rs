//! Memory that a scene needs, estimated from the grid of its mesh before any element is made.
//!
//! The figures are upper bounds for the peak of a phase. `tests/shortage.rs` holds them against an allocator that counts: no phase
//! takes more, and building and remeshing take at least half.

use super::build::{BuildError, MOST_CELLS, check_planes, n_cells, plane_block, section_block, space_block};
use super::{Saved, Simulation};
use crate::mesh::{Block, Split};
use crate::scene::{Dimension, GelShape, MaterialModel, Scene};

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
const BASE: f64 = 2e6;
/// Peak of the bytes per element while a mesh is made and laid out, in the plane and in space: 332 and 313 were found of plain gels.
const BUILDING: [f64; 2] = [390.0, 370.0];
/// More of an element that remembers: 310 and 430 were found.
const BUILDING_MEMORY: [f64; 2] = [370.0, 480.0];
/// Peak of the bytes per old element in an exchange of the mesh, in the plane and in space: 680 and 510 were found where the new mesh was as
/// large as the old one.
const REMESHING: [f64; 2] = [1000.0, 900.0];
/// More of an element that remembers: 250 were found in the plane.
const REMESHING_MEMORY: [f64; 2] = [700.0, 900.0];
/// What going to another mesh takes beside building it: of two meshes both are held.
const RESTORING: f64 = 1.5;
/// Bytes of the pictures of a frame and of the report whatever the mesh, and per element: 28 MB and 270 were found.
const PICTURES: f64 = 32e6;
const WRITING: f64 = 400.0;
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
    let (is_spatial, remembers) = (scene.scene.dimension == Dimension::Spatial, remembers(scene.gel.material));
    let size = MeshSize { elements, is_spatial, remembers };
    Ok(MemoryEstimate {
        elements: elements as u64,
        building: size.building() as u64,
        remeshing: scene.remesh.as_ref().map_or(0, |_| size.remeshing() as u64),
    })
}

impl Simulation {
    /// Bytes that an exchange of the mesh takes at most beside what is held; 0 where meshes are never exchanged.
    #[must_use]
    pub fn memory_of_remeshing(&self) -> u64 {
        if self.model.can_remesh() && !self.is_at_rest() { self.model.mesh_size().remeshing() as u64 } else { 0 }
    }

    /// Bytes that a frame of the results, or the report at the end, takes at most beside what is held.
    #[must_use]
    pub fn memory_of_writing(&self) -> u64 {
        (PICTURES + self.model.mesh_size().elements * WRITING) as u64
    }

    /// Bytes of a state.
    #[must_use]
    pub fn memory_of_state(&self) -> u64 {
        self.model.state_bytes() as u64
    }

    /// Bytes that going to a state takes at most beside what is held: a mesh that is not the present one is laid out again.
    #[must_use]
    pub fn memory_of_restoring(&self, saved: &Saved) -> u64 {
        let own = self.model.mesh_size();
        let larger = MeshSize { elements: own.elements.max(saved.n_elements() as f64), ..own };
        if self.model.can_remesh() { (RESTORING * larger.building()) as u64 } else { 0 }
    }
}

/// The size of a mesh, by which it takes memory.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeshSize {
    pub elements: f64,
    pub is_spatial: bool,
    /// Whether its elements remember how they were deformed.
    pub remembers: bool,
}

impl MeshSize {
    fn building(self) -> f64 {
        self.taken(BUILDING, BUILDING_MEMORY)
    }

    fn remeshing(self) -> f64 {
        self.taken(REMESHING, REMESHING_MEMORY)
    }

    fn taken(self, plain: [f64; 2], memory: [f64; 2]) -> f64 {
        let space = usize::from(self.is_spatial);
        BASE + self.elements * (plain[space] + if self.remembers { memory[space] } else { 0.0 })
    }
}

fn remembers(material: MaterialModel) -> bool {
    match material {
        MaterialModel::NeoHookean | MaterialModel::MooneyRivlin | MaterialModel::Ogden => false,
        MaterialModel::Flowing | MaterialModel::Viscoelastic => true,
    }
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

/// Elements of a beam beside those of as many cells of a block: its legs have more boundary.
const BEAM: f64 = 1.1;

/// Part of the grid that is filled: of the square around the legs of a beam, those.
fn filled_part(scene: &Scene) -> f64 {
    match scene.gel.shape {
        GelShape::LBeam { leg, thickness, .. } => {
            let empty = 1.0 - thickness / leg;
            BEAM * (1.0 - empty * empty)
        }
        GelShape::Block { .. } | GelShape::Cylinder { .. } | GelShape::Shell { .. } => 1.0,
    }
}
