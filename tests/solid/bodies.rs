//! Triangles of simple bodies, and files of them.

use ballistic_gel::math::Vector3;
use std::f64::consts::{PI, TAU};

/// Corners of triangles, outward oriented.
pub type Triangles = Vec<[Vector3; 3]>;

/// The surface that a profile (r, z) from pole to pole sweeps about the z axis, in so many segments.
pub fn turned(profile: &[(f64, f64)], segments: usize) -> Triangles {
    let at = |(r, z): (f64, f64), i: usize| {
        let angle = TAU * (i % segments) as f64 / segments as f64;
        Vector3::new(r * angle.cos(), r * angle.sin(), z)
    };
    let mut triangles = vec![];
    for (pair, i) in profile.windows(2).flat_map(|pair| (0..segments).map(move |i| (pair, i))) {
        let [a, b, c, d] = [at(pair[0], i), at(pair[0], i + 1), at(pair[1], i + 1), at(pair[1], i)];
        if pair[0].0 > 0.0 {
            triangles.push([a, b, c]);
        }
        if pair[1].0 > 0.0 {
            triangles.push([a, c, d]);
        }
    }
    triangles
}

/// A sphere with twice as many segments as rings; with `n` doubled, facets are half as large.
pub fn sphere(radius: f64, n: usize) -> Triangles {
    let angle = |i: usize| PI * i as f64 / n as f64;
    let ring = |i: usize| if i == 0 || i == n { 0.0 } else { radius * angle(i).sin() };
    let profile: Vec<(f64, f64)> = (0..=n).map(|i| (ring(i), -radius * angle(i).cos())).collect();
    turned(&profile, 2 * n)
}

/// A cylinder about the z axis.
pub fn cylinder(radius: f64, length: f64, segments: usize) -> Triangles {
    let z = 0.5 * length;
    turned(&[(0.0, -z), (radius, -z), (radius, z), (0.0, z)], segments)
}

/// A cuboid about the origin, its faces divided once.
pub fn cuboid(size: [f64; 3]) -> Triangles {
    let side = |i: usize, axis: usize| if i >> axis & 1 == 0 { -0.5 * size[axis] } else { 0.5 * size[axis] };
    let corner = |i: usize| Vector3::from_fn(|axis, _| side(i, axis));
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    faces
        .into_iter()
        .flat_map(|face| [[face[0], face[1], face[2]], [face[0], face[2], face[3]]])
        .map(|t| t.map(corner))
        .collect()
}

/// What an outline, counter-clockwise in triangles, sweeps along z.
fn prism(outline: &[(f64, f64)], cap: &[[usize; 3]], height: f64) -> Triangles {
    let at = |i: usize, z: f64| Vector3::new(outline[i % outline.len()].0, outline[i % outline.len()].1, z);
    let mut triangles: Triangles = cap.iter().map(|t| t.map(|i| at(i, height))).collect();
    triangles.extend(cap.iter().map(|&[a, b, c]| [at(a, 0.0), at(c, 0.0), at(b, 0.0)]));
    for i in 0..outline.len() {
        triangles.push([at(i, 0.0), at(i + 1, 0.0), at(i + 1, height)]);
        triangles.push([at(i, 0.0), at(i + 1, height), at(i, height)]);
    }
    triangles
}

/// A thick L, so one with a hollow edge.
pub fn angle() -> Triangles {
    let outline = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)];
    prism(&outline, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], 1.5)
}

/// A fork: a bar along x with two prongs towards −z, 4 to 5 apart, 4 long and 1 thick, each ending in a short edge along y.
/// Its centre of mass is between the prongs.
pub fn fork() -> Triangles {
    let outline =
        [(-3.0, 1.0), (-3.0, 0.0), (-2.5, -4.0), (-2.0, 0.0), (2.0, 0.0), (2.5, -4.0), (3.0, 0.0), (3.0, 1.0)];
    let cap = [[0, 1, 3], [1, 2, 3], [0, 3, 4], [0, 4, 7], [4, 6, 7], [4, 5, 6]];
    let upright = |p: Vector3| Vector3::new(p.x, -p.z, p.y);
    prism(&outline, &cap, 1.0).iter().map(|triangle| triangle.map(upright)).collect()
}

/// The same moved.
pub fn moved(triangles: &Triangles, by: Vector3) -> Triangles {
    triangles.iter().map(|triangle| triangle.map(|p| p + by)).collect()
}

/// The same inside out.
pub fn reversed(triangles: &Triangles) -> Triangles {
    triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect()
}

/// A binary STL file.
pub fn binary(triangles: &Triangles) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.iter().flatten().flat_map(|x| (*x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// An ASCII STL file.
pub fn ascii(triangles: &Triangles) -> Vec<u8> {
    let vertex = |p: &Vector3| format!("      vertex {:e} {:e} {:e}\n", p.x, p.y, p.z);
    let corners = |triangle: &[Vector3; 3]| triangle.iter().map(vertex).collect::<String>();
    let facet = |t| format!("  facet normal 0 0 0\n    outer loop\n{}    endloop\n  endfacet\n", corners(t));
    let facets: String = triangles.iter().map(facet).collect();
    format!("solid body\n{facets}endsolid body\n").into_bytes()
}
