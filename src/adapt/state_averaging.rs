//! Reference shape of a new element from the states of the source elements that it overlaps (method 4.6).
//!
//! A *new element* of a remeshed hyperelastic gel covers parts of old ones, its *sources* (the cells of the supermesh,
//! Farrell et al. 2009). It must store the energy that these parts stored. In a hyperelastic gel this energy depends on
//! the deformation gradient F = D_x D_X⁻¹, with the edges of an element as columns, D_x now and D_X at rest. D_x is
//! given by the new mesh, so the state is transferred by the choice of D_X, the reference shape.
//!
//! Two figures are required of D_X:
//!
//! - the measure at rest w₀ (area, volume, or area times radius of a ring), from [`super::rest_volumes`], as the bulk
//!   modulus acts on J = w/w₀;
//! - the distortion Ī₁ = tr(FᵀF)/J^⅔, as the shear modulus acts on it. It is the mean of the sources by the masses m_s
//!   of the overlaps: Ī₁* = Σ m_s Ī₁(F_s)/Σ m_s.
//!
//! The axes of the deformation are free. There are two candidates for F, and mostly neither has the distortion Ī₁*:
//!
//! - the *mean* ⟨F⟩ = Σ m_s F_s/Σ m_s, which forgets the differences between sources: mostly Ī₁(⟨F⟩) < Ī₁*;
//! - the *nodal* F, with D_X of the rest positions that the nodes carry. If it has w₀ and Ī₁*, the element is
//!   *compatible* with its nodes, and no reference shape of its own is stored.
//!
//! Any F is scaled to the required measure: F ← F/s, with s chosen so that D_X = s F⁻¹ D_x has w₀. The reference shape
//! of an incompatible element is then found by bisection of the straight line from an F of too little distortion to one
//! of enough:
//!
//! ```text
//!   Ī₁ too little               Ī₁*              Ī₁ enough
//!       A ────────────────────── F ────────────────── B       F = (1 − t) A + t B
//!
//!      ⟨F⟩                                         nodal F    if that has enough distortion
//!      ⟨F⟩                                       ⟨F⟩⟨F⟩ᵀ⟨F⟩   otherwise: stretches cubed, same axes
//!    R(⟨F⟩)                                          ⟨F⟩      sources rotated against each other: mean almost flat
//!   R(nodal F)                                     nodal F    mean inverted; else undistorted, F = 1
//! ```
//!
//! R is the rotation of the polar decomposition F = VR. In the plane the stretch λ out of it, in a ring around the
//! axis, belongs to F, and J = λ det F.

use super::patch_volume_share::measure;
use super::source_mesh::SourceMesh;
use crate::fem::{Potential, ReferenceShape, Section};
use crate::math::{Tensor, Vector, cofactor, cube_root, det};
use crate::mesh::ElementId;
use crate::remesh::OverlapSource;

/// Relative tolerance of the measure at rest and of the distortion, within which they agree with the required ones.
const COMPATIBILITY_TOLERANCE: f64 = 1e-9;
/// Number of bisections of the line between two deformations: their place is then exact to 2⁻⁴⁰ of it.
const BISECTIONS: usize = 40;
/// Number of Newton steps of the polar decomposition.
const POLAR_STEPS: usize = 40;

/// Averages of the sources of a new element, which its reference shape must reproduce.
pub(super) struct StateAverage<const D: usize> {
    /// Mean ⟨F⟩ and mean stretch out of the plane.
    strain: ElementStrain<D>,
    /// Mean Ī₁* of the distortions, which the mean of F does not preserve.
    distortion: f64,
    /// Required measure at rest w₀: area or volume, or area times radius of a ring.
    rest: f64,
    is_ring: bool,
}

/// Deformation of an element: F, and the stretch λ out of the plane, which is 1 in space and in plane strain.
#[derive(Clone, Copy)]
struct ElementStrain<const D: usize> {
    f: Tensor<D>,
    out: f64,
}

/// Reference shape with the required measure at rest, and the distortion of the element that has it.
#[derive(Clone, Copy)]
struct ScaledReference<const D: usize> {
    shape: ReferenceShape<D>,
    distortion: f64,
}

impl<const D: usize> ElementStrain<D> {
    /// Deformation of an old element with the nodes at `x`.
    fn of(past: &SourceMesh<'_, D>, x: &[Vector<D>], element: ElementId) -> Self {
        let (f, out) = past.potential.deformation_gradient(element, x);
        Self { f, out }
    }

    fn rest() -> Self {
        Self { f: Tensor::<D>::identity(), out: 1.0 }
    }

