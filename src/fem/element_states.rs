//! What all elements answer where they are, eight patches at a time, in lanes that are filled again and again: what a mesh that is new is
//! made ready by.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::{LANES, Wide, fused, on};
use super::layout::{Law, volumetric};
use super::node_cache::{Held, Local, rounding};
use super::simd_material::{Slopes, Solid, Strains};
use super::{DEPTH, Kick, Lanes, Measured, Memory, Potential, Recall, Simplices, places};
use crate::math::Vector;
use crate::mesh::ElementId;
use fearless_simd::{Level, Simd, SimdBase, f64x8};
use std::any::Any;

/// V, J, of eight patches, and κ, N/m, and J of their elements.
#[derive(Default)]
struct Answers {
    energy: Wide,
    stiffness: [Wide; DEPTH],
    jacobian: [Wide; DEPTH],
}

impl<const D: usize> Simplices<D> {
    /// [`Potential::measure_all`]: in lanes, where there are any.
    pub(super) fn measured_at(&self, x: &[Vector<D>], memory: &[Memory<D>]) -> Measured {
        let mut measured = Measured::of(self.len(), self.patches().len());
        let depth = if self.patches().largest() > 1 { places(D) } else { 1 };
        let Some(mut lanes) = Lanes::empty(LANES * depth, depth, (&self.material, self.section)) else {
            (0..self.patches().len()).for_each(|patch| measured.take(self, patch, (x, memory)));
            return measured;
        };
        let (mut local, mut remembered) = (Local::new(rounding(self.rest())), lanes.memory());
        for first in (0..self.patches().len()).step_by(LANES) {
            let ids =
                |lane: usize| if first + lane < self.patches().len() { self.patches().of(first + lane) } else { &[] };
            lanes.forget();
            for k in 0..depth {
                let slots = std::array::from_fn(|lane| ids(lane).get(k).copied());
                self.fill(&mut lanes, (k, &slots), x, &mut local);
                self.remind(&lanes, (k, &slots), memory, &mut remembered);
            }
            let answers = lanes.answers(&local, &mut remembered);
            for lane in 0..LANES.min(self.patches().len() - first) {
                measured.energy[first + lane] = answers.energy[lane];
                for (k, id) in ids(lane).iter().enumerate() {
                    measured.stiffness[id.index()] = answers.stiffness[k][lane];
                    measured.jacobian[id.index()] = answers.jacobian[k][lane];
                }
            }
        }
        measured
    }

    /// Puts these elements into the k-th batch, with nodes of their own.
    fn fill(
        &self,
        lanes: &mut Lanes<D>,
        (k, slots): (usize, &[Option<ElementId>; LANES]),
        x: &[Vector<D>],
        local: &mut Local,
    ) {
        let number = |lane: usize, a: usize| (k * LANES + lane) * (D + 1) + a;
        let numbers = std::array::from_fn(|lane| {
            let of = |a: usize| if a <= D { number(lane, a) as u16 } else { 0 };
            [0, 1, 2, 3].map(of)
        });
        lanes.put(k, &self.rest_of(slots), &numbers);
        for (lane, element) in slots.iter().enumerate() {
            let Some(element) = element else { continue };
            if !self.is_compatible(*element) {
                lanes.tell(k * LANES + lane);
            }
            let numbered = self.nodes(*element).iter().enumerate().map(|(a, node)| (number(lane, a), *node));
            local.load(Level::new(), &Held::new(x, self.rest()), numbered);
        }
    }

    /// Puts what they remember into its rows.
    fn remind(
        &self,
        lanes: &Lanes<D>,
        (k, slots): (usize, &[Option<ElementId>; LANES]),
        memory: &[Memory<D>],
        remembered: &mut [Recall],
    ) {
        let (rows, n) = (lanes.rows(), self.memories());
        for (lane, element) in slots.iter().enumerate().filter(|_| n > 0) {
            let Some(element) = element else { continue };
            lanes.remember(&mut remembered[k * rows..(k + 1) * rows], lane, &memory[element.index() * n..][..n]);
        }
    }
}

