//! Transfer of rest shapes and history variables to a new mesh: from the nodes' rest positions where these are
//! compatible, otherwise from the source elements (numerics 4.6).

use super::patch_volume_share::stays;
use super::rest_volumes::rests;
use super::source_mesh::{SourceMesh, TargetMesh};
use super::state_averaging::{SourceStrains, StateAverage};
use crate::fem::{HistoryVariables, Potential, ReferenceShape, Section};
use crate::math::{Tensor, Vector, det};
use crate::mesh::{ElementId, ElementPatches};
use crate::remesh::UnchangedElement;

/// Rest shapes of the new elements whose nodes' rest positions do not give them.
type RestShapes<const D: usize> = Vec<(ElementId, ReferenceShape<D>)>;

/// Rest shapes of the incompatible elements of a new mesh, and the history variables of all; `None` if an element has
/// no valid rest shape.
///
/// In a viscoplastic gel nodal rest positions do not give an element's rest shape. Each new element gets the mean
/// elastic strain of its sources, and the amount of their plastic strain, but not its direction.
pub(super) fn inherited<const D: usize>(
    past: &SourceMesh<'_, D>,
    position: &[Vector<D>],
    new: &TargetMesh<'_, D>,
    patches: &ElementPatches,
) -> Option<(RestShapes<D>, Vec<HistoryVariables<D>>)> {
    let flows = past.potential.remembers();
    let mut memory = vec![HistoryVariables::default(); if flows { new.elements.len() } else { 0 }];
    let mut all = vec![];
    let stays = stays(past.potential.patches(), patches, new.same);
    let again = (0..).map(ElementId).zip(new.same).filter_map(|(element, same)| Some((element, (*same)?)));
    for (element, same) in again {
        // Elements unchanged *and* in an unchanged patch keep their reference. Exception: in a viscoplastic gel in the
        // plane every element takes the J of its patch at a remeshing, because its shots are calibrated that way.
        let goes_on = stays[element.index()] && (new.is_kept || !(D == 2 && flows));
        let share = if goes_on { 1.0 } else { past.shares[same.element.index()] };
        if flows {
            let now = ReferenceShape::of(new.position, &new.elements[element.index()]);
            let made = if goes_on { None } else { StateAverage::alone(past, position, same.element).again(&now) };
            // Elements that keep their reference, and inverted ones, which have no average.
            let as_it_is = || (turned(&past.potential.reference(same.element), same).scaled(share), past.memory(same));
            let (reference, recalled) = made.unwrap_or_else(as_it_is);
            all.push((element, reference));
            memory[element.index()] = recalled;
            continue;
        }
        if share != 1.0 || !past.potential.is_compatible(same.element) {
            all.push((element, turned(&past.potential.reference(same.element), same).scaled(share)));
        }
    }
    let strains = SourceStrains::of(past, position, new.sources);
    let rests = rests(past, position, new);
    let is_there = |element: ElementId| rests[element.index()] > 0.0;
    for sources in new.sources.chunk_by(|a, b| a.new == b.new).filter(|sources| is_there(sources[0].new)) {
        let (element, nodes) = (sources[0].new, &new.elements[sources[0].new.index()]);
        let [told, now] = [new.rest, new.position].map(|x| ReferenceShape::of(x, nodes));
        let mean = StateAverage::of(past, position, &strains, sources, rests[element.index()]);
        if !mean.is_told(&told, &now) {
            all.push((element, mean.made(&told, &now)?));
        }
        if flows {
            memory[element.index()] = mean.recalled();
        }
    }
    // Elements without sources are at rest in their current shape.
    for (element, nodes) in
        (0..).map(ElementId).zip(new.elements).filter(|(e, _)| new.same[e.index()].is_none() && !is_there(*e))
    {
        all.push((element, ReferenceShape::of(new.position, nodes)));
    }
    all.sort_by_key(|(element, _)| *element);
    let is_ring = past.potential.section() == Section::Axisymmetric;
    for ((element, reference), memory) in all.iter().zip(&mut memory) {
        let now = ReferenceShape::of(new.position, &new.elements[element.index()]);
        memory.jacobian = volume_ratio(reference, &now, is_ring);
    }
    // A ring needs a positive radius.
    let stands = |(_, reference): &(ElementId, ReferenceShape<D>)| !is_ring || reference.radius > 0.0;
    all.iter().all(stands).then_some((all, memory))
}

/// Volume ratio J of an element with this reference in its current shape.
fn volume_ratio<const D: usize>(reference: &ReferenceShape<D>, now: &ReferenceShape<D>, is_ring: bool) -> f64 {
    let out = if is_ring { now.radius / reference.radius } else { 1.0 };
    det(&now.edges) / det(&reference.edges) * out
}

