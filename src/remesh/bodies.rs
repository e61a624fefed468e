//! Bodies to be remeshed in tests.

use super::*;

/// Numbers from 0 to 1 that are the same in every run.
pub(super) struct Random(u64);

impl Random {
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

/// A grid of planes along two axes, every cell cut along a diagonal of its own, inner nodes moved by up to a quarter of
/// a cell.
fn grid(planes: &[Vec<f64>; 2], jitter: f64, random: &mut Random) -> (Vec<Vector<2>>, Vec<Simplex>) {
    let n = [planes[0].len(), planes[1].len()];
    let mut points = vec![];
    let mut elements = vec![];
    for j in 0..n[1] {
        for i in 0..n[0] {
            let mut shift = |axis: usize, k: usize| {
                let p = &planes[axis];
                let room = (p[k + 1] - p[k]).min(p[k] - p[k - 1]);
                jitter * room * (0.5 * random.next() - 0.25)
            };
            let is_inner = i > 0 && j > 0 && i + 1 < n[0] && j + 1 < n[1];
            let by = if is_inner { Vector::<2>::new(shift(0, i), shift(1, j)) } else { Vector::zeros() };
            points.push(Vector::<2>::new(planes[0][i], planes[1][j]) + by);
        }
    }
    for cell in (0..n[1] - 1).flat_map(|j| (0..n[0] - 1).map(move |i| i + j * n[0])) {
        let [a, b, c, d] = [cell, cell + 1, cell + 1 + n[0], cell + n[0]].map(|i| NodeId(i as u32));
        let one_way = jitter == 0.0 || random.next() < 0.5;
        elements.extend(if one_way { [[a, b, c, a], [a, c, d, a]] } else { [[a, b, d, a], [b, c, d, b]] });
    }
    (points, elements)
}

/// `n` equal cells from 0 to 1.
pub(super) fn even(n: usize) -> Vec<f64> {
    (0..=n).map(|i| i as f64 / n as f64).collect()
}

/// The unit square in n × n jittered cells.
pub(super) fn jittered_square(n: usize, random: &mut Random) -> Mesh<2> {
    let (points, elements) = grid(&[even(n), even(n)], 1.0, random);
    Mesh::new(points, elements)
}

/// A body that is a rectangle in coordinates ξ of its own, and where it is now.
#[derive(Clone)]
pub(super) struct Body {
    pub xi: Vec<Vector<2>>,
    pub mesh: Mesh<2>,
    pub position: Vec<Vector<2>>,
    pub symmetry: Symmetry,
    pub mass: Vec<f64>,
    pub corner_mass: Vec<[f64; 3]>,
    pub velocity: Vec<Vector<2>>,
}

impl Body {
    /// At rest at ξ, of unit density, and now at map(ξ).
    pub fn new(
        planes: &[Vec<f64>; 2],
        (jitter, random): (f64, &mut Random),
        (symmetry, map): (Symmetry, &dyn Fn(&Vector<2>) -> Vector<2>),
    ) -> Self {
        let (xi, elements) = grid(planes, jitter, random);
        let mesh = Mesh::<2>::new(xi.clone(), elements);
        let ring = |e: &Simplex| std::f64::consts::TAU / 3.0 * e[..3].iter().map(|n| xi[n.index()][0]).sum::<f64>();
        let thickness = |e: &Simplex| if symmetry == Symmetry::Planar { 1.0 } else { ring(e) };
        let mass: Vec<f64> = mesh.elements.iter().map(|e| mesh.measure(e) * thickness(e)).collect();
        let position: Vec<Vector<2>> = xi.iter().map(map).collect();
        let velocity = vec![Vector::zeros(); xi.len()];
        Self { xi, mesh, position, symmetry, mass: vec![], corner_mass: vec![], velocity }.with_masses(&mass)
    }

