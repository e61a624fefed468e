//! A new mesh of a body in space, by operations on the old one: long edges are split, short ones drawn together, and what is
//! badly shaped is joined anew, moved or drawn together.
//!
//! Every operation leaves a mesh of the same body, so that nothing can be welded or torn and no boundary has to be found again;
//! what is good is not touched and keeps its bits. The surface changes only where it is flat, now and at rest, to within
//! [`Rules::sag`] of a target length.

mod collapse;
mod edge_star;
mod slide;
mod sliver_removal;
mod smooth;
mod split;
mod surface_criteria;
mod swap;
#[cfg(test)]
mod test_shapes;
#[cfg(test)]
mod tests;
mod tet_mesh;
mod volume_correction;

use super::{Moved, Proposal, Rules};
use crate::math::{Vector, ordered_sum};
use crate::mesh::signed_volume;
use surface_criteria::Flat;
use tet_mesh::{Change, Complex, Fault, Tet};

/// The edges of a tetrahedron.
const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
/// Edges longer than this in target lengths are split: the diagonal of a cube of Kuhn's lattice has 1.73.
const LONG: f64 = 1.8;
/// Edges shorter than this are drawn together: where the centred lattice meets its boundary they have 0.5.
const SHORT: f64 = 0.45;
/// Tetrahedra of less quality than this are made better. Those of the centred lattice have 0.8; the more are changed, the more is
/// lost with them: a ball of 20 m/s at R/2 lost 3.5 % of its energy in 3 ms with 0.5 (11 meshes), 1.6 % with 0.35 (16).
const FAIR: f64 = 0.35;
/// A split may leave this part of the cube of the poor quality, or what there was: what it leaves is improved after it.
const SPLIT: f64 = 0.35;
/// What an operation must gain in the cube of the quality to be worth it.
const GAIN: f64 = 1.02;
/// What the volume of the body may change by, as a part of it, where its surface is made of other facets and cannot give it back:
/// half of what a second mesh of the same sizes may.
const VOLUME: f64 = 5e-7;
/// Points of the surface may stand so deep in a body, in target lengths: twice what contact leaves standing, of a gel that flows just that.
const STANDING: f64 = 0.06;
/// Times that all is gone through at most.
const ROUNDS: usize = 6;

/// A new mesh of a body in space with these target sizes, m, by node. Where the old mesh is good and has these sizes it stays.
/// New points of the surface are put where `cleared` says, if the tetrahedra around them bear it.
pub(super) fn propose(
    old: &Moved<'_, 3>,
    size: &[f64],
    rules: &Rules,
    cleared: &dyn Fn(&Vector<3>) -> Vector<3>,
) -> Proposal<3> {
    let (sag, slide, planes) = (rules.sag, rules.slide, rules.rests);
    let stays_clear = (!rules.rests).then_some(cleared);
    let flat = Flat { sag, slide, planes, volume: VOLUME * volume(old), swept: 0.0, cleared: stays_clear };
    let mut work = Work { complex: Complex::new(old, size), flat, poor: cube(rules.poor), cleared };
    work.run();
    work.complex.proposal()
}

struct Work<'a> {
    complex: Complex,
    flat: Flat<'a>,
    /// The cube of the quality that new tetrahedra must have.
    poor: f64,
    cleared: &'a dyn Fn(&Vector<3>) -> Vector<3>,
}

