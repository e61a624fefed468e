//! Reading and setting of variables by value reference.

use super::body;
use super::call::CallError;
use super::instance::FmuInstance;
use super::lifecycle::LifecyclePhase;
use super::model::BuiltModel;
use super::parameters::RunSettings;
use super::scalar::{ScalarValues, ScalarVariable};
use super::table::{EnergyAccount, Kind, Observed, Source};
use crate::math::Vector3;
use crate::simulation::{ContactReport, EnergyReport, ImpulseExchange};

/// Value of an observed variable.
enum ObservedValue {
    Real([f64; 6]),
    Integer(i32),
    Boolean(bool),
}

/// Value of an observed variable, or the reason why it cannot be computed.
type ObservedResult = Result<ObservedValue, CallError>;

impl FmuInstance {
    /// Returns the value of a Real.
    pub(super) fn real(&mut self, reference: u32) -> Result<f64, CallError> {
        let scalar = find_scalar(reference, Kind::Real)?;
        match scalar.variable.source {
            Source::Observed(observed) => match self.observe_scalar(&scalar, observed)? {
                ObservedValue::Real(values) => Ok(values[scalar.component]),
                ObservedValue::Integer(_) | ObservedValue::Boolean(_) => Err(CallError::unknown(reference, Kind::Real)),
            },
            Source::Scene | Source::Input(_) => self.parameter_or_input(&scalar),
            Source::Setting(_) => Err(CallError::unknown(reference, Kind::Real)),
        }
    }

    /// Returns the value of an Integer or Enumeration.
    pub(super) fn integer(&mut self, reference: u32) -> Result<i32, CallError> {
        let scalar = find_scalar(reference, Kind::Integer)?;
        let value = match scalar.variable.source {
            Source::Setting(setting) => self.settings.integer(setting),
            Source::Scene => Some(self.parameter_or_input(&scalar)? as i32),
            Source::Observed(observed) => match self.observe_scalar(&scalar, observed)? {
                ObservedValue::Integer(value) => Some(value),
                ObservedValue::Real(_) | ObservedValue::Boolean(_) => None,
            },
            Source::Input(_) => None,
        };
        value.ok_or_else(|| CallError::unknown(reference, Kind::Integer))
    }

    /// Returns the value of a Boolean.
    pub(super) fn boolean(&mut self, reference: u32) -> Result<bool, CallError> {
        let scalar = find_scalar(reference, Kind::Boolean)?;
        match scalar.variable.source {
            Source::Observed(observed) => match self.observe_scalar(&scalar, observed)? {
                ObservedValue::Boolean(value) => Ok(value),
                ObservedValue::Real(_) | ObservedValue::Integer(_) => Err(CallError::unknown(reference, Kind::Boolean)),
            },
            Source::Input(_) => self.parameter_or_input(&scalar).map(|value| value != 0.0),
            Source::Scene | Source::Setting(_) => Err(CallError::unknown(reference, Kind::Boolean)),
        }
    }

    /// Returns the value of a String.
    pub(super) fn text(&self, reference: u32) -> Result<&str, CallError> {
        let scalar = find_scalar(reference, Kind::String)?;
        match scalar.variable.source {
            Source::Setting(setting) => self.settings.text(setting),
            Source::Scene | Source::Input(_) | Source::Observed(_) => None,
        }
        .ok_or_else(|| CallError::unknown(reference, Kind::String))
    }

    /// Returns a parameter of the scene or an input: the set value, or the start in the scene.
    fn parameter_or_input(&mut self, scalar: &ScalarVariable) -> Result<f64, CallError> {
        if !self.settings.scene.is_empty() {
            // The meaning of the overrides depends on the other scene.
            self.model()?;
        }
        let scene = self.model.as_ref().map_or(&self.packed.starts, |m| &m.table);
        let set = match scalar.variable.source {
            Source::Input(_) => self.inputs.values.get(&scalar.reference()),
            // The model in use has the overrides; without a model, the set value counts.
            _ => self.overrides.get(&scalar.reference()).filter(|_| self.model.is_none()),
        };
        Ok(set.copied().or_else(|| scalar.start(scene)).unwrap_or(0.0))
    }

    /// Sets Reals: all of them, or none.
    pub(super) fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Result<(), CallError> {
        for (&reference, &value) in references.iter().zip(values) {
            let scalar = find_scalar(reference, Kind::Real)?;
            self.expect_settable(&scalar)?;
            check_range(&scalar, value)?;
        }
        for (&reference, &value) in references.iter().zip(values) {
            if matches!(find_scalar(reference, Kind::Real)?.variable.source, Source::Input(_)) {
                self.inputs.values.insert(reference, value);
            } else {
                self.set_override(reference, value);
            }
        }
        Ok(())
    }

