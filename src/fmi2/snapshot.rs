//! FMU state: everything except `threads` and the output, as a value and as bytes.
//!
//! Layout, little-endian: magic (8 bytes), version (4), digest of the simulation (16), length of the body (8), body,
//! CRC-32 of the preceding bytes (4). Header and checksum are verified before decoding. The body holds the importer's
//! data (postcard), then the state of the simulation, if any.

use super::call::CallError;
use super::inputs::InputValues;
use super::instance::{BuiltModel, ExperimentClock, FmuInstance, ScalarValues};
use super::lifecycle::LifecyclePhase;
use super::memory::{MemoryPhase, MemoryShortage, reserve_large};
use super::status::CallStatus;
use crate::simulation::SavedSimulation;
use crc32fast::Hasher;

const MAGIC: [u8; 8] = *b"GELSTATE";
const VERSION: u32 = 12;
const HEADER: usize = 8 + 4 + 16 + 8;
const TRAILER: usize = 4;
/// Limit of the decoded bytes per encoded byte: arrays are not packed, and a mesh is checked beside them.
const MOST_PER_BYTE: u64 = 2;

/// Error of an unusable state.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// Foreign pointer.
    #[error("the pointer is not a state of this FMU, or the state was freed")]
    Foreign,
    /// Wrong length.
    #[error("the serialised state has {found} bytes, expected {expected}: it is cut off or has something appended")]
    Size {
        /// Given bytes.
        found: usize,
        /// Bytes according to the header, or the least possible length.
        expected: usize,
    },
    /// Wrong magic bytes.
    #[error("the bytes are not a serialised state of this FMU")]
    Magic,
    /// Wrong version of the layout.
    #[error("the serialised state has version {found}, expected {expected}: it was written by another release")]
    Version {
        /// Found version.
        found: u32,
        /// Supported version.
        expected: u32,
    },
    /// Wrong checksum.
    #[error("the checksum of the serialised state is wrong: it was damaged")]
    Damaged,
    /// Undecodable body.
    #[error("the serialised state cannot be decoded: it was written by another build")]
    Undecodable,
    /// Wrong size of the buffer.
    #[error("the buffer has {found} bytes, expected {expected} as given by fmi2SerializedFMUstateSize")]
    Buffer {
        /// Size of the buffer.
        found: usize,
        /// Size of the state.
        expected: usize,
    },
    /// Shortage of memory.
    #[error("{0}")]
    Memory(#[from] MemoryShortage),
    /// State of another mesh.
    #[error("the state does not fit the scene that it names: {reason}")]
    Mesh {
        /// Mismatch.
        reason: String,
    },
}

/// Importer's data of a state: phase, clock, scene, overrides, inputs, and origin and text of the model's scene.
type SnapshotHead = (LifecyclePhase, ExperimentClock, String, ScalarValues, InputValues, Option<(String, String)>);

/// State of an instance.
#[derive(Debug, PartialEq)]
pub(super) struct InstanceSnapshot {
    phase: LifecyclePhase,
    clock: ExperimentClock,
    scene: String,
    overrides: ScalarValues,
    inputs: InputValues,
    model: Option<SavedModel>,
}

#[derive(Debug, PartialEq)]
struct SavedModel {
    origin: String,
    text: String,
    saved: SavedSimulation,
}

impl SavedModel {
    fn empty() -> Self {
        Self { origin: String::new(), text: String::new(), saved: SavedSimulation::empty() }
    }

    fn save(&mut self, model: &BuiltModel) {
        self.origin.clone_from(&model.origin);
        self.text.clone_from(&model.text);
        model.simulation.save_into(&mut self.saved);
    }

    fn restore_into(self: &SavedModel, model: &mut BuiltModel) -> Result<(), SnapshotError> {
        model.restore(&self.saved).map_err(|e| SnapshotError::Mesh { reason: e.to_string() })
    }
}

impl FmuInstance {
    /// Copies the current state into `to`, reusing its memory.
    ///
    /// # Errors
    /// [`SnapshotError::Memory`] if the memory is too small for a copy; `to` is unchanged then.
    pub(super) fn snapshot(&self, to: &mut InstanceSnapshot) -> Result<(), SnapshotError> {
        let needed = self.model.as_ref().map_or(0, |model| model.simulation.memory_of_state());
        let _reserve = reserve_large(MemoryPhase::Saving, needed)?;
        (to.phase, to.clock) = (self.phase, self.clock);
        to.scene.clone_from(&self.settings.scene);
        copy_if_changed(&mut to.overrides, &self.overrides);
        copy_if_changed(&mut to.inputs, &self.inputs);
        match &self.model {
            Some(model) => to.model.get_or_insert_with(SavedModel::empty).save(model),
            None => to.model = None,
        }
        Ok(())
    }

    /// Restores a state. The files of a run continue if the state belongs to its model; otherwise they are completed
    /// first.
    pub(super) fn restore(&mut self, snapshot: &InstanceSnapshot) -> Result<CallStatus, CallError> {
        let is_running = match snapshot.phase {
            LifecyclePhase::StepComplete | LifecyclePhase::StepFailed | LifecyclePhase::Terminated => true,
            LifecyclePhase::Instantiated | LifecyclePhase::Initialization | LifecyclePhase::Fatal => false,
        };
        let continues = is_running && snapshot.model.as_ref().is_some_and(|saved| self.is_built_from(saved));
        let completed = if continues { CallStatus::Ok } else { self.finish_recording() };
        self.restore_model(snapshot.model.as_ref())?;
        if !continues {
            self.close_recording();
        }
        self.phase = snapshot.phase;
        self.clock = snapshot.clock;
        self.settings.scene.clone_from(&snapshot.scene);
        self.overrides.clone_from(&snapshot.overrides);
        self.inputs.clone_from(&snapshot.inputs);
        Ok(completed.max(if is_running { self.rewind_recording() } else { CallStatus::Ok }))
    }

