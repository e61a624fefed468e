//! Transfer of rest shapes and history variables to a new mesh: from the nodes' rest positions where these are
//! compatible, otherwise from the source elements (method 4.6).

use super::network_transfer::{NetworkHistory, inherit_networks};
use super::patch_volume_share::stays;
use super::rest_volumes::rests;
use super::source_mesh::{SourceMesh, TargetMesh};
use super::state_averaging::{SourceStrains, StateAverage};
use crate::constitutive::Material;
use crate::fem::{HistoryVariables, Potential, ReferenceShape, Section};
use crate::math::Vector;
use crate::mesh::{ElementId, ElementPatches};

/// Rest shapes of the incompatible elements: those that differ from the shape of their nodes' rest positions.
type RestShapes<const D: usize> = Vec<(ElementId, ReferenceShape<D>)>;

/// Rest shapes of the incompatible elements of a new mesh, and the history variables of all; `None` if an element has
/// no valid rest shape.
pub(super) fn inherited<const D: usize>(
    past: &SourceMesh<'_, D>,
    position: &[Vector<D>],
    new: &TargetMesh<'_, D>,
    patches: &ElementPatches,
) -> Option<(RestShapes<D>, Vec<HistoryVariables<D>>)> {
    if let Material::TwoNetwork(gel) = &past.potential.material {
        let NetworkHistory { references, memory } = inherit_networks(gel, past, position, new, patches)?;
        return Some((references, memory));
    }
    inherited_shapes(past, position, new, patches).map(|references| (references, vec![]))
}

