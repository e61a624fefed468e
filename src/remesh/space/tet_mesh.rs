//! Editable tetrahedral mesh: points, tetrahedra, and the star of every point.

use super::limits::{EDGES, FAIR, LONG, SHORT, cube};
use crate::geometry::BoundingBox;
use crate::math::{CLOSE, Vector};
use crate::mesh::{ElementId, FACES, NodeId, Simplex};
use crate::remesh::{DeformedMesh, NodeOrigin, ProposedMesh, load_markers};

/// Tetrahedron by its points, positively oriented.
pub(super) type Tetrahedron = [u32; 4];

/// Point of the mesh.
#[derive(Debug, Clone)]
pub(super) struct MeshPoint {
    /// Current position, m.
    pub x: Vector<3>,
    /// Rest position, m; defined for surface points only.
    pub rest: Vector<3>,
    /// Target length of the surrounding edges, m.
    pub size: f64,
    /// Origin in the old mesh.
    pub origin: NodeOrigin,
    /// Held directions.
    pub held: [bool; 3],
    /// Loaded faces that end at the point: bit i for the i-th.
    pub ends: u8,
    pub is_on_surface: bool,
}

/// Defect of a tetrahedron; its causes do not change while the tetrahedron exists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TetDefect {
    /// Edge longer than [`LONG`].
    Long,
    /// Edge shorter than [`SHORT`].
    Short,
    /// Shape worse than [`FAIR`].
    Poor,
}

/// Mesh operation: tetrahedra removed and tetrahedra added.
#[derive(Debug, Clone, Default)]
pub(super) struct MeshOperation {
    pub gone: Vec<u32>,
    pub new: Vec<Tetrahedron>,
    /// Change of the body's volume by the motion of its surface, m³.
    pub swept: f64,
    /// Surface point to be moved afterwards, with its new position, m.
    pub moved: Option<(u32, Vector<3>)>,
}

/// Editable tetrahedral mesh. Indices of removed tetrahedra are not reused.
#[derive(Debug, Clone)]
pub(super) struct TetMesh {
    pub points: Vec<MeshPoint>,
    tets: Vec<Option<Tetrahedron>>,
    shapes: Vec<f64>,
    /// Tetrahedra with each defect, ascending; some are removed.
    faulty: [Vec<u32>; 3],
    stars: Vec<Vec<u32>>,
    /// Bounding boxes of the old tetrahedra.
    bounds: Vec<BoundingBox<3>>,
    /// Old tetrahedra that each may overlap, ascending; none for an old one itself.
    over: Vec<Option<Box<[u32]>>>,
    /// Loss of volume by moving new points out of bodies, m³.
    pub cleared: f64,
}

/// Cubed shape quality, 12³ · 9 V|V|/(Σl²)³: the same order without a root, hence the same bits on every platform.
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

impl TetMesh {
    /// Builds the mesh from a deformed old mesh with target sizes by node.
    pub fn new(old: &DeformedMesh<'_, 3>, size: &[f64]) -> Self {
        let ends = load_markers::ends(old.mesh);
        let point = |n: usize| MeshPoint {
            x: old.position[n],
            rest: old.mesh.rest[n],
            size: size[n],
            origin: NodeOrigin::Kept(NodeId(n as u32)),
            held: old.mesh.held[n],
            ends: ends.get(n).copied().unwrap_or(0),
            is_on_surface: false,
        };
        let n = old.position.len();
        let mut counts = vec![0; n];
        old.mesh.elements.iter().flatten().for_each(|node| counts[node.index()] += 1);
        let filled = |nodes: &Simplex| BoundingBox::around(nodes.iter().map(|node| &old.position[node.index()]));
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

    /// Number of tetrahedron indices used so far.
    pub fn len(&self) -> usize {
        self.tets.len()
    }

    /// Points of a tetrahedron, unless it is removed.
    pub fn tet(&self, t: u32) -> Option<Tetrahedron> {
        self.tets[t as usize]
    }

    /// The i-th tetrahedron with a defect, in order of appearance; it may be removed.
    pub fn nth_defective(&self, fault: TetDefect, i: usize) -> Option<u32> {
        self.faulty[fault as usize].get(i).copied()
    }

    /// Cubed quality of a tetrahedron.
    pub fn shape(&self, t: u32) -> f64 {
        self.shapes[t as usize]
    }

    /// Star of a point: its tetrahedra.
    pub fn star(&self, point: u32) -> impl Iterator<Item = (u32, Tetrahedron)> + Clone + '_ {
        self.stars[point as usize].iter().filter_map(|&t| Some((t, self.tet(t)?)))
    }

