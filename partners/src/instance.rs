//! One instance of a partner: which call is allowed when, and its state as a value.

use super::table::{Causality, Model};

/// Where in its life an instance is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// After `fmi2Instantiate` or `fmi2Reset`.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    Initialization,
    /// After `fmi2ExitInitializationMode`, before the first step.
    Ready,
    /// Steps are taken.
    Stepping,
    /// After `fmi2Terminate`.
    Terminated,
}

const PHASES: [Phase; 5] =
    [Phase::Instantiated, Phase::Initialization, Phase::Ready, Phase::Stepping, Phase::Terminated];

/// Everything that a later answer depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    phase: Phase,
    time: f64,
    values: Vec<f64>,
}

/// A partner in use.
#[derive(Debug)]
pub struct Instance {
    /// What it is an instance of.
    pub model: &'static Model,
    /// Start values of all components, as it was packed.
    starts: Vec<f64>,
    state: State,
}

impl Instance {
    /// An instance with these start values of all components.
    pub fn new(model: &'static Model, starts: Vec<f64>) -> Self {
        let state = State { phase: Phase::Instantiated, time: 0.0, values: starts.clone() };
        Self { model, starts, state }
    }

    /// The present state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Time up to which it has stepped, s.
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Goes to a state.
    pub fn restore(&mut self, state: State) {
        self.state = state;
    }

    /// Begins anew.
    pub fn reset(&mut self) {
        *self = Self::new(self.model, std::mem::take(&mut self.starts));
    }

    /// Start time, s.
    pub fn setup(&mut self, start_time: f64) -> Result<(), String> {
        self.expect(&[Phase::Instantiated], "fmi2SetupExperiment")?;
        if !start_time.is_finite() {
            return Err(format!("startTime: found {start_time} s, expected a finite number"));
        }
        self.state.time = start_time;
        Ok(())
    }

    /// Enters initialization mode.
    pub fn enter_initialization(&mut self) -> Result<(), String> {
        self.expect(&[Phase::Instantiated], "fmi2EnterInitializationMode")?;
        self.state.phase = Phase::Initialization;
        Ok(())
    }

    /// Computes the first outputs and is ready to step.
    pub fn exit_initialization(&mut self) -> Result<(), String> {
        self.expect(&[Phase::Initialization], "fmi2ExitInitializationMode")?;
        self.start()?;
        self.state.phase = Phase::Ready;
        Ok(())
    }

    /// Ends the simulation; values can still be read.
    pub fn terminate(&mut self) -> Result<(), String> {
        self.expect(&[Phase::Ready, Phase::Stepping], "fmi2Terminate")?;
        self.state.phase = Phase::Terminated;
        Ok(())
    }

    /// Values of the references.
    pub fn get(&mut self, references: &[u32]) -> Result<Vec<f64>, String> {
        if self.state.phase == Phase::Initialization {
            self.start()?;
        }
        references.iter().map(|&reference| Ok(self.state.values[self.index(reference)?])).collect()
    }

