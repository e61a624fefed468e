//! Rest measures of the elements that remeshing creates (method 4.6): area or volume, or area times radius of a
//! ring.

use super::source_mesh::{SourceMesh, TargetMesh};
use crate::constitutive::Material;
use crate::fem::{Potential, ReferenceShape, Section};
use crate::math::Vector;
use crate::mesh::{ElementId, Simplex};
use crate::remesh::{OverlapSource, UnchangedElement};

/// Greatest relative difference between the rest measure of a new element and that of its sources, at which it keeps
/// their J; the excess changes J. An element created outside the old gel has less mass than stiffness, and without
/// this limit it is thrown about.
const MOST_GROWN: f64 = 0.1;
/// Greatest relative volume correction of new elements that conserves the total rest measure; a further excess is
/// lost. Where few elements are new beside a removed loop, 10 % was a shock: a gel with K = 2000 μ gained fifteen
/// times its energy by it.
const MOST_SPREAD: f64 = 0.01;

/// Fraction of an element that must lie over sources for the sources to determine its rest shape. With less,
/// round-off once gave J = 3e30 and velocities of 1e30 m/s. An element that filled a closed gap had J = 3.3 and
/// gained 70 % of a shot's energy.
const OVER: f64 = 0.5;

/// Rest measure of each new element made of parts of old ones; 0 for elements without sources.
///
/// Every element gets the mean J of its sources. Measure that a new surface cuts off or adds is spread over all new
/// elements: the bulk modulus exceeds the shear modulus or strength by hundreds. A twentieth of an element moved from
/// one wall element to the next gave 2 MPa and 2 mJ at once. Masses cannot replace measures: the errors of their
/// redistribution would act against the bulk modulus.
///
/// `position` is where the old nodes are.
pub(super) fn rests<const D: usize>(
    past: &SourceMesh<'_, D>,
    position: &[Vector<D>],
    new: &TargetMesh<'_, D>,
) -> Vec<f64> {
    let is_ring = past.potential.section() == Section::Axisymmetric;
    let size = |x: &[Vector<D>], nodes: &Simplex| ReferenceShape::of(x, nodes).size(is_ring);
    let (mut rests, mut covered) = (vec![0.0; new.same.len()], vec![0.0; new.same.len()]);
    for source in new.sources {
        rests[source.new.index()] += rest_of(past, source);
        covered[source.new.index()] += source.part * size(position, &past.old.mesh.elements[source.old.index()]);
    }
    // A ring that the axis intersects has no meaningful measure.
    for rest in rests.iter_mut().filter(|rest| !rest.is_finite()) {
        *rest = 0.0;
    }
    let (mut of_nothing, most) = (0.0, 1.0 + most_strained(&past.potential.material));
    for (((rest, covered), nodes), same) in rests.iter_mut().zip(covered).zip(new.elements).zip(new.same) {
        let measure = size(new.position, nodes);
        if covered < OVER * measure {
            *rest = 0.0;
        }
        if *rest > 0.0 && covered > 0.0 {
            let grown = measure / covered;
            *rest *= grown.clamp(1.0 - MOST_GROWN, 1.0 + MOST_GROWN).clamp(grown / most, grown * most);
        } else if same.is_none() && *rest <= 0.0 {
            of_nothing += measure;
        }
    }
    let whole: f64 = rests.iter().sum();
    if whole > 0.0 {
        let missing = gone(past, new.same) - whole - of_nothing;
        let part = 1.0 + (missing / whole).clamp(-MOST_SPREAD, MOST_SPREAD);
        for rest in &mut rests {
            *rest *= part;
        }
    }
    rests
}

/// Greatest relative error of J: the error that stores as much energy as a shear of 1. In a gel with K = 3900 μ, an
/// element half outside the old gel had J = 1.7, and gained 70 % of a shot's energy at once. A tension limit also
/// limits the effect of such errors.
fn most_strained(material: &Material) -> f64 {
    match material {
        Material::TwoNetwork(gel) if gel.state().has_tension_limit() => f64::INFINITY,
        _ => material.shear_wave_ratio(),
    }
}

