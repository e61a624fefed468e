//! The FMU state: everything but `threads` and the output, as a value and as bytes.
//!
//! Bytes: magic (8), version (4), digest of the simulation (16), length of the body (8), body, CRC-32 of all before it (4);
//! numbers little-endian. Header and checksum are read before anything is decoded. The body is what the importer said
//! (postcard), then the state of the simulation, if there is one.

use super::call::CallError;
use super::inputs::InputValues;
use super::instance::{Clock, Instance, Model, Values};
use super::lifecycle::Phase;
use super::memory::{MemoryPhase, MemoryShortage, reserve_large};
use super::status::Status;
use crate::simulation::Saved;
use crc32fast::Hasher;

const MAGIC: [u8; 8] = *b"GELSTATE";
const VERSION: u32 = 12;
const HEADER: usize = 8 + 4 + 16 + 8;
const TRAILER: usize = 4;
/// Bytes of a decoded state per byte of it, at most: arrays are not packed, and a mesh is checked beside them.
const MOST_PER_BYTE: u64 = 2;

/// A state that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// Not made by this FMU.
    #[error("the pointer is not a state of this FMU, or the state was freed")]
    Foreign,
    /// Too short or too long.
    #[error("the serialised state has {found} bytes, expected {expected}: it is cut off or has something appended")]
    Size {
        /// Bytes given.
        found: usize,
        /// Bytes that the header speaks of, or the least possible.
        expected: usize,
    },
    /// Other bytes altogether.
    #[error("the bytes are not a serialised state of this FMU")]
    Magic,
    /// Another layout.
    #[error("the serialised state has version {found}, expected {expected}: it was written by another release")]
    Version {
        /// Version found.
        found: u32,
        /// Version that is read.
        expected: u32,
    },
    /// Changed on the way.
    #[error("the checksum of the serialised state is wrong: it was damaged")]
    Damaged,
    /// Sound bytes that do not describe a state.
    #[error("the serialised state cannot be decoded: it was written by another build")]
    Undecodable,
    /// A buffer of another size.
    #[error("the buffer has {found} bytes, expected {expected} as given by fmi2SerializedFMUstateSize")]
    Buffer {
        /// Size of the buffer.
        found: usize,
        /// Size of the state.
        expected: usize,
    },
    /// More memory than is available.
    #[error("{0}")]
    Memory(#[from] MemoryShortage),
    /// A state of another mesh.
    #[error("the state does not fit the scene that it names: {reason}")]
    Mesh {
        /// What does not fit.
        reason: String,
    },
}

/// All but the state of the simulation: phase, clock, scene, overrides, inputs, and origin and text of the model's scene.
type Head = (Phase, Clock, String, Values, InputValues, Option<(String, String)>);

/// The state of an instance.
#[derive(Debug, PartialEq)]
pub(super) struct Snapshot {
    phase: Phase,
    clock: Clock,
    scene: String,
    overrides: Values,
    inputs: InputValues,
    model: Option<SavedModel>,
}

#[derive(Debug, PartialEq)]
struct SavedModel {
    origin: String,
    text: String,
    saved: Saved,
}

impl SavedModel {
    fn empty() -> Self {
        Self { origin: String::new(), text: String::new(), saved: Saved::empty() }
    }

    fn take(&mut self, model: &Model) {
        self.origin.clone_from(&model.origin);
        self.text.clone_from(&model.text);
        model.simulation.save_into(&mut self.saved);
    }

    fn into(self: &SavedModel, model: &mut Model) -> Result<(), SnapshotError> {
        model.restore(&self.saved).map_err(|e| SnapshotError::Mesh { reason: e.to_string() })
    }
}

impl Instance {
    /// Writes the state now over another one, in its memory.
    ///
    /// # Errors
    /// [`SnapshotError::Memory`] if there is not enough for a copy; the other state is as it was then.
    pub(super) fn snapshot(&self, to: &mut Snapshot) -> Result<(), SnapshotError> {
        let needed = self.model.as_ref().map_or(0, |model| model.simulation.memory_of_state());
        let _reserve = reserve_large(MemoryPhase::Saving, needed)?;
        (to.phase, to.clock) = (self.phase, self.clock);
        to.scene.clone_from(&self.settings.scene);
        renew(&mut to.overrides, &self.overrides);
        renew(&mut to.inputs, &self.inputs);
        match &self.model {
            Some(model) => to.model.get_or_insert_with(SavedModel::empty).take(model),
            None => to.model = None,
        }
        Ok(())
    }

    /// Goes back, or on, to a state. The files of a run go on with it; those of another model, and of a run that the
    /// state knows nothing of, are completed before.
    pub(super) fn restore(&mut self, snapshot: &Snapshot) -> Result<Status, CallError> {
        let running = match snapshot.phase {
            Phase::StepComplete | Phase::StepFailed | Phase::Terminated => true,
            Phase::Instantiated | Phase::Initialization | Phase::Fatal => false,
        };
        let goes_on = running && snapshot.model.as_ref().is_some_and(|saved| self.has(saved));
        let completed = if goes_on { Status::Ok } else { self.finish_recording() };
        self.restore_model(snapshot.model.as_ref())?;
        if !goes_on {
            self.close_recording();
        }
        self.phase = snapshot.phase;
        self.clock = snapshot.clock;
        self.settings.scene.clone_from(&snapshot.scene);
        self.overrides.clone_from(&snapshot.overrides);
        self.inputs.clone_from(&snapshot.inputs);
        Ok(completed.max(if running { self.rewind_recording() } else { Status::Ok }))
    }

