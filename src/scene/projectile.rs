//! Tables of a rigid body. The field docs are the descriptions that an editor shows; units are SI.

use super::{ExpansionSpec, MushroomSpec};
use crate::geometry::{ChiselCylinder, TriangulatedBody};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Rigid body that hits the gel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct ProjectileSpec {
    /// Shape, in the frame of the body; that of the `library` projectile if absent.
    pub shape: BodyShape,
    /// Mass, kg; in `planar` that of the gel's thickness. That of the `library` projectile, or computed from `density`,
    /// if absent; not needed when `fixed`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Mass density, kg/m3; gives the mass where `mass` is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Inertia about the centre of mass in the frame of the body, kg m2: xx, yy, zz, xy, xz, yz. That of a
    /// homogeneous body of the given mass if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<[f64; 6]>,
    /// Expansion of a bullet; a rigid body if absent. That of the `library` projectile, if it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expansion: Option<ExpansionSpec>,
    /// Position of the centre of mass at the start, m. The reference point of a half-space is in its plane, that of a
    /// dome is the centre of its base.
    pub position: [f64; 3],
    /// Velocity at the start, m/s.
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Orientation at the start: Hamilton quaternion w, x, y, z from the frame of the body to the world.
    #[serde(default = "upright")]
    pub orientation: [f64; 4],
    /// Angular velocity at the start, world frame, rad/s.
    #[serde(default)]
    pub angular_velocity: [f64; 3],
    /// Name of the projectile of the library that gives shape and mass where the table has none. Values beside the name
    /// must be those of the library. `gelfmu check` and the report give the sources, and what the real projectile does
    /// and a rigid one does not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub library: Option<String>,
    /// Version of the library that the body is from, as `gelfmu new` writes it; the present one if absent. Values of an
    /// earlier version are kept, and `gelfmu check` reports those that have changed since.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub library_version: Option<u32>,
    /// True for a body that is held in place.
    #[serde(default)]
    pub fixed: bool,
    /// True for a body that takes part from the start. An inactive body stays in place without contact until the
    /// importer activates it.
    #[serde(default = "yes")]
    pub active: bool,
}

fn yes() -> bool {
    true
}

fn upright() -> [f64; 4] {
    [1.0, 0.0, 0.0, 0.0]
}

/// Shape of a rigid body, in its own frame with the centre of mass at the origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum BodyShape {
    /// Sphere (`planar`: a disc).
    Sphere {
        /// Radius, m.
        radius: f64,
    },
    /// Right circular cylinder about the z axis of the body: a rod, a plate, a fragment simulator.
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Length, m.
        length: f64,
        /// Radius of the rounding of both rims, m; 0 is sharp. Below half a cell of the mesh, nodes that slip over
        /// the rim see a jump of the normal.
        #[serde(default)]
        edge_radius: f64,
    },
    /// Cylinder with a hemisphere on each end, about the z axis of the body.
    Capsule {
        /// Radius, m.
        radius: f64,
        /// Overall length, both ends included, m; at least twice the radius.
        length: f64,
    },
    /// Bullet about the z axis of the body, its nose towards -z: without rotation it flies into the gel nose first.
    Bullet(BulletSpec),
    /// Mushroom about the z axis of the body, its front towards -z: an expanded bullet as it is recovered.
    Mushroom(MushroomSpec),
    /// Cuboid along the axes of the body; not in `axisymmetric`.
    Plate {
        /// Edge lengths, m: [x, y, z]; in `planar` y is ignored.
        size: [f64; 3],
        /// Radius of the rounding of all edges and corners, m; 0 is sharp. Below half a cell of the mesh, nodes that
        /// slip over an edge see a jump of the normal.
        #[serde(default)]
        edge_radius: f64,
    },
    /// Chisel-nosed cylinder about the z axis of the body, as of a fragment simulating projectile, its nose towards
    /// -z and the edges of its front face along y; in `spatial` only.
    Chisel(ChiselSpec),
    /// Closed triangulated surface from an STL file; in `spatial` only.
    Stl(StlSpec),
    /// Half-space on the far side of a plane through the body's origin.
    HalfSpace {
        /// Normal of the plane, out of the body; normalised.
        normal: [f64; 3],
    },
    /// Back face of an armour: the half-space above z = 0 of the body, and a spherical cap below it, the bulge.
    /// Height and base radius are inputs that change in time; the scene gives those of the start.
    Dome {
        /// Height of the cap, m: from 0, a flat plate, to the base radius, a hemisphere.
        height: f64,
        /// Base radius of the cap, m.
        radius: f64,
    },
}

