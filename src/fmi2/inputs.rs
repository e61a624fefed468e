//! Inputs: what was set, what it means to the simulation, and what a two-dimensional scene cannot take.

use super::call::CallError;
use super::instance::{Instance, Values};
use super::table::{Input, Source, VARIABLES, Variable, row, start_of};
use crate::algebra::Vector3;
use crate::scene::Dimension;
use crate::simulation::{CouplingMode, Inputs, Kinematics, Wrench};
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
}

impl InputValues {
    /// One component: as it was set, else as the scene starts.
    pub(super) fn value(&self, variable: &Variable, component: usize, scene: &toml::Table) -> f64 {
        let set = self.values.get(&(variable.reference + component as u32)).copied();
        set.or_else(|| start_of(variable, component, scene)).unwrap_or(0.0)
    }

    fn vector(&self, input: Input, scene: &toml::Table) -> Vector3 {
        let variable = row(Source::Input(input));
        Vector3::from_fn(|i, _| self.value(variable, i, scene))
    }

    fn rate(&self, input: Input) -> Vector3 {
        let reference = row(Source::Input(input)).reference;
        Vector3::from_fn(|i, _| self.rates.get(&(reference + i as u32)).copied().unwrap_or(0.0))
    }

    fn assembled(&self, scene: &toml::Table) -> Inputs {
        let orientation = row(Source::Input(Input::ProjectileOrientation));
        Inputs {
            kinematics: Kinematics {
                position: self.vector(Input::ProjectilePosition, scene),
                velocity: self.vector(Input::ProjectileVelocity, scene),
                orientation: std::array::from_fn(|i| self.value(orientation, i, scene)),
                angular_velocity: self.vector(Input::ProjectileAngularVelocity, scene),
            },
            acceleration: self.rate(Input::ProjectileVelocity),
            wrench: Wrench {
                force: self.vector(Input::ProjectileExternalForce, scene),
                torque: self.vector(Input::ProjectileExternalTorque, scene),
                force_rate: self.rate(Input::ProjectileExternalForce),
                torque_rate: self.rate(Input::ProjectileExternalTorque),
            },
        }
    }
}

impl Instance {
    /// What the importer hands over at the start of a step, checked.
    pub(super) fn step_inputs(&mut self) -> Result<Inputs, CallError> {
        self.model()?;
        let model = self.model.as_ref().expect("the model was built above");
        for variable in VARIABLES {
            if let Source::Input(input) = variable.source
                && read_in(input, model.mode)
            {
                check_dimension(variable, input, &self.inputs, (&model.table, model.scene.scene.dimension))?;
            }
        }
        let mut inputs = self.inputs.assembled(&model.table);
        if read_in(Input::ProjectileOrientation, model.mode) {
            inputs.kinematics.orientation = normalised(inputs.kinematics.orientation)?;
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
        let given = InputValues { values: Values::from([(reference, value)]), rates: Values::new() };
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
        assert_eq!(given.vector(Input::ProjectileVelocity, &scene), Vector3::new(0.0, 0.0, -5.0));
        given.values.insert(105, 3.0);
        assert_eq!(given.vector(Input::ProjectileVelocity, &scene), Vector3::new(0.0, 0.0, 3.0));
    }
}
