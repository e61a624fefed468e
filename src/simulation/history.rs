//! What the elements of a new mesh were at rest: what their nodes say where that is true, else the mean of the old elements
//! that they are made of (numerics 4.6).

use crate::algebra::{Tensor, Vector, cofactor, cube_root, det};
use crate::element::{Reference, Section, Simplices};
use crate::mesh::ElementId;
use crate::remesh::{Proposal, Same, Source, Transferred};
use crate::state::Birth;

/// The inverse map is taken where the F that it gives differs from the mean by less than this part of it.
const AGREES: f64 = 0.5;
/// A ring must also be at rest within this part of what it is made of: its stretch about the axis is that of its middle, and a ring
/// that lies elsewhere in an old one has another. Without this rule a ball of 15 m/s gained 11 % of its energy by eight meshes of
/// 2.5 mm, and with finer ones the run failed; with it 2.1, 1.5 and 1.0 % are lost with 2.5, 1.25 and 0.625 mm.
const HOLDS: f64 = 0.01;

/// F of the old elements of which an element is made, and the measure that they had at rest: means by mass.
struct Mean<const D: usize> {
    f: Tensor<D>,
    out: f64,
    /// Area or volume, or area times radius of a ring, at rest.
    rest: f64,
    is_ring: bool,
}

/// The elements of a new mesh that are at rest not what their nodes say; `None` if one can be nothing.
pub(super) fn references<const D: usize>(
    (potential, old): (&Simplices<D>, &Birth<D>),
    position: &[Vector<D>],
    (proposal, new): (&Proposal<D>, &Transferred<D>),
) -> Option<Vec<(ElementId, Reference<D>)>> {
    let mut all = vec![];
    for (element, same) in (0..).map(ElementId).zip(&new.same) {
        if let Some(same) = same.filter(|same| !potential.is_compatible(same.element)) {
            all.push((element, turned(&potential.reference(same.element), &same)));
        }
    }
    let mut found = new.same.iter().flatten().count();
    for sources in new.sources.chunk_by(|a, b| a.new == b.new) {
        found += 1;
        let element = sources[0].new;
        let nodes = &proposal.elements[element.index()];
        let told = Reference::of(&new.rest, nodes);
        let now = Reference::of(&proposal.position, nodes);
        let mean = mean((potential, old), position, sources);
        let compatible = sources.iter().all(|source| potential.is_compatible(source.old));
        if !(compatible && agrees(&told, &now, &mean)) {
            all.push((element, made(&now, &mean)?));
        }
    }
    all.sort_by_key(|(element, _)| *element);
    // One that is made of nothing can be nothing.
    (found == new.same.len()).then_some(all)
}

/// The reference of an old element whose nodes may stand in another order now.
fn turned<const D: usize>(reference: &Reference<D>, same: &Same) -> Reference<D> {
    let corner = |a: usize| if a == 0 { Vector::<D>::zeros() } else { reference.edges.column(a - 1).into_owned() };
    let corners = same.turned(&[0, 1, 2, 3].map(|a| if a <= D { corner(a) } else { Vector::<D>::zeros() }));
    Reference { edges: Tensor::<D>::from_fn(|i, j| corners[j + 1][i] - corners[0][i]), ..*reference }
}

fn mean<const D: usize>((potential, old): (&Simplices<D>, &Birth<D>), x: &[Vector<D>], sources: &[Source]) -> Mean<D> {
    let is_ring = potential.section() == Section::Axisymmetric;
    let mut sum = Mean { f: Tensor::<D>::zeros(), out: 0.0, rest: 0.0, is_ring };
    let mut mass = 0.0;
    for source in sources {
        let whole: f64 = old.corner_mass[source.old.index()].iter().sum();
        let (f, out) = potential.deformation(source.old, x);
        let reference = potential.reference(source.old);
        let ring = if is_ring { reference.radius } else { 1.0 };
        sum.rest += source.mass / whole * measure(&reference.edges) * ring;
        sum.f += f * source.mass;
        sum.out += out * source.mass;
        mass += source.mass;
    }
    Mean { f: sum.f / mass, out: sum.out / mass, ..sum }
}

/// Whether the F that the nodes say is about the mean.
fn agrees<const D: usize>(told: &Reference<D>, now: &Reference<D>, mean: &Mean<D>) -> bool {
    let Some(inverse) = inverse(&told.edges) else { return false };
    let missing = measure(&told.edges) * told.radius - mean.rest;
    let holds = !mean.is_ring || missing.abs() < HOLDS * mean.rest;
    holds && (now.edges * inverse - mean.f).norm() < AGREES * mean.f.norm()
}

/// What has the mean F and the measure at rest of what it is made of, where it is now.
fn made<const D: usize>(now: &Reference<D>, mean: &Mean<D>) -> Option<Reference<D>> {
    let (radius, rest) = if mean.is_ring {
        let radius = now.radius / mean.out;
        (radius, mean.rest / radius)
    } else {
        (now.radius, mean.rest)
    };
    let scale = measure(&now.edges) / rest / det(&mean.f);
    if !(scale > 0.0 && scale.is_finite()) {
        return None;
    }
    let stretch = if D == 2 { scale.sqrt() } else { cube_root(scale) };
    let edges = inverse(&(mean.f * stretch))? * now.edges;
    let outside = !mean.is_ring || radius > 0.0;
    (outside && det(&edges) > 0.0).then_some(Reference { edges, radius })
}

/// Area or volume of the element with these edges.
fn measure<const D: usize>(edges: &Tensor<D>) -> f64 {
    det(edges) / if D == 2 { 2.0 } else { 6.0 }
}

/// The inverse of what is upright.
fn inverse<const D: usize>(a: &Tensor<D>) -> Option<Tensor<D>> {
    let det = det(a);
    (det > 0.0).then(|| cofactor(a).transpose() / det)
}