    /// Sets Integers and Enumerations: all of them, or none.
    pub(super) fn set_integers(&mut self, references: &[u32], values: &[i32]) -> Result<(), CallError> {
        let (mut settings, mut overrides) = (self.settings.clone(), ScalarValues::new());
        for (&reference, &value) in references.iter().zip(values) {
            let scalar = find_scalar(reference, Kind::Integer)?;
            self.expect_settable(&scalar)?;
            if let Source::Setting(setting) = scalar.variable.source {
                settings.set_integer(setting, value)?;
            } else {
                check_item(&scalar, value)?;
                overrides.insert(reference, value.into());
            }
        }
        self.replace_settings(settings);
        for (reference, value) in overrides {
            self.set_override(reference, value);
        }
        Ok(())
    }

    /// Sets a parameter of the scene; a changed value discards the model.
    fn set_override(&mut self, reference: u32, value: f64) {
        if self.overrides.insert(reference, value) != Some(value) {
            self.model = None;
        }
    }

    /// Sets Booleans: all of them, or none.
    pub(super) fn set_booleans(&mut self, references: &[u32], values: &[bool]) -> Result<(), CallError> {
        for &reference in references {
            self.expect_settable(&find_scalar(reference, Kind::Boolean)?)?;
        }
        // All remaining scalars are inputs.
        let values = values.iter().map(|value| f64::from(u8::from(*value)));
        self.inputs.values.extend(references.iter().copied().zip(values));
        Ok(())
    }

    /// Sets Strings: all of them, or none.
    pub(super) fn set_texts(&mut self, references: &[u32], values: &[&str]) -> Result<(), CallError> {
        let mut settings = self.settings.clone();
        for (&reference, value) in references.iter().zip(values) {
            let scalar = find_scalar(reference, Kind::String)?;
            self.expect_settable(&scalar)?;
            if let Source::Setting(setting) = scalar.variable.source {
                settings.set_text(setting, value)?;
            }
        }
        self.replace_settings(settings);
        Ok(())
    }

    fn observe_scalar(&mut self, scalar: &ScalarVariable, observed: Observed) -> ObservedResult {
        let now = self.clock.now;
        let model = self.model()?;
        model.expect_body(scalar)?;
        observed_value(observed, scalar.body, now, model)
    }

    fn replace_settings(&mut self, settings: RunSettings) {
        let before = std::mem::replace(&mut self.settings, settings);
        let after = &self.settings;
        if (&before.scene, before.threads) != (&after.scene, after.threads) {
            self.model = None;
        }
    }

    fn expect_settable(&self, scalar: &ScalarVariable) -> Result<(), CallError> {
        let is_started = !matches!(self.phase, LifecyclePhase::Instantiated | LifecyclePhase::Initialization);
        let remedy = match scalar.variable.source {
            Source::Observed(_) => "it is computed; set parameters and inputs",
            Source::Setting(_) | Source::Scene if is_started => "a parameter is fixed; call fmi2Reset first",
            Source::Setting(_) | Source::Scene | Source::Input(_) => return Ok(()),
        };
        let when = if is_started { "after initialization" } else { "at any time" };
        Err(CallError::NotSettable { name: scalar.name(), when: when.to_string(), remedy })
    }
}

/// Returns the scalar with this type and value reference; an Enumeration counts as Integer.
pub(super) fn find_scalar(reference: u32, kind: Kind) -> Result<ScalarVariable, CallError> {
    let is_same = |k: Kind| k == kind || (k == Kind::Enumeration && kind == Kind::Integer);
    ScalarVariable::find(reference)
        .filter(|scalar| is_same(scalar.variable.kind))
        .ok_or_else(|| CallError::unknown(reference, kind))
}

/// Refuses a number without an item in the Enumeration.
fn check_item(scalar: &ScalarVariable, value: i32) -> Result<(), CallError> {
    let items = scalar.variable.items();
    if items.iter().any(|item| item.value == value) {
        return Ok(());
    }
    let known: Vec<String> = items.iter().map(|item| format!("{} ({})", item.value, item.name)).collect();
    Err(CallError::value(scalar.name(), value, format!("one of {}", known.join(", "))))
}

/// Limit of a Real: squares and products of larger values overflow, and no physical value is larger.
const LARGEST: f64 = 1e15;

