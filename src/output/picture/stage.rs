//! Which polygons of a frame can be seen.

use super::cut::{Corner, Plane};
use crate::math::Vector3;
use crate::output::body::{self, Solid};
use crate::output::bounds::Bounds;
use crate::scene::{Dimension, Scene};
use crate::simulation::Frame;
use std::collections::HashMap;

/// What a polygon belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Substance {
    /// Gel, in an element of this step, s.
    Gel {
        /// Step, s.
        step: f64,
    },
    /// The projectile or a fragment.
    Body,
}

/// A convex polygon in space.
#[derive(Debug, Clone)]
pub(super) struct Polygon {
    pub(super) corners: Vec<Corner>,
    pub(super) substance: Substance,
}

/// The polygons of a frame: in two dimensions the elements (mirrored about the axis), in three the surface behind a cut
/// through the middle of the projectile and the section there. A bounded body in space is drawn whole.
pub(super) fn polygons(frame: &Frame, scene: &Scene) -> Vec<Polygon> {
    let scenery = Bounds::around(frame.points.iter().copied());
    let plane = Plane { y: frame.bodies[0].kinematics.position.y, tolerance: 1e-9 * scenery.radius() };
    // First the bodies: where they overlap gel in the plane of the picture, the first one drawn is seen.
    let mut polygons = vec![];
    for solid in body::solids(scene, frame, &scenery) {
        match scene.scene.dimension {
            Dimension::Spatial if solid.bounded => polygons.extend(whole(&solid)),
            Dimension::Spatial => polygons.extend(section(&solid, plane).chain(surface(&solid, plane))),
            Dimension::Planar | Dimension::Axisymmetric => polygons.extend(section(&solid, plane)),
        }
    }
    match scene.scene.dimension {
        Dimension::Planar => polygons.extend(elements(frame)),
        Dimension::Axisymmetric => polygons.extend(mirrored(elements(frame))),
        Dimension::Spatial => polygons.extend(halved(frame, plane)),
    }
    polygons.retain(|polygon| polygon.corners.len() > 2);
    polygons
}

fn gel(frame: &Frame, element: usize, corners: Vec<Corner>) -> Polygon {
    Polygon { corners, substance: Substance::Gel { step: frame.cells.step[element] } }
}

fn corner(frame: &Frame, node: u32) -> Corner {
    Corner { at: frame.points[node as usize], speed: frame.velocities[node as usize].norm() }
}

fn elements(frame: &Frame) -> Vec<Polygon> {
    let corners = |nodes: &[u32; 4]| nodes[..3].iter().map(|node| corner(frame, *node)).collect();
    frame.cells.nodes.iter().enumerate().map(|(element, nodes)| gel(frame, element, corners(nodes))).collect()
}

fn mirrored(mut polygons: Vec<Polygon>) -> Vec<Polygon> {
    let mut images = polygons.clone();
    for corner in images.iter_mut().flat_map(|image| &mut image.corners) {
        corner.at.x = -corner.at.x;
    }
    polygons.append(&mut images);
    polygons
}

/// The boundary of the gel behind the plane, and its section.
fn halved(frame: &Frame, plane: Plane) -> impl Iterator<Item = Polygon> + '_ {
    let owners = owners(frame);
    let boundary =
        frame.cells.facets.iter().zip(owners).filter_map(move |(facet, owner)| {
            Some(gel(frame, owner?, plane.clip(&facet.map(|node| corner(frame, node)))))
        });
    let sections = frame
        .cells
        .nodes
        .iter()
        .enumerate()
        .map(move |(element, nodes)| gel(frame, element, plane.section(&nodes.map(|node| corner(frame, node)))));
    boundary.chain(sections)
}

/// The element that each boundary facet belongs to.
fn owners(frame: &Frame) -> Vec<Option<usize>> {
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

fn whole(solid: &Solid) -> impl Iterator<Item = Polygon> + '_ {
    let corners = |triangle: &[u32; 3]| triangle.iter().map(|i| still(solid.points[*i as usize])).collect();
    solid.triangles.iter().map(move |triangle| Polygon { corners: corners(triangle), substance: Substance::Body })
}

fn surface(solid: &Solid, plane: Plane) -> impl Iterator<Item = Polygon> + '_ {
    solid.triangles.iter().map(move |triangle| {
        let corners = triangle.map(|i| still(solid.points[i as usize]));
        Polygon { corners: plane.clip(&corners), substance: Substance::Body }
    })
}

/// The section of a solid: it is the union of the tetrahedra from its centre to its triangles.
fn section(solid: &Solid, plane: Plane) -> impl Iterator<Item = Polygon> + '_ {
    solid.triangles.iter().map(move |triangle| {
        let [a, b, c] = triangle.map(|i| still(solid.points[i as usize]));
        Polygon { corners: plane.section(&[still(solid.centre), a, b, c]), substance: Substance::Body }
    })
}

fn still(at: Vector3) -> Corner {
    Corner { at, speed: 0.0 }
}
