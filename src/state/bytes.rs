//! Binary form of a state: a header by postcard, then the plain arrays, numbers little-endian.
//!
//! The bytes come in runs, so that the receiver can hash or copy each while it is in the nearest cache.

use super::mesh_instance::{InstanceArrays, MeshInstance, numbers, simplex};
use super::{CavityGas, DynamicState, GroupAlarm, GroupClock, RunRecord, StateSizes, Tick};
use crate::constitutive::MaterialParts;
use crate::contact::BodyState;
use crate::fem::{HistoryVariables, ReferenceShape};
use crate::ledger::Ledger;
use crate::math::{Tensor, Vector};
use crate::mesh::{ElementId, Simplex};
use std::sync::Arc;
use xxhash_rust::xxh3::Xxh3;

/// Maximum bytes of a run: with its source it stays in a first-level cache of 32 kB.
const RUN_BYTES: usize = 8192;

/// Header of the binary form: all data but the arrays. The tick of a remeshed mesh comes with the marks of its
/// facets.
type BinaryHeader = (StateSizes, (Option<Tick>, Tick, Vec<u8>), Vec<BodyState>, Ledger, RunRecord);

/// Values with a fixed number of bytes.
trait FixedBytes: Sized {
    const SIZE: usize;
    fn encode(&self, to: &mut [u8]);
    fn decode(from: &[u8]) -> Self;
}

impl FixedBytes for u64 {
    const SIZE: usize = 8;

    fn encode(&self, to: &mut [u8]) {
        to.copy_from_slice(&self.to_le_bytes());
    }

    fn decode(from: &[u8]) -> Self {
        Self::from_le_bytes(first_bytes(from))
    }
}

impl FixedBytes for u32 {
    const SIZE: usize = 4;

    fn encode(&self, to: &mut [u8]) {
        to.copy_from_slice(&self.to_le_bytes());
    }

    fn decode(from: &[u8]) -> Self {
        Self::from_le_bytes(first_bytes(from))
    }
}

impl FixedBytes for f64 {
    const SIZE: usize = 8;

    fn encode(&self, to: &mut [u8]) {
        self.to_bits().encode(to);
    }

    fn decode(from: &[u8]) -> Self {
        Self::from_bits(u64::decode(from))
    }
}

impl<const D: usize> FixedBytes for Vector<D> {
    const SIZE: usize = 8 * D;

    fn encode(&self, to: &mut [u8]) {
        to.chunks_exact_mut(8).zip(self.as_slice()).for_each(|(to, component)| component.encode(to));
    }

    fn decode(from: &[u8]) -> Self {
        Self::from_fn(|i, _| f64::decode(&from[8 * i..]))
    }
}

impl FixedBytes for GroupClock {
    const SIZE: usize = 36;

    fn encode(&self, to: &mut [u8]) {
        self.step.encode(&mut to[..8]);
        self.energy.encode(&mut to[8..16]);
        self.ahead.encode(&mut to[16..24]);
        to[24..28].copy_from_slice(&self.calm.to_le_bytes());
        to[28..32].copy_from_slice(&self.inverted.to_le_bytes());
        to[32..36].copy_from_slice(&self.crushed.to_le_bytes());
    }

    fn decode(from: &[u8]) -> Self {
        let count = |at: usize| u32::from_le_bytes(first_bytes(&from[at..]));
        Self {
            step: Tick::decode(from),
            energy: f64::decode(&from[8..]),
            ahead: f64::decode(&from[16..]),
            calm: count(24),
            inverted: count(28),
            crushed: count(32),
        }
    }
}

impl FixedBytes for u8 {
    const SIZE: usize = 1;

    fn encode(&self, to: &mut [u8]) {
        to[0] = *self;
    }

    fn decode(from: &[u8]) -> Self {
        from[0]
    }
}

impl FixedBytes for [f64; 4] {
    const SIZE: usize = 32;

    fn encode(&self, to: &mut [u8]) {
        to.chunks_exact_mut(8).zip(self).for_each(|(to, number)| number.encode(to));
    }

    fn decode(from: &[u8]) -> Self {
        [0, 8, 16, 24].map(|at| f64::decode(&from[at..]))
    }
}

impl<const D: usize> FixedBytes for (ElementId, ReferenceShape<D>) {
    const SIZE: usize = 4 + 8 * (D * D + 1);

    fn encode(&self, to: &mut [u8]) {
        let (id, numbers) = to.split_at_mut(4);
        id.copy_from_slice(&self.0.0.to_le_bytes());
        let own = self.1.edges.iter().chain([&self.1.radius]);
        numbers.chunks_exact_mut(8).zip(own).for_each(|(to, number)| number.encode(to));
    }