fn check_range(scalar: &ScalarVariable, value: f64) -> Result<(), CallError> {
    let refuse = |expected: String| Err(CallError::value(scalar.name(), value, expected.trim_end()));
    let variable = scalar.variable;
    let unit = variable.unit.filter(|unit| *unit != "1").unwrap_or_default();
    if !value.is_finite() {
        return refuse(format!("a finite number {unit}"));
    }
    if value.abs() > LARGEST {
        return refuse(format!("nothing beyond {LARGEST:e} {unit} in size"));
    }
    match (variable.min, variable.max) {
        (Some(min), _) if value < min => refuse(format!("at least {min} {unit}")),
        (_, Some(max)) if value > max => refuse(format!("at most {max} {unit}")),
        _ => Ok(()),
    }
}

/// Returns time, s, or energy, J, at the exit of a body.
fn exit_figure(observed: Observed, model: &BuiltModel, body: usize) -> f64 {
    let exit = model.exit(body);
    if matches!(observed, Observed::ProjectileExitTime) { exit.time } else { exit.residual_energy }
}

/// Returns an account of the energy balance, J.
fn energy_account(account: EnergyAccount, energy: &EnergyReport) -> f64 {
    match account {
        EnergyAccount::Kinetic => energy.kinetic,
        EnergyAccount::Elastic => energy.elastic,
        EnergyAccount::Contact => energy.contact,
        EnergyAccount::SelfContact => energy.self_contact,
        EnergyAccount::Remesh => energy.remesh,
        EnergyAccount::RemeshReturned => energy.remesh_returned,
        EnergyAccount::Friction => energy.friction,
        EnergyAccount::ContactBias => energy.contact_bias,
        EnergyAccount::Integration => energy.integration,
        EnergyAccount::External => energy.external,
        EnergyAccount::Expansion => energy.expansion,
        EnergyAccount::Importer => energy.importer,
        EnergyAccount::Load => energy.load,
        EnergyAccount::Air => energy.air,
        EnergyAccount::Damping => energy.damping,
        EnergyAccount::BulkViscous => energy.bulk_viscous,
        EnergyAccount::Viscous => energy.viscous,
        EnergyAccount::Eroded => energy.eroded,
        EnergyAccount::Damage => energy.damage,
        EnergyAccount::Imbalance => energy.imbalance,
    }
}

/// Returns the diameter of the cavity, m, or its depth, m.
fn cavity_figure(observed: Observed, model: &mut BuiltModel) -> Result<f64, CallError> {
    let widest = model.cavity()?;
    Ok(if matches!(observed, Observed::CavityDiameter) { widest.diameter } else { widest.depth })
}

/// Returns the displacement of the block, m, or its velocity, m/s.
fn block_vector(observed: Observed, model: &BuiltModel) -> Vector3 {
    let block = model.simulation.block_motion();
    if matches!(observed, Observed::BlockDisplacement) { block.displacement } else { block.velocity }
}

/// Returns the impulse on height or base radius of a dome, N·s, or on the opening of an expanding body, N·m·s.
fn shape_impulse(observed: Observed, exchange: ImpulseExchange) -> ObservedValue {
    scalar(exchange.shape_impulse[usize::from(matches!(observed, Observed::ContactBulgeRadiusImpulse))])
}

/// Returns the recommended communication step, or the least without chatter, s.
fn advised_step(observed: Observed, contact: &ContactReport) -> f64 {
    if matches!(observed, Observed::CouplingStepAdvice) { contact.step_advice } else { contact.step_min }
}

/// Returns the number of elements, or of remeshings.
fn count_of(observed: Observed, model: &mut BuiltModel) -> i32 {
    let elements = matches!(observed, Observed::CostElements);
    let n = if elements { model.cost().elements as u64 } else { model.simulation.remeshes() };
    i32::try_from(n).unwrap_or(i32::MAX)
}

/// Returns the smallest or the largest step, s.
fn step_of(observed: Observed, model: &mut BuiltModel) -> f64 {
    let cost = model.cost();
    if matches!(observed, Observed::CostSmallestStep) { cost.smallest_step } else { cost.largest_step }
}

