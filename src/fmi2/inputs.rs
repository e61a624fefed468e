//! Inputs: what was set, what it means to the simulation, and what a two-dimensional scene cannot take.

use super::call::{CallError, number};
use super::instance::{Instance, Model, Values};
use super::scalar::{Ports, Scalar, scalars};
use super::table::{Input, Source, VARIABLES, row};
use crate::math::Vector3;
use crate::scene::{Dimension, body_name};
use crate::simulation::{CouplingMode, Inputs};
use serde::{Deserialize, Serialize};

/// Round-off of an importer that rotates vectors: this much of the longest component counts as zero.
const ROUND_OFF: f64 = 1e-9;

/// Inputs and their first derivatives, as far as they were set.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct InputValues {
    /// Values.
    pub values: Values,
    /// First derivatives by time; they hold for one step.
    pub rates: Values,
    /// What acted at the end of the last step, by body.
    pub acted: Vec<Acted>,
}

/// What moves a body beside the contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) enum Acted {
    /// An external force, N.
    Force(Vector3),
    /// A prescribed acceleration, m/s²: the contact moves nothing.
    Acceleration(Vector3),
}

impl Default for Acted {
    fn default() -> Self {
        Self::Force(Vector3::zeros())
    }
}

impl Acted {
    /// What acts at the end of a step of this length, s.
    pub(super) fn at_the_end(inputs: &Inputs, mode: CouplingMode, duration: f64) -> Self {
        match mode {
            CouplingMode::Prescribed => Self::Acceleration(inputs.acceleration),
            CouplingMode::Integrated | CouplingMode::Corrected => {
                Self::Force(inputs.wrench.force + duration * inputs.wrench.force_rate)
            }
        }
    }
}

impl InputValues {
    /// First derivative of a scalar.
    fn rate(&self, scalar: &Scalar) -> f64 {
        self.rates.get(&scalar.reference()).copied().unwrap_or(0.0)
    }
}

/// What the inputs start with in a scene with these ports.
pub(super) fn starts(ports: Ports, scene: &toml::Table) -> Values {
    let inputs = scalars(ports).filter(|scalar| matches!(scalar.variable.source, Source::Input(_)));
    inputs.filter_map(|scalar| Some((scalar.reference(), scalar.start(scene)?))).collect()
}

/// What was given for one body, and what the scene that it is given to starts with.
struct Given<'a> {
    inputs: &'a InputValues,
    body: usize,
    starts: &'a Values,
    dimension: Dimension,
    /// No step was taken yet.
    is_first_step: bool,
}

