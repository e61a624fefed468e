//! Frame of a run, read back: the grid of the gel with the bodies of the history.

use super::grid::{self, GelGrid};
use super::table::CsvTable;
use crate::contact::{DomeMotion, ExpansionMotion, ShapeMotion};
use crate::math::{Vector, Vector3};
use crate::mesh::{self, NodeId, Simplex};
use crate::output::reading::MOST_RESULT_BYTES;
use crate::scene::{OutputField, Scene};
use crate::simulation::{BlockMotion, BodyKinematics, BodyPose, FrameCells, FrameField, MeshFrame};

/// Boundary of the elements of the last frame: most frames of a mesh have the same.
#[derive(Default)]
pub(super) struct KnownBoundary {
    elements: Vec<[u32; 4]>,
    facets: Vec<[u32; 3]>,
}

impl KnownBoundary {
    /// Returns the boundary facets of elements with this number of corners.
    fn of(&mut self, elements: &[[u32; 4]], corners: usize) -> Vec<[u32; 3]> {
        if self.elements != elements {
            (self.elements, self.facets) = (elements.to_vec(), boundary_facets(elements, corners));
        }
        self.facets.clone()
    }
}

/// Reads a frame from the bytes of its grid file.
///
/// # Errors
/// The content found instead of a frame of this crate.
pub(super) fn read(
    bytes: &[u8],
    scene: &Scene,
    history: &CsvTable,
    boundary: &mut KnownBoundary,
) -> Result<MeshFrame, String> {
    let names: Vec<&str> = scene.output.fields.iter().map(|field| field.name()).collect();
    Ok(mesh_frame(grid::parse(bytes, &names, MOST_RESULT_BYTES)?, scene, history, boundary))
}

/// Returns the motion of the block.
fn block_motion(history: &CsvTable, row: &[f64]) -> BlockMotion {
    let vector = |before: &str, after: &str| {
        let column = |axis: &str| history.value(row, &format!("block_{before}_{axis}_{after}"));
        Vector3::from(["x", "y", "z"].map(|axis| column(axis).unwrap_or(0.0)))
    };
    BlockMotion { displacement: vector("displacement", "m"), velocity: vector("velocity", "m_per_s") }
}

/// Returns the pose of the body whose columns begin with `prefix`.
fn pose(history: &CsvTable, row: &[f64], prefix: &str) -> BodyPose {
    let value = |name: &str| history.value(row, &format!("{prefix}{name}")).unwrap_or(0.0);
    let vector = |before: &str, after: &str| {
        Vector3::from(["x", "y", "z"].map(|axis| value(&format!("{before}_{axis}_{after}"))))
    };
    let size = [value("bulge_height_m"), value("bulge_radius_m")];
    let dome = DomeMotion { size: size.into(), rate: Vector::<2>::zeros(), acceleration: Vector::<2>::zeros() };
    let opening = value("expansion");
    let expansion = (opening > 0.0).then_some(ShapeMotion::Expansion(ExpansionMotion::at_rest(opening, 0.0)));
    BodyPose {
        kinematics: BodyKinematics {
            position: vector("position", "m"),
            velocity: vector("velocity", "m_per_s"),
            orientation: ["w", "x", "y", "z"].map(|part| value(&format!("orientation_{part}"))),
            angular_velocity: vector("angular_velocity", "rad_per_s"),
        },
        shape_motion: if size[1] > 0.0 { Some(ShapeMotion::Bulge(dome)) } else { expansion },
        active: prefix.is_empty() || value("active") > 0.0,
    }
}

/// Returns the frame of a grid with the bodies of the history.
fn mesh_frame(grid: GelGrid, scene: &Scene, history: &CsvTable, boundary: &mut KnownBoundary) -> MeshFrame {
    let row = history.nearest_row(grid.time).unwrap_or_default();
    let block = block_motion(history, row);
    let prefixes = (0..=scene.fragment.len()).map(|i| if i == 0 { String::new() } else { format!("fragment{i}_") });
    let nodes: Vec<[u32; 4]> = grid
        .nodes
        .chunks(grid.corners)
        .map(|corners| std::array::from_fn(|i| corners.get(i).copied().unwrap_or(0)))
        .collect();
    let field = |(wanted, (points, cells)): (&OutputField, _)| FrameField {
        name: wanted.name(),
        unit: wanted.unit(),
        points,
        cells,
    };
    MeshFrame {
        time: grid.time,
        dimension: grid.corners - 1,
        mass: 0.0,
        velocities: grid.velocities,
        displacements: grid.displacements,
        points: grid.points,
        cells: FrameCells {
            facets: boundary.of(&nodes, grid.corners),
            nodes,
            step: grid.steps,
            jacobian: grid.jacobians,
            energy_density: grid.energy_densities,
            damage: grid.damage,
        },
        fields: scene.output.fields.iter().zip(grid.fields).map(field).collect(),
        bodies: prefixes.map(|prefix| pose(history, row, &prefix)).collect(),
        gel_displacement: block.displacement,
        block,
    }
}

/// Returns the boundary facets of elements with this number of corners.
fn boundary_facets(nodes: &[[u32; 4]], corners: usize) -> Vec<[u32; 3]> {
    let elements: Vec<Simplex> = nodes.iter().map(|corners| corners.map(NodeId)).collect();
    let facets = if corners == 4 { mesh::boundary::<3>(&elements) } else { mesh::boundary::<2>(&elements) };
    facets.iter().map(|facet| facet.map(|node| node.0)).collect()
}