    /// Whether the model that a state was made with is there.
    fn has(&self, saved: &SavedModel) -> bool {
        self.model.as_ref().is_some_and(|model| model.text == saved.text)
    }

    fn restore_model(&mut self, saved: Option<&SavedModel>) -> Result<(), CallError> {
        let Some(saved) = saved else {
            self.model = None;
            return Ok(());
        };
        if self.has(saved)
            && let Some(model) = &mut self.model
        {
            let _reserve = reserve_large(MemoryPhase::Restoring, model.simulation.memory_of_restoring(&saved.saved))?;
            return Ok(saved.into(model)?);
        }
        let scene = self.read_scene(saved.origin.clone(), saved.text.clone())?;
        let mut model = Model::build(scene, self.settings.threads)?;
        let _reserve = reserve_large(MemoryPhase::Restoring, model.simulation.memory_of_restoring(&saved.saved))?;
        saved.into(&mut model)?;
        self.model = Some(model);
        Ok(())
    }
}

/// Copies what has changed: maps have no memory to be used again.
fn renew<T: Clone + PartialEq>(to: &mut T, from: &T) {
    if to != from {
        to.clone_from(from);
    }
}

impl Snapshot {
    /// A state of nothing, to be written over.
    pub(super) fn empty() -> Self {
        Self {
            phase: Phase::Instantiated,
            clock: Clock::default(),
            scene: String::new(),
            overrides: Values::new(),
            inputs: InputValues::default(),
            model: None,
        }
    }

    fn head(&self) -> Vec<u8> {
        let model = self.model.as_ref().map(|model| (&model.origin, &model.text));
        let head = (self.phase, self.clock, &self.scene, &self.overrides, &self.inputs, model);
        postcard::to_stdvec(&head).expect("a state consists of plain values")
    }

    /// Bytes that [`Snapshot::write`] takes.
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

    /// Digest of the simulation, 0 without one, and checksum of the body.
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

    /// Becomes the state that the bytes describe, in the memory that it has; if they describe none, nothing changes.
    pub(super) fn read(&mut self, bytes: &[u8]) -> Result<(), SnapshotError> {
        let body = sound_body(bytes)?;
        let _reserve = reserve_large(MemoryPhase::Saving, MOST_PER_BYTE * body.len() as u64)?;
        let (head, rest) = postcard::take_from_bytes::<Head>(body).map_err(|_| SnapshotError::Undecodable)?;
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

/// What stands between header and checksum, if both are right.
fn sound_body(bytes: &[u8]) -> Result<&[u8], SnapshotError> {
    let found = bytes.len();
    let header = bytes.get(..HEADER).ok_or(SnapshotError::Size { found, expected: HEADER + TRAILER })?;
    if header[..8] != MAGIC {
        return Err(SnapshotError::Magic);
    }
    let version = u32::from_le_bytes(take(&header[8..]));
    if version != VERSION {
        return Err(SnapshotError::Version { found: version, expected: VERSION });
    }
    let body = usize::try_from(u64::from_le_bytes(take(&header[28..]))).unwrap_or(usize::MAX);
    let expected = body.saturating_add(HEADER + TRAILER);
    if found != expected {
        return Err(SnapshotError::Size { found, expected });
    }
    let (sound, crc) = bytes.split_at(found - TRAILER);
    if crc32fast::hash(sound) != u32::from_le_bytes(take(crc)) {
        return Err(SnapshotError::Damaged);
    }
    Ok(&sound[HEADER..])
}

fn take<const N: usize>(bytes: &[u8]) -> [u8; N] {
    std::array::from_fn(|i| bytes[i])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi2::logger::Log;
    use crate::fmi2::parameters::Packed;

    fn snapshot() -> Snapshot {
        let mut it = Instance::new("a".into(), Packed::default(), Log::new(false));
        it.set_up(-1.0, Some(2.0)).unwrap();
        it.set_reals(&[20, 105], &[1060.0, -7.5]).unwrap();
        it.set_input_rates(&[(105, 1)], &[3.0]).unwrap();
        state_of(&it)
    }

    fn state_of(it: &Instance) -> Snapshot {
        let mut snapshot = Snapshot::empty();
        it.snapshot(&mut snapshot).unwrap();
        snapshot
    }

    fn to_bytes(snapshot: &Snapshot) -> Vec<u8> {
        let mut bytes = vec![0; snapshot.size()];
        snapshot.write(&mut bytes).unwrap();
        bytes
    }

    fn refused(bytes: &[u8]) -> SnapshotError {
        let mut other = Snapshot::empty();
        let error = other.read(bytes).unwrap_err();
        assert_eq!(other, Snapshot::empty());
        error
    }

    #[test]
    fn bytes_give_the_same_state_back() {
        let it = snapshot();
        let bytes = to_bytes(&it);
        let mut other = Snapshot::empty();
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
        let mut other = Instance::new("b".into(), Packed::default(), Log::new(false));
        other.restore(&it).unwrap();
        assert_eq!(state_of(&other), it);
        assert_eq!(other.real(105).unwrap(), -7.5);
    }
}
