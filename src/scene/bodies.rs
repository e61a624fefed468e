//! The projectile and the fragments beside it: 0 is the projectile, from 1 on the fragments.

use super::{Dimension, Projectile, Scene, Symmetry};
use crate::geometry::SignedDistance;

/// Most fragments of a scene: each has its own block of value references.
pub const MOST_FRAGMENTS: usize = 99;

impl Scene {
    /// The dimension in which its bodies are free to move: of a part of a spatial gel that of its symmetry.
    #[must_use]
    pub fn freedom(&self) -> Dimension {
        match self.gel.symmetry {
            Symmetry::None => self.scene.dimension,
            Symmetry::Half => Dimension::Planar,
            Symmetry::Quarter => Dimension::Axisymmetric,
        }
    }

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
        Self { projectile: self.body(body).clone(), fragment: Vec::new(), ..self.clone() }
    }

    /// Volume of a body, m³, in `planar` of the thickness of the gel; `None` if it is unbounded.
    ///
    /// # Panics
    /// As [`Scene::shape`].
    #[must_use]
    pub fn volume(&self, body: usize) -> Option<f64> {
        let shape = self.shape(body);
        match self.scene.dimension {
            Dimension::Planar => shape.area_of_section().map(|area| area * self.thickness()),
            Dimension::Axisymmetric | Dimension::Spatial => shape.volume(),
        }
    }

    /// The scene with the masses of its bodies where only their densities were given.
    pub(super) fn with_masses(mut self) -> Self {
        let mass = |body| Some(self.body(body).density? * self.volume(body)?);
        let masses: Vec<Option<f64>> = (0..self.n_bodies()).map(mass).collect();
        for (body, mass) in self.bodies_mut().zip(masses) {
            body.mass = body.mass.or(mass);
        }
        self
    }

    /// A body.
    ///
    /// # Panics
    /// If there is no such body.
    #[must_use]
    pub fn body(&self, body: usize) -> &Projectile {
        if body == 0 { &self.projectile } else { &self.fragment[body - 1] }
    }

    /// The bodies in order.
    pub fn bodies(&self) -> impl Iterator<Item = &Projectile> {
        std::iter::once(&self.projectile).chain(&self.fragment)
    }

    /// The bodies in order.
    pub(super) fn bodies_mut(&mut self) -> impl Iterator<Item = &mut Projectile> {
        std::iter::once(&mut self.projectile).chain(&mut self.fragment)
    }
}

/// `projectile` or `fragment[i]`, as keys and variables begin.
#[must_use]
pub fn body_name(body: usize) -> String {
    if body == 0 { "projectile".to_owned() } else { format!("fragment[{body}]") }
}