    fn zero() -> Self {
        Self { f: Tensor::<D>::zeros(), out: 0.0 }
    }

    fn plus(&self, other: &Self, part: f64) -> Self {
        Self { f: self.f + other.f * part, out: self.out + other.out * part }
    }

    /// Point (1 − t) A + t B of the line from this deformation A to another B.
    fn between(&self, other: &Self, t: f64) -> Self {
        Self::zero().plus(self, 1.0 - t).plus(other, t)
    }

    /// Rotation R of this deformation F = VR, without its stretches.
    fn rotation(&self) -> Self {
        Self { f: rotation(&self.f), out: 1.0 }
    }

    /// Deformation (F Fᵀ F, λ³): the same axes and rotation, with cubed stretches.
    fn with_cubed_stretches(&self) -> Self {
        Self { f: self.f * self.f.transpose() * self.f, out: self.out * self.out * self.out }
    }

    /// Invariant Ī₁ = (tr(FᵀF) + λ²)/J^⅔, without λ² in space, which measures distortion independently of volume.
    fn distortion(&self) -> f64 {
        let across = if D == 2 { self.out * self.out } else { 0.0 };
        let root = cube_root(det(&self.f) * self.out);
        (self.f.norm_squared() + across) / (root * root)
    }
}

/// Deformations and distortions of source elements, computed once: most have several targets.
pub(super) struct SourceStrains<const D: usize> {
    /// Index of each old element in `strains`, if it is a source.
    index: Vec<Option<u32>>,
    strains: Vec<(ElementStrain<D>, f64)>,
}

impl<const D: usize> SourceStrains<D> {
    /// Deformations of the sources, with the nodes at `x`.
    pub fn of(past: &SourceMesh<'_, D>, x: &[Vector<D>], sources: &[OverlapSource]) -> Self {
        let mut all = Self { index: vec![None; past.potential.len()], strains: vec![] };
        for old in sources.iter().map(|source| source.old) {
            if all.index[old.index()].is_none() {
                all.index[old.index()] = Some(all.strains.len() as u32);
                let strain = ElementStrain::of(past, x, old);
                all.strains.push((strain, strain.distortion()));
            }
        }
        all
    }

    /// Deformation and distortion of a source.
    fn at(&self, element: ElementId) -> (ElementStrain<D>, f64) {
        self.strains[self.index[element.index()].expect("it is a source") as usize]
    }
}

impl<const D: usize> StateAverage<D> {
    /// Averages the sources of a new element with the measure at rest `rest`: ⟨F⟩ = Σ m_s F_s/Σ m_s, likewise ⟨λ⟩ and
    /// Ī₁*.
    pub fn of(past: &SourceMesh<'_, D>, strains: &SourceStrains<D>, sources: &[OverlapSource], rest: f64) -> Self {
        let is_ring = past.potential.section() == Section::Axisymmetric;
        let (mut strain, mut distortion, mut mass) = (ElementStrain::zero(), 0.0, 0.0);
        let is_massive = sources.iter().any(|source| source.mass > 0.0);
        for source in sources {
            let (own, own_distortion) = strains.at(source.old);
            // Sources created outside the gel have no mass: their average is by volume.
            let weight = if is_massive { source.mass } else { source.part * past.rest(source.old) };
            strain = strain.plus(&own, weight);
            distortion += own_distortion * weight;
            mass += weight;
        }
        let strain = ElementStrain::zero().plus(&strain, 1.0 / mass);
        Self { strain, distortion: distortion / mass, rest, is_ring }
    }

    /// Returns true if the element is compatible: the shape `nodal` of its nodes' rest positions has the required
    /// measure at rest, and the deformation from it to the shape `present` has the required distortion.
    pub fn is_compatible(&self, nodal: &ReferenceShape<D>, present: &ReferenceShape<D>) -> bool {
        let agrees = |found: f64, required: f64| (found - required).abs() < COMPATIBILITY_TOLERANCE * required;
        let strain = self.nodal_deformation(nodal, present);
        agrees(nodal.size(self.is_ring), self.rest)
            && strain.is_some_and(|strain| agrees(strain.distortion(), self.distortion))
    }

    /// Deformation F = D_x D_X⁻¹, λ = r/R from the shape of the nodes' rest positions; `None` if that is inverted.
    fn nodal_deformation(&self, nodal: &ReferenceShape<D>, present: &ReferenceShape<D>) -> Option<ElementStrain<D>> {
        let out = if self.is_ring { present.radius / nodal.radius } else { 1.0 };
        let is_upright = out > 0.0 && out.is_finite();
        inverse(&nodal.edges).filter(|_| is_upright).map(|inverse| ElementStrain { f: present.edges * inverse, out })
    }

