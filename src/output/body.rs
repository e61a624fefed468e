//! Closed triangle surfaces of the rigid bodies, for VTK files and pictures.

use super::bounds::AxisAlignedBox;
use crate::geometry::{Dome, ShapeGeometry, TriangulatedBody as TriangleBody};
use crate::math::Vector3;
use crate::scene::Scene;
use crate::simulation::{BodyPose, MeshFrame, ShapeMotion};
use nalgebra::{Quaternion, UnitQuaternion};
use std::f64::consts::{PI, TAU};

/// Segments around the axis of revolution: a polygon of 48 sides deviates from its circle by 0.3 % of the radius.
const SEGMENTS: usize = 48;

/// Closed triangle surface of a body. Unless the body is read from a file, the surface is star-shaped about `centre`.
#[derive(Debug, Clone)]
pub(super) struct BodySurface {
    /// True for a body of finite extent; an unbounded body is drawn as a plate.
    pub(super) bounded: bool,
    pub(super) velocity: Vector3,
    pub(super) centre: Vector3,
    pub(super) points: Vec<Vector3>,
    /// Triangles, oriented outwards.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Returns the surfaces of the active bodies at their current position. A half-space is drawn as a plate behind its
/// plane across `scenery`, a dome as a plate around its cap.
pub(super) fn body_surfaces(scene: &Scene, frame: &MeshFrame, scenery: &AxisAlignedBox) -> Vec<BodySurface> {
    let bodies = frame.bodies.iter().enumerate().filter(|(_, place)| place.active);
    bodies.map(|(i, place)| body_surface(&scene.shape(i), place, scenery)).collect()
}

/// Returns the surface of a body at its current position; an unbounded body gives a plate.
pub(super) fn body_surface(shape: &ShapeGeometry, place: &BodyPose, scenery: &AxisAlignedBox) -> BodySurface {
    let [w, x, y, z] = place.kinematics.orientation;
    let (turn, to) = (UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)), place.kinematics.position);
    let drawn = |profile: &[(f64, f64)]| transformed(surface_of_revolution(profile), turn, to);
    let turn_of_segment = TAU / SEGMENTS as f64;
    let solid = match (shape, &place.shape_motion) {
        (_, Some(ShapeMotion::Bulge(bulge))) => drawn(&dome_profile(&bulge.dome(), scenery)),
        (ShapeGeometry::Expanding(shape), at) => {
            let motion = at.as_ref().and_then(ShapeMotion::expansion);
            let opening = motion.map_or(shape.opening_at_start(), |motion| motion.opening);
            drawn(&shape.polyline(opening, turn_of_segment))
        }
        (ShapeGeometry::Sphere(sphere), _) => drawn(&sphere_profile(sphere.radius)),
        (ShapeGeometry::Profile(profile), _) => drawn(&profile.polyline(turn_of_segment)),
        (ShapeGeometry::Plate(rounded), _) => transformed(cuboid(rounded.size()), turn, to),
        (ShapeGeometry::Solid(solid), _) => transformed(mesh_surface(solid), turn, to),
        (ShapeGeometry::HalfSpace(half_space), _) => plate(turn * half_space.normal(), to, scenery),
        (ShapeGeometry::Dome(dome), _) => drawn(&dome_profile(dome, scenery)),
    };
    let bounded = !matches!(shape, ShapeGeometry::HalfSpace(_) | ShapeGeometry::Dome(_));
    BodySurface { bounded, velocity: place.kinematics.velocity, ..solid }
}

#[cfg(feature = "cli")]
/// Returns the box of the visible part of a body in a picture of `scenery`; an unbounded body counts with its surface
/// alone.
pub(super) fn visible_box(shape: &ShapeGeometry, place: &BodyPose, scenery: &AxisAlignedBox) -> AxisAlignedBox {
    let [w, x, y, z] = place.kinematics.orientation;
    let (turn, to) = (UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)), place.kinematics.position);
    let on_plane = |n: Vector3| scenery.corners().map(move |p| p - n * (p - to).dot(&n));
    match (shape, &place.shape_motion) {
        (ShapeGeometry::HalfSpace(half_space), _) => AxisAlignedBox::around(on_plane(half_space.normal())),
        (ShapeGeometry::Dome(_), Some(ShapeMotion::Bulge(bulge))) => {
            let apex = to - turn * Vector3::z() * bulge.dome().height();
            AxisAlignedBox::around(on_plane(turn * Vector3::z()).chain([apex]))
        }
        _ => AxisAlignedBox::around(body_surface(shape, place, scenery).points),
    }
}

