//! Outlines of gel and bodies in the plane of the shot.

use super::part::{self, PartKind, ViewPart};
use crate::math::Vector3;
use crate::output::body::{self, BodySurface};
use crate::output::bounds::AxisAlignedBox;
use crate::scene::{Dimension, Scene};
use crate::simulation::MeshFrame;
use std::collections::{BTreeMap, BTreeSet};

/// Point of the section: depth below the undisturbed entry surface, m, and distance from the z axis along x, m.
pub(in crate::output) type SectionPoint = [f64; 2];

/// Section of a frame with the plane of the shot, seen from the block.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::output) struct SectionOutline {
    /// Time, s.
    pub(in crate::output) time: f64,
    /// Closed boundary loops of the gel.
    pub(in crate::output) gel: Vec<Vec<SectionPoint>>,
    /// Closed outline of each body.
    pub(in crate::output) bodies: Vec<Vec<SectionPoint>>,
}

impl SectionOutline {
    /// Cuts a frame.
    pub(in crate::output) fn of(frame: &MeshFrame, scene: &Scene) -> Self {
        let scenery = AxisAlignedBox::around(frame.points.iter().copied());
        let plane = part::shot_plane(frame, scene);
        let place = |at: &Vector3| {
            let at = at - frame.block.displacement;
            [-at.z, at.x]
        };
        let parts = part::parts(frame, scene);
        let sections = parts.iter().filter(|part| part.kind == PartKind::Section);
        let mut gel: Vec<Vec<SectionPoint>> = sections.flat_map(|part| loops(part, place)).collect();
        let is_mirrored =
            scene.scene.dimension == Dimension::Axisymmetric || scene.gel.symmetry.mirrored().contains(&0);
        if is_mirrored {
            let reflected = |points: &Vec<SectionPoint>| points.iter().map(|[depth, x]| [*depth, -x]).collect();
            gel.extend(gel.iter().map(reflected).collect::<Vec<_>>());
        }
        let solids = body::body_surfaces(scene, frame, &scenery);
        let bodies = solids.iter().map(|solid| cut_body(solid, plane).iter().map(place).collect::<Vec<_>>());
        Self { time: frame.time, gel, bodies: bodies.filter(|points| points.len() > 2).collect() }
    }
}

/// Returns the boundary loops of a triangulated section: chains of edges that belong to one triangle.
fn loops(part: &ViewPart, place: impl Fn(&Vector3) -> SectionPoint) -> Vec<Vec<SectionPoint>> {
    let mut counts = BTreeMap::<[u32; 2], usize>::new();
    for [a, b, c] in &part.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *counts.entry([*from.min(to), *from.max(to)]).or_default() += 1;
        }
    }
    let mut neighbours = BTreeMap::<u32, BTreeSet<u32>>::new();
    for [a, b] in counts.into_iter().filter(|(_, count)| *count == 1).map(|(edge, _)| edge) {
        neighbours.entry(a).or_default().insert(b);
        neighbours.entry(b).or_default().insert(a);
    }
    let mut all = vec![];
    while let Some((&first, _)) = neighbours.iter().find(|(_, ends)| !ends.is_empty()) {
        let (mut chain, mut at) = (vec![], first);
        while let Some(next) = neighbours.get_mut(&at).and_then(BTreeSet::pop_first) {
            neighbours.entry(next).or_default().remove(&at);
            chain.push(place(&part.points[at as usize].at));
            at = next;
        }
        neighbours.retain(|_, ends| !ends.is_empty());
        all.push(chain);
    }
    all
}

/// Returns the points in which the edges of a body meet the plane y = const, in the order of their angle about its centre.
fn cut_body(solid: &BodySurface, y: f64) -> Vec<Vector3> {
    let sides = |triangle: &[u32; 3]| {
        let corners = triangle.map(|i| solid.points[i as usize]);
        (0..3).map(move |i| [corners[i], corners[(i + 1) % 3]]).collect::<Vec<_>>()
    };
    let crossing = |[a, b]: [Vector3; 2]| {
        let crosses = (a.y >= y) != (b.y >= y);
        crosses.then(|| a + (b - a) * ((y - a.y) / (b.y - a.y)))
    };
    let mut points: Vec<Vector3> = solid.triangles.iter().flat_map(sides).filter_map(crossing).collect();
    let angle = |at: &Vector3| (at.z - solid.centre.z).atan2(at.x - solid.centre.x);
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    points.dedup_by(|a, b| (*a - *b).norm() < 1e-12);
    points
}

#[cfg(test)]
mod tests {
    use super::super::part::PartPoint;
    use super::*;

    #[test]
    fn the_boundary_of_a_section_with_a_hole_is_two_loops() {
        // A square ring: 8 points, inner and outer, and 8 triangles.
        let corner = |r: f64, i: u32| [[r, r], [-r, r], [-r, -r], [r, -r]][i as usize];
        let at = |r: f64, i: u32| Vector3::new(corner(r, i)[0], 0.0, corner(r, i)[1]);
        let point = |at: Vector3| PartPoint { nodes: [0; 2], share: 0.0, at };
        let points = (0..4).map(|i| point(at(2.0, i))).chain((0..4).map(|i| point(at(1.0, i)))).collect();
        let quad = |i: u32| [[i, (i + 1) % 4, 4 + i], [(i + 1) % 4, 4 + (i + 1) % 4, 4 + i]];
        let triangles = (0..4).flat_map(quad).collect();
        let part = ViewPart { kind: PartKind::Section, points, triangles, edges: vec![] };
        let mut found = loops(&part, |at| [-at.z, at.x]);
        found.sort_by(|a, b| a[0][1].abs().total_cmp(&b[0][1].abs()));
        let reach = |points: &Vec<SectionPoint>| points.iter().map(|[depth, _]| *depth).fold(f64::MIN, f64::max);
        assert_eq!(found.iter().map(|points| (points.len(), reach(points))).collect::<Vec<_>>(), [(4, 1.0), (4, 2.0)]);
    }
}
