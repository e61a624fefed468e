//! Tetrahedra that are changed one operation after the other: points, tetrahedra, and the star of every point.

use super::{EDGES, FAIR, LONG, SHORT, cube};
use crate::math::{CLOSE, Vector};
use crate::mesh::{ElementId, FACES, NodeId, Simplex};
use crate::remesh::bounds::Bounds;
use crate::remesh::{Moved, Origin, Proposal, load_markers};

/// A tetrahedron by its points, positively oriented.
pub(super) type Tet = [u32; 4];

/// A point.
#[derive(Debug, Clone)]
pub(super) struct Point {
    /// Where it is, m.
    pub x: Vector<3>,
    /// Where it was at rest, m; said of points of the surface only.
    pub rest: Vector<3>,
    /// Target length of the edges around it, m.
    pub size: f64,
    /// Where it comes from.
    pub origin: Origin,
    /// Which of its directions are held.
    pub held: [bool; 3],
    /// The loaded faces whose edge it is on: bit i for the i-th.
    pub ends: u8,
    pub is_on_surface: bool,
}

/// What may be wrong with a tetrahedron. Nothing that it follows from changes while there is the tetrahedron.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fault {
    /// An edge longer than [`LONG`].
    Long,
    /// An edge shorter than [`SHORT`].
    Short,
    /// A shape worse than [`FAIR`].
    Poor,
}

/// An operation: these tetrahedra go, those come.
#[derive(Debug, Clone, Default)]
pub(super) struct Change {
    pub gone: Vec<u32>,
    pub new: Vec<Tet>,
    /// What the volume of the body changes by where its surface moves, m³.
    pub swept: f64,
    /// A point of the surface that goes there after it, m.
    pub moved: Option<(u32, Vector<3>)>,
}

/// A complex of tetrahedra. The numbers of those that are gone are not used again.
#[derive(Debug, Clone)]
pub(super) struct Complex {
    pub points: Vec<Point>,
    tets: Vec<Option<Tet>>,
    shapes: Vec<f64>,
    /// The tetrahedra with each fault, ascending; some are gone.
    faulty: [Vec<u32>; 3],
    stars: Vec<Vec<u32>>,
    /// What the old ones fill.
    bounds: Vec<Bounds<3>>,
    /// The old ones that each can lie over, ascending; nothing for an old one itself.
    over: Vec<Option<Box<[u32]>>>,
    /// What the volume is less by because new points were put clear of bodies, m³.
    pub cleared: f64,
}

/// The cube of the shape quality, 12³ · 9 V|V|/(Σl²)³: the same order without a root, so the same bits on every platform.
pub(super) fn shape(corners: [&Vector<3>; 4]) -> f64 {
    let [a, b, c, d] = corners;
    let (u, v, w) = (b - a, c - a, d - a);
    let six = u.cross(&v).dot(&w);
    let squares = u.norm_squared()
        + v.norm_squared()
        + w.norm_squared()
        + (c - b).norm_squared()
        + (d - b).norm_squared()
        + (d - c).norm_squared();
    432.0 * six * six.abs() / (squares * squares * squares)
}

impl Complex {
    /// Of an old mesh where it is, with these target sizes by node.
    pub fn new(old: &Moved<'_, 3>, size: &[f64]) -> Self {
        let ends = load_markers::ends(old.mesh);
        let point = |n: usize| Point {
            x: old.position[n],
            rest: old.mesh.rest[n],
            size: size[n],
            origin: Origin::Kept(NodeId(n as u32)),
            held: old.mesh.held[n],
            ends: ends.get(n).copied().unwrap_or(0),
            is_on_surface: false,
        };
        let n = old.position.len();
        let mut counts = vec![0; n];
        old.mesh.elements.iter().flatten().for_each(|node| counts[node.index()] += 1);
        let filled = |nodes: &Simplex| Bounds::around(nodes.iter().map(|node| &old.position[node.index()]));
        let mut complex = Self {
            points: (0..n).map(point).collect(),
            tets: vec![],
            shapes: vec![],
            faulty: [vec![], vec![], vec![]],
            stars: counts.into_iter().map(Vec::with_capacity).collect(),
            bounds: old.mesh.elements.iter().map(filled).collect(),
            over: vec![],
            cleared: 0.0,
        };
        old.mesh.facets.iter().flatten().for_each(|node| complex.points[node.index()].is_on_surface = true);
        old.mesh.elements.iter().for_each(|nodes| complex.add(nodes.map(|node| node.0), None));
        complex
    }

    /// How many numbers of tetrahedra are in use or were.
    pub fn len(&self) -> usize {
        self.tets.len()
    }

    /// A tetrahedron, unless it is gone.
    pub fn tet(&self, t: u32) -> Option<Tet> {
        self.tets[t as usize]
    }

