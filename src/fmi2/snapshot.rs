//! The FMU state: everything but `threads` and the output, as a value and as bytes.
//!
//! Bytes: magic (8), version (4), digest of the simulation (16), length of the body (8), body (postcard), CRC-32 of all
//! before it (4); numbers little-endian. Header and checksum are read before anything is decoded.

use super::call::CallError;
use super::inputs::InputValues;
use super::instance::{Clock, Instance, Model, Values};
use super::lifecycle::Phase;
use super::status::Status;
use crate::simulation::Saved;
use serde::{Deserialize, Serialize};

const MAGIC: [u8; 8] = *b"GELSTATE";
const VERSION: u32 = 2;
const HEADER: usize = 8 + 4 + 16 + 8;
const TRAILER: usize = 4;

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
    /// A state of another mesh.
    #[error("the state does not fit the scene that it names: {reason}")]
    Mesh {
        /// What does not fit.
        reason: String,
    },
}

/// The state of an instance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Snapshot {
    phase: Phase,
    clock: Clock,
    scene: String,
    overrides: Values,
    inputs: InputValues,
    model: Option<SavedModel>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct SavedModel {
    origin: String,
    text: String,
    saved: Saved,
}

impl SavedModel {
    fn of(model: &Model) -> Self {
        Self { origin: model.origin.clone(), text: model.text.clone(), saved: model.simulation.save() }
    }

    fn into(self: &SavedModel, model: &mut Model) -> Result<(), SnapshotError> {
        model.restore(&self.saved).map_err(|e| SnapshotError::Mesh { reason: e.to_string() })
    }
}

impl Instance {
    /// The state now.
    pub(super) fn snapshot(&self) -> Snapshot {
        Snapshot {
            phase: self.phase,
            clock: self.clock,
            scene: self.settings.scene.clone(),
            overrides: self.overrides.clone(),
            inputs: self.inputs.clone(),
            model: self.model.as_ref().map(SavedModel::of),
        }
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
            return Ok(saved.into(model)?);
        }
        let scene = self.read_scene(saved.origin.clone(), saved.text.clone())?;
        let mut model = Model::build(scene, self.settings.threads)?;
        saved.into(&mut model)?;
        self.model = Some(model);
        Ok(())
    }
}

impl Snapshot {
    /// Bytes that [`Snapshot::to_bytes`] gives.
    pub(super) fn size(&self) -> usize {
        let flavor = postcard::ser_flavors::Size::default();
        let body = postcard::serialize_with_flavor(self, flavor).expect("a state consists of plain values");
        HEADER + body + TRAILER
    }

    /// The state as bytes.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.size());
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(self.model.as_ref().map_or(0, |m| m.saved.digest()).to_le_bytes());
        bytes.extend([0; 8]);
        let mut bytes = postcard::to_extend(self, bytes).expect("a state consists of plain values");
        let body = (bytes.len() - HEADER) as u64;
        bytes[HEADER - 8..HEADER].copy_from_slice(&body.to_le_bytes());
        let crc = crc32fast::hash(&bytes);
        bytes.extend(crc.to_le_bytes());
        bytes
    }

    /// The state that the bytes describe.
    pub(super) fn from_bytes(bytes: &[u8]) -> Result<Self, SnapshotError> {
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
        match postcard::take_from_bytes(&sound[HEADER..]) {
            Ok((snapshot, [])) => Ok(snapshot),
            Ok(_) | Err(_) => Err(SnapshotError::Undecodable),
        }
    }
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
        let mut it = Instance::new("a".into(), Packed::of(Err("none".into())), Log::new(false));
        it.set_up(-1.0, Some(2.0)).unwrap();
        it.set_reals(&[20, 105], &[1060.0, -7.5]).unwrap();
        it.set_input_rates(&[(105, 1)], &[3.0]).unwrap();
        it.snapshot()
    }

    #[test]
    fn bytes_give_the_same_state_back() {
        let it = snapshot();
        let bytes = it.to_bytes();
        assert_eq!(bytes.len(), it.size());
        assert_eq!(Snapshot::from_bytes(&bytes), Ok(it));
    }

    #[test]
    fn every_flipped_bit_is_refused() {
        let bytes = snapshot().to_bytes();
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(Snapshot::from_bytes(&damaged).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn every_other_length_is_refused() {
        let mut bytes = snapshot().to_bytes();
        for length in 0..bytes.len() {
            assert!(Snapshot::from_bytes(&bytes[..length]).is_err(), "{length} bytes");
        }
        bytes.push(0);
        assert!(matches!(Snapshot::from_bytes(&bytes), Err(SnapshotError::Size { .. })));
    }

    #[test]
    fn a_restored_instance_has_the_inputs_parameters_and_times() {
        let it = snapshot();
        let mut other = Instance::new("b".into(), Packed::of(Err("none".into())), Log::new(false));
        other.restore(&it).unwrap();
        assert_eq!(other.snapshot(), it);
        assert_eq!(other.real(105).unwrap(), -7.5);
    }
}
