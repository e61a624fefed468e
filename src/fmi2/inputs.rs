//! Inputs: what was set, what it means to the simulation, and what a two-dimensional scene cannot take.

use super::call::CallError;
use super::instance::{Instance, Values};
use super::table::{Input, Source, VARIABLES, Variable, row, start_of};
use crate::algebra::Vector3;
use crate::scene::Dimension;
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
    /// What acted at the end of the last step.
    pub acted: Acted,
}

/// What moves the projectile beside the contact.
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
    /// One component: as it was set, else as the scene starts.
    pub(super) fn value(&self, variable: &Variable, component: usize, scene: &toml::Table) -> f64 {
        let set = self.values.get(&(variable.reference + component as u32)).copied();
        set.or_else(|| start_of(variable, component, scene)).unwrap_or(0.0)
    }

    /// All components of an input as they are handed over: what is round-off out of the plane or off the axis is 0.
    fn components<const N: usize>(&self, input: Input, (scene, dimension): (&toml::Table, Dimension)) -> [f64; N] {
        let variable = row(Source::Input(input));
        let strange = foreign(input, dimension);
        std::array::from_fn(|i| if strange.contains(&i) { 0.0 } else { self.value(variable, i, scene) })
    }

    fn rate(&self, input: Input) -> Vector3 {
        let reference = row(Source::Input(input)).reference;
        Vector3::from_fn(|i, _| self.rates.get(&(reference + i as u32)).copied().unwrap_or(0.0))
    }

    /// Hands one input over.
    fn hand_over(&self, input: Input, to: &mut Inputs, scene: (&toml::Table, Dimension)) -> Result<(), CallError> {
        let vector = || Vector3::from(self.components::<3>(input, scene));
        match input {
            Input::ProjectilePosition => to.kinematics.position = vector(),
            Input::ProjectileVelocity => {
                (to.kinematics.velocity, to.acceleration) = (vector(), self.rate(input));
            }
            Input::ProjectileOrientation => to.kinematics.orientation = normalised(self.components(input, scene))?,
            Input::ProjectileAngularVelocity => to.kinematics.angular_velocity = vector(),
            Input::ProjectileExternalForce => {
                (to.wrench.force, to.wrench.force_rate) = (vector(), self.rate(input));
            }
            Input::ProjectileExternalTorque => {
                (to.wrench.torque, to.wrench.torque_rate) = (vector(), self.rate(input));
            }
        }
        Ok(())
    }
}

impl Instance {
    /// What the importer hands over at the start of a step, checked. What is not read in this mode changes nothing.
    pub(super) fn step_inputs(&mut self) -> Result<Inputs, CallError> {
        self.model()?;
        let model = self.model.as_ref().expect("the model was built above");
        let scene = (&model.table, model.scene.scene.dimension);
        let mut inputs = model.simulation.inputs();
        for variable in VARIABLES {
            if let Source::Input(input) = variable.source
                && read_in(input, model.mode)
            {
                check_dimension(variable, input, &self.inputs, scene)?;
                if model.scene.projectile.fixed {
                    check_held(variable, input, &self.inputs, scene.0)?;
                }
                self.inputs.hand_over(input, &mut inputs, scene)?;
            }
        }
        Ok(inputs)
    }
}

/// Whether an input is read at all.
fn read_in(input: Input, mode: CouplingMode) -> bool {
    match input {
        Input::ProjectilePosition
        | Input::ProjectileVelocity
        | Input::ProjectileOrientation
        | Input::ProjectileAngularVelocity => mode != CouplingMode::Integrated,
        Input::ProjectileExternalForce | Input::ProjectileExternalTorque => mode != CouplingMode::Prescribed,
    }
}

/// Components that would leave the plane or the axis.
fn foreign(input: Input, dimension: Dimension) -> &'static [usize] {
    match (dimension, input) {
        (Dimension::Spatial, _) => &[],
        (Dimension::Planar, Input::ProjectilePosition | Input::ProjectileVelocity | Input::ProjectileExternalForce) => {
            &[1]
        }
        (Dimension::Planar, Input::ProjectileOrientation) => &[1, 3],
        (Dimension::Planar, Input::ProjectileAngularVelocity | Input::ProjectileExternalTorque) => &[0, 2],
        (
            Dimension::Axisymmetric,
            Input::ProjectilePosition | Input::ProjectileVelocity | Input::ProjectileExternalForce,
        ) => &[0, 1],
        (Dimension::Axisymmetric, Input::ProjectileOrientation) => &[1, 2, 3],
        (Dimension::Axisymmetric, Input::ProjectileAngularVelocity | Input::ProjectileExternalTorque) => &[0, 1, 2],
    }
}

