//! Inputs: set values, their meaning for the simulation, and the checks against the dimension of the scene.

use super::call::{CallError, format_number};
use super::model::BuiltModel;
use super::ports::{InputGroup, excluded_components, input_group};
use super::scalar::{ScalarValues, ScalarVariable};
use super::table::{Input, Source, VARIABLES, variable_of};
use crate::math::Vector3;
use crate::scene::{Dimension, body_name};
use crate::simulation::{CouplingMode, ShapeMotion, StepInputs};
use serde::{Deserialize, Serialize};

/// Tolerance of a component relative to the longest component, for the round-off of an importer that rotates vectors.
const RELATIVE_TOLERANCE: f64 = 1e-9;

/// Inputs and first derivatives set by the importer.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct InputValues {
    /// Values by value reference.
    pub values: ScalarValues,
    /// First derivatives by time, valid for one step.
    pub rates: ScalarValues,
    /// Load at the end of the last step, by body.
    pub acted: Vec<BodyLoad>,
}

/// Load on a body beside the contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) enum BodyLoad {
    /// External force, N.
    Force(Vector3),
    /// Prescribed acceleration, m/s²; the contact moves nothing.
    Acceleration(Vector3),
}

impl Default for BodyLoad {
    fn default() -> Self {
        Self::Force(Vector3::zeros())
    }
}

impl BodyLoad {
    /// Returns the load at the end of a step of this length, s.
    pub(super) fn at_step_end(inputs: &StepInputs, mode: CouplingMode, duration: f64) -> Self {
        match mode {
            CouplingMode::Prescribed => Self::Acceleration(inputs.acceleration),
            CouplingMode::Integrated | CouplingMode::Corrected => {
                Self::Force(inputs.wrench.force + duration * inputs.wrench.force_rate)
            }
        }
    }
}

impl InputValues {
    /// Returns the first derivative of a scalar.
    fn rate(&self, scalar: &ScalarVariable) -> f64 {
        self.rates.get(&scalar.reference()).copied().unwrap_or(0.0)
    }

    /// Checks the inputs at the start of a step of this length, s, and stores them by body in `handed`. An input
    /// without effect in the coupling mode is ignored.
    pub(super) fn hand_over(
        &self,
        model: &BuiltModel,
        is_first_step: bool,
        duration: f64,
        handed: &mut Vec<StepInputs>,
    ) -> Result<(), CallError> {
        let mut scalars = self.values.keys().filter_map(|reference| ScalarVariable::find(*reference));
        scalars.try_for_each(|scalar| model.expect_body(&scalar))?;
        handed.clear();
        let dimension = model.scene.freedom();
        for body in 0..model.simulation.n_bodies() {
            let inputs = BodyInputs { inputs: self, body, starts: &model.starts, dimension, is_first_step };
            handed.push(inputs.to_step_inputs(model, duration)?);
        }
        Ok(())
    }
}

/// Inputs of one body with the start values of the scene.
struct BodyInputs<'a> {
    inputs: &'a InputValues,
    body: usize,
    starts: &'a ScalarValues,
    dimension: Dimension,
    /// True before the first step.
    is_first_step: bool,
}

