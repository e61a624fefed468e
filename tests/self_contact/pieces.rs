//! Gels of several pieces: structured blocks in one mesh, and how far their surfaces have crossed.

use ballistic_gel::constitutive::NeoHookean;
use ballistic_gel::contact::{BodyMotion, BodyState, ContactSurface, FreeDirections, ImpulseLaw, RigidBody};
use ballistic_gel::fem::{Potential, Section, Simplices};
use ballistic_gel::geometry::{ShapeGeometry, Sphere};
use ballistic_gel::integrator::{DiscreteGel, Engine, IntegratorSettings, SteppingSchedule};
use ballistic_gel::math::{Vector, Vector3, embed};
use ballistic_gel::mesh::{self, BlockSpec, CellSplit, ElementPatches, Mesh, NodeId};

/// Shear modulus and bulk modulus, Pa, and density, kg/m³, of `sphere-block`.
pub const SHEAR: f64 = 68_965.517;
pub const BULK: f64 = 666_666.67;
pub const DENSITY: f64 = 1030.0;

/// Contact law of the pieces with bodies.
pub const MOREAU: ImpulseLaw = ImpulseLaw::Moreau { restitution: 0.0, bias: 0.1, friction: 0.0 };

/// Block with cells of one edge, m, between two corners, and its velocity, m/s.
pub struct Piece<const D: usize> {
    pub low: [f64; D],
    pub high: [f64; D],
    pub cell: f64,
    pub velocity: [f64; D],
}

/// Gel of pieces in an engine, without bodies near it.
pub struct Pieces<const D: usize> {
    pub mesh: Mesh<D>,
    pub velocity: Vec<Vector<D>>,
    /// Piece of each node.
    pub piece: Vec<usize>,
    /// Size of the facets at each node, m.
    pub cell: Vec<f64>,
    pub section: Section,
}

impl<const D: usize> Pieces<D> {
    /// Joins pieces to one mesh; all nodes are held along `held`.
    #[must_use]
    pub fn new(all: &[Piece<D>], section: Section, held: &[usize]) -> Self {
        let (mut rest, mut elements, mut velocity) = (vec![], vec![], vec![]);
        let (mut piece, mut cell) = (vec![], vec![]);
        for (number, one) in all.iter().enumerate() {
            let planes = |axis: usize| {
                let n = ((one.high[axis] - one.low[axis]) / one.cell).round().max(1.0) as u32;
                let place = |i: u32| one.low[axis] + (one.high[axis] - one.low[axis]) * f64::from(i) / f64::from(n);
                (0..=n).map(place).collect()
            };
            let spec = BlockSpec { planes: std::array::from_fn(planes), split: CellSplit::Centred, faces: vec![] };
            let (block, first) = (mesh::block(spec), rest.len() as u32);
            elements.extend(block.elements.iter().map(|nodes| nodes.map(|node| NodeId(node.0 + first))));
            velocity.extend(block.rest.iter().map(|_| Vector::<D>::from(one.velocity)));
            piece.extend(block.rest.iter().map(|_| number));
            cell.extend(block.rest.iter().map(|_| one.cell));
            rest.extend(block.rest);
        }
        let mut mesh = Mesh::new(rest, elements);
        mesh.held.iter_mut().for_each(|of| held.iter().for_each(|axis| of[*axis] = true));
        Self { mesh, velocity, piece, cell, section }
    }

    /// Moves the rest positions of the nodes of each piece by a map that keeps the orientation of elements.
    #[must_use]
    pub fn mapped(mut self, map: impl Fn(usize, &Vector<D>) -> Vector<D>) -> Self {
        for (x, piece) in self.mesh.rest.iter_mut().zip(&self.piece) {
            *x = map(*piece, x);
        }
        self
    }

    /// Cuts a slot: removes the elements whose middle it contains, and sets the velocity of the nodes by their places.
    #[must_use]
    pub fn cut(mut self, slot: impl Fn(&Vector<D>) -> bool, velocity: impl Fn(&Vector<D>) -> Vector<D>) -> Self {
        let rest = &self.mesh.rest;
        let middle =
            |nodes: &[NodeId; 4]| nodes[..=D].iter().map(|node| rest[node.index()]).sum::<Vector<D>>() / (D + 1) as f64;
        let kept: Vec<_> = self.mesh.elements.iter().copied().filter(|nodes| !slot(&middle(nodes))).collect();
        let mut number = vec![None; rest.len()];
        let mut used = vec![];
        for node in kept.iter().flat_map(|nodes| &nodes[..=D]) {
            if number[node.index()].is_none() {
                number[node.index()] = Some(NodeId(used.len() as u32));
                used.push(node.index());
            }
        }
        let renumbered = |nodes: [NodeId; 4]| nodes.map(|node| number[node.index()].unwrap_or(NodeId(0)));
        let held: Vec<[bool; D]> = used.iter().map(|node| self.mesh.held[*node]).collect();
        let mesh = Mesh::new(used.iter().map(|node| rest[*node]).collect(), kept.into_iter().map(renumbered).collect());
        self.velocity = mesh.rest.iter().map(velocity).collect();
        self.piece = used.iter().map(|node| self.piece[*node]).collect();
        self.cell = used.iter().map(|node| self.cell[*node]).collect();
        self.mesh = Mesh { held, ..mesh };
        self
    }

