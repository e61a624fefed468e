//! One triangle or tetrahedron: at rest, strained, and where its material remembers how it has flowed, what of that is elastic.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::{MAX_NODES, Memory, Reference, Section};
use crate::constitutive::NeoHookean;
use crate::math::{Number, Tensor, Vector, cofactor, cube_root, det};

/// Newton's steps to the determinant of 1 at most; stretched ninefold it takes 12 (from θ = 27 each of the first takes a third off).
const NEWTON: usize = 64;

/// An element at rest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Element<const D: usize> {
    pub gradients: [Vector<D>; MAX_NODES],
    /// w, rest volume, m³.
    pub volume: f64,
    /// 1/(3R̄) of a ring, 0 otherwise, 1/m.
    pub hoop: f64,
    /// Σ_a |∇N_a|², extended for a ring, 1/m².
    pub spread: f64,
    /// F and λ where its nodes are at rest: 1 if they say what it is.
    pub base: (Tensor<D>, f64),
}

/// F, λ and J of an element.
#[derive(Clone, Copy)]
pub(super) struct Strain<const D: usize> {
    pub f: Tensor<D>,
    pub cofactor: Tensor<D>,
    /// λ, stretch out of the plane.
    pub out: f64,
    /// det F in the plane or in space.
    pub inner: f64,
}

/// A strained element of a material whose isochoric part has J^(−2/3) held below the continuation of its volumetric one.
pub(super) struct Placed<'a, const D: usize> {
    pub element: &'a Element<D>,
    pub strain: &'a Strain<D>,
    /// J, no less than where the material law is continued.
    pub jacobian: f64,
    /// J^(−2/3).
    pub scale: f64,
    /// ∇N_a where the element is now, 1/m.
    gradients: [Vector<D>; MAX_NODES],
}

/// The elastic part of an isochoric deformation: b̄ = J^(−2/3) F C̄_p⁻¹ Fᵀ, and its component out of the plane.
#[derive(Clone, Copy)]
pub(super) struct Elastic<const D: usize> {
    pub inner: Tensor<D>,
    pub out: f64,
}

impl<const D: usize> Element<D> {
    pub fn new(reference: &Reference<D>, section: Section) -> Self {
        let measure = det(&reference.edges) / if D == 2 { 2.0 } else { 6.0 };
        let radius = reference.radius;
        let (volume, hoop) = match section {
            Section::Planar { thickness } => (measure * thickness, 0.0),
            Section::Axisymmetric => (std::f64::consts::TAU * radius * measure, 1.0 / (3.0 * radius)),
            Section::Spatial => (measure, 0.0),
        };
        let gradients = shape_gradients(&reference.edges);
        let spread = gradients[..=D].iter().map(|g| g.norm_squared() + hoop * hoop).sum();
        Self { gradients, volume, hoop, spread, base: (Tensor::<D>::identity(), 1.0) }
    }

    /// f_a = −w P ∇N_a, and −w P_θθ/(3R̄) along r of a ring; `hoop` is P_θθ, Pa.
    pub fn forces(&self, p: &Tensor<D>, hoop: f64) -> [Vector<D>; MAX_NODES] {
        let mut forces = [Vector::zeros(); MAX_NODES];
        for (force, gradient) in forces.iter_mut().zip(&self.gradients[..=D]) {
            *force = p * gradient * -self.volume;
            force[0] -= self.volume * (hoop * self.hoop);
        }
        forces
    }
}

/// ∇N_a at rest: the rows of the inverse of the edge matrix, and minus their sum for the first node.
fn shape_gradients<const D: usize>(edges: &Tensor<D>) -> [Vector<D>; MAX_NODES] {
    let inverse_transpose = cofactor(edges) / det(edges);
    let mut gradients = [Vector::<D>::zeros(); MAX_NODES];
    for a in 0..D {
        gradients[a + 1] = inverse_transpose.column(a).into_owned();
        gradients[0] -= inverse_transpose.column(a);
    }
    gradients
}

impl<const D: usize> Strain<D> {
    /// Of no element.
    pub fn none() -> Self {
        Self { f: Tensor::<D>::zeros(), cofactor: Tensor::<D>::zeros(), out: 0.0, inner: 0.0 }
    }

    pub fn jacobian(&self) -> f64 {
        self.inner * self.out
    }
}

