//! A new point in the middle of an edge.

use super::edge_star::Ring;
use super::tet_mesh::{Change, Complex, Point, Tet};
use crate::math::Vector;
use crate::mesh::NodeId;
use crate::remesh::Origin;

/// Splits an edge in the middle, if all that comes is better than `enough`; at the surface where that is `cleared`, if all is
/// `good` then.
pub(super) fn split(
    complex: &mut Complex,
    (a, b): (u32, u32),
    (enough, good): (f64, f64),
    cleared: &dyn Fn(&Vector<3>) -> Vector<3>,
) -> bool {
    let Some(ring) = Ring::of(complex, a, b) else { return false };
    let Some(middle) = between(complex, (a, b), ring.is_open) else { return false };
    let m = complex.add_point(middle);
    let old: Vec<Tet> = ring.tets.iter().filter_map(|t| complex.tet(*t)).collect();
    let with = |end: u32| move |tet: &Tet| tet.map(|point| if point == end { m } else { point });
    let new: Vec<Tet> = old.iter().map(with(a)).chain(old.iter().map(with(b))).collect();
    let middle = *complex.x(m);
    let clear = if ring.is_open { complex.allowed(m, cleared(&middle)) } else { middle };
    let places = [(clear, enough.max(good)), (middle, enough)];
    for (place, enough) in places {
        complex.points[m as usize].x = place;
        if complex.worst_new(&new, enough) > enough {
            complex.cleared -= complex.growth(&new, &ring.tets);
            complex.apply(&Change { gone: ring.tets, new, ..Change::default() });
            return true;
        }
    }
    complex.drop_point();
    false
}

/// The point in the middle of an edge of the surface or inside.
fn between(complex: &Complex, (a, b): (u32, u32), is_on_surface: bool) -> Option<Point> {
    let [a, b] = [a, b].map(|point| &complex.points[point as usize]);
    let origin = if is_on_surface { blend([(&a.origin, 0.5), (&b.origin, 0.5)])? } else { Origin::Inside };
    Some(Point {
        x: (a.x + b.x) * 0.5,
        rest: (a.rest + b.rest) * 0.5,
        size: 0.5 * (a.size + b.size),
        origin,
        held: std::array::from_fn(|axis| is_on_surface && a.held[axis] && b.held[axis]),
        ends: if is_on_surface { a.ends & b.ends } else { 0 },
        is_on_surface,
    })
}

/// So much of each of two points of the old surface, if that is made of three old nodes at most.
pub(super) fn blend([a, b]: [(&Origin, f64); 2]) -> Option<Origin> {
    let (mut nodes, mut weights, mut n) = ([NodeId::default(); 3], [0.0; 3], 0);
    let of = |(origin, part): (&Origin, f64)| Some(parents(origin)?.map(|(node, weight)| (node, part * weight)));
    for (node, weight) in of(a)?.into_iter().chain(of(b)?).filter(|(_, weight)| *weight > 0.0) {
        let k = nodes[..n].iter().position(|other| *other == node).unwrap_or(n);
        *nodes.get_mut(k)? = node;
        weights[k] += weight;
        n = n.max(k + 1);
    }
    let last = nodes[n - 1];
    nodes[n..].fill(last);
    Some(Origin::Surface(nodes, weights))
}

fn parents(origin: &Origin) -> Option<[(NodeId, f64); 3]> {
    match *origin {
        Origin::Kept(node) => Some([(node, 1.0), (node, 0.0), (node, 0.0)]),
        Origin::Surface(nodes, weights) => Some(std::array::from_fn(|k| (nodes[k], weights[k]))),
        Origin::Inside => None,
    }
}