    /// Builds the engine.
    pub fn engine(&self, schedule: SteppingSchedule, law: ImpulseLaw) -> Engine<D, Simplices<D>> {
        let patches = ElementPatches::alone(self.mesh.elements.len());
        let simplices = Simplices::in_patches(&self.mesh, patches, (NeoHookean::new(SHEAR, BULK), self.section));
        let mass = simplices.lumped_masses(&self.mesh, DENSITY);
        let surface = ContactSurface::new::<D>(self.mesh.rest.len(), self.mesh.facets.clone(), |facet| {
            let cell = self.cell[facet[0].index()];
            (cell, if D == 2 { cell } else { 0.5 * cell * cell })
        });
        let gel = DiscreteGel::new(simplices, mass, &self.mesh.held, surface).with_self_contact(true);
        let nodes = gel.potential.rest().iter().copied().zip(self.velocity.iter().copied()).collect();
        let rules = IntegratorSettings { schedule, cfl: 0.8, law, force_window: 1.0, damping: 0.0 };
        Engine::new(gel, vec![bystander(self.section)], rules, nodes)
    }

    /// Depth of the deepest node of one piece behind a facet across an axis of another at a time, in cells, if it is less
    /// than one.
    pub fn crossing(&self, engine: &Engine<D, Simplices<D>>, t: f64, axis: usize) -> f64 {
        let place = |node: NodeId| embed(&engine.position_at(node, t));
        let mut deepest: f64 = 0.0;
        for facet in &self.mesh.facets {
            let corners = facet.map(place);
            let across = corners[1] - corners[0];
            let normal = across.cross(&if D == 3 { corners[2] - corners[0] } else { -Vector3::y() });
            let (unit, square) = (normal.normalize(), normal.norm_squared());
            if unit[if D == 2 { 2 * axis } else { axis }].abs() < 0.5 {
                continue;
            }
            let middle = corners[..D].iter().sum::<Vector3>() / D as f64;
            let other = self.piece[facet[0].index()];
            for at in engine.gel().surface.nodes.iter().filter(|at| self.piece[at.node.index()] != other) {
                let arm = place(at.node) - corners[0];
                if (arm + corners[0] - middle).norm() > 2.0 * across.norm() {
                    continue;
                }
                let weights = if D == 3 {
                    let beta = arm.cross(&(corners[2] - corners[0])).dot(&normal) / square;
                    let gamma = across.cross(&arm).dot(&normal) / square;
                    [1.0 - beta - gamma, beta, gamma]
                } else {
                    let beta = arm.dot(&across) / across.norm_squared();
                    [1.0 - beta, beta, 0.0]
                };
                let depth = -unit.dot(&arm) / self.cell[at.node.index()];
                if weights.iter().all(|w| *w >= 0.0) && depth < 1.0 {
                    deepest = deepest.max(depth);
                }
            }
        }
        deepest
    }

    /// Mean velocity of a piece, m/s.
    pub fn mean_velocity(&self, engine: &Engine<D, Simplices<D>>, piece: usize) -> Vector<D> {
        let (mut momentum, mut total) = (Vector::<D>::zeros(), 0.0);
        for (i, mass) in engine.gel().mass.iter().enumerate().filter(|(i, _)| self.piece[*i] == piece) {
            momentum += engine.state().velocity[i] * *mass;
            total += mass;
        }
        momentum / total
    }
}

/// Body that is never met: an engine has one.
fn bystander(section: Section) -> (RigidBody, BodyState) {
    let freedom = match section {
        Section::Planar { .. } => FreeDirections::PLANAR,
        Section::Axisymmetric => FreeDirections::AXISYMMETRIC,
        Section::Spatial => FreeDirections::SPATIAL,
    };
    let shape = ShapeGeometry::Sphere(Sphere { radius: 0.3 });
    let body = RigidBody::new(shape, BodyMotion::Free, freedom, 1.0, nalgebra::Matrix3::identity());
    (body, BodyState::at_start(Vector3::new(0.0, 0.0, 50.0), Vector3::zeros()))
}