/// Returns the value of an observed variable. Reports with a loop over the mesh come from the cache of `model`, other
/// values from the simulation. A sensor has no coupling exchange.
fn observed_value(observed: Observed, body: usize, now: f64, model: &mut BuiltModel) -> ObservedResult {
    let exchange = model.simulation.exchanges().get(body).copied().unwrap_or_default();
    Ok(match observed {
        Observed::Time => scalar(now),
        Observed::ProjectileEffectiveMass => scalar(body::mass(&model.simulation, body)),
        Observed::ProjectileEffectiveInertia => ObservedValue::Real(body::inertia(&model.simulation, body)),
        Observed::ContactImpulse => vector(exchange.impulse),
        Observed::ContactAngularImpulse => vector(exchange.angular_impulse),
        Observed::ContactImpulseMoment => vector(exchange.impulse_moment),
        Observed::ContactForce | Observed::ContactLinearForce => vector(exchange.mean_force()),
        Observed::ContactTorque => vector(exchange.mean_torque()),
        Observed::ContactTotalImpulse => vector(model.simulation.total_impulse(body)),
        Observed::ContactActive => ObservedValue::Boolean(exchange.is_contact()),
        Observed::ContactArea => scalar(model.contact(body).area),
        Observed::ContactPenetration => scalar(model.contact(body).penetration),
        Observed::ContactStiffness => scalar(model.contact(body).stiffness),
        Observed::ContactImpedance => scalar(model.contact(body).impedance),
        Observed::ContactBulgeHeightImpulse
        | Observed::ContactBulgeRadiusImpulse
        | Observed::ContactExpansionImpulse => shape_impulse(observed, exchange),
        Observed::ProjectileExpansion => scalar(model.simulation.expansion(body)),
        Observed::ProjectilePredictedPosition => vector(model.simulation.kinematics(body).position),
        Observed::ProjectilePredictedVelocity => vector(model.simulation.kinematics(body).velocity),
        Observed::ProjectilePredictedOrientation => real(&model.simulation.kinematics(body).orientation),
        Observed::ProjectilePredictedAngularVelocity => vector(model.simulation.kinematics(body).angular_velocity),
        Observed::ProjectileDepth => scalar(model.simulation.depth(body)),
        Observed::BlockDisplacement | Observed::BlockVelocity => vector(block_vector(observed, model)),
        Observed::ProjectilePerforated => ObservedValue::Boolean(model.simulation.exit(body).is_some()),
        Observed::ProjectileExitVelocity => vector(model.exit(body).velocity),
        Observed::ProjectileExitTime | Observed::ProjectileResidualEnergy => scalar(exit_figure(observed, model, body)),
        Observed::ProjectileEnergyDeposited => scalar(model.simulation.energy_deposited(body)),
        Observed::CavityDiameter | Observed::CavityDepth => scalar(cavity_figure(observed, model)?),
        Observed::SceneIsOver => ObservedValue::Boolean(model.simulation.is_over()),
        Observed::CouplingEnergyResidual => scalar(exchange.energy_residual),
        Observed::CouplingStepAdvice | Observed::CouplingStepMin => scalar(advised_step(observed, model.contact(body))),
        Observed::SensorPressure => scalar(model.sensor(body).pressure),
        Observed::SensorDisplacement => vector(model.sensor(body).displacement),
        Observed::SensorVelocity => vector(model.sensor(body).velocity),
        Observed::Energy(account) => scalar(energy_account(account, &model.books().energy)),
        Observed::MomentumImbalance => vector(model.books().momentum_imbalance),
        Observed::AngularMomentumImbalance => vector(model.books().angular_momentum_imbalance),
        Observed::CostElementUpdates => scalar(model.simulation.updates()),
        Observed::CostSmallestStep | Observed::CostLargestStep => scalar(step_of(observed, model)),
        Observed::CostIncompatibleFraction => scalar(model.simulation.incompatible_fraction()),
        Observed::CostElements | Observed::CostRemeshes => ObservedValue::Integer(count_of(observed, model)),
    })
}

fn real(values: &[f64]) -> ObservedValue {
    let mut all = [0.0; 6];
    all[..values.len()].copy_from_slice(values);
    ObservedValue::Real(all)
}

fn scalar(value: f64) -> ObservedValue {
    real(&[value])
}

fn vector(value: Vector3) -> ObservedValue {
    real(value.as_slice())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi2::logger::CallLog;
    use crate::fmi2::parameters::PackedScene;

    fn instance() -> FmuInstance {
        FmuInstance::new("a".into(), PackedScene::default(), CallLog::new(false))
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
        assert!(it.set_booleans(&[221], &[true]).is_err());
        it.set_booleans(&[119], &[false]).unwrap();
        assert!(!it.boolean(119).unwrap());
        it.set_reals(&[20], &[1000.0]).unwrap();
        it.phase = LifecyclePhase::StepComplete;
        assert!(it.set_reals(&[20], &[1000.0]).unwrap_err().to_string().contains("fmi2Reset"));
        it.set_reals(&[103], &[2.0]).unwrap();
        assert_eq!(it.real(103).unwrap(), 2.0);
    }

    #[test]
    fn an_input_whose_square_overflows_is_refused() {
        let refused = instance().set_reals(&[116], &[1e160]).unwrap_err().to_string();
        assert!(refused.contains("nothing beyond 1e15 N.m"), "{refused}");
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
