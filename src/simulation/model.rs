//! A gel of either dimension behind one interface.

use super::build::MOST_TICKS;
use super::driver::Renew;
use super::gel_definition::Recipe;
use super::memory::MeshSize;
use super::observe::{Frame, FrameCells, Place, SensorReport};
use super::preview::{Refusal, Rehearsal, Renewal};
use super::sensors::Seat;
use super::{RestoreError, SavedState};
use crate::contact::{Body, BodyState, Exchange};
use crate::fem::{Potential, Simplices};
use crate::integrator::{Engine, Gel, Reached, Run, StepError, SurfaceNode, Totals};
use crate::ledger::Ledger;
use crate::math::{Vector, Vector3, embed, ordered_sum, restrict};
use crate::mesh::{Facet, NodeId, Simplex};
use crate::remesh::{self, Neighbours};
use crate::state::{Birth, Clock, Record, State, Tick};
use std::sync::Arc;

/// Reach of the contact now.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Reach {
    /// Area of the nodes within a tenth of their size of a body, m².
    pub area: f64,
    /// Deepest penetration, m.
    pub penetration: f64,
    /// Longest step of a patch of those nodes, s.
    pub longest_step: f64,
}

/// What the simulation asks of a gel, whatever its dimension.
pub(super) trait Model: Send {
    fn advance_to(&mut self, t: f64, exchanges: &mut [Exchange]) -> Result<(), StepError>;
    /// The same up to the first exchange of the mesh from time `from` on, shown before it is made, if there is one.
    fn rehearse(&mut self, from: f64, t: f64, exchanges: &mut [Exchange]) -> Result<Option<Rehearsal>, StepError>;
    /// Exchanges of the mesh since it was built.
    fn renewals(&self) -> &[Renewal];
    fn refusals(&self) -> &[Refusal];
    fn n_bodies(&self) -> usize;
    /// What does not change of a body, and its last event.
    fn body(&self, i: usize) -> (&Body, &BodyState);
    fn rebase_body(&mut self, i: usize, t: f64);
    fn set_body(&mut self, i: usize, state: &BodyState);
    fn ledger_mut(&mut self) -> &mut Ledger;
    fn record(&self) -> &Record;
    /// Returns true if the gel is no longer integrated.
    fn is_at_rest(&self) -> bool;
    /// Returns true if a body at this state no longer meets the gel.
    fn is_away(&self, i: usize, at: &BodyState) -> bool;
    fn totals(&self, t: f64) -> Totals;
    /// Reach of the contact with a body at time `t`.
    fn reach(&self, i: usize, t: f64) -> Reach;
    /// How deep the surface of the gel would be, m, inside a body that comes to be there, until the gel looks again; if that is
    /// more than it may be.
    fn overlap(&self, i: usize, at: &BodyState) -> Option<f64>;
    /// Whether a body so would have the gel around its centre.
    fn swallows(&self, i: usize, at: &BodyState) -> bool;
    /// What rounding leaves of the energy of the gel at rest, J.
    fn noise(&self) -> f64;
    /// μ V, the torque of stresses of the size of the shear modulus, N·m.
    fn shear_torque(&self) -> f64;
    /// Elements, nodes, elements below the continuation.
    fn counts(&self) -> (usize, usize, usize);
    /// Part of the elements that are at rest not what their nodes say.
    fn fallback(&self) -> f64;
    /// Smallest and largest step, s.
    fn steps(&self) -> (f64, f64);
    fn synchronous_updates(&self, t: f64) -> f64;
    fn frame(&self, t: f64) -> Frame;
    /// What the sensors measure at time `t`.
    fn sensors(&self, t: f64) -> Vec<SensorReport>;
    /// Writes the state over another one, in its memory if it is of the same dimension.
    fn save(&self, to: &mut SavedState);
    /// Continues from a saved state that has come to `time`, s.
    fn restore(&mut self, saved: &SavedState, time: f64) -> Result<(), RestoreError>;
    /// Until when ticks are exact, s.
    fn latest(&self) -> f64;
    fn digest(&self) -> u128;
    fn bytes(&self) -> usize;
    /// Bytes of its state, as a copy takes them.
    fn state_bytes(&self) -> usize;
    fn mesh_size(&self) -> MeshSize;
    /// Returns true if its meshes are exchanged.
    fn can_remesh(&self) -> bool;
    fn runs(&self) -> Vec<Run<'_>>;
}

