//! Surface criteria: where the surface is flat enough, now and at rest, to be made of other facets.

use super::edge_star::fan;
use super::limits::{FAIR, STANDING, cube};
use super::tet_mesh::{MeshOperation, TetMesh};
use super::volume_correction::VolumeCorrection;
use crate::math::Vector;

/// Limits for operations at the surface.
#[derive(Clone, Copy)]
pub(super) struct SurfaceCriteria<'a> {
    /// Greatest distance of a point from a new facet, in target lengths; 0 where the surface must stay.
    pub sag: f64,
    /// Greatest distance of a sliding point from its facets, in target lengths; 0 disables sliding.
    pub slide: f64,
    /// True if all facets within a held plane count as flat. It must be false for a two-network gel: otherwise the run of
    /// `bullet-yaw` with a yaw of 4° ends after 117 µs.
    pub planes: bool,
    /// Greatest total change of volume, and the change so far, m³.
    pub volume: f64,
    pub swept: f64,
    /// Projection out of bodies, for a two-network gel: no new facet may be deep in a body. In other gels facets may be 0.3
    /// of a size deep, and some of the remeshed ones around the body are.
    pub cleared: Option<&'a dyn Fn(&Vector<3>) -> Vector<3>>,
}

/// Part of the volume limit that one operation may use without returning it.
const LITTLE: f64 = 1e-3;
/// Least cosine between the normals of an old facet and its replacement.
const TURNED: f64 = 0.7;

type PointPosition<'a> = &'a dyn Fn(u32) -> Vector<3>;

impl SurfaceCriteria<'_> {
    /// Returns true if the two facets at an edge may be replaced by those at the other diagonal.
    pub fn can_flip_edge(&self, complex: &TetMesh, (a, b): (u32, u32), (first, last): (u32, u32)) -> bool {
        if self.planes && is_in_held_plane(complex, [a, b, first, last]) {
            return self.sag > 0.0;
        }
        let limit = self.limit(complex, a);
        self.holds_in_both_configurations(complex, &|at: PointPosition| {
            let [a, b, p, q] = [a, b, first, last].map(at);
            // The facets are (a, p, b) and (a, b, q); those of the other diagonal (a, p, q) and (p, b, q).
            let old = [(p - a).cross(&(b - a)), (b - a).cross(&(q - a))];
            let new = [(p - a).cross(&(q - a)), (b - p).cross(&(q - p))];
            let height = (b - a).cross(&(q - p));
            let rises = (p - a).dot(&height).abs() <= limit * height.norm();
            rises && new.iter().all(|n| old.iter().all(|o| is_along(n, o)))
        }) && self.stands_off(complex, (&[[a, b]], &[[first, last]]))
    }

    /// Returns true if new surface edges are no deeper in a body than points may stand, or than the edges they replace.
    /// Contact stops a deep facet where it is and pushes it out once it is split.
    fn stands_off(&self, complex: &TetMesh, (old, new): (&[[u32; 2]], &[[u32; 2]])) -> bool {
        let Some(cleared) = self.cleared else { return true };
        let depth = |[p, q]: &[u32; 2]| {
            let middle = (complex.x(*p) + complex.x(*q)) / 2.0;
            (cleared(&middle) - middle).norm()
        };
        let deepest = |edges: &[[u32; 2]]| edges.iter().map(depth).fold(0.0, f64::max);
        let size = |[p, _]: &[u32; 2]| complex.points[*p as usize].size;
        let least = new.iter().map(size).fold(f64::INFINITY, f64::min);
        let comes = deepest(new);
        comes <= STANDING * least || comes <= deepest(old)
    }

    /// Returns true if a surface point may be removed by collapsing its facets onto another one.
    pub fn can_collapse(&self, complex: &TetMesh, a: u32, b: u32) -> bool {
        let limit = self.limit(complex, a);
        let is_held = |[u, v]: &[u32; 2]| self.planes && is_in_held_plane(complex, [a, b, *u, *v]);
        let (held, fan): (Vec<[u32; 2]>, Vec<[u32; 2]>) = fan(complex, a).into_iter().partition(is_held);
        faces_as_before(complex, (a, b), &held)
            && self.holds_in_both_configurations(complex, &|at: PointPosition| {
                let [a_at, b_at] = [a, b].map(at);
                fan.iter().filter(|edge| !edge.contains(&b)).all(|&[u, v]| {
                    let [u, v] = [u, v].map(at);
                    let [old, new] = [a_at, b_at].map(|apex| twice_area(&apex, [&u, &v]));
                    is_along(&new, &old) && (a_at - b_at).dot(&new).abs() <= limit * new.norm()
                })
            })
            && self.stands_off(complex, (&spokes(&fan, (a, b)), &spokes(&fan, (b, b))))
    }

    /// Returns an operation of this quality with its volume change within limits: a small change is accepted, a larger
    /// one is returned at one of these points. `None` where none of them may move.
    pub fn correct_volume(
        &self,
        complex: &TetMesh,
        (worst, change): (f64, MeshOperation),
        (points, enough): (&[u32], f64),
    ) -> Option<(f64, MeshOperation)> {
        if change.swept.abs() <= LITTLE * self.volume && self.allows(change.swept) {
            return Some((worst, change));
        }
        let kept = points.iter().find_map(|point| {
            let most = self.limit(complex, *point);
            VolumeCorrection { most, enough, fair: cube(FAIR) }.kept(complex, &change, *point)
        });
        kept.or_else(|| self.allows(change.swept).then_some((worst, change)))
    }

    /// Returns true if the volume may change by `swept` more, m³.
    fn allows(&self, swept: f64) -> bool {
        (self.swept + swept).abs() <= self.volume
    }

    fn limit(&self, complex: &TetMesh, a: u32) -> f64 {
        self.sag * complex.points[a as usize].size
    }

    /// Returns true if a criterion holds for current and for rest positions.
    fn holds_in_both_configurations(&self, complex: &TetMesh, holds: &dyn Fn(PointPosition) -> bool) -> bool {
        let point = |p: u32| &complex.points[p as usize];
        self.sag > 0.0 && holds(&|p| point(p).x) && holds(&|p| point(p).rest)
    }
}

