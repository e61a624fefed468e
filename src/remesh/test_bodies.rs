//! Test bodies for remeshing.

use super::*;
use crate::math::Vector;
use crate::mesh::{CellSplit, Facet, Mesh, NodeId, RectilinearGrid, Simplex, signed_volume};

/// Deterministic random numbers from 0 to 1.
pub(super) struct TestRandom(u64);

impl TestRandom {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Jittered grid: inner nodes are displaced by up to a quarter of a cell, every cell is cut along a diagonal of its
/// own. In space the displacement is an eighth, so that no element is inverted, and cells are cut into Kuhn's six
/// tetrahedra.
fn grid<const D: usize>(
    planes: &[Vec<f64>; D],
    jitter: f64,
    random: &mut TestRandom,
) -> (Vec<Vector<D>>, Vec<Simplex>) {
    if D == 2 {
        return flat_grid(planes, jitter, random);
    }
    let whole = RectilinearGrid { planes: planes.clone(), filled: Box::new(|_| true) };
    let (mut points, elements) = whole.split(CellSplit::Kuhn);
    for point in &mut points {
        let at: [usize; D] = std::array::from_fn(|axis| planes[axis].iter().position(|p| *p == point[axis]).unwrap());
        if (0..D).all(|axis| at[axis] > 0 && at[axis] + 1 < planes[axis].len()) {
            *point += Vector::<D>::from_fn(|axis, _| 0.5 * jitter * random_shift(&planes[axis], at[axis], random));
        }
    }
    (points, elements)
}

/// Random displacement of up to a quarter of the lesser adjacent cell, to either side.
fn random_shift(planes: &[f64], k: usize, random: &mut TestRandom) -> f64 {
    (planes[k + 1] - planes[k]).min(planes[k] - planes[k - 1]) * (0.5 * random.next() - 0.25)
}

fn flat_grid<const D: usize>(
    planes: &[Vec<f64>; D],
    jitter: f64,
    random: &mut TestRandom,
) -> (Vec<Vector<D>>, Vec<Simplex>) {
    let n = [planes[0].len(), planes[1].len()];
    let mut points = vec![];
    let mut elements = vec![];
    for j in 0..n[1] {
        for i in 0..n[0] {
            let is_inner = i > 0 && j > 0 && i + 1 < n[0] && j + 1 < n[1];
            let mut by = |axis: usize, k| if is_inner { jitter * random_shift(&planes[axis], k, random) } else { 0.0 };
            let by = [by(0, i), by(1, j)];
            points.push(Vector::<D>::from_fn(|axis, _| planes[axis][[i, j][axis]] + by[axis]));
        }
    }
    for cell in (0..n[1] - 1).flat_map(|j| (0..n[0] - 1).map(move |i| i + j * n[0])) {
        let [a, b, c, d] = [cell, cell + 1, cell + 1 + n[0], cell + n[0]].map(|i| NodeId(i as u32));
        let one_way = jitter == 0.0 || random.next() < 0.5;
        elements.extend(if one_way { [[a, b, c, a], [a, c, d, a]] } else { [[a, b, d, a], [b, c, d, b]] });
    }
    (points, elements)
}

/// Planes of `n` equal cells from 0 to 1.
pub(super) fn even(n: usize) -> Vec<f64> {
    (0..=n).map(|i| i as f64 / n as f64).collect()
}

/// Unit square in n × n jittered cells.
pub(super) fn jittered_square(n: usize, random: &mut TestRandom) -> Mesh<2> {
    let (points, elements) = grid(&[even(n), even(n)], 1.0, random);
    Mesh::new(points, elements)
}

/// Body that is a rectangle or box in material coordinates ξ, with its current positions.
#[derive(Clone)]
pub(super) struct TestBody<const D: usize> {
    pub xi: Vec<Vector<D>>,
    pub mesh: Mesh<D>,
    pub position: Vec<Vector<D>>,
    pub symmetry: BodySymmetry,
    pub mass: Vec<f64>,
    pub corner_mass: Vec<[f64; 4]>,
    pub velocity: Vec<Vector<D>>,
}

/// Map from ξ to current positions.
pub(super) type BodyMap<'a, const D: usize> = dyn Fn(&Vector<D>) -> Vector<D> + 'a;

impl<const D: usize> TestBody<D> {
    /// Builds a body at rest at ξ, of unit density, with current positions map(ξ).
    pub fn new(
        planes: &[Vec<f64>; D],
        (jitter, random): (f64, &mut TestRandom),
        (symmetry, map): (BodySymmetry, &BodyMap<'_, D>),
    ) -> Self {
        let (xi, elements) = grid(planes, jitter, random);
        let mesh = Mesh::<D>::new(xi.clone(), elements);
        let ring = |e: &Simplex| std::f64::consts::TAU / 3.0 * e[..3].iter().map(|n| xi[n.index()][0]).sum::<f64>();
        let thickness = |e: &Simplex| if symmetry == BodySymmetry::Axisymmetric { ring(e) } else { 1.0 };
        let mass: Vec<f64> = mesh.elements.iter().map(|e| mesh.measure(e) * thickness(e)).collect();
        let position: Vec<Vector<D>> = xi.iter().map(map).collect();
        let velocity = vec![Vector::zeros(); xi.len()];
        Self { xi, mesh, position, symmetry, mass: vec![], corner_mass: vec![], velocity }.with_masses(&mass)
    }

    /// Sets the masses of the elements, kg.
    pub fn with_masses(mut self, mass: &[f64]) -> Self {
        self.corner_mass = corner_masses(&self.mesh.rest, &self.mesh.elements, mass, self.symmetry);
        self.mass = nodal_masses::<D>(self.xi.len(), &self.mesh.elements, &self.corner_mass);
        self
    }

    /// Sets the velocity as a function of position.
    pub fn with_velocity(mut self, velocity: impl Fn(&Vector<D>) -> Vector<D>) -> Self {
        self.velocity = self.position.iter().map(velocity).collect();
        self
    }

    pub fn moved(&self) -> DeformedMesh<'_, D> {
        DeformedMesh { mesh: &self.mesh, position: &self.position }
    }

