//! Rest geometry of eight elements in vector lanes, bit-identical to the scalar form ([`super::simplex`]); prepares a
//! new mesh.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::{ElementBatch, LANES, LaneArray, load_lanes};
use super::simd_material::SimdMaterial;
use super::{ElementBatches, MAX_NODES, Section, Simplices};
use crate::math::Number;
use crate::mesh::ElementId;
use fearless_simd::{Simd, SimdBase, f64x8};

/// Reference shapes of eight elements.
pub(super) struct ReferenceBatch<const D: usize> {
    /// Edges as columns, m; the identity in an empty lane.
    edges: [[LaneArray; D]; D],
    /// R̄ of rings, m.
    radius: LaneArray,
    /// 1 in a filled lane, else 0.
    filled: LaneArray,
}

/// Gradients and volumes of eight elements at rest.
#[derive(Clone, Copy)]
pub(super) struct RestGeometry<const D: usize, V> {
    /// ∇N_a for a = 1..=D, 1/m.
    pub gradients: [[V; D]; D],
    /// Rest volume w, m³.
    pub volume: V,
}

impl<const D: usize> ReferenceBatch<D> {
    /// Computes the gradients and volumes; 0 in an empty lane.
    #[inline(always)]
    pub fn geometry<S: Simd>(&self, simd: S, section: Section) -> RestGeometry<D, f64x8<S>> {
        let edges = load_tensor(simd, &self.edges);
        let (det, cofactor, filled) = (det(&edges), cofactor(&edges), load_lanes(simd, &self.filled));
        let measure = det / det.constant(if D == 2 { 2.0 } else { 6.0 });
        let volume = match section {
            Section::Planar { thickness } => measure * thickness,
            Section::Axisymmetric => load_lanes(simd, &self.radius) * std::f64::consts::TAU * measure,
            Section::Spatial => measure,
        };
        let mut gradients = edges;
        for a in 0..D {
            for i in 0..D {
                gradients[a][i] = cofactor[i][a] / det * filled;
            }
        }
        RestGeometry { gradients, volume: volume * filled }
    }
}

impl<const D: usize> Simplices<D> {
    /// Collects the reference shapes of eight elements.
    pub(super) fn reference_batch(&self, elements: &[Option<ElementId>; LANES]) -> ReferenceBatch<D> {
        let mut rest = ReferenceBatch { edges: [[[0.0; LANES]; D]; D], radius: [1.0; LANES], filled: [0.0; LANES] };
        for (lane, element) in elements.iter().enumerate() {
            let Some(element) = element else {
                (0..D).for_each(|i| rest.edges[i][i][lane] = 1.0);
                continue;
            };
            let reference = self.reference(*element);
            (rest.radius[lane], rest.filled[lane]) = (reference.radius, 1.0);
            for i in 0..D {
                for j in 0..D {
                    rest.edges[i][j][lane] = reference.edges[(i, j)];
                }
            }
        }
        rest
    }

    /// Builds the SIMD form, [`super::Potential::lanes`].
    pub(super) fn build_batches(
        &self,
        slots: &[Option<ElementId>],
        depth: usize,
        local: &[[u16; MAX_NODES]],
    ) -> Option<ElementBatches<D>> {
        let mut lanes = ElementBatches::empty(slots.len(), depth, &self.material, self.section)?;
        for (at, (slots, local)) in slots.as_chunks::<LANES>().0.iter().zip(local.as_chunks::<LANES>().0).enumerate() {
            lanes.set_batch(at, &self.reference_batch(slots), local);
            for (lane, element) in slots.iter().enumerate() {
                if element.is_some_and(|element| !self.is_compatible(element)) {
                    lanes.mark_incompatible(at * LANES + lane);
                }
            }
        }
        Some(lanes)
    }
}

