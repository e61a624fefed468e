//! Memory estimate of a scene from the grid of its mesh, before any element is made.
//!
//! The figures are upper bounds for the peak of a phase. `tests/shortage.rs` checks them with a counting allocator:
//! no phase exceeds its bound, and building and remeshing take at least half.

use super::build_error::BuildError;
use super::grid::{check_planes, n_cells, plane_block, section_block, space_block};
use super::reduced_section::REDUCED_ELEMENTS;
use crate::mesh::{BlockSpec, CellSplit};
use crate::scene::{Dimension, GelShape, MaterialModel, Scene};

/// Estimated memory of a scene, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemoryEstimate {
    /// Elements of the first mesh.
    pub elements: u64,
    /// Peak while the first mesh is built; a third to a half of it is kept.
    pub building: u64,
    /// Additional peak while that mesh is replaced; 0 without remeshing. A finer mesh takes more.
    pub remeshing: u64,
}

/// Bytes of any scene.
const BASE: f64 = 2e6;
/// Peak bytes per element while a mesh is built, in the plane and in space: 332 and 313 were measured for elastic
/// gels.
const BUILDING: [f64; 2] = [390.0, 370.0];
/// Additional bytes per element with history variables: 310 and 430 were measured.
const BUILDING_MEMORY: [f64; 2] = [370.0, 480.0];
/// Peak bytes per old element while a mesh is replaced, in the plane and in space. For a new mesh as large as the old
/// one, 680 and 510 were measured.
const REMESHING: [f64; 2] = [1000.0, 900.0];
/// Additional bytes per element with history variables: 250 were measured in the plane.
const REMESHING_MEMORY: [f64; 2] = [700.0, 900.0];
/// Ratio of the memory to restore another mesh to that of building it: two meshes are held at once.
const RESTORING: f64 = 1.5;
/// Bytes of the pictures of a frame and of the report for any mesh, and per element: 28 MB and 270 were measured.
const PICTURES: f64 = 32e6;
const WRITING: f64 = 400.0;
/// Bytes of a look at the cavity per element: the corners of a facet, and two sections of it at depths.
const LOOKING: f64 = 200.0;
/// Bytes of a field of a frame per element, at most: 30 of its values and their compressed copy, and 32 that the fields
/// have in common.
const FIELD: f64 = 64.0;
/// Elements per cell of a tree counted before it is balanced, in the plane and in space.
const PER_LEAF: [f64; 2] = [6.0, 20.0];

/// Estimates the memory that a scene needs, without building it.
///
/// # Errors
/// [`BuildError`] if its mesh exceeds the greatest size.
pub fn memory_estimate(scene: &Scene) -> Result<MemoryEstimate, BuildError> {
    if scene.reduced_class().is_some() {
        let size = MeshSize { elements: REDUCED_ELEMENTS as f64, is_spatial: false, has_history: false, fields: 0 };
        return Ok(MemoryEstimate {
            elements: REDUCED_ELEMENTS as u64,
            building: size.building() as u64,
            remeshing: 0,
        });
    }
    check_planes(scene)?;
    let elements = match scene.scene.dimension {
        Dimension::Planar => n_elements(&plane_block(scene))?,
        Dimension::Axisymmetric => n_elements(&section_block(scene))?,
        Dimension::Spatial => n_elements(&space_block(scene))?,
    };
    let elements = elements * filled_part(scene);
    let (is_spatial, has_history) = (scene.scene.dimension == Dimension::Spatial, has_history(scene.gel.material));
    let size = MeshSize { elements, is_spatial, has_history, fields: scene.output.fields.len() };
    Ok(MemoryEstimate {
        elements: elements as u64,
        building: size.building() as u64,
        remeshing: scene.remesh.as_ref().map_or(0, |_| size.remeshing() as u64),
    })
}

/// Size of a mesh as far as memory depends on it.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeshSize {
    pub elements: f64,
    pub is_spatial: bool,
    /// True if its elements have history variables.
    pub has_history: bool,
    /// Number of fields of a frame.
    pub fields: usize,
}

impl MeshSize {
    fn building(self) -> f64 {
        self.bytes(BUILDING, BUILDING_MEMORY)
    }

    /// Additional bytes of a remeshing at most.
    pub fn remeshing(self) -> f64 {
        self.bytes(REMESHING, REMESHING_MEMORY)
    }

    /// Additional bytes at most of laying out a saved mesh of this many elements again, beside this mesh.
    pub fn restoring(self, n_elements: f64) -> f64 {
        RESTORING * Self { elements: self.elements.max(n_elements), ..self }.building()
    }

    /// Additional bytes at most of a frame of the results, or of the final report.
    pub fn writing(self) -> f64 {
        PICTURES + self.elements * (WRITING + FIELD * self.fields as f64)
    }

    /// Additional bytes at most of the sections of the surface at a look at the cavity.
    pub fn looking(self) -> f64 {
        self.elements * LOOKING
    }

    fn bytes(self, plain: [f64; 2], memory: [f64; 2]) -> f64 {
        let space = usize::from(self.is_spatial);
        BASE + self.elements * (plain[space] + if self.has_history { memory[space] } else { 0.0 })
    }
}

fn has_history(material: MaterialModel) -> bool {
    match material {
        MaterialModel::NeoHookean | MaterialModel::MooneyRivlin | MaterialModel::Ogden => false,
        MaterialModel::TwoNetwork => true,
    }
}

/// Number of elements that fill a grid.
fn n_elements<const D: usize>(block: &BlockSpec<D>) -> Result<f64, BuildError> {
    let cells = n_cells(block)?;
    Ok(match (block.split, D) {
        (CellSplit::Kuhn, 2) => 2.0 * cells,
        (CellSplit::Kuhn, _) => 6.0 * cells,
        (CellSplit::Centred, 2) => 4.0 * cells,
        // Four tetrahedra at each face of a cell.
        (CellSplit::Centred, _) => {
            let counts = block.planes.iter().map(|planes| planes.len() as f64 - 1.0);
            4.0 * counts.map(|n| cells + cells / n).sum::<f64>()
        }
        (CellSplit::Tree(_), _) => cells * PER_LEAF[D - 2],
    })
}

/// Ratio of the elements of a beam to those of a block of as many cells: its legs have more boundary.
const BEAM: f64 = 1.1;

/// Fraction of the grid that the gel fills: less than 1 for the square around the legs of a beam.
fn filled_part(scene: &Scene) -> f64 {
    match scene.gel.shape {
        GelShape::LBeam { leg, thickness, .. } => {
            let empty = 1.0 - thickness / leg;
            BEAM * (1.0 - empty * empty)
        }
        GelShape::Block { .. } | GelShape::Cylinder { .. } | GelShape::Shell { .. } => 1.0,
    }
}
