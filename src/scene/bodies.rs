//! The projectile and the fragments beside it: 0 is the projectile, from 1 on the fragments.

use super::{Dimension, Projectile, Scene};
use crate::geometry::SignedDistance;

/// Most fragments of a scene: each has its own block of value references.
pub const MOST_FRAGMENTS: usize = 99;

impl Scene {
    /// Number of bodies, the projectile included.
    #[must_use]
    pub fn n_bodies(&self) -> usize {
        1 + self.fragment.len()
    }

    /// The scene with one of its bodies alone, as its projectile.
    ///
    /// # Panics
    /// If there is no such body.
    #[must_use]
    pub fn alone(&self, body: usize) -> Self {
        let projectile = if body == 0 { self.projectile.clone() } else { self.fragment[body - 1].clone() };
        Self { projectile, fragment: Vec::new(), ..self.clone() }
    }

    /// Volume of the projectile, m³, in `planar` of the thickness of the gel; `None` if it is unbounded.
    #[must_use]
    pub fn projectile_volume(&self) -> Option<f64> {
        let shape = self.projectile_shape();
        match self.scene.dimension {
            Dimension::Planar => shape.area_of_section().map(|area| area * self.thickness()),
            Dimension::Axisymmetric | Dimension::Spatial => shape.volume(),
        }
    }

    /// The scene with the masses of its bodies where only their densities were given.
    pub(super) fn with_masses(mut self) -> Self {
        let mass = |scene: &Self| Some(scene.projectile.density? * scene.projectile_volume()?);
        let masses: Vec<Option<f64>> = (0..self.n_bodies()).map(|body| mass(&self.alone(body))).collect();
        for (body, mass) in std::iter::once(&mut self.projectile).chain(&mut self.fragment).zip(masses) {
            body.mass = body.mass.or(mass);
        }
        self
    }

    /// The bodies in order.
    pub fn bodies(&self) -> impl Iterator<Item = &Projectile> {
        std::iter::once(&self.projectile).chain(&self.fragment)
    }
}

/// `projectile` or `fragment[i]`, as keys and variables begin.
#[must_use]
pub fn body_name(body: usize) -> String {
    if body == 0 { "projectile".to_owned() } else { format!("fragment[{body}]") }
}
