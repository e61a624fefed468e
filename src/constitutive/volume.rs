use crate::math::Number;

/// Volumetric energy density and its derivatives by J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Volumetric<T = f64> {
    /// U, J/m³.
    pub energy: T,
    /// U′, Pa.
    pub slope: T,
    /// U″, Pa.
    pub curvature: T,
}

/// What a change of volume stores, of one element or of eight side by side.
pub trait Volume {
    /// U of an element that is a patch by itself.
    #[must_use]
    fn volumetric<T: Number>(&self, j: T) -> Volumetric<T>;
    /// The part of U that stays with each element of a patch that shares its volume change.
    #[must_use]
    fn own<T: Number>(&self, j: T) -> Volumetric<T>;
    /// The part of U that acts on the volume change J̄ of a patch.
    #[must_use]
    fn shared<T: Number>(&self, mean: T) -> Volumetric<T>;
}