/// Rest shapes of the incompatible elements of a hyperelastic gel.
fn inherited_shapes<const D: usize>(
    past: &SourceMesh<'_, D>,
    position: &[Vector<D>],
    new: &TargetMesh<'_, D>,
    patches: &ElementPatches,
) -> Option<RestShapes<D>> {
    let mut all = vec![];
    let stays = stays(past.potential.patches(), patches, new.same);
    let unchanged = (0..).map(ElementId).zip(new.same).filter_map(|(element, same)| Some((element, (*same)?)));
    for (element, same) in unchanged {
        // Elements unchanged *and* in an unchanged patch keep their reference.
        let share = if stays[element.index()] { 1.0 } else { past.shares[same.element.index()] };
        if share != 1.0 || !past.potential.is_compatible(same.element) {
            all.push((element, past.kept_reference(same).scaled(share)));
        }
    }
    let strains = SourceStrains::of(past, position, new.sources);
    let rests = rests(past, position, new);
    let has_sources = |element: ElementId| rests[element.index()] > 0.0;
    for sources in new.sources.chunk_by(|a, b| a.new == b.new).filter(|sources| has_sources(sources[0].new)) {
        let (element, nodes) = (sources[0].new, &new.elements[sources[0].new.index()]);
        let [nodal, present] = [new.rest, new.position].map(|x| ReferenceShape::of(x, nodes));
        let average = StateAverage::of(past, &strains, sources, rests[element.index()]);
        if !average.is_compatible(&nodal, &present) {
            all.push((element, average.required_reference(&nodal, &present)?));
        }
    }
    // Elements without sources are at rest in their current shape.
    for (element, nodes) in
        (0..).map(ElementId).zip(new.elements).filter(|(e, _)| new.same[e.index()].is_none() && !has_sources(*e))
    {
        all.push((element, ReferenceShape::of(new.position, nodes)));
    }
    all.sort_by_key(|(element, _)| *element);
    // A ring needs a positive radius.
    let is_ring = past.potential.section() == Section::Axisymmetric;
    let is_valid = |(_, reference): &(ElementId, ReferenceShape<D>)| !is_ring || reference.radius > 0.0;
    all.iter().all(is_valid).then_some(all)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::adapt::patch_volume_share::measure;
    use crate::constitutive::{Branch, Dashpot, ElasticAverage, EquationOfState, StretchDamage, TwoNetwork};
    use crate::fem::Simplices;
    use crate::mesh::{BlockSpec, CellSplit, Mesh, block};
    use crate::remesh::{OverlapSource, UnchangedElement};
    use crate::state::MeshInstance;

    /// Two-network gel of density 1, whose elastic network may be damaged.
    pub fn gel() -> TwoNetwork {
        let branch = Branch::new(4.8, Dashpot::power_law(0.3, 0.8));
        TwoNetwork::new(0.5, &[branch], EquationOfState::new(60.0, 0.0, 20.0), 1.0)
            .with_damage(StretchDamage::new(3.0, 1e-2))
    }

    /// Mesh with these masses of all nodes and corners.
    pub fn instance<const D: usize>(mesh: Mesh<D>, position: &[Vector<D>], mass: f64) -> MeshInstance<D> {
        let (mass, corner_mass) = (vec![mass; mesh.rest.len()], vec![[mass; 4]; mesh.elements.len()]);
        let position = position.to_vec();
        let patches = ElementPatches::alone(mesh.elements.len());
        let (references, parts, steps) = (vec![], vec![], vec![]);
        MeshInstance { tick: 0, position, mass, corner_mass, references, patches, parts, steps, mesh }
    }

    #[test]
    fn an_inverted_element_keeps_its_reference() {
        let mesh =
            block::<2>(BlockSpec { planes: [[0.0, 1.0]; 2].map(Vec::from), split: CellSplit::Centred, faces: vec![] });
        let n = mesh.elements.len();
        let material = (Material::TwoNetwork(gel()), Section::Planar { thickness: 1.0 });
        let simplices = Simplices::in_patches(&mesh, ElementPatches::alone(n), material);
        let of = |e: usize| HistoryVariables { damage: 0.1 * e as f64, ..HistoryVariables::default() };
        let memory: Vec<_> = (0..n).flat_map(|e| [of(e), HistoryVariables::default()]).collect();
        // The centre node is pushed out through a side: the element there is inverted.
        let middle = Vector::<2>::new(0.5, 0.5);
        let out = Vector::<2>::new(0.5, -0.2);
        let position: Vec<_> = mesh.rest.iter().map(|x| if *x == middle { out } else { *x }).collect();
        let (elements, rest) = (mesh.elements.clone(), mesh.rest.clone());
        let birth = instance(mesh, &position, 1.0);
        let past = SourceMesh::new(&simplices, &birth, &memory, &position);
        let same: Vec<_> = (0..n as u32).map(|e| Some(UnchangedElement::in_order(ElementId(e)))).collect();
        let new = TargetMesh {
            position: &position,
            rest: &rest,
            elements: &elements,
            same: &same,
            sources: &[],
            rule: ElasticAverage::default(),
        };
        let (references, recalled) = inherited(&past, &position, &new, &ElementPatches::alone(n)).unwrap();
        let inverted: Vec<_> =
            (0..n).filter(|e| measure(&ReferenceShape::of(&position, &elements[*e]).edges) < 0.0).collect();
        assert_eq!(inverted.len(), 1);
        for (element, reference) in references {
            let e = element.index();
            let before = simplices.reference(element);
            assert_eq!(reference.edges == before.edges, inverted.contains(&e), "{e}");
            assert!(
                (measure(&reference.edges) - measure(&before.edges)).abs() < 1e-14
                    && recalled[2 * e].damage == memory[2 * e].damage
            );
        }
    }

    #[test]
    fn an_element_without_sources_rests_in_its_current_shape_without_history() {
        let solid = Material::NeoHookean(crate::constitutive::NeoHookean::new(20e3, 2e6));
        let (plane, ring) = (Section::Planar { thickness: 1.0 }, Section::Axisymmetric);
        let networks = Material::TwoNetwork(gel());
        for (section, material) in [(plane, networks), (ring, networks), (plane, solid), (ring, solid)] {
            let axis = || vec![1.0, 2.0];
            let mesh = block::<2>(BlockSpec { planes: [axis(), axis()], split: CellSplit::Centred, faces: vec![] });
            let simplices = Simplices::in_patches(&mesh, ElementPatches::alone(4), (material, section));
            let memory = vec![HistoryVariables { damage: 0.6, ..HistoryVariables::default() }; 8];
            // Stretch, shear and expansion.
            let position: Vec<_> =
                mesh.rest.iter().map(|x| Vector::<2>::new(1.1 * x[0] + 0.3 * x[1], 1.2 * x[1])).collect();
            let (elements, rest) = (mesh.elements.clone(), mesh.rest.clone());
            let birth = instance(mesh, &position, 1.0);
            let past = SourceMesh::new(&simplices, &birth, &memory, &position);
            let same = [None, Some(1), Some(2), Some(3)].map(|e| e.map(|e| UnchangedElement::in_order(ElementId(e))));
            let sources = [OverlapSource { new: ElementId(0), old: ElementId(0), mass: 0.3, part: 0.3 }];
            let new = TargetMesh {
                position: &position,
                rest: &rest,
                elements: &elements,
                same: &same,
                sources: &sources,
                rule: ElasticAverage::default(),
            };
            let (references, recalled) = inherited(&past, &position, &new, &ElementPatches::alone(4)).unwrap();
            let (_, own) = references.iter().find(|(element, _)| element.index() == 0).unwrap();
            let present = ReferenceShape::of(&position, &elements[0]);
            assert!(own.edges == present.edges && own.radius == present.radius, "{section:?}: {own:?}");
            let expected = HistoryVariables { jacobian: 1.0, ..HistoryVariables::default() };
            assert!(recalled.is_empty() || recalled[..2] == [expected; 2], "{section:?}: {:?}", recalled[0]);
        }
    }
}
