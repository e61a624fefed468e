//! Gel of either dimension behind one interface.

use super::fields::FieldSource;
use super::kinematics::BodyKinematics;
use super::memory::MeshSize;
use super::observe::{BodyPose, FrameCells, FrameField, MeshFrame, RemeshPreview, SensorReport};
use super::saved::{EraseDimension, SavedState};
use super::sensors::{LocatedSensor, locate_sensors};
use crate::adapt::{AdaptiveGel, FailedRemesh, RemeshDriver, RemeshRecord, RestoreError};
use crate::contact::{BodyState, ImpulseExchange, RigidBody, SurfaceNode};
use crate::fem::{HistoryVariables, Potential};
use crate::integrator::{AdvanceOutcome, BalanceTotals, BlockMotion, DiscreteGel, GelFrame, StepError};
use crate::ledger::Ledger;
use crate::math::{Vector, Vector3, embed, restrict};
use crate::mesh::{NodeId, Simplex};
use crate::remesh;
use crate::scene::OutputField;
use crate::state::{DynamicState, GroupClock, RunRecord, Tick};

/// Current extent of the contact with a body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct ContactReach {
    /// Area of the surface nodes within a tenth of their size of the body, m².
    pub area: f64,
    /// Deepest penetration, m.
    pub penetration: f64,
    /// Longest step of a patch at those nodes, s.
    pub longest_step: f64,
}

/// Numbers of elements and nodes of a mesh.
pub(super) struct MeshCounts {
    pub elements: usize,
    pub nodes: usize,
    /// Elements compressed below the start of the continuation.
    pub crushed: usize,
}

/// Range of element steps, s.
pub(super) struct StepRange {
    pub smallest: f64,
    pub largest: f64,
}

/// Gel independent of its dimension, as the simulation drives and observes it.
pub(super) trait ErasedModel: Send {
    /// Advances to time `until`, s, within a communication step that ends at `end`, s.
    fn advance_part(&mut self, until: f64, end: f64, exchanges: &mut [ImpulseExchange]) -> Result<(), StepError>;
    /// Advances to the first remeshing from time `from` on and returns its preview, or to time `t` if there is none.
    fn preview_remesh(
        &mut self,
        from: f64,
        t: f64,
        exchanges: &mut [ImpulseExchange],
    ) -> Result<Option<RemeshPreview>, StepError>;
    /// Remeshings since the gel was built.
    fn remesh_records(&self) -> &[RemeshRecord];
    fn failed_remeshes(&self) -> &[FailedRemesh];
    fn n_bodies(&self) -> usize;
    /// Constants of a body, and its state at its last event.
    fn body(&self, i: usize) -> (&RigidBody, &BodyState);
    fn rebase_body(&mut self, i: usize, t: f64);
    fn set_body(&mut self, i: usize, state: &BodyState);
    fn ledger_mut(&mut self) -> &mut Ledger;
    fn record(&self) -> &RunRecord;
    /// Returns true if the gel is no longer integrated.
    fn is_at_rest(&self) -> bool;
    /// Sets the time from the exit of the projectile until the gel is put to rest, s.
    fn set_rest_after(&mut self, time: f64);
    /// Returns true if a body at this state no longer meets the gel.
    fn is_away(&self, i: usize, at: &BodyState) -> bool;
    /// Frame of the block.
    fn block_frame(&self) -> &GelFrame;
    /// Rigid motion of the block at time `t`.
    fn block_motion(&self, t: f64) -> BlockMotion;
    fn totals(&self, t: f64) -> BalanceTotals;
    /// Extent of the contact with a body at time `t`.
    fn reach(&self, i: usize, t: f64) -> ContactReach;
    /// Depth of the gel's surface, m, inside a body placed in this state, until the next contact query of the gel;
    /// `None` if the depth is tolerable.
    fn overlap(&self, i: usize, at: &BodyState) -> Option<f64>;
    /// Returns true if a body in this state would have gel around its centre.
    fn is_centre_in_gel(&self, i: usize, at: &BodyState) -> bool;
    /// Round-off of the energy of the gel at rest, J.
    fn energy_round_off(&self) -> f64;
    /// Shear modulus times volume: the torque of stresses of the size of the shear modulus, N·m.
    fn shear_torque(&self) -> f64;
    /// Numbers of elements and nodes.
    fn counts(&self) -> MeshCounts;
    /// Fraction of the elements whose rest shape is not that of their nodes' rest positions.
    fn incompatible_fraction(&self) -> f64;
    /// Range of the current element steps.
    fn steps(&self) -> StepRange;
    fn synchronous_updates(&self, t: f64) -> f64;
    fn frame(&self, t: f64) -> MeshFrame;
    /// Corners of the boundary facets at time `t`, outward oriented, `dimension` used.
    fn facet_corners(&self, t: f64) -> Vec<[Vector3; 3]>;
    /// Greatest diameter of the cavity at time `t` between two depths, m, of a model without a surface to be cut.
    fn opened_diameter(&self, _t: f64, _first: f64, _rear: f64) -> Option<f64> {
        None
    }
    /// Reports of the sensors at time `t`.
    fn sensors(&self, t: f64) -> Vec<SensorReport>;
    /// Writes the state over another one, reusing its memory if it is of the same dimension.
    fn save(&self, to: &mut SavedState);
    /// Continues from a saved state that has reached `time`, s.
    fn restore(&mut self, saved: &SavedState, time: f64) -> Result<(), RestoreError>;
    /// Latest time whose ticks are exact, s.
    fn latest(&self) -> f64;
    fn digest(&self) -> u128;
    fn bytes(&self) -> usize;
    /// Bytes of a copy of the state.
    fn state_bytes(&self) -> usize;
    fn mesh_size(&self) -> MeshSize;
    /// Masses of the materials of the gel, kg, front to back.
    fn material_masses(&self) -> Vec<f64>;
    /// Returns true if the scene has remeshing.
    fn can_remesh(&self) -> bool;
}