/// A gel of simplices.
pub(super) struct Gelatin<const D: usize> {
    pub engine: Engine<D, Simplices<D>>,
    /// The boundary of its mesh.
    pub facets: Vec<Facet>,
    /// Which loads act on them; empty where there are none.
    pub marks: Vec<u8>,
    /// Where the sensors are in its mesh.
    pub seats: Vec<Seat<D>>,
    /// The neighbours of its elements, where meshes are exchanged; none while one is, or after that has failed.
    pub across: Option<Neighbours>,
    /// What it is made of.
    pub recipe: Recipe,
    /// The mesh of the start, if it is not that of the engine.
    pub first: Option<Arc<Birth<D>>>,
    /// Its exchanges since it was built.
    pub renewals: Vec<Renewal>,
    /// When no mesh was taken, and why not, by attempt.
    pub refusals: Vec<Refusal>,
}

/// Overlap at the start that contact can take, in element sizes.
const OVERLAP: f64 = 0.1;

/// Depth of the deepest node of the surface, m, inside a body that goes on for the node's `wait`, s, if that is more than
/// contact can take.
pub(super) fn overlap<const D: usize, P>(
    gel: &Gel<D, P>,
    (body, at): (&Body, &BodyState),
    (position, wait): (impl Fn(NodeId) -> Vector3, impl Fn(NodeId) -> f64),
) -> Option<f64> {
    let too_deep = |surface: &SurfaceNode| {
        let x = position(surface.node);
        let way = body.velocity_at(at, &x).norm() * wait(surface.node);
        let depth = way - body.gap(at, &x).distance;
        (depth > OVERLAP * surface.size).then_some(depth)
    };
    gel.surface.nodes.iter().filter_map(too_deep).reduce(f64::max)
}

/// Whether the centre of a body is in the gel, and in the body too: then the gel is where the body is, and its surface need not be anywhere
/// near, so that no contact would say so.
pub(super) fn is_swallowed<const D: usize>(
    (x, elements): (&[Vector<D>], &[Simplex]),
    (body, at): (&Body, &BodyState),
) -> bool {
    let centre = restrict::<D>(&at.position);
    body.gap(at, &at.position).distance < 0.0 && remesh::is_inside(x, elements, &centre)
}

/// Fraction of an element's size within which a node counts as in contact.
const TOUCHING: f64 = 0.1;

impl<const D: usize> Gelatin<D> {
    /// Mass of the gel, kg.
    pub fn gel_mass(&self) -> f64 {
        let mass = &self.engine.gel().mass;
        ordered_sum(mass.len(), 0.0, |i| mass[i])
    }

    fn cells(&self, t: f64) -> FrameCells {
        let (measured, potential) = (self.engine.measure_at(t), &self.engine.gel().potential);
        let mut energy_density = vec![0.0; self.engine.gel().potential.len()];
        for (patch, energy) in measured.energy.iter().enumerate() {
            let elements = potential.patches().of(patch);
            let volume: f64 = elements.iter().map(|element| potential.volume(*element)).sum();
            for element in elements {
                energy_density[element.index()] = energy / (volume * self.recipe.copies());
            }
        }
        FrameCells {
            nodes: self.engine.gel().potential.elements().iter().map(|nodes| nodes.map(|n| n.0)).collect(),
            step: self.engine.steps(),
            jacobian: measured.jacobian,
            energy_density,
            facets: self.facets.iter().map(|nodes| nodes.map(|n| n.0)).collect(),
        }
    }

    fn longest_step(&self, node: NodeId) -> f64 {
        let steps = self.engine.gel().star.of(node).iter().map(|element| self.engine.step_of(*element));
        self.engine.grid().time(steps.max().unwrap_or(0))
    }
}