impl<'a, const D: usize> Placed<'a, D> {
    pub fn new(element: &'a Element<D>, strain: &'a Strain<D>) -> Self {
        let jacobian = strain.jacobian().max(NeoHookean::FLOOR);
        let root = cube_root(jacobian);
        let push = strain.cofactor * (strain.out / jacobian);
        let mut gradients = element.gradients;
        gradients[..=D].iter_mut().for_each(|gradient| *gradient = push * *gradient);
        Self { element, strain, jacobian, scale: 1.0 / (root * root), gradients }
    }

    pub fn is_upright(&self) -> bool {
        self.strain.jacobian() >= NeoHookean::FLOOR
    }

    /// b̄ with what is remembered.
    pub fn elastic(&self, memory: &Memory<D>) -> Elastic<D> {
        let (f, squared) = (&self.strain.f, self.strain.out * self.strain.out);
        let out = if D == 2 { squared * memory.out * self.scale } else { 1.0 };
        Elastic { inner: f * memory.inverse * f.transpose() * self.scale, out }
    }

    /// ∇N_a where the element is now, 1/m.
    pub fn gradients(&self) -> &[Vector<D>] {
        &self.gradients[..=D]
    }

    /// 1/(3r̄) of a ring where it is now, 1/m.
    pub fn hoop(&self) -> f64 {
        self.element.hoop / self.strain.out
    }

    /// Bound of the curvature of ½(tr b̄ − 3) in the places of the nodes, 1/m².
    ///
    /// With L = δF F⁻¹ = Σ δx_a ⊗ g_a, the gradients g_a being those where the element is now (of a ring with their hoop parts), it is
    /// L:Lb̄ − 4/3 tr L b̄:L + 2/9 Ī₁ (tr L)² + Ī₁/3 tr(LL), and the terms with tr L are together at most 2 (d:L)²/Ī₁, d = dev b̄. Each is a
    /// square of a sum over the nodes, so at most the sum of their squares.
    pub fn shear_bound(&self, elastic: &Elastic<D>) -> f64 {
        let (deviator, trace, hoop) = (elastic.deviator(), elastic.trace(), self.hoop());
        let (mut sheared, mut spread) = (0.0, 0.0);
        for gradient in self.gradients() {
            sheared += gradient.dot(&(elastic.inner * gradient)) + hoop * hoop * elastic.out;
            let (inner, out) = ((deviator.inner * gradient).norm_squared(), hoop * deviator.out);
            sheared += 2.0 / trace * (inner + out * out);
            spread += gradient.norm_squared() + hoop * hoop;
        }
        sheared + trace / 3.0 * spread
    }
}

impl<const D: usize> Elastic<D> {
    pub fn trace(&self) -> f64 {
        self.inner.trace() + if D == 2 { self.out } else { 0.0 }
    }

    /// b̄ − tr b̄/3.
    pub fn deviator(&self) -> Self {
        let mean = self.trace() / 3.0;
        Self { inner: self.inner - Tensor::<D>::identity() * mean, out: if D == 2 { self.out - mean } else { 0.0 } }
    }

    pub fn norm_squared(&self) -> f64 {
        self.inner.norm_squared() + if D == 2 { self.out * self.out } else { 0.0 }
    }

    /// θ + s d of determinant 1 for a deviator d, which is this one; sought from a θ above.
    pub fn isochoric(&self, part: f64, above: f64) -> Self {
        let determinant = det(&self.inner) * if D == 2 { self.out } else { 1.0 };
        let mean = isochoric(above, (0.5 * part * part * self.norm_squared(), part * part * part * determinant));
        let whole = Tensor::<D>::identity() * mean + self.inner * part;
        Self { inner: whole, out: if D == 2 { mean + self.out * part } else { 1.0 } }
    }
}

/// The greatest root θ of θ³ − aθ + c = 1, det(θ + s d) with a = s²|d|²/2 and c = s³ det d, from above: there Newton's steps only fall.
#[inline(always)]
pub(super) fn isochoric<T: Number>(above: T, (a, c): (T, T)) -> T {
    let mut mean = above;
    for _ in 0..NEWTON {
        let less = (mean * (mean * mean - a) + c - 1.0) / (mean * 3.0 * mean - a);
        mean = mean - less;
        if !(less.absolute() - mean * f64::EPSILON).any_positive() {
            break;
        }
    }
    mean
}