/// Loads a tensor of eight elements.
#[inline(always)]
fn load_tensor<const D: usize, S: Simd>(simd: S, rows: &[[LaneArray; D]; D]) -> [[f64x8<S>; D]; D] {
    let mut all = [[f64x8::splat(simd, 0.0); D]; D];
    for i in 0..D {
        for j in 0..D {
            all[i][j] = load_lanes(simd, &rows[i][j]);
        }
    }
    all
}

/// Stores the rest geometry and the rest data of eight elements in a batch.
#[inline(always)]
pub(super) fn store_rest_geometry<const D: usize, G: SimdMaterial<D>, S: Simd>(
    simd: S,
    gel: &G,
    batch: &mut ElementBatch,
    law: &mut G::Rest,
    rest: &ReferenceBatch<D>,
    section: Section,
) {
    let shape = rest.geometry(simd, section);
    let mut columns = shape.gradients;
    for a in 0..D {
        for i in 0..D {
            columns[i][a] = shape.gradients[a][i];
        }
    }
    (batch.volume, batch.scale) = (shape.volume.into(), det(&columns).into());
    *law = gel.rest(&shape);
}

/// Returns the determinant, as [`crate::math::det`].
#[inline(always)]
pub(super) fn det<const D: usize, V: Number>(a: &[[V; D]; D]) -> V {
    if D == 2 {
        return a[0][0] * a[1][1] - a[0][1] * a[1][0];
    }
    let (first, second, third) = (a[0], a[1], a[2 % D]);
    first[0] * (second[1] * third[2 % D] - second[2 % D] * third[1])
        - first[1] * (second[0] * third[2 % D] - second[2 % D] * third[0])
        + first[2 % D] * (second[0] * third[1] - second[1] * third[0])
}

/// Returns the cofactor tensor, as [`crate::math::cofactor`].
#[inline(always)]
fn cofactor<const D: usize, V: Number>(a: &[[V; D]; D]) -> [[V; D]; D] {
    let mut c = *a;
    if D == 2 {
        (c[0][0], c[0][1], c[1][0], c[1][1]) = (a[1][1], -a[1][0], -a[0][1], a[0][0]);
        return c;
    }
    for i in 0..D {
        for j in 0..D {
            let (k, l, m, n) = ((i + 1) % D, (i + 2) % D, (j + 1) % D, (j + 2) % D);
            c[i][j] = a[k][m] * a[l][n] - a[k][n] * a[l][m];
        }
    }
    c
}

#[cfg(test)]
mod tests {
    use super::super::batch::on;
    use super::*;
    use crate::constitutive::NeoHookean;
    use crate::mesh::{BlockSpec, CellSplit, ElementPatches, block, uniform};
    use fearless_simd::Level;

    #[test]
    #[cfg(target_arch = "x86_64")]
    fn every_instruction_set_gives_the_same_rest_geometry() {
        let planes = std::array::from_fn(|_| uniform(0.0, 1.0, 0.3));
        let mesh = block::<3>(BlockSpec { planes, split: CellSplit::Centred, faces: vec![] });
        let gel = NeoHookean::new(3.0, 40.0);
        let all = Simplices::in_patches(&mesh, ElementPatches::alone(mesh.elements.len()), (gel, Section::Spatial));
        // One lane is empty.
        let elements = std::array::from_fn(|lane| (lane < 7).then_some(ElementId(3 * lane as u32)));
        let rest = all.reference_batch(&elements);
        let made = |level: Level| {
            let (mut batch, mut law) =
                (ElementBatch::default(), crate::fem::hyperelastic_simd::ShearStiffness::<3>::default());
            on!(level, simd => store_rest_geometry(simd, &gel, &mut batch, &mut law, &rest, Section::Spatial));
            format!("{batch:?} {law:?}")
        };
        let widest = Level::new();
        let narrower = [widest.as_avx2().map(Level::Avx2), widest.as_sse2().map(Level::Sse2)];
        assert!(narrower.iter().any(Option::is_some), "there are instruction sets to compare");
        narrower.into_iter().flatten().for_each(|level| assert_eq!(made(level), made(widest)));
    }
}