impl<const D: usize> Model for Gelatin<D>
where
    State<D>: Erase,
    Self: Renew,
{
    fn advance_to(&mut self, t: f64, exchanges: &mut [Exchange]) -> Result<(), StepError> {
        while self.engine.advance_to(t, exchanges)? == Reached::Worn {
            self.renew()?;
        }
        Ok(())
    }

    fn rehearse(&mut self, from: f64, t: f64, exchanges: &mut [Exchange]) -> Result<Option<Rehearsal>, StepError> {
        while self.engine.advance_to(t, exchanges)? == Reached::Worn {
            let time = self.engine.now();
            let shown = if time >= from { self.rehearsal(self.frame(time)) } else { None };
            self.renew()?;
            if shown.is_some() {
                return Ok(shown);
            }
        }
        Ok(None)
    }

    fn refusals(&self) -> &[Refusal] {
        &self.refusals
    }

    fn renewals(&self) -> &[Renewal] {
        &self.renewals
    }

    fn n_bodies(&self) -> usize {
        self.engine.bodies().len()
    }

    fn body(&self, i: usize) -> (&Body, &BodyState) {
        (&self.engine.bodies()[i], &self.engine.state().bodies[i])
    }

    fn rebase_body(&mut self, i: usize, t: f64) {
        self.engine.rebase_body(i, t);
    }

    fn set_body(&mut self, i: usize, state: &BodyState) {
        self.engine.set_body(i, state);
    }

    fn ledger_mut(&mut self) -> &mut Ledger {
        self.engine.ledger_mut()
    }

    fn record(&self) -> &Record {
        &self.engine.state().record
    }

    fn is_at_rest(&self) -> bool {
        self.engine.is_at_rest()
    }

    fn is_away(&self, i: usize, at: &BodyState) -> bool {
        self.engine.is_body_away(i, at)
    }

    fn totals(&self, t: f64) -> Totals {
        self.engine.totals(t)
    }

    fn reach(&self, i: usize, t: f64) -> Reach {
        let (body, last) = self.body(i);
        let at = last.at(body, t);
        let mut reach = Reach::default();
        if !at.active || self.engine.is_at_rest() {
            return reach;
        }
        for surface in &self.engine.gel().surface.nodes {
            let gap = body.gap(&at, &embed(&self.engine.position_at(surface.node, t))).distance;
            reach.penetration = reach.penetration.max(-gap);
            if gap <= TOUCHING * surface.size {
                reach.area += surface.area;
                reach.longest_step = reach.longest_step.max(self.longest_step(surface.node));
            }
        }
        reach
    }

    fn overlap(&self, i: usize, at: &BodyState) -> Option<f64> {
        let gel = self.engine.gel();
        let position = |node| embed(&self.engine.position_at(node, self.engine.gel_time(at.time)));
        overlap(gel, (self.body(i).0, at), (position, |node| self.longest_step(node)))
    }

    fn swallows(&self, i: usize, at: &BodyState) -> bool {
        let (gel, time) = (self.engine.gel(), self.engine.gel_time(at.time));
        let x: Vec<_> = (0..gel.mass.len() as u32).map(|n| self.engine.position_at(NodeId(n), time)).collect();
        is_swallowed((&x, gel.potential.elements()), (self.body(i).0, at))
    }

    fn noise(&self) -> f64 {
        self.recipe.noise(self.gel_mass())
    }

    fn shear_torque(&self) -> f64 {
        self.recipe.shear_torque(self.gel_mass())
    }

    fn counts(&self) -> (usize, usize, usize) {
        let crushed = self.engine.state().clocks.iter().map(|clock| clock.crushed as usize).sum();
        (self.engine.gel().potential.len(), self.engine.gel().mass.len(), crushed)
    }

    fn fallback(&self) -> f64 {
        let own = self.engine.state().birth.as_ref().map_or(0, |birth| birth.references.len());
        own as f64 / self.engine.gel().potential.len() as f64
    }

    fn steps(&self) -> (f64, f64) {
        let state = self.engine.state();
        if state.now.is_none() {
            let wider = |(least, most): (f64, f64), step: &f64| (least.min(*step), most.max(*step));
            return self.engine.steps().iter().fold((f64::INFINITY, 0.0), wider);
        }
        let wider = |(least, most): (Tick, Tick), clock: &Clock| (least.min(clock.step), most.max(clock.step));
        let (least, most) = state.clocks.iter().fold((Tick::MAX, 0), wider);
        (self.engine.grid().time(least), self.engine.grid().time(most))
    }

    fn synchronous_updates(&self, t: f64) -> f64 {
        self.engine.synchronous_updates(t)
    }

    fn frame(&self, t: f64) -> Frame {
        let (n, gel_time) = (self.engine.gel().mass.len() as u32, self.engine.gel_time(t));
        let points: Vec<Vector3> = (0..n).map(|i| embed(&self.engine.position_at(NodeId(i), gel_time))).collect();
        let displacements =
            points.iter().zip(self.engine.gel().potential.rest()).map(|(x, rest)| x - embed(rest)).collect();
        let place = |i: usize| {
            let (body, last) = self.body(i);
            let at = last.at(body, t);
            Place { kinematics: super::Kinematics::of(body, &at), bulge: at.bulge, active: at.active }
        };
        Frame {
            time: t,
            dimension: D,
            mass: self.gel_mass(),
            points,
            velocities: self.engine.state().velocity.iter().map(embed).collect(),
            displacements,
            cells: self.cells(t),
            bodies: (0..self.n_bodies()).map(place).collect(),
        }
    }

    fn sensors(&self, t: f64) -> Vec<SensorReport> {
        self.measured(t)
    }

    fn save(&self, to: &mut SavedState) {
        match State::<D>::recall_mut(to) {
            Some(state) => state.clone_from(self.engine.state()),
            None => *to = self.engine.state().clone().erase(),
        }
    }

    fn restore(&mut self, saved: &SavedState, time: f64) -> Result<(), RestoreError> {
        let state = State::<D>::recall(saved).ok_or(RestoreError::Foreign)?;
        self.engine.check_time(state, time).map_err(|what| RestoreError::Inconsistent { what })?;
        self.go_back(state)
    }

    fn latest(&self) -> f64 {
        self.engine.grid().length(MOST_TICKS)
    }

    fn digest(&self) -> u128 {
        self.engine.state().digest()
    }

    fn bytes(&self) -> usize {
        self.engine.bytes()
    }

    fn state_bytes(&self) -> usize {
        self.engine.state().bytes()
    }

    fn mesh_size(&self) -> MeshSize {
        let potential = &self.engine.gel().potential;
        MeshSize { elements: potential.len() as f64, is_spatial: D == 3, remembers: potential.remembers() }
    }

    fn can_remesh(&self) -> bool {
        self.recipe.remesh.is_some()
    }

    fn runs(&self) -> Vec<Run<'_>> {
        self.engine.runs()
    }
}

