//! Bodies of many shapes shot at the gel of `sphere-block`.

use super::run::{scene, scene_with_files};
use ballistic_gel::geometry::{ShapeGeometry, SignedDistance as _};
use ballistic_gel::math::Vector3;
use ballistic_gel::scene::Scene;
use nalgebra::{Quaternion, UnitQuaternion};

#[path = "../../tests/solid/bodies.rs"]
#[allow(dead_code, reason = "the tests know more bodies")]
mod bodies;

/// Cosine and sine of an eighth of a turn, half of the angle by which a tilted body is turned.
const EIGHTH: [f64; 2] = [0.923_879_532_511_286_7, 0.382_683_432_365_089_8];
/// Gap to the gel at the start, m.
const GAP: f64 = 1e-5;

/// Radius of every body, m.
pub const RADIUS: f64 = 0.01;

/// The space of a shot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Space {
    Spatial,
    Planar,
    Axisymmetric,
}

impl Space {
    /// How its rows begin.
    pub fn label(self) -> &'static str {
        match self {
            Self::Spatial => "",
            Self::Planar => "planar ",
            Self::Axisymmetric => "axisymmetric ",
        }
    }

    /// Points of entry, in cells: the middle of a facet, a node, the middle of the longest side, and somewhere.
    pub fn entries(self) -> &'static [[f64; 2]] {
        match self {
            Self::Spatial => &[[0.5, 1.0 / 6.0], [0.0, 0.0], [0.5, 0.0], [0.2, -0.4]],
            Self::Planar => &[[0.5, 0.0], [0.0, 0.0], [0.2, 0.0]],
            Self::Axisymmetric => &[[0.0, 0.0]],
        }
    }

    /// The block, and a body of steel, or a bar of it a metre long.
    fn keys(self) -> Vec<(&'static str, String)> {
        let keys: &[(&str, &str)] = match self {
            Self::Spatial => &[],
            Self::Planar => {
                &[("scene.dimension", "planar"), ("gel.shape.block.size", "[0.1, 0.05]"), ("projectile.mass", "2.5")]
            }
            Self::Axisymmetric => {
                &[("scene.dimension", "axisymmetric"), ("gel.shape", "{cylinder={radius=0.05, height=0.05}}")]
            }
        };
        keys.iter().map(|(key, value)| (*key, (*value).to_owned())).collect()
    }
}

/// A body as a scene writes it, and whether it is tilted by 45°.
fn body(name: &str) -> (String, bool) {
    let r = RADIUS;
    let bullet = |nose: String| format!("{{bullet={{radius={r:e}, length={:e}, nose={nose}}}}}", 6.0 * r);
    let cylinder = |edge: f64| format!("{{cylinder={{radius={r:e}, length={:e}, edge_radius={edge:e}}}}}", 2.0 * r);
    let long = 3.0 * r;
    match name {
        "sphere" => (format!("{{sphere={{radius={r:e}}}}}"), false),
        "capsule, tilted" => (format!("{{capsule={{radius={r:e}, length={:e}}}}}", 4.0 * r), true),
        "cylinder" => (cylinder(0.0), false),
        "cylinder on its rim, sharp" => (cylinder(0.0), true),
        "cylinder on its rim, rounded" => (cylinder(0.2 * r), true),
        "ogive, sharp" => (bullet(format!("{{ogive={{length={long:e}}}}}")), false),
        "ogive, meplat" => (bullet(format!("{{ogive={{length={long:e}, meplat_radius={:e}}}}}", 0.1 * r)), false),
        "ogive of triangles" => ("{stl={file='ogive.stl'}}".to_owned(), false),
        "cylinder of triangles on its rim" => ("{stl={file='cylinder.stl'}}".to_owned(), true),
        "cone" => (bullet(format!("{{cone={{length={long:e}}}}}")), false),
        _ => panic!("{name} is no body of the studies"),
    }
}

/// A binary STL of the body of revolution that the file is named after.
fn triangles(file: &str) -> Vec<u8> {
    /// An arc is drawn within a thousandth of its radius.
    const TURN: f64 = 0.05;
    let smooth = match file {
        "ogive.stl" => "ogive, sharp",
        "cylinder.stl" => "cylinder",
        _ => panic!("{file} is no file of the studies"),
    };
    let keys = [("projectile.shape", body(smooth).0), ("projectile.position", "[0.0, 0.0, 1.0]".to_owned())];
    let ShapeGeometry::Profile(profile) = scene("sphere-block", &keys).shape(0) else {
        panic!("{smooth} has a profile")
    };
    bodies::binary(&bodies::turned(&profile.polyline(TURN), 96))
}

/// `sphere-block` with this body just above the gel at (x, y), and with some keys replaced.
pub fn shot((space, name): (Space, &str), at: [f64; 2], replaced: &[(&str, String)]) -> Scene {
    let (shape, tilted) = body(name);
    let [cos, sin] = if tilted { EIGHTH } else { [1.0, 0.0] };
    let orientation = [cos, 0.0, sin, 0.0];
    let mut keys = space.keys();
    keys.extend([
        ("projectile.shape", shape),
        ("projectile.orientation", format!("{orientation:?}")),
        ("projectile.position", format!("[{:e}, {:e}, 1.0]", at[0], at[1])),
    ]);
    keys.extend(replaced.iter().cloned());
    let mut scene = scene_with_files("sphere-block", &keys, &|file| Ok(triangles(file)));
    let down = turn(scene.projectile.orientation).inverse_transform_vector(&-Vector3::z());
    scene.projectile.position[2] = scene.shape(0).reach(&down) + GAP;
    scene
}

fn turn([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
}