/// Gel of simplices, its sensors and the fields of its frames.
pub(super) struct GelModel<const D: usize> {
    pub gel: AdaptiveGel<D>,
    pub sensors: Vec<LocatedSensor<D>>,
    pub fields: Vec<OutputField>,
}

/// Greatest number of ticks: a tick times q ≤ 31 stays below 2⁵³ (method A3).
pub(super) const MOST_TICKS: f64 = 2.8e14;
/// Overlap at the start that contact tolerates, in element sizes.
const OVERLAP_TOLERANCE: f64 = 0.1;

/// Depth of the deepest surface node, m, inside a body that moves on for the node's `wait`, s; `None` if contact
/// tolerates it.
pub(super) fn overlap<const D: usize, P>(
    gel: &DiscreteGel<D, P>,
    body: &RigidBody,
    at: &BodyState,
    position: impl Fn(NodeId) -> Vector3,
    wait: impl Fn(NodeId) -> f64,
) -> Option<f64> {
    let too_deep = |surface: &SurfaceNode| {
        let x = position(surface.node);
        let travel = body.velocity_at(at, &x).norm() * wait(surface.node);
        let depth = travel - body.gap(at, &x).distance;
        (depth > OVERLAP_TOLERANCE * surface.size).then_some(depth)
    };
    gel.surface.nodes.iter().filter_map(too_deep).reduce(f64::max)
}

/// Returns true if the centre of a body lies in the gel and in the body itself. The gel's surface may then be too far
/// away for contact to find the overlap.
pub(super) fn is_centre_in_gel<const D: usize>(
    x: &[Vector<D>],
    elements: &[Simplex],
    body: &RigidBody,
    at: &BodyState,
) -> bool {
    let centre = restrict::<D>(&at.position);
    body.gap(at, &at.position).distance < 0.0 && remesh::is_inside(x, elements, &centre)
}

