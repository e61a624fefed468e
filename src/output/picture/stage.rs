//! Visible polygons of a frame.

use super::cut::{CutPlane, PolygonCorner};
use crate::math::Vector3;
use crate::output::body::{self, BodySurface};
use crate::output::bounds::AxisAlignedBox;
use crate::scene::{Dimension, Scene};
use crate::simulation::MeshFrame;
use std::collections::HashMap;

/// Material of a polygon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PolygonMaterial {
    /// Gel, in an element of this time step, s.
    Gel {
        /// Time step, s.
        step: f64,
    },
    /// Projectile or fragment.
    Body,
}

/// Convex polygon in space.
#[derive(Debug, Clone)]
pub(super) struct VisiblePolygon {
    pub(super) corners: Vec<PolygonCorner>,
    pub(super) material: PolygonMaterial,
}

/// Returns the polygons of a frame. A plane scene shows its elements, an axisymmetric scene also their mirror images.
/// A scene in space shows surface and section of the gel behind a cut through the middle of the projectile, and
/// bounded bodies as a whole.
pub(super) fn polygons(frame: &MeshFrame, scene: &Scene) -> Vec<VisiblePolygon> {
    let scenery = AxisAlignedBox::around(frame.points.iter().copied());
    let plane = CutPlane { y: frame.bodies[0].kinematics.position.y, tolerance: 1e-9 * scenery.radius() };
    // Bodies first: of overlapping polygons in the plane of the picture, the first drawn is seen.
    let mut polygons = vec![];
    for solid in body::body_surfaces(scene, frame, &scenery) {
        match scene.scene.dimension {
            Dimension::Spatial if solid.bounded => polygons.extend(body_triangles(&solid)),
            Dimension::Spatial => polygons.extend(body_section(&solid, plane).chain(clipped_surface(&solid, plane))),
            Dimension::Planar | Dimension::Axisymmetric => polygons.extend(body_section(&solid, plane)),
        }
    }
    match scene.scene.dimension {
        Dimension::Planar => polygons.extend(element_polygons(frame)),
        Dimension::Axisymmetric => polygons.extend(mirrored(element_polygons(frame))),
        Dimension::Spatial => polygons.extend(cut_gel(frame, plane)),
    }
    polygons.retain(|polygon| polygon.corners.len() > 2);
    polygons
}

fn gel_polygon(frame: &MeshFrame, element: usize, corners: Vec<PolygonCorner>) -> VisiblePolygon {
    VisiblePolygon { corners, material: PolygonMaterial::Gel { step: frame.cells.step[element] } }
}

fn node_corner(frame: &MeshFrame, node: u32) -> PolygonCorner {
    PolygonCorner { at: frame.points[node as usize], speed: frame.velocities[node as usize].norm() }
}

fn element_polygons(frame: &MeshFrame) -> Vec<VisiblePolygon> {
    let corners = |nodes: &[u32; 4]| nodes[..3].iter().map(|node| node_corner(frame, *node)).collect();
    frame.cells.nodes.iter().enumerate().map(|(element, nodes)| gel_polygon(frame, element, corners(nodes))).collect()
}

fn mirrored(mut polygons: Vec<VisiblePolygon>) -> Vec<VisiblePolygon> {
    let mut images = polygons.clone();
    for corner in images.iter_mut().flat_map(|image| &mut image.corners) {
        corner.at.x = -corner.at.x;
    }
    polygons.append(&mut images);
    polygons
}

/// Returns the boundary of the gel behind the plane, and its section.
fn cut_gel(frame: &MeshFrame, plane: CutPlane) -> impl Iterator<Item = VisiblePolygon> + '_ {
    let facet_elements = facet_elements(frame);
    let boundary = frame.cells.facets.iter().zip(facet_elements).filter_map(move |(facet, owner)| {
        Some(gel_polygon(frame, owner?, plane.clip(&facet.map(|node| node_corner(frame, node)))))
    });
    let sections = frame.cells.nodes.iter().enumerate().map(move |(element, nodes)| {
        gel_polygon(frame, element, plane.section(&nodes.map(|node| node_corner(frame, node))))
    });
    boundary.chain(sections)
}

/// Returns the element of each boundary facet.
fn facet_elements(frame: &MeshFrame) -> Vec<Option<usize>> {
    let sorted = |mut facet: [u32; 3]| {
        facet.sort_unstable();
        facet
    };
    let mut owner_of: HashMap<[u32; 3], Option<usize>> =
        frame.cells.facets.iter().map(|facet| (sorted(*facet), None)).collect();
    for (element, &[a, b, c, d]) in frame.cells.nodes.iter().enumerate() {
        for facet in [[a, b, c], [a, b, d], [a, c, d], [b, c, d]] {
            owner_of.entry(sorted(facet)).and_modify(|owner| *owner = Some(element));
        }
    }
    frame.cells.facets.iter().map(|facet| owner_of[&sorted(*facet)]).collect()
}

fn body_triangles(solid: &BodySurface) -> impl Iterator<Item = VisiblePolygon> + '_ {
    let corners = |triangle: &[u32; 3]| triangle.iter().map(|i| resting_corner(solid.points[*i as usize])).collect();
    solid
        .triangles
        .iter()
        .map(move |triangle| VisiblePolygon { corners: corners(triangle), material: PolygonMaterial::Body })
}

fn clipped_surface(solid: &BodySurface, plane: CutPlane) -> impl Iterator<Item = VisiblePolygon> + '_ {
    solid.triangles.iter().map(move |triangle| {
        let corners = triangle.map(|i| resting_corner(solid.points[i as usize]));
        VisiblePolygon { corners: plane.clip(&corners), material: PolygonMaterial::Body }
    })
}

/// Returns the section of a solid: the union of the tetrahedra from its centre to its triangles.
fn body_section(solid: &BodySurface, plane: CutPlane) -> impl Iterator<Item = VisiblePolygon> + '_ {
    solid.triangles.iter().map(move |triangle| {
        let [a, b, c] = triangle.map(|i| resting_corner(solid.points[i as usize]));
        VisiblePolygon {
            corners: plane.section(&[resting_corner(solid.centre), a, b, c]),
            material: PolygonMaterial::Body,
        }
    })
}

fn resting_corner(at: Vector3) -> PolygonCorner {
    PolygonCorner { at, speed: 0.0 }
}