/// Total rest measure of the old elements that were removed.
fn gone<const D: usize>(past: &SourceMesh<'_, D>, same: &[Option<UnchangedElement>]) -> f64 {
    let mut is_gone = vec![true; past.potential.len()];
    same.iter().flatten().for_each(|same| is_gone[same.element.index()] = false);
    let old = (0..).map(ElementId).zip(&past.shares).zip(is_gone).filter(|(_, is_gone)| *is_gone);
    old.map(|((old, share), _)| past.rest(old) * share).sum()
}

/// Rest measure of the part of an old element in a new one. In a patch, an element contributes its measure at the J
/// of the patch.
pub(super) fn rest_of<const D: usize>(past: &SourceMesh<'_, D>, source: &OverlapSource) -> f64 {
    source.part * past.rest(source.old) * past.shares[source.old.index()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adapt::history::tests::{gel, instance};
    use crate::constitutive::{ElasticAverage, NeoHookean};
    use crate::fem::{HistoryVariables, Simplices};
    use crate::mesh::{BlockSpec, CellSplit, ElementPatches, block};
    use crate::state::MeshInstance;

    /// Deformed block with corner masses of 1, and the history variables of its elements.
    fn body(
        n: usize,
        section: Section,
        material: Material,
    ) -> (Simplices<2>, MeshInstance<2>, Vec<HistoryVariables<2>>) {
        let axis = || crate::mesh::uniform(0.0, 1.0, 1.0 / n as f64);
        let mesh = block::<2>(BlockSpec { planes: [axis(), axis()], split: CellSplit::Centred, faces: vec![] });
        let elements = mesh.elements.len();
        let patches = if n > 1 { ElementPatches::grouped(&mesh) } else { ElementPatches::alone(elements) };
        let simplices = Simplices::in_patches(&mesh, patches, (material, section));
        let position: Vec<_> = mesh.rest.iter().map(|x| x * 0.9_f64.sqrt() + wave(x) * (n as f64 - 1.0)).collect();
        (simplices, instance(mesh, &position, 1.0), vec![HistoryVariables::default(); elements * 2])
    }

    fn wave(x: &Vector<2>) -> Vector<2> {
        Vector::<2>::new((5.0 * x[1]).sin() * x[0], (7.0 * x[0]).sin()) * 2e-3
    }

    fn whole(old: u32, new: u32) -> OverlapSource {
        OverlapSource { new: ElementId(new), old: ElementId(old), mass: 1.0, part: 1.0 }
    }

    #[test]
    fn a_new_surface_keeps_pressures_equal_and_the_total_rest_measure() {
        let [soft, stiff] = [10.0, 4000.0].map(|bulk| Material::NeoHookean(NeoHookean::new(1.0, bulk)));
        for material in [Material::TwoNetwork(gel()), soft, stiff] {
            let (simplices, birth, memory) = body(1, Section::Planar { thickness: 1.0 }, material);
            let (elements, position) = (&birth.mesh.elements[..2], &birth.position);
            let same: Vec<_> = (2..4).map(|e| Some(UnchangedElement::in_order(ElementId(e)))).collect();
            let same = [vec![None; 2], same].concat();
            let past = SourceMesh::new(&simplices, &birth, &memory, position);
            let tip = elements[0][..3].iter().find(|node| !elements[1][..3].contains(node)).unwrap().index();
            let others = elements[0][..3].iter().filter(|node| node.index() != tip);
            let foot = others.map(|node| position[node.index()] * 0.5).sum::<Vector<2>>();
            for pulled in [0.0, 0.01, -0.01, 0.05, -0.05, 0.3, 0.8] {
                let mut now = position.clone();
                now[tip] += (position[tip] - foot) * pulled;
                let (rest, sources) = (&birth.mesh.rest, [whole(0, 0), whole(1, 1)]);
                let elements = &birth.mesh.elements;
                let new = TargetMesh {
                    position: &now,
                    rest,
                    elements,
                    same: &same,
                    sources: &sources,
                    rule: ElasticAverage::default(),
                };
                let rests = rests(&past, position, &new);
                let [first, second] = [0, 1].map(|e| ReferenceShape::of(&now, &elements[e]).size(false) / rests[e]);
                // Limits of growth and of strain, and of the spread correction.
                let most = 1.0 + most_strained(&material);
                let grown = (1.0 + pulled.clamp(-MOST_GROWN, MOST_GROWN)).max((1.0 + pulled) / most);
                let apart = (1.0 + pulled) / grown;
                assert!((first / second - apart).abs() < 1e-13, "{pulled}: J {first} beside {second}");
                assert!(apart <= most + 1e-14, "{pulled}: J {first} beside {second}");
                let whole = 0.25 + 0.25 * grown;
                let spread = (0.5 / whole).clamp(1.0 - MOST_SPREAD, 1.0 + MOST_SPREAD);
                assert!((rests[0] + rests[1] - whole * spread).abs() < 1e-13, "{pulled}: {rests:?}");
                assert!(pulled != 0.0 || (first - 0.9).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn an_element_less_than_half_over_the_gel_has_no_sources() {
        let (simplices, birth, memory) = body(1, Section::Planar { thickness: 1.0 }, Material::TwoNetwork(gel()));
        let (position, rest) = (&birth.position, &birth.mesh.rest);
        let elements = &birth.mesh.elements[..2];
        let past = SourceMesh::new(&simplices, &birth, &memory, position);
        let of = |part: f64| {
            let sources = [OverlapSource { part, ..whole(0, 0) }, whole(1, 1)];
            let new = TargetMesh {
                position,
                rest,
                elements,
                same: &[None; 2],
                sources: &sources,
                rule: ElasticAverage::default(),
            };
            rests(&past, position, &new)[0]
        };
        assert_eq!([1e-14, 0.4].map(of), [0.0; 2]);
        assert!(of(0.6) > 0.0);
    }

    /// Removes one element, adds one without sources, and replaces half of the others; some patches stay in part.
    #[test]
    fn remeshing_conserves_the_total_rest_measure() {
        let plane = Section::Planar { thickness: 1.0 };
        let solid = Material::NeoHookean(NeoHookean::new(20e3, 2e6));
        let networks = Material::TwoNetwork(gel());
        for (section, material) in [(plane, networks), (Section::Axisymmetric, networks), (plane, solid)] {
            let (simplices, birth, memory) = body(6, section, material);
            let position = &birth.position;
            let past = SourceMesh::new(&simplices, &birth, &memory, position);
            let (n, is_ring) = (birth.mesh.elements.len() as u32, section == Section::Axisymmetric);
            // Element 0 is removed, and the second one is duplicated without sources.
            let old: Vec<u32> = (1..n).chain([1]).collect();
            let elements: Vec<_> = old.iter().map(|e| birth.mesh.elements[*e as usize]).collect();
            let stays = |e: u32| e % 7 > 3;
            let again = |e: &u32| stays(*e).then_some(UnchangedElement::in_order(ElementId(*e)));
            let same: Vec<_> = old[..old.len() - 1].iter().map(again).chain([None]).collect();
            let sources: Vec<_> = (1..n).filter(|e| !stays(*e)).map(|e| whole(e, e - 1)).collect();
            let rest = &birth.mesh.rest;
            let new = TargetMesh {
                position,
                rest,
                elements: &elements,
                same: &same,
                sources: &sources,
                rule: ElasticAverage::default(),
            };
            let made: f64 = rests(&past, position, &new).iter().sum();
            let handed = |e: u32| past.rest(ElementId(e)) * past.shares[e as usize];
            let kept: f64 = (1..n).filter(|e| stays(*e)).map(handed).sum();
            let of_nothing = ReferenceShape::of(position, &elements[elements.len() - 1]).size(is_ring);
            let before: f64 = (0..n).map(|e| past.rest(ElementId(e))).sum();
            let after = made + kept + of_nothing;
            assert!((after / before - 1.0).abs() < 1e-13, "{section:?}: {before} {after}");
            assert!(past.shares.iter().any(|share| (share - 1.0).abs() > 1e-5));
        }
    }
}