/// Into and out of [`SavedState`].
pub(super) trait Erase: Sized {
    fn erase(self) -> SavedState;
    /// The state, unless it is of the other dimension.
    fn recall(saved: &SavedState) -> Option<&Self>;
    /// The same, to be written over.
    fn recall_mut(saved: &mut SavedState) -> Option<&mut Self>;
}

impl Erase for State<2> {
    fn erase(self) -> SavedState {
        SavedState::Flat(self)
    }

    fn recall(saved: &SavedState) -> Option<&Self> {
        match saved {
            SavedState::Flat(state) => Some(state),
            SavedState::Solid(_) => None,
        }
    }

    fn recall_mut(saved: &mut SavedState) -> Option<&mut Self> {
        match saved {
            SavedState::Flat(state) => Some(state),
            SavedState::Solid(_) => None,
        }
    }
}

impl Erase for State<3> {
    fn erase(self) -> SavedState {
        SavedState::Solid(self)
    }

    fn recall(saved: &SavedState) -> Option<&Self> {
        match saved {
            SavedState::Solid(state) => Some(state),
            SavedState::Flat(_) => None,
        }
    }

    fn recall_mut(saved: &mut SavedState) -> Option<&mut Self> {
        match saved {
            SavedState::Solid(state) => Some(state),
            SavedState::Flat(_) => None,
        }
    }
}