/// Returns the damage of an element from its first record of history variables.
fn damage_of<const D: usize>(first: &HistoryVariables<D>) -> f64 {
    first.damage
}

/// Fraction of an element's size within which a node counts as in contact.
const TOUCHING: f64 = 0.1;

impl<const D: usize> GelModel<D> {
    fn cells(&self, t: f64) -> FrameCells {
        let (measured, potential) = (self.gel.engine.measure_at(t), &self.gel.engine.gel().potential);
        let mut energy_density = vec![0.0; self.gel.engine.gel().potential.len()];
        for (patch, energy) in measured.energy.iter().enumerate() {
            let elements = potential.patches().of(patch);
            let volume: f64 = elements.iter().map(|element| potential.volume(*element)).sum();
            for element in elements {
                energy_density[element.index()] = energy / (volume * self.gel.definition.copies());
            }
        }
        FrameCells {
            nodes: self.gel.engine.gel().potential.elements().iter().map(|nodes| nodes.map(|n| n.0)).collect(),
            step: self.gel.engine.steps(),
            jacobian: measured.jacobian,
            energy_density,
            damage: self.damage(),
            facets: self.gel.facets.iter().map(|nodes| nodes.map(|n| n.0)).collect(),
        }
    }

    /// Returns the damage of each element, 0 to 1.
    fn damage(&self) -> Vec<f64> {
        let potential = &self.gel.engine.gel().potential;
        let records = self.gel.engine.state().memory.chunks(potential.memories().max(1));
        let mut damage: Vec<f64> = records.map(|records| damage_of(&records[0])).collect();
        damage.resize(potential.len(), 0.0);
        damage
    }

    /// Returns the fields of a frame; no cost without fields.
    fn fields(&self, t: f64) -> Vec<FrameField> {
        if self.fields.is_empty() {
            return vec![];
        }
        FieldSource::new(&self.gel.engine, self.gel.definition.copies(), t).evaluate(&self.fields)
    }

    fn longest_step(&self, node: NodeId) -> f64 {
        let steps = self.gel.engine.gel().star.of(node).iter().map(|element| self.gel.engine.step_of(*element));
        self.gel.engine.grid().time(steps.max().unwrap_or(0))
    }
}

impl<const D: usize> GelModel<D>
where
    AdaptiveGel<D>: RemeshDriver,
{
    /// Continues with a better mesh, and finds the sensors in it. The mesh may be another one even after an error.
    fn remesh(&mut self) -> Result<(), StepError> {
        let outcome = self.gel.remesh();
        locate_sensors(&mut self.sensors, &self.gel.engine);
        outcome
    }
}

