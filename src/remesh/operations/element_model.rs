//! Law of the elements, as remeshing sees it.

use crate::math::Vector;

/// State of an element by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementState {
    /// Rest volume, m³.
    pub volume: f64,
    /// J = det F.
    pub jacobian: f64,
    /// Stored energy, J; without the volumetric part that is common to a patch.
    pub energy: f64,
    /// Greatest frequency of the element by itself, 1/s: the square root of (D + 1) κ/(ρw).
    pub frequency: f64,
}

/// Law of the elements.
pub trait ElementModel<const D: usize> {
    /// State of an element by the rest positions and the positions of its corners, m.
    fn state(&self, rest: &[Vector<D>; 4], now: &[Vector<D>; 4]) -> ElementState;
    /// Volumetric energy density that is common to the elements of a patch, by their mean J, J/m³.
    fn common_energy(&self, jacobian: f64) -> f64;
}
