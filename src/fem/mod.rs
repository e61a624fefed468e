//! Potential energies made of elements, in patches that share a volume change: what the integrator steps.

mod batch;
mod element_pressure;
mod element_states;
mod facet_pressure;
mod history;
mod hyperelastic_simd;
mod inversion_time;
mod kinematics;
mod layout;
mod node_cache;
mod pipeline;
mod rest_geometry;
mod simd_material;
mod simplex;
mod simplices;
mod symmetric_tensor;
mod transpose;
mod viscoelastic;
mod viscoelastic_simd;
mod viscoplastic;
mod viscoplastic_simd;

use crate::math::Vector;
use crate::mesh::{ElementId, NodeId, Patches};

pub(crate) use batch::on;
pub use batch::{Batch, LANES};
pub use facet_pressure::{Push, push};
pub use history::Recall;
pub use layout::{Asked, Corner, DEPTH, Found, GroupAnswer, Kick, Kicks, Lanes, Power, places};
pub use node_cache::{Accumulated, At, Held, Local, MOST_LOCAL_NODES, Row, Whereabouts, rounding};
pub use simplices::{Reference, Section, Simplices};
pub use viscoplastic::{Memory, Spent};

/// How far J may come below nothing within a step, the element closing as it does at its beginning.
///
/// A bound of the stiffness there does not see that: a strip of a wall, 0.1 mm thick, whose sides met at 50 m/s, had J = −2.3 after one step
/// and 9000 times its κ, and gave back many times the energy that had closed it. Half of where the continuation begins: in it, what resists
/// grows no more. Of 40 speeds around a random scene (191) two stopped without this, and none does with it. No half of J in a step instead:
/// J → 0 in ever shorter steps then, and `ball-square` at 30 m/s, which comes to J = 0.01 on its fixed mesh, ended there.
pub const TURNED: f64 = 0.1;
/// How fast elements close is told where one would be [`TURNED`] within so many of the steps behind: then a step may be doubled without it
/// being asked once more.
pub const FORESEEN: f64 = 2.0;

/// Most nodes that an element may have.
pub const MAX_NODES: usize = 4;

/// What an element answers at one position of its nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer<const D: usize> {
    /// −∂V/∂x of its nodes, N; V is the energy of its patch, of which this element's share is meant.
    pub forces: [Vector<D>; MAX_NODES],
    /// κ, upper bound of the greatest eigenvalue of the element's share of the stiffness matrix ∂²V/∂x∂x, N/m.
    pub stiffness: f64,
    /// J = det F.
    pub jacobian: f64,
}

impl<const D: usize> Default for Answer<D> {
    fn default() -> Self {
        Self { forces: [Vector::zeros(); MAX_NODES], stiffness: 0.0, jacobian: 1.0 }
    }
}

/// What all elements answer at some positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// κ of each element, N/m.
    pub stiffness: Vec<f64>,
    /// J of each element.
    pub jacobian: Vec<f64>,
    /// V of each patch, J.
    pub energy: Vec<f64>,
}

impl Measured {
    /// Of so many elements in so many patches, and nothing known of them.
    fn of(n_elements: usize, n_patches: usize) -> Self {
        Self { stiffness: vec![0.0; n_elements], jacobian: vec![1.0; n_elements], energy: vec![0.0; n_patches] }
    }

    /// Takes down what those of a patch answer.
    fn take<const D: usize, P: Potential<D> + ?Sized>(
        &mut self,
        potential: &P,
        patch: usize,
        (x, memory): (&[Vector<D>], &[Memory<D>]),
    ) {
        let mut answers = [Answer::default(); DEPTH];
        self.energy[patch] = potential.evaluate(patch, x, memory, &mut answers);
        for (element, answer) in potential.patches().of(patch).iter().zip(&answers) {
            self.stiffness[element.index()] = answer.stiffness;
            self.jacobian[element.index()] = answer.jacobian;
        }
    }
}

/// An elastic energy V = Σ_P V_P(x) of patches P of elements.
pub trait Potential<const D: usize>: Send + Sync {
    /// Number of elements.
    fn len(&self) -> usize;
    /// Whether there are no elements.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// The nodes of an element, at most [`MAX_NODES`].
    fn nodes(&self, element: ElementId) -> &[NodeId];
    /// Which elements share an energy, at most [`DEPTH`] each.
    fn patches(&self) -> &Patches;
    /// Energy of a patch at the positions `x` of all nodes, J; `answers` receives what its elements answer, in their order. `memory`
    /// is what all elements remember, [`Self::memories`] of each, one element after the other.
    fn evaluate(&self, patch: usize, x: &[Vector<D>], memory: &[Memory<D>], answers: &mut [Answer<D>; DEPTH]) -> f64;
    /// The same at the next own tick of the patch, `step` s after the last: what it remembers goes on.
    fn advance(
        &self,
        patch: usize,
        x: &[Vector<D>],
        (_, memory): (f64, &mut [Memory<D>]),
        answers: &mut [Answer<D>; DEPTH],
    ) -> Spent {
        Spent { energy: self.evaluate(patch, x, memory, answers), ..Spent::default() }
    }
    /// The same at a tick at which the patch has been advanced already; `viscous` is what viscosity has added to U′ of each element then.
    fn again(
        &self,
        patch: usize,
        x: &[Vector<D>],
        (memory, _viscous): (&[Memory<D>], &[f64; DEPTH]),
        answers: &mut [Answer<D>; DEPTH],
    ) -> f64 {
        self.evaluate(patch, x, memory, answers)
    }
    /// How many memories each element has of how it has come where it is.
    fn memories(&self) -> usize {
        0
    }
    /// Whether its elements have any.
    fn remembers(&self) -> bool {
        self.memories() > 0
    }
    /// Whether an element is crushed beyond what its material law means (below the continuation).
    fn is_crushed(&self, jacobian: f64) -> bool;
    /// Area or volume of an element with its corners there times a constant, of a ring that remembers all around the axis; of a
    /// potential that has meshes.
    fn measure(&self, _corners: &[Vector<D>; MAX_NODES]) -> f64 {
        1.0
    }
    /// Whether that is so of them.
    fn measures_rings(&self) -> bool {
        false
    }
    /// What all elements answer at these positions, but for their forces: what [`Self::evaluate`] gives, but for rounding.
    fn measure_all(&self, x: &[Vector<D>], memory: &[Memory<D>]) -> Measured {
        let mut measured = Measured::of(self.len(), self.patches().len());
        (0..self.patches().len()).for_each(|patch| measured.take(self, patch, (x, memory)));
        measured
    }
    /// How fast an element of this J closes with all nodes there, so fast: 1 over the time after which it is [`TURNED`], 1/s; 0 if it
    /// does not.
    fn closing(&self, _element: ElementId, _jacobian: f64, (_x, _v): (&[Vector<D>], &[Vector<D>])) -> f64 {
        0.0
    }
    /// The positions of all nodes at which nothing is stored; of a potential that has lanes.
    fn rest(&self) -> &[Vector<D>] {
        &[]
    }
    /// The same elements laid out for vector units, if there is such a form: lane by lane in the order of `slots`, `None`
    /// where a lane is empty; `local` gives the number of each node of the element in a slot.
    fn lanes(&self, _slots: &[Option<ElementId>], _depth: usize, _local: &[[u16; MAX_NODES]]) -> Option<Lanes<D>> {
        None
    }
}
