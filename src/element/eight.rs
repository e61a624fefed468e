//! Eight elements at rest side by side, with the bits that one after the other has ([`super::simplex`], [`Simplices::evaluate`]): what a
//! mesh that is new is made ready by.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::{Batch, LANES, Wide, on, wide};
use super::solid::Solid;
use super::{Lanes, MAX_NODES, Measured, Memory, Potential, Section, Simplices};
use crate::algebra::{Number, Vector};
use crate::material::{Hyperelastic, Material, NeoHookean, Volume};
use crate::mesh::{ElementId, NodeId};
use fearless_simd::{Level, Simd, SimdBase, f64x8};

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

/// Eight elements where they are.
struct Displaced {
    rest: References<3>,
    /// What their nodes say that the edges are at rest, m.
    told: [[Wide; 3]; 3],
    /// 1 where that is not what they are.
    strange: Wide,
    /// By how much the displacements of the others differ from that of the first node, m.
    moved: [[Wide; 3]; 3],
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
    fn rest_of(&self, elements: &[Option<ElementId>; LANES]) -> References<D> {
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

    /// [`Potential::measure_all`]: of neo-Hookean tetrahedra that are patches by themselves eight at a time.
    pub(super) fn measured_at(&self, x: &[Vector<D>], memory: &[Memory<D>]) -> Measured {
        let mut measured = Measured::of(self.len(), self.patches().len());
        match &self.material {
            Material::NeoHookean(gel) if D == 3 && self.patches().largest() == 1 => {
                on!(Level::new(), simd => self.measure_eights((simd, gel), x, &mut measured));
            }
            _ => (0..self.patches().len()).for_each(|patch| measured.take(self, patch, (x, memory))),
        }
        measured
    }

    #[inline(always)]
    fn measure_eights<S: Simd>(&self, (simd, gel): (S, &NeoHookean), x: &[Vector<D>], measured: &mut Measured) {
        let n = self.len();
        for first in (0..n).step_by(LANES) {
            let ids: [ElementId; LANES] = std::array::from_fn(|lane| self.patches().of((first + lane).min(n - 1))[0]);
            let [energy, stiffness, jacobian] = stretched(simd, gel, &self.displaced(&ids, x));
            for (lane, id) in ids.iter().enumerate().take(n - first) {
                measured.energy[first + lane] = energy[lane];
                measured.stiffness[id.index()] = stiffness[lane];
                measured.jacobian[id.index()] = jacobian[lane];
            }
        }
    }

    /// Those tetrahedra with their nodes at `x`.
    fn displaced(&self, ids: &[ElementId; LANES], x: &[Vector<D>]) -> Displaced {
        let none = [[[0.0; LANES]; 3]; 3];
        let mut displaced = Displaced {
            rest: References { edges: none, radius: [1.0; LANES], filled: [1.0; LANES] },
            told: none,
            strange: [0.0; LANES],
            moved: none,
        };
        for (lane, id) in ids.iter().enumerate() {
            let nodes = &self.elements()[id.index()];
            let at = |node: NodeId| (&x[node.index()], &self.rest()[node.index()]);
            let (now, rest) = at(nodes[0]);
            for j in 0..3 {
                let (other, other_rest) = at(nodes[j + 1]);
                for i in 0..3 {
                    displaced.told[i][j][lane] = other_rest[i] - rest[i];
                    displaced.moved[i][j][lane] = (other[i] - other_rest[i]) - (now[i] - rest[i]);
                }
            }
            displaced.rest.copy(lane, &displaced.told);
            if !self.is_compatible(*id) {
                let own = self.reference(*id).edges;
                displaced.strange[lane] = 1.0;
                (0..9).for_each(|k| displaced.rest.edges[k / 3][k % 3][lane] = own[(k / 3, k % 3)]);
            }
        }
        displaced
    }
}

impl References<3> {
    /// Takes the edges of one lane.
    fn copy(&mut self, lane: usize, edges: &[[Wide; 3]; 3]) {
        (0..9).for_each(|k| self.edges[k / 3][k % 3][lane] = edges[k / 3][k % 3][lane]);
    }
}

/// V, J, κ, N/m, and J of eight tetrahedra that are patches by themselves, as [`Simplices`] has them.
#[inline(always)]
fn stretched<S: Simd>(simd: S, gel: &NeoHookean, of: &Displaced) -> [Wide; 3] {
    let (mu, zero) = (gel.shear_modulus(), f64x8::splat(simd, 0.0));
    let Shape { gradients: g, volume } = of.rest.shape(simd, Section::Spatial);
    let (moved, told) = (loaded(simd, &of.moved), loaded(simd, &of.told));
    let strange = wide(simd, &of.strange);
    let mut f = [[zero; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            let base = told[i][0] * g[0][j] + told[i][1] * g[1][j] + told[i][2] * g[2][j];
            let unit = zero.constant(if i == j { 1.0 } else { 0.0 });
            f[i][j] = moved[i][0] * g[0][j] + moved[i][1] * g[1][j] + moved[i][2] * g[2][j];
            f[i][j] += strange.choose(base, unit);
        }
    }
    let (j, cofactor) = (det(&f), cofactor(&f));
    let column = |k: usize| f[0][k] * f[0][k] + f[1][k] * f[1][k] + f[2][k] * f[2][k];
    let square = column(0) + column(1) + column(2);
    let u = Hyperelastic::volume(gel).volumetric(j);
    let first = [0, 1, 2].map(|i| zero - g[0][i] - g[1][i] - g[2][i]);
    let (mut spread, mut volumetric) = (zero, zero);
    for g in [&first, &g[0], &g[1], &g[2]] {
        spread += g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
        let b = [0, 1, 2].map(|i| cofactor[i][0] * g[0] + cofactor[i][1] * g[1] + cofactor[i][2] * g[2]);
        volumetric += b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
    }
    let turn = (square * 2.0).root();
    let even = (u.slope.absolute() * turn + mu) * spread;
    let stiffness = volume * (even + u.curvature.at_least(0.0) * volumetric);
    let energy = volume * ((square - 3.0) * (0.5 * mu) + u.energy);
    [energy.into(), stiffness.into(), j.into()]
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

/// [`crate::algebra::det`].
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

/// [`crate::algebra::cofactor`].
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
    use super::*;
    use crate::algebra::Tensor;
    use crate::element::Reference;
    use crate::mesh::{Block, Patches, Split, block, uniform};

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
            let (mut batch, mut law) = (Batch::default(), crate::element::elastic::Metric::<3>::default());
            on!(level, simd => put_in((simd, &gel), (&mut batch, &mut law), (&rest, Section::Spatial)));
            format!("{batch:?} {law:?}")
        };
        let widest = Level::new();
        let narrower = [widest.as_avx2().map(Level::Avx2), widest.as_sse2().map(Level::Sse2)];
        assert!(narrower.iter().any(Option::is_some), "there are instruction sets to compare");
        narrower.into_iter().flatten().for_each(|level| assert_eq!(made(level), made(widest)));
    }

    #[test]
    fn eight_tetrahedra_are_measured_with_the_bits_of_one() {
        let planes = std::array::from_fn(|_| uniform(0.0, 1.0, 0.25));
        let mesh = block::<3>(Block { planes, split: Split::Centred, faces: vec![] });
        let gel = NeoHookean::new(3.0, 40.0);
        let strange = |e: u32| {
            let told = Reference::of(&mesh.rest, &mesh.elements[e as usize]);
            let bent = Tensor::<3>::new(1.1, 0.2, 0.0, -0.1, 0.9, 0.3, 0.0, 0.1, 1.2);
            (ElementId(e), Reference { edges: bent * told.edges, ..told })
        };
        let references: Vec<_> = (3..90).step_by(5).map(strange).collect();
        let mut elements = mesh.elements.clone();
        // No multiple of eight.
        elements.truncate(elements.len() - 3);
        let mesh = crate::mesh::Mesh { elements, ..mesh.clone() };
        let all = Simplices::in_patches(&mesh, Patches::alone(mesh.elements.len()), (gel, Section::Spatial))
            .with_references(&references);
        for size in [0.0, 0.02, 0.3] {
            let wave = |i: usize, a: usize| size * ((7 * a + 3 * i) as f64).sin();
            let x: Vec<Vector<3>> =
                mesh.rest.iter().enumerate().map(|(a, x)| x + Vector::<3>::from_fn(|i, _| wave(i, a))).collect();
            let mut one = Measured::of(all.len(), all.len());
            (0..all.len()).for_each(|patch| one.take(&all, patch, (&x, &[])));
            assert_eq!(all.measure_all(&x, &[]), one, "{size}");
        }
    }
}