impl Given<'_> {
    /// One scalar: as it was set, else as the scene starts.
    fn value(&self, scalar: &Scalar) -> f64 {
        self.inputs.values.get(&scalar.reference()).copied().unwrap_or_else(|| self.start(scalar))
    }

    fn start(&self, scalar: &Scalar) -> f64 {
        self.starts.get(&scalar.reference()).copied().unwrap_or(0.0)
    }

    /// The first component of an input.
    fn scalar(&self, input: Input) -> Scalar {
        Scalar { variable: row(Source::Input(input)), component: 0, body: self.body }
    }

    fn scalars(&self, input: Input) -> impl Iterator<Item = Scalar> + Clone {
        Scalar::of(row(Source::Input(input)), self.body)
    }

    /// All components of an input as they are handed over: what is round-off out of the plane or off the axis is 0.
    fn components<const N: usize>(&self, input: Input) -> [f64; N] {
        let strange = foreign(input, self.dimension);
        let mut values = self.scalars(input).map(|s| if strange.contains(&s.component) { 0.0 } else { self.value(&s) });
        std::array::from_fn(|_| values.next().unwrap_or(0.0))
    }

    fn vector(&self, input: Input) -> Vector3 {
        Vector3::from(self.components(input))
    }

    fn rates(&self, input: Input) -> Vector3 {
        let mut rates = self.scalars(input).map(|s| self.inputs.rate(&s));
        Vector3::from_fn(|_, _| rates.next().unwrap_or(0.0))
    }

    /// Whether the importer has said anything of the motion of this body.
    fn moves(&self) -> bool {
        let set =
            |reference: &u32| self.inputs.values.contains_key(reference) || self.inputs.rates.contains_key(reference);
        let motion = inputs().filter(|input| about(*input) == About::Motion);
        motion.flat_map(|input| self.scalars(input)).any(|scalar| set(&scalar.reference()))
    }

    /// Hands one input over.
    fn hand_over(&self, input: Input, to: &mut Inputs) -> Result<(), CallError> {
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
            | Input::ProjectileBulgeRadiusRate => self.hand_over_bulge(input, to)?,
        }
        Ok(())
    }

    fn hand_over_bulge(&self, input: Input, to: &mut Inputs) -> Result<(), CallError> {
        let (value, rate) = (self.vector(input)[0], self.rates(input)[0]);
        let Some(bulge) = &mut to.bulge else {
            let (name, expected) = (|| self.scalar(input).name(), "0: the shape of the body is no dome");
            return match (value, rate) {
                (0.0, 0.0) => Ok(()),
                (0.0, rate) => Err(CallError::value(format!("derivative of {}", name()), rate, expected)),
                (value, _) => Err(CallError::value(name(), value, expected)),
            };
        };
        match input {
            Input::ProjectileBulgeHeight => bulge.size[0] = value,
            Input::ProjectileBulgeRadius => bulge.size[1] = value,
            Input::ProjectileBulgeHeightRate => (bulge.rate[0], bulge.acceleration[0]) = (value, rate),
            _ => (bulge.rate[1], bulge.acceleration[1]) = (value, rate),
        }
        Ok(())
    }

    /// The dome must be one at the start and at the end of the step.
    fn check_bulge(&self, inputs: &Inputs, duration: f64) -> Result<(), CallError> {
        let Some(bulge) = inputs.bulge else { return Ok(()) };
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

    /// Returns true if an importer that sets every input to 0 before the first step has left the orientation unset: a zero
    /// quaternion is no orientation.
    fn has_unset_orientation(&self) -> bool {
        self.is_first_step && self.is_zero(Input::ProjectileOrientation)
    }

    /// Returns true if such an importer has left the whole motion unset. The body then starts as the scene says.
    fn has_unset_motion(&self) -> bool {
        self.has_unset_orientation() && inputs().filter(|i| about(*i) == About::Motion).all(|i| self.is_zero(i))
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
            return Err(CallError::value(name.row_name(), format!("{q:?} of norm {}", number(norm)), expected));
        }
        Ok(normalised(q))
    }

    fn check_dimension(&self, input: Input) -> Result<(), CallError> {
        let longest = self.scalars(input).map(|s| self.value(&s).abs()).fold(0.0, f64::max);
        let strange = foreign(input, self.dimension);
        let alone = strange.len() == self.scalars(input).count();
        let limit = if alone { 0.0 } else { ROUND_OFF * longest };
        let expected = match self.dimension {
            Dimension::Planar => "0: the scene is planar, motion stays in the x-z plane",
            Dimension::Axisymmetric => "0: the scene is axisymmetric, motion stays on the z axis without turning",
            Dimension::Spatial => return Ok(()),
        };
        for scalar in self.scalars(input).filter(|s| strange.contains(&s.component)) {
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

    /// Refuses an input that would move a body that the scene holds in place.
    fn check_held(&self, input: Input) -> Result<(), CallError> {
        let held = format!("the scene holds the body in place ({}.fixed = true)", body_name(self.body));
        let longest = self.scalars(input).map(|s| self.start(&s).abs()).fold(0.0, f64::max);
        // A quaternion may be given as in the scene, or normalised.
        let slack = if input == Input::ProjectileOrientation { 2e-3 } else { ROUND_OFF };
        for scalar in self.scalars(input) {
            let (value, start, rate) = (self.value(&scalar), self.start(&scalar), self.inputs.rate(&scalar));
            if (value - start).abs() > slack * longest {
                return Err(CallError::value(scalar.name(), value, format!("{}: {held}", number(start))));
            }
            if rate != 0.0 {
                return Err(CallError::value(format!("derivative of {}", scalar.name()), rate, format!("0: {held}")));
            }
        }
        Ok(())
    }
}

impl Instance {
    /// Checks what the importer hands over at the start of a step of this length, s, and lays it out by body in `handed`. What is
    /// not read in this mode changes nothing.
    pub(super) fn step_inputs(&mut self, duration: f64) -> Result<(), CallError> {
        self.model()?;
        let Self { model, inputs, handed, clock, .. } = self;
        let is_first_step = clock.now == clock.start;
        let model = model.as_ref().expect("the model was built above");
        inputs.values.keys().filter_map(|r| Scalar::find(*r)).try_for_each(|scalar| model.expect_body(&scalar))?;
        handed.clear();
        for body in 0..model.simulation.n_bodies() {
            let dimension = model.scene.freedom();
            handed.push(Given { inputs, body, starts: &model.starts, dimension, is_first_step }.to(model, duration)?);
        }
        Ok(())
    }
}

impl Given<'_> {
    /// The inputs of the body in a step of this length, s.
    fn to(&self, model: &Model, duration: f64) -> Result<Inputs, CallError> {
        let mut inputs = model.simulation.unchanged(self.body);
        let held = model.scene.body(self.body).fixed;
        let was_active = inputs.active;
        self.hand_over(Input::ProjectileActive, &mut inputs)?;
        let mode = match (was_active, inputs.active) {
            // Its motion is not read.
            (_, false) => CouplingMode::Integrated,
            // It starts from its kinematic inputs.
            (false, true) => CouplingMode::Corrected,
            (true, true) => model.scene.coupling.mode,
        };
        // A body that nobody moves goes on as it does.
        let unmoved = (was_active && !self.moves()) || self.has_unset_motion();
        for input in inputs_read_in(mode).filter(|input| !(unmoved && about(*input) == About::Motion)) {
            self.check_dimension(input)?;
            if held && about(input) != About::Form {
                self.check_held(input)?;
            }
            self.hand_over(input, &mut inputs)?;
        }
        self.check_bulge(&inputs, duration)?;
        if model.simulation.comes_back(self.body, &inputs, duration) {
            return Err(self.back_again(&inputs));
        }
        if model.simulation.is_at_rest() {
            return Ok(inputs);
        }
        if let Some(depth) = model.simulation.overlap(self.body, &inputs) {
            return Err(self.inside(depth));
        }
        if model.simulation.is_swallowed(self.body, &inputs) {
            return Err(self.swallowed(was_active, &inputs));
        }
        Ok(inputs)
    }

    /// A gel at rest would not feel it.
    fn back_again(&self, inputs: &Inputs) -> CallError {
        let found: [f64; 3] = inputs.kinematics.position.into();
        let expected = "a path that stays outside the gel: the projectile has left it, and scene.stop_after_exit has put it to rest, so \
                        that it would not be felt; pack the scene with scene.stop_after_exit = \"never\", or go back to a state before";
        CallError::value(format!("{}.position", body_name(self.body)), format!("{found:?}"), expected)
    }

    /// Nor can it be put there past the surface of the gel.
    fn swallowed(&self, was_active: bool, inputs: &Inputs) -> CallError {
        let found: [f64; 3] = inputs.kinematics.position.into();
        let expected =
            "a place outside the gel: the centre of the body would be in it, where no surface of the gel meets it";
        let remedy =
            if was_active { "; hand over each place that it comes through on its way" } else { "; move it out" };
        let name = format!("{}.position", body_name(self.body));
        CallError::value(name, format!("{found:?}"), expected.to_owned() + remedy)
    }

    /// A body cannot come to be inside the gel.
    fn inside(&self, depth: f64) -> CallError {
        let expected = format!(
            "a place outside the gel, and for a fast body further off than it goes in an element's step: the gel's surface would \
             be {depth:.3e} m inside the body; move it out"
        );
        CallError::value(format!("{}.active", body_name(self.body)), true, expected)
    }
}

