//! Meshes of the gel shapes: block, cylinder, hollow half sphere and L-beam.

use super::{CellSplit, Mesh, RectilinearGrid};
use crate::math::Vector;

/// Constrained directions of a held face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaceConstraint {
    /// Along its normal only.
    Normal,
    /// In every direction.
    All,
}

/// Held face: all nodes at the least (`high` false) or greatest coordinate along `axis`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HeldFace {
    /// Axis the face is normal to.
    pub axis: usize,
    /// Selects the face of greatest coordinate.
    pub high: bool,
    /// Constrained directions.
    pub hold: FaceConstraint,
}

/// Specification of a rectilinear block.
pub struct BlockSpec<const D: usize> {
    /// Planes along each axis, ascending, m.
    pub planes: [Vec<f64>; D],
    /// Subdivision of a cell into simplices.
    pub split: CellSplit,
    /// Held faces.
    pub faces: Vec<HeldFace>,
}

/// Meshes a block; also the half section of a cylinder in (r, z).
#[must_use]
pub fn block<const D: usize>(block: BlockSpec<D>) -> Mesh<D> {
    let ends: [[f64; 2]; D] = std::array::from_fn(|i| [block.planes[i][0], block.planes[i][block.planes[i].len() - 1]]);
    let grid = RectilinearGrid { planes: block.planes, filled: Box::new(|_| true) };
    let (points, elements) = grid.split(block.split);
    let mut mesh = Mesh::new(points, elements);
    for face in block.faces {
        let plane = ends[face.axis][usize::from(face.high)];
        constrain_nodes(&mut mesh, face, |x| x[face.axis] == plane);
    }
    mesh
}

fn constrain_nodes<const D: usize>(mesh: &mut Mesh<D>, face: HeldFace, on_face: impl Fn(&Vector<D>) -> bool) {
    for (_, held) in mesh.rest.iter().zip(&mut mesh.held).filter(|(x, _)| on_face(x)) {
        match face.hold {
            FaceConstraint::All => *held = [true; D],
            FaceConstraint::Normal => held[face.axis] = true,
        }
    }
}

/// Meshes a cylinder about z: the cross-section of a block of half width `radius` is mapped to a disc.
///
/// A point of the square at (x, y) moves to radius R₀ = max(|x|, |y|) on its ray, blended with the square itself by
/// (R₀/R)². The grid stays square near the axis and is round at the mantle. Faces of axis 0 denote the mantle.
#[must_use]
pub fn cylinder(radius: f64, square: BlockSpec<3>) -> Mesh<3> {
    let faces = square.faces.clone();
    let mut mesh = block(BlockSpec { faces: faces.iter().copied().filter(|f| f.axis == 2).collect(), ..square });
    // The planes of the square end at ±radius bit for bit.
    let on_mantle = |x: &Vector<3>| x[0].abs().max(x[1].abs()) == radius;
    for face in faces.into_iter().filter(|f| f.axis == 0) {
        constrain_nodes(&mut mesh, face, on_mantle);
    }
    for x in &mut mesh.rest {
        let (square, r) = (x[0].abs().max(x[1].abs()), (x[0] * x[0] + x[1] * x[1]).sqrt());
        if r > 0.0 {
            let round = (square / radius) * (square / radius);
            let scale = 1.0 + round * (square / r - 1.0);
            x[0] *= scale;
            x[1] *= scale;
        }
    }
    mesh
}

/// Radii from an inner to an outer sphere, and angles of a quarter turn, rad. Cells are as long as they are wide; at
/// the inner sphere they measure `size` or a little less.
#[must_use]
pub fn shell_planes([inner, outer]: [f64; 2], size: f64) -> [Vec<f64>; 2] {
    let angles = super::uniform(0.0, std::f64::consts::FRAC_PI_2, size / inner);
    let growth = 1.0 + std::f64::consts::FRAC_PI_2 / (angles.len() - 1) as f64;
    let mut radii = vec![inner];
    while radii[radii.len() - 1] * growth < outer {
        radii.push(radii[radii.len() - 1] * growth);
    }
    // The last cell takes the remainder; a remainder below half a cell is joined to the cell before it.
    let least = 0.5 * (growth - 1.0) * outer;
    if radii.len() > 1 && outer - radii[radii.len() - 1] < least {
        radii.pop();
    }
    radii.push(outer);
    [radii, angles]
}

