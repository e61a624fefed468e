//! State of a simulation as a value and as bytes.

use super::end_watch::EndWatch;
use crate::contact::ImpulseExchange;
use crate::integrator::StepError;
use crate::reduced::ReducedState;
use crate::state::DynamicState;
use xxhash_rust::xxh3::Xxh3;

/// Stored state of a gel of either dimension, or of the reduced model.
#[derive(Debug, Clone, PartialEq)]
pub enum SavedState {
    /// Planar or axisymmetric.
    Flat(DynamicState<2>),
    /// Spatial.
    Solid(DynamicState<3>),
    /// Reduced model.
    Reduced(Box<ReducedState>),
}

/// Complete dynamic state as a value.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedSimulation {
    /// Hash of the scene and the coupling mode.
    pub origin: u64,
    /// Time reached, s.
    pub time: f64,
    /// Contact exchange of each body over the last communication step.
    pub exchanges: Vec<ImpulseExchange>,
    /// Error that ended the simulation, if any.
    pub failure: Option<StepError>,
    /// Findings of the watch over the end of the run.
    pub watch: EndWatch,
    /// Gel, bodies, ledger and record.
    pub state: SavedState,
}

/// Header of the bytes: origin, time, exchanges, failure, watch and dimension.
type StateHeader = (u64, f64, Vec<ImpulseExchange>, Option<StepError>, EndWatch, u8);

impl SavedState {
    /// Empty state of a gel of this dimension, 0 for the reduced model; `None` for others than 0, 2 and 3.
    fn empty(dimension: u8) -> Option<Self> {
        match dimension {
            2 => Some(Self::Flat(DynamicState::empty())),
            0 => Some(Self::Reduced(Box::new(ReducedState::empty()))),
            3 => Some(Self::Solid(DynamicState::empty())),
            _ => None,
        }
    }

    fn dimension(&self) -> u8 {
        match self {
            Self::Reduced(_) => 0,
            Self::Flat(_) => 2,
            Self::Solid(_) => 3,
        }
    }

    fn read(&mut self, bytes: &[u8]) -> bool {
        match self {
            Self::Flat(state) => state.read(bytes),
            Self::Solid(state) => state.read(bytes),
            Self::Reduced(state) => ReducedState::from_bytes(bytes).map(|read| **state = read).is_some(),
        }
    }

    fn write(&self, sink: &mut impl FnMut(&[u8])) {
        match self {
            Self::Flat(state) => state.write(sink),
            Self::Solid(state) => state.write(sink),
            Self::Reduced(state) => sink(&state.to_bytes()),
        }
    }
}

/// Conversion of a state into and out of [`SavedState`].
pub(super) trait EraseDimension: Sized {
    fn erase(self) -> SavedState;
    /// State of this dimension; `None` if the saved state has the other dimension.
    fn downcast(saved: &SavedState) -> Option<&Self>;
    /// Mutable state of this dimension; `None` if the saved state has the other dimension.
    fn downcast_mut(saved: &mut SavedState) -> Option<&mut Self>;
}

impl EraseDimension for DynamicState<2> {
    fn erase(self) -> SavedState {
        SavedState::Flat(self)
    }

    fn downcast(saved: &SavedState) -> Option<&Self> {
        match saved {
            SavedState::Flat(state) => Some(state),
            SavedState::Solid(_) | SavedState::Reduced(_) => None,
        }
    }

    fn downcast_mut(saved: &mut SavedState) -> Option<&mut Self> {
        match saved {
            SavedState::Flat(state) => Some(state),
            SavedState::Solid(_) | SavedState::Reduced(_) => None,
        }
    }
}

impl EraseDimension for DynamicState<3> {
    fn erase(self) -> SavedState {
        SavedState::Solid(self)
    }

    fn downcast(saved: &SavedState) -> Option<&Self> {
        match saved {
            SavedState::Solid(state) => Some(state),
            SavedState::Flat(_) | SavedState::Reduced(_) => None,
        }
    }

    fn downcast_mut(saved: &mut SavedState) -> Option<&mut Self> {
        match saved {
            SavedState::Solid(state) => Some(state),
            SavedState::Flat(_) | SavedState::Reduced(_) => None,
        }
    }
}

