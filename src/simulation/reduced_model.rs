//! Reduced model of a scene behind the interface of the finite elements.

use super::build_error::BuildError;
use super::kinematics::BodyKinematics;
use super::memory::MeshSize;
use super::model::{ContactReach, ErasedModel, MOST_TICKS, MeshCounts, StepRange};
use super::observe::{BodyPose, MeshFrame, RemeshPreview, SensorReport};
use super::reduced_section::{REDUCED_ELEMENTS, SectionGrid};
use super::saved::SavedState;
use super::scene_bodies::build_body;
use crate::adapt::{FailedRemesh, RemeshRecord, RestoreError};
use crate::contact::{BodyState, ImpulseExchange, RigidBody};
use crate::geometry::SignedDistance;
use crate::integrator::{BalanceTotals, BlockMotion, ExitRule, GelFrame, StepError, rebase_body};
use crate::ledger::Ledger;
use crate::math::Vector3;
use crate::reduced::{IdentifiedClass, ReducedTarget, TargetBlock};
use crate::scene::{FaceSupport, GelShape, Scene};
use crate::state::RunRecord;
use std::f64::consts::PI;

/// Reduced model with the section of its frames.
pub(super) struct ReducedModel {
    target: ReducedTarget,
    section: SectionGrid,
}

/// Builds the reduced model of a checked scene; `prescribed` if the importer gives the motion of the body.
pub(super) fn build_reduced(
    scene: &Scene,
    class: &IdentifiedClass,
    prescribed: bool,
) -> Result<Box<dyn ErasedModel>, BuildError> {
    let GelShape::Cylinder { radius, height, .. } = scene.gel.shape else {
        unreachable!("the gel of a reduced model is a cylinder: the scene was checked")
    };
    let (body, at) = build_body(scene, 0, prescribed);
    let depth = body.depth(&at);
    if at.active && depth > OVERLAP * body.shape.inner_radius() {
        return Err(BuildError::Overlap { body: crate::scene::body_name(0), depth });
    }
    let supports = &scene.gel.supports;
    let holds = [supports.z_min, supports.z_max].iter().any(|support| *support != FaceSupport::Free)
        || supports.side == FaceSupport::Fixed;
    let mass = PI * radius * radius * height * scene.gel.density;
    let free = if holds { Vector3::zeros() } else { Vector3::z() };
    let frame =
        GelFrame { initial_velocity: Vector3::from(scene.gel.velocity).component_mul(&free), mobility: free / mass };
    let follows = frame.initial_velocity == Vector3::from(scene.gel.velocity);
    let exits = follows.then(|| ExitRule {
        back_face: -height,
        half_width: [radius; 2],
        rest_after: scene.scene.stop_after_exit.time(),
    });
    let block = TargetBlock {
        radius,
        thickness: height,
        density: scene.gel.density,
        frame,
        exits,
        force_window: scene.force_window(),
    };
    let target = ReducedTarget::new(block, class.clone(), body, at);
    let section = SectionGrid::of(&target);
    Ok(Box::new(ReducedModel { target, section }))
}

/// Depth of a body in the gel at the start that is tolerated, in radii.
const OVERLAP: f64 = 1e-3;

impl ReducedModel {
    /// Returns the state of the body as it is seen from the block.
    fn seen(&self, at: &BodyState) -> BodyState {
        self.target.block_motion(at.time).seen_from(at)
    }
}

impl ErasedModel for ReducedModel {
    fn advance_part(&mut self, until: f64, end: f64, exchanges: &mut [ImpulseExchange]) -> Result<(), StepError> {
        self.target.advance(until, end, &mut exchanges[0]);
        Ok(())
    }

    fn preview_remesh(
        &mut self,
        _from: f64,
        t: f64,
        exchanges: &mut [ImpulseExchange],
    ) -> Result<Option<RemeshPreview>, StepError> {
        self.advance_part(t, t, exchanges).map(|()| None)
    }

    fn remesh_records(&self) -> &[RemeshRecord] {
        &[]
    }

    fn failed_remeshes(&self) -> &[FailedRemesh] {
        &[]
    }

    fn n_bodies(&self) -> usize {
        1
    }

    fn body(&self, i: usize) -> (&RigidBody, &BodyState) {
        (&self.target.body, &self.target.state().bodies[i])
    }

    fn rebase_body(&mut self, i: usize, t: f64) {
        let rigid = self.target.body.clone();
        let state = self.target.state_mut();
        rebase_body(&rigid, &mut state.bodies[i], &mut state.ledger, t);
    }

    fn set_body(&mut self, _i: usize, state: &BodyState) {
        self.target.set_body(state);
    }

