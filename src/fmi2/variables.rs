//! Getting and setting by value reference.

use super::body;
use super::call::CallError;
use super::instance::{Instance, Model};
use super::lifecycle::Phase;
use super::table::{Kind, Observed, Source, Variable, find, start_of};
use crate::algebra::Vector3;

/// Components of an observed variable.
enum Sample {
    Real([f64; 6]),
    Integer(i32),
    Boolean(bool),
}

impl Instance {
    /// A Real.
    pub(super) fn real(&mut self, reference: u32) -> Result<f64, CallError> {
        let (variable, component) = known(reference, Kind::Real)?;
        if matches!(variable.source, Source::Scene | Source::Input(_)) && !self.settings.scene.is_empty() {
            // What the overrides mean depends on the other scene.
            self.model()?;
        }
        match variable.source {
            Source::Scene => Ok(self.parameter(variable, component)),
            Source::Input(_) => {
                let scene = self.model.as_ref().map_or(&self.packed.starts, |m| &m.table);
                Ok(self.inputs.value(variable, component, scene))
            }
            Source::Observed(observed) => match self.sample(observed)? {
                Sample::Real(values) => Ok(values[component]),
                Sample::Integer(_) | Sample::Boolean(_) => Err(CallError::unknown(reference, Kind::Real)),
            },
            Source::Setting(_) => Err(CallError::unknown(reference, Kind::Real)),
        }
    }

    /// An Integer or Enumeration.
    pub(super) fn integer(&mut self, reference: u32) -> Result<i32, CallError> {
        let (variable, _) = known(reference, Kind::Integer)?;
        let value = match variable.source {
            Source::Setting(setting) => self.settings.integer(setting),
            Source::Observed(observed) => match self.sample(observed)? {
                Sample::Integer(value) => Some(value),
                Sample::Real(_) | Sample::Boolean(_) => None,
            },
            Source::Scene | Source::Input(_) => None,
        };
        value.ok_or_else(|| CallError::unknown(reference, Kind::Integer))
    }

    /// A Boolean.
    pub(super) fn boolean(&mut self, reference: u32) -> Result<bool, CallError> {
        let (variable, _) = known(reference, Kind::Boolean)?;
        if let Source::Observed(observed) = variable.source
            && let Sample::Boolean(value) = self.sample(observed)?
        {
            return Ok(value);
        }
        Err(CallError::unknown(reference, Kind::Boolean))
    }

    /// A String.
    pub(super) fn text(&self, reference: u32) -> Result<&str, CallError> {
        let (variable, _) = known(reference, Kind::String)?;
        match variable.source {
            Source::Setting(setting) => self.settings.text(setting),
            Source::Scene | Source::Input(_) | Source::Observed(_) => None,
        }
        .ok_or_else(|| CallError::unknown(reference, Kind::String))
    }

    /// Sets Reals: all of them, or none.
    pub(super) fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Result<(), CallError> {
        for (&reference, &value) in references.iter().zip(values) {
            let (variable, component) = known(reference, Kind::Real)?;
            self.expect_settable(variable, component)?;
            check_range(variable, component, value)?;
        }
        for (&reference, &value) in references.iter().zip(values) {
            let (variable, _) = known(reference, Kind::Real)?;
            if matches!(variable.source, Source::Input(_)) {
                self.inputs.values.insert(reference, value);
            } else if self.overrides.insert(reference, value) != Some(value) {
                self.model = None;
            }
        }
        Ok(())
    }

    /// Sets Integers and Enumerations: all of them, or none.
    pub(super) fn set_integers(&mut self, references: &[u32], values: &[i32]) -> Result<(), CallError> {
        let mut settings = self.settings.clone();
        for (&reference, &value) in references.iter().zip(values) {
            let (variable, component) = known(reference, Kind::Integer)?;
            self.expect_settable(variable, component)?;
            if let Source::Setting(setting) = variable.source {
                settings.set_integer(setting, value)?;
            }
        }
        self.adopt(settings);
        Ok(())
    }

    /// Refuses to set a Boolean: none can be set.
    pub(super) fn set_booleans(&mut self, references: &[u32]) -> Result<(), CallError> {
        for &reference in references {
            let (variable, component) = known(reference, Kind::Boolean)?;
            self.expect_settable(variable, component)?;
        }
        Ok(())
    }

