//! Meshes for the tests of remeshing.

use super::operations::{
    EditLimits, EditScene, EditSource, EditableMesh, ElementModel, ElementState, ReferenceConfiguration, improve,
};
use super::{BodySymmetry, DeformedMesh, ProposedMesh, corner_masses, nodal_masses};
use crate::math::Vector;
use crate::mesh::{
    BlockSpec, CORNERS, CellSplit, ElementPatches, FaceConstraint, HeldFace, Mesh, NodeIncidence, RectilinearGrid,
    block, shape_quality, signed_volume, uniform,
};

/// Unit square in crossed cells, `n` along each side.
pub(super) fn square(n: usize) -> Mesh<2> {
    let axis = || uniform(0.0, 1.0, 1.0 / n as f64);
    block(BlockSpec { planes: [axis(), axis()], split: CellSplit::Centred, faces: vec![] })
}

/// Unit square held at its foot and, along its normal, on its left.
pub(super) fn held(n: usize) -> Mesh<2> {
    let axis = || uniform(0.0, 1.0, 1.0 / n as f64);
    let foot = HeldFace { axis: 1, high: false, hold: FaceConstraint::All };
    let left = HeldFace { axis: 0, high: false, hold: FaceConstraint::Normal };
    block(BlockSpec { planes: [axis(), axis()], split: CellSplit::Centred, faces: vec![left, foot] })
}

/// Squares of 3 × 3 with a hole of 1 × 1, `pieces` of them beside each other.
pub(super) fn rings(pieces: usize, size: f64) -> Mesh<2> {
    let planes = [uniform(0.0, 4.0 * pieces as f64, size), uniform(0.0, 3.0, size)];
    let filled = move |[i, j]: [usize; 2]| {
        let [x, y] = [i, j].map(|n| (n as f64 + 0.5) * size);
        let x = x % 4.0;
        x < 3.0 && !(1.0 < x && x < 2.0 && 1.0 < y && y < 2.0)
    };
    let (points, elements) = RectilinearGrid { planes, filled: Box::new(filled) }.split(CellSplit::Centred);
    Mesh::new(points, elements)
}

/// Positions of the nodes after a map.
pub(super) fn moved(mesh: &Mesh<2>, map: impl Fn(&Vector<2>) -> Vector<2>) -> Vec<Vector<2>> {
    mesh.rest.iter().map(map).collect()
}

/// Elements of a gel that flows, remade below a quality of 0.4.
pub(super) struct FlowingShapes;

impl<const D: usize> ElementModel<D> for FlowingShapes {
    fn state(&self, _: &[Vector<D>; 4], now: &[Vector<D>; 4]) -> ElementState {
        let volume = signed_volume(now, &CORNERS);
        let hindrance = if volume > 0.0 { 0.4 / shape_quality(now, &CORNERS) } else { f64::INFINITY };
        ElementState { volume, jacobian: 1.0, density: 1.0, strength: 1.0, energy: 0.0, hindrance }
    }

    fn common_energy(&self, _: f64) -> f64 {
        0.0
    }

    fn smoothing(&self, _: f64) -> f64 {
        0.05
    }
}

/// Mesh that follows target lengths by operations in its present shape, as that of a gel that flows does.
pub(crate) fn edited<const D: usize>(
    old: &DeformedMesh<'_, D>,
    symmetry: BodySymmetry,
    size: &dyn Fn(&Vector<D>) -> f64,
) -> ProposedMesh<D> {
    let DeformedMesh { mesh, position } = *old;
    let (n, n_nodes) = (mesh.elements.len(), position.len());
    let masses: Vec<f64> = mesh.elements.iter().map(|nodes| signed_volume(position, nodes)).collect();
    let corner_mass = corner_masses(position, &mesh.elements, &masses, symmetry);
    let (patches, velocity) = (&ElementPatches::alone(n), &vec![Vector::zeros(); n_nodes]);
    let mass = &nodal_masses::<D>(n_nodes, &mesh.elements, &corner_mass);
    let incidence = NodeIncidence::new(n_nodes, mesh.elements.iter().map(|nodes| &nodes[..=D]));
    let mut editable = EditableMesh::new(EditSource {
        mesh,
        incidence: &incidence,
        patches,
        position,
        velocity,
        mass,
        corner_mass: &corner_mass,
        step: vec![1.0; n],
        is_compatible: vec![true; n],
        symmetry,
        configuration: ReferenceConfiguration::Present,
    });
    let scene = EditScene { gap: &|_| 1.0, cleared: &|x| *x, size, growth: f64::INFINITY };
    let least = position.iter().map(size).fold(f64::INFINITY, f64::min);
    let limits = EditLimits { energy: 1.0, usual: least, least };
    improve(&mut editable, &FlowingShapes, &scene, &limits, vec![]);
    let (new, _) = editable.finish();
    ProposedMesh { position: new.position, origin: new.origin, elements: new.elements, over: new.over }
}
