//! Volume of self-overlap of the gel at the end of a run.

use crate::math::{Vector, restrict};
use crate::mesh::{Mesh, NodeId};
use crate::remesh::{DeformedMesh, self_overlap_mass};
use crate::scene::{Dimension, Scene};
use crate::simulation::MeshFrame;

/// Returns the volume of gel that overlaps other gel, m³.
pub(super) fn volume(scene: &Scene, frame: &MeshFrame) -> f64 {
    let thickness = scene.thickness();
    match scene.scene.dimension {
        Dimension::Planar => overlap_volume::<2>(frame, |_| thickness),
        Dimension::Axisymmetric => overlap_volume::<2>(frame, |x| std::f64::consts::TAU * x[0].max(0.0)),
        Dimension::Spatial => {
            let copies = scene.gel.symmetry.copies();
            overlap_volume::<3>(frame, |_| copies)
        }
    }
}

fn overlap_volume<const D: usize>(frame: &MeshFrame, density: impl Fn(&Vector<D>) -> f64) -> f64 {
    let position: Vec<Vector<D>> = frame.points.iter().map(restrict::<D>).collect();
    let elements = frame.cells.nodes.iter().map(|nodes| nodes.map(NodeId)).collect();
    let facets = frame.cells.facets.iter().map(|nodes| nodes.map(NodeId)).collect();
    let mesh = Mesh { rest: position, elements, facets, held: vec![], marks: vec![] };
    self_overlap_mass(&DeformedMesh { mesh: &mesh, position: &mesh.rest }, density)
}
