//! What the elements that an exchange makes measure at rest (numerics 4.6): area or volume, or area times radius of a ring.

use super::history::{Made, Past};
use crate::algebra::Vector;
use crate::element::{Potential, Reference, Section};
use crate::mesh::Simplex;
use crate::remesh::Source;

/// The part of its measure at rest that an element can be given at once of what no new one lies over; the rest is lost.
const MOST_LAID: f64 = 0.1;

/// By new element, its measure at rest, of those that are made of parts of old ones; nothing of the others.
///
/// `position` is where the old nodes are.
pub(super) fn rests<const D: usize>(past: &Past<'_, D>, position: &[Vector<D>], new: &Made<'_, D>) -> Vec<f64> {
    let mut rests = vec![0.0; new.same.len()];
    new.sources.iter().for_each(|source| rests[source.new.index()] += rest_of(past, source));
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
    laid.iter().for_each(|source| more[source.new.index()] += rest_of(past, source));
    for (rest, more) in rests.iter_mut().zip(more) {
        let most = MOST_LAID * rest.abs();
        *rest += more.clamp(-most, most);
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
    let mut missing: f64 = new.laid.iter().map(|source| rest_of(past, source)).sum();
    for ((rest, covered), nodes) in rests.iter_mut().zip(covered).zip(new.elements) {
        if *rest > 0.0 && covered > 0.0 {
            let grown = size(new.position, nodes) / covered;
            let kept = *rest * grown.clamp(1.0 - MOST_LAID, 1.0 + MOST_LAID);
            missing -= kept - std::mem::replace(rest, kept);
        }
    }
    let whole: f64 = rests.iter().sum();
    if whole > 0.0 {
        let part = 1.0 + (missing / whole).clamp(-MOST_LAID, MOST_LAID);
        rests.iter_mut().for_each(|rest| *rest *= part);
    }
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