    pub fn carried(&self) -> NodalFields<'_, D> {
        NodalFields {
            symmetry: self.symmetry,
            mass: &self.mass,
            corner_mass: &self.corner_mass,
            velocity: &self.velocity,
            is_level: false,
        }
    }

    pub fn books(&self) -> ConservedTotals<D> {
        ConservedTotals::of(&self.position, &self.mass, &self.velocity)
    }

    /// First moment Σ m x, kg·m.
    pub fn first_moment(&self) -> Vector<D> {
        self.position.iter().zip(&self.mass).map(|(x, m)| x * *m).sum()
    }

    /// Proposal that changes nothing.
    pub fn again(&self) -> ProposedMesh<D> {
        ProposedMesh {
            position: self.position.clone(),
            origin: (0..self.xi.len() as u32).map(|i| NodeOrigin::Kept(NodeId(i))).collect(),
            elements: self.mesh.elements.clone(),
            over: vec![],
        }
    }

    /// Another grid of the same rectangle or box, with the node positions in ξ.
    pub fn other(
        &self,
        planes: &[Vec<f64>; D],
        (jitter, random): (f64, &mut TestRandom),
        map: &BodyMap<'_, D>,
    ) -> (Vec<Vector<D>>, ProposedMesh<D>) {
        let (xi, elements) = grid(planes, jitter, random);
        let is_end = |p: &Vector<D>, axis: usize| p[axis] == 0.0 || p[axis] == *planes[axis].last().unwrap();
        // Corners of a rectangle are ends of the sides along the first axis.
        let origin: Vec<NodeOrigin> = xi
            .iter()
            .map(|p| match (0..D).rev().find(|axis| is_end(p, *axis)) {
                Some(across) if D == 2 => self.on_side(p, 1 - across),
                Some(across) => self.on_face(p, across),
                None => NodeOrigin::Inside,
            })
            .collect();
        let at = |node: NodeId| self.position[node.index()];
        let place = |(p, origin): (&Vector<D>, &NodeOrigin)| match *origin {
            NodeOrigin::Kept(node) => at(node),
            NodeOrigin::Surface([a, b, _], [r, s, _]) if D == 2 => at(a) * r + at(b) * s,
            NodeOrigin::Surface([a, b, c], [r, s, t]) => at(a) * r + at(b) * s + at(c) * t,
            NodeOrigin::Inside => map(p),
        };
        let position = xi.iter().zip(&origin).map(place).collect();
        (xi, ProposedMesh { position, origin, elements, over: vec![] })
    }

