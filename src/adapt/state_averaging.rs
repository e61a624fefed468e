//! Averages of source elements for a new element, and the rest shape with their measure and distortion (method
//! 4.6).

use super::patch_volume_share::measure;
use super::source_mesh::SourceMesh;
use crate::fem::{Potential, ReferenceShape, Section};
use crate::math::{Tensor, Vector, cofactor, cube_root, det};
use crate::mesh::ElementId;
use crate::remesh::OverlapSource;

/// Relative tolerance of measure and distortion at rest, within which an element is compatible with its nodes' rest
/// positions.
const HOLDS: f64 = 1e-9;
/// Bisection steps for the deformation with the sources' distortion, and for a rotation.
const HALVINGS: usize = 40;

/// Mass-weighted averages of the sources of a new element, and their measure at rest.
pub(super) struct StateAverage<const D: usize> {
    strain: ElementStrain<D>,
    /// Mean of Ī₁, which the mean of F does not preserve.
    distortion: f64,
    /// Area or volume, or area times radius of a ring, at rest.
    rest: f64,
    is_ring: bool,
}

/// Deformation gradient F and the stretch out of the plane.
#[derive(Clone, Copy)]
struct ElementStrain<const D: usize> {
    f: Tensor<D>,
    out: f64,
}

impl<const D: usize> ElementStrain<D> {
    /// Deformation of an old element.
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

    /// Linear interpolation from this strain to another.
    fn between(&self, other: &Self, part: f64) -> Self {
        Self::zero().plus(self, 1.0 - part).plus(other, part)
    }

    /// Rotation of this strain without its distortion.
    fn undistorted(&self) -> Self {
        Self { f: rotation(&self.f), out: 1.0 }
    }

    /// Strain (F Fᵀ F, λ³): the same axes with cubed stretches.
    fn thrice(&self) -> Self {
        Self { f: self.f * self.f.transpose() * self.f, out: self.out * self.out * self.out }
    }

    /// Invariant Ī₁ = tr(FᵀF)/J^⅔, which measures distortion independently of volume.
    fn distortion(&self) -> f64 {
        let across = if D == 2 { self.out * self.out } else { 0.0 };
        let root = cube_root(det(&self.f) * self.out);
        (self.f.norm_squared() + across) / (root * root)
    }
}

/// Strains and distortions of source elements, computed once: most have several targets.
pub(super) struct SourceStrains<const D: usize> {
    /// Index of each old element among these, if it is a source.
    place: Vec<Option<u32>>,
    all: Vec<(ElementStrain<D>, f64)>,
}

impl<const D: usize> SourceStrains<D> {
    /// Strains of the sources, with the nodes at `x`.
    pub fn of(past: &SourceMesh<'_, D>, x: &[Vector<D>], sources: &[OverlapSource]) -> Self {
        let mut strains = Self { place: vec![None; past.potential.len()], all: vec![] };
        for old in sources.iter().map(|source| source.old) {
            if strains.place[old.index()].is_none() {
                strains.place[old.index()] = Some(strains.all.len() as u32);
                let strain = ElementStrain::of(past, x, old);
                strains.all.push((strain, strain.distortion()));
            }
        }
        strains
    }

    /// Strain and distortion of a source.
    fn at(&self, element: ElementId) -> (ElementStrain<D>, f64) {
        self.all[self.place[element.index()].expect("it is a source") as usize]
    }
}

impl<const D: usize> StateAverage<D> {
    /// Average of parts of old elements, with this measure at rest.
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

    /// Returns true if the nodes' rest positions give the sources' measure and distortion.
    pub fn is_told(&self, told: &ReferenceShape<D>, now: &ReferenceShape<D>) -> bool {
        let holds = |found: f64, wanted: f64| (found - wanted).abs() < HOLDS * wanted;
        let strain = self.said(told, now);
        holds(told.size(self.is_ring), self.rest)
            && strain.is_some_and(|strain| holds(strain.distortion(), self.distortion))
    }

    /// Deformation by the nodes' rest positions, if these are not inverted.
    fn said(&self, told: &ReferenceShape<D>, now: &ReferenceShape<D>) -> Option<ElementStrain<D>> {
        let out = if self.is_ring { now.radius / told.radius } else { 1.0 };
        let outside = out > 0.0 && out.is_finite();
        inverse(&told.edges).filter(|_| outside).map(|inverse| ElementStrain { f: now.edges * inverse, out })
    }