/// Chisel-nosed cylinder: a flat front face across the diameter, and a flat that slopes back at each side of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct ChiselSpec {
    /// Radius, m.
    pub radius: f64,
    /// Overall length, m.
    pub length: f64,
    /// Width of the front face, m.
    pub face_width: f64,
    /// Angle between each sloping flat and the plane of the front face, degrees.
    pub face_angle: f64,
    /// Solid body, once the scene is read.
    #[serde(skip)]
    pub solid: Option<Arc<TriangulatedBody>>,
}

impl ChiselSpec {
    /// Builds the solid body; without one the lengths make none.
    pub(super) fn build(&mut self) {
        self.solid = self.outline().solid().ok().map(Arc::new);
    }

    /// Outline of the body.
    #[must_use]
    pub fn outline(&self) -> ChiselCylinder {
        let &Self { radius, length, face_width, face_angle, .. } = self;
        let (sin, cos) = libm::sincos(face_angle.to_radians());
        ChiselCylinder { radius, length, face_width, slope: sin / cos }
    }
}

/// Rigid body from an STL file: oriented as in the file, its origin moved to the centre of mass of the homogeneous
/// body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct StlSpec {
    /// Path of the file, binary or ASCII, relative to the folder of the scene.
    pub file: String,
    /// Metres per unit of the file; 1e-3 for a file in millimetres.
    #[serde(default = "metres")]
    pub scale: f64,
    /// Content of the file, once read.
    #[serde(skip)]
    pub content: Option<StlContent>,
}

fn metres() -> f64 {
    1.0
}

/// Content of an STL file.
#[derive(Debug, Clone, PartialEq)]
pub struct StlContent {
    /// Hash of the bytes of the file.
    pub digest: u128,
    /// Solid body, in metres.
    pub solid: Arc<TriangulatedBody>,
}

impl StlSpec {
    /// Solid body; `None` before the file is read.
    #[must_use]
    pub fn solid(&self) -> Option<Arc<TriangulatedBody>> {
        self.content.as_ref().map(|content| content.solid.clone())
    }
}

/// Bullet: nose, cylindrical body and optional boat-tail. The centre of mass of the homogeneous bullet is the origin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct BulletSpec {
    /// Radius of the cylindrical body, half of the calibre, m.
    pub radius: f64,
    /// Overall length, m; the cylindrical body takes the length that nose and tail leave.
    pub length: f64,
    /// Nose.
    pub nose: BulletNose,
    /// Boat-tail; a flat base if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tail: Option<BulletTail>,
    /// Radius of the rounding of every rim (not of a point on the axis), m; 0 is sharp. Below half a cell of the
    /// mesh, nodes that slip over a rim see a jump of the normal.
    #[serde(default)]
    pub edge_radius: f64,
}

/// Nose of a bullet.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum BulletNose {
    /// Ogive: an arc turned about the axis.
    Ogive {
        /// Length along the axis, m; at least the radius of the bullet less the meplat radius.
        length: f64,
        /// Radius of the arc, m: greater than that of the tangent ogive for a secant ogive; tangent ogive if absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        arc_radius: Option<f64>,
        /// Radius of the flat tip (meplat), m; 0 is a point.
        #[serde(default)]
        meplat_radius: f64,
    },
    /// Cone.
    Cone {
        /// Length along the axis, m.
        length: f64,
        /// Radius of the flat tip (meplat), m; 0 is a point.
        #[serde(default)]
        meplat_radius: f64,
    },
    /// Hemisphere.
    Round,
    /// Flat front face without a nose, as of a wadcutter.
    Flat,
}

/// Boat-tail of a bullet: a truncated cone.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct BulletTail {
    /// Length along the axis, m.
    pub length: f64,
    /// Radius of the base, m; at most that of the bullet.
    pub radius: f64,
}
