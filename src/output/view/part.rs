//! Parts of a frame that the view draws: the surface of the gel, its section and the bodies.

use crate::math::Vector3;
use crate::output::body::{self, BodySurface};
use crate::output::bounds::AxisAlignedBox;
use crate::scene::{Dimension, Scene};
use crate::simulation::MeshFrame;
use std::collections::HashMap;

/// Kind of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PartKind {
    /// Surface of the gel, without the planes of symmetry.
    Surface,
    /// Section of the gel in the plane of the shot; in two dimensions the whole mesh.
    Section,
    /// Projectile or fragment.
    Body,
}

impl PartKind {
    /// Returns the name of the kind in the data of the page.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Surface => "surface",
            Self::Section => "section",
            Self::Body => "body",
        }
    }
}

/// Point of a part: on the line between two nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PartPoint {
    /// Nodes at both ends of the line.
    pub(super) nodes: [u32; 2],
    /// Fraction of the way to the second node.
    pub(super) share: f64,
    /// Position, m.
    pub(super) at: Vector3,
}

/// Triangles and boundary edges of a part, with its points in the order of their first use.
#[derive(Debug)]
pub(super) struct ViewPart {
    pub(super) kind: PartKind,
    pub(super) points: Vec<PartPoint>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Boundary edges, in two dimensions.
    pub(super) edges: Vec<[u32; 2]>,
}

/// Builder of a part: numbers the points in the order of their first use.
struct PartBuilder<'a> {
    frame: &'a MeshFrame,
    part: ViewPart,
    numbers: HashMap<[u32; 2], u32>,
}

impl<'a> PartBuilder<'a> {
    fn new(kind: PartKind, frame: &'a MeshFrame) -> Self {
        let part = ViewPart { kind, points: vec![], triangles: vec![], edges: vec![] };
        Self { frame, part, numbers: HashMap::new() }
    }

    fn node(&mut self, node: u32) -> u32 {
        self.point(PartPoint { nodes: [node; 2], share: 0.0, at: self.frame.points[node as usize] })
    }

    fn point(&mut self, point: PartPoint) -> u32 {
        *self.numbers.entry(point.nodes).or_insert_with(|| {
            self.part.points.push(point);
            self.part.points.len() as u32 - 1
        })
    }

    /// Returns the intersection of the edge between two nodes with the plane y = const.
    fn crossing(&mut self, a: u32, b: u32, y: f64) -> u32 {
        let (first, second) = (a.min(b), a.max(b));
        let [p, q] = [first, second].map(|node| self.frame.points[node as usize]);
        let share = ((y - p.y) / (q.y - p.y)).clamp(0.0, 1.0);
        let mut at = p + share * (q - p);
        at.y = y;
        self.point(PartPoint { nodes: [first, second], share, at })
    }
}

/// Returns the height y of the plane through the shot: a plane of symmetry, or that through the projectile.
pub(super) fn shot_plane(frame: &MeshFrame, scene: &Scene) -> f64 {
    let is_symmetric = scene.gel.symmetry.mirrored().contains(&1) || scene.scene.dimension != Dimension::Spatial;
    frame.bodies.first().filter(|_| !is_symmetric).map_or(0.0, |body| body.kinematics.position.y)
}

/// Returns the parts of a frame.
pub(super) fn parts(frame: &MeshFrame, scene: &Scene) -> Vec<ViewPart> {
    let scenery = AxisAlignedBox::around(frame.points.iter().copied());
    let plane = shot_plane(frame, scene);
    let solids = body::body_surfaces(scene, frame, &scenery);
    let bodies: Vec<ViewPart> = match scene.scene.dimension {
        Dimension::Planar => solids.iter().map(|solid| flat_body(solid, solid.centre.y)).collect(),
        Dimension::Axisymmetric | Dimension::Spatial => solids.iter().map(solid_body).collect(),
    };
    let tolerance = 1e-9 * scenery.radius();
    let gel = match scene.scene.dimension {
        Dimension::Planar | Dimension::Axisymmetric => vec![flat_gel(frame)],
        Dimension::Spatial => spatial_gel(frame, scene, plane, tolerance),
    };
    gel.into_iter().chain(bodies).filter(|part| !part.triangles.is_empty()).collect()
}

/// Returns the mesh of a gel in two dimensions with its boundary.
fn flat_gel(frame: &MeshFrame) -> ViewPart {
    let mut builder = PartBuilder::new(PartKind::Section, frame);
    for nodes in &frame.cells.nodes {
        let triangle = [nodes[0], nodes[1], nodes[2]].map(|node| builder.node(node));
        builder.part.triangles.push(triangle);
    }
    for facet in &frame.cells.facets {
        let edge = [facet[0], facet[1]].map(|node| builder.node(node));
        builder.part.edges.push(edge);
    }
    builder.part
}