    /// The same with these masses of the elements, kg.
    pub fn with_masses(mut self, mass: &[f64]) -> Self {
        self.corner_mass = corner_masses(&self.mesh.rest, &self.mesh.elements, mass, self.symmetry);
        self.mass = nodal_masses(self.xi.len(), &self.mesh.elements, &self.corner_mass);
        self
    }

    /// The same with a velocity that depends on where a node is.
    pub fn with_velocity(mut self, velocity: impl Fn(&Vector<2>) -> Vector<2>) -> Self {
        self.velocity = self.position.iter().map(velocity).collect();
        self
    }

    pub fn moved(&self) -> Moved<'_, 2> {
        Moved { mesh: &self.mesh, position: &self.position }
    }

    pub fn carried(&self) -> Carried<'_> {
        Carried { symmetry: self.symmetry, mass: &self.mass, corner_mass: &self.corner_mass, velocity: &self.velocity }
    }

    pub fn books(&self) -> Books {
        Books::of(&self.position, &self.mass, &self.velocity)
    }

    /// The proposal that changes nothing.
    pub fn again(&self) -> Proposal<2> {
        Proposal {
            position: self.position.clone(),
            origin: (0..self.xi.len() as u32).map(|i| Origin::Kept(NodeId(i))).collect(),
            elements: self.mesh.elements.clone(),
        }
    }

    /// Another grid of the same rectangle, and where its nodes are in ξ.
    pub fn other(
        &self,
        planes: &[Vec<f64>; 2],
        (jitter, random): (f64, &mut Random),
        map: &dyn Fn(&Vector<2>) -> Vector<2>,
    ) -> (Vec<Vector<2>>, Proposal<2>) {
        let (xi, elements) = grid(planes, jitter, random);
        let [width, height] = [0, 1].map(|axis| *planes[axis].last().unwrap());
        let origin: Vec<Origin> = xi
            .iter()
            .map(|p| match (p[0] == 0.0 || p[0] == width, p[1] == 0.0 || p[1] == height) {
                (_, true) => self.on_side(p, 0),
                (true, false) => self.on_side(p, 1),
                (false, false) => Origin::Inside,
            })
            .collect();
        let at = |node: NodeId| self.position[node.index()];
        let place = |(p, origin): (&Vector<2>, &Origin)| match *origin {
            Origin::Kept(node) => at(node),
            Origin::Surface([a, b, _], [r, s, _]) => at(a) * r + at(b) * s,
            Origin::Inside => map(p),
        };
        let position = xi.iter().zip(&origin).map(place).collect();
        (xi, Proposal { position, origin, elements })
    }

    /// Origin of a point of a side along an axis.
    fn on_side(&self, p: &Vector<2>, along: usize) -> Origin {
        let mut side: Vec<usize> = (0..self.xi.len()).filter(|i| self.xi[*i][1 - along] == p[1 - along]).collect();
        side.sort_by(|a, b| self.xi[*a][along].total_cmp(&self.xi[*b][along]));
        let next = side.iter().position(|i| self.xi[*i][along] >= p[along]).unwrap();
        if self.xi[side[next]] == *p {
            return Origin::Kept(NodeId(side[next] as u32));
        }
        let [a, b] = [side[next - 1], side[next]];
        let s = (p[along] - self.xi[a][along]) / (self.xi[b][along] - self.xi[a][along]);
        Origin::Surface([a, b, b].map(|n| NodeId(n as u32)), [1.0 - s, s, 0.0])
    }

    /// The body after a transfer.
    pub fn after(self, xi: Vec<Vector<2>>, new: Proposal<2>, transferred: Transferred) -> Self {
        let mut mesh = Mesh::<2>::new(transferred.rest, new.elements);
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

/// Numbers from 0 to 1, one for each element.
pub(super) fn scatter(mesh: &Mesh<2>, random: &mut Random) -> Vec<f64> {
    mesh.elements.iter().map(|_| random.next()).collect()
}
