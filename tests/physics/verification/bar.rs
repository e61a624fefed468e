//! A linear bar along z: equal springs and lumped masses, stepped by the engine that steps the gel.
//!
//! The lower end is node 0, at z = 0, and meets a half-space below. The surface size of that node is the length of the
//! bar, so that neither the limit on the path of a node nor the step of its neighbours ever lowers a step: all steps are
//! and stay equal, as the closed forms need.

use ballistic_gel::contact::{
    BodyMotion, BodyState, ContactSurface, FreeDirections, ImpulseExchange, ImpulseLaw, RigidBody, SurfaceNode,
};
use ballistic_gel::fem::{DEPTH, ElementResponse, HistoryVariables, Potential};
use ballistic_gel::geometry::{HalfSpace, ShapeGeometry};
use ballistic_gel::integrator::{DiscreteGel, Engine, IntegratorSettings, SteppingSchedule};
use ballistic_gel::math::{Tensor3, Vector, Vector3};
use ballistic_gel::mesh::{ElementId, ElementPatches, NodeId, NodeIncidence};

/// Springs between consecutive nodes along z: V = k/2 (Δz − L₀)².
#[derive(Debug)]
pub struct Springs {
    /// k, N/m, of each spring.
    pub stiffness: Vec<f64>,
    /// L₀, m, of each spring.
    pub rest: Vec<f64>,
    nodes: Vec<[NodeId; 2]>,
    patches: ElementPatches,
}

impl Springs {
    /// The spring i joins node i to node i + 1.
    pub fn new(stiffness: Vec<f64>, rest: Vec<f64>) -> Self {
        let nodes = (0..stiffness.len() as u32).map(|i| [NodeId(i), NodeId(i + 1)]).collect();
        let patches = ElementPatches::alone(stiffness.len());
        Self { stiffness, rest, nodes, patches }
    }

    /// Tension of a spring, N.
    pub fn tension(&self, spring: usize, x: &[Vector<2>]) -> f64 {
        self.stiffness[spring] * (x[spring + 1][1] - x[spring][1] - self.rest[spring])
    }
}

impl Potential<2> for Springs {
    fn len(&self) -> usize {
        self.stiffness.len()
    }

    fn nodes(&self, spring: ElementId) -> &[NodeId] {
        &self.nodes[spring.index()]
    }

    fn patches(&self) -> &ElementPatches {
        &self.patches
    }

    /// The stiffness matrix k [[1, −1], [−1, 1]] has the eigenvalue 2k.
    fn evaluate(
        &self,
        i: usize,
        x: &[Vector<2>],
        _: &[HistoryVariables<2>],
        answers: &mut [ElementResponse<2>; DEPTH],
    ) -> f64 {
        let (k, tension) = (self.stiffness[i], self.tension(i, x));
        answers[0].forces[0] = Vector::<2>::new(0.0, tension);
        answers[0].forces[1] = Vector::<2>::new(0.0, -tension);
        answers[0].stiffness = 2.0 * k;
        answers[0].jacobian = (x[i + 1][1] - x[i][1]) / self.rest[i];
        0.5 * tension * tension / k
    }

    fn is_crushed(&self, _jacobian: f64) -> bool {
        false
    }
}

/// A straight bar of equal cells.
#[derive(Debug, Clone, Copy)]
pub struct Bar {
    /// Length, m.
    pub length: f64,
    /// EA, N.
    pub modulus: f64,
    /// ρA, kg/m.
    pub density: f64,
    /// Number of springs.
    pub cells: usize,
    /// Whether the upper end is held.
    pub held: bool,
}

/// A bar of unit length, mass and wave speed.
pub fn unit_bar(cells: usize) -> Bar {
    Bar { length: 1.0, modulus: 1.0, density: 1.0, cells, held: false }
}

/// How a bar is stepped.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    /// Fraction of the stable step.
    pub cfl: f64,
    /// Restitution of the law.
    pub restitution: f64,
}

impl Bar {
    /// Length of a cell, m.
    pub fn cell(&self) -> f64 {
        self.length / self.cells as f64
    }

    /// The bar in the engine, all nodes at rest in place with these velocities (by z), before a half-space.
    pub fn engine(
        &self,
        pace: Pace,
        wall: &(RigidBody, BodyState),
        velocity: impl Fn(f64) -> f64,
    ) -> Engine<2, Springs> {
        let (n, h) = (self.cells, self.cell());
        let springs = Springs::new(vec![self.modulus / h; n], vec![h; n]);
        let mass: Vec<f64> = (0..=n).map(|i| self.density * h * if i == 0 || i == n { 0.5 } else { 1.0 }).collect();
        let held: Vec<[bool; 2]> = (0..=n).map(|i| [true, self.held && i == n]).collect();
        let node = |i: usize| {
            let z = i as f64 * h;
            (Vector::<2>::new(0.0, z), Vector::<2>::new(0.0, if held[i][1] { 0.0 } else { velocity(z) }))
        };
        let nodes = (0..=n).map(node).collect();
        let gel = DiscreteGel::new(springs, mass, &held, end_surface(n + 1, self.length));
        Engine::new(gel, vec![wall.clone()], rules(pace), nodes)
    }
}

/// Powers of two, Moreau's law without removal of penetration.
pub fn rules(pace: Pace) -> IntegratorSettings {
    let law = ImpulseLaw::Moreau { restitution: pace.restitution, bias: 0.0, friction: 0.0 };
    IntegratorSettings { schedule: SteppingSchedule::Bins, cfl: pace.cfl, law, force_window: 1e-2, damping: 0.0 }
}

/// Node 0 is all of the surface.
pub fn end_surface(n_nodes: usize, size: f64) -> ContactSurface {
    let mut of = vec![None; n_nodes];
    of[0] = Some(0);
    let around = NodeIncidence::new(n_nodes, std::iter::empty::<&[NodeId]>());
    ContactSurface { nodes: vec![SurfaceNode { node: NodeId(0), size, area: 1.0 }], of, facets: vec![], around }
}

/// The body fills the half-space below its position.
pub fn below_z(z: f64, velocity: f64) -> BodyState {
    BodyState::at_start(Vector3::new(0.0, 0.0, z), Vector3::new(0.0, 0.0, velocity))
}

fn half_space() -> ShapeGeometry {
    ShapeGeometry::HalfSpace(HalfSpace::new(Vector3::z()))
}

/// A held wall whose surface is at `z`.
pub fn fixed_wall(z: f64) -> (RigidBody, BodyState) {
    (RigidBody::fixed(half_space(), FreeDirections::PLANAR), below_z(z, 0.0))
}

/// A rigid mass whose face starts at `z` and moves up.
pub fn striker(motion: BodyMotion, mass: f64, (z, velocity): (f64, f64)) -> (RigidBody, BodyState) {
    (RigidBody::new(half_space(), motion, FreeDirections::PLANAR, mass, Tensor3::identity()), below_z(z, velocity))
}

/// Advances to `t`; gives what the body received.
pub fn advance<P: Potential<2>>(engine: &mut Engine<2, P>, t: f64) -> ImpulseExchange {
    let mut exchange = ImpulseExchange::default();
    engine.advance_to(t, std::slice::from_mut(&mut exchange)).expect("a linear bar does not fail");
    exchange
}

/// The one step of all cells, s.
///
/// # Panics
/// If they differ.
pub fn common_step<P: Potential<2>>(engine: &Engine<2, P>) -> f64 {
    let steps = engine.steps();
    assert!(steps.iter().all(|step| *step == steps[0]), "all steps of a uniform bar are equal");
    steps[0]
}
