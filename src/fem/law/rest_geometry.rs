//! Rest geometry of elements, over [`Number`].

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use crate::fem::Section;
use crate::math::{Number, array};

/// Gradients and volumes at rest.
#[derive(Clone, Copy)]
pub(crate) struct RestGeometry<const D: usize, V> {
    /// ∇N_a for a = 1..=D, 1/m.
    pub gradients: [[V; D]; D],
    /// Rest volume w, m³.
    pub volume: V,
    /// Density relative to that of the gel; of a gel of one material at most 1, that of the lightest node of the element.
    pub density: V,
    /// Strength of the material relative to that of the gel.
    pub strength: V,
    /// Bulk modulus of the material relative to that of the gel.
    pub bulk: V,
}

/// Returns the volume of an element, m³, from the determinant of its edges and R̄ of a ring, m.
#[inline(always)]
pub(crate) fn volume_of<const D: usize, V: Number>(det: V, radius: V, section: Section) -> V {
    let measure = det / det.constant(if D == 2 { 2.0 } else { 6.0 });
    match section {
        Section::Planar { thickness } => measure * thickness,
        Section::Axisymmetric => radius * std::f64::consts::TAU * measure,
        Section::Spatial => measure,
    }
}

impl<const D: usize, V: Number> RestGeometry<D, V> {
    /// Computes the gradients and volumes from the edges as columns, m, and R̄ of rings, m.
    ///
    /// `filled` is 1 for an element, and 0, as then are the results, in an empty lane. The material is that of the gel.
    #[inline(always)]
    pub fn new(edges: &[[V; D]; D], radius: V, filled: V, section: Section) -> Self {
        let det = array::det(edges);
        let volume = volume_of::<D, V>(det, radius, section);
        let mut gradients = *edges;
        for a in 0..D {
            for i in 0..D {
                gradients[a][i] = array::cofactor(edges, i, a) / det * filled;
            }
        }
        let one = filled.constant(1.0);
        Self { gradients, volume: volume * filled, density: one, strength: one, bulk: one }
    }

    /// Returns the inverse determinant of the edges, 1/mᴰ.
    #[inline(always)]
    pub fn scale(&self) -> V {
        let mut columns = self.gradients;
        for a in 0..D {
            for i in 0..D {
                columns[i][a] = self.gradients[a][i];
            }
        }
        array::det(&columns)
    }
}
