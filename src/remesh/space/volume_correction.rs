//! What an operation at the surface takes from the volume of the body or adds to it is given back at a point of it.

use super::tet_mesh::{Change, Complex, Tet, gradient};
use crate::math::Vector;

/// How a point may be moved along the surface's normal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Level {
    /// No further than this, m.
    pub most: f64,
    /// What is new must be better than this.
    pub enough: f64,
    /// What is not new and worse than this must not get worse by it.
    pub fair: f64,
}

impl Level {
    /// The change with a point of its surface where the volume stays what it was, and how good what is new is then; `None` where it
    /// may not go there.
    ///
    /// The volume is linear in the place of a point: a third of the area vectors of its facets is what it changes by. The
    /// point goes along that, in its free directions (Lindstrom, Turk 1998).
    pub fn kept(&self, complex: &Complex, change: &Change, point: u32) -> Option<(f64, Change)> {
        let holds = |tet: &&Tet| tet.contains(&point);
        let stays = || complex.star(point).filter(|(t, _)| !change.gone.contains(t));
        let around = stays().map(|(_, tet)| tet).chain(change.new.iter().filter(holds).copied());
        let gradient: Vector<3> = around.map(|tet| gradient(complex, &tet, point)).sum();
        let here = *complex.x(point);
        let along = complex.allowed(point, here + gradient) - here;
        let x = here - along * (change.swept / along.norm_squared());
        if (x - here).norm().is_nan() || (x - here).norm() > self.most {
            return None;
        }
        let bears = |(t, tet): (u32, Tet)| complex.would_be_with(&tet, (point, &x)) >= complex.shape(t).min(self.fair);
        let shapes = change.new.iter().map(|tet| complex.would_be_with(tet, (point, &x)));
        let worst = shapes.fold(f64::INFINITY, |worst, shape| if shape.is_nan() { shape } else { worst.min(shape) });
        let change = || Change { swept: 0.0, moved: Some((point, x)), ..change.clone() };
        (worst > self.enough && stays().all(bears)).then(|| (worst, change()))
    }
}
