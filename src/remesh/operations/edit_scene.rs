//! Surroundings of the gel, as operations see them.

use crate::math::Vector;

/// Surroundings of the gel.
pub struct EditScene<'a, const D: usize> {
    /// Distance from the nearest body, negative inside, m.
    pub gap: &'a dyn Fn(&Vector<D>) -> f64,
    /// Point outside all bodies that is nearest to a point.
    pub cleared: &'a dyn Fn(&Vector<D>) -> Vector<D>,
    /// Target edge length at a point, m.
    pub size: &'a dyn Fn(&Vector<D>) -> f64,
    /// Greatest change of the target edge length over a way, relative to the way (its Lipschitz constant).
    pub growth: f64,
}