    fn ledger_mut(&mut self) -> &mut Ledger {
        &mut self.target.state_mut().ledger
    }

    fn record(&self) -> &RunRecord {
        &self.target.state().record
    }

    fn is_at_rest(&self) -> bool {
        self.record().at_rest
    }

    fn set_rest_after(&mut self, time: f64) {
        if let Some(rule) = &mut self.target.block.exits {
            rule.rest_after = time;
        }
    }

    fn is_away(&self, _i: usize, at: &BodyState) -> bool {
        self.target.exit(at).is_away()
    }

    fn block_frame(&self) -> &GelFrame {
        &self.target.block.frame
    }

    fn block_motion(&self, t: f64) -> BlockMotion {
        self.target.block_motion(t)
    }

    fn totals(&self, t: f64) -> BalanceTotals {
        self.target.totals(t)
    }

    fn reach(&self, i: usize, t: f64) -> ContactReach {
        let (body, last) = self.body(i);
        let at = last.at(body, t);
        let depth = body.depth(&self.seen(&at));
        let radius = body.reach(&at, &Vector3::x());
        let touches = at.active && depth > 0.0 && !self.is_at_rest() && self.record().contacts[i].exit.is_none();
        let area = if touches { PI * radius * radius } else { 0.0 };
        ContactReach { area, penetration: 0.0, longest_step: self.steps().largest }
    }

    fn overlap(&self, i: usize, at: &BodyState) -> Option<f64> {
        let depth = self.body(i).0.depth(&self.seen(at));
        (depth > OVERLAP * self.target.body.shape.inner_radius()).then_some(depth)
    }

    fn is_centre_in_gel(&self, _i: usize, at: &BodyState) -> bool {
        let depth = -self.seen(at).position.z;
        let is_open = self.target.opening(depth, at.time).squared_radius > 0.0;
        depth > 0.0 && depth < self.target.block.thickness && !is_open
    }

    fn energy_round_off(&self) -> f64 {
        0.0
    }

    fn shear_torque(&self) -> f64 {
        0.0
    }

    fn counts(&self) -> MeshCounts {
        MeshCounts { elements: REDUCED_ELEMENTS, nodes: self.section.n_nodes(), crushed: 0 }
    }

    fn incompatible_fraction(&self) -> f64 {
        0.0
    }

    fn steps(&self) -> StepRange {
        let state = self.target.state();
        let step = ReducedTarget::time_of(state.next - state.now.unwrap_or(0));
        StepRange { smallest: step, largest: step }
    }

    fn synchronous_updates(&self, _t: f64) -> f64 {
        self.record().updates as f64
    }

    fn frame(&self, t: f64) -> MeshFrame {
        let place = |i: usize| {
            let (body, last) = self.body(i);
            let at = last.at(body, t);
            BodyPose { kinematics: BodyKinematics::of(body, &at), shape_motion: at.shape_motion, active: at.active }
        };
        self.section.frame(&self.target, t, vec![place(0)])
    }

    fn facet_corners(&self, t: f64) -> Vec<[Vector3; 3]> {
        let frame = self.frame(t);
        frame.cells.facets.iter().map(|nodes| nodes.map(|node| frame.points[node as usize])).collect()
    }

    fn opened_diameter(&self, t: f64, first: f64, rear: f64) -> Option<f64> {
        Some(self.target.greatest_diameter(t, first, rear))
    }

    fn sensors(&self, _t: f64) -> Vec<SensorReport> {
        vec![]
    }

    fn save(&self, to: &mut SavedState) {
        *to = SavedState::Reduced(Box::new(self.target.state().clone()));
    }

    fn restore(&mut self, saved: &SavedState, _time: f64) -> Result<(), RestoreError> {
        let SavedState::Reduced(state) = saved else { return Err(RestoreError::Foreign) };
        self.target.restore(state).map_err(|what| RestoreError::Inconsistent { what })
    }

    fn latest(&self) -> f64 {
        ReducedTarget::time_of(1) * MOST_TICKS
    }

    fn digest(&self) -> u128 {
        self.target.state().digest()
    }

    fn bytes(&self) -> usize {
        size_of::<Self>() + self.state_bytes()
    }

    fn state_bytes(&self) -> usize {
        size_of::<crate::reduced::ReducedState>() + size_of_val(&self.target.state().rings[..])
    }

    fn mesh_size(&self) -> MeshSize {
        MeshSize { elements: REDUCED_ELEMENTS as f64, is_spatial: false, has_history: false, fields: 0 }
    }

    fn material_masses(&self) -> Vec<f64> {
        vec![self.target.gel_mass()]
    }

    fn can_remesh(&self) -> bool {
        false
    }
}