    /// Origin of a point on a side along an axis.
    fn on_side(&self, p: &Vector<D>, along: usize) -> NodeOrigin {
        let mut side: Vec<usize> = (0..self.xi.len()).filter(|i| self.xi[*i][1 - along] == p[1 - along]).collect();
        side.sort_by(|a, b| self.xi[*a][along].total_cmp(&self.xi[*b][along]));
        let next = side.iter().position(|i| self.xi[*i][along] >= p[along]).unwrap();
        if self.xi[side[next]] == *p {
            return NodeOrigin::Kept(NodeId(side[next] as u32));
        }
        let [a, b] = [side[next - 1], side[next]];
        let s = (p[along] - self.xi[a][along]) / (self.xi[b][along] - self.xi[a][along]);
        NodeOrigin::Surface([a, b, b].map(|n| NodeId(n as u32)), [1.0 - s, s, 0.0])
    }

    /// Origin of a point on a face across an axis.
    fn on_face(&self, p: &Vector<D>, across: usize) -> NodeOrigin {
        let flat = |x: &Vector<D>| Vector::<2>::new(x[(across + 1) % 3], x[(across + 2) % 3]);
        let beside = |facet: &&Facet| facet.iter().all(|n| self.xi[n.index()][across] == p[across]);
        let found = self.mesh.facets.iter().filter(beside).map(|facet| {
            let corners = facet.map(|n| flat(&self.xi[n.index()]));
            let [a, b, c] = triangle::barycentric([&corners[0], &corners[1], &corners[2]], &flat(p));
            (*facet, [a, b, c].map(|w| if w.abs() < 1e-14 { 0.0 } else { w }))
        });
        let inner = |weights: &[f64; 3]| weights.iter().copied().fold(f64::MAX, f64::min);
        let (facet, weights) = found.max_by(|a, b| inner(&a.1).total_cmp(&inner(&b.1))).unwrap();
        match facet.iter().find(|n| self.xi[n.index()] == *p) {
            Some(node) => NodeOrigin::Kept(*node),
            None => NodeOrigin::Surface(facet, weights),
        }
    }

    /// Body after a transfer.
    pub fn after(self, xi: Vec<Vector<D>>, new: ProposedMesh<D>, transferred: TransferredFields<D>) -> Self {
        let mut mesh = Mesh::<D>::new(transferred.rest, new.elements);
        mesh.held = transferred.held;
        Self {
            xi,
            mesh,
            position: new.position,
            symmetry: self.symmetry,
            mass: transferred.mass,
            corner_mass: transferred.corner_mass,
            velocity: transferred.velocity,
        }
    }
}

/// Random numbers from 0 to 1, one per element.
pub(super) fn scatter<const D: usize>(mesh: &Mesh<D>, random: &mut TestRandom) -> Vec<f64> {
    mesh.elements.iter().map(|_| random.next()).collect()
}

/// Asserts that a transfer conserves mass and momentum to a relative tolerance.
#[track_caller]
pub(super) fn check_conserved<const D: usize>(defects: &ConservationDefects<D>, tolerance: f64) {
    let ConservationDefects { before, raw, after, .. } = *defects;
    assert!((raw.mass / before.mass - 1.0).abs() < tolerance, "mass {:e}", raw.mass / before.mass - 1.0);
    let scale = before.momentum.norm() + before.mass.sqrt() * before.kinetic.sqrt();
    assert!(defects.momentum_defect().norm() < tolerance * scale, "momentum {:e}", defects.momentum_defect().norm());
    assert!((after.momentum - raw.momentum).norm() < tolerance * scale);
}