    fn decode(from: &[u8]) -> Self {
        let number = |i: usize| f64::decode(&from[4 + 8 * i..]);
        let edges = Tensor::<D>::from_fn(|row, column| number(column * D + row));
        (ElementId(u32::from_le_bytes(first_bytes(from))), ReferenceShape { edges, radius: number(D * D) })
    }
}

impl FixedBytes for Simplex {
    const SIZE: usize = 16;

    fn encode(&self, to: &mut [u8]) {
        to.chunks_exact_mut(4).zip(numbers(self)).for_each(|(to, node)| to.copy_from_slice(&node.to_le_bytes()));
    }

    fn decode(from: &[u8]) -> Self {
        simplex([0, 4, 8, 12].map(|at| u32::from_le_bytes(first_bytes(&from[at..]))))
    }
}

impl FixedBytes for GroupAlarm {
    const SIZE: usize = 16;

    fn encode(&self, to: &mut [u8]) {
        self.last.encode(&mut to[..8]);
        self.next.encode(&mut to[8..]);
    }

    fn decode(from: &[u8]) -> Self {
        Self { last: Tick::decode(from), next: Tick::decode(&from[8..]) }
    }
}

impl FixedBytes for CavityGas {
    const SIZE: usize = 24;

    fn encode(&self, to: &mut [u8]) {
        self.pressure.encode(&mut to[..8]);
        self.volume.encode(&mut to[8..16]);
        self.tick.encode(&mut to[16..]);
    }

    fn decode(from: &[u8]) -> Self {
        Self { pressure: f64::decode(from), volume: f64::decode(&from[8..]), tick: Tick::decode(&from[16..]) }
    }
}

impl<const D: usize> FixedBytes for HistoryVariables<D> {
    const SIZE: usize = 8 * (D * D + 4);

    fn encode(&self, to: &mut [u8]) {
        let Self { inverse, out, jacobian, damage, stress } = self;
        let own = inverse.iter().chain([out, jacobian, damage, stress]);
        to.chunks_exact_mut(8).zip(own).for_each(|(to, number)| number.encode(to));
    }

    fn decode(from: &[u8]) -> Self {
        let number = |i: usize| f64::decode(&from[8 * i..]);
        let inverse = Tensor::<D>::from_fn(|row, column| number(column * D + row));
        let [out, jacobian, damage, stress] = [0, 1, 2, 3].map(|i| number(D * D + i));
        Self { inverse, out, jacobian, damage, stress }
    }
}

/// Returns the first N bytes.
fn first_bytes<const N: usize>(from: &[u8]) -> [u8; N] {
    *from.first_chunk().expect("the bytes of a number")
}

/// Writes an array in runs.
fn write_all<T: FixedBytes>(items: &[T], sink: &mut impl FnMut(&[u8])) {
    let mut run = [0; RUN_BYTES];
    for items in items.chunks(RUN_BYTES / T::SIZE) {
        let run = &mut run[..items.len() * T::SIZE];
        run.chunks_exact_mut(T::SIZE).zip(items).for_each(|(to, item)| item.encode(to));
        sink(run);
    }
}

/// Reads an array from the front of the bytes, which are long enough, into existing memory.
fn read_all<T: FixedBytes>(items: &mut Vec<T>, n: usize, bytes: &mut &[u8]) {
    let (own, rest) = bytes.split_at(n * T::SIZE);
    items.clear();
    items.extend(own.chunks_exact(T::SIZE).map(T::decode));
    *bytes = rest;
}

/// Bytes of a node of a remeshed mesh: mass and held directions.
const NODE_BYTES: usize = f64::SIZE + u8::SIZE;
/// Bytes of an element of a remeshed mesh: nodes, corner masses, patch and first step.
const ELEMENT_BYTES: usize = Simplex::SIZE + <[f64; 4]>::SIZE + u32::SIZE + f64::SIZE;

/// Reads the mesh instance; `None` if the bytes are no valid mesh.
fn read_mesh_instance<const D: usize>(
    sizes: &StateSizes,
    tick: Tick,
    marks: Vec<u8>,
    mut bytes: &[u8],
) -> Option<Arc<MeshInstance<D>>> {
    let mut arrays = InstanceArrays::default();
    read_all(&mut arrays.rest, sizes.nodes, &mut bytes);
    read_all(&mut arrays.position, sizes.nodes, &mut bytes);
    read_all(&mut arrays.mass, sizes.nodes, &mut bytes);
    read_all(&mut arrays.held, sizes.nodes, &mut bytes);
    read_all(&mut arrays.elements, sizes.born, &mut bytes);
    read_all(&mut arrays.corner_mass, sizes.born, &mut bytes);
    read_all(&mut arrays.references, sizes.references, &mut bytes);
    read_all(&mut arrays.patch, sizes.born, &mut bytes);
    read_all(&mut arrays.parts, sizes.layered, &mut bytes);
    read_all(&mut arrays.steps, sizes.born, &mut bytes);
    MeshInstance::from_arrays(tick, arrays, marks).map(Arc::new)
}