/// Reference of an old element whose nodes may be permuted now.
fn turned<const D: usize>(reference: &ReferenceShape<D>, same: UnchangedElement) -> ReferenceShape<D> {
    if same == UnchangedElement::in_order(same.element) {
        return *reference;
    }
    let corner = |a: usize| if a == 0 { Vector::<D>::zeros() } else { reference.edges.column(a - 1).into_owned() };
    let corners = same.turned(&[0, 1, 2, 3].map(|a| if a <= D { corner(a) } else { Vector::<D>::zeros() }));
    ReferenceShape { edges: Tensor::<D>::from_fn(|i, j| corners[j + 1][i] - corners[0][i]), ..*reference }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::adapt::patch_volume_share::measure;
    use crate::constitutive::{BulkViscosity, EquationOfState, Material, Viscoplastic, YieldLaw};
    use crate::fem::Simplices;
    use crate::mesh::{BlockSpec, CellSplit, Mesh, block};
    use crate::remesh::OverlapSource;
    use crate::state::MeshInstance;

    /// Viscoplastic gel of density 1.
    pub fn gel() -> Viscoplastic {
        Viscoplastic {
            shear_modulus: 4.8,
            state: EquationOfState::new(60.0, 0.0, 20.0),
            strength: Some(YieldLaw::new(0.3, 0.2, 1.6)),
            softening: None,
            viscosity: BulkViscosity { linear: 0.1, quadratic: 1.0 },
            density: 1.0,
        }
    }

    /// Mesh with these masses of all nodes and corners.
    pub fn instance<const D: usize>(mesh: Mesh<D>, position: &[Vector<D>], mass: f64) -> MeshInstance<D> {
        let (mass, corner_mass) = (vec![mass; mesh.rest.len()], vec![[mass; 4]; mesh.elements.len()]);
        let position = position.to_vec();
        MeshInstance { tick: 0, position, mass, corner_mass, references: vec![], steps: vec![], mesh }
    }

    #[test]
    fn an_inverted_element_keeps_its_reference() {
        let mesh =
            block::<2>(BlockSpec { planes: [[0.0, 1.0]; 2].map(Vec::from), split: CellSplit::Centred, faces: vec![] });
        let n = mesh.elements.len();
        let material = (Material::Flowing(gel()), Section::Planar { thickness: 1.0 });
        let simplices = Simplices::in_patches(&mesh, ElementPatches::alone(n), material);
        let memory: Vec<_> = (0..n)
            .map(|e| HistoryVariables { plastic: e as f64, jacobian: 1.0, ..HistoryVariables::default() })
            .collect();
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
            is_kept: false,
        };
        let (references, recalled) = inherited(&past, &position, &new, &ElementPatches::alone(n)).unwrap();
        let turned: Vec<_> =
            (0..n).filter(|e| measure(&ReferenceShape::of(&position, &elements[*e]).edges) < 0.0).collect();
        assert_eq!(turned.len(), 1);
        for (element, reference) in references {
            let e = element.index();
            let was = simplices.reference(element);
            assert_eq!(reference.edges == was.edges, turned.contains(&e), "{e}");
            assert!(
                (measure(&reference.edges) - measure(&was.edges)).abs() < 1e-14
                    && recalled[e].plastic == memory[e].plastic
            );
        }
    }

    #[test]
    fn an_element_without_sources_rests_in_its_current_shape_without_history() {
        let solid = Material::NeoHookean(crate::constitutive::NeoHookean::new(20e3, 2e6));
        let (plane, ring) = (Section::Planar { thickness: 1.0 }, Section::Axisymmetric);
        let flowing = Material::Flowing(gel());
        for (section, material) in [(plane, flowing), (ring, flowing), (plane, solid), (ring, solid)] {
            let axis = || vec![1.0, 2.0];
            let mesh = block::<2>(BlockSpec { planes: [axis(), axis()], split: CellSplit::Centred, faces: vec![] });
            let simplices = Simplices::in_patches(&mesh, ElementPatches::alone(4), (material, section));
            let memory =
                vec![HistoryVariables { plastic: 0.7, left: 0.4, felt: -3.0, ..HistoryVariables::default() }; 4];
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
                is_kept: false,
            };
            let (references, recalled) = inherited(&past, &position, &new, &ElementPatches::alone(4)).unwrap();
            let (_, own) = references.iter().find(|(element, _)| element.index() == 0).unwrap();
            let now = ReferenceShape::of(&position, &elements[0]);
            assert!(own.edges == now.edges && own.radius == now.radius, "{section:?}: {own:?}");
            let expected = HistoryVariables { jacobian: 1.0, ..HistoryVariables::default() };
            assert!(recalled.is_empty() || recalled[0] == expected, "{section:?}: {:?}", recalled[0]);
        }
    }
}