/// A quaternion of norm 1, to the bit as it was given if it is one.
fn normalised(q: [f64; 4]) -> [f64; 4] {
    let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    if norm == 1.0 { q } else { q.map(|c| c / norm) }
}

/// What an input says of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum About {
    /// Where it is and how it moves.
    Motion,
    /// What acts on it.
    Wrench,
    /// What it is.
    Form,
}

fn about(input: Input) -> About {
    match input {
        Input::ProjectilePosition
        | Input::ProjectileVelocity
        | Input::ProjectileOrientation
        | Input::ProjectileAngularVelocity => About::Motion,
        Input::ProjectileExternalForce | Input::ProjectileExternalTorque => About::Wrench,
        Input::ProjectileActive
        | Input::ProjectileBulgeHeight
        | Input::ProjectileBulgeRadius
        | Input::ProjectileBulgeHeightRate
        | Input::ProjectileBulgeRadiusRate => About::Form,
    }
}

/// The inputs that are read in a mode.
fn inputs_read_in(mode: CouplingMode) -> impl Iterator<Item = Input> {
    let read = move |input: &Input| match about(*input) {
        About::Motion => mode != CouplingMode::Integrated,
        About::Wrench => mode != CouplingMode::Prescribed,
        About::Form => true,
    };
    inputs().filter(read)
}

