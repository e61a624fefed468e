//! What the elements of a new mesh were at rest: what their nodes say where that is true, else the mean of the old elements
//! that they are made of (numerics 4.6).

use crate::algebra::{Tensor, Vector, det};
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
struct Mean {
    f: Tensor<2>,
    out: f64,
    /// Area, or area times radius of a ring, at rest.
    rest: f64,
    is_ring: bool,
}

/// The elements of a new mesh that are at rest not what their nodes say; `None` if one can be nothing.
pub(super) fn references(
    (potential, old): (&Simplices<2>, &Birth<2>),
    position: &[Vector<2>],
    (proposal, new): (&Proposal<2>, &Transferred<2>),
) -> Option<Vec<(ElementId, Reference<2>)>> {
    let mut all = vec![];
    for (element, same) in (0..).map(ElementId).zip(&new.same) {
        if let Some(same) = same.filter(|same| !potential.is_compatible(same.element)) {
            all.push((element, turned(&potential.reference(same.element), same)));
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
fn turned(reference: &Reference<2>, same: Same) -> Reference<2> {
    let none = Vector::<2>::zeros();
    let [a, b, c, _] = same.turned(&[none, reference.edges.column(0).into(), reference.edges.column(1).into(), none]);
    Reference { edges: Tensor::<2>::from_columns(&[b - a, c - a]), ..*reference }
}

fn mean((potential, old): (&Simplices<2>, &Birth<2>), x: &[Vector<2>], sources: &[Source]) -> Mean {
    let is_ring = potential.section() == Section::Axisymmetric;
    let mut sum = Mean { f: Tensor::<2>::zeros(), out: 0.0, rest: 0.0, is_ring };
    let mut mass = 0.0;
    for source in sources {
        let whole: f64 = old.corner_mass[source.old.index()].iter().sum();
        let (f, out) = potential.deformation(source.old, x);
        let reference = potential.reference(source.old);
        let ring = if is_ring { reference.radius } else { 1.0 };
        sum.rest += source.mass / whole * 0.5 * det(&reference.edges) * ring;
        sum.f += f * source.mass;
        sum.out += out * source.mass;
        mass += source.mass;
    }
    Mean { f: sum.f / mass, out: sum.out / mass, ..sum }
}

/// Whether the F that the nodes say is about the mean.
fn agrees(told: &Reference<2>, now: &Reference<2>, mean: &Mean) -> bool {
    let inverse = told.edges.try_inverse().filter(|_| det(&told.edges) > 0.0);
    let Some(inverse) = inverse else { return false };
    let missing = 0.5 * det(&told.edges) * told.radius - mean.rest;
    let holds = !mean.is_ring || missing.abs() < HOLDS * mean.rest;
    holds && (now.edges * inverse - mean.f).norm() < AGREES * mean.f.norm()
}

/// What has the mean F and the measure at rest of what it is made of, where it is now.
fn made(now: &Reference<2>, mean: &Mean) -> Option<Reference<2>> {
    let (radius, area) = if mean.is_ring {
        let radius = now.radius / mean.out;
        (radius, mean.rest / radius)
    } else {
        (now.radius, mean.rest)
    };
    let inner = 0.5 * det(&now.edges) / area;
    let scale = inner / det(&mean.f);
    if !(scale > 0.0 && scale.is_finite()) {
        return None;
    }
    let f = mean.f * scale.sqrt();
    let edges = f.try_inverse()? * now.edges;
    let outside = !mean.is_ring || radius > 0.0;
    (outside && det(&edges) > 0.0).then_some(Reference { edges, radius })
}