/// Edges from a point to the points of a fan, except for one.
fn spokes(fan: &[[u32; 2]], (apex, other): (u32, u32)) -> Vec<[u32; 2]> {
    fan.iter().flatten().filter(|p| **p != other).map(|p| [apex, *p]).collect()
}

/// Returns true if the points lie in a plane in which they are held: all facets between them are flat.
fn is_in_held_plane(complex: &TetMesh, points: [u32; 4]) -> bool {
    let [first, others @ ..] = points.map(|p| &complex.points[p as usize]);
    (0..3).any(|axis| first.held[axis] && others.iter().all(|p| p.held[axis] && p.x[axis] == first.x[axis]))
}

/// Returns true if the facets of a held plane keep their orientation when collapsed from one point to another, apart
/// from one that is inverted.
fn faces_as_before(complex: &TetMesh, (a, b): (u32, u32), fan: &[[u32; 2]]) -> bool {
    let facet = |apex: u32, [u, v]: &[u32; 2]| twice_area(complex.x(apex), [complex.x(*u), complex.x(*v)]);
    let before: Vector<3> = fan.iter().map(|edge| facet(a, edge)).sum();
    fan.iter().filter(|edge| !edge.contains(&b)).all(|edge| facet(b, edge).dot(&before) > 0.0)
}

/// Twice the area vector of a facet.
pub(super) fn twice_area(apex: &Vector<3>, [u, v]: [&Vector<3>; 2]) -> Vector<3> {
    (u - apex).cross(&(v - apex))
}

pub(super) fn is_along(n: &Vector<3>, other: &Vector<3>) -> bool {
    let along = n.dot(other);
    along > 0.0 && along * along >= TURNED * TURNED * n.norm_squared() * other.norm_squared()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, NodeId};
    use crate::remesh::DeformedMesh;

    /// A point among four of a plane, of which one is in a bay of the others; and one beside the plane.
    #[test]
    fn a_point_of_a_held_plane_is_spared_if_no_facet_is_turned_over_by_it_whether_one_was_or_not() {
        let points = |point: [f64; 2]| {
            let plane = [[0.0, 0.0], [1.0, 0.0], [0.3, 0.3], [0.0, 1.0], point];
            let plane = plane.map(|[y, z]| Vector::<3>::new(0.0, y, z));
            [plane.as_slice(), &[Vector::<3>::new(1.0, 0.2, 0.2)]].concat()
        };
        let elements = [0, 1, 2, 3].map(|k| [k, (k + 1) % 4, 4, 5].map(NodeId));
        let mut mesh = Mesh::<3>::new(points([0.1, 0.1]), elements.to_vec());
        let flat = SurfaceCriteria { sag: 0.06, slide: 0.0, planes: true, volume: 0.0, swept: 0.0, cleared: None };
        for (place, is_turned) in [([0.1, 0.1], false), ([0.1, -0.02], true)] {
            let position = points(place);
            for is_held in [true, false] {
                mesh.held = (0..6).map(|point| [is_held && point < 5, false, false]).collect();
                let complex = TetMesh::new(&DeformedMesh { mesh: &mesh, position: &position }, &[1.0; 6]);
                let can_collapse = |to: u32| flat.can_collapse(&complex, 4, to);
                assert_eq!((can_collapse(1), can_collapse(2)), (false, is_held || !is_turned), "{place:?} {is_held}");
            }
        }
    }

    /// Edge of two facets beneath a body, at a distance below their other diagonal, which is deep in it.
    #[test]
    fn no_facet_comes_that_is_deep_in_a_body_unless_one_as_deep_goes() {
        for (depth, below, stands_off) in [(0.05, 0.02, true), (0.07, 0.02, false), (0.07, -0.01, true)] {
            let points = [[0.0, 0.0, -below], [1.0, 1.0, -below], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, -1.0]];
            let position = points.map(Vector::<3>::from).to_vec();
            let elements = [[0, 3, 1, 4], [0, 1, 2, 4]].map(|nodes| nodes.map(NodeId)).to_vec();
            let mesh = Mesh::<3>::new(position.clone(), elements);
            let complex = TetMesh::new(&DeformedMesh { mesh: &mesh, position: &position }, &[1.0; 5]);
            let beneath = |x: &Vector<3>| Vector::<3>::new(x[0], x[1], x[2].min(-depth));
            let stays_clear: Option<&dyn Fn(&Vector<3>) -> Vector<3>> = Some(&beneath);
            let can_flip_edge =
                |cleared| {
                    SurfaceCriteria { sag: 0.06, slide: 0.0, planes: true, volume: 0.0, swept: 0.0, cleared }
                        .can_flip_edge(&complex, (0, 1), (2, 3))
                };
            assert_eq!((can_flip_edge(None), can_flip_edge(stays_clear)), (true, stands_off), "{depth} {below}");
        }
    }
}
