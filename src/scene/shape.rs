//! Solids of the bodies of a scene.

use super::{BodyShape, BulletNose, BulletSpec, Dimension, Scene};
use crate::geometry::{
    Dome, ExpandingProfile, HalfSpace, ProfileBody, ProfileOutline, ProfileSweep, RoundedCuboid, ShapeGeometry, Sphere,
};
use crate::math::Vector3;
use std::sync::Arc;

/// Reason why the outline of a mushroom can be rounded.
const MUSHROOM_HAS_ROOM: &str = "the roundings of the mushroom have room";

impl Scene {
    /// Solid of a body. Its origin is the centre of mass of the homogeneous body, in `planar` that of the section.
    ///
    /// # Panics
    /// If the body does not exist, or its lengths make no solid; [`read()`](super::read()) refuses such lengths.
    #[must_use]
    pub fn shape(&self, body: usize) -> ShapeGeometry {
        let sweep = match self.scene.dimension {
            Dimension::Planar => ProfileSweep::Prism,
            Dimension::Axisymmetric | Dimension::Spatial => ProfileSweep::Revolution,
        };
        let profile = |outline: &ProfileOutline| ShapeGeometry::Profile(Arc::new(ProfileBody::new(outline, sweep)));
        match &self.body(body).shape {
            &BodyShape::Sphere { radius } => ShapeGeometry::Sphere(Sphere { radius }),
            &BodyShape::Cylinder { radius, length, edge_radius } => {
                profile(&cylinder(radius, length).rounded(edge_radius).expect("the rims have room"))
            }
            &BodyShape::Capsule { radius, length } => profile(&capsule(radius, length)),
            BodyShape::Bullet(bullet) => {
                let unopened = bullet.rounded().expect("the roundings of the rims have room");
                match &self.body(body).expansion {
                    Some(expansion) => {
                        let opened = expansion.opened.outline().expect(MUSHROOM_HAS_ROOM);
                        let [unopened, opened] = [unopened, opened].map(|outline| ProfileBody::new(&outline, sweep));
                        let body = ExpandingProfile::new(unopened, opened, expansion.opening);
                        ShapeGeometry::Expanding(Arc::new(body))
                    }
                    None => profile(&unopened),
                }
            }
            BodyShape::Mushroom(mushroom) => profile(&mushroom.outline().expect(MUSHROOM_HAS_ROOM)),
            &BodyShape::Plate { size, edge_radius } => ShapeGeometry::Plate(plate(size, edge_radius, sweep)),
            BodyShape::Chisel(chisel) => {
                ShapeGeometry::Solid(chisel.solid.clone().expect("the solid of a scene that was read is built"))
            }
            BodyShape::Stl(stl) => {
                ShapeGeometry::Solid(stl.solid().expect("the file of a scene that was read is read"))
            }
            BodyShape::HalfSpace { normal } => ShapeGeometry::HalfSpace(HalfSpace::new(Vector3::from(*normal))),
            &BodyShape::Dome { height, radius } => ShapeGeometry::Dome(Dome::new(height, radius)),
        }
    }
}

/// Plate of a scene. In the plane the prism is made long across it, so that the nearest surface point lies in the
/// plane.
fn plate([x, y, z]: [f64; 3], edge_radius: f64, sweep: ProfileSweep) -> RoundedCuboid {
    let across = match sweep {
        ProfileSweep::Prism => 2.0 * x.max(z),
        ProfileSweep::Revolution => y,
    };
    RoundedCuboid::new([x, across, z], edge_radius)
}

fn cylinder(radius: f64, length: f64) -> ProfileOutline {
    ProfileOutline::at_tip().line(radius, 0.0).line(radius, length).line(0.0, length)
}

fn capsule(radius: f64, length: f64) -> ProfileOutline {
    ProfileOutline::at_tip().arc(radius, radius, radius).line(radius, length - radius).arc(0.0, length, radius)
}

impl BulletSpec {
    /// Length of the nose along the axis, m.
    pub(super) fn nose_length(&self) -> f64 {
        match self.nose {
            BulletNose::Ogive { length, .. } | BulletNose::Cone { length, .. } => length,
            BulletNose::Round => self.radius,
            BulletNose::Flat => 0.0,
        }
    }

    /// Length of the cylindrical body between nose and tail, m; negative if they overlap by more than round-off.
    pub(super) fn mantle_length(&self) -> f64 {
        const ROUND_OFF: f64 = 1e-9;
        let rest = self.length - self.nose_length() - self.tail.map_or(0.0, |tail| tail.length);
        if rest.abs() <= ROUND_OFF * self.length { 0.0 } else { rest }
    }

    /// Arc radius (L² + d²)/2d of the tangent ogive, m: through the rims of meplat and cylinder, tangent to the
    /// cylinder.
    pub(super) fn tangent_radius(&self, length: f64, meplat_radius: f64) -> f64 {
        let step = self.radius - meplat_radius;
        (length * length + step * step) / (2.0 * step)
    }

    /// Outline with rounded rims; `None` if there is no room for the rounding.
    pub(super) fn rounded(&self) -> Option<ProfileOutline> {
        self.outline().rounded(self.edge_radius)
    }

    fn outline(&self) -> ProfileOutline {
        let (radius, shoulder) = (self.radius, self.nose_length());
        let nose = match self.nose {
            BulletNose::Ogive { length, arc_radius, meplat_radius } => {
                let arc = arc_radius.unwrap_or_else(|| self.tangent_radius(length, meplat_radius));
                ProfileOutline::at_tip().line(meplat_radius, 0.0).arc(radius, shoulder, arc)
            }
            BulletNose::Cone { meplat_radius, .. } => {
                ProfileOutline::at_tip().line(meplat_radius, 0.0).line(radius, shoulder)
            }
            BulletNose::Round => ProfileOutline::at_tip().arc(radius, shoulder, radius),
            BulletNose::Flat => ProfileOutline::at_tip().line(radius, 0.0),
        };
        let base = self.tail.map_or(radius, |tail| tail.radius);
        nose.line(radius, shoulder + self.mantle_length()).line(base, self.length).line(0.0, self.length)
    }
}
