//! Expanding bodies of a scene: the law of their opening, and the shapes with which they fly through the gel.

use super::Scene;
use super::block_fit::approach;
use crate::contact::ExpansionLaw;
use crate::geometry::ShapeGeometry;
use crate::math::Vector3;
use std::sync::Arc;

impl Scene {
    /// Law by which a body expands; `None` for one that does not, or whose importer prescribes its opening.
    #[must_use]
    pub fn expansion_law(&self, body: usize) -> Option<ExpansionLaw> {
        let (projectile, density) = (self.body(body), self.gel.density);
        let expansion = projectile.expansion?;
        let [opening_pressure, full_pressure] = expansion.thresholds(density)?;
        Some(ExpansionLaw { opening_pressure, full_pressure, path: expansion.path?, density })
    }

    /// Shape with which a body flies through the gel: the opened form of a bullet that is open at least by half, or opens so
    /// far at its speed, or the shape at the start.
    pub(super) fn shape_in_gel(&self, body: usize) -> ShapeGeometry {
        let shape = self.shape(body);
        let ShapeGeometry::Expanding(expanding) = &shape else { return shape };
        let velocity = approach(self, self.body(body));
        let opens = self.expansion_law(body).is_some_and(|law| law.target(&velocity) >= 0.5);
        let is_open = expanding.opening_at_start() >= 0.5;
        if opens || is_open { ShapeGeometry::Profile(Arc::new(expanding.forms()[1].clone())) } else { shape }
    }

    /// Diameter across the axis of an expanding body at an opening, m; `None` for a body that does not expand.
    #[must_use]
    pub fn diameter_at(&self, body: usize, opening: f64) -> Option<f64> {
        let ShapeGeometry::Expanding(expanding) = self.shape(body) else { return None };
        Some(2.0 * expanding.reach_at(opening, &Vector3::x()))
    }
}