    /// Rest shape with the rest measure of the sources and their mean distortion, found by bisection.
    ///
    /// The mean of F has less distortion than the sources. The shape lies between this mean and the deformation by
    /// the nodes' rest positions. If the latter is less distorted, the shape lies between the mean and its cube. The
    /// mean of sources rotated against each other is almost flat, with more distortion. The shape then lies between
    /// the mean and its rotation. An inverted mean is replaced by the nodes' deformation.
    ///
    /// The mean of F alone loses the differences between sources. A ball of 20 m/s lost 20 % of its energy by the
    /// mean of F on its way into gel. The nodes' deformation alone, where upright, gained 6 % (h = R/2, 18 meshes).
    pub fn made(&self, told: &ReferenceShape<D>, now: &ReferenceShape<D>) -> Option<ReferenceShape<D>> {
        let mean = self.fitted(&self.strain, now);
        let holds = |fit: &(_, f64)| (fit.1 / self.distortion - 1.0).abs() <= HOLDS;
        if let Some(fit) = mean.filter(holds) {
            return Some(fit.0);
        }
        // A deformation between two upright ones may be inverted.
        let told = self.said(told, now).filter(|told| self.reaches(told, now));
        let (from, aim) = match mean {
            Some(fit) if fit.1 > self.distortion => (self.strain.undistorted(), self.strain),
            Some(_) => (self.strain, told.unwrap_or_else(|| self.strain.thrice())),
            None => told.map_or((ElementStrain::rest(), ElementStrain::rest()), |told| (told.undistorted(), told)),
        };
        let (mut less, mut more) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (less + more);
            if self.reaches(&from.between(&aim, middle), now) { more = middle } else { less = middle }
        }
        // Without information the current shape is at rest.
        let fit = self.fitted(&from.between(&aim, less), now).or_else(|| self.fitted(&ElementStrain::rest(), now));
        fit.map(|fit| fit.0)
    }

    /// Returns true if an element with this F, scaled to the measure at rest, has at least the mean distortion, or is
    /// inverted.
    ///
    /// The test is that of [`Self::fitted`], cubed to avoid the roots. F stretched by 1/s has det F/s^D = w/w₀: s
    /// cancels from Ī₁ in space, and is s² = w₀ det F/w in the plane.
    fn reaches(&self, strain: &ElementStrain<D>, now: &ReferenceShape<D>) -> bool {
        let (whole, turned) = (measure(&now.edges), det(&strain.f));
        let rest = if self.is_ring { self.rest * strain.out / now.radius } else { self.rest };
        let grown = whole / rest;
        let (square, volume) = match D {
            2 => (strain.f.norm_squared() / turned * grown + strain.out * strain.out, grown * strain.out),
            _ => (strain.f.norm_squared(), turned),
        };
        let cube = |x: f64| x * x * x;
        let is_upright = turned > 0.0 && grown > 0.0 && (!self.is_ring || strain.out > 0.0);
        !is_upright || cube(square) >= cube(self.distortion) * volume * volume
    }

    /// Reference of an element with this F, scaled to the measure at rest, and its distortion.
    fn fitted(&self, strain: &ElementStrain<D>, now: &ReferenceShape<D>) -> Option<(ReferenceShape<D>, f64)> {
        let radius = if self.is_ring { now.radius / strain.out } else { now.radius };
        let rest = if self.is_ring { self.rest / radius } else { self.rest };
        let edges = inverse(&strain.f)? * now.edges;
        let scale = rest / measure(&edges);
        let edges = edges * if D == 2 { scale.sqrt() } else { cube_root(scale) };
        let f = now.edges * inverse(&edges)?;
        let whole = edges.norm().is_finite() && radius.is_finite() && (!self.is_ring || radius > 0.0);
        whole.then(|| (ReferenceShape { edges, radius }, ElementStrain { f, out: strain.out }.distortion()))
    }
}

/// Rotation R of an upright F = VR, by Newton's iteration for the polar decomposition: F ← (F + F⁻ᵀ)/2. Both terms
/// have the same R; each stretch λ becomes (λ + 1/λ)/2, which converges to 1.
fn rotation<const D: usize>(f: &Tensor<D>) -> Tensor<D> {
    (0..HALVINGS).fold(*f, |f, _| (f + cofactor(&f) / det(&f)) * 0.5)
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
            let strains = SourceStrains { place: vec![Some(0), Some(1), None, None], all: all.to_vec() };
            let mean = StateAverage::of(&past, &strains, &sources, 0.25);
            let now = ReferenceShape { edges: turn * there.edges, ..there };
            let (_, flat) = mean.fitted(&mean.strain, &now).unwrap();
            assert!(flat > 10.0 * most && less < mean.distortion && mean.distortion < most, "{less} {most} {flat}");

            let made = mean.made(&there, &now).unwrap();

            let found = ElementStrain { f: now.edges * inverse(&made.edges).unwrap(), out: 1.0 };
            assert!((found.distortion() / mean.distortion - 1.0).abs() < HOLDS, "{angle}: {}", found.distortion());
            assert!((measure(&made.edges) / 0.25 - 1.0).abs() < HOLDS, "{made:?}");
            // The rest shape does not depend on the rotation, and is stretched along the axes of the mean.
            let first: Tensor<2> = *upright.get_or_insert(made.edges);
            assert!((made.edges - first).amax() < 1e-9, "{angle}: {made:?}");
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
