use crate::algebra::Vector;
use crate::element::{Evaluation, MAX_NODES, Potential};
use crate::mesh::{ElementId, Facet, Incidence, NodeId};
use crate::state::Clock;

/// What the engine steps and what does not change while it does: energy, masses, held directions, surface.
#[derive(Debug)]
pub struct Gel<const D: usize, P> {
    /// Stored energy.
    pub potential: P,
    /// Lumped masses, kg.
    pub mass: Vec<f64>,
    /// 1 in the free directions of a node, 0 in the held ones (P_a).
    pub free: Vec<Vector<D>>,
    /// The patches of each node.
    pub star: Incidence,
    /// Where contact can be.
    pub surface: Surface,
    /// The patch that each facet of the surface bounds.
    pub behind: Vec<ElementId>,
}

/// The nodes and facets that can touch.
#[derive(Debug)]
pub struct Surface {
    /// The nodes, ascending.
    pub nodes: Vec<SurfaceNode>,
    /// Position of a node among `nodes`, or `None`, by node.
    pub of: Vec<Option<u32>>,
    /// The facets.
    pub facets: Vec<Facet>,
    /// The facets of each node.
    pub around: Incidence,
}

/// A node that can touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceNode {
    /// The node.
    pub node: NodeId,
    /// h, local size of the facets, m.
    pub size: f64,
    /// Its share of the surface at rest, m².
    pub area: f64,
}

impl<const D: usize, P: Potential<D>> Gel<D, P> {
    /// From an energy, the masses, the held directions and the surface.
    ///
    /// # Panics
    /// If the lengths differ or a mass is not positive.
    #[must_use]
    pub fn new(potential: P, mass: Vec<f64>, held: &[[bool; D]], surface: Surface) -> Self {
        assert_eq!(mass.len(), held.len(), "every node has a mass and its held directions");
        assert!(mass.iter().all(|m| *m > 0.0), "every node needs a positive mass");
        assert!(potential.stride() <= MAX_NODES, "a patch has too many nodes");
        let patches = (0..potential.len()).map(|p| potential.nodes(ElementId(p as u32)));
        let star = Incidence::new(mass.len(), patches);
        let free = held.iter().map(|held| Vector::<D>::from_fn(|i, _| if held[i] { 0.0 } else { 1.0 })).collect();
        let owner = |facet: &Facet| {
            let has_all = |patch: &&ElementId| facet[..D].iter().all(|node| potential.nodes(**patch).contains(node));
            star.of(facet[0]).iter().find(has_all).copied().expect("a facet bounds a patch")
        };
        let behind = surface.facets.iter().map(owner).collect();
        Self { potential, mass, free, star, surface, behind }
    }

    /// Clocks that have not begun, with what the patches answer at these positions.
    pub(super) fn clocks(&self, x: &[Vector<D>]) -> Vec<Clock> {
        let answer = |p: usize| {
            let mut forces = [Vector::<D>::zeros(); MAX_NODES];
            self.potential.evaluate(ElementId(p as u32), x, &mut forces[..self.potential.stride()])
        };
        let clock = |at: Evaluation| Clock {
            stiffness: at.stiffness,
            energy: at.energy,
            jacobian: at.jacobian,
            ..Clock::default()
        };
        (0..self.potential.len()).map(|p| clock(answer(p))).collect()
    }

    /// The smallest of the stable steps at these positions, s; not a normal number where there is none.
    #[must_use]
    pub fn smallest_step(&self, x: &[Vector<D>]) -> f64 {
        let steps = super::pace::stable_steps(self, &self.clocks(x), 1.0);
        // Any NaN must come out: `f64::min` would drop it.
        steps.into_iter().fold(f64::INFINITY, |least, step| if least.is_nan() || step >= least { least } else { step })
    }
}

impl Surface {
    /// The surface made of these facets of `D` nodes each; `area` gives the measure of a facet at rest, m², `length` its
    /// size, m in the plane, m² in space.
    #[must_use]
    pub fn new<const D: usize>(n_nodes: usize, facets: Vec<Facet>, measure: impl Fn(&Facet) -> (f64, f64)) -> Self {
        let mut share = vec![(0.0, 0.0); n_nodes];
        for facet in &facets {
            let (area, extent) = measure(facet);
            for node in &facet[..D] {
                share[node.index()].0 += area / D as f64;
                share[node.index()].1 += extent / D as f64;
            }
        }
        let touching = share.iter().enumerate().filter(|(_, (_, extent))| *extent > 0.0);
        let size = |extent: f64| if D == 2 { extent } else { extent.sqrt() };
        let nodes: Vec<SurfaceNode> = touching
            .map(|(i, (area, extent))| SurfaceNode { node: NodeId(i as u32), size: size(*extent), area: *area })
            .collect();
        let mut of = vec![None; n_nodes];
        for (i, surface) in nodes.iter().enumerate() {
            of[surface.node.index()] = Some(i as u32);
        }
        let around = Incidence::new(n_nodes, facets.iter().map(|facet| &facet[..D]));
        Self { nodes, of, facets, around }
    }
}
