//! Derivatives: input and output derivatives by time, and the directional derivative of the contact force.

use super::call::CallError;
use super::inputs::BodyLoad;
use super::instance::FmuInstance;
use super::scalar::ScalarVariable;
use super::table::{Input, Kind, Observed, Source};
use super::variables::find_scalar;
use super::{body::mass, table::Causality};
use crate::math::Vector3;
use crate::simulation::ContactReport;

/// Limit of an input derivative: a force of 1e5 N within a microsecond is a billionth of the limit.
const LARGEST: f64 = 1e20;

impl FmuInstance {
    /// Sets first derivatives of inputs for the next step: all of them, or none.
    pub(super) fn set_input_rates(&mut self, asked: &[(u32, i32)], values: &[f64]) -> Result<(), CallError> {
        for (&(reference, order), &value) in asked.iter().zip(values) {
            let scalar = find_scalar(reference, Kind::Real)?;
            let name = scalar.name();
            if scalar.variable.causality != Causality::Input {
                let (when, remedy) = ("by its derivative".to_string(), "only inputs have input derivatives");
                return Err(CallError::NotSettable { name, when, remedy });
            }
            if order != 1 {
                return Err(CallError::value(format!("order of the derivative of {name}"), order, "1"));
            }
            if value.is_nan() || value.abs() > LARGEST {
                return Err(CallError::value(
                    format!("derivative of {name}"),
                    value,
                    "a finite number, at most 1e20 in size",
                ));
            }
            if let Some(model) = &self.model {
                model.expect_body(&scalar)?;
            }
        }
        self.inputs.rates.extend(asked.iter().map(|(reference, _)| *reference).zip(values.iter().copied()));
        Ok(())
    }

    /// Returns the first derivative of an output by time.
    pub(super) fn output_rate(&mut self, reference: u32, order: i32) -> Result<f64, CallError> {
        let scalar = find_scalar(reference, Kind::Real)?;
        let (name, variable, component) = (scalar.name(), scalar.variable, scalar.component);
        if variable.causality != Causality::Output {
            return Err(CallError::value(name, format!("{:?}", variable.causality), "an output"));
        }
        if order != 1 {
            return Err(CallError::value(format!("order of the derivative of {name}"), order, "1"));
        }
        let acted = self.inputs.acted.get(scalar.body).copied().unwrap_or_default();
        let model = self.model()?;
        model.expect_body(&scalar)?;
        if variable.source == Source::Observed(Observed::SensorDisplacement) {
            return Ok(model.sensor(scalar.body).velocity[component]);
        }
        if variable.is_of_sensors() {
            return Ok(0.0);
        }
        let (body, simulation) = (scalar.body, &model.simulation);
        let force = simulation.exchanges()[body].mean_force();
        Ok(match variable.source {
            Source::Observed(Observed::ProjectilePredictedPosition) => simulation.kinematics(body).velocity[component],
            Source::Observed(Observed::ProjectilePredictedVelocity) => {
                acceleration(&force, acted, mass(simulation, body))[component]
            }
            Source::Observed(Observed::ContactTotalImpulse) => force[component],
            Source::Observed(_) | Source::Setting(_) | Source::Scene | Source::Input(_) => 0.0,
        })
    }

    /// Returns the directional derivative Σ ∂unknown/∂known · seed.
    pub(super) fn directional_derivative(&mut self, unknown: u32, seeds: &[(u32, f64)]) -> Result<f64, CallError> {
        let of = find_scalar(unknown, Kind::Real)?;
        let model = self.model()?;
        model.expect_body(&of)?;
        if of.variable.is_of_sensors() {
            return Ok(0.0);
        }
        let contact = model.contact(of.body);
        let mut sum = 0.0;
        for &(reference, seed) in seeds {
            sum += sensitivity(contact, &of, &find_scalar(reference, Kind::Real)?) * seed;
        }
        Ok(sum)
    }
}

/// Returns the acceleration of a body of this mass, kg; a fixed body has mass 0 and no acceleration.
fn acceleration(contact: &Vector3, acted: BodyLoad, mass: f64) -> Vector3 {
    match acted {
        BodyLoad::Acceleration(acceleration) => acceleration,
        BodyLoad::Force(force) if mass > 0.0 => (contact + force) / mass,
        BodyLoad::Force(_) => Vector3::zeros(),
    }
}

/// Returns the sensitivity of the contact force: −k n⊗n for position, −Z n⊗n for velocity, with n the direction of
/// the last impulse.
fn sensitivity(contact: &ContactReport, of: &ScalarVariable, by: &ScalarVariable) -> f64 {
    if of.variable.source != Source::Observed(Observed::ContactLinearForce) || of.body != by.body {
        return 0.0;
    }
    let scale = match by.variable.source {
        Source::Input(Input::ProjectilePosition) => contact.stiffness,
        Source::Input(Input::ProjectileVelocity) => contact.impedance,
        Source::Input(_) | Source::Observed(_) | Source::Setting(_) | Source::Scene => return 0.0,
    };
    -scale * contact.direction[of.component] * contact.direction[by.component]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi2::logger::CallLog;
    use crate::fmi2::parameters::PackedScene;

    #[test]
    fn only_first_derivatives_of_inputs_are_taken() {
        let mut it = FmuInstance::new("a".into(), PackedScene::default(), CallLog::new(false));
        assert!(it.set_input_rates(&[(105, 2)], &[1.0]).unwrap_err().to_string().contains("expected 1"));
        assert!(it.set_input_rates(&[(105, 1), (200, 1)], &[1.0, 1.0]).is_err());
        assert!(it.set_input_rates(&[(105, 1)], &[f64::INFINITY]).is_err());
        assert!(it.inputs.rates.is_empty());
        it.set_input_rates(&[(105, 1)], &[4.0]).unwrap();
        assert_eq!(it.inputs.rates.get(&105), Some(&4.0));
    }
}