impl<const D: usize> Lanes<D> {
    /// What its first group answers at hold.
    fn answers(&self, local: &Local, memory: &mut [Recall]) -> Answers {
        // Not generic, as [`Self::sweep`].
        let lanes: &dyn Any = self;
        if let Some(lanes) = lanes.downcast_ref() {
            answers_in_plane(lanes, local, memory)
        } else {
            answers_in_space(lanes.downcast_ref().expect("the gel has two or three dimensions"), local, memory)
        }
    }

    /// With patches of one or `N` places.
    #[inline(always)]
    fn answers_of<const N: usize>(&self, local: &Local, memory: &mut [Recall]) -> Answers {
        match self.law() {
            Law::Elastic(gel, rest) => self.answers_by::<N, _>((gel, rest), local, memory),
            Law::Flowing(gel, rest) => self.answers_by::<N, _>((gel, rest), local, memory),
            Law::Relaxing(gel, rest) => self.answers_by::<N, _>((gel, rest), local, memory),
        }
    }

    fn answers_by<const N: usize, G: Solid<D>>(
        &self,
        (gel, rest): (&G, &[G::Rest]),
        local: &Local,
        memory: &mut [Recall],
    ) -> Answers {
        if self.depth() == 1 {
            on!(Level::new(), simd => self.hold::<1, _, _>((simd, gel, rest), local, memory))
        } else {
            on!(Level::new(), simd => self.hold::<N, _, _>((simd, gel, rest), local, memory))
        }
    }

    /// As a sweep in no time, but for what is given to the nodes.
    #[inline(always)]
    fn hold<const N: usize, G: Solid<D>, S: Simd>(
        &self,
        (simd, gel, rest): (S, &G, &[G::Rest]),
        local: &Local,
        memory: &mut [Recall],
    ) -> Answers {
        let (batches, rest) = (self.batches_of::<N>(0), rest.first_chunk().expect("a group is whole"));
        let zero = f64x8::splat(simd, 0.0);
        let mut strains = [Strains::at_rest(zero); N];
        let strained = self.strain_group::<N, G, S>((0, batches, rest), local.motion()[0], &mut strains);
        let mut slopes = [Slopes { slope: zero, curvature: zero }; N];
        let mut energy = volumetric::<D, N, S>(gel, batches, &strains, &mut slopes);
        let (mut answers, rows, kick) = (Answers::default(), gel.rows(), Kick { length: 0.0, elapsed: 0.0 });
        for k in 0..N {
            let own = &mut memory[k * rows..(k + 1) * rows];
            let pull = gel.pull(self.section(), (&batches[k], &rest[k], kick, own), (&strains[k], &slopes[k]));
            energy = fused(pull.energy, strained, energy);
            pull.stiffness.store_slice(&mut answers.stiffness[k]);
            strains[k].jacobian().store_slice(&mut answers.jacobian[k]);
        }
        energy.store_slice(&mut answers.energy);
        answers
    }
}

#[inline(never)]
fn answers_in_plane(lanes: &Lanes<2>, local: &Local, memory: &mut [Recall]) -> Answers {
    lanes.answers_of::<{ places(2) }>(local, memory)
}

