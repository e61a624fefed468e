//! Transfer of the history of a two-network gel to a new mesh (method 4.6): spatial tensors b̄ are averaged, and
//! pulled back to the reference shape of each new element.

use super::patch_volume_share::stays;
use super::rest_volumes::{rest_of, rests};
use super::source_mesh::{SourceMesh, TargetMesh};
use crate::constitutive::{
    ElasticAverage, IsochoricDeformation, IsochoricShape, LeftCauchyGreen, TwoNetwork, WeightedElastic, average_elastic,
};
use crate::fem::{HistoryVariables, Potential, ReferenceShape, Section};
use crate::math::{SymmetricTensor, Tensor, Vector, array, cofactor, det, map_chunks_in_order, map_in_order};
use crate::mesh::{ElementId, ElementPatches};
use crate::remesh::{OverlapSource, UnchangedElement};

/// Most networks: the elastic one and the branches.
const MOST_NETWORKS: usize = 1 + TwoNetwork::MOST_BRANCHES;
/// Part 1 − d of the elastic network that is intact, below which its rest state is free: it stores nothing.
const NEGLIGIBLE: f64 = 1e-9;
/// Least number of old elements whose states a thread finds.
const OLD_ELEMENTS: usize = 32;
/// Number of new elements whose history a thread finds at once.
const NEW_ELEMENTS: usize = 256;

/// New elements with their rest shapes, and their history variables.
pub(super) struct NetworkHistory<const D: usize> {
    /// Rest shapes of the incompatible elements, which differ from the shape of their nodes' rest positions, in order.
    pub references: Vec<(ElementId, ReferenceShape<D>)>,
    /// Records of all elements.
    pub memory: Vec<HistoryVariables<D>>,
}

/// Spatial state of an element: b̄ of the elastic network, then of each branch, and the damage.
#[derive(Clone, Copy)]
struct SpatialState<const D: usize> {
    networks: [LeftCauchyGreen<D>; MOST_NETWORKS],
    damage: f64,
    /// Strength relative to that of the gel.
    strength: f64,
}

/// Transfer from an old mesh with its nodes at `x`.
struct NetworkTransfer<'a, const D: usize> {
    gel: &'a TwoNetwork,
    past: &'a SourceMesh<'a, D>,
    x: &'a [Vector<D>],
    rule: ElasticAverage,
}

/// States of the old elements that are sources of new ones.
struct SourceStates<const D: usize> {
    /// Elements, ascending.
    elements: Vec<ElementId>,
    /// States in the same order; `None` for an inverted element.
    states: Vec<Option<SpatialState<D>>>,
}

/// New elements, with the states of their sources and their measures at rest.
struct NewElements<'a, const D: usize> {
    mesh: &'a TargetMesh<'a, D>,
    sources: SourceStates<D>,
    /// True for unchanged elements in an unchanged patch.
    stays: Vec<bool>,
    /// Measures at rest of the elements.
    rests: Vec<f64>,
}

impl<const D: usize> SourceStates<D> {
    /// State of an old element; `None` if it is inverted.
    fn of(&self, element: ElementId) -> Option<&SpatialState<D>> {
        self.states[self.elements.binary_search(&element).ok()?].as_ref()
    }
}

/// Transfers the history of a two-network gel; `None` if an element has no valid rest shape.
///
/// Elements unchanged in an unchanged patch keep their reference. Another unchanged element keeps b̄ and its damage,
/// and takes the J of its patch. A new element gets the mean b̄ of its sources, and its damage by mass. References
/// other than those of the nodes are the present shape, scaled to the rest measure.
pub(super) fn inherit_networks<const D: usize>(
    gel: &TwoNetwork,
    past: &SourceMesh<'_, D>,
    x: &[Vector<D>],
    new: &TargetMesh<'_, D>,
    patches: &ElementPatches,
) -> Option<NetworkHistory<D>> {
    let transfer = NetworkTransfer { gel, past, x, rule: new.rule };
    let all = NewElements {
        mesh: new,
        sources: transfer.source_states(new.sources),
        stays: stays(past.potential.patches(), patches, new.same),
        rests: rests(past, x, new),
    };
    let n = gel.records();
    let mut memory = vec![HistoryVariables::default(); new.elements.len() * n];
    let references =
        map_chunks_in_order(&mut memory, NEW_ELEMENTS * n, |row, memory| transfer.inherit(&all, row / n, memory));
    let references = references.into_iter().collect::<Option<Vec<_>>>()?.concat();
    Some(NetworkHistory { references, memory })
}