    /// Sets Strings: all of them, or none.
    pub(super) fn set_texts(&mut self, references: &[u32], values: &[&str]) -> Result<(), CallError> {
        let mut settings = self.settings.clone();
        for (&reference, value) in references.iter().zip(values) {
            let (variable, component) = known(reference, Kind::String)?;
            self.expect_settable(variable, component)?;
            if let Source::Setting(setting) = variable.source {
                settings.set_text(setting, value)?;
            }
        }
        self.adopt(settings);
        Ok(())
    }

    fn sample(&mut self, observed: Observed) -> Result<Sample, CallError> {
        let now = self.clock.now;
        Ok(sample(observed, now, self.model()?))
    }

    fn adopt(&mut self, settings: super::parameters::Settings) {
        let before = std::mem::replace(&mut self.settings, settings);
        let after = &self.settings;
        if (&before.scene, before.threads, before.mode) != (&after.scene, after.threads, after.mode) {
            self.model = None;
        }
    }

    /// The value in use once there is a model; before, what was set or the start.
    fn parameter(&self, variable: &Variable, component: usize) -> f64 {
        let set = || self.overrides.get(&(variable.reference + component as u32)).copied();
        match &self.model {
            Some(model) => start_of(variable, component, &model.table),
            None => set().or_else(|| start_of(variable, component, &self.packed.starts)),
        }
        .unwrap_or(0.0)
    }

    fn expect_settable(&self, variable: &Variable, component: usize) -> Result<(), CallError> {
        let started = !matches!(self.phase, Phase::Instantiated | Phase::Initialization);
        let remedy = match variable.source {
            Source::Observed(_) => "it is computed; set parameters and inputs",
            Source::Setting(_) | Source::Scene if started => "a parameter is fixed; call fmi2Reset first",
            Source::Setting(_) | Source::Scene | Source::Input(_) => return Ok(()),
        };
        let when = if started { "after initialization" } else { "at any time" };
        Err(CallError::NotSettable { name: variable.component_name(component), when: when.to_string(), remedy })
    }
}

/// The variable of this type (an Enumeration counts as Integer) with the value reference.
pub(super) fn known(reference: u32, kind: Kind) -> Result<(&'static Variable, usize), CallError> {
    let same = |k: Kind| k == kind || (k == Kind::Enumeration && kind == Kind::Integer);
    find(reference).filter(|(v, _)| same(v.kind)).ok_or_else(|| CallError::unknown(reference, kind))
}

fn check_range(variable: &Variable, component: usize, value: f64) -> Result<(), CallError> {
    let refuse = |expected: String| Err(CallError::value(variable.component_name(component), value, expected));
    let unit = variable.unit.unwrap_or_default();
    if !value.is_finite() {
        return refuse(format!("a finite number, {unit}"));
    }
    match (variable.min, variable.max) {
        (Some(min), _) if value < min => refuse(format!("at least {min} {unit}")),
        (_, Some(max)) if value > max => refuse(format!("at most {max} {unit}")),
        _ => Ok(()),
    }
}

