//! Improvement of a mesh of tetrahedra by local operations, until no element has a defect.

use super::limits::{EDGES, FAIR, GAIN, LONG, SHORT, STANDING, cube};
use super::surface_criteria::SurfaceCriteria;
use super::tet_mesh::{MeshOperation, TetDefect, TetMesh, Tetrahedron};
use super::{collapse, slide, sliver_removal, smooth, split, swap};
use crate::math::{Vector, ordered_sum};
use crate::mesh::{Mesh, signed_volume};
use crate::remesh::mesher::check;
use crate::remesh::{DeformedMesh, ProposedMesh, RemeshError, RemeshRules};

/// Part of the cubed limit quality that a split may leave, unless the quality was lower before: its results are
/// improved afterwards.
const SPLIT: f64 = 0.35;
/// Greatest relative change of the body's volume by surface operations that cannot return it: half the limit for a
/// second mesh of the same sizes.
const VOLUME: f64 = 5e-7;
/// Greatest number of passes.
const ROUNDS: usize = 6;

/// Proposes a mesh of a body in space with these target sizes, m, by node. The old mesh stays where it is good and of
/// these sizes.
///
/// The sizes should satisfy the growth limit of [`graded`](crate::remesh::graded). Kept nodes come first and in their old order, then points
/// of the old surface, then interior points; kept elements come first and in their old order, then new ones.
///
/// New surface points are projected by `cleared` if the elements around them stay good enough.
///
/// # Errors
/// [`RemeshError`] for invalid sizes or positions.
pub(in crate::remesh) fn propose(
    old: &DeformedMesh<'_, 3>,
    size: &[f64],
    rules: &RemeshRules,
    cleared: &dyn Fn(&Vector<3>) -> Vector<3>,
) -> Result<ProposedMesh<3>, RemeshError> {
    check(old, size, rules)?;
    // A two-network gel has no surface at rest that a new one must lie along: treat the current configuration as the rest
    // configuration.
    let flown = (!rules.rests).then(|| Mesh { rest: old.position.to_vec(), ..old.mesh.clone() });
    let old = &flown.as_ref().map_or(*old, |mesh| DeformedMesh { mesh, position: old.position });
    let (sag, slide, planes) = (rules.sag, rules.slide, rules.rests);
    let stays_clear = (!rules.rests).then_some(cleared);
    let flat = SurfaceCriteria { sag, slide, planes, volume: VOLUME * volume(old), swept: 0.0, cleared: stays_clear };
    let mut work = MeshImprover { complex: TetMesh::new(old, size), flat, poor: cube(rules.poor), cleared };
    work.run();
    Ok(work.complex.proposal())
}

/// Mesh improvement by local operations.
struct MeshImprover<'a> {
    complex: TetMesh,
    flat: SurfaceCriteria<'a>,
    /// Cubed quality that new tetrahedra must have.
    poor: f64,
    cleared: &'a dyn Fn(&Vector<3>) -> Vector<3>,
}

