//! Kinematics of one triangle or tetrahedron: rest geometry, deformation gradient and elastic strain.

use crate::constitutive::NeoHookean;
use crate::fem::law::rest_geometry::RestGeometry;
use crate::fem::{HistoryVariables, MAX_NODES, ReferenceShape, Section};
use crate::math::{Tensor, Vector, array, cube_root, det, isochoric_mean};

/// Rest geometry of an element.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RestElement<const D: usize> {
    /// Shape function gradients ∇N_a, 1/m.
    pub gradients: [Vector<D>; MAX_NODES],
    /// Rest volume w, m³.
    pub volume: f64,
    /// Hoop gradient 1/(3R̄) of a ring, 0 otherwise, 1/m.
    pub hoop: f64,
    /// F at the rest positions of the nodes: 1 for a compatible element.
    pub rest_f: Tensor<D>,
    /// λ at the rest positions of the nodes: 1 for a compatible element.
    pub rest_stretch: f64,
}

/// Deformation gradient F of an element, with its cofactor, the out-of-plane stretch λ and det F.
#[derive(Clone, Copy)]
pub(crate) struct DeformationGradient<const D: usize> {
    pub f: Tensor<D>,
    pub cofactor: Tensor<D>,
    /// Out-of-plane stretch λ.
    pub out: f64,
    /// det F in the plane or in space, without λ.
    pub det_f: f64,
}

/// Kinematics of a deformed element for isochoric–volumetric materials; J^(−2/3) is constant below the floor of J.
pub(crate) struct ElementKinematics<'a, const D: usize> {
    pub element: &'a RestElement<D>,
    pub strain: &'a DeformationGradient<D>,
    /// J, clamped to the floor of the material law.
    pub jacobian: f64,
    /// J^(−2/3).
    pub scale: f64,
    /// Spatial gradients ∇N_a, 1/m.
    gradients: [Vector<D>; MAX_NODES],
}

/// Isochoric elastic left Cauchy–Green tensor b̄ = J^(−2/3) F C̄_p⁻¹ Fᵀ, with its out-of-plane component.
#[derive(Clone, Copy)]
pub(crate) struct ElasticCauchyGreen<const D: usize> {
    pub tensor: Tensor<D>,
    pub out: f64,
}

impl<const D: usize> RestElement<D> {
    /// Computes the rest geometry from a reference shape.
    pub fn new(reference: &ReferenceShape<D>, section: Section) -> Self {
        let geometry = RestGeometry::new(&array::rows(&reference.edges), reference.radius, 1.0, section);
        let hoop = if section == Section::Axisymmetric { 1.0 / (3.0 * reference.radius) } else { 0.0 };
        let mut gradients = [Vector::<D>::zeros(); MAX_NODES];
        for (a, gradient) in geometry.gradients.into_iter().enumerate() {
            gradients[a + 1] = gradient.into();
            gradients[0] -= gradients[a + 1];
        }
        let volume = geometry.volume;
        Self { gradients, volume, hoop, rest_f: Tensor::<D>::identity(), rest_stretch: 1.0 }
    }

    /// Returns the nodal forces f_a = −w P ∇N_a, with −w P_θθ/(3R̄) along r for a ring; `hoop` is P_θθ, Pa.
    pub fn forces(&self, p: &Tensor<D>, hoop: f64) -> [Vector<D>; MAX_NODES] {
        let mut forces = [Vector::zeros(); MAX_NODES];
        for (force, gradient) in forces.iter_mut().zip(&self.gradients[..=D]) {
            *force = p * gradient * -self.volume;
            force[0] -= self.volume * (hoop * self.hoop);
        }
        forces
    }
}

impl<const D: usize> DeformationGradient<D> {
    /// Placeholder for an absent element.
    pub fn none() -> Self {
        Self { f: Tensor::<D>::zeros(), cofactor: Tensor::<D>::zeros(), out: 0.0, det_f: 0.0 }
    }