fn sample(observed: Observed, now: f64, model: &mut Model) -> Sample {
    let (o, simulation) = model.look();
    let (exchange, contact, energy, cost) = (&o.exchange, &o.contact, &o.energy, &o.cost);
    match observed {
        Observed::Time => scalar(now),
        Observed::ProjectileEffectiveMass => scalar(body::mass(simulation)),
        Observed::ProjectileEffectiveInertia => Sample::Real(body::inertia(simulation)),
        Observed::ContactImpulse => vector(exchange.impulse),
        Observed::ContactAngularImpulse => vector(exchange.angular_impulse),
        Observed::ContactImpulseMoment => vector(exchange.impulse_moment),
        Observed::ContactForce | Observed::ContactLinearForce => vector(exchange.mean_force()),
        Observed::ContactTorque => vector(exchange.mean_torque()),
        Observed::ContactTotalImpulse => vector(contact.total_impulse),
        Observed::ContactActive => Sample::Boolean(contact.active),
        Observed::ContactArea => scalar(contact.area),
        Observed::ContactPenetration => scalar(contact.penetration),
        Observed::ContactStiffness => scalar(contact.stiffness),
        Observed::ContactImpedance => scalar(contact.impedance),
        Observed::ProjectilePredictedPosition => vector(o.projectile.position),
        Observed::ProjectilePredictedVelocity => vector(o.projectile.velocity),
        Observed::ProjectilePredictedOrientation => real(&o.projectile.orientation),
        Observed::ProjectilePredictedAngularVelocity => vector(o.projectile.angular_velocity),
        Observed::ProjectileDepth => scalar(o.depth),
        Observed::CouplingEnergyResidual => scalar(exchange.energy_residual),
        Observed::CouplingStepAdvice => scalar(contact.step_advice),
        Observed::CouplingStepMin => scalar(contact.step_min),
        Observed::EnergyKinetic => scalar(energy.kinetic),
        Observed::EnergyElastic => scalar(energy.elastic),
        Observed::EnergyContact => scalar(energy.contact),
        Observed::EnergyFriction => scalar(energy.friction),
        Observed::EnergyContactBias => scalar(energy.contact_bias),
        Observed::EnergyIntegration => scalar(energy.integration),
        Observed::EnergyExternal => scalar(energy.external),
        Observed::EnergyImporter => scalar(energy.importer),
        Observed::EnergyClosure => scalar(energy.closure),
        Observed::MomentumClosure => vector(o.momentum_closure),
        Observed::AngularMomentumClosure => vector(o.angular_momentum_closure),
        Observed::CostElementUpdates => scalar(cost.element_updates),
        Observed::CostSmallestStep => scalar(cost.smallest_step),
        Observed::CostLargestStep => scalar(cost.largest_step),
        Observed::CostElements => Sample::Integer(i32::try_from(cost.elements).unwrap_or(i32::MAX)),
    }
}

fn real(values: &[f64]) -> Sample {
    let mut all = [0.0; 6];
    all[..values.len()].copy_from_slice(values);
    Sample::Real(all)
}

fn scalar(value: f64) -> Sample {
    real(&[value])
}

fn vector(value: Vector3) -> Sample {
    real(value.as_slice())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi2::logger::Log;
    use crate::fmi2::parameters::Packed;

    fn instance() -> Instance {
        Instance::new("a".into(), Packed::of(Err("none".into())), Log::new(false))
    }

    #[test]
    fn a_set_call_with_one_bad_value_sets_nothing() {
        let mut it = instance();
        let refused = it.set_reals(&[103, 104], &[1.0, f64::NAN]).unwrap_err().to_string();
        assert!(refused.starts_with("projectile.velocity[2] = NaN"), "{refused}");
        assert!(it.inputs.values.is_empty());
        assert!(it.set_integers(&[11, 13], &[4, 9]).is_err());
        assert_eq!(it.integer(11).unwrap(), 1);
    }

    #[test]
    fn outputs_and_time_cannot_be_set_and_parameters_only_before_the_start() {
        let mut it = instance();
        assert!(it.set_reals(&[1], &[0.0]).unwrap_err().to_string().contains("it is computed"));
        assert!(it.set_reals(&[200], &[0.0]).unwrap_err().to_string().contains("contact.impulse[1]"));
        assert!(it.set_booleans(&[221]).is_err());
        it.set_reals(&[20], &[1000.0]).unwrap();
        it.phase = Phase::StepComplete;
        assert!(it.set_reals(&[20], &[1000.0]).unwrap_err().to_string().contains("fmi2Reset"));
        it.set_reals(&[103], &[2.0]).unwrap();
        assert_eq!(it.real(103).unwrap(), 2.0);
    }

    #[test]
    fn a_reference_of_another_type_is_unknown() {
        let mut it = instance();
        assert!(it.real(11).unwrap_err().to_string().contains("11"));
        assert!(it.integer(20).is_err() && it.boolean(20).is_err() && it.text(20).is_err());
        assert!(it.real(4_000_000_000).is_err());
    }

    #[test]
    fn a_value_below_its_minimum_is_refused() {
        assert!(instance().set_reals(&[20], &[-1.0]).unwrap_err().to_string().contains("at least 0 kg/m3"));
    }
}