impl MeshImprover<'_> {
    fn run(&mut self) {
        for _ in 0..ROUNDS {
            let before = self.complex.len();
            self.process_defects(TetDefect::Long, Self::split_longest);
            self.process_defects(TetDefect::Short, Self::collapse_shortest);
            self.process_defects(TetDefect::Poor, Self::improve);
            self.clear_surface();
            if self.complex.len() == before {
                break;
            }
        }
    }

    /// Applies an operation to every tetrahedron with a defect, including those that it creates.
    fn process_defects(&mut self, fault: TetDefect, mut operate: impl FnMut(&mut Self, u32, Tetrahedron)) {
        let mut i = 0;
        while let Some(t) = self.complex.nth_defective(fault, i) {
            if let Some(tet) = self.complex.tet(t) {
                operate(self, t, tet);
            }
            i += 1;
        }
    }

    /// Edge of a tetrahedron whose squared length, in target lengths, comes first in an order, and that length.
    fn first_edge(&self, tet: &Tetrahedron, comes_before: fn(&f64, &f64) -> bool) -> (f64, (u32, u32)) {
        let of = |[i, j]: [usize; 2]| (self.complex.length(tet[i], tet[j]), (tet[i], tet[j]));
        EDGES[1..].iter().fold(of(EDGES[0]), |first, edge| {
            let next = of(*edge);
            if comes_before(&next.0, &first.0) { next } else { first }
        })
    }

    fn split_longest(&mut self, _: u32, tet: Tetrahedron) {
        let (length, edge) = self.first_edge(&tet, f64::gt);
        if length > LONG * LONG {
            let worst = self.worst_around(edge);
            let enough = worst.min(SPLIT * self.poor);
            split::split(&mut self.complex, edge, (enough, cube(FAIR)), self.cleared);
        }
    }

    fn collapse_shortest(&mut self, _: u32, tet: Tetrahedron) {
        let (length, edge) = self.first_edge(&tet, f64::lt);
        if length < SHORT * SHORT {
            self.collapse_edge(edge, self.poor);
        }
    }

    fn worst_around(&self, (a, b): (u32, u32)) -> f64 {
        self.complex.worst_of(self.complex.star(a).filter(|(_, tet)| tet.contains(&b)).map(|(t, _)| t))
    }

    /// Projects surface points out of bodies, unless the surface must stay.
    fn clear_surface(&mut self) {
        if self.flat.sag <= 0.0 {
            return;
        }
        for point in 0..self.complex.points.len() as u32 {
            let own = &self.complex.points[point as usize];
            let x = if own.is_on_surface { self.complex.project_to_free(point, (self.cleared)(&own.x)) } else { own.x };
            if (x - own.x).norm() > STANDING * own.size {
                smooth::clear(&mut self.complex, (point, x), cube(FAIR));
            }
        }
    }

    /// Collapses an edge to the better end, if the result is better than `enough`.
    fn collapse_edge(&mut self, (a, b): (u32, u32), enough: f64) -> bool {
        let ways = [(a, b), (b, a)].map(|way| collapse::collapse_onto(&self.complex, way, enough, &self.flat));
        self.take_best(ways.into_iter().flatten())
    }

    /// Improves a poor tetrahedron: by reconnection, by smoothing a point, or by collapsing an edge.
    fn improve(&mut self, t: u32, tet: Tetrahedron) {
        let shape = self.complex.shape(t);
        if shape >= cube(FAIR) {
            return;
        }
        let _ = self.reconnect(t, &tet)
            || self.smooth_points(&tet)
            || self.collapse_any_edge(&tet)
            || self.remove_sliver(t, &tet);
    }

    /// Removes a sliver at the surface, unless the surface must stay.
    fn remove_sliver(&mut self, t: u32, tet: &Tetrahedron) -> bool {
        let is_removable_sliver = self.flat.sag > 0.0 && sliver_removal::is_removable_sliver(&self.complex, (t, tet));
        if is_removable_sliver {
            self.complex.cut_off(t);
        }
        is_removable_sliver
    }

    fn reconnect(&mut self, t: u32, tet: &Tetrahedron) -> bool {
        let edges = EDGES.iter().filter_map(|[i, j]| {
            let edge = (tet[*i], tet[*j]);
            swap::remove_edge(&self.complex, edge, worthwhile_shape(self.worst_around(edge)), &self.flat)
        });
        let faces =
            (0..4).filter_map(|k| swap::flip_face(&self.complex, (t, k), worthwhile_shape(self.complex.shape(t))));
        let all: Vec<(f64, MeshOperation)> = edges.chain(faces).collect();
        self.take_best(all.into_iter())
    }

    fn smooth_points(&mut self, tet: &Tetrahedron) -> bool {
        let slides = self.flat.slide > 0.0;
        tet.iter().any(|point| {
            smooth::smooth(&mut self.complex, *point)
                || slides && slide::slide(&mut self.complex, *point, (&self.flat, self.cleared))
        })
    }

    fn collapse_any_edge(&mut self, tet: &Tetrahedron) -> bool {
        let ways = EDGES.iter().flat_map(|[i, j]| [(tet[*i], tet[*j]), (tet[*j], tet[*i])]);
        let all: Vec<(f64, MeshOperation)> = ways
            .filter_map(|(a, b)| {
                let own = self.complex.worst_of(self.complex.star(a).map(|(t, _)| t));
                collapse::collapse_onto(&self.complex, (a, b), worthwhile_shape(own), &self.flat)
            })
            .collect();
        self.take_best(all.into_iter())
    }

    /// Applies the best of the operations, if there is one.
    fn take_best(&mut self, ways: impl Iterator<Item = (f64, MeshOperation)>) -> bool {
        let best = ways.fold(None::<(f64, MeshOperation)>, |best, next| match best {
            Some(best) if best.0 >= next.0 => Some(best),
            _ => Some(next),
        });
        best.inspect(|(_, change)| {
            self.flat.swept += change.swept;
            self.complex.apply(change);
        })
        .is_some()
    }
}

fn volume(old: &DeformedMesh<'_, 3>) -> f64 {
    ordered_sum(old.mesh.elements.len(), 0.0, |e| signed_volume(old.position, &old.mesh.elements[e]))
}

/// Cubed quality above which an operation is worthwhile.
fn worthwhile_shape(shape: f64) -> f64 {
    GAIN * shape.max(0.0)
}