impl BodyInputs<'_> {
    /// Returns a scalar: the set value, or the start value of the scene.
    fn value(&self, scalar: &ScalarVariable) -> f64 {
        self.inputs.values.get(&scalar.reference()).copied().unwrap_or_else(|| self.start(scalar))
    }

    fn start(&self, scalar: &ScalarVariable) -> f64 {
        self.starts.get(&scalar.reference()).copied().unwrap_or(0.0)
    }

    /// Returns the first component of an input.
    fn scalar(&self, input: Input) -> ScalarVariable {
        ScalarVariable { variable: variable_of(Source::Input(input)), component: 0, body: self.body }
    }

    fn scalars(&self, input: Input) -> impl Iterator<Item = ScalarVariable> + Clone {
        ScalarVariable::of(variable_of(Source::Input(input)), self.body)
    }

    /// Returns all components of an input; components out of the plane or off the axis are 0.
    fn components<const N: usize>(&self, input: Input) -> [f64; N] {
        let excluded = excluded_components(input, self.dimension);
        let mut values =
            self.scalars(input).map(|s| if excluded.contains(&s.component) { 0.0 } else { self.value(&s) });
        std::array::from_fn(|_| values.next().unwrap_or(0.0))
    }

    fn vector(&self, input: Input) -> Vector3 {
        Vector3::from(self.components(input))
    }

    fn rates(&self, input: Input) -> Vector3 {
        let mut rates = self.scalars(input).map(|s| self.inputs.rate(&s));
        Vector3::from_fn(|_, _| rates.next().unwrap_or(0.0))
    }

    /// Returns true if the importer has set an input or a derivative of the motion of this body.
    fn has_motion_input(&self) -> bool {
        let set =
            |reference: &u32| self.inputs.values.contains_key(reference) || self.inputs.rates.contains_key(reference);
        let motion = all_inputs().filter(|input| input_group(*input) == InputGroup::Motion);
        motion.flat_map(|input| self.scalars(input)).any(|scalar| set(&scalar.reference()))
    }

    /// Copies one input to the simulation.
    fn copy_input(&self, input: Input, to: &mut StepInputs) -> Result<(), CallError> {
        match input {
            Input::ProjectilePosition => to.kinematics.position = self.vector(input),
            Input::ProjectileVelocity => {
                (to.kinematics.velocity, to.acceleration) = (self.vector(input), self.rates(input));
            }
            Input::ProjectileOrientation => to.kinematics.orientation = self.orientation()?,
            Input::ProjectileAngularVelocity => to.kinematics.angular_velocity = self.vector(input),
            Input::ProjectileExternalForce => {
                (to.wrench.force, to.wrench.force_rate) = (self.vector(input), self.rates(input));
            }
            Input::ProjectileExternalTorque => {
                (to.wrench.torque, to.wrench.torque_rate) = (self.vector(input), self.rates(input));
            }
            Input::ProjectileActive => to.active = self.vector(input)[0] != 0.0,
            Input::ProjectileBulgeHeight
            | Input::ProjectileBulgeRadius
            | Input::ProjectileBulgeHeightRate
            | Input::ProjectileBulgeRadiusRate => self.copy_bulge(input, to)?,
            Input::ProjectilePrescribedExpansion | Input::ProjectilePrescribedExpansionRate => {
                self.copy_expansion(input, to)?;
            }
        }
        Ok(())
    }

    fn copy_bulge(&self, input: Input, to: &mut StepInputs) -> Result<(), CallError> {
        let (value, rate) = (self.vector(input)[0], self.rates(input)[0]);
        let Some(ShapeMotion::Bulge(bulge)) = &mut to.shape_motion else {
            return self.expect_zero(input, "0: the shape of the body is no dome");
        };
        match input {
            Input::ProjectileBulgeHeight => bulge.size[0] = value,
            Input::ProjectileBulgeRadius => bulge.size[1] = value,
            Input::ProjectileBulgeHeightRate => (bulge.rate[0], bulge.acceleration[0]) = (value, rate),
            _ => (bulge.rate[1], bulge.acceleration[1]) = (value, rate),
        }
        Ok(())
    }

    /// Copies the opening of an expanding body or its rate; the body opens or closes until its end.
    fn copy_expansion(&self, input: Input, to: &mut StepInputs) -> Result<(), CallError> {
        let Some(ShapeMotion::Expansion(expansion)) = &mut to.shape_motion else {
            return self.expect_zero(input, "0: the importer does not prescribe the opening of this body");
        };
        let value = self.vector(input)[0];
        if input == Input::ProjectilePrescribedExpansion {
            expansion.opening = value;
        } else {
            (expansion.rate, expansion.end) = (value, if value < 0.0 { 0.0 } else { 1.0 });
        }
        Ok(())
    }

    /// Refuses a value of an input that the body does not have, or a derivative of it.
    fn expect_zero(&self, input: Input, expected: &str) -> Result<(), CallError> {
        let (value, rate) = (self.vector(input)[0], self.rates(input)[0]);
        let name = || self.scalar(input).name();
        match (value, rate) {
            (0.0, 0.0) => Ok(()),
            (0.0, rate) => Err(CallError::value(format!("derivative of {}", name()), rate, expected)),
            (value, _) => Err(CallError::value(name(), value, expected)),
        }
    }

    /// Refuses an invalid dome at the start or at the end of the step.
    fn check_bulge(&self, inputs: &StepInputs, duration: f64) -> Result<(), CallError> {
        let Some(ShapeMotion::Bulge(bulge)) = inputs.shape_motion else { return Ok(()) };
        for (when, at) in [("start", bulge), ("end", bulge.after(duration))] {
            if let Err(expected) = at.check() {
                let [height, radius] = at.size.into();
                let found = format!("{height} m, with a base radius of {radius} m at the {when} of the step");
                return Err(CallError::value(self.scalar(Input::ProjectileBulgeHeight).name(), found, expected));
            }
        }
        Ok(())
    }

    /// Returns true if every component of an input is 0.
    fn is_zero(&self, input: Input) -> bool {
        self.scalars(input).all(|scalar| self.value(&scalar) == 0.0)
    }

    /// Returns true if the orientation is zero before the first step, set by an importer that zeroes every input. A
    /// zero quaternion is no orientation.
    fn has_unset_orientation(&self) -> bool {
        self.is_first_step && self.is_zero(Input::ProjectileOrientation)
    }

    /// Returns true if the whole motion is zero before the first step, set by the same importer. The body then starts
    /// with the motion of the scene.
    fn has_unset_motion(&self) -> bool {
        self.has_unset_orientation()
            && all_inputs().filter(|i| input_group(*i) == InputGroup::Motion).all(|i| self.is_zero(i))
    }

    fn orientation(&self) -> Result<[f64; 4], CallError> {
        if self.has_unset_orientation() {
            let mut starts = self.scalars(Input::ProjectileOrientation).map(|scalar| self.start(&scalar));
            return Ok(normalised(std::array::from_fn(|_| starts.next().unwrap_or(0.0))));
        }
        let q: [f64; 4] = self.components(Input::ProjectileOrientation);
        let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        if (norm - 1.0).abs() > 1e-3 {
            let (name, expected) = (self.scalar(Input::ProjectileOrientation), "a quaternion of norm 1 to within 1e-3");
            return Err(CallError::value(name.row_name(), format!("{q:?} of norm {}", format_number(norm)), expected));
        }
        Ok(normalised(q))
    }

    fn check_dimension(&self, input: Input) -> Result<(), CallError> {
        let longest = self.scalars(input).map(|s| self.value(&s).abs()).fold(0.0, f64::max);
        let excluded = excluded_components(input, self.dimension);
        let alone = excluded.len() == self.scalars(input).count();
        let limit = if alone { 0.0 } else { RELATIVE_TOLERANCE * longest };
        let expected = match self.dimension {
            Dimension::Planar => "0: the scene is planar, motion stays in the x-z plane",
            Dimension::Axisymmetric => "0: the scene is axisymmetric, motion stays on the z axis without turning",
            Dimension::Spatial => return Ok(()),
        };
        for scalar in self.scalars(input).filter(|s| excluded.contains(&s.component)) {
            let (value, rate) = (self.value(&scalar), self.inputs.rate(&scalar));
            if value.abs() > limit {
                return Err(CallError::value(scalar.name(), value, expected));
            }
            if rate != 0.0 {
                return Err(CallError::value(format!("derivative of {}", scalar.name()), rate, expected));
            }
        }
        Ok(())
    }

    /// Refuses an input that would move a fixed body.
    fn check_held(&self, input: Input) -> Result<(), CallError> {
        let held = format!("the scene holds the body in place ({}.fixed = true)", body_name(self.body));
        let longest = self.scalars(input).map(|s| self.start(&s).abs()).fold(0.0, f64::max);
        // A quaternion may be normalised, or not normalised as in the scene.
        let slack = if input == Input::ProjectileOrientation { 2e-3 } else { RELATIVE_TOLERANCE };
        for scalar in self.scalars(input) {
            let (value, start, rate) = (self.value(&scalar), self.start(&scalar), self.inputs.rate(&scalar));
            if (value - start).abs() > slack * longest {
                return Err(CallError::value(scalar.name(), value, format!("{}: {held}", format_number(start))));
            }
            if rate != 0.0 {
                return Err(CallError::value(format!("derivative of {}", scalar.name()), rate, format!("0: {held}")));
            }
        }
        Ok(())
    }

    /// Returns the inputs of the body for a step of this length, s.
    fn to_step_inputs(&self, model: &BuiltModel, duration: f64) -> Result<StepInputs, CallError> {
        let mut inputs = model.simulation.unchanged(self.body);
        let is_fixed = model.scene.body(self.body).fixed;
        let was_active = inputs.active;
        self.copy_input(Input::ProjectileActive, &mut inputs)?;
        let mode = match (was_active, inputs.active) {
            // The motion of an inactive body is not read.
            (_, false) => CouplingMode::Integrated,
            // An activated body starts from its kinematic inputs.
            (false, true) => CouplingMode::Corrected,
            (true, true) => model.scene.coupling.mode,
        };
        // A body without motion inputs continues its motion.
        let is_unmoved = (was_active && !self.has_motion_input()) || self.has_unset_motion();
        for input in inputs_read_in(mode).filter(|input| !(is_unmoved && input_group(*input) == InputGroup::Motion)) {
            self.check_dimension(input)?;
            if is_fixed && matches!(input_group(input), InputGroup::Motion | InputGroup::Wrench) {
                self.check_held(input)?;
            }
            self.copy_input(input, &mut inputs)?;
        }
        self.check_bulge(&inputs, duration)?;
        if model.simulation.reenters_resting_gel(self.body, &inputs, duration) {
            return Err(self.return_error(&inputs));
        }
        if model.simulation.is_at_rest() {
            return Ok(inputs);
        }
        if let Some(depth) = model.simulation.overlap(self.body, &inputs) {
            return Err(self.overlap_error(depth));
        }
        if model.simulation.is_swallowed(self.body, &inputs) {
            return Err(self.swallowed_error(was_active, &inputs));
        }
        Ok(inputs)
    }

    /// Returns the error of a return to a gel that was put to rest.
    fn return_error(&self, inputs: &StepInputs) -> CallError {
        let found: [f64; 3] = inputs.kinematics.position.into();
        let expected = "a path outside the gel: the projectile has left the gel, which scene.stop_after_exit has put \
                        to rest, so contact is off; pack the scene with scene.stop_after_exit = \"never\", or restore \
                        a state before the exit";
        CallError::value(format!("{}.position", body_name(self.body)), format!("{found:?}"), expected)
    }

    /// Returns the error of a body centre inside the gel, beyond its surface.
    fn swallowed_error(&self, was_active: bool, inputs: &StepInputs) -> CallError {
        let found: [f64; 3] = inputs.kinematics.position.into();
        let expected =
            "a place outside the gel: the centre of the body would be inside, out of reach of the surface of the gel";
        let remedy =
            if was_active { "; prescribe every position on its path, in shorter steps" } else { "; move it out" };
        let name = format!("{}.position", body_name(self.body));
        CallError::value(name, format!("{found:?}"), expected.to_owned() + remedy)
    }

    /// Returns the error of a body that overlaps the gel by `depth`, m.
    fn overlap_error(&self, depth: f64) -> CallError {
        let expected = format!(
            "a place outside the gel, and for a fast body at a distance above its travel in an element's step: the \
             gel's surface would be {depth:.3e} m inside the body; move it out"
        );
        CallError::value(format!("{}.active", body_name(self.body)), true, expected)
    }
}

