//! Rigid bodies of a scene: index 0 is the projectile, the fragments follow from 1.

use super::{Dimension, GelSymmetry, MaterialModel, ProjectileSpec, Scene, SelfContactMode};
use crate::geometry::SignedDistance;

/// Greatest number of fragments of a scene: each has its own block of value references.
pub const MOST_FRAGMENTS: usize = 99;

impl Scene {
    /// Returns true if the surface of the gel is stopped where it meets itself.
    #[must_use]
    pub fn meets_itself(&self) -> bool {
        match self.gel.self_contact {
            SelfContactMode::Auto => self.gel.material == MaterialModel::TwoNetwork || self.remesh.is_some(),
            SelfContactMode::Off => false,
            SelfContactMode::On => true,
        }
    }

    /// Dimension of the motion of the bodies; with a symmetry of the gel that of the planes of symmetry.
    #[must_use]
    pub fn freedom(&self) -> Dimension {
        match self.gel.symmetry {
            GelSymmetry::None => self.scene.dimension,
            GelSymmetry::Half => Dimension::Planar,
            GelSymmetry::Quarter => Dimension::Axisymmetric,
        }
    }

    /// Number of bodies, the projectile included.
    #[must_use]
    pub fn n_bodies(&self) -> usize {
        1 + self.fragment.len()
    }

    /// Scene with a single body as its projectile.
    ///
    /// # Panics
    /// If the body does not exist.
    #[must_use]
    pub fn alone(&self, body: usize) -> Self {
        Self { projectile: self.body(body).clone(), fragment: Vec::new(), ..self.clone() }
    }

    /// Volume of a body, m³, in `planar` of the thickness of the gel; `None` if it is unbounded.
    ///
    /// # Panics
    /// If [`Scene::shape`] panics.
    #[must_use]
    pub fn volume(&self, body: usize) -> Option<f64> {
        let shape = self.shape(body);
        match self.scene.dimension {
            Dimension::Planar => shape.area_of_section().map(|area| area * self.thickness()),
            Dimension::Axisymmetric | Dimension::Spatial => shape.volume(),
        }
    }

    /// Computes the masses of the bodies that have only a density.
    pub(super) fn with_masses(mut self) -> Self {
        let mass = |body| Some(self.body(body).density? * self.volume(body)?);
        let masses: Vec<Option<f64>> = (0..self.n_bodies()).map(mass).collect();
        for (body, mass) in self.bodies_mut().zip(masses) {
            body.mass = body.mass.or(mass);
        }
        self
    }

    /// Body of an index.
    ///
    /// # Panics
    /// If the body does not exist.
    #[must_use]
    pub fn body(&self, body: usize) -> &ProjectileSpec {
        if body == 0 { &self.projectile } else { &self.fragment[body - 1] }
    }

    /// Bodies in order.
    pub fn bodies(&self) -> impl Iterator<Item = &ProjectileSpec> {
        std::iter::once(&self.projectile).chain(&self.fragment)
    }

    /// Mutable bodies in order.
    pub(super) fn bodies_mut(&mut self) -> impl Iterator<Item = &mut ProjectileSpec> {
        std::iter::once(&mut self.projectile).chain(&mut self.fragment)
    }
}

/// Prefix of a body's keys and variables: `projectile` or `fragment[i]`.
#[must_use]
pub fn body_name(body: usize) -> String {
    if body == 0 { "projectile".to_owned() } else { format!("fragment[{body}]") }
}
