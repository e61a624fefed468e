//! What the elements that an exchange makes measure at rest (numerics 4.6): area or volume, or area times radius of a ring.

use super::history::{Made, Past};
use crate::algebra::Vector;
use crate::element::{Potential, Reference, Section};
use crate::mesh::{ElementId, Simplex};
use crate::remesh::{Same, Source};

/// The part of its measure at rest by which that of an element can change at once, by what no new one lies over, by what no old one
/// lies under, or by its share of both: what goes beyond is lost, and J is not kept then.
const MOST_LAID: f64 = 0.1;

/// By new element, its measure at rest, of those that are made of parts of old ones; nothing of the others.
///
/// `position` is where the old nodes are.
pub(super) fn rests<const D: usize>(past: &Past<'_, D>, position: &[Vector<D>], new: &Made<'_, D>) -> Vec<f64> {
    let mut rests = vec![0.0; new.same.len()];
    for source in new.sources {
        rests[source.new.index()] += rest_of(past, source);
    }
    if past.potential.remembers() {
        keep_pressures(&mut rests, past, position, new);
    } else {
        lay(&mut rests, past, new.laid);
    }
    rests
}

/// Lays what no new element lies over on the nearest one, of which it takes a tenth more at most: what is cut off a neighbourhood
/// compresses it.
fn lay<const D: usize>(rests: &mut [f64], past: &Past<'_, D>, laid: &[Source]) {
    let mut more = vec![0.0; rests.len()];
    for source in laid {
        more[source.new.index()] += rest_of(past, source);
    }
    for (rest, more) in rests.iter_mut().zip(more) {
        let most = MOST_LAID * rest.abs();
        // Not `clamp`, which panics where the bounds are no numbers.
        *rest += more.max(-most).min(most);
    }
}

/// Gives every element the mean J of the gel under it, though a new surface cuts gel off or goes around what is none, and what that
/// takes in all to all of them.
///
/// In gel that flows the bulk modulus is a thousand times the strength: a twentieth cut off one element of a wall, laid on the next
/// one, was 2 MPa there, and 2 mJ at once that bulk viscosity had to take.
fn keep_pressures<const D: usize>(rests: &mut [f64], past: &Past<'_, D>, position: &[Vector<D>], new: &Made<'_, D>) {
    let is_ring = past.potential.section() == Section::Axisymmetric;
    let size = |x: &[Vector<D>], nodes: &Simplex| Reference::of(x, nodes).size(is_ring);
    let mut covered = vec![0.0; rests.len()];
    for source in new.sources {
        covered[source.new.index()] += source.part * size(position, &past.old.mesh.elements[source.old.index()]);
    }
    let mut of_nothing = 0.0;
    for (((rest, covered), nodes), same) in rests.iter_mut().zip(covered).zip(new.elements).zip(new.same) {
        if *rest > 0.0 && covered > 0.0 {
            let grown = size(new.position, nodes) / covered;
            *rest *= grown.clamp(1.0 - MOST_LAID, 1.0 + MOST_LAID);
        } else if same.is_none() && *rest <= 0.0 {
            of_nothing += size(new.position, nodes);
        }
    }
    let whole: f64 = rests.iter().sum();
    if whole > 0.0 {
        let missing = gone(past, new.same) - whole - of_nothing;
        let part = 1.0 + (missing / whole).clamp(-MOST_LAID, MOST_LAID);
        for rest in rests {
            *rest *= part;
        }
    }
}

/// What the old elements that are gone were at rest, in all.
fn gone<const D: usize>(past: &Past<'_, D>, same: &[Option<Same>]) -> f64 {
    let mut is_gone = vec![true; past.potential.len()];
    same.iter().flatten().for_each(|same| is_gone[same.element.index()] = false);
    let old = (0..).map(ElementId).zip(&past.shares).zip(is_gone).filter(|(_, is_gone)| *is_gone);
    old.map(|((old, share), _)| past.rest(old) * share).sum()
}