/// Returns surface and section of a gel in space.
fn spatial_gel(frame: &MeshFrame, scene: &Scene, plane: f64, tolerance: f64) -> Vec<ViewPart> {
    let mirrored = scene.gel.symmetry.mirrored();
    let mut surface = PartBuilder::new(PartKind::Surface, frame);
    let mut section = PartBuilder::new(PartKind::Section, frame);
    for facet in &frame.cells.facets {
        let lies_on = |axis: &&usize| facet.iter().all(|node| frame.points[*node as usize][**axis].abs() <= tolerance);
        match mirrored.iter().find(lies_on) {
            None => {
                let triangle = facet.map(|node| surface.node(node));
                surface.part.triangles.push(triangle);
            }
            Some(1) => {
                let triangle = facet.map(|node| section.node(node));
                section.part.triangles.push(triangle);
            }
            Some(_) => {}
        }
    }
    if !mirrored.contains(&1) {
        for nodes in &frame.cells.nodes {
            cut_element(&mut section, nodes, plane, tolerance);
        }
    }
    vec![surface.part, section.part]
}

/// Appends the section of a tetrahedron with the plane y = const.
fn cut_element(section: &mut PartBuilder, nodes: &[u32; 4], y: f64, tolerance: f64) {
    let is_behind = |node: &u32| section.frame.points[*node as usize].y >= y - tolerance;
    let (behind, before): (Vec<u32>, Vec<u32>) = nodes.iter().partition(|node| is_behind(node));
    let pairs = match (behind.as_slice(), before.as_slice()) {
        ([a], [b, c, d]) | ([b, c, d], [a]) => vec![(*a, *b), (*a, *c), (*a, *d)],
        ([a, b], [c, d]) => vec![(*a, *c), (*a, *d), (*b, *d), (*b, *c)],
        _ => return,
    };
    let corners: Vec<u32> = pairs.into_iter().map(|(a, b)| section.crossing(a, b, y)).collect();
    for pair in corners[1..].windows(2) {
        section.part.triangles.push([corners[0], pair[0], pair[1]]);
    }
}

/// Returns the whole surface of a body.
fn solid_body(solid: &BodySurface) -> ViewPart {
    let points = solid.points.iter().map(|at| PartPoint { nodes: [0; 2], share: 0.0, at: *at }).collect();
    ViewPart { kind: PartKind::Body, points, triangles: solid.triangles.clone(), edges: vec![] }
}

/// Returns the section of a body that is star-shaped about its centre, with its outline.
fn flat_body(solid: &BodySurface, y: f64) -> ViewPart {
    let point = |at: Vector3| PartPoint { nodes: [0; 2], share: 0.0, at };
    let mut part =
        ViewPart { kind: PartKind::Body, points: vec![point(solid.centre)], triangles: vec![], edges: vec![] };
    for triangle in &solid.triangles {
        let corners = triangle.map(|i| solid.points[i as usize]);
        let sides = (0..3).map(|i| (corners[i], corners[(i + 1) % 3]));
        let ends: Vec<Vector3> = sides
            .filter(|(a, b)| (a.y >= y) != (b.y >= y))
            .map(|(a, b)| a + (b - a) * ((y - a.y) / (b.y - a.y)))
            .collect();
        if let [a, b] = ends[..] {
            let first = part.points.len() as u32;
            part.points.extend([point(a), point(b)]);
            part.triangles.push([0, first, first + 1]);
            part.edges.push([first, first + 1]);
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{BlockMotion, FrameCells};

    #[test]
    fn the_section_of_elements_has_the_area_of_the_plane_in_them() {
        let corners = [[0.0, -1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 1.0, 0.0], [0.0, 3.0, 0.0]];
        let cells = FrameCells {
            nodes: vec![[0, 1, 2, 3], [1, 2, 3, 4]],
            step: vec![],
            jacobian: vec![],
            energy_density: vec![],
            damage: vec![],
            facets: vec![],
        };
        let points = corners.map(Vector3::from).to_vec();
        let (velocities, displacements) = (vec![], vec![]);
        let frame = MeshFrame {
            time: 0.0,
            dimension: 3,
            mass: 1.0,
            points,
            velocities,
            displacements,
            cells,
            fields: vec![],
            bodies: vec![],
            block: BlockMotion::default(),
            gel_displacement: Vector3::zeros(),
        };
        let area = |y: f64| {
            let mut section = PartBuilder::new(PartKind::Section, &frame);
            for nodes in &frame.cells.nodes {
                cut_element(&mut section, nodes, y, 1e-9);
            }
            let at = |i: u32| section.part.points[i as usize].at;
            let areas =
                section.part.triangles.iter().map(|[a, b, c]| (at(*b) - at(*a)).cross(&(at(*c) - at(*a))).norm());
            0.5 * areas.sum::<f64>()
        };
        assert!((area(0.0) - 0.125).abs() < 1e-15 && (area(2.0) - 0.125).abs() < 1e-15);
        assert!((area(1.0) - 0.5).abs() < 1e-15, "a face in the plane is drawn once");
    }
}
