//! What the elements of a new mesh were at rest: what their nodes say where that is true, else the mean of the old elements
//! that they are made of (numerics 4.6).

use crate::algebra::{Tensor, Vector, cofactor, cube_root, det};
use crate::element::{Reference, Section, Simplices};
use crate::mesh::ElementId;
use crate::remesh::{Proposal, Same, Source, Transferred};
use crate::state::Birth;

/// The inverse map is taken where the F that it gives differs from the mean by less than this part of it.
const AGREES: f64 = 0.5;
/// The nodes say how much matter there is if they do within this part of it.
const HOLDS: f64 = 1e-9;

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
        let told = mean.agrees(&told, &now).then_some(told);
        if !told.is_some_and(|told| mean.holds(&told)) {
            all.push((element, mean.made(&now, told.as_ref())?));
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

fn mean<const D: usize>(
    (potential, old): (&Simplices<D>, &Birth<D>),
    x: &[Vector<D>],
    sources: &[Source],
) -> Mean<D> {
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

impl<const D: usize> Mean<D> {
    /// Whether the F that the nodes say is about the mean, but for the change of volume.
    fn agrees(&self, told: &Reference<D>, now: &Reference<D>) -> bool {
        let Some(inverse) = inverse(&told.edges) else { return false };
        let f = now.edges * inverse;
        let mean = self.f * root::<D>(det(&f) / det(&self.f));
        (f - mean).norm() < AGREES * mean.norm()
    }

    /// Whether the nodes say how much matter there is.
    fn holds(&self, told: &Reference<D>) -> bool {
        (self.held_by(told) - self.rest).abs() < HOLDS * self.rest
    }

    fn held_by(&self, told: &Reference<D>) -> f64 {
        measure(&told.edges) * if self.is_ring { told.radius } else { 1.0 }
    }

    /// What has the measure at rest of what it is made of, and the F that the nodes say, or the mean, but for the change of volume.
    fn made(&self, now: &Reference<D>, told: Option<&Reference<D>>) -> Option<Reference<D>> {
        let radius = told.map_or(now.radius / self.out, |told| told.radius);
        let rest = if self.is_ring { self.rest / radius } else { self.rest };
        let edges = match told {
            Some(told) => told.edges,
            None => inverse(&self.f)? * now.edges,
        };
        let edges = edges * root::<D>(rest / measure(&edges));
        let outside = !self.is_ring || radius > 0.0;
        (outside && det(&edges) > 0.0 && edges.norm().is_finite()).then_some(Reference { edges, radius })
    }
}

/// √x in the plane, ∛x in space; what is no positive number gives none either.
fn root<const D: usize>(x: f64) -> f64 {
    if D == 2 { x.sqrt() } else { cube_root(x) }
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