    /// Position of a point, m.
    pub fn x(&self, point: u32) -> &Vector<3> {
        &self.points[point as usize].x
    }

    /// Cubed quality of a tetrahedron that is not in the mesh.
    pub fn candidate_shape(&self, tet: &Tetrahedron) -> f64 {
        shape(tet.map(|point| self.x(point)))
    }

    /// Cubed quality of a tetrahedron with one of its points displaced.
    pub fn displaced_shape(&self, tet: &Tetrahedron, (point, x): (u32, &Vector<3>)) -> f64 {
        shape(tet.map(|p| if p == point { x } else { self.x(p) }))
    }

    /// Cubed quality of the worst of new tetrahedra; the search stops at `enough`.
    pub fn worst_new(&self, new: &[Tetrahedron], enough: f64) -> f64 {
        let mut worst = f64::INFINITY;
        for tet in new {
            worst = worst.min(self.candidate_shape(tet));
            if worst.is_nan() || worst <= enough {
                return f64::NEG_INFINITY;
            }
        }
        worst
    }

    /// Cubed quality of the worst of existing tetrahedra.
    pub fn worst_of(&self, tets: impl Iterator<Item = u32>) -> f64 {
        tets.map(|t| self.shape(t)).fold(f64::INFINITY, f64::min)
    }