/// Every input.
fn inputs() -> impl Iterator<Item = Input> {
    VARIABLES.iter().filter_map(|variable| match variable.source {
        Source::Input(input) => Some(input),
        Source::Setting(_) | Source::Scene | Source::Observed(_) => None,
    })
}

/// Components that would leave the plane or the axis.
fn foreign(input: Input, dimension: Dimension) -> &'static [usize] {
    let along = [Input::ProjectilePosition, Input::ProjectileVelocity, Input::ProjectileExternalForce].contains(&input);
    let about = [Input::ProjectileAngularVelocity, Input::ProjectileExternalTorque].contains(&input);
    match (dimension, input) {
        (Dimension::Planar, Input::ProjectileOrientation) => &[1, 3],
        (Dimension::Axisymmetric, Input::ProjectileOrientation) => &[1, 2, 3],
        (Dimension::Planar, _) if along => &[1],
        (Dimension::Planar, _) if about => &[0, 2],
        (Dimension::Axisymmetric, _) if along => &[0, 1],
        (Dimension::Axisymmetric, _) if about => &[0, 1, 2],
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: Ports = Ports { fragments: 0, sensors: 0 };

    fn given<'a>(inputs: &'a InputValues, starts: &'a Values, dimension: Dimension) -> Given<'a> {
        Given { inputs, body: 0, starts, dimension, is_first_step: false }
    }

    fn values(values: &[(u32, f64)]) -> InputValues {
        InputValues { values: values.iter().copied().collect(), ..InputValues::default() }
    }

    fn input(reference: u32) -> Input {
        let scalar = Scalar::find(reference).unwrap();
        let Source::Input(input) = scalar.variable.source else { panic!("{} is no input", scalar.name()) };
        input
    }

    fn check(reference: u32, value: f64, dimension: Dimension) -> Result<(), CallError> {
        given(&values(&[(reference, value)]), &Values::new(), dimension).check_dimension(input(reference))
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
            given(&inputs, &Values::new(), Dimension::Spatial).orientation().map_err(|e| e.to_string())
        };
        assert!(turned(1.1).unwrap_err().starts_with("projectile.orientation = [1.1, 0.0, 0.0, 0.0] of norm 1.1"));
        assert_eq!(turned(1.0005).unwrap(), [1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn an_input_that_was_not_set_is_as_the_scene_starts() {
        let scene = starts(NONE, &toml::from_str("[projectile]\nvelocity = [0, 0, -5.0]").unwrap());
        let velocity =
            |inputs: &InputValues| given(inputs, &scene, Dimension::Planar).vector(Input::ProjectileVelocity);
        assert_eq!(velocity(&InputValues::default()).z, -5.0);
        assert_eq!(velocity(&values(&[(105, 3.0)])).z, 3.0);
    }

    #[test]
    fn round_off_out_of_the_plane_is_taken_away() {
        let (scene, inputs) = (Values::new(), values(&[(103, 2.0), (104, 1e-15)]));
        let given = given(&inputs, &scene, Dimension::Planar);
        assert!(given.check_dimension(Input::ProjectileVelocity).is_ok());
        assert_eq!(given.vector(Input::ProjectileVelocity), Vector3::new(2.0, 0.0, 0.0));
    }

    #[test]
    fn what_would_move_a_held_projectile_is_named_and_refused() {
        let scene = starts(NONE, &toml::from_str("[projectile]\nposition = [0, 0, 0.5]\nfixed = true").unwrap());
        let check = |reference: u32, value: f64, rate: f64| {
            let rates = Values::from([(reference, rate)]);
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
