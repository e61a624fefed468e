//! Resampling of the plane boundary: long edges are split, and needless nodes are left out.

use super::boundary_loops::BoundaryLoops;
use super::point_set::PointSet;
use super::triangle::{PlanarPoint, cross, distance};
use super::untangle::BoundaryCuts;
use super::{DeformedMesh, NodeOrigin, RemeshError, RemeshRules};
use crate::geometry::Bvh;
use crate::mesh::NodeId;

/// Length, in target sizes, above which an edge is split evenly; an edge shorter than `SHORT` is first joined to the
/// next. Parts of a split edge are longer than 0.7 sizes: neither operation undoes the other. With edges of 0.45 sizes
/// and circumradii of 0.9, boundary angles are at least asin(0.45 / 1.8) = 14°.
const LONG: f64 = 1.4;
const SHORT: f64 = 0.45;
/// Greatest displacement of a new point by the projection out of a body, in target sizes.
const NEAR: f64 = 0.2;
/// Greatest number of coarsening passes along the boundary: each can halve the number of edges.
const WALKS: usize = 12;

/// Boundary of the new mesh.
#[derive(Debug, Clone)]
pub(super) struct NewBoundary {
    /// Edges, the body on their left.
    pub edges: Vec<[usize; 2]>,
    /// Edges of the old boundary that the new one lacks.
    pub lost: Vec<[usize; 2]>,
    /// Search tree over the new edges.
    pub near: Bvh<2>,
    /// Loss of area, m², by cutting off loops and needles and by moving new points out of bodies.
    pub cleared: f64,
}

/// Projection of a point to the nearest position outside all bodies.
pub(super) type ClearProjection<'a> = &'a dyn Fn(&PlanarPoint) -> PlanarPoint;

/// Resamples the boundary; new points are projected by `cleared`.
///
/// # Errors
/// [`RemeshError`] if two edges of the old boundary cross.
pub(super) fn resample(
    old: &DeformedMesh<'_, 2>,
    cloud: &mut PointSet,
    (rules, cleared): (&RemeshRules, ClearProjection<'_>),
) -> Result<NewBoundary, RemeshError> {
    let mut chain = BoundaryLoops::new(old, rules.rests);
    chain.members.iter().for_each(|&node| cloud.chosen[node] = true);
    let mut cut = BoundaryCuts::default();
    // A pit pierced by a neighbouring tip looks like a needle; an inseparable crossing may be located at such a pit.
    let _ = chain.untangle(cloud, &mut cut);
    (0..WALKS).any(|_| !chain.cut_needles(cloud, &mut cut));
    chain.untangle(cloud, &mut cut)?;
    if rules.sag > 0.0 {
        (0..WALKS).any(|_| !chain.coarsen(cloud, rules.sag));
    }
    let mut surface = NewBoundary { edges: vec![], lost: cut.edges, near: Bvh::new(&[]), cleared: 0.0 };
    for &edge in &chain.edges {
        if cloud.chosen[edge[0]] {
            surface.take(&chain.stretch(edge), cloud);
        }
    }
    surface.clear(cloud, &old.mesh.held, cleared);
    surface.cleared += cut.area;
    surface.near = Bvh::segments(&surface.edges, &cloud.position);
    Ok(surface)
}

impl BoundaryLoops<'_> {
    /// Old nodes from the start of an edge to the next node that stays.
    fn stretch(&self, [start, next]: [usize; 2]) -> Vec<usize> {
        let mut nodes = vec![start, next];
        let mut at = next;
        while let (true, Some(after)) = (self.after[start].is_some_and(|end| end != at), self.first_after[at]) {
            nodes.push(after);
            at = after;
        }
        nodes
    }

    /// Leaves out needless nodes, no two of them adjacent. Returns true if any was left out.
    fn coarsen(&mut self, cloud: &mut PointSet, sag: f64) -> bool {
        let mut waits = vec![false; self.can_go.len()];
        let mut any = false;
        for i in 0..self.members.len() {
            let node = self.members[i];
            if waits[node] || !cloud.chosen[node] || !self.can_go[node] || !self.is_needless(node, cloud, sag) {
                continue;
            }
            let (Some(before), Some(after)) = (self.before[node], self.after[node]) else { continue };
            (waits[before], waits[after]) = (true, true);
            cloud.chosen[node] = false;
            self.after[before] = Some(after);
            self.before[after] = Some(before);
            any = true;
        }
        any
    }

    /// Returns true if the boundary is nearly unchanged without a node, and its target size does not need it.
    fn is_needless(&self, node: usize, cloud: &PointSet, sag: f64) -> bool {
        let (Some(before), Some(after)) = (self.before[node], self.after[node]) else { return false };
        let x = self.old.position;
        let size = cloud.size[node];
        let short = distance(&x[before], &x[node]).min(distance(&x[node], &x[after]));
        short < SHORT * size
            && before != after
            && self.after[after] != Some(before)
            && self.after[before].is_some()
            && self.before[after].is_some()
            && self.is_straight([before, after], x, sag * LONG * size)
            && [Some(x), self.rests.then_some(&*self.old.mesh.rest)]
                .iter()
                .flatten()
                .all(|x| self.is_straight([before, after], x, sag * distance(&x[before], &x[after])))
            && !self.is_inside_another([before, node, after], cloud)
    }

    /// Returns true if all old nodes of a stretch are within `sag`, m, of its chord.
    fn is_straight(&self, [from, to]: [usize; 2], x: &[PlanarPoint], sag: f64) -> bool {
        let chord = distance(&x[from], &x[to]);
        let mut node = self.first_after[from];
        while let Some(at) = node.filter(|&at| at != to) {
            if cross(&x[from], &x[to], &x[at]).abs() > sag * chord {
                return false;
            }
            node = self.first_after[at];
        }
        chord > 0.0
    }
}