impl<const D: usize> NetworkTransfer<'_, D> {
    fn is_ring(&self) -> bool {
        self.past.potential.section() == Section::Axisymmetric
    }

    /// States of the old elements of these sources.
    fn source_states(&self, sources: &[OverlapSource]) -> SourceStates<D> {
        let mut elements: Vec<ElementId> = sources.iter().map(|source| source.old).collect();
        elements.sort_unstable();
        elements.dedup();
        let states = map_in_order(&elements, OLD_ELEMENTS, |old| self.state(*old));
        SourceStates { elements, states }
    }

    /// Fills the records of the new elements from number `first` on, as many as `memory` has room for; returns the rest
    /// shapes of the incompatible ones, `None` if an element has no valid one.
    fn inherit(
        &self,
        new: &NewElements<'_, D>,
        first: usize,
        memory: &mut [HistoryVariables<D>],
    ) -> Option<Vec<(ElementId, ReferenceShape<D>)>> {
        let mut references = vec![];
        let TargetMesh { position, elements, same, sources, .. } = *new.mesh;
        let begin = sources.partition_point(|source| source.new.index() < first);
        let mut sources = sources[begin..].chunk_by(|a, b| a.new == b.new).peekable();
        for (e, records) in (first..).zip(memory.chunks_mut(self.gel.records())) {
            let (element, rest) = (ElementId(e as u32), new.rests[e]);
            let present = ReferenceShape::of(position, &elements[e]);
            let own = sources.next_if(|sources| sources[0].new == element).unwrap_or_default();
            let stays = same[e].is_some_and(|same| new.stays[e] || self.past.shares[same.element.index()] == 1.0);
            let reference = match same[e] {
                Some(same) if stays => self.keep(same, 1.0, &present, records),
                Some(same) => self.take_patch_volume(same, &present, records),
                None if rest > 0.0 => self.rebase(&self.blend(own, &new.sources, rest), rest, &present, records),
                None => present,
            };
            if self.is_ring() && reference.radius <= 0.0 {
                return None;
            }
            let is_compatible = stays && same[e].is_some_and(|same| self.past.potential.is_compatible(same.element));
            if !is_compatible {
                references.push((element, reference));
            }
        }
        Some(references)
    }

    /// Returns the records of an old element.
    fn records(&self, element: ElementId) -> &[HistoryVariables<D>] {
        let n = self.gel.records();
        &self.past.memory[element.index() * n..(element.index() + 1) * n]
    }

    /// Keeps the reference of an unchanged element, of `part` of its measure, and its tensors; the whole one has been
    /// advanced to this tick.
    fn keep(
        &self,
        same: UnchangedElement,
        part: f64,
        present: &ReferenceShape<D>,
        records: &mut [HistoryVariables<D>],
    ) -> ReferenceShape<D> {
        let reference = self.past.kept_reference(same).scaled(part);
        records.copy_from_slice(self.records(same.element));
        if part == 1.0 {
            return reference;
        }
        if let Some(at) = self.deformation(&reference, present) {
            let tensors = self.spatial_tensors(&at, records);
            self.note_tick(&at, &tensors, records);
        }
        reference
    }

    /// Keeps b̄ of an unchanged element, and gives it the J of its patch; an inverted one keeps its reference.
    fn take_patch_volume(
        &self,
        same: UnchangedElement,
        present: &ReferenceShape<D>,
        records: &mut [HistoryVariables<D>],
    ) -> ReferenceShape<D> {
        let share = self.past.shares[same.element.index()];
        match self.state(same.element) {
            Some(state) => self.rebase(&state, self.past.rest(same.element) * share, present, records),
            None => self.keep(same, share, present, records),
        }
    }

    /// Mean state of the sources of a new element with this measure at rest.
    fn blend(&self, sources: &[OverlapSource], states: &SourceStates<D>, rest: f64) -> SpatialState<D> {
        // Sources created outside the gel have no mass: their average is by volume.
        let is_massive = sources.iter().any(|source| source.mass > 0.0);
        let mass = |source: &OverlapSource| if is_massive { source.mass } else { rest_of(self.past, source) };
        let of_records = |source: &OverlapSource| self.records(source.old)[0].damage;
        let whole: f64 = sources.iter().map(mass).sum();
        let damage = sources.iter().map(|source| mass(source) * of_records(source)).sum::<f64>() / whole;
        let weighted = |source: &OverlapSource| Some((rest_of(self.past, source), states.of(source.old)?));
        let upright: Vec<(f64, &SpatialState<D>)> = sources.iter().filter_map(weighted).collect();
        let strength = mean_strength(&upright);
        let mut networks = [LeftCauchyGreen::undistorted(); MOST_NETWORKS];
        for (k, network) in networks.iter_mut().enumerate().take(1 + self.gel.branches().len()) {
            let left = |damage: f64| if k == 0 { 1.0 - damage } else { 1.0 };
            if left(damage) < NEGLIGIBLE {
                continue;
            }
            let parts = upright.iter().map(|(measure, state)| WeightedElastic {
                weight: measure * left(state.damage) * state.strength,
                elastic: &state.networks[k],
            });
            let parts: Vec<_> = parts.collect();
            let stored: f64 = parts.iter().map(|part| part.weight * part.elastic.distortion()).sum();
            *network = average_elastic(&parts, stored / (rest * left(damage) * strength), self.rule);
        }
        SpatialState { networks, damage, strength }
    }

    /// Returns the state of an old element; `None` if it is inverted.
    fn state(&self, element: ElementId) -> Option<SpatialState<D>> {
        let (f, out) = self.past.potential.deformation_gradient(element, self.x);
        let det_f = det(&f);
        if !(det_f > 0.0 && out > 0.0) {
            return None;
        }
        let records = self.records(element);
        let networks = self.networks(&IsochoricDeformation::new(&array::rows(&f), out, det_f), records)?;
        let strength = self.past.potential.ratios(element).strength;
        Some(SpatialState { networks, damage: records[0].damage, strength })
    }

    /// Returns b̄ of all networks; `None` if one is not positive definite.
    fn networks(
        &self,
        at: &IsochoricDeformation<D, f64>,
        records: &[HistoryVariables<D>],
    ) -> Option<[LeftCauchyGreen<D>; MOST_NETWORKS]> {
        let mut networks = [LeftCauchyGreen::undistorted(); MOST_NETWORKS];
        let tensors = self.spatial_tensors(at, records);
        for (network, tensor) in networks.iter_mut().zip(&tensors).take(1 + self.gel.branches().len()) {
            *network = LeftCauchyGreen::of(tensor)?;
        }
        Some(networks)
    }

    /// Returns J^(−2/3) F C Fᵀ of all networks; 1 of one that stores nothing, whose rest state is free.
    fn spatial_tensors(
        &self,
        at: &IsochoricDeformation<D, f64>,
        records: &[HistoryVariables<D>],
    ) -> [SymmetricTensor<D, f64>; MOST_NETWORKS] {
        let mut tensors = [LeftCauchyGreen::undistorted().tensor; MOST_NETWORKS];
        let own = records.iter().take(1).chain(&records[self.gel.first_branch()..]);
        for (k, (tensor, record)) in tensors.iter_mut().zip(own).enumerate() {
            if k > 0 || self.gel.shear_modulus() > 0.0 && 1.0 - record.damage >= NEGLIGIBLE {
                let own = record.tensor();
                *tensor = at.elastic(&at.times_inverse_shape(&own), own.out);
            }
        }
        tensors
    }

    /// Gives an element the present shape, scaled to the measure `rest`, as its reference, with these b̄.
    fn rebase(
        &self,
        state: &SpatialState<D>,
        rest: f64,
        present: &ReferenceShape<D>,
        records: &mut [HistoryVariables<D>],
    ) -> ReferenceShape<D> {
        let reference = present.scaled(rest / present.size(self.is_ring()));
        let Some(at) = self.deformation(&reference, present) else { return reference };
        let tensors = state.networks.map(|network| network.tensor);
        let first = self.gel.first_branch();
        for (k, tensor) in tensors.iter().enumerate().take(1 + self.gel.branches().len()) {
            store(&mut records[if k == 0 { 0 } else { first + k - 1 }], &at.pull_back(tensor));
        }
        records[0].damage = state.damage;
        self.note_tick(&at, &tensors, records);
        reference
    }

    /// Notes the present deformation and stresses as those of the last tick.
    fn note_tick(
        &self,
        at: &IsochoricDeformation<D, f64>,
        tensors: &[SymmetricTensor<D, f64>; MOST_NETWORKS],
        records: &mut [HistoryVariables<D>],
    ) {
        records[0].jacobian = if D == 2 { at.det_f * at.out } else { at.det_f };
        let first = self.gel.first_branch();
        if first > 1 {
            store(&mut records[1], &IsochoricShape::now(at).inverse);
        }
        for (k, branch) in self.gel.branches().iter().enumerate() {
            let deviator = tensors[k + 1].deviator();
            records[first + k].stress = branch.shear_modulus() * (1.5 * deviator.dot(&deviator)).sqrt();
        }
    }

    /// Returns the deformation from a reference to the present shape; `None` if it is inverted.
    fn deformation(
        &self,
        reference: &ReferenceShape<D>,
        present: &ReferenceShape<D>,
    ) -> Option<IsochoricDeformation<D, f64>> {
        let whole = det(&reference.edges);
        let f = present.edges * (cofactor(&reference.edges).transpose() / whole);
        let out = if self.is_ring() { present.radius / reference.radius } else { 1.0 };
        let det_f = det(&f);
        (whole > 0.0 && det_f > 0.0 && out > 0.0).then(|| IsochoricDeformation::new(&array::rows(&f), out, det_f))
    }
}