    /// Finds the reference shape with the required measure at rest and distortion of an incompatible element; `None` if
    /// the present shape is inverted.
    ///
    /// ⟨F⟩ is taken where it has the distortion Ī₁*. Otherwise F lies on one of the lines of the module's picture,
    /// where it reaches Ī₁*, found by bisection.
    ///
    /// The mean of F alone loses the differences between sources. A ball of 20 m/s lost 20 % of its energy by the
    /// mean of F on its way into gel. The nodes' deformation alone, where upright, gained 6 % (h = R/2, 18 meshes).
    pub fn required_reference(
        &self,
        nodal: &ReferenceShape<D>,
        present: &ReferenceShape<D>,
    ) -> Option<ReferenceShape<D>> {
        let mean = self.scaled_reference(&self.strain, present);
        let is_as_distorted =
            |fit: &ScaledReference<D>| (fit.distortion / self.distortion - 1.0).abs() <= COMPATIBILITY_TOLERANCE;
        if let Some(fit) = mean.filter(is_as_distorted) {
            return Some(fit.shape);
        }
        let nodal = self.nodal_deformation(nodal, present).filter(|nodal| self.reaches_distortion(nodal, present));
        let (from, to) = match mean {
            Some(fit) if fit.distortion > self.distortion => (self.strain.rotation(), self.strain),
            Some(_) => (self.strain, nodal.unwrap_or_else(|| self.strain.with_cubed_stretches())),
            None => nodal.map_or((ElementStrain::rest(), ElementStrain::rest()), |nodal| (nodal.rotation(), nodal)),
        };
        // A deformation between two upright ones may be inverted: the bisection stays below such a one.
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if self.reaches_distortion(&from.between(&to, middle), present) { high = middle } else { low = middle }
        }
        // Without any upright deformation the element is at rest in its present shape, scaled.
        let fit = self.scaled_reference(&from.between(&to, low), present);
        fit.or_else(|| self.scaled_reference(&ElementStrain::rest(), present)).map(|fit| fit.shape)
    }

    /// Returns true if a deformation, scaled to the required measure at rest, has at least the distortion Ī₁*, or is
    /// inverted.
    ///
    /// The distortion is that of [`Self::scaled_reference`], cubed to avoid the roots: Ī₁³ = (tr FᵀF)³/J². In space the
    /// scale s of F/s cancels. In the plane det(F/s) = w/w₀, thus s² = w₀ det F/w, and
    /// Ī₁³ = (tr FᵀF/s² + λ²)³/(λ w/w₀)².
    fn reaches_distortion(&self, strain: &ElementStrain<D>, present: &ReferenceShape<D>) -> bool {
        let (measure_now, det_f) = (measure(&present.edges), det(&strain.f));
        let rest = if self.is_ring { self.rest * strain.out / present.radius } else { self.rest };
        let growth = measure_now / rest;
        let (trace, jacobian) = match D {
            2 => (strain.f.norm_squared() / det_f * growth + strain.out * strain.out, growth * strain.out),
            _ => (strain.f.norm_squared(), det_f),
        };
        let cube = |x: f64| x * x * x;
        let is_upright = det_f > 0.0 && growth > 0.0 && (!self.is_ring || strain.out > 0.0);
        !is_upright || cube(trace) >= cube(self.distortion) * jacobian * jacobian
    }

    /// Reference shape D_X = s F⁻¹ D_x of an element with the deformation F/s, where s gives it the required measure at
    /// rest; `None` if F or the result is inverted. A ring has the mean radius r/λ at rest.
    fn scaled_reference(&self, strain: &ElementStrain<D>, present: &ReferenceShape<D>) -> Option<ScaledReference<D>> {
        let radius = if self.is_ring { present.radius / strain.out } else { present.radius };
        let rest = if self.is_ring { self.rest / radius } else { self.rest };
        let edges = inverse(&strain.f)? * present.edges;
        let scale = rest / measure(&edges);
        let edges = edges * if D == 2 { scale.sqrt() } else { cube_root(scale) };
        let f = present.edges * inverse(&edges)?;
        let is_valid = edges.norm().is_finite() && radius.is_finite() && (!self.is_ring || radius > 0.0);
        is_valid.then(|| ScaledReference {
            shape: ReferenceShape { edges, radius },
            distortion: ElementStrain { f, out: strain.out }.distortion(),
        })
    }
}