/// Returns the profile (r, z) of a dome's cap and of the plate behind the cap. The plate ends a little beyond the
/// cap, because a wider plate would hide the gel.
fn dome_profile(dome: &Dome, scenery: &AxisAlignedBox) -> Vec<(f64, f64)> {
    let (h, a) = (dome.height(), dome.radius());
    let (wide, thick) = (1.2 * a, 0.06 * scenery.radius());
    // Equal parts, from apex to rim, of the angle 2 atan(h/a) spanned by half of the cap.
    let n = SEGMENTS / 4;
    let half = 2.0 * (h / a).atan();
    let sphere = if h > 0.0 { (a * a + h * h) / (2.0 * h) } else { 0.0 };
    let angles = (0..n).map(|i| half * i as f64 / n as f64).filter(|_| h > 0.0);
    let curve = angles.map(|t| (sphere * t.sin(), sphere * (1.0 - t.cos()) - h));
    let mut profile: Vec<(f64, f64)> = if h > 0.0 { curve.collect() } else { vec![(0.0, 0.0)] };
    profile.extend([(a, 0.0), (wide, 0.0), (wide, thick), (0.0, thick)]);
    profile
}

/// Returns the profile (r, z) of a sphere from pole to pole.
fn sphere_profile(radius: f64) -> Vec<(f64, f64)> {
    let n = SEGMENTS / 2;
    (0..=n).map(|i| PI * i as f64 / n as f64).map(|a| (radius * a.sin(), -radius * a.cos())).collect()
}

/// Returns the profile (r, z) of a cylinder from pole to pole.
fn cylinder_profile(radius: f64, length: f64) -> Vec<(f64, f64)> {
    let z = 0.5 * length;
    vec![(0.0, -z), (radius, -z), (radius, z), (0.0, z)]
}

