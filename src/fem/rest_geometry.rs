//! Eight elements at rest side by side, with the bits that one after the other has ([`super::simplex`]): what a mesh that is new is made
//! ready by.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::{Batch, LANES, Wide, wide};
use super::simd_material::Solid;
use super::{Lanes, MAX_NODES, Section, Simplices};
use crate::math::Number;
use crate::mesh::ElementId;
use fearless_simd::{Simd, SimdBase, f64x8};

/// Eight elements as they are at rest.
pub(super) struct References<const D: usize> {
    /// Their edges, as columns, m; 1 where there is no element.
    edges: [[Wide; D]; D],
    /// R̄ of rings, m.
    radius: Wide,
    /// 1 where there is an element, else 0.
    filled: Wide,
}

/// What follows from the edges of eight elements.
#[derive(Clone, Copy)]
pub(super) struct Shape<const D: usize, V> {
    /// ∇N_a for a = 1..=D, 1/m.
    pub gradients: [[V; D]; D],
    /// w, rest volume, m³.
    pub volume: V,
}

impl<const D: usize> References<D> {
    /// Gradients and volumes; 0 where there is no element.
    #[inline(always)]
    pub fn shape<S: Simd>(&self, simd: S, section: Section) -> Shape<D, f64x8<S>> {
        let edges = loaded(simd, &self.edges);
        let (det, cofactor, filled) = (det(&edges), cofactor(&edges), wide(simd, &self.filled));
        let measure = det / det.constant(if D == 2 { 2.0 } else { 6.0 });
        let volume = match section {
            Section::Planar { thickness } => measure * thickness,
            Section::Axisymmetric => wide(simd, &self.radius) * std::f64::consts::TAU * measure,
            Section::Spatial => measure,
        };
        let mut gradients = edges;
        for a in 0..D {
            for i in 0..D {
                gradients[a][i] = cofactor[i][a] / det * filled;
            }
        }
        Shape { gradients, volume: volume * filled }
    }
}

impl<const D: usize> Simplices<D> {
    /// Those elements at rest.
    pub(super) fn rest_of(&self, elements: &[Option<ElementId>; LANES]) -> References<D> {
        let mut rest = References { edges: [[[0.0; LANES]; D]; D], radius: [1.0; LANES], filled: [0.0; LANES] };
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

    /// [`Potential::lanes`].
    pub(super) fn in_lanes(
        &self,
        slots: &[Option<ElementId>],
        depth: usize,
        local: &[[u16; MAX_NODES]],
    ) -> Option<Lanes<D>> {
        let mut lanes = Lanes::empty(slots.len(), depth, (&self.material, self.section))?;
        for (at, (slots, local)) in slots.as_chunks::<LANES>().0.iter().zip(local.as_chunks::<LANES>().0).enumerate() {
            lanes.put(at, &self.rest_of(slots), local);
            for (lane, element) in slots.iter().enumerate() {
                if element.is_some_and(|element| !self.is_compatible(element)) {
                    lanes.tell(at * LANES + lane);
                }
            }
        }
        Some(lanes)
    }
}

#[inline(always)]
fn loaded<const D: usize, S: Simd>(simd: S, rows: &[[Wide; D]; D]) -> [[f64x8<S>; D]; D] {
    let mut all = [[f64x8::splat(simd, 0.0); D]; D];
    for i in 0..D {
        for j in 0..D {
            all[i][j] = wide(simd, &rows[i][j]);
        }
    }
    all
}

/// Notes eight elements.
#[inline(always)]
pub(super) fn put_in<const D: usize, G: Solid<D>, S: Simd>(
    (simd, gel): (S, &G),
    (batch, law): (&mut Batch, &mut G::Rest),
    (rest, section): (&References<D>, Section),
) {
    let shape = rest.shape(simd, section);
    let mut columns = shape.gradients;
    for a in 0..D {
        for i in 0..D {
            columns[i][a] = shape.gradients[a][i];
        }
    }
    (batch.volume, batch.scale) = (shape.volume.into(), det(&columns).into());
    *law = gel.rest(&shape);
}

/// [`crate::math::det`].
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

/// [`crate::math::cofactor`].
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
    use crate::mesh::{Block, Patches, Split, block, uniform};
    use fearless_simd::Level;

    #[test]
    #[cfg(target_arch = "x86_64")]
    fn every_instruction_set_makes_ready_the_same_bits() {
        let planes = std::array::from_fn(|_| uniform(0.0, 1.0, 0.3));
        let mesh = block::<3>(Block { planes, split: Split::Centred, faces: vec![] });
        let gel = NeoHookean::new(3.0, 40.0);
        let all = Simplices::in_patches(&mesh, Patches::alone(mesh.elements.len()), (gel, Section::Spatial));
        // One lane is empty.
        let elements = std::array::from_fn(|lane| (lane < 7).then_some(ElementId(3 * lane as u32)));
        let rest = all.rest_of(&elements);
        let made = |level: Level| {
            let (mut batch, mut law) = (Batch::default(), crate::fem::hyperelastic_simd::Metric::<3>::default());
            on!(level, simd => put_in((simd, &gel), (&mut batch, &mut law), (&rest, Section::Spatial)));
            format!("{batch:?} {law:?}")
        };
        let widest = Level::new();
        let narrower = [widest.as_avx2().map(Level::Avx2), widest.as_sse2().map(Level::Sse2)];
        assert!(narrower.iter().any(Option::is_some), "there are instruction sets to compare");
        narrower.into_iter().flatten().for_each(|level| assert_eq!(made(level), made(widest)));
    }
}