impl SavedSimulation {
    /// Empty state, to be written over.
    #[must_use]
    pub fn empty() -> Self {
        let state = SavedState::Solid(DynamicState::empty());
        Self { origin: 0, time: 0.0, exchanges: vec![], failure: None, watch: EndWatch::default(), state }
    }

    /// Hash of the stored state, as [`Simulation::digest`](super::Simulation::digest).
    #[must_use]
    pub fn digest(&self) -> u128 {
        match &self.state {
            SavedState::Flat(state) => state.digest(),
            SavedState::Solid(state) => state.digest(),
            SavedState::Reduced(state) => state.digest(),
        }
    }

    /// Number of elements of the mesh.
    pub(super) fn n_elements(&self) -> usize {
        match &self.state {
            SavedState::Flat(state) => state.stiffness.len(),
            SavedState::Solid(state) => state.stiffness.len(),
            SavedState::Reduced(_) => 0,
        }
    }

    fn head(&self) -> Vec<u8> {
        let head = (self.origin, self.time, &self.exchanges, &self.failure, &self.watch, self.state.dimension());
        postcard::to_stdvec(&head).expect("a state is plain values")
    }

    /// Number of bytes that [`SavedSimulation::write`] emits.
    #[must_use]
    pub fn size(&self) -> usize {
        let state = match &self.state {
            SavedState::Flat(state) => state.size(),
            SavedState::Solid(state) => state.size(),
            SavedState::Reduced(state) => state.to_bytes().len(),
        };
        self.head().len() + state
    }

    /// Emits the bytes to `sink`, run by run, and returns the digest.
    pub fn write(&self, sink: &mut impl FnMut(&[u8])) -> u128 {
        sink(&self.head());
        let mut hash = Xxh3::new();
        self.state.write(&mut |run| {
            hash.update(run);
            sink(run);
        });
        hash.digest128()
    }

    /// Reads the state from bytes into the memory that it has; returns false, and changes nothing, if the bytes are
    /// no state.
    #[must_use]
    pub fn read(&mut self, bytes: &[u8]) -> bool {
        let Ok((head, rest)) = postcard::take_from_bytes::<StateHeader>(bytes) else { return false };
        let (origin, time, exchanges, failure, watch, dimension) = head;
        if dimension == self.state.dimension() {
            if !self.state.read(rest) {
                return false;
            }
        } else {
            let Some(mut state) = SavedState::empty(dimension) else { return false };
            if !state.read(rest) {
                return false;
            }
            self.state = state;
        }
        (self.origin, self.time, self.exchanges, self.failure) = (origin, time, exchanges, failure);
        self.watch = watch;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn saved() -> SavedSimulation {
        let state = DynamicState { stiffness: vec![1.0, 2.0], ..DynamicState::empty() };
        let failure = Some(StepError::NotFinite { element: 3, time: 0.25 });
        SavedSimulation {
            origin: 7,
            time: 0.5,
            exchanges: vec![ImpulseExchange::default()],
            failure,
            watch: EndWatch::default(),
            state: SavedState::Flat(state),
        }
    }

    #[test]
    fn bytes_restore_the_value_also_over_a_state_of_the_other_dimension() {
        let mut bytes = Vec::new();
        let digest = saved().write(&mut |run| bytes.extend_from_slice(run));
        assert_eq!((digest, bytes.len()), (saved().digest(), saved().size()));
        for mut other in [SavedSimulation::empty(), SavedSimulation { time: 1.0, ..saved() }] {
            assert!(other.read(&bytes));
            assert_eq!(other, saved());
        }
    }

    #[test]
    fn invalid_bytes_change_nothing() {
        let mut bytes = Vec::new();
        saved().write(&mut |run| bytes.extend_from_slice(run));
        let mut another = bytes.clone();
        // The dimension is the last byte of the header.
        another[saved().head().len() - 1] = 4;
        for bytes in [&bytes[..bytes.len() - 1], &another, b""] {
            for mut other in [SavedSimulation::empty(), SavedSimulation { time: 1.0, ..saved() }] {
                let before = other.clone();
                assert!(!other.read(bytes));
                assert_eq!(other, before);
            }
        }
    }
}