#[inline(never)]
fn answers_in_space(lanes: &Lanes<3>, local: &Local, memory: &mut [Recall]) -> Answers {
    lanes.answers_of::<{ places(3) }>(local, memory)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constitutive::{BulkViscosity, EquationOfState, Flowing, Material, NeoHookean, Strength};
    use crate::fem::{Reference, Section};
    use crate::math::Tensor;
    use crate::mesh::{Block, Mesh, Patches, Split, block, uniform};

    /// All but the last three, no multiple of eight, in patches or each by itself, and some of them not what their nodes say.
    fn simplices<const D: usize>(material: &Material, section: Section, is_grouped: bool) -> Simplices<D> {
        let planes = std::array::from_fn(|_| uniform(0.5, 1.5, 0.25));
        let mut mesh = block::<D>(Block { planes, split: Split::Centred, faces: vec![] });
        mesh.elements.truncate(mesh.elements.len() - 3);
        let strange = |e: u32| {
            let told = Reference::of(&mesh.rest, &mesh.elements[e as usize]);
            let bent = Tensor::<D>::from_fn(|i, j| if i == j { 1.1 } else { 0.1 * (i as f64 - j as f64) });
            (ElementId(e), Reference { edges: bent * told.edges, ..told })
        };
        let references: Vec<_> = (3..60).step_by(5).map(strange).collect();
        let n = mesh.elements.len();
        let mesh = Mesh { elements: mesh.elements, ..mesh };
        let patches = if is_grouped { Patches::grouped(&mesh) } else { Patches::alone(n) };
        Simplices::in_patches(&mesh, patches, (*material, section)).with_references(&references)
    }

    fn check<const D: usize>(material: &Material, section: Section, is_grouped: bool) {
        let all = simplices::<D>(material, section, is_grouped);
        let mut memory = vec![Memory::default(); all.memories() * all.len()];
        for (e, memory) in memory.iter_mut().enumerate() {
            (memory.left, memory.plastic) = (1.0 - 0.1 * (e % 3) as f64, 0.1 * (e % 5) as f64);
        }
        for size in [0.0, 0.02, 0.1] {
            let wave = |i: usize, a: usize| size * ((7 * a + 3 * i) as f64).sin();
            let moved = |(a, x): (usize, &Vector<D>)| x + Vector::<D>::from_fn(|i, _| wave(i, a));
            let x: Vec<Vector<D>> = all.rest().iter().enumerate().map(moved).collect();
            let mut one = Measured::of(all.len(), all.patches().len());
            (0..all.patches().len()).for_each(|patch| one.take(&all, patch, (&x, &memory)));
            let eight = all.measure_all(&x, &memory);
            let close = |found: &[f64], wanted: &[f64], part: f64| {
                let scale = wanted.iter().map(|w| w.abs()).fold(0.0, f64::max);
                found.len() == wanted.len() && found.iter().zip(wanted).all(|(f, w)| (f - w).abs() <= part * scale)
            };
            assert!(close(&eight.jacobian, &one.jacobian, 1e-14), "{section:?} {size}");
            assert!(close(&eight.energy, &one.energy, 1e-13), "{section:?} {size}");
            for ids in (0..all.patches().len()).map(|patch| all.patches().of(patch)) {
                // What is alone among patches has the sum of two bounds in lanes, not that of the sum.
                let room = if ids.len() < all.patches().largest() { f64::INFINITY } else { 1e-8 };
                for e in ids.iter().map(|id| id.index()) {
                    let more = eight.stiffness[e] / one.stiffness[e] - 1.0;
                    // Of a ring the root of what rounding leaves of the difference of its stretches is in it.
                    assert!((-1e-8..=room).contains(&more), "{section:?} {size}: {more}");
                }
            }
        }
    }

    #[test]
    fn eight_patches_are_measured_as_one_after_the_other() {
        let flowing = Flowing {
            shear_modulus: 4.8,
            state: EquationOfState::new(60.0, 0.0, 20.0),
            strength: Some(Strength::new(0.3, 0.2, 1.6)),
            softening: None,
            viscosity: BulkViscosity { linear: 0.1, quadratic: 1.0 },
            density: 1.0,
        };
        for material in [NeoHookean::new(3.0, 40.0).into(), Material::Flowing(flowing)] {
            for is_grouped in [false, true] {
                check::<2>(&material, Section::Planar { thickness: 0.7 }, is_grouped);
                check::<2>(&material, Section::Axisymmetric, is_grouped);
                check::<3>(&material, Section::Spatial, is_grouped);
            }
        }
    }
}
