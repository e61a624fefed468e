//! Simulation in time, as an importer steps it.

use super::build::build;
use super::build_error::BuildError;
use super::end_watch::{EndRules, EndWatch};
use super::gel::build_material;
use super::kinematics::{BodyKinematics, StepInputs};
use super::model::ErasedModel;
use super::observe::{MeshFrame, RemeshPreview};
use super::saved::SavedSimulation;
use super::scene_bodies::orientation;
use crate::adapt::{FailedRemesh, RemeshRecord, RestoreError};
use crate::constitutive::MaterialRatios;
use crate::contact::{BodyMotion, BodyState, ImpulseExchange, ShapeMotion, Wrench};
use crate::integrator::{BlockMotion, StepError};
use crate::ledger::Ledger;
use crate::math::Vector3;
use crate::scene::{CouplingMode, GelBox, Scene, layer_stack};

/// Gel and rigid bodies in time.
///
/// ```
/// use ballistic_gel::scene;
/// use ballistic_gel::simulation::{CouplingMode, Simulation};
///
/// let scene = scene::read(scene::builtin("ball-square").unwrap()).unwrap();
/// let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
/// let inputs = simulation.inputs();
/// simulation.step(&inputs, 1e-4).unwrap();
/// assert!(simulation.observe().energy.energy_error < 1e-10);
/// ```
pub struct Simulation {
    pub(super) model: Box<dyn ErasedModel>,
    pub(super) mode: CouplingMode,
    pub(super) constants: SceneConstants,
    pub(super) time: f64,
    pub(super) exchanges: Vec<ImpulseExchange>,
    failure: Option<StepError>,
    pub(super) watch: EndWatch,
    /// Kinematics of the bodies at the start of the current step; kept to reuse its memory.
    before: Vec<BodyKinematics>,
}

/// Constants of the scene that reports need.
pub(super) struct SceneConstants {
    /// Hash of the scene and the coupling mode.
    origin: u64,
    pub(super) end_time: f64,
    pub(super) force_window: f64,
    /// Contact modulus E* = E/(1 − ν²), Pa.
    pub(super) contact_modulus: f64,
    /// Specific acoustic impedance ρ c, Pa·s/m.
    pub(super) specific_impedance: f64,
    /// Round-off of the energy of the gel at rest, J.
    pub(super) energy_round_off: f64,
    /// Shear modulus times volume, μ V, N·m.
    pub(super) shear_torque: f64,
    /// Bounding box of the gel at rest; `None` for a shape without a back face.
    pub(super) gel_box: Option<GelBox>,
    pub(super) end_rules: EndRules,
}

impl SceneConstants {
    fn of(scene: &Scene, mode: CouplingMode, model: &dyn ErasedModel) -> Self {
        let material = build_material(&scene.gel);
        // The gel stiffens and loads the importer's body no more than the stiffest and heaviest layer.
        let layers = layer_stack(&scene.layer, &scene.gel);
        let most = layers.map_or(MaterialRatios::GEL, |stack| stack.greatest());
        Self {
            origin: xxhash_rust::xxh3::xxh3_64(format!("{scene:?} {mode:?}").as_bytes()),
            end_time: scene.scene.end_time,
            force_window: scene.force_window(),
            contact_modulus: most.strength * material.contact_modulus(),
            specific_impedance: (most.density
                * scene.gel.density
                * (most.bulk.max(most.strength) * material.wave_modulus()))
            .sqrt(),
            energy_round_off: model.energy_round_off(),
            shear_torque: model.shear_torque(),
            gel_box: scene.gel.shape.bounding_box(),
            end_rules: EndRules::of(scene, &model.block_motion(0.0).velocity),
        }
    }
}

impl Simulation {
    /// Builds the mesh and the initial state. `threads` 0 uses all cores; results do not depend on it.
    ///
    /// # Errors
    /// [`BuildError`] if the scene cannot be built.
    pub fn new(scene: &Scene, mode: CouplingMode, threads: usize) -> Result<Self, BuildError> {
        let model = build(scene, mode == CouplingMode::Prescribed, threads)?;
        let (constants, exchanges) =
            (SceneConstants::of(scene, mode, &*model), vec![ImpulseExchange::default(); model.n_bodies()]);
        let watch = EndWatch::default();
        let mut simulation =
            Self { model, mode, constants, time: 0.0, exchanges, failure: None, watch, before: vec![] };
        simulation.apply_watch();
        Ok(simulation)
    }

