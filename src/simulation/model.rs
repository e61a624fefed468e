//! A gel of either dimension behind one interface.

use super::RestoreError;
use super::observe::{Frame, FrameCells};
use crate::algebra::{Vector3, embed};
use crate::avi::{Engine, StepError, Totals};
use crate::contact::{Body, BodyState, Exchange};
use crate::element::{Potential, Simplices};
use crate::ledger::Ledger;
use crate::mesh::{ElementId, Mesh};
use crate::state::{Record, State};
use serde::{Deserialize, Serialize};

/// The stored state of a gel of either dimension.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum SavedState {
    /// Planar or axisymmetric.
    Flat(State<2>),
    /// Spatial.
    Solid(State<3>),
}

/// Reach of the contact now.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Reach {
    /// Area of the nodes within a tenth of their size of the body, m².
    pub area: f64,
    /// Deepest penetration, m.
    pub penetration: f64,
    /// Longest step of a patch of those nodes, s.
    pub longest_step: f64,
}

/// What the simulation asks of a gel, whatever its dimension.
pub(super) trait Model: Send {
    fn advance_to(&mut self, t: f64, exchange: &mut Exchange) -> Result<(), StepError>;
    fn body(&self) -> (&Body, &BodyState);
    fn rebase_body(&mut self, t: f64);
    fn set_body(&mut self, state: BodyState);
    fn ledger_mut(&mut self) -> &mut Ledger;
    fn record(&self) -> &Record;
    fn totals(&self, t: f64) -> Totals;
    fn reach(&self, t: f64) -> Reach;
    /// Elements, nodes, elements below the continuation.
    fn counts(&self) -> (usize, usize, usize);
    /// Smallest and largest step, s.
    fn steps(&self) -> (f64, f64);
    fn synchronous_updates(&self, t: f64) -> f64;
    fn frame(&self, t: f64) -> Frame;
    fn save(&self) -> SavedState;
    fn restore(&mut self, saved: &SavedState) -> Result<(), RestoreError>;
    fn digest(&self) -> u128;
}

/// A gel of simplices and the mesh it was made from.
pub(super) struct Gelatin<const D: usize> {
    pub engine: Engine<D, Simplices<D>>,
    pub mesh: Mesh<D>,
}

/// Fraction of an element's size within which a node counts as in contact.
const TOUCHING: f64 = 0.1;

impl<const D: usize> Gelatin<D> {
    fn cells(&self) -> FrameCells {
        let (clocks, gel) = (&self.engine.state().clocks, self.engine.gel());
        let volume = |i: usize| gel.potential.volume(ElementId(i as u32));
        FrameCells {
            nodes: self.mesh.elements.iter().map(|nodes| nodes.map(|n| n.0)).collect(),
            step: self.engine.steps(),
            jacobian: clocks.iter().map(|clock| clock.jacobian).collect(),
            energy_density: clocks.iter().enumerate().map(|(i, clock)| clock.energy / volume(i)).collect(),
            facets: self.mesh.facets.iter().map(|nodes| nodes.map(|n| n.0)).collect(),
        }
    }

    fn longest_step(&self, node: crate::mesh::NodeId) -> f64 {
        let clocks = &self.engine.state().clocks;
        let steps = self.engine.gel().star.of(node).iter().map(|patch| clocks[patch.index()].step);
        self.engine.grid().time(steps.max().unwrap_or(0))
    }
}

impl<const D: usize> Model for Gelatin<D>
where
    State<D>: Erase,
{
    fn advance_to(&mut self, t: f64, exchange: &mut Exchange) -> Result<(), StepError> {
        self.engine.advance_to(t, exchange)
    }

    fn body(&self) -> (&Body, &BodyState) {
        (self.engine.body(), &self.engine.state().body)
    }

    fn rebase_body(&mut self, t: f64) {
        self.engine.rebase_body(t);
    }

    fn set_body(&mut self, state: BodyState) {
        self.engine.set_body(state);
    }

    fn ledger_mut(&mut self) -> &mut Ledger {
        self.engine.ledger_mut()
    }

    fn record(&self) -> &Record {
        &self.engine.state().record
    }

    fn totals(&self, t: f64) -> Totals {
        self.engine.totals(t)
    }

    fn reach(&self, t: f64) -> Reach {
        let (body, last) = self.body();
        let at = last.at(body, t);
        let mut reach = Reach::default();
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

    fn counts(&self) -> (usize, usize, usize) {
        let crushed = |clock: &&crate::state::Clock| self.engine.gel().potential.is_crushed(clock.jacobian);
        (self.mesh.elements.len(), self.mesh.rest.len(), self.engine.state().clocks.iter().filter(crushed).count())
    }

    fn steps(&self) -> (f64, f64) {
        let steps = self.engine.steps();
        steps.iter().fold((f64::INFINITY, 0.0), |(least, most): (f64, f64), step| (least.min(*step), most.max(*step)))
    }

    fn synchronous_updates(&self, t: f64) -> f64 {
        self.engine.synchronous_updates(t)
    }

    fn frame(&self, t: f64) -> Frame {
        let n = self.mesh.rest.len() as u32;
        let points: Vec<Vector3> = (0..n).map(|i| embed(&self.engine.position_at(crate::mesh::NodeId(i), t))).collect();
        let displacements = points.iter().zip(&self.mesh.rest).map(|(x, rest)| x - embed(rest)).collect();
        let (body, last) = self.body();
        Frame {
            time: t,
            dimension: D,
            points,
            velocities: self.engine.state().velocity.iter().map(embed).collect(),
            displacements,
            cells: self.cells(),
            projectile: super::Kinematics::of(body, &last.at(body, t)),
        }
    }

    fn save(&self) -> SavedState {
        self.engine.state().clone().erase()
    }

    fn restore(&mut self, saved: &SavedState) -> Result<(), RestoreError> {
        let state = State::<D>::recall(saved).ok_or(RestoreError::Foreign)?;
        self.engine.check(state).map_err(|what| RestoreError::Inconsistent { what })?;
        self.engine.restore(state.clone());
        Ok(())
    }

    fn digest(&self) -> u128 {
        self.engine.state().digest()
    }
}

/// Into and out of [`SavedState`].
pub(super) trait Erase: Sized {
    fn erase(self) -> SavedState;
    /// The state, unless it is of the other dimension.
    fn recall(saved: &SavedState) -> Option<&Self>;
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
}
