//! Kinematics of one triangle or tetrahedron: rest geometry and deformation gradient.

use crate::fem::law::rest_geometry::RestGeometry;
use crate::fem::{MAX_NODES, ReferenceShape, Section};
use crate::math::{Tensor, Vector, array};

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

/// Deformation gradient F of an element, with the out-of-plane stretch λ and det F.
#[derive(Clone, Copy)]
pub(crate) struct DeformationGradient<const D: usize> {
    pub f: Tensor<D>,
    /// Out-of-plane stretch λ.
    pub out: f64,
    /// det F in the plane or in space, without λ.
    pub det_f: f64,
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
}

impl<const D: usize> DeformationGradient<D> {
    /// Returns F of an element at rest.
    pub fn identity() -> Self {
        Self { f: Tensor::<D>::identity(), out: 1.0, det_f: 1.0 }
    }

    /// Returns J = λ det F.
    pub fn jacobian(&self) -> f64 {
        self.det_f * self.out
    }
}
