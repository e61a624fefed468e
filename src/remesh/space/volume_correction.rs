//! Volume correction: the volume change of a surface operation is returned at one of its points.

use super::tet_mesh::{MeshOperation, TetMesh, Tetrahedron, gradient};
use crate::math::Vector;

/// Limits of a volume correction along the surface normal.
#[derive(Debug, Clone, Copy)]
pub(super) struct VolumeCorrection {
    /// Greatest displacement, m.
    pub most: f64,
    /// Quality that new tetrahedra must exceed.
    pub enough: f64,
    /// Quality below which other tetrahedra must not worsen.
    pub fair: f64,
}

impl VolumeCorrection {
    /// Completes an operation by the displacement of a surface point that conserves the volume, and returns the new
    /// quality; `None` where the point may not move.
    ///
    /// The volume is linear in the position of a point; its gradient is a third of the area vectors of the facets. The
    /// point moves along the gradient, in its free directions (Lindstrom & Turk 1998).
    pub fn kept(&self, complex: &TetMesh, change: &MeshOperation, point: u32) -> Option<(f64, MeshOperation)> {
        let holds = |tet: &&Tetrahedron| tet.contains(&point);
        let stays = || complex.star(point).filter(|(t, _)| !change.gone.contains(t));
        let around = stays().map(|(_, tet)| tet).chain(change.new.iter().filter(holds).copied());
        let gradient: Vector<3> = around.map(|tet| gradient(complex, &tet, point)).sum();
        let here = *complex.x(point);
        let along = complex.project_to_free(point, here + gradient) - here;
        let x = here - along * (change.swept / along.norm_squared());
        if (x - here).norm().is_nan() || (x - here).norm() > self.most {
            return None;
        }
        let bears = |(t, tet): (u32, Tetrahedron)| {
            complex.displaced_shape(&tet, (point, &x)) >= complex.shape(t).min(self.fair)
        };
        let shapes = change.new.iter().map(|tet| complex.displaced_shape(tet, (point, &x)));
        let worst = shapes.fold(f64::INFINITY, |worst, shape| if shape.is_nan() { shape } else { worst.min(shape) });
        let change = || MeshOperation { swept: 0.0, moved: Some((point, x)), ..change.clone() };
        (worst > self.enough && stays().all(bears)).then(|| (worst, change()))
    }
}