/// Meshes the half section, in (r, z), of the lower half of a hollow sphere about the origin. The planes are radii and
/// angles: angle 0 is the axis below, a quarter turn the plane z = 0. Faces of axis 0 are the spheres, those of axis 1
/// the axis and that plane.
#[must_use]
pub fn shell(rays: BlockSpec<2>) -> Mesh<2> {
    let (radii, angles) = (rays.planes[0].clone(), rays.planes[1].clone());
    let faces = rays.faces.clone();
    let mut mesh = block(BlockSpec { faces: vec![], ..rays });
    let (outer, flat) = (radii[radii.len() - 1], angles[angles.len() - 1]);
    for (x, held) in mesh.rest.iter_mut().zip(&mut mesh.held) {
        let (radius, angle) = (x[0], x[1]);
        let (sin, cos) = if angle == flat { (1.0, 0.0) } else { libm::sincos(angle) };
        *x = Vector::<2>::new(radius * sin, -radius * cos);
        for face in &faces {
            let end = [[radii[0], outer], [0.0, flat]][face.axis][usize::from(face.high)];
            let along = if face.axis == 1 { usize::from(face.high) } else { 0 };
            match face.hold {
                _ if [radius, angle][face.axis] != end => {}
                FaceConstraint::All => *held = [true; 2],
                FaceConstraint::Normal => held[along] = true,
            }
        }
    }
    mesh
}

/// Meshes an L-beam: two legs at a right angle with the outer corner at the origin. It is built in the axes of the
/// legs, turned by `angle`, degrees, in the x–z plane and moved to `corner`. The first and the last planes run along
/// the legs.
///
/// # Panics
/// If the split is an octree.
#[must_use]
pub fn l_beam<const D: usize>(legs: BlockSpec<D>, thickness: f64, (angle, corner): (f64, Vector<D>)) -> Mesh<D> {
    assert!(!matches!(legs.split, CellSplit::Tree(_)), "a tree fills all of its box, a beam does not");
    let (along, up) = (legs.planes[0].clone(), legs.planes[D - 1].clone());
    let middle = |planes: &[f64], i: usize| 0.5 * (planes[i] + planes[i + 1]);
    let filled = move |cell: [usize; D]| middle(&along, cell[0]) < thickness || middle(&up, cell[D - 1]) < thickness;
    let (mut points, elements) = RectilinearGrid { planes: legs.planes, filled: Box::new(filled) }.split(legs.split);
    let (sin, cos) = libm::sincos(angle.to_radians());
    for x in &mut points {
        let (a, b) = (x[0], x[D - 1]);
        x[0] = cos * a - sin * b;
        x[D - 1] = sin * a + cos * b;
        *x += corner;
    }
    Mesh::new(points, elements)
}

#[cfg(test)]
mod tests {
    use super::super::uniform;
    use super::*;

    fn volume<const D: usize>(mesh: &Mesh<D>) -> f64 {
        mesh.elements.iter().map(|e| mesh.measure(e)).sum()
    }

    #[test]
    fn a_cylinder_tends_to_its_volume_and_holds_its_mantle() {
        let error = |n: f64| {
            let axis = || uniform(-2.0, 2.0, 4.0 / n);
            let mantle = HeldFace { axis: 0, high: true, hold: FaceConstraint::All };
            let square = BlockSpec {
                planes: [axis(), axis(), uniform(-1.0, 0.0, 0.5)],
                split: CellSplit::Centred,
                faces: vec![mantle],
            };
            let mesh = cylinder(2.0, square);
            for (x, held) in mesh.rest.iter().zip(&mesh.held) {
                let on_mantle = ((x[0] * x[0] + x[1] * x[1]).sqrt() - 2.0).abs() < 1e-12;
                assert_eq!(on_mantle, *held == [true; 3], "{x}");
            }
            4.0 * std::f64::consts::PI - volume(&mesh)
        };
        let (coarse, fine) = (error(8.0), error(16.0));
        assert!(coarse > 0.0 && fine > 0.0 && (coarse / fine - 4.0).abs() < 0.3);
    }

    #[test]
    fn an_l_beam_stands_on_its_corner() {
        let planes = || uniform(0.0, 1.0, 0.125);
        let legs = BlockSpec {
            planes: [planes(), uniform(-0.1, 0.1, 0.1), planes()],
            split: CellSplit::Centred,
            faces: vec![],
        };
        let corner = Vector::<3>::new(0.0, 0.0, 0.5);
        let mesh = l_beam(legs, 0.25, (45.0, corner));
        assert!((volume(&mesh) - 0.2 * (1.0 - 0.75 * 0.75)).abs() < 1e-12);
        let lowest = mesh.rest.iter().map(|x| x[2]).fold(f64::MAX, f64::min);
        assert!((lowest - 0.5).abs() < 1e-12);
    }

    #[test]
    fn faces_hold_their_nodes() {
        let faces = vec![
            HeldFace { axis: 1, high: false, hold: FaceConstraint::All },
            HeldFace { axis: 0, high: true, hold: FaceConstraint::Normal },
        ];
        let mesh = block(BlockSpec {
            planes: [uniform(0.0, 1.0, 0.5), uniform(0.0, 1.0, 0.5)],
            split: CellSplit::Kuhn,
            faces,
        });
        let count = |f: fn(&[bool; 2]) -> bool| mesh.held.iter().filter(|h| f(h)).count();
        assert_eq!(count(|h| h[1]), 3);
        assert_eq!(count(|h| h[0]), 5);
    }
}