    /// The i-th tetrahedron with a fault, in the order in which they came; it may be gone.
    pub fn with(&self, fault: Fault, i: usize) -> Option<u32> {
        self.faulty[fault as usize].get(i).copied()
    }

    /// The cube of its quality.
    pub fn shape(&self, t: u32) -> f64 {
        self.shapes[t as usize]
    }

    /// The tetrahedra of a point.
    pub fn star(&self, point: u32) -> impl Iterator<Item = (u32, Tet)> + Clone + '_ {
        self.stars[point as usize].iter().filter_map(|&t| Some((t, self.tet(t)?)))
    }

    pub fn x(&self, point: u32) -> &Vector<3> {
        &self.points[point as usize].x
    }

    /// The cube of the quality that a tetrahedron would have.
    pub fn would_be(&self, tet: &Tet) -> f64 {
        shape(tet.map(|point| self.x(point)))
    }

    /// That with one of its points elsewhere.
    pub fn would_be_with(&self, tet: &Tet, (point, x): (u32, &Vector<3>)) -> f64 {
        shape(tet.map(|p| if p == point { x } else { self.x(p) }))
    }

    /// That of the worst one of some new ones; at most `enough` is looked for.
    pub fn worst_new(&self, new: &[Tet], enough: f64) -> f64 {
        let mut worst = f64::INFINITY;
        for tet in new {
            worst = worst.min(self.would_be(tet));
            if worst.is_nan() || worst <= enough {
                return f64::NEG_INFINITY;
            }
        }
        worst
    }

    /// That of the worst one of those there are.
    pub fn worst_of(&self, tets: impl Iterator<Item = u32>) -> f64 {
        tets.map(|t| self.shape(t)).fold(f64::INFINITY, f64::min)
    }

    /// What the volume changes by if some come and others go, m³.
    pub fn growth(&self, new: &[Tet], gone: &[u32]) -> f64 {
        let volume = |tet: &Tet| {
            let [a, b, c, d] = tet.map(|point| self.x(point));
            (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
        };
        let old = gone.iter().filter_map(|t| self.tet(*t)).map(|tet| volume(&tet));
        new.iter().map(volume).sum::<f64>() - old.sum::<f64>()
    }

    /// Length of an edge over its target length, squared.
    pub fn length(&self, a: u32, b: u32) -> f64 {
        let [a, b] = [a, b].map(|point| &self.points[point as usize]);
        let target = 0.5 * (a.size + b.size);
        (a.x - b.x).norm_squared() / (target * target)
    }

    /// Whether that is beyond a limit on this side. What clearly is or is not is known without a division.
    fn is_beyond(&self, (a, b): (u32, u32), limit: f64, beyond: fn(&f64, &f64) -> bool) -> bool {
        let [from, to] = [a, b].map(|point| &self.points[point as usize]);
        let target = 0.5 * (from.size + to.size);
        let (square, limited) = ((from.x - to.x).norm_squared(), limit * (target * target));
        if (square - limited).abs() > CLOSE * limited {
            beyond(&square, &limited)
        } else {
            beyond(&self.length(a, b), &limit)
        }
    }

    pub fn apply(&mut self, change: &Change) {
        let under = self.under(&change.gone);
        for &t in &change.gone {
            for point in self.tets[t as usize].take().into_iter().flatten() {
                self.stars[point as usize].retain(|&other| other != t);
            }
        }
        for tet in &change.new {
            let bounds = Bounds::around(tet.map(|point| *self.x(point)).iter());
            let own = under.iter().copied().filter(|old| self.bounds[*old as usize].meets(&bounds)).collect();
            self.add(*tet, Some(own));
        }
        if let Some((point, x)) = change.moved {
            self.shift(point, x);
        }
    }

    /// The old ones that these lie over.
    fn under(&self, tets: &[u32]) -> Vec<u32> {
        let mut all = vec![];
        for t in tets {
            match &self.over[*t as usize] {
                Some(over) => all.extend_from_slice(over),
                None => all.push(*t),
            }
        }
        all.sort_unstable();
        all.dedup();
        all
    }

    fn alive(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.tets.len()).filter(|t| self.tets[*t].is_some())
    }

    /// A new point, not yet in any tetrahedron.
    pub fn add_point(&mut self, point: Point) -> u32 {
        self.points.push(point);
        self.stars.push(vec![]);
        self.points.len() as u32 - 1
    }

    /// Takes back the last new point, which is in no tetrahedron.
    pub fn drop_point(&mut self) {
        self.points.pop();
        self.stars.pop();
    }

    /// Moves a point; its tetrahedra are new ones then.
    pub fn shift(&mut self, point: u32, x: Vector<3>) {
        let (gone, new): (Vec<u32>, Vec<Tet>) = self.star(point).unzip();
        let own = &mut self.points[point as usize];
        own.x = x;
        own.origin = match own.origin {
            _ if !own.is_on_surface => Origin::Inside,
            Origin::Kept(node) => Origin::Surface([node; 3], [1.0, 0.0, 0.0]),
            origin => origin,
        };
        self.apply(&Change { gone, new, ..Change::default() });
    }

    /// Moves a point along the surface, to where that is said to be made of.
    pub fn slide(&mut self, point: u32, (x, origin): (Vector<3>, Origin)) {
        self.shift(point, x);
        self.points[point as usize].origin = origin;
    }

    /// The place nearest to `x` that a point may go to from where it is: nowhere in its held directions.
    pub fn allowed(&self, point: u32, x: Vector<3>) -> Vector<3> {
        let own = &self.points[point as usize];
        Vector::<3>::from_fn(|axis, _| if own.held[axis] { own.x[axis] } else { x[axis] })
    }

    /// The cube of the quality of the worst tetrahedron around a point, were it there; less than any other where that is no place.
    pub fn worst_at(&self, point: u32, x: &Vector<3>) -> f64 {
        let shapes = self.star(point).map(|(_, tet)| self.would_be_with(&tet, (point, x)));
        shapes.fold(f64::INFINITY, |worst, shape| if shape.is_nan() { f64::NEG_INFINITY } else { worst.min(shape) })
    }

    /// Volume of the tetrahedra around a point, were it there, m³.
    fn volume_around(&self, point: u32, x: &Vector<3>) -> f64 {
        let corner = |p: u32| if p == point { x } else { self.x(p) };
        let six = |[a, b, c, d]: [&Vector<3>; 4]| (b - a).cross(&(c - a)).dot(&(d - a));
        self.star(point).map(|(_, tet)| six(tet.map(corner))).sum::<f64>() / 6.0
    }

    /// The part of their volume that the tetrahedra around a point would keep.
    pub fn squeeze(&self, point: u32, x: &Vector<3>) -> f64 {
        self.volume_around(point, x) / self.volume_around(point, self.x(point))
    }

    /// Moves a point of the surface out of a body.
    pub fn clear(&mut self, point: u32, x: Vector<3>) {
        self.cleared += self.volume_around(point, self.x(point)) - self.volume_around(point, &x);
        self.shift(point, x);
    }

    /// Cuts a tetrahedron off the body.
    pub fn cut_off(&mut self, t: u32) {
        self.cleared -= self.growth(&[], &[t]);
        self.apply(&Change { gone: vec![t], ..Change::default() });
    }

    fn add(&mut self, tet: Tet, over: Option<Box<[u32]>>) {
        let t = self.tets.len() as u32;
        for point in tet {
            self.stars[point as usize].push(t);
        }
        let shape = self.would_be(&tet);
        let (mut is_long, mut is_short) = (false, false);
        for [i, j] in EDGES {
            is_long |= self.is_beyond((tet[i], tet[j]), LONG * LONG, f64::gt);
            is_short |= self.is_beyond((tet[i], tet[j]), SHORT * SHORT, f64::lt);
        }
        let is_faulty = [is_long, is_short, shape < cube(FAIR)];
        for (faulty, _) in self.faulty.iter_mut().zip(is_faulty).filter(|(_, is_faulty)| *is_faulty) {
            faulty.push(t);
        }
        self.shapes.push(shape);
        self.tets.push(Some(tet));
        self.over.push(over);
    }

    /// The mesh: kept nodes in their old order, then points of the surface, then those inside; kept elements in their old
    /// order, then new ones.
    pub fn proposal(&self) -> Proposal<3> {
        let rank = |p: &u32| match self.points[*p as usize].origin {
            Origin::Kept(_) => 0,
            Origin::Surface(..) => 1,
            Origin::Inside => 2,
        };
        let mut used: Vec<u32> =
            (0..self.points.len() as u32).filter(|p| !self.stars[*p as usize].is_empty()).collect();
        used.sort_by_key(rank);
        let mut number = vec![NodeId::default(); self.points.len()];
        used.iter().zip(0..).for_each(|(&point, n)| number[point as usize] = NodeId(n));
        Proposal {
            position: used.iter().map(|&point| *self.x(point)).collect(),
            origin: used.iter().map(|&point| self.points[point as usize].origin).collect(),
            elements: self.tets.iter().flatten().map(|tet| tet.map(|point| number[point as usize])).collect(),
            over: self.alive().map(|t| self.over[t].iter().flatten().map(|e| ElementId(*e)).collect()).collect(),
            cleared: self.cleared,
        }
    }
}

/// What the volume of a tetrahedron changes by with the place of a point of it, m².
pub(super) fn gradient(complex: &Complex, tet: &Tet, point: u32) -> Vector<3> {
    let Some(k) = tet.iter().position(|p| *p == point) else { return Vector::<3>::zeros() };
    let [a, b, c] = FACES[k].map(|corner| complex.x(tet[corner]));
    (b - a).cross(&(c - a)) / -6.0
}
