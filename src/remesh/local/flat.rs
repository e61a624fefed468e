//! Where the surface is flat enough to be made of other facets, now and at rest.

use super::complex::{Change, Complex};
use super::level::Level;
use super::ring::fan;
use super::{FAIR, cube};
use crate::algebra::Vector;

/// How flat is flat.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flat {
    /// How far a point may be from a new facet, in target lengths; 0 where the surface must stay as it is.
    pub sag: f64,
    /// How far a point that slides along the surface may come off its facets, in target lengths; 0 where none slides.
    pub slide: f64,
    /// What the volume may change by in all, and has changed by, m³.
    pub volume: f64,
    pub swept: f64,
}

/// The part of what the volume may change by that one operation may take without giving it back.
const LITTLE: f64 = 1e-3;
/// The least cosine between the normals of an old facet and the new one in its place.
const TURNED: f64 = 0.7;

type Place<'a> = &'a dyn Fn(u32) -> Vector<3>;

impl Flat {
    /// Whether the facets on both sides of an edge may be those on both sides of the other diagonal.
    pub fn turns(&self, complex: &Complex, (a, b): (u32, u32), (first, last): (u32, u32)) -> bool {
        if is_in_held_plane(complex, [a, b, first, last]) {
            return self.sag > 0.0;
        }
        let limit = self.limit(complex, a);
        self.both(complex, &|at: Place| {
            let [a, b, p, q] = [a, b, first, last].map(at);
            // The facets are (a, p, b) and (a, b, q); those of the other diagonal (a, p, q) and (p, b, q).
            let old = [(p - a).cross(&(b - a)), (b - a).cross(&(q - a))];
            let new = [(p - a).cross(&(q - a)), (b - p).cross(&(q - p))];
            let height = (b - a).cross(&(q - p));
            let rises = (p - a).dot(&height).abs() <= limit * height.norm();
            rises && new.iter().all(|n| old.iter().all(|o| is_along(n, o)))
        })
    }

    /// Whether a point of the surface may be left out, its facets drawn to another one.
    pub fn spares(&self, complex: &Complex, a: u32, b: u32) -> bool {
        let limit = self.limit(complex, a);
        let bends = |[u, v]: &[u32; 2]| !is_in_held_plane(complex, [a, b, *u, *v]);
        let fan: Vec<[u32; 2]> = fan(complex, a).into_iter().filter(bends).collect();
        self.both(complex, &|at: Place| {
            let [a_at, b_at] = [a, b].map(at);
            fan.iter().filter(|edge| !edge.contains(&b)).all(|&[u, v]| {
                let [u, v] = [u, v].map(at);
                let [old, new] = [a_at, b_at].map(|apex| (u - apex).cross(&(v - apex)));
                is_along(&new, &old) && (a_at - b_at).dot(&new).abs() <= limit * new.norm()
            })
        })
    }

    /// A change of this quality with the volume that there was: a little may be lost, and what is more is given back at one of
    /// these points. With what it is then; `None` where none of them may go there.
    pub fn level(
        &self,
        complex: &Complex,
        (worst, change): (f64, Change),
        (points, enough): (&[u32], f64),
    ) -> Option<(f64, Change)> {
        if change.swept.abs() <= LITTLE * self.volume && self.allows(change.swept) {
            return Some((worst, change));
        }
        let kept = points.iter().find_map(|point| {
            let most = self.limit(complex, *point);
            Level { most, enough, fair: cube(FAIR) }.kept(complex, &change, *point)
        });
        kept.or_else(|| self.allows(change.swept).then_some((worst, change)))
    }

    /// Whether the volume may change by so much more, m³.
    fn allows(&self, swept: f64) -> bool {
        (self.swept + swept).abs() <= self.volume
    }

    fn limit(&self, complex: &Complex, a: u32) -> f64 {
        self.sag * complex.points[a as usize].size
    }

    /// Whether this holds where the points are and where they were at rest.
    fn both(&self, complex: &Complex, holds: &dyn Fn(Place) -> bool) -> bool {
        let point = |p: u32| &complex.points[p as usize];
        self.sag > 0.0 && holds(&|p| point(p).x) && holds(&|p| point(p).rest)
    }
}

/// Whether these points are held in a plane that they are in: facets between them are flat, whichever these are.
fn is_in_held_plane(complex: &Complex, points: [u32; 4]) -> bool {
    let [first, others @ ..] = points.map(|p| &complex.points[p as usize]);
    (0..3).any(|axis| first.held[axis] && others.iter().all(|p| p.held[axis] && p.x[axis] == first.x[axis]))
}

pub(super) fn is_along(n: &Vector<3>, other: &Vector<3>) -> bool {
    let along = n.dot(other);
    along > 0.0 && along * along >= TURNED * TURNED * n.norm_squared() * other.norm_squared()
}
