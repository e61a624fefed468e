//! Side of a surface on which a point lies, decided by angle-weighted pseudonormals.

use super::closest::TriangleFeature;
use super::surface::TriangleSurface;
use crate::math::Vector3;

/// Angle-weighted pseudonormals (Bærentzen & Aanæs 2005): edges sum the normals of both faces, corners weight them with
/// the face angles. The sign of n·(p − q) tells the side of p, where q is the closest point of the surface.
#[derive(Debug, Clone)]
pub(super) struct PseudoNormals {
    /// Unit normals of the faces; zero for a triangle without an area.
    pub faces: Vec<Vector3>,
    edges: Vec<[Vector3; 3]>,
    /// Pseudonormals of the corners, of any length.
    pub corners: Vec<Vector3>,
}

impl PseudoNormals {
    /// Computes the normals of a surface.
    pub fn of(surface: &TriangleSurface) -> Self {
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

    /// Pseudonormal, of any length, of a feature of a triangle.
    pub fn at(&self, surface: &TriangleSurface, triangle: u32, feature: TriangleFeature) -> Vector3 {
        let n = triangle as usize;
        match feature {
            TriangleFeature::Face => self.faces[n],
            TriangleFeature::Edge(i) => self.edges[n][i],
            TriangleFeature::Corner(i) => self.corners[surface.triangles[n][i] as usize],
        }
    }
}
