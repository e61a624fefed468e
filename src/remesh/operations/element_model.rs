//! Law of the elements, as remeshing sees it.

use crate::math::Vector;

/// State of an element by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementState {
    /// Volume by which the element is judged, m³: at rest, or the present one of a gel that flows.
    pub volume: f64,
    /// J = det F; 1 of a gel that flows.
    pub jacobian: f64,
    /// Density relative to that of the gel; 1 of a gel that flows.
    pub density: f64,
    /// Strength relative to that of the gel; 1 of a gel that flows.
    pub strength: f64,
    /// Stored energy, J, without the volumetric part that is common to a patch; 0 of a gel that flows.
    pub energy: f64,
    /// Hindrance, above 1 of an element that is remade: by the model, its frequency √((D + 1) κ/(ρw)) and its compression
    /// 1/J, or its height and quality, over their limits; infinite where it is inverted.
    pub hindrance: f64,
}

/// Law of the elements.
pub trait ElementModel<const D: usize> {
    /// State of an element by the rest positions and the positions of its corners, m.
    fn state(&self, rest: &[Vector<D>; 4], now: &[Vector<D>; 4]) -> ElementState;
    /// Volumetric energy density of the gel that is common to the elements of a patch, by their mean J, J/m³.
    fn common_energy(&self, jacobian: f64) -> f64;
    /// Greatest relative change of a volume, m³, of gel beneath the surface by an operation that smooths it; 0 where the surface
    /// has a shape at rest.
    fn smoothing(&self, volume: f64) -> f64;
}
