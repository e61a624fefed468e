//! The projectile and the fragments beside it: 0 is the projectile, from 1 on the fragments.

use super::{Projectile, Scene};

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