    /// Returns J = λ det F.
    pub fn jacobian(&self) -> f64 {
        self.det_f * self.out
    }
}

impl<'a, const D: usize> ElementKinematics<'a, D> {
    /// Computes the kinematics from the rest geometry and the deformation gradient.
    pub fn new(element: &'a RestElement<D>, strain: &'a DeformationGradient<D>) -> Self {
        let jacobian = strain.jacobian().max(NeoHookean::FLOOR);
        let root = cube_root(jacobian);
        let push = strain.cofactor * (strain.out / jacobian);
        let mut gradients = element.gradients;
        gradients[..=D].iter_mut().for_each(|gradient| *gradient = push * *gradient);
        Self { element, strain, jacobian, scale: 1.0 / (root * root), gradients }
    }

    /// Returns true if J is at or above the floor of the material law.
    pub fn is_above_floor(&self) -> bool {
        self.strain.jacobian() >= NeoHookean::FLOOR
    }

    /// Returns b̄ for the rest shape C̄_p⁻¹ of the history variables.
    pub fn elastic(&self, memory: &HistoryVariables<D>) -> ElasticCauchyGreen<D> {
        let (f, squared) = (&self.strain.f, self.strain.out * self.strain.out);
        let out = if D == 2 { squared * memory.out * self.scale } else { 1.0 };
        ElasticCauchyGreen { tensor: f * memory.inverse * f.transpose() * self.scale, out }
    }

    /// Returns the spatial gradients ∇N_a, 1/m.
    pub fn gradients(&self) -> &[Vector<D>] {
        &self.gradients[..=D]
    }

    /// Returns the spatial hoop gradient 1/(3r̄) of a ring, 1/m.
    pub fn hoop(&self) -> f64 {
        self.element.hoop / self.strain.out
    }

    /// Returns an upper bound of the second derivative of ½(tr b̄ − 3) by the nodal positions, 1/m².
    ///
    /// Derivation: [`crate::fem::law::kinematics::GradientSums::shear_bound`].
    pub fn shear_bound(&self, elastic: &ElasticCauchyGreen<D>) -> f64 {
        let (deviator, trace, hoop) = (elastic.deviator(), elastic.trace(), self.hoop());
        let (mut sheared, mut spread) = (0.0, 0.0);
        for gradient in self.gradients() {
            sheared += gradient.dot(&(elastic.tensor * gradient)) + hoop * hoop * elastic.out;
            let (in_plane, out) = ((deviator.tensor * gradient).norm_squared(), hoop * deviator.out);
            sheared += 2.0 / trace * (in_plane + out * out);
            spread += gradient.norm_squared() + hoop * hoop;
        }
        sheared + trace / 3.0 * spread
    }
}

impl<const D: usize> ElasticCauchyGreen<D> {
    /// Returns tr b̄.
    pub fn trace(&self) -> f64 {
        self.tensor.trace() + if D == 2 { self.out } else { 0.0 }
    }

    /// Returns the deviator b̄ − tr b̄/3.
    pub fn deviator(&self) -> Self {
        let mean = self.trace() / 3.0;
        Self { tensor: self.tensor - Tensor::<D>::identity() * mean, out: if D == 2 { self.out - mean } else { 0.0 } }
    }

    /// Returns the squared Frobenius norm.
    pub fn norm_squared(&self) -> f64 {
        self.tensor.norm_squared() + if D == 2 { self.out * self.out } else { 0.0 }
    }

    /// Returns θ + s d of unit determinant for the deviator d = `self` and s = `part`; `above` is an upper bound of θ.
    pub fn with_unit_determinant(&self, part: f64, above: f64) -> Self {
        let determinant = det(&self.tensor) * if D == 2 { self.out } else { 1.0 };
        let mean = isochoric_mean(above, 0.5 * part * part * self.norm_squared(), part * part * part * determinant);
        let whole = Tensor::<D>::identity() * mean + self.tensor * part;
        Self { tensor: whole, out: if D == 2 { mean + self.out * part } else { 1.0 } }
    }
}