impl StateSizes {
    /// Returns the bytes of the arrays; `None` on overflow.
    fn array_bytes<const D: usize>(&self) -> Option<usize> {
        let arrays = [
            (self.nodes, 2 * Vector::<D>::SIZE + f64::SIZE),
            (self.slots, f64::SIZE),
            (self.groups, GroupClock::SIZE),
            (self.alarms, GroupAlarm::SIZE),
            (self.memories, HistoryVariables::<D>::SIZE),
            (self.instance_nodes(), NODE_BYTES + 2 * Vector::<D>::SIZE),
            (self.born, ELEMENT_BYTES),
            (self.references, <(ElementId, ReferenceShape<D>)>::SIZE),
            (self.layered, MaterialParts::SIZE),
        ];
        arrays.into_iter().try_fold(0_usize, |sum, (n, size)| sum.checked_add(n.checked_mul(size)?))
    }

    /// Returns the bytes of the mesh instance at the end of the arrays; called once [`Self::array_bytes`] has succeeded.
    fn instance_bytes<const D: usize>(&self) -> usize {
        self.instance_nodes() * (NODE_BYTES + 2 * Vector::<D>::SIZE)
            + self.born * ELEMENT_BYTES
            + self.references * <(ElementId, ReferenceShape<D>)>::SIZE
            + self.layered * MaterialParts::SIZE
    }

    /// Returns the number of nodes of the mesh instance.
    fn instance_nodes(&self) -> usize {
        if self.born > 0 { self.nodes } else { 0 }
    }
}

impl<const D: usize> DynamicState<D> {
    /// Returns the sizes of the arrays.
    fn sizes(&self) -> StateSizes {
        StateSizes {
            nodes: self.position.len(),
            slots: self.stiffness.len(),
            groups: self.clocks.len(),
            alarms: self.alarms.len(),
            memories: self.memory.len(),
            bodies: self.bodies.len(),
            born: self.birth.as_ref().map_or(0, |birth| birth.mesh.elements.len()),
            references: self.birth.as_ref().map_or(0, |birth| birth.references.len()),
            layered: self.birth.as_ref().map_or(0, |birth| birth.parts.len()),
        }
    }

    /// Serialises the header.
    fn header(&self) -> Vec<u8> {
        let (born, marks) = self.birth.as_ref().map_or((0, &[][..]), |birth| (birth.tick, birth.mesh.marks.as_slice()));
        let header = (self.sizes(), (self.now, born, marks), &self.bodies, &self.ledger, &self.record);
        postcard::to_stdvec(&header).expect("a state is plain numbers")
    }

    /// Returns the number of bytes that [`DynamicState::write`] writes.
    #[must_use]
    pub fn size(&self) -> usize {
        let gas = self.record.gas.map_or(0, |_| CavityGas::SIZE);
        self.header().len() + self.sizes().array_bytes::<D>().unwrap_or(usize::MAX - gas) + gas
    }

    /// Writes the bytes of the state to `sink`, run by run.
    pub fn write(&self, sink: &mut impl FnMut(&[u8])) {
        // Listed by name, so that no field is forgotten.
        let Self { position, velocity, excess, stiffness, clocks, alarms, memory, birth, .. } = self;
        let Self { now: _, bodies: _, ledger: _, record, .. } = self;
        sink(&self.header());
        write_all(position, sink);
        write_all(velocity, sink);
        write_all(excess, sink);
        write_all(stiffness, sink);
        write_all(clocks, sink);
        write_all(alarms, sink);
        write_all(memory, sink);
        if let Some(birth) = birth {
            write_all(&birth.mesh.rest, sink);
            write_all(&birth.position, sink);
            write_all(&birth.mass, sink);
            write_all(&birth.held(), sink);
            write_all(&birth.mesh.elements, sink);
            write_all(&birth.corner_mass, sink);
            write_all(&birth.references, sink);
            write_all(&birth.patch_numbers(), sink);
            write_all(&birth.parts, sink);
            write_all(&birth.steps, sink);
        }
        write_all(record.gas.as_slice(), sink);
    }