    /// Time since the start, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Latest time that can be stepped to, s: later ticks would not be exact.
    #[must_use]
    pub fn latest(&self) -> f64 {
        self.model.latest()
    }

    /// Number of bodies: the projectile, and the fragments after it.
    #[must_use]
    pub fn n_bodies(&self) -> usize {
        self.model.n_bodies()
    }

    /// Current motion of a body.
    #[must_use]
    pub fn kinematics(&self, body: usize) -> BodyKinematics {
        let (fixed, _) = self.model.body(body);
        BodyKinematics::of(fixed, &self.now(body))
    }

    /// Rigid motion of the block: what the gel moves by as a whole since the start, by the impulses on it. It is zero
    /// in directions in which a support or a plane of symmetry holds the gel, and for a gel without an entry face.
    #[must_use]
    pub fn block_motion(&self) -> BlockMotion {
        self.model.block_motion(self.time)
    }

    /// Current state of a body as it is seen from the block.
    pub(super) fn seen(&self, body: usize) -> BodyState {
        self.block_motion().seen_from(&self.now(body))
    }

    /// Current state of a body.
    pub(super) fn now(&self, body: usize) -> BodyState {
        let (fixed, last) = self.model.body(body);
        last.at(fixed, self.time)
    }

    /// Contact exchange of each body over the last communication step.
    #[must_use]
    pub fn exchanges(&self) -> &[ImpulseExchange] {
        &self.exchanges
    }