fn check_dimension(
    variable: &Variable,
    input: Input,
    given: &InputValues,
    (scene, dimension): (&toml::Table, Dimension),
) -> Result<(), CallError> {
    let value = |i: usize| given.value(variable, i, scene);
    let rate = |i: usize| given.rates.get(&(variable.reference + i as u32)).copied().unwrap_or(0.0);
    let longest = (0..variable.size()).map(|i| value(i).abs()).fold(0.0, f64::max);
    let alone = foreign(input, dimension).len() == variable.size();
    let limit = if alone { 0.0 } else { ROUND_OFF * longest };
    for &i in foreign(input, dimension) {
        let name = variable.component_name(i);
        let expected = match dimension {
            Dimension::Planar => "0: the scene is planar, motion stays in the x-z plane",
            Dimension::Axisymmetric => "0: the scene is axisymmetric, motion stays on the z axis without turning",
            Dimension::Spatial => unreachable!("nothing is foreign to a spatial scene"),
        };
        if value(i).abs() > limit {
            return Err(CallError::value(name, value(i), expected));
        }
        if rate(i) != 0.0 {
            return Err(CallError::value(format!("derivative of {name}"), rate(i), expected));
        }
    }
    Ok(())
}

/// Refuses an input that would move a projectile that the scene holds in place.
fn check_held(variable: &Variable, input: Input, given: &InputValues, scene: &toml::Table) -> Result<(), CallError> {
    const HELD: &str = "the scene holds the projectile in place (projectile.fixed = true)";
    let start = |i: usize| start_of(variable, i, scene).unwrap_or(0.0);
    let longest = (0..variable.size()).map(|i| start(i).abs()).fold(0.0, f64::max);
    // A quaternion may be given as in the scene, or normalised.
    let slack = if input == Input::ProjectileOrientation { 2e-3 } else { ROUND_OFF };
    for i in 0..variable.size() {
        let (name, value) = (variable.component_name(i), given.value(variable, i, scene));
        if (value - start(i)).abs() > slack * longest {
            return Err(CallError::value(name, value, format!("{}: {HELD}", start(i))));
        }
        let rate = given.rates.get(&(variable.reference + i as u32)).copied().unwrap_or(0.0);
        if rate != 0.0 {
            return Err(CallError::value(format!("derivative of {name}"), rate, format!("0: {HELD}")));
        }
    }
    Ok(())
}

fn normalised(q: [f64; 4]) -> Result<[f64; 4], CallError> {
    let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    if (norm - 1.0).abs() > 1e-3 {
        let expected = "a quaternion of norm 1 to within 1e-3";
        return Err(CallError::value("projectile.orientation", format!("{q:?} of norm {norm}"), expected));
    }
    Ok(if norm == 1.0 { q } else { q.map(|c| c / norm) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(reference: u32, value: f64, dimension: Dimension) -> Result<(), CallError> {
        let (variable, _) = super::super::table::find(reference).unwrap();
        let Source::Input(input) = variable.source else { panic!("{} is no input", variable.name) };
        let given = InputValues { values: Values::from([(reference, value)]), ..InputValues::default() };
        check_dimension(variable, input, &given, (&toml::Table::new(), dimension))
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
    }

    #[test]
    fn a_quaternion_far_from_norm_one_is_refused_and_a_near_one_is_normalised() {
        assert!(normalised([1.1, 0.0, 0.0, 0.0]).is_err());
        assert_eq!(normalised([1.0005, 0.0, 0.0, 0.0]).unwrap(), [1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn an_input_that_was_not_set_is_as_the_scene_starts() {
        let scene: toml::Table = toml::from_str("[projectile]\nvelocity = [0, 0, -5.0]").unwrap();
        let mut given = InputValues::default();
        let velocity = |given: &InputValues| given.components(Input::ProjectileVelocity, (&scene, Dimension::Planar));
        assert_eq!(velocity(&given), [0.0, 0.0, -5.0]);
        given.values.insert(105, 3.0);
        assert_eq!(velocity(&given), [0.0, 0.0, 3.0]);
    }

    #[test]
    fn round_off_out_of_the_plane_is_taken_away() {
        let (scene, planar) = (toml::Table::new(), Dimension::Planar);
        let given = InputValues { values: Values::from([(103, 2.0), (104, 1e-15)]), ..InputValues::default() };
        let (variable, _) = super::super::table::find(104).unwrap();
        assert!(check_dimension(variable, Input::ProjectileVelocity, &given, (&scene, planar)).is_ok());
        assert_eq!(given.components(Input::ProjectileVelocity, (&scene, planar)), [2.0, 0.0, 0.0]);
    }

    #[test]
    fn what_would_move_a_held_projectile_is_named_and_refused() {
        let scene: toml::Table = toml::from_str("[projectile]\nposition = [0, 0, 0.5]\nfixed = true").unwrap();
        let check = |reference: u32, value: f64, rate: f64| {
            let (variable, _) = super::super::table::find(reference).unwrap();
            let Source::Input(input) = variable.source else { panic!("{} is no input", variable.name) };
            let (values, rates) = (Values::from([(reference, value)]), Values::from([(reference, rate)]));
            check_held(variable, input, &InputValues { values, rates, ..InputValues::default() }, &scene)
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