impl<const D: usize> ErasedModel for GelModel<D>
where
    DynamicState<D>: EraseDimension,
    AdaptiveGel<D>: RemeshDriver,
{
    fn advance_part(&mut self, until: f64, end: f64, exchanges: &mut [ImpulseExchange]) -> Result<(), StepError> {
        while self.gel.engine.advance_part(until, end, exchanges)? == AdvanceOutcome::MeshEnded {
            self.remesh()?;
        }
        Ok(())
    }

    fn preview_remesh(
        &mut self,
        from: f64,
        t: f64,
        exchanges: &mut [ImpulseExchange],
    ) -> Result<Option<RemeshPreview>, StepError> {
        while self.gel.engine.advance_to(t, exchanges)? == AdvanceOutcome::MeshEnded {
            let time = self.gel.engine.now();
            let trial = if time >= from { self.gel.try_remesh() } else { None };
            let shown = trial.map(|trial| RemeshPreview { frame: self.frame(time), trial });
            self.remesh()?;
            if shown.is_some() {
                return Ok(shown);
            }
        }
        Ok(None)
    }

    fn failed_remeshes(&self) -> &[FailedRemesh] {
        &self.gel.failed_remeshes
    }

    fn remesh_records(&self) -> &[RemeshRecord] {
        &self.gel.remesh_records
    }

    fn n_bodies(&self) -> usize {
        self.gel.engine.bodies().len()
    }

    fn body(&self, i: usize) -> (&RigidBody, &BodyState) {
        (&self.gel.engine.bodies()[i], &self.gel.engine.state().bodies[i])
    }

    fn rebase_body(&mut self, i: usize, t: f64) {
        self.gel.engine.rebase_body(i, t);
    }

    fn set_body(&mut self, i: usize, state: &BodyState) {
        self.gel.engine.set_body(i, state);
    }

    fn ledger_mut(&mut self) -> &mut Ledger {
        self.gel.engine.ledger_mut()
    }

    fn record(&self) -> &RunRecord {
        &self.gel.engine.state().record
    }

    fn is_at_rest(&self) -> bool {
        self.gel.engine.is_at_rest()
    }

    fn set_rest_after(&mut self, time: f64) {
        self.gel.engine.set_rest_after(time);
    }

    fn is_away(&self, i: usize, at: &BodyState) -> bool {
        self.gel.engine.is_body_away(i, at)
    }

    fn block_frame(&self) -> &GelFrame {
        self.gel.engine.frame()
    }

    fn block_motion(&self, t: f64) -> BlockMotion {
        self.gel.engine.block_motion(t)
    }

    fn totals(&self, t: f64) -> BalanceTotals {
        self.gel.engine.totals(t)
    }

    fn reach(&self, i: usize, t: f64) -> ContactReach {
        let (body, last) = self.body(i);
        let at = last.at(body, t);
        let mut reach = ContactReach::default();
        if !at.active || self.gel.engine.is_at_rest() {
            return reach;
        }
        for surface in &self.gel.engine.gel().surface.nodes {
            let gap = body.gap(&at, &embed(&self.gel.engine.position_at(surface.node, t))).distance;
            reach.penetration = reach.penetration.max(-gap);
            if gap <= TOUCHING * surface.size {
                reach.area += surface.area;
                reach.longest_step = reach.longest_step.max(self.longest_step(surface.node));
            }
        }
        reach
    }

    fn overlap(&self, i: usize, at: &BodyState) -> Option<f64> {
        let gel = self.gel.engine.gel();
        let position = |node| embed(&self.gel.engine.position_at(node, self.gel.engine.time_in_gel(at.time)));
        overlap(gel, self.body(i).0, at, position, |node| self.longest_step(node))
    }

    fn is_centre_in_gel(&self, i: usize, at: &BodyState) -> bool {
        let (gel, time) = (self.gel.engine.gel(), self.gel.engine.time_in_gel(at.time));
        let x: Vec<_> = (0..gel.mass.len() as u32).map(|n| self.gel.engine.position_at(NodeId(n), time)).collect();
        is_centre_in_gel(&x, gel.potential.elements(), self.body(i).0, at)
    }

    fn energy_round_off(&self) -> f64 {
        self.gel.definition.energy_round_off(self.gel.mass())
    }

    fn shear_torque(&self) -> f64 {
        self.gel.definition.shear_torque(self.gel.mass())
    }

    fn counts(&self) -> MeshCounts {
        let crushed = self.gel.engine.state().clocks.iter().map(|clock| clock.crushed as usize).sum();
        MeshCounts { elements: self.gel.engine.gel().potential.len(), nodes: self.gel.engine.gel().mass.len(), crushed }
    }

    fn incompatible_fraction(&self) -> f64 {
        let own = self.gel.engine.state().birth.as_ref().map_or(0, |birth| birth.references.len());
        own as f64 / self.gel.engine.gel().potential.len() as f64
    }

    fn steps(&self) -> StepRange {
        let state = self.gel.engine.state();
        if state.now.is_none() {
            let steps = self.gel.engine.steps();
            return StepRange {
                smallest: steps.iter().copied().fold(f64::INFINITY, f64::min),
                largest: steps.iter().copied().fold(0.0, f64::max),
            };
        }
        let wider = |(least, most): (Tick, Tick), clock: &GroupClock| (least.min(clock.step), most.max(clock.step));
        let (least, most) = state.clocks.iter().fold((Tick::MAX, 0), wider);
        StepRange { smallest: self.gel.engine.grid().time(least), largest: self.gel.engine.grid().time(most) }
    }

    fn synchronous_updates(&self, t: f64) -> f64 {
        self.gel.engine.synchronous_updates(t)
    }

    fn facet_corners(&self, t: f64) -> Vec<[Vector3; 3]> {
        let time = self.gel.engine.time_in_gel(t);
        let corner = |node: NodeId| embed(&self.gel.engine.position_at(node, time));
        self.gel.facets.iter().map(|nodes| nodes.map(corner)).collect()
    }

    fn frame(&self, t: f64) -> MeshFrame {
        let (n, gel_time) = (self.gel.engine.gel().mass.len() as u32, self.gel.engine.time_in_gel(t));
        let points: Vec<Vector3> = (0..n).map(|i| embed(&self.gel.engine.position_at(NodeId(i), gel_time))).collect();
        let displacements =
            points.iter().zip(self.gel.engine.gel().potential.rest()).map(|(x, rest)| x - embed(rest)).collect();
        let place = |i: usize| {
            let (body, last) = self.body(i);
            let at = last.at(body, t);
            BodyPose { kinematics: BodyKinematics::of(body, &at), shape_motion: at.shape_motion, active: at.active }
        };
        MeshFrame {
            time: t,
            dimension: D,
            mass: self.gel.mass(),
            points,
            velocities: self.gel.engine.state().velocity.iter().map(embed).collect(),
            displacements,
            cells: self.cells(t),
            fields: self.fields(t),
            bodies: (0..self.n_bodies()).map(place).collect(),
            block: self.block_motion(t),
            gel_displacement: self.block_motion(gel_time).displacement,
        }
    }

    fn sensors(&self, t: f64) -> Vec<SensorReport> {
        self.sensors.iter().map(|sensor| sensor.report(&self.gel.engine, self.gel.definition.copies(), t)).collect()
    }

    fn save(&self, to: &mut SavedState) {
        match DynamicState::<D>::downcast_mut(to) {
            Some(state) => state.clone_from(self.gel.engine.state()),
            None => *to = self.gel.engine.state().clone().erase(),
        }
    }

    fn restore(&mut self, saved: &SavedState, time: f64) -> Result<(), RestoreError> {
        let state = DynamicState::<D>::downcast(saved).ok_or(RestoreError::Foreign)?;
        self.gel.engine.check_time(state, time).map_err(|what| RestoreError::Inconsistent { what })?;
        if self.gel.restore(state)? {
            locate_sensors(&mut self.sensors, &self.gel.engine);
        }
        Ok(())
    }

    fn latest(&self) -> f64 {
        self.gel.engine.grid().length(MOST_TICKS)
    }

    fn digest(&self) -> u128 {
        self.gel.engine.state().digest()
    }

    fn bytes(&self) -> usize {
        self.gel.engine.bytes()
    }

    fn state_bytes(&self) -> usize {
        self.gel.engine.state().bytes()
    }

    fn material_masses(&self) -> Vec<f64> {
        self.gel.material_masses()
    }

    fn mesh_size(&self) -> MeshSize {
        let potential = &self.gel.engine.gel().potential;
        MeshSize {
            elements: potential.len() as f64,
            is_spatial: D == 3,
            has_history: potential.remembers(),
            fields: self.fields.len(),
        }
    }

    fn can_remesh(&self) -> bool {
        self.gel.definition.remesh.is_some()
    }
}