/// Normalises a quaternion; a quaternion of norm 1 keeps its bits.
fn normalised(q: [f64; 4]) -> [f64; 4] {
    let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    if norm == 1.0 { q } else { q.map(|c| c / norm) }
}

/// Returns the inputs read in a coupling mode.
fn inputs_read_in(mode: CouplingMode) -> impl Iterator<Item = Input> {
    let read = move |input: &Input| match input_group(*input) {
        InputGroup::Motion => mode != CouplingMode::Integrated,
        InputGroup::Wrench => mode != CouplingMode::Prescribed,
        InputGroup::Activity | InputGroup::Shape => true,
    };
    all_inputs().filter(read)
}

/// Returns every input.
fn all_inputs() -> impl Iterator<Item = Input> {
    VARIABLES.iter().filter_map(|variable| match variable.source {
        Source::Input(input) => Some(input),
        Source::Setting(_) | Source::Scene | Source::Observed(_) => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi2::scalar::input_start_values;

    fn given<'a>(inputs: &'a InputValues, starts: &'a ScalarValues, dimension: Dimension) -> BodyInputs<'a> {
        BodyInputs { inputs, body: 0, starts, dimension, is_first_step: false }
    }

    fn values(values: &[(u32, f64)]) -> InputValues {
        InputValues { values: values.iter().copied().collect(), ..InputValues::default() }
    }

    fn input(reference: u32) -> Input {
        let scalar = ScalarVariable::find(reference).unwrap();
        let Source::Input(input) = scalar.variable.source else { panic!("{} is no input", scalar.name()) };
        input
    }

    fn check(reference: u32, value: f64, dimension: Dimension) -> Result<(), CallError> {
        given(&values(&[(reference, value)]), &ScalarValues::new(), dimension).check_dimension(input(reference))
    }

    #[test]
    fn motion_out_of_the_plane_is_named_and_refused() {
        let refused = check(104, 2.0, Dimension::Planar).unwrap_err().to_string();
        assert!(refused.starts_with("projectile.velocity[2] = 2") && refused.contains("planar"), "{refused}");
        assert!(check(103, 2.0, Dimension::Planar).is_ok());
        assert!(check(111, 2.0, Dimension::Planar).is_ok());
        assert!(check(104, 2.0, Dimension::Spatial).is_ok());
    }

    #[test]
    fn only_the_axis_is_free_in_an_axisymmetric_scene() {
        assert!(check(103, 1e-3, Dimension::Axisymmetric).is_err());
        assert!(check(105, 1e-3, Dimension::Axisymmetric).is_ok());
        assert!(check(118, 1e-3, Dimension::Axisymmetric).is_err());
        assert!(check(120, 1e-3, Dimension::Axisymmetric).is_ok());
    }

    #[test]
    fn a_quaternion_far_from_norm_one_is_refused_and_a_near_one_is_normalised() {
        let turned = |w: f64| {
            let inputs = values(&[(106, w)]);
            given(&inputs, &ScalarValues::new(), Dimension::Spatial).orientation().map_err(|e| e.to_string())
        };
        assert!(turned(1.1).unwrap_err().starts_with("projectile.orientation = [1.1, 0.0, 0.0, 0.0] of norm 1.1"));
        assert_eq!(turned(1.0005).unwrap(), [1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn an_input_that_was_not_set_is_as_the_scene_starts() {
        let scene = input_start_values(1, &toml::from_str("[projectile]\nvelocity = [0, 0, -5.0]").unwrap());
        let velocity =
            |inputs: &InputValues| given(inputs, &scene, Dimension::Planar).vector(Input::ProjectileVelocity);
        assert_eq!(velocity(&InputValues::default()).z, -5.0);
        assert_eq!(velocity(&values(&[(105, 3.0)])).z, 3.0);
    }

    #[test]
    fn round_off_out_of_the_plane_is_taken_away() {
        let (scene, inputs) = (ScalarValues::new(), values(&[(103, 2.0), (104, 1e-15)]));
        let given = given(&inputs, &scene, Dimension::Planar);
        assert!(given.check_dimension(Input::ProjectileVelocity).is_ok());
        assert_eq!(given.vector(Input::ProjectileVelocity), Vector3::new(2.0, 0.0, 0.0));
    }

    #[test]
    fn an_input_that_would_move_a_held_projectile_is_refused_by_name() {
        let scene =
            input_start_values(1, &toml::from_str("[projectile]\nposition = [0, 0, 0.5]\nfixed = true").unwrap());
        let check = |reference: u32, value: f64, rate: f64| {
            let rates = ScalarValues::from([(reference, rate)]);
            let inputs = InputValues { rates, ..values(&[(reference, value)]) };
            given(&inputs, &scene, Dimension::Spatial).check_held(input(reference))
        };
        assert!(check(102, 0.5, 0.0).is_ok() && check(105, 0.0, 0.0).is_ok());
        for (reference, value, rate, start) in [
            (100, 0.05, 0.0, "projectile.position[1] = 0.05: expected 0: "),
            (102, 0.4, 0.0, "projectile.position[3] = 0.4: expected 0.5: "),
            (105, 0.0, 1.0, "derivative of projectile.velocity[3] = 1: expected 0: "),
        ] {
            let refused = check(reference, value, rate).unwrap_err().to_string();
            assert!(refused.starts_with(start) && refused.contains("projectile.fixed"), "{refused}");
        }
    }
}
