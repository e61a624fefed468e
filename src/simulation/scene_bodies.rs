//! Rigid bodies of a scene, and their states at time 0.

use crate::contact::{BodyMotion, BodyState, DomeMotion, ExpansionMotion, FreeDirections, RigidBody, ShapeMotion};
use crate::geometry::{ShapeGeometry, SignedDistance};
use crate::math::{Tensor3, Vector3};
use crate::scene::{Dimension, ProjectileSpec, Scene};
use nalgebra::{Quaternion, UnitQuaternion};

/// Rigid body of a scene that moves freely, unless the scene holds it, and its state at time 0.
///
/// # Panics
/// If the body does not exist, or its lengths make no solid; [`read()`](crate::scene::read()) refuses such lengths.
#[must_use]
pub fn free_body(scene: &Scene, body: usize) -> (RigidBody, BodyState) {
    build_body(scene, body, false)
}

/// Constants of a body of the scene, and its state at time 0.
pub(super) fn build_body(scene: &Scene, i: usize, prescribed: bool) -> (RigidBody, BodyState) {
    let (projectile, shape) = (scene.body(i), scene.shape(i));
    let freedom = match scene.freedom() {
        Dimension::Planar => FreeDirections::PLANAR,
        Dimension::Axisymmetric => FreeDirections::AXISYMMETRIC,
        Dimension::Spatial => FreeDirections::SPATIAL,
    };
    let body = if projectile.fixed {
        RigidBody::fixed(shape, freedom)
    } else {
        let motion = if prescribed { BodyMotion::Prescribed } else { BodyMotion::Free };
        let inertia = inertia(projectile, &shape, scene.scene.dimension);
        RigidBody::new(shape, motion, freedom, projectile.mass.unwrap_or(1.0), inertia)
    };
    let body = body.with_expansion(scene.expansion_law(i));
    let mut state = BodyState {
        orientation: orientation(freedom.turns(projectile.orientation)),
        shape_motion: match &body.shape {
            ShapeGeometry::Dome(dome) => Some(ShapeMotion::Bulge(DomeMotion::at_rest(dome))),
            ShapeGeometry::Expanding(shape) => {
                let at_start = ExpansionMotion::at_rest(shape.opening_at_start(), shape.greatest_travel());
                Some(ShapeMotion::Expansion(at_start))
            }
            _ => None,
        },
        active: projectile.active,
        ..BodyState::at_start(projectile.position.into(), projectile.velocity.into())
    };
    if !projectile.fixed {
        state.angular_momentum = body.angular_momentum(&state, &Vector3::from(projectile.angular_velocity));
    }
    (body, state)
}

/// Unit quaternion of the components (w, x, y, z).
pub(super) fn orientation([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    let q = Quaternion::new(w, x, y, z);
    UnitQuaternion::new_unchecked(q / q.norm())
}

/// Inertia of the scene, or that of a homogeneous body, kg·m²; in the plane that of a prism about y.
fn inertia(projectile: &ProjectileSpec, shape: &ShapeGeometry, dimension: Dimension) -> Tensor3 {
    if let Some([xx, yy, zz, xy, xz, yz]) = projectile.inertia {
        return Tensor3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    }
    let specific = match dimension {
        Dimension::Planar => shape.specific_inertia_of_section().map(|i| Tensor3::identity() * i),
        Dimension::Axisymmetric | Dimension::Spatial => shape.specific_inertia(),
    };
    specific.expect("a half-space that moves has its inertia in the scene") * projectile.mass.unwrap_or(1.0)
}