    /// Returns true if the model of a saved state is the present model.
    fn is_built_from(&self, saved: &SavedModel) -> bool {
        self.model.as_ref().is_some_and(|model| model.text == saved.text)
    }

    fn restore_model(&mut self, saved: Option<&SavedModel>) -> Result<(), CallError> {
        let Some(saved) = saved else {
            self.model = None;
            return Ok(());
        };
        if self.is_built_from(saved)
            && let Some(model) = &mut self.model
        {
            let _reserve = reserve_large(MemoryPhase::Restoring, model.simulation.memory_of_restoring(&saved.saved))?;
            return Ok(saved.restore_into(model)?);
        }
        let scene = self.read_scene(saved.origin.clone(), saved.text.clone())?;
        let mut model = BuiltModel::build(scene, self.settings.threads)?;
        let _reserve = reserve_large(MemoryPhase::Restoring, model.simulation.memory_of_restoring(&saved.saved))?;
        saved.restore_into(&mut model)?;
        self.model = Some(model);
        Ok(())
    }
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
        Self {
            phase: LifecyclePhase::Instantiated,
            clock: ExperimentClock::default(),
            scene: String::new(),
            overrides: ScalarValues::new(),
            inputs: InputValues::default(),
            model: None,
        }
    }

    fn head(&self) -> Vec<u8> {
        let model = self.model.as_ref().map(|model| (&model.origin, &model.text));
        let head = (self.phase, self.clock, &self.scene, &self.overrides, &self.inputs, model);
        postcard::to_stdvec(&head).expect("a state consists of plain values")
    }

    /// Returns the number of bytes for [`InstanceSnapshot::write`].
    pub(super) fn size(&self) -> usize {
        HEADER + self.head().len() + self.model.as_ref().map_or(0, |model| model.saved.size()) + TRAILER
    }

    /// Writes the state as bytes over all of `to`.
    pub(super) fn write(&self, to: &mut [u8]) -> Result<(), SnapshotError> {
        let (found, expected) = (to.len(), self.size());
        if found != expected {
            return Err(SnapshotError::Buffer { found, expected });
        }
        let (header, rest) = to.split_at_mut(HEADER);
        let (body, trailer) = rest.split_at_mut(expected - HEADER - TRAILER);
        let (digest, crc_of_body) = self.write_body(body);
        header[..8].copy_from_slice(&MAGIC);
        header[8..12].copy_from_slice(&VERSION.to_le_bytes());
        header[12..28].copy_from_slice(&digest.to_le_bytes());
        header[28..].copy_from_slice(&(body.len() as u64).to_le_bytes());
        let mut crc = Hasher::new();
        crc.update(header);
        crc.combine(&crc_of_body);
        trailer.copy_from_slice(&crc.finalize().to_le_bytes());
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
        sink(&self.head());
        let digest = self.model.as_ref().map_or(0, |model| model.saved.write(&mut sink));
        (digest, crc)
    }

    /// Decodes a state from bytes, reusing memory; invalid bytes change nothing.
    pub(super) fn read(&mut self, bytes: &[u8]) -> Result<(), SnapshotError> {
        let body = verified_body(bytes)?;
        let _reserve = reserve_large(MemoryPhase::Saving, MOST_PER_BYTE * body.len() as u64)?;
        let (head, rest) = postcard::take_from_bytes::<SnapshotHead>(body).map_err(|_| SnapshotError::Undecodable)?;
        let (phase, clock, scene, overrides, inputs, model) = head;
        self.read_model(model, rest)?;
        (self.phase, self.clock, self.scene, self.overrides, self.inputs) = (phase, clock, scene, overrides, inputs);
        Ok(())
    }

    fn read_model(&mut self, of: Option<(String, String)>, bytes: &[u8]) -> Result<(), SnapshotError> {
        let Some((origin, text)) = of else {
            if !bytes.is_empty() {
                return Err(SnapshotError::Undecodable);
            }
            self.model = None;
            return Ok(());
        };
        let mut fresh = None;
        let model = self.model.as_mut().unwrap_or_else(|| fresh.insert(SavedModel::empty()));
        if !model.saved.read(bytes) {
            return Err(SnapshotError::Undecodable);
        }
        (model.origin, model.text) = (origin, text);
        self.model = fresh.or(self.model.take());
        Ok(())
    }
}

/// Returns the body between header and checksum, if both are valid.
fn verified_body(bytes: &[u8]) -> Result<&[u8], SnapshotError> {
    let found = bytes.len();
    let header = bytes.get(..HEADER).ok_or(SnapshotError::Size { found, expected: HEADER + TRAILER })?;
    if header[..8] != MAGIC {
        return Err(SnapshotError::Magic);
    }
    let version = u32::from_le_bytes(first_bytes(&header[8..]));
    if version != VERSION {
        return Err(SnapshotError::Version { found: version, expected: VERSION });
    }
    let body = usize::try_from(u64::from_le_bytes(first_bytes(&header[28..]))).unwrap_or(usize::MAX);
    let expected = body.saturating_add(HEADER + TRAILER);
    if found != expected {
        return Err(SnapshotError::Size { found, expected });
    }
    let (sound, crc) = bytes.split_at(found - TRAILER);
    if crc32fast::hash(sound) != u32::from_le_bytes(first_bytes(crc)) {
        return Err(SnapshotError::Damaged);
    }
    Ok(&sound[HEADER..])
}

fn first_bytes<const N: usize>(bytes: &[u8]) -> [u8; N] {
    std::array::from_fn(|i| bytes[i])
}

#[cfg(test)]
mod tests {
    use super::*;
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
