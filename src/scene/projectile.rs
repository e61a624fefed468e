//! The tables of a body. Field docs are the help an editor shows; units are SI.

use super::StlContent;
use serde::{Deserialize, Serialize};

/// The rigid body that meets the gel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Projectile {
    /// Shape, in the frame of the body.
    pub shape: BodyShape,
    /// Mass, kg; in `planar` for the gel's thickness. From `density` if absent; not needed when `fixed`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Mass density, kg/m3, of which the mass is computed where none is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Inertia about the centre of mass in the frame of the body, kg m2: xx, yy, zz, xy, xz, yz.
    /// Computed for a homogeneous body of the given mass if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<[f64; 6]>,
    /// Centre of mass (a point of the plane of a half-space, the middle of the base of a dome) at the start, m.
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
    /// Held where it is.
    #[serde(default)]
    pub fixed: bool,
    /// Whether it takes part from the start. One that does not stays where it is and touches nothing, until the importer
    /// makes it active.
    #[serde(default = "yes")]
    pub active: bool,
}

fn yes() -> bool {
    true
}

fn upright() -> [f64; 4] {
    [1.0, 0.0, 0.0, 0.0]
}

/// Shape of the rigid body, in its own frame with the centre of mass at the origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum BodyShape {
    /// A sphere (`planar`: a disc).
    Sphere {
        /// Radius, m.
        radius: f64,
    },
    /// A right circular cylinder about the z axis of the body: a rod, a plate, a fragment simulator.
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Length, m.
        length: f64,
        /// Radius of the rounding of both rims, m; 0 is sharp. Below half a cell of the mesh, nodes that slip over the rim
        /// see the normal jump.
        #[serde(default)]
        edge_radius: f64,
    },
    /// A cylinder with half a sphere on each end, about the z axis of the body.
    Capsule {
        /// Radius, m.
        radius: f64,
        /// Overall length, both ends included, m; at least twice the radius.
        length: f64,
    },
    /// A bullet about the z axis of the body, its nose towards -z: one that is not turned flies into the gel nose first.
    Bullet(Bullet),
    /// A cuboid along the axes of the body; not in `axisymmetric`.
    Plate {
        /// Edge lengths, m: [x, y, z]; in `planar` y does not count.
        size: [f64; 3],
        /// Radius of the rounding of all edges and corners, m; 0 is sharp. Below half a cell of the mesh, nodes that slip
        /// over an edge see the normal jump.
        #[serde(default)]
        edge_radius: f64,
    },
    /// Any closed surface of triangles, from an STL file; in `spatial` only.
    Stl(Stl),
    /// All space on the far side of a plane through the body's origin.
    HalfSpace {
        /// Normal of the plane, out of the body; normalised.
        normal: [f64; 3],
    },
    /// The back face of an armour: all space above z = 0 of the body, and a spherical cap below it, the bulge. Height and base
    /// radius are inputs that change in time; here they are those of the start.
    Dome {
        /// Height of the cap, m: from 0, a flat plate, to the base radius, half a sphere.
        height: f64,
        /// Radius of the base of the cap, m.
        radius: f64,
    },
}

/// A body from an STL file, oriented as in the file, its origin moved to the centre of mass of the homogeneous body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Stl {
    /// Path of the file, binary or ASCII, relative to the folder of the scene.
    pub file: String,
    /// Metres per unit of the file; 1e-3 for a file in millimetres.
    #[serde(default = "metres")]
    pub scale: f64,
    /// What is in the file.
    #[serde(skip)]
    pub content: Option<StlContent>,
}

fn metres() -> f64 {
    1.0
}

/// A bullet: nose, cylindrical mantle, and a boat-tail if it has one. Homogeneous, it has its centre of mass in the origin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Bullet {
    /// Radius of the mantle, half of the calibre, m.
    pub radius: f64,
    /// Overall length, m; what nose and tail leave of it is the mantle.
    pub length: f64,
    /// The nose.
    pub nose: Nose,
    /// The boat-tail; a flat base on the mantle if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tail: Option<Tail>,
    /// Radius of the rounding of every rim (not of a point on the axis), m; 0 is sharp. Below half a cell of the mesh, nodes
    /// that slip over a rim see the normal jump.
    #[serde(default)]
    pub edge_radius: f64,
}

/// Nose of a bullet.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum Nose {
    /// An arc, turned about the axis.
    Ogive {
        /// Length along the axis, m; at least mantle radius less meplat radius.
        length: f64,
        /// Radius of the arc, m: greater than that of the tangent ogive for a secant one; tangent to the mantle if absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        arc_radius: Option<f64>,
        /// Radius of the flat tip, m; 0 is a point.
        #[serde(default)]
        meplat_radius: f64,
    },
    /// A cone.
    Cone {
        /// Length along the axis, m.
        length: f64,
        /// Radius of the flat tip, m; 0 is a point.
        #[serde(default)]
        meplat_radius: f64,
    },
    /// Half a sphere.
    Round,
    /// None: the mantle is cut off, as of a wadcutter.
    Flat,
}

/// Boat-tail of a bullet: a cut cone.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Tail {
    /// Length along the axis, m.
    pub length: f64,
    /// Radius of the base, m; at most that of the mantle.
    pub radius: f64,
}