    /// Sets inputs at any time, and parameters before the first step: all of them, or none.
    pub fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), String> {
        for (&reference, &value) in references.iter().zip(values) {
            self.check(reference, value)?;
        }
        for (&reference, &value) in references.iter().zip(values) {
            self.state.values[reference as usize] = value;
        }
        Ok(())
    }

    /// Whether this variable can be set to this value now.
    fn check(&self, reference: u32, value: f64) -> Result<(), String> {
        let index = self.index(reference)?;
        let (variable, _) = self.model.scalars().nth(index).ok_or("a reference without variable")?;
        let (phase, name) = (self.state.phase, variable.name);
        let when = match variable.causality {
            Causality::Input if phase != Phase::Terminated => None,
            Causality::Input => Some("an input, set before fmi2Terminate"),
            Causality::Parameter if matches!(phase, Phase::Instantiated | Phase::Initialization) => None,
            Causality::Parameter => Some("a parameter, set before fmi2ExitInitializationMode"),
            Causality::Output | Causality::Local => Some("computed, never set"),
        };
        if let Some(when) = when {
            return Err(format!("{name}: found a call that sets it in phase {phase:?}; it is {when}"));
        }
        if value.is_finite() {
            Ok(())
        } else {
            Err(format!("{name}: found {value}, expected a finite number of {}", variable.unit))
        }
    }

    /// Steps from a time over a length, s.
    pub fn step(&mut self, from: f64, length: f64) -> Result<(), String> {
        self.expect(&[Phase::Ready, Phase::Stepping], "fmi2DoStep")?;
        if !(length.is_finite() && length > 0.0) {
            return Err(format!("step size: found {length} s, expected a positive number"));
        }
        // Times of importers are sums or products of steps: they differ from ours by rounding alone.
        let same = (from - self.state.time).abs() <= 1e-6 * length + 1e-9 * from.abs();
        if !(same && (from + length).is_finite()) {
            return Err(format!("step from {from} s: the last step ended at {} s", self.state.time));
        }
        let mut values = self.state.values.clone();
        if self.state.phase == Phase::Ready {
            self.restore_unset_inputs(&mut values);
        }
        (self.model.step)(&mut values, length)?;
        self.check_finite(&values)?;
        (self.state.values, self.state.time, self.state.phase) = (values, from + length, Phase::Stepping);
        Ok(())
    }

    /// Gives the inputs their start values back if all that have one other than 0 are 0: some importers set every input to 0
    /// before the first step, whatever is wired to it.
    fn restore_unset_inputs(&self, values: &mut [f64]) {
        let inputs = self.model.scalars().enumerate().filter(|(_, (of, _))| of.causality == Causality::Input);
        let started: Vec<usize> = inputs.map(|(index, _)| index).filter(|index| self.starts[*index] != 0.0).collect();
        if started.iter().all(|index| values[*index] == 0.0) {
            for index in started {
                values[index] = self.starts[index];
            }
        }
    }

    /// Outputs and locals from the parameters.
    fn start(&mut self) -> Result<(), String> {
        let mut values = self.state.values.clone();
        (self.model.start)(&mut values)?;
        self.check_finite(&values)?;
        self.state.values = values;
        Ok(())
    }

    /// What was computed must be numbers: an overflow is no answer.
    fn check_finite(&self, values: &[f64]) -> Result<(), String> {
        match self.model.scalars().zip(values).find(|(_, value)| !value.is_finite()) {
            None => Ok(()),
            Some(((variable, _), value)) => Err(format!(
                "{}: computed {value}, expected a finite number of {}: inputs or parameters are too large",
                variable.name, variable.unit
            )),
        }
    }

    fn expect(&self, phases: &[Phase], call: &str) -> Result<(), String> {
        let found = self.state.phase;
        let help = || format!("{call}: not allowed in phase {found:?}, expected one of {phases:?}");
        if phases.contains(&found) { Ok(()) } else { Err(help()) }
    }

    fn index(&self, reference: u32) -> Result<usize, String> {
        let (index, n) = (reference as usize, self.state.values.len());
        if index < n { Ok(index) } else { Err(format!("value reference {reference}: there are {n}, from 0")) }
    }
}

impl State {
    /// The state as bytes: the interface it belongs to, phase, time and values.
    pub fn to_bytes(&self, model: &Model) -> Vec<u8> {
        let mut bytes = model.interface().into_bytes();
        let numbers = [f64::from(self.phase as u8), self.time].into_iter().chain(self.values.iter().copied());
        bytes.extend(numbers.flat_map(f64::to_le_bytes));
        bytes
    }

    /// A state from bytes.
    pub fn from_bytes(bytes: &[u8], model: &Model) -> Result<Self, String> {
        let guid = model.interface();
        let expected = guid.len() + 8 * (2 + model.values().len());
        if bytes.len() != expected || !bytes.starts_with(guid.as_bytes()) {
            let n = bytes.len();
            return Err(format!("serialised state: found {n} bytes, expected {expected} that begin with {guid}"));
        }
        let (words, _) = bytes[guid.len()..].as_chunks::<8>();
        let mut numbers = words.iter().map(|word| f64::from_le_bytes(*word));
        let (phase, time) = (numbers.next(), numbers.next());
        let phase = PHASES.into_iter().find(|known| phase == Some(f64::from(*known as u8)));
        match (phase, time) {
            (Some(phase), Some(time)) => Ok(Self { phase, time, values: numbers.collect() }),
            _ => Err("serialised state: it holds no phase that is known".to_owned()),
        }
    }
}