/// Asserts that nothing at all can be transferred to a node.
pub(super) fn check_nothing<const D: usize>(symmetry: BodySymmetry) {
    let mesh = Mesh::<D>::new(vec![], vec![]);
    let carried = NodalFields { symmetry, mass: &[], corner_mass: &[], velocity: &[], is_level: false };
    let new = ProposedMesh {
        position: vec![Vector::zeros()],
        origin: vec![NodeOrigin::Inside],
        elements: vec![],
        over: vec![],
    };
    let after = transfer(&DeformedMesh { mesh: &mesh, position: &[] }, &carried, &new);
    assert_eq!((after.rest, after.mass, after.defects.misses), (vec![Vector::zeros()], vec![0.0], 1));
}

/// Asserts that meshes of very different sizes take over from one another.
pub(super) fn check_sizes<const D: usize>(
    mut body: TestBody<D>,
    meshes: &[[Vec<f64>; D]],
    random: &mut TestRandom,
    map: &BodyMap<'_, D>,
) {
    for planes in meshes {
        let (xi, new) = body.other(planes, (1.0, random), map);
        let after = transfer(&body.moved(), &body.carried(), &new);
        check_conserved(&after.defects, 1e-13);
        assert!(after.defects.relative_mass() < 1e-13);
        assert_eq!((after.defects.misses, after.defects.massless), (0, 0));
        body = body.after(xi, new, after);
    }
}

/// Asserts that an element turned inside out by a node moved by `shift` gives its mass to its neighbours.
pub(super) fn check_inverted<const D: usize>(mut body: TestBody<D>, shift: Vector<D>) {
    let mut new = body.again();
    let inner = (0..body.xi.len()).find(|i| body.xi[*i].iter().all(|c| *c > 0.3 && *c < 0.6)).unwrap();
    body.position[inner] += shift;
    let upright = |x: &[Vector<D>]| body.mesh.elements.iter().filter(|e| signed_volume(x, e) > 0.0).count();
    assert!(upright(&body.position) < body.mesh.elements.len());
    new.origin[inner] = NodeOrigin::Inside;
    let after = transfer(&body.moved(), &body.carried(), &new);
    check_conserved(&after.defects, 1e-13);
    assert!(after.defects.stray_mass > 0.0 && after.defects.massless == 0);
}

/// Asserts that nodes keep every bit where the mesh around them does, although node `moved` moves by `shift`. Returns
/// the numbers of nodes that do and do not.
pub(super) fn check_reach<const D: usize>(body: &TestBody<D>, moved: usize, shift: Vector<D>) -> [usize; 2] {
    let mut new = body.again();
    new.position[moved] += shift;
    new.origin[moved] = NodeOrigin::Inside;
    let after = transfer(&body.moved(), &body.carried(), &new);
    let mut counts = [0; 2];
    for (i, xi) in body.xi.iter().enumerate() {
        let is_far = xi[0] > 0.05 * (1.0 + 1.0 + 4.0) + 0.03;
        let is_same = (after.mass[i], after.velocity[i]) == (body.mass[i], body.velocity[i]);
        assert!(is_same || !is_far, "node {i} at {xi}");
        assert!(after.rest[i] == body.mesh.rest[i] || i == moved);
        counts[usize::from(!is_same)] += 1;
    }
    assert!(after.defects.unchanged > 0.9 && after.defects.unchanged < 1.0);
    check_conserved(&after.defects, 1e-13);
    if D == 3 {
        let ConservationDefects { before, after, .. } = after.defects;
        assert!((after.angular - before.angular).norm() < 1e-13 * before.angular.norm());
    }
    counts
}