/// Mean strength of states by these measures; 1 of a gel of one material.
fn mean_strength<const D: usize>(states: &[(f64, &SpatialState<D>)]) -> f64 {
    if states.iter().all(|(_, state)| state.strength == 1.0) {
        return 1.0;
    }
    let whole: f64 = states.iter().map(|(measure, _)| measure).sum();
    states.iter().map(|(measure, state)| measure * state.strength).sum::<f64>() / whole
}

/// Stores a tensor in a record.
fn store<const D: usize>(record: &mut HistoryVariables<D>, tensor: &SymmetricTensor<D, f64>) {
    record.inverse = Tensor::<D>::from_fn(|i, j| tensor.of(i, j));
    record.out = if D == 2 { tensor.out } else { 1.0 };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adapt::history::tests::{gel, instance};
    use crate::constitutive::Material;
    use crate::fem::Simplices;
    use crate::mesh::{BlockSpec, CellSplit, block};
    use crate::state::MeshInstance;

    /// Records of an element of `gel()`: a network stretched along x, a branch along y, and damage.
    fn records(e: usize) -> [HistoryVariables<2>; 2] {
        let stretch = |along: usize, part: f64| {
            let inverse = Tensor::<2>::from_fn(|i, j| match (i, j) {
                (0, 0) | (1, 1) => {
                    if i == along {
                        part
                    } else {
                        1.0
                    }
                }
                _ => 0.2,
            });
            let out = 1.0 / det(&inverse);
            HistoryVariables { inverse, out, ..HistoryVariables::default() }
        };
        let part = 1.5 + 0.2 * e as f64;
        [HistoryVariables { damage: 0.1 * e as f64, ..stretch(0, part) }, stretch(1, part)]
    }

    fn states(
        potential: &Simplices<2>,
        birth: &MeshInstance<2>,
        memory: &[HistoryVariables<2>],
    ) -> Vec<SpatialState<2>> {
        let (gel, x) = (gel(), &birth.position);
        let past = &SourceMesh::new(potential, birth, memory, x);
        let transfer = NetworkTransfer { gel: &gel, past, x, rule: ElasticAverage::default() };
        (0..4).map(|e| transfer.state(ElementId(e)).expect("it is upright")).collect()
    }

    #[test]
    fn elements_of_another_reference_keep_their_spatial_tensors_and_damage() {
        for section in [Section::Planar { thickness: 1.0 }, Section::Axisymmetric] {
            let planes = [vec![1.0, 2.0], vec![1.0, 2.0]];
            let mesh = block::<2>(BlockSpec { planes, split: CellSplit::Centred, faces: vec![] });
            let wave = |x: &Vector<2>| Vector::<2>::new(0.1 * x[0] * x[1], 0.2 * x[0]);
            let position: Vec<_> = mesh.rest.iter().map(|x| x + wave(x)).collect();
            let old = Simplices::in_patches(&mesh, ElementPatches::grouped(&mesh), (Material::from(gel()), section));
            let memory: Vec<_> = (0..4).flat_map(records).collect();
            let birth = instance(mesh.clone(), &position, 1.0);
            let before = states(&old, &birth, &memory);
            // Two elements are unchanged in other patches, two are new, each with one old element as source.
            let same = [Some(0), Some(1), None, None].map(|e| e.map(|e| UnchangedElement::in_order(ElementId(e))));
            let whole = |e: u32| OverlapSource { new: ElementId(e), old: ElementId(e), mass: 1.0, part: 1.0 };
            let past = SourceMesh::new(&old, &birth, &memory, &position);
            assert!(past.shares.iter().all(|share| (share - 1.0).abs() > 1e-6));
            let (rest, elements, rule) = (&mesh.rest, &mesh.elements, ElasticAverage::default());
            let new =
                TargetMesh { position: &position, rest, elements, same: &same, sources: &[whole(2), whole(3)], rule };
            let alone = ElementPatches::alone(4);
            let NetworkHistory { references, memory } =
                inherit_networks(&gel(), &past, &position, &new, &alone).expect("all rest shapes are valid");
            let transferred =
                Simplices::in_patches(&mesh, alone, (Material::from(gel()), section)).with_references(&references);
            assert_eq!(references.len(), 4);
            for (found, before) in states(&transferred, &birth, &memory).iter().zip(&before) {
                assert!((found.damage - before.damage).abs() < 1e-15);
                for (found, before) in found.networks.iter().zip(&before.networks) {
                    let off = found.tensor.combined(1.0, &before.tensor, -1.0);
                    assert!(off.dot(&off) < 1e-20 * before.tensor.dot(&before.tensor), "{section:?}");
                }
            }
        }
    }
}
