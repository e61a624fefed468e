//! Meshes for the tests of remeshing.

use crate::math::Vector;
use crate::mesh::{BlockSpec, CellSplit, FaceConstraint, HeldFace, Mesh, RectilinearGrid, block, uniform};

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