/// Rotation R of an upright F = VR, by Newton's iteration for the polar decomposition (Higham 1986): F ← (F + F⁻ᵀ)/2.
/// Both terms have the same R; each stretch λ becomes (λ + 1/λ)/2, which converges to 1.
fn rotation<const D: usize>(f: &Tensor<D>) -> Tensor<D> {
    (0..POLAR_STEPS).fold(*f, |f, _| (f + cofactor(&f) / det(&f)) * 0.5)
}

/// Inverse of an upright tensor; `None` if its determinant is not positive.
fn inverse<const D: usize>(a: &Tensor<D>) -> Option<Tensor<D>> {
    let det = det(a);
    (det > 0.0).then(|| cofactor(a).transpose() / det)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adapt::history::tests::instance;
    use crate::constitutive::{Material, NeoHookean};
    use crate::fem::Simplices;
    use crate::mesh::{BlockSpec, CellSplit, ElementPatches, block};

    #[test]
    fn an_average_of_rotated_sources_keeps_their_distortion() {
        let planes = [[0.0, 1.0]; 2].map(Vec::from);
        let mesh = block::<2>(BlockSpec { planes, split: CellSplit::Centred, faces: vec![] });
        let n = mesh.elements.len();
        let material = (Material::NeoHookean(NeoHookean::new(20e3, 2e6)), Section::Planar { thickness: 1.0 });
        let simplices = Simplices::in_patches(&mesh, ElementPatches::alone(n), material);
        let (position, elements) = (mesh.rest.clone(), mesh.elements.clone());
        let birth = instance(mesh, &position, 1.0);
        let past = SourceMesh::new(&simplices, &birth, &[], &position);
        let sources = [0, 1].map(|old| OverlapSource { new: ElementId(2), old: ElementId(old), mass: 1.0, part: 0.5 });
        let there = ReferenceShape::of(&position, &elements[2]);
        let mut upright = None;
        for angle in [0.0, 1.0, 2.0, 3.0] {
            let turn = Tensor::<2>::new(f64::cos(angle), -f64::sin(angle), f64::sin(angle), f64::cos(angle));
            // Two sources half a turn apart, one of them wider.
            let turned = |x: f64, y: f64| ElementStrain { f: turn * Tensor::<2>::new(x, 0.0, 0.2 * x, y), out: 1.0 };
            let all = [turned(1.5, 0.67), turned(-1.0, -0.66)].map(|strain| (strain, strain.distortion()));
            let [less, most] = [all[1].1, all[0].1];
            let strains = SourceStrains { index: vec![Some(0), Some(1), None, None], strains: all.to_vec() };
            let mean = StateAverage::of(&past, &strains, &sources, 0.25);
            let present = ReferenceShape { edges: turn * there.edges, ..there };
            let flat = mean.scaled_reference(&mean.strain, &present).unwrap().distortion;
            assert!(flat > 10.0 * most && less < mean.distortion && mean.distortion < most, "{less} {most} {flat}");

            let required = mean.required_reference(&there, &present).unwrap();

            let found = ElementStrain { f: present.edges * inverse(&required.edges).unwrap(), out: 1.0 };
            let error = found.distortion() / mean.distortion - 1.0;
            assert!(error.abs() < COMPATIBILITY_TOLERANCE, "{angle}: {}", found.distortion());
            assert!((measure(&required.edges) / 0.25 - 1.0).abs() < COMPATIBILITY_TOLERANCE, "{required:?}");
            // The rest shape does not depend on the rotation, and is stretched along the axes of the mean.
            let first: Tensor<2> = *upright.get_or_insert(required.edges);
            assert!((required.edges - first).amax() < 1e-9, "{angle}: {required:?}");
            let [squares, of_mean] = [found.f, mean.strain.f].map(|f| f * f.transpose());
            let across = squares * of_mean - of_mean * squares;
            assert!(across.amax() < 1e-9 * squares.norm() * of_mean.norm(), "{angle}: {across}");
        }
    }

    #[test]
    fn the_polar_decomposition_recovers_the_rotation() {
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, 2.0, -1.2).into_inner();
        let other = nalgebra::Rotation3::from_euler_angles(1.0, 0.5, 0.1).into_inner();
        let stretch = other * Tensor::<3>::from_diagonal(&Vector::<3>::new(4.0, 0.3, 1e-6)) * other.transpose();
        assert!((rotation::<3>(&(stretch * turn)) - turn).amax() < 1e-9);
    }
}