impl Work<'_> {
    fn run(&mut self) {
        for _ in 0..ROUNDS {
            let before = self.complex.len();
            self.sweep(Fault::Long, Self::split_longest);
            self.sweep(Fault::Short, Self::draw_shortest);
            self.sweep(Fault::Poor, Self::improve);
            self.clear_surface();
            if self.complex.len() == before {
                break;
            }
        }
    }

    /// Does this to every tetrahedron with a fault, and to those that come meanwhile.
    fn sweep(&mut self, fault: Fault, mut operate: impl FnMut(&mut Self, u32, Tet)) {
        let mut i = 0;
        while let Some(t) = self.complex.with(fault, i) {
            if let Some(tet) = self.complex.tet(t) {
                operate(self, t, tet);
            }
            i += 1;
        }
    }

    /// The edge of a tetrahedron whose length in target lengths, squared, comes first in this order, and that.
    fn first_edge(&self, tet: &Tet, comes_before: fn(&f64, &f64) -> bool) -> (f64, (u32, u32)) {
        let of = |[i, j]: [usize; 2]| (self.complex.length(tet[i], tet[j]), (tet[i], tet[j]));
        EDGES[1..].iter().fold(of(EDGES[0]), |first, edge| {
            let next = of(*edge);
            if comes_before(&next.0, &first.0) { next } else { first }
        })
    }

    fn split_longest(&mut self, _: u32, tet: Tet) {
        let (length, edge) = self.first_edge(&tet, f64::gt);
        if length > LONG * LONG {
            let worst = self.worst_around(edge);
            let enough = worst.min(SPLIT * self.poor);
            split::split(&mut self.complex, edge, (enough, cube(FAIR)), self.cleared);
        }
    }

    fn draw_shortest(&mut self, _: u32, tet: Tet) {
        let (length, edge) = self.first_edge(&tet, f64::lt);
        if length < SHORT * SHORT {
            self.draw(edge, self.poor);
        }
    }

    fn worst_around(&self, (a, b): (u32, u32)) -> f64 {
        self.complex.worst_of(self.complex.star(a).filter(|(_, tet)| tet.contains(&b)).map(|(t, _)| t))
    }

    /// Puts points of the surface that are inside a body out of it, unless the surface is to stay as it is.
    fn clear_surface(&mut self) {
        if self.flat.sag <= 0.0 {
            return;
        }
        for point in 0..self.complex.points.len() as u32 {
            let own = &self.complex.points[point as usize];
            let x = if own.is_on_surface { self.complex.allowed(point, (self.cleared)(&own.x)) } else { own.x };
            if (x - own.x).norm() > STANDING * own.size {
                smooth::clear(&mut self.complex, (point, x), cube(FAIR));
            }
        }
    }

    /// Draws an edge together to the better end, if what comes is better than `enough`.
    fn draw(&mut self, (a, b): (u32, u32), enough: f64) -> bool {
        let ways = [(a, b), (b, a)].map(|way| collapse::onto(&self.complex, way, enough, &self.flat));
        self.take_best(ways.into_iter().flatten())
    }

    /// Makes a bad tetrahedron better: by other edges and faces, by moving a point, by drawing an edge together.
    fn improve(&mut self, t: u32, tet: Tet) {
        let shape = self.complex.shape(t);
        if shape >= cube(FAIR) {
            return;
        }
        let _ = self.join_anew(t, &tet) || self.shift(&tet) || self.draw_any(&tet) || self.pare(t, &tet);
    }

    /// Cuts off what is flat at the surface, unless that is to stay as it is.
    fn pare(&mut self, t: u32, tet: &Tet) -> bool {
        let is_flat = self.flat.sag > 0.0 && sliver_removal::is_flat(&self.complex, (t, tet));
        if is_flat {
            self.complex.cut_off(t);
        }
        is_flat
    }

    fn join_anew(&mut self, t: u32, tet: &Tet) -> bool {
        let edges = EDGES.iter().filter_map(|[i, j]| {
            let edge = (tet[*i], tet[*j]);
            swap::without_edge(&self.complex, edge, better(self.worst_around(edge)), &self.flat)
        });
        let faces = (0..4).filter_map(|k| swap::without_face(&self.complex, (t, k), better(self.complex.shape(t))));
        let all: Vec<(f64, Change)> = edges.chain(faces).collect();
        self.take_best(all.into_iter())
    }

    fn shift(&mut self, tet: &Tet) -> bool {
        let slides = self.flat.slide > 0.0;
        tet.iter().any(|point| {
            smooth::smooth(&mut self.complex, *point)
                || slides && slide::slide(&mut self.complex, *point, (&self.flat, self.cleared))
        })
    }

    fn draw_any(&mut self, tet: &Tet) -> bool {
        let ways = EDGES.iter().flat_map(|[i, j]| [(tet[*i], tet[*j]), (tet[*j], tet[*i])]);
        let all: Vec<(f64, Change)> = ways
            .filter_map(|(a, b)| {
                let own = self.complex.worst_of(self.complex.star(a).map(|(t, _)| t));
                collapse::onto(&self.complex, (a, b), better(own), &self.flat)
            })
            .collect();
        self.take_best(all.into_iter())
    }

    fn take_best(&mut self, ways: impl Iterator<Item = (f64, Change)>) -> bool {
        let best = ways.fold(None::<(f64, Change)>, |best, next| match best {
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

fn volume(old: &Moved<'_, 3>) -> f64 {
    ordered_sum(old.mesh.elements.len(), 0.0, |e| signed_volume(old.position, &old.mesh.elements[e]))
}

/// The cube of the quality above which an operation is worth it.
fn better(shape: f64) -> f64 {
    GAIN * shape.max(0.0)
}

fn cube(quality: f64) -> f64 {
    quality * quality * quality
}
