//! The side of a surface that a point is on, by the normals of its faces, edges and corners.

use super::closest::Feature;
use super::surface::Surface;
use crate::math::Vector3;

/// Normals out of a surface: with those of edges summed over both faces, and those of corners weighted with the angles of
/// the faces there, the sign of n·(p − q) tells the side of p, q being the point nearest to it (Bærentzen and Aanæs 2005).
#[derive(Debug, Clone)]
pub(super) struct Normals {
    /// Unit vectors; zero of a triangle without an area.
    pub faces: Vec<Vector3>,
    edges: Vec<[Vector3; 3]>,
    /// Of any length.
    pub corners: Vec<Vector3>,
}

impl Normals {
    pub fn of(surface: &Surface) -> Self {
        let unit = |[a, b, c]: [Vector3; 3]| (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
        let faces: Vec<Vector3> = surface.corners().map(unit).collect();
        let sum = |(n, across): (usize, &[u32; 3])| across.map(|other| faces[n] + faces[other as usize]);
        let edges = surface.across.iter().enumerate().map(sum).collect();
        let mut corners = vec![Vector3::zeros(); surface.points.len()];
        for ((triangle, at), face) in surface.triangles.iter().zip(surface.corners()).zip(&faces) {
            for i in 0..3 {
                let (u, v) = (at[(i + 1) % 3] - at[i], at[(i + 2) % 3] - at[i]);
                corners[triangle[i] as usize] += face * libm::atan2(u.cross(&v).norm(), u.dot(&v));
            }
        }
        Self { faces, edges, corners }
    }

    /// The normal, of any length, of a part of a triangle.
    pub fn at(&self, surface: &Surface, triangle: u32, feature: Feature) -> Vector3 {
        let n = triangle as usize;
        match feature {
            Feature::Face => self.faces[n],
            Feature::Edge(i) => self.edges[n][i],
            Feature::Corner(i) => self.corners[surface.triangles[n][i] as usize],
        }
    }
}