    /// Mass, kg, and inertia about the centre of mass in the frame of the body, kg·m²: xx, yy, zz, xy, xz, yz. The
    /// mass of a fixed body is infinite.
    #[must_use]
    pub fn inertia(&self, body: usize) -> (f64, [f64; 6]) {
        let body = self.model.body(body).0;
        let i = |row, column| body.inertia[(row, column)];
        (body.mass, [i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2)])
    }

    /// Inputs of all bodies that change nothing: current motion, no wrench.
    #[must_use]
    pub fn inputs(&self) -> Vec<StepInputs> {
        (0..self.n_bodies()).map(|body| self.unchanged(body)).collect()
    }

    /// Inputs of one body that change nothing.
    #[must_use]
    pub fn unchanged(&self, body: usize) -> StepInputs {
        let now = self.now(body);
        let (kinematics, acceleration, wrench) = (self.kinematics(body), Vector3::zeros(), Wrench::default());
        // The importer has no part in an opening by the law.
        let shape_motion = now.shape_motion.filter(|_| self.model.body(body).0.expansion.is_none());
        StepInputs { kinematics, acceleration, wrench, shape_motion, active: now.active }
    }

    /// Performs a communication step to `end`, s since the start, under the inputs of each body. An `end` not after
    /// the current time makes no step.
    ///
    /// # Panics
    /// If inputs are missing or not finite, or move a body out of the plane or off the axis of the scene. If a changing
    /// shape is invalid, or `end` is after [`Simulation::latest`].
    ///
    /// # Errors
    /// [`StepError`] when the mesh or the numbers fail. The state stays at the last consistent tick, and each later
    /// call returns the same error.
    pub fn step(&mut self, inputs: &[StepInputs], end: f64) -> Result<(), StepError> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        assert_eq!(inputs.len(), self.n_bodies(), "every body has its inputs");
        assert!(end <= self.latest(), "a step ends no later than the ticks are exact");
        let end = end.max(self.time);
        for (body, inputs) in inputs.iter().enumerate() {
            self.check_inputs(body, inputs, end - self.time);
            self.apply_inputs(body, inputs);
        }
        self.before.clear();
        for body in 0..self.n_bodies() {
            let now = self.kinematics(body);
            self.before.push(now);
        }
        self.exchanges.fill(ImpulseExchange { duration: end - self.time, ..ImpulseExchange::default() });
        let result = self.advance(end);
        self.time = match &result {
            Ok(()) => end,
            Err(failure) => failure.time().clamp(self.time, end),
        };
        for body in 0..self.n_bodies() {
            self.exchanges[body].energy_residual += self.contact_work(body);
        }
        self.failure = result.clone().err();
        result
    }

    /// Advances to `end`, s, with the looks of the watch on the way.
    fn advance(&mut self, end: f64) -> Result<(), StepError> {
        while let Some(look) = self.next_look().filter(|look| *look <= end) {
            self.model.advance_part(look, end, &mut self.exchanges)?;
            self.time = look;
            self.look();
        }
        self.model.advance_part(end, end, &mut self.exchanges)
    }

    /// Advances with unchanged inputs to the first remeshing from time `from` on, s, and returns its preview; to
    /// `end`, s, if there is none.
    ///
    /// # Errors
    /// [`StepError`] as [`Simulation::step`].
    pub fn preview_remeshing(&mut self, from: f64, end: f64) -> Result<Option<RemeshPreview>, StepError> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        self.exchanges.fill(ImpulseExchange::default());
        let result = self.model.preview_remesh(from, end, &mut self.exchanges);
        self.time = match &result {
            Ok(Some(shown)) => shown.frame.time.max(self.time),
            Ok(None) => end.max(self.time),
            Err(failure) => failure.time().clamp(self.time, end.max(self.time)),
        };
        self.failure = result.as_ref().err().cloned();
        result
    }

    /// Remeshings since this simulation was built; those before a restored state are not included.
    #[must_use]
    pub fn remeshings(&self) -> &[RemeshRecord] {
        self.model.remesh_records()
    }

    /// Failed remeshings since this simulation was built, with the reason for each attempt; not kept in states.
    #[must_use]
    pub fn failed_remeshings(&self) -> &[FailedRemesh] {
        self.model.failed_remeshes()
    }

    /// Work of contact in the energy bond of the last step, J·(V₀ + V₁)/2 + A·(Ω₀ + Ω₁)/2, J.
    fn contact_work(&self, body: usize) -> f64 {
        let (before, exchange) = (&self.before[body], &self.exchanges[body]);
        let (velocity, spin) = self.velocities_after_step(body, before, exchange);
        exchange.impulse.dot(&(before.velocity + velocity)) / 2.0
            + exchange.angular_impulse.dot(&(before.angular_velocity + spin)) / 2.0
    }

    /// Velocity and angular velocity of a body after a step.
    ///
    /// A prescribed motion does not respond to the impulse. The velocities are then V₀ + J/M and Ω₀ + I⁻¹A, those of
    /// an importer's body under contact alone.
    fn velocities_after_step(
        &self,
        i: usize,
        before: &BodyKinematics,
        exchange: &ImpulseExchange,
    ) -> (Vector3, Vector3) {
        let body = self.model.body(i).0;
        if body.motion != BodyMotion::Prescribed {
            let after = self.kinematics(i);
            return (after.velocity, after.angular_velocity);
        }
        let turned = body.spin(&self.now(i), &exchange.angular_impulse);
        (before.velocity + exchange.impulse / body.mass, before.angular_velocity + turned)
    }

    /// Checks that inputs are finite, and stay in the plane or on the axis.
    fn check_inputs(&self, body: usize, inputs: &StepInputs, duration: f64) {
        let (freedom, moved) = (self.model.body(body).0.freedom, &inputs.kinematics);
        let along =
            [moved.position, moved.velocity, inputs.acceleration, inputs.wrench.force, inputs.wrench.force_rate];
        let about = [moved.angular_velocity, inputs.wrench.torque, inputs.wrench.torque_rate];
        let q = nalgebra::Vector4::from(moved.orientation).norm();
        assert!((q - 1.0).abs() < 1e-2, "the orientation must be a unit quaternion, not one of norm {q}");
        let finite = along.iter().chain(&about).all(|v| v.iter().all(|component| component.is_finite()));
        assert!(finite, "inputs must be finite numbers");
        let free =
            along.iter().all(|v| freedom.translation(v) == *v) && about.iter().all(|v| freedom.rotation(v) == *v);
        assert!(free, "a body of a plane or axisymmetric scene must stay in its plane or on its axis");
        let own = self.model.body(body).1.shape_motion;
        for shape in inputs.shape_motion.iter().flat_map(|shape| [*shape, shape.after(duration)]) {
            assert!(own.is_some_and(|own| own.is_like(&shape)), "a changing shape is of the kind of its body");
            assert!(self.model.body(body).0.expansion.is_none(), "an opening by the law is not prescribed");
            assert_eq!(
                shape.check(),
                Ok(()),
                "a changing shape is one of its body, at the start and at the end of a step"
            );
        }
    }

    /// Applies the importer's inputs of a body at the start of a step (method A4, A5). Unchanged inputs are no
    /// event.
    fn apply_inputs(&mut self, body: usize, inputs: &StepInputs) {
        let (fixed, now) = (self.model.body(body).0, self.now(body));
        let (motion, mass) = (fixed.motion, fixed.mass);
        if motion == BodyMotion::Fixed {
            let shape_motion = prescribed_shape(&now, inputs);
            if (shape_motion, inputs.active) != (now.shape_motion, now.active) {
                self.model.set_body(body, &BodyState { shape_motion, active: inputs.active, ..now });
            }
            return;
        }
        match self.mode {
            _ if !inputs.active => self.deactivate(body),
            CouplingMode::Integrated if now.active => self.set_wrench(body, inputs),
            CouplingMode::Integrated | CouplingMode::Corrected => self.replace_motion(body, inputs, inputs.wrench),
            CouplingMode::Prescribed => {
                self.replace_motion(body, inputs, Wrench { force: inputs.acceleration * mass, ..Wrench::default() });
            }
        }
    }

    /// Deactivates a body where it is.
    fn deactivate(&mut self, i: usize) {
        if self.now(i).active {
            self.model.rebase_body(i, self.time);
            let there = *self.model.body(i).1;
            let shape_motion = there.shape_motion.map(|shape| shape.held());
            self.replace_state(i, &BodyState { active: false, shape_motion, ..there });
        }
    }

    /// Sets wrench and prescribed shape of a free body, if they change.
    fn set_wrench(&mut self, body: usize, inputs: &StepInputs) {
        let (last, now) = (self.model.body(body).1, self.now(body));
        let shape_motion = prescribed_shape(&now, inputs);
        if last.wrench != inputs.wrench || !inputs.wrench.is_constant() || shape_motion != now.shape_motion {
            self.model.rebase_body(body, self.time);
            let now = *self.model.body(body).1;
            self.replace_state(body, &BodyState { wrench: inputs.wrench, shape_motion, ..now });
        }
    }

    /// Replaces the state of a body by the importer's.
    fn replace_motion(&mut self, i: usize, inputs: &StepInputs, wrench: Wrench) {
        self.model.rebase_body(i, self.time);
        let now = self.state_from_inputs(i, inputs);
        self.replace_state(i, &BodyState { wrench, ..now });
    }

    /// Current state of a body with the motion of these inputs, active and without a wrench; a fixed body stays in
    /// place.
    pub(super) fn state_from_inputs(&self, i: usize, inputs: &StepInputs) -> BodyState {
        let (body, was) = (self.model.body(i).0, self.now(i));
        let shape_motion = prescribed_shape(&was, inputs);
        let mut now = BodyState { shape_motion, active: true, wrench: Wrench::default(), ..was };
        if body.motion != BodyMotion::Fixed {
            let given = &inputs.kinematics;
            (now.position, now.velocity) = (given.position, given.velocity);
            now.orientation = orientation(given.orientation);
            now.angular_momentum = body.angular_momentum(&now, &given.angular_velocity);
        }
        now
    }

    /// Replaces the state of a body at its own time and books the jump in the ledger.
    ///
    /// Energy and momenta of an activated or deactivated body are booked as external, those of a continuously active
    /// body as the importer's.
    fn replace_state(&mut self, i: usize, now: &BodyState) {
        let (body, was) = self.model.body(i);
        let energy = body.kinetic_energy(now) - body.kinetic_energy(was);
        let momentum = body.momentum(now) - body.momentum(was);
        let turning = body.total_angular_momentum(now) - body.total_angular_momentum(was);
        let goes_on = now.active && was.active;
        self.model.set_body(i, now);
        let Ledger { energy: e, momentum: p, angular_momentum: l } = self.model.ledger_mut();
        *(if goes_on { &mut e.importer } else { &mut e.external }) += energy;
        *(if goes_on { &mut p.importer } else { &mut p.external }) += momentum;
        *(if goes_on { &mut l.importer } else { &mut l.external }) += turning;
    }

    /// Depth of the gel's surface, m, inside a body that these inputs activate; `None` if contact tolerates it.
    #[must_use]
    pub fn overlap(&self, body: usize, inputs: &StepInputs) -> Option<f64> {
        let comes = inputs.active && !self.now(body).active;
        comes.then(|| self.model.overlap(body, &self.state_from_inputs(body, inputs))).flatten()
    }

    /// Returns true if these inputs put a body past the surface of the gel, where contact would not find the overlap.
    ///
    /// The check applies to a body that is activated, or that moves at once further than the depth of its centre in
    /// itself. Shorter moves cannot pass a surface.
    #[must_use]
    pub fn is_swallowed(&self, body: usize, inputs: &StepInputs) -> bool {
        if !inputs.active {
            return false;
        }
        let (was, there) = (self.now(body), self.state_from_inputs(body, inputs));
        let distance = (there.position - was.position).norm();
        let jumps = || distance > 0.0 && distance > -self.model.body(body).0.gap(&there, &there.position).distance;
        (!was.active || jumps()) && self.model.is_centre_in_gel(body, &there)
    }

    /// Error that ended the simulation, if any.
    #[must_use]
    pub fn failure(&self) -> Option<&StepError> {
        self.failure.as_ref()
    }

    /// Description of that error, and the reason why the last mesh was not replaced, if remeshing was tried.
    #[must_use]
    pub fn diagnosis(&self) -> Option<String> {
        let failure = self.failure.as_ref()?;
        let last_remesh = self.remeshings().last().map_or(0.0, |remeshing| remeshing.time);
        let tried = self.failed_remeshings().last().filter(|last| (last_remesh..=failure.time()).contains(&last.time));
        Some(tried.map_or_else(|| failure.to_string(), |refusal| format!("{failure}. {refusal}")))
    }

    /// Current mesh.
    #[must_use]
    pub fn frame(&self) -> MeshFrame {
        self.model.frame(self.time)
    }

    /// Saves the state, to be restored later, also by another process that built the same scene.
    #[must_use]
    pub fn save(&self) -> SavedSimulation {
        let mut saved = SavedSimulation::empty();
        self.save_into(&mut saved);
        saved
    }

    /// Saves the state into the memory of an older one.
    pub fn save_into(&self, saved: &mut SavedSimulation) {
        (saved.origin, saved.time) = (self.constants.origin, self.time);
        saved.exchanges.clone_from(&self.exchanges);
        saved.failure.clone_from(&self.failure);
        saved.watch = self.watch;
        self.model.save(&mut saved.state);
    }

    /// Continues from a saved state with identical bits.
    ///
    /// # Errors
    /// [`RestoreError`] if the state is of another scene; this simulation is then unchanged.
    pub fn restore(&mut self, saved: &SavedSimulation) -> Result<(), RestoreError> {
        if saved.origin != self.constants.origin {
            return Err(RestoreError::Foreign);
        }
        if saved.exchanges.len() != self.n_bodies() {
            return Err(RestoreError::Inconsistent { what: "a body is missing" });
        }
        self.model.restore(&saved.state, saved.time)?;
        self.time = saved.time;
        self.exchanges.clone_from(&saved.exchanges);
        self.failure.clone_from(&saved.failure);
        self.watch = saved.watch;
        self.apply_watch();
        Ok(())
    }

    /// Hash of the stored state: equal digests are equal bits.
    #[must_use]
    pub fn digest(&self) -> u128 {
        self.model.digest()
    }

    /// Bytes of the gel in the engine.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.model.bytes()
    }
}

/// Shape of a body after the inputs of a step; one that the importer does not prescribe goes on as it is.
fn prescribed_shape(now: &BodyState, inputs: &StepInputs) -> Option<ShapeMotion> {
    now.shape_motion.and(inputs.shape_motion.map(|given| given.after(0.0))).or(now.shape_motion)
}
