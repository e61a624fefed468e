//! FMU state: everything except `threads` and the output, as a value and as bytes.
//!
//! The body of the bytes holds the importer's data (postcard), then the state of the simulation, if any. The envelope
//! is verified before the body is decoded.

use super::call::CallError;
use super::envelope::{SnapshotError, seal, sealed_size, verified_body};
use super::inputs::InputValues;
use super::instance::{ExperimentClock, FmuInstance};
use super::lifecycle::LifecyclePhase;
use super::memory::{MemoryPhase, reserve_large};
use super::model::BuiltModel;
use super::scalar::ScalarValues;
use super::status::CallStatus;
use crate::simulation::SavedSimulation;
use crc32fast::Hasher;
use serde::{Deserialize, Serialize};

/// Limit of the decoded bytes per encoded byte: arrays are not packed, and a mesh is checked beside them.
const MOST_PER_BYTE: u64 = 2;

/// Importer's data of a state.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct SnapshotHead {
    phase: LifecyclePhase,
    clock: ExperimentClock,
    /// Parameter `scene`.
    scene: String,
    overrides: ScalarValues,
    inputs: InputValues,
    /// Scene of the built model, if any.
    model: Option<ModelSource>,
}

/// Scene of a built model.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct ModelSource {
    origin: String,
    text: String,
}

/// State of an instance.
#[derive(Debug, PartialEq)]
pub(super) struct InstanceSnapshot {
    head: SnapshotHead,
    /// State of the simulation, if a model was built.
    saved: Option<SavedSimulation>,
}

impl FmuInstance {
    /// Copies the current state into `to`, reusing its memory.
    ///
    /// # Errors
    /// [`SnapshotError::Memory`] if the memory is too small for a copy; `to` is unchanged then.
    pub(super) fn snapshot(&self, to: &mut InstanceSnapshot) -> Result<(), SnapshotError> {
        let needed = self.model.as_ref().map_or(0, |model| model.simulation.memory_of_state());
        let _reserve = reserve_large(MemoryPhase::Saving, needed)?;
        let head = &mut to.head;
        (head.phase, head.clock) = (self.phase, self.clock);
        head.scene.clone_from(&self.settings.scene);
        copy_if_changed(&mut head.overrides, &self.overrides);
        copy_if_changed(&mut head.inputs, &self.inputs);
        let Some(model) = &self.model else {
            (head.model, to.saved) = (None, None);
            return Ok(());
        };
        let source = head.model.get_or_insert_with(|| ModelSource { origin: String::new(), text: String::new() });
        source.origin.clone_from(&model.origin);
        source.text.clone_from(&model.text);
        model.simulation.save_into(to.saved.get_or_insert_with(SavedSimulation::empty));
        Ok(())
    }

    /// Restores a state. The files of a run continue if the state belongs to its model; otherwise they are completed
    /// first.
    pub(super) fn restore(&mut self, snapshot: &InstanceSnapshot) -> Result<CallStatus, CallError> {
        let InstanceSnapshot { head, saved } = snapshot;
        let is_running = match head.phase {
            LifecyclePhase::StepComplete | LifecyclePhase::StepFailed | LifecyclePhase::Terminated => true,
            LifecyclePhase::Instantiated | LifecyclePhase::Initialization | LifecyclePhase::Fatal => false,
        };
        let continues = is_running && head.model.as_ref().is_some_and(|source| self.is_built_from(source));
        let completed = if continues { CallStatus::Ok } else { self.finish_recording() };
        match (&head.model, saved) {
            (Some(source), Some(saved)) => self.restore_model(source, saved)?,
            (None, _) | (_, None) => self.model = None,
        }
        if !continues {
            self.recording.close();
        }
        self.phase = head.phase;
        self.clock = head.clock;
        self.settings.scene.clone_from(&head.scene);
        self.overrides.clone_from(&head.overrides);
        self.inputs.clone_from(&head.inputs);
        Ok(completed.max(if is_running { self.rewind_recording() } else { CallStatus::Ok }))
    }

    /// Returns true if the present model is built from this scene.
    fn is_built_from(&self, source: &ModelSource) -> bool {
        self.model.as_ref().is_some_and(|model| model.text == source.text)
    }

    fn restore_model(&mut self, source: &ModelSource, saved: &SavedSimulation) -> Result<(), CallError> {
        if self.is_built_from(source)
            && let Some(model) = &mut self.model
        {
            return restore_into(model, saved);
        }
        let scene = self.packed.read_scene(source.origin.clone(), source.text.clone())?;
        let mut model = BuiltModel::build(scene, self.settings.threads)?;
        restore_into(&mut model, saved)?;
        self.model = Some(model);
        Ok(())
    }
}

fn restore_into(model: &mut BuiltModel, saved: &SavedSimulation) -> Result<(), CallError> {
    let _reserve = reserve_large(MemoryPhase::Restoring, model.simulation.memory_of_restoring(saved))?;
    Ok(model.restore(saved).map_err(|e| SnapshotError::Mesh { reason: e.to_string() })?)
}

/// Copies a changed value; maps cannot reuse memory.
fn copy_if_changed<T: Clone + PartialEq>(to: &mut T, from: &T) {
    if to != from {
        to.clone_from(from);
    }
}

impl InstanceSnapshot {
    /// Returns an empty state to be overwritten.
    pub(super) fn empty() -> Self {
        let head = SnapshotHead {
            phase: LifecyclePhase::Instantiated,
            clock: ExperimentClock::default(),
            scene: String::new(),
            overrides: ScalarValues::new(),
            inputs: InputValues::default(),
            model: None,
        };
        Self { head, saved: None }
    }