    /// Reads the state from bytes into existing memory; returns true on success. Malformed bytes change nothing;
    /// [`DynamicState::check_invariants`] checks the values.
    #[must_use]
    pub fn read(&mut self, bytes: &[u8]) -> bool {
        let Ok((header, mut arrays)) = postcard::take_from_bytes::<BinaryHeader>(bytes) else { return false };
        let sizes = header.0;
        let Some(behind) = sizes.array_bytes::<D>().and_then(|bytes| arrays.len().checked_sub(bytes)) else {
            return false;
        };
        if behind != 0 && behind != CavityGas::SIZE {
            return false;
        }
        let (own, gas) = arrays.split_at(arrays.len() - behind);
        arrays = own;
        let end = &arrays[arrays.len() - sizes.instance_bytes::<D>()..];
        let born = (sizes.born > 0).then(|| read_mesh_instance(&sizes, header.1.1, header.1.2.clone(), end));
        if born == Some(None) {
            return false;
        }
        let Self { position, velocity, excess, stiffness, clocks, alarms, memory, birth, .. } = self;
        let Self { now, bodies, ledger, record, .. } = self;
        (_, (*now, ..), *bodies, *ledger, *record) = header;
        *birth = born.flatten();
        record.gas = (behind > 0).then(|| CavityGas::decode(gas));
        read_all(position, sizes.nodes, &mut arrays);
        read_all(velocity, sizes.nodes, &mut arrays);
        read_all(excess, sizes.nodes, &mut arrays);
        read_all(stiffness, sizes.slots, &mut arrays);
        read_all(clocks, sizes.groups, &mut arrays);
        read_all(alarms, sizes.alarms, &mut arrays);
        read_all(memory, sizes.memories, &mut arrays);
        true
    }

    /// Returns the hash of the bytes of the state: equal digests are equal bits.
    #[must_use]
    pub fn digest(&self) -> u128 {
        let mut hash = Xxh3::new();
        self.write(&mut |run| hash.update(run));
        hash.digest128()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector3;

    fn state() -> DynamicState<3> {
        let n = 1000;
        let vector = |i: usize| Vector3::new(i as f64, -0.5, f64::MIN_POSITIVE / 2.0);
        let clock = |i: u32| GroupClock {
            step: 1 << (i % 40),
            energy: f64::from(i),
            ahead: -0.0,
            calm: i,
            inverted: u32::MAX,
            crushed: 2,
        };
        DynamicState {
            position: (0..n).map(vector).collect(),
            velocity: (n..2 * n).map(vector).collect(),
            excess: vec![-1e-300; n],
            stiffness: (0..3 * n).map(|i| 1.0 / (1 + i) as f64).collect(),
            clocks: (0..700).map(clock).collect(),
            alarms: vec![GroupAlarm { last: 3, next: u64::MAX }; 2],
            now: Some(7),
            ..DynamicState::empty()
        }
    }

    fn written(state: &DynamicState<3>) -> Vec<u8> {
        let mut bytes = Vec::new();
        state.write(&mut |run| bytes.extend_from_slice(run));
        bytes
    }

    #[test]
    fn bytes_give_the_same_bits_back_whatever_was_there() {
        let bytes = written(&state());
        assert_eq!(bytes.len(), state().size());
        let longer = DynamicState { stiffness: vec![2.0; 10_000], clocks: vec![], ..state() };
        for mut other in [DynamicState::empty(), longer] {
            assert!(other.read(&bytes));
            assert_eq!(other, state());
            assert_eq!(written(&other), bytes);
        }
    }

    #[test]
    fn the_air_in_the_cavity_follows_the_arrays() {
        let mut with = state();
        with.record.gas = Some(CavityGas { pressure: 0.3, volume: 1e-5, tick: 9 });
        let bytes = written(&with);
        assert_eq!((bytes.len(), &bytes[..written(&state()).len()]), (with.size(), written(&state()).as_slice()));
        let mut other = DynamicState::empty();
        assert!(other.read(&bytes) && other == with && other.read(&written(&state())) && other == state());
    }

    #[test]
    fn the_digest_is_that_of_the_bytes() {
        assert_eq!(state().digest(), xxhash_rust::xxh3::xxh3_128(&written(&state())));
        let mut other = state();
        other.velocity[999].z = 0.0;
        assert_ne!(other.digest(), state().digest());
    }

    #[test]
    fn bytes_of_another_length_change_nothing() {
        let bytes = written(&state());
        let mut other = DynamicState::<3> { now: Some(1), ..DynamicState::empty() };
        for length in [0, 1, 40, bytes.len() - 1] {
            assert!(!other.read(&bytes[..length]), "{length}");
        }
        assert!(!other.read(&[bytes.as_slice(), &[0]].concat()));
        assert_eq!(other, DynamicState { now: Some(1), ..DynamicState::empty() });
    }

    #[test]
    fn sizes_that_overflow_are_refused() {
        let sizes = StateSizes {
            // Times the 56 bytes of a node it is 0 in 64 bits, as many as follow.
            nodes: 1 << (usize::BITS - 3),
            slots: 0,
            groups: 0,
            alarms: 0,
            memories: 0,
            bodies: 0,
            born: 0,
            references: 0,
            layered: 0,
        };
        let header: BinaryHeader = (sizes, (None, 0, vec![]), vec![], Ledger::default(), RunRecord::new(0));
        assert!(!DynamicState::<3>::empty().read(&postcard::to_stdvec(&header).unwrap()));
    }
}