impl NewBoundary {
    /// Projects new points by `cleared` where that is near: a chord of a wall that lies around a body crosses the body.
    fn clear(&mut self, cloud: &mut PointSet, held: &[[bool; 2]], cleared: ClearProjection<'_>) {
        let area = |edges: &[[usize; 2]], x: &[PlanarPoint]| -> f64 {
            edges.iter().map(|[a, b]| 0.5 * (x[*a][0] * x[*b][1] - x[*a][1] * x[*b][0])).sum()
        };
        let before = area(&self.edges, &cloud.position);
        for point in held.len()..cloud.position.len() {
            let mut there = cleared(&cloud.position[point]);
            for axis in 0..2 {
                if cloud.stays(point, axis, held) {
                    there[axis] = cloud.position[point][axis];
                }
            }
            if distance(&there, &cloud.position[point]) < NEAR * cloud.size[point] {
                cloud.position[point] = there;
            }
        }
        self.cleared = before - area(&self.edges, &cloud.position);
    }

    /// Adds a stretch of the old boundary, given by its nodes, as one edge or split evenly.
    fn take(&mut self, stretch: &[usize], cloud: &mut PointSet) {
        let [Some(&first), Some(&last)] = [stretch.first(), stretch.last()] else { return };
        let length = |[a, b]: [usize; 2], cloud: &PointSet| distance(&cloud.position[a], &cloud.position[b]);
        let sizes = [first, last].map(|n| cloud.size[n]);
        let size = 0.5 * (sizes[0] + sizes[1]);
        let edges = || stretch.windows(2).map(|w| [w[0], w[1]]);
        let whole: f64 = edges().map(|edge| length(edge, cloud)).sum();
        let parts = if whole <= LONG * size { 1 } else { (whole / size).round().max(2.0) as usize };
        if stretch.len() > 2 || parts > 1 {
            self.lost.extend(edges());
        }
        let (mut from, mut part, mut walked) = (first, 1, 0.0);
        for [a, b] in edges() {
            let along = length([a, b], cloud);
            while part < parts && walked + along >= whole * part as f64 / parts as f64 && along > 0.0 {
                let at = part as f64 / parts as f64;
                let share = (whole * at - walked) / along;
                let position = (1.0 - share) * cloud.position[a] + share * cloud.position[b];
                let ends = [a, b, b].map(|n| NodeId(n as u32));
                let origin = NodeOrigin::Surface(ends, [1.0 - share, share, 0.0]);
                let to = cloud.add(position, (1.0 - at) * sizes[0] + at * sizes[1], origin);
                self.edges.push([from, to]);
                (from, part) = (to, part + 1);
            }
            walked += along;
        }
        self.edges.push([from, last]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_meshes::{moved, rings, square};
    use super::super::{AcceptanceLimits, check_acceptance, plane::propose};
    use super::*;
    use crate::mesh::Mesh;

    #[test]
    fn edges_of_straight_sides_end_up_near_their_size() {
        let mesh = square(12);
        let position = moved(&mesh, |x| PlanarPoint::new(x[0].powi(3), x[1] + 0.4 * x[1] * (1.0 - x[1])));
        let old = DeformedMesh { mesh: &mesh, position: &position };
        for size in [0.03, 0.1, 0.2, 0.4] {
            let new = propose(&old, &vec![size; position.len()], &RemeshRules::default(), &|x| *x).unwrap();
            check_acceptance(&old, &new, &AcceptanceLimits { measure: 1e-12, quality: 0.3 }).unwrap();
            let mesh = Mesh::<2>::new(new.position, new.elements);
            for facet in &mesh.facets {
                let length = distance(&mesh.rest[facet[0].index()], &mesh.rest[facet[1].index()]);
                assert!(length > 0.999 * SHORT * size && length < 1.001 * LONG * size, "{length} for {size}");
            }
        }
    }

    #[test]
    fn no_node_is_left_out_across_another_wall() {
        // A wall with a dent, and a neighbouring wall with a held tip in the dent.
        let mut mesh = rings(2, 0.25);
        let (dent, tip) = (PlanarPoint::new(3.0, 1.5), PlanarPoint::new(4.0, 1.5));
        let mut position = moved(&mesh, |x| if x[0] > 3.5 { x - PlanarPoint::new(0.995, 0.0) } else { *x });
        for (n, x) in mesh.rest.iter().enumerate() {
            if *x == dent {
                position[n] = PlanarPoint::new(2.98, 1.5);
            } else if *x == tip {
                position[n] = PlanarPoint::new(2.99, 1.5);
                mesh.held[n] = [true; 2];
            }
        }
        let sizes = vec![1.2; position.len()];
        let proposed = |position: &[PlanarPoint]| {
            let old = DeformedMesh { mesh: &mesh, position };
            let new = propose(&old, &sizes, &RemeshRules::default(), &|x| *x).unwrap();
            check_acceptance(&old, &new, &AcceptanceLimits { measure: 0.01, quality: 0.0 }).unwrap();
            new.position.contains(&PlanarPoint::new(2.98, 1.5))
        };
        assert!(proposed(&position));
        // Without the tip the dent is filled.
        let apart: Vec<PlanarPoint> = position
            .iter()
            .map(|x| if x[0] > 2.985 && x[0] != 3.0 { x + PlanarPoint::new(0.5, 0.0) } else { *x })
            .collect();
        assert!(!proposed(&apart));
    }
}