    fn head_bytes(&self) -> Vec<u8> {
        postcard::to_stdvec(&self.head).expect("a state consists of plain values")
    }

    /// Returns the number of bytes for [`InstanceSnapshot::write`].
    pub(super) fn size(&self) -> usize {
        sealed_size(self.head_bytes().len() + self.saved.as_ref().map_or(0, SavedSimulation::size))
    }

    /// Writes the state as bytes over all of `to`.
    pub(super) fn write(&self, to: &mut [u8]) -> Result<(), SnapshotError> {
        let (found, expected) = (to.len(), self.size());
        if found != expected {
            return Err(SnapshotError::Buffer { found, expected });
        }
        seal(to, |body| self.write_body(body));
        Ok(())
    }

    /// Writes the body; returns the digest of the simulation, 0 without a model, and the checksum of the body.
    fn write_body(&self, body: &mut [u8]) -> (u128, Hasher) {
        let (mut crc, mut rest) = (Hasher::new(), body);
        let mut sink = |run: &[u8]| {
            let (own, left) = std::mem::take(&mut rest).split_at_mut(run.len());
            own.copy_from_slice(run);
            crc.update(run);
            rest = left;
        };
        sink(&self.head_bytes());
        let digest = self.saved.as_ref().map_or(0, |saved| saved.write(&mut sink));
        (digest, crc)
    }

    /// Decodes a state from bytes, reusing memory; invalid bytes change nothing.
    pub(super) fn read(&mut self, bytes: &[u8]) -> Result<(), SnapshotError> {
        let body = verified_body(bytes)?;
        let _reserve = reserve_large(MemoryPhase::Saving, MOST_PER_BYTE * body.len() as u64)?;
        let (head, rest) = postcard::take_from_bytes::<SnapshotHead>(body).map_err(|_| SnapshotError::Undecodable)?;
        self.read_simulation(head.model.is_some(), rest)?;
        self.head = head;
        Ok(())
    }

    fn read_simulation(&mut self, is_built: bool, bytes: &[u8]) -> Result<(), SnapshotError> {
        if !is_built && bytes.is_empty() {
            self.saved = None;
            return Ok(());
        }
        if !is_built {
            return Err(SnapshotError::Undecodable);
        }
        let mut fresh = None;
        let saved = self.saved.as_mut().unwrap_or_else(|| fresh.insert(SavedSimulation::empty()));
        if !saved.read(bytes) {
            return Err(SnapshotError::Undecodable);
        }
        self.saved = fresh.or(self.saved.take());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi2::envelope::VERSION;
    use crate::fmi2::logger::CallLog;
    use crate::fmi2::parameters::PackedScene;

    fn snapshot() -> InstanceSnapshot {
        let mut it = FmuInstance::new("a".into(), PackedScene::default(), CallLog::new(false));
        it.set_up_experiment(-1.0, Some(2.0)).unwrap();
        it.set_reals(&[20, 105], &[1060.0, -7.5]).unwrap();
        it.set_input_rates(&[(105, 1)], &[3.0]).unwrap();
        state_of(&it)
    }

    fn state_of(it: &FmuInstance) -> InstanceSnapshot {
        let mut snapshot = InstanceSnapshot::empty();
        it.snapshot(&mut snapshot).unwrap();
        snapshot
    }

    fn to_bytes(snapshot: &InstanceSnapshot) -> Vec<u8> {
        let mut bytes = vec![0; snapshot.size()];
        snapshot.write(&mut bytes).unwrap();
        bytes
    }

    fn refused(bytes: &[u8]) -> SnapshotError {
        let mut other = InstanceSnapshot::empty();
        let error = other.read(bytes).unwrap_err();
        assert_eq!(other, InstanceSnapshot::empty());
        error
    }

    #[test]
    fn bytes_give_the_same_state_back() {
        let it = snapshot();
        let bytes = to_bytes(&it);
        let mut other = InstanceSnapshot::empty();
        assert_eq!(other.read(&bytes), Ok(()));
        assert_eq!(other, it);
        let (found, expected) = (bytes.len() + 1, bytes.len());
        assert_eq!(it.write(&mut vec![0; found]), Err(SnapshotError::Buffer { found, expected }));
    }

    #[test]
    fn every_flipped_bit_is_refused() {
        let bytes = to_bytes(&snapshot());
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            refused(&damaged);
        }
    }

    #[test]
    fn every_other_length_is_refused() {
        let mut bytes = to_bytes(&snapshot());
        for length in 0..bytes.len() {
            refused(&bytes[..length]);
        }
        bytes.push(0);
        assert!(matches!(refused(&bytes), SnapshotError::Size { .. }));
    }

    #[test]
    fn bytes_of_another_release_are_named() {
        let mut bytes = to_bytes(&snapshot());
        bytes[8..12].copy_from_slice(&2_u32.to_le_bytes());
        assert_eq!(refused(&bytes), SnapshotError::Version { found: 2, expected: VERSION });
    }

    #[test]
    fn a_restored_instance_has_the_inputs_parameters_and_times() {
        let it = snapshot();
        let mut other = FmuInstance::new("b".into(), PackedScene::default(), CallLog::new(false));
        other.restore(&it).unwrap();
        assert_eq!(state_of(&other), it);
        assert_eq!(other.real(105).unwrap(), -7.5);
    }
}