/// Returns a cuboid about the origin.
fn cuboid(size: Vector3) -> BodySurface {
    let side = |i: u32, axis: usize| if i >> axis & 1 == 0 { -0.5 * size[axis] } else { 0.5 * size[axis] };
    let points = (0..8).map(|i| Vector3::from_fn(|axis, _| side(i, axis))).collect();
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    closed_surface(points, faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

/// Returns a closed surface at rest about the origin.
fn closed_surface(points: Vec<Vector3>, triangles: Vec<[u32; 3]>) -> BodySurface {
    BodySurface { bounded: true, velocity: Vector3::zeros(), centre: Vector3::zeros(), points, triangles }
}

fn mesh_surface(body: &TriangleBody) -> BodySurface {
    closed_surface(body.points().to_vec(), body.triangles().to_vec())
}

/// Returns the surface of revolution of a pole-to-pole profile about the z axis.
fn surface_of_revolution(profile: &[(f64, f64)]) -> BodySurface {
    let rings = profile.len() - 2;
    let (south, north) = ((rings * SEGMENTS) as u32, (rings * SEGMENTS + 1) as u32);
    let mut points = Vec::with_capacity(rings * SEGMENTS + 2);
    for &(r, z) in &profile[1..=rings] {
        points.extend(
            (0..SEGMENTS).map(|i| TAU * i as f64 / SEGMENTS as f64).map(|a| Vector3::new(r * a.cos(), r * a.sin(), z)),
        );
    }
    points.extend([profile[0].1, profile[rings + 1].1].map(|z| Vector3::new(0.0, 0.0, z)));
    let at = |ring: usize, i: usize| (ring * SEGMENTS + i % SEGMENTS) as u32;
    let mut triangles = Vec::with_capacity(2 * rings * SEGMENTS);
    for i in 0..SEGMENTS {
        triangles.push([south, at(0, i + 1), at(0, i)]);
        triangles.push([north, at(rings - 1, i), at(rings - 1, i + 1)]);
        for ring in 1..rings {
            let (a, b, c, d) = (at(ring - 1, i), at(ring - 1, i + 1), at(ring, i + 1), at(ring, i));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    closed_surface(points, triangles)
}

fn transformed(mut solid: BodySurface, turn: UnitQuaternion<f64>, to: Vector3) -> BodySurface {
    for point in solid.points.iter_mut().chain([&mut solid.centre]) {
        *point = turn * *point + to;
    }
    solid
}

/// Returns a round plate as wide as `scenery`, with its upper face in the plane through `origin`.
fn plate(normal: Vector3, origin: Vector3, scenery: &AxisAlignedBox) -> BodySurface {
    let (radius, thickness) = (1.1 * scenery.radius(), 0.06 * scenery.radius());
    let middle = scenery.centre();
    let foot = middle - normal * (middle - origin).dot(&normal);
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &normal)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI));
    transformed(surface_of_revolution(&cylinder_profile(radius, thickness)), turn, foot - 0.5 * thickness * normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{self, Override};
    use crate::simulation::BodyKinematics;

    fn at(position: Vector3) -> BodyPose {
        let [velocity, angular_velocity] = [Vector3::zeros(); 2];
        let kinematics = BodyKinematics { position, velocity, orientation: [1.0, 0.0, 0.0, 0.0], angular_velocity };
        BodyPose { kinematics, shape_motion: None, active: true }
    }

    fn volume(solid: &BodySurface) -> f64 {
        let corner = |i: u32| solid.points[i as usize] - solid.centre;
        solid.triangles.iter().map(|t| corner(t[0]).cross(&corner(t[1])).dot(&corner(t[2])) / 6.0).sum()
    }

    fn drawn(shape: &str, position: Vector3, scenery: &AxisAlignedBox) -> BodySurface {
        let shape: Override = format!("projectile.shape={shape}").parse().unwrap();
        let inertia = "projectile.inertia=[1, 1, 1, 0, 0, 0]".parse().unwrap();
        let above = "projectile.position=[0, 0, 9]".parse().unwrap();
        let text = scene::resolve(scene::builtin("sphere-block").unwrap(), &[shape, inertia, above]).unwrap();
        body_surface(&scene::read(&text).unwrap().shape(0), &at(position), scenery)
    }

    #[test]
    fn surfaces_enclose_the_volume_of_their_body_and_face_outwards() {
        let scenery = AxisAlignedBox { lower: Vector3::zeros(), upper: Vector3::zeros() };
        let bodies = [
            ("{sphere={radius=2.0}}", 32.0 / 3.0),
            ("{cylinder={radius=2.0, length=5.0}}", 20.0),
            ("{capsule={radius=2.0, length=5.0}}", 32.0 / 3.0 + 4.0),
            ("{bullet={radius=2.0, length=5.0, nose={cone={length=3.0}}}}", 12.0),
            ("{bullet={radius=2.0, length=5.0, nose='flat'}}", 20.0),
            ("{plate={size=[2.0, 3.0, 5.0]}}", 30.0 / PI),
        ];
        for (shape, expected) in bodies {
            let found = volume(&drawn(shape, Vector3::new(1.0, 2.0, 3.0), &scenery));
            assert!((found / (expected * PI) - 1.0).abs() < 0.01, "{shape}: {found}");
        }
    }

    #[test]
    fn a_bullet_is_drawn_about_its_centre_of_mass_nose_down() {
        let scenery = AxisAlignedBox { lower: Vector3::zeros(), upper: Vector3::zeros() };
        let cone = drawn("{bullet={radius=1.0, length=4.0, nose={cone={length=4.0}}}}", Vector3::zeros(), &scenery);
        let heights = AxisAlignedBox::around(cone.points.iter().copied());
        assert!((heights.lower.z + 3.0).abs() < 1e-12 && (heights.upper.z - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_body_of_triangles_is_drawn_with_them() {
        let corner = [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
        let faces = [[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]].map(|face| face.map(|i: usize| corner[i]));
        let body = TriangleBody::new(crate::geometry::TriangleSurface::new(&faces).unwrap(), 2.0).unwrap();
        let scenery = AxisAlignedBox { lower: Vector3::zeros(), upper: Vector3::zeros() };
        let drawn = body_surface(&ShapeGeometry::Solid(body.into()), &at(Vector3::new(1.0, 2.0, 3.0)), &scenery);
        assert!((volume(&drawn) - 8.0 / 6.0).abs() < 1e-14 && drawn.triangles.len() == 4 && drawn.bounded);
        let lower = AxisAlignedBox::around(drawn.points.iter().copied()).lower;
        assert!((lower - Vector3::new(0.5, 1.5, 2.5)).norm() < 1e-14);
    }

    #[test]
    fn a_dome_is_a_cap_under_a_plate() {
        let scenery = AxisAlignedBox { lower: Vector3::new(-1.0, 0.0, 0.0), upper: Vector3::new(1.0, 0.0, 0.0) };
        for (height, cap) in [(0.0, 0.0), (0.3, PI * 0.3 * (3.0 * 0.25 + 0.09) / 6.0)] {
            let shape = format!("{{dome={{height={height:?}, radius=0.5}}}}");
            let dome = drawn(&shape, Vector3::zeros(), &scenery);
            let plate = PI * 0.6 * 0.6 * 0.06;
            assert!(!dome.bounded && (volume(&dome) / (plate + cap) - 1.0).abs() < 0.01, "{}", volume(&dome));
        }
    }

    #[test]
    fn the_plate_of_a_half_space_lies_behind_its_plane() {
        let scenery = AxisAlignedBox { lower: Vector3::new(-1.0, 0.0, 0.5), upper: Vector3::new(1.0, 0.0, 2.0) };
        let plate = drawn("{half-space={normal=[0.0, 0.0, 2.0]}}", Vector3::zeros(), &scenery);
        let heights = AxisAlignedBox::around(plate.points.iter().copied());
        assert!(heights.upper.z.abs() < 1e-12 && heights.lower.z < 0.0 && heights.upper.x > 1.0);
    }
}