/// The part of an old element at rest that is in a new one. Where pressure is that of a patch, its elements hand on what they would
/// be at rest with the J of the patch, and by volume: their own, and masses that were laid out anew, would come back as noise in
/// the pressure of new patches, K times what they are off.
pub(super) fn rest_of<const D: usize>(past: &Past<'_, D>, source: &Source) -> f64 {
    if let Some(share) = past.shares.get(source.old.index()) {
        return source.part * past.rest(source.old) * share;
    }
    let whole: f64 = past.old.corner_mass[source.old.index()].iter().sum();
    source.mass / whole * past.rest(source.old)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::{Memory, Simplices};
    use crate::material::Material;
    use crate::mesh::{Block, Patches, Split, block};
    use crate::simulation::history::tests::gel;
    use crate::state::Birth;

    /// A block of a gel that flows, of parts of 1, and memories of its elements.
    fn flowing(n: usize, section: Section) -> (Simplices<2>, Birth<2>, Vec<Memory<2>>) {
        let axis = || crate::mesh::uniform(0.0, 1.0, 1.0 / n as f64);
        let mesh = block::<2>(Block { planes: [axis(), axis()], split: Split::Centred, faces: vec![] });
        let (nodes, elements) = (mesh.rest.len(), mesh.elements.len());
        let patches = if n > 1 { Patches::grouped(&mesh) } else { Patches::alone(elements) };
        let simplices = Simplices::in_patches(&mesh, patches, (Material::Flowing(gel()), section));
        let position = mesh.rest.iter().map(|x| x * 0.9_f64.sqrt() + wave(x) * (n as f64 - 1.0)).collect();
        let (mass, corner_mass) = (vec![1.0; nodes], vec![[1.0; 4]; elements]);
        let birth = Birth { tick: 0, mesh, position, mass, corner_mass, references: vec![] };
        (simplices, birth, vec![Memory::default(); elements])
    }

    fn wave(x: &Vector<2>) -> Vector<2> {
        Vector::<2>::new((5.0 * x[1]).sin() * x[0], (7.0 * x[0]).sin()) * 2e-3
    }

    fn whole(old: u32, new: u32) -> Source {
        Source { new: ElementId(new), old: ElementId(old), mass: 1.0, part: 1.0 }
    }

    #[test]
    fn pressures_stay_alike_and_the_measure_in_all_what_it_was_where_a_surface_is_made_anew() {
        let (simplices, birth, memory) = flowing(1, Section::Planar { thickness: 1.0 });
        let (elements, position) = (&birth.mesh.elements[..2], &birth.position);
        let same: Vec<_> = (2..4).map(|e| Some(Same { element: ElementId(e), corners: [0, 1, 2, 3] })).collect();
        let same = [vec![None; 2], same].concat();
        let past = Past::new((&simplices, &birth, &memory), position);
        let tip = elements[0][..3].iter().find(|node| !elements[1][..3].contains(node)).unwrap().index();
        let others = elements[0][..3].iter().filter(|node| node.index() != tip);
        let foot = others.map(|node| position[node.index()] * 0.5).sum::<Vector<2>>();
        for pulled in [0.0, 0.05, -0.04] {
            let mut now = position.clone();
            now[tip] += (position[tip] - foot) * pulled;
            let (rest, sources) = (&birth.mesh.rest, [whole(0, 0), whole(1, 1)]);
            let elements = &birth.mesh.elements;
            let new = Made { position: &now, rest, elements, same: &same, sources: &sources, laid: &[] };
            let rests = rests(&past, position, &new);
            let [first, second] = [0, 1].map(|e| Reference::of(&now, &elements[e]).size(false) / rests[e]);
            assert!((first / second - 1.0).abs() < 1e-13, "{pulled}: J {first} beside {second}");
            assert!((rests[0] + rests[1] - 0.5).abs() < 1e-13, "{pulled}: {rests:?}");
            assert!(pulled != 0.0 || (first - 0.9).abs() < 1e-14);
        }
    }

    /// One element is cut off, one is made of nothing, half of the others are made anew, some of whose patches stay in part.
    #[test]
    fn an_exchange_keeps_the_measure_at_rest_of_what_flows() {
        for section in [Section::Planar { thickness: 1.0 }, Section::Axisymmetric] {
            let (simplices, birth, memory) = flowing(6, section);
            let position = &birth.position;
            let past = Past::new((&simplices, &birth, &memory), position);
            let (n, is_ring) = (birth.mesh.elements.len() as u32, section == Section::Axisymmetric);
            // The element 0 is gone, and the second one is there once more, of nothing.
            let old: Vec<u32> = (1..n).chain([1]).collect();
            let elements: Vec<_> = old.iter().map(|e| birth.mesh.elements[*e as usize]).collect();
            let stays = |e: u32| e % 7 > 3;
            let again = |e: &u32| stays(*e).then_some(Same { element: ElementId(*e), corners: [0, 1, 2, 3] });
            let same: Vec<_> = old[..old.len() - 1].iter().map(again).chain([None]).collect();
            let sources: Vec<_> = (1..n).filter(|e| !stays(*e)).map(|e| whole(e, e - 1)).collect();
            let rest = &birth.mesh.rest;
            let new = Made { position, rest, elements: &elements, same: &same, sources: &sources, laid: &[] };
            let made: f64 = rests(&past, position, &new).iter().sum();
            let handed = |e: u32| past.rest(ElementId(e)) * past.shares[e as usize];
            let kept: f64 = (1..n).filter(|e| stays(*e)).map(handed).sum();
            let of_nothing = Reference::of(position, &elements[elements.len() - 1]).size(is_ring);
            let before: f64 = (0..n).map(|e| past.rest(ElementId(e))).sum();
            let after = made + kept + of_nothing;
            assert!((after / before - 1.0).abs() < 1e-13, "{section:?}: {before} {after}");
            assert!(past.shares.iter().any(|share| (share - 1.0).abs() > 1e-5));
        }
    }
}
