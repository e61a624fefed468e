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
        } else if same.is_none() {
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
    let old = (0..).map(ElementId).zip(&is_gone).filter(|(_, is_gone)| **is_gone);
    old.map(|(old, _)| past.rest(old) * past.shares.get(old.index()).unwrap_or(&1.0)).sum()
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

    /// The measures at rest of the first two of four triangles of a gel that flows, squeezed in all by a tenth, and what they are now, when
    /// both are made anew, the third one stays and the fourth is cut off or stays: by how much the tip of the first one is pulled out beyond the gel.
    fn made(pulled: f64, cut: bool) -> ([f64; 2], [f64; 2]) {
        let planes = [[0.0, 1.0]; 2].map(Vec::from);
        let mesh = block::<2>(Block { planes, split: Split::Centred, faces: vec![] });
        let (n, patches) = (mesh.elements.len(), Patches::alone(mesh.elements.len()));
        let material = (Material::Flowing(gel()), Section::Planar { thickness: 1.0 });
        let simplices = Simplices::in_patches(&mesh, patches, material);
        let position: Vec<_> = mesh.rest.iter().map(|x| x * 0.9_f64.sqrt()).collect();
        let (mass, memory) = (vec![1.0; position.len()], vec![Memory::default(); n]);
        let (mut elements, rest) = (mesh.elements.clone(), mesh.rest.clone());
        let birth = Birth {
            tick: 0,
            mesh,
            position: position.clone(),
            mass,
            corner_mass: vec![[1.0; 4]; n],
            references: vec![],
        };
        let past = Past::new((&simplices, &birth, &memory), &position);
        let source = |at: u32| Source { new: ElementId(at), old: ElementId(at), mass: 1.0, part: 1.0 };
        let sources = [source(0), source(1)];
        let again = |e: u32| Some(Same { element: ElementId(e), corners: [0, 1, 2, 3] });
        let same = [None, None, again(2), again(3)];
        let left = if cut { 3 } else { 4 };
        elements.truncate(left);
        let mut now = position.clone();
        let own = |node: &&crate::mesh::NodeId| !elements[1][..3].contains(node);
        let tip = elements[0][..3].iter().find(own).unwrap().index();
        let others = elements[0][..3].iter().filter(|node| node.index() != tip);
        let foot = others.map(|node| position[node.index()] * 0.5).sum::<Vector<2>>();
        now[tip] += (position[tip] - foot) * pulled;
        let (elements, same) = (elements.as_slice(), &same[..left]);
        let new = Made { position: &now, rest: &rest, elements, same, sources: &sources, laid: &[] };
        let rests = rests(&past, &position, &new);
        let sizes = [0, 1].map(|e| Reference::of(&now, &elements[e]).size(false));
        ([rests[0], rests[1]], sizes)
    }

    #[test]
    fn pressures_stay_alike_and_the_measure_in_all_what_it_was_where_a_surface_is_made_anew() {
        let quarter = 0.25;
        for (pulled, cut) in [(0.0, false), (0.05, false), (-0.04, false)] {
            let (rests, sizes) = made(pulled, cut);
            let [first, second] = [0, 1].map(|e| sizes[e] / rests[e]);
            assert!((first / second - 1.0).abs() < 1e-13, "{pulled}, {cut}: J {first} beside {second}");
            assert!((rests[0] + rests[1] - 2.0 * quarter).abs() < 1e-13, "{pulled}, {cut}: {rests:?}");
        }
        assert!((made(0.0, false).1[0] / made(0.0, false).0[0] - 0.9).abs() < 1e-14);
        // What is cut off goes to what is made anew, as far as that can take it.
        let (rests, _) = made(0.0, true);
        for rest in rests {
            assert!((rest - quarter * (1.0 + MOST_LAID)).abs() < 1e-14, "{rests:?}");
        }
    }
}