    /// Change of volume if some tetrahedra are added and others removed, m³.
    pub fn growth(&self, new: &[Tetrahedron], gone: &[u32]) -> f64 {
        let volume = |tet: &Tetrahedron| {
            let [a, b, c, d] = tet.map(|point| self.x(point));
            (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
        };
        let old = gone.iter().filter_map(|t| self.tet(*t)).map(|tet| volume(&tet));
        new.iter().map(volume).sum::<f64>() - old.sum::<f64>()
    }

    /// Squared length of an edge over its target length.
    pub fn length(&self, a: u32, b: u32) -> f64 {
        let [a, b] = [a, b].map(|point| &self.points[point as usize]);
        let target = 0.5 * (a.size + b.size);
        (a.x - b.x).norm_squared() / (target * target)
    }

    /// Returns true if the squared length of an edge is beyond a limit; clear cases need no division.
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

    /// Applies a mesh operation.
    pub fn apply(&mut self, change: &MeshOperation) {
        let under = self.under(&change.gone);
        for &t in &change.gone {
            for point in self.tets[t as usize].take().into_iter().flatten() {
                self.stars[point as usize].retain(|&other| other != t);
            }
        }
        for tet in &change.new {
            let bounds = BoundingBox::around(tet.map(|point| *self.x(point)).iter());
            let own = under.iter().copied().filter(|old| self.bounds[*old as usize].meets(&bounds)).collect();
            self.add(*tet, Some(own));
        }
        if let Some((point, x)) = change.moved {
            self.move_point(point, x);
        }
    }

    /// Old tetrahedra that these may overlap.
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

    /// Adds a point without tetrahedra.
    pub fn add_point(&mut self, point: MeshPoint) -> u32 {
        self.points.push(point);
        self.stars.push(vec![]);
        self.points.len() as u32 - 1
    }

    /// Removes the last point, which has no tetrahedra.
    pub fn remove_last_point(&mut self) {
        self.points.pop();
        self.stars.pop();
    }

    /// Moves a point; its tetrahedra become new ones.
    pub fn move_point(&mut self, point: u32, x: Vector<3>) {
        let (gone, new): (Vec<u32>, Vec<Tetrahedron>) = self.star(point).unzip();
        let own = &mut self.points[point as usize];
        own.x = x;
        own.origin = match own.origin {
            _ if !own.is_on_surface => NodeOrigin::Inside,
            NodeOrigin::Kept(node) => NodeOrigin::Surface([node; 3], [1.0, 0.0, 0.0]),
            origin => origin,
        };
        self.apply(&MeshOperation { gone, new, ..MeshOperation::default() });
    }

    /// Moves a point along the surface and sets its origin.
    pub fn slide(&mut self, point: u32, (x, origin): (Vector<3>, NodeOrigin)) {
        self.move_point(point, x);
        self.points[point as usize].origin = origin;
    }

    /// Projects a target position onto the free directions of a point.
    pub fn project_to_free(&self, point: u32, x: Vector<3>) -> Vector<3> {
        let own = &self.points[point as usize];
        Vector::<3>::from_fn(|axis, _| if own.held[axis] { own.x[axis] } else { x[axis] })
    }

    /// Cubed quality of the worst tetrahedron around a point at `x`; the least value where the position is not allowed.
    pub fn worst_at(&self, point: u32, x: &Vector<3>) -> f64 {
        let shapes = self.star(point).map(|(_, tet)| self.displaced_shape(&tet, (point, x)));
        shapes.fold(f64::INFINITY, |worst, shape| if shape.is_nan() { f64::NEG_INFINITY } else { worst.min(shape) })
    }

    /// Volume of the tetrahedra around a point at `x`, m³.
    fn volume_around(&self, point: u32, x: &Vector<3>) -> f64 {
        let corner = |p: u32| if p == point { x } else { self.x(p) };
        let six = |[a, b, c, d]: [&Vector<3>; 4]| (b - a).cross(&(c - a)).dot(&(d - a));
        self.star(point).map(|(_, tet)| six(tet.map(corner))).sum::<f64>() / 6.0
    }

    /// Ratio of the volume around a point at `x` to the present volume.
    pub fn volume_ratio(&self, point: u32, x: &Vector<3>) -> f64 {
        self.volume_around(point, x) / self.volume_around(point, self.x(point))
    }

    /// Moves a surface point out of a body.
    pub fn clear(&mut self, point: u32, x: Vector<3>) {
        self.cleared += self.volume_around(point, self.x(point)) - self.volume_around(point, &x);
        self.move_point(point, x);
    }

    /// Removes a tetrahedron from the body.
    pub fn cut_off(&mut self, t: u32) {
        self.cleared -= self.growth(&[], &[t]);
        self.apply(&MeshOperation { gone: vec![t], ..MeshOperation::default() });
    }

    fn add(&mut self, tet: Tetrahedron, over: Option<Box<[u32]>>) {
        let t = self.tets.len() as u32;
        for point in tet {
            self.stars[point as usize].push(t);
        }
        let shape = self.candidate_shape(&tet);
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

    /// Proposes the mesh: kept nodes in their old order, then surface points, then interior points; kept elements in
    /// their old order, then new ones.
    pub fn proposal(&self) -> ProposedMesh<3> {
        let rank = |p: &u32| match self.points[*p as usize].origin {
            NodeOrigin::Kept(_) => 0,
            NodeOrigin::Surface(..) => 1,
            NodeOrigin::Inside => 2,
        };
        let mut used: Vec<u32> =
            (0..self.points.len() as u32).filter(|p| !self.stars[*p as usize].is_empty()).collect();
        used.sort_by_key(rank);
        let mut number = vec![NodeId::default(); self.points.len()];
        used.iter().zip(0..).for_each(|(&point, n)| number[point as usize] = NodeId(n));
        ProposedMesh {
            position: used.iter().map(|&point| *self.x(point)).collect(),
            origin: used.iter().map(|&point| self.points[point as usize].origin).collect(),
            elements: self.tets.iter().flatten().map(|tet| tet.map(|point| number[point as usize])).collect(),
            over: self.alive().map(|t| self.over[t].iter().flatten().map(|e| ElementId(*e)).collect()).collect(),
            cleared: self.cleared,
        }
    }
}

/// Gradient of the volume of a tetrahedron with respect to one of its points, m².
pub(super) fn gradient(complex: &TetMesh, tet: &Tetrahedron, point: u32) -> Vector<3> {
    let Some(k) = tet.iter().position(|p| *p == point) else { return Vector::<3>::zeros() };
    let [a, b, c] = FACES[k].map(|corner| complex.x(tet[corner]));
    (b - a).cross(&(c - a)) / -6.0
}
