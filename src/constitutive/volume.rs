use crate::math::Number;

/// Volumetric energy density U and its derivatives by J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumetricResponse<T = f64> {
    /// U, J/m³.
    pub energy: T,
    /// U′, Pa.
    pub slope: T,
    /// U″, Pa.
    pub curvature: T,
}

/// Volumetric energy of a material, for one element or for eight in vector lanes.
pub trait VolumetricEnergy {
    /// Evaluates U of an element without a patch.
    #[must_use]
    fn volumetric<T: Number>(&self, j: T) -> VolumetricResponse<T>;
    /// Evaluates the element part of U, at the J of the element, in an F-bar patch.
    #[must_use]
    fn own<T: Number>(&self, j: T) -> VolumetricResponse<T>;
    /// Evaluates the patch part of U, at the volume ratio J̄ of an F-bar patch.
    #[must_use]
    fn shared<T: Number>(&self, mean: T) -> VolumetricResponse<T>;
}
