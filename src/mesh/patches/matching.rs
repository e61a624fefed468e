//! Groups joined two by two.

use super::element_graph::Dual;
use crate::mesh::ElementId;
use std::cmp::Reverse;

/// Pairs that one exchange of partners may break.
///
/// Without exchanges a fifth of the tetrahedra of Kuhn's cells stay alone (20 % of 48 000), a twentieth of a centred mesh in
/// the plane that lacks 5 % of its triangles; with 1 pair 3 % of Kuhn's are not in fours, with 2 0.8 %, with 5 0.5 %. Beyond
/// that little is left to gain (7: 0.35 %), while the chains to be tried triple with every pair in space.
const MOST_EXCHANGED: usize = 5;

/// Joins two groups.
pub(super) fn marry(mates: &mut [Option<ElementId>], a: ElementId, b: ElementId) {
    mates[a.index()] = Some(b);
    mates[b.index()] = Some(a);
}

/// The mate of each group, some of which are given: first the most compact unions of free neighbours, the lower groups first
/// among equals; then partners are exchanged along chains free – pair – … – pair – free as long as one leaves fewer alone.
pub(super) fn pair<const D: usize>(dual: &Dual<D>, mut mates: Vec<Option<ElementId>>) -> Vec<Option<ElementId>> {
    for (_, a, b) in candidates(dual, &mates) {
        if mates[a.index()].is_none() && mates[b.index()].is_none() {
            marry(&mut mates, a, b);
        }
    }
    for n_pairs in 1..=MOST_EXCHANGED {
        for group in dual.groups() {
            exchange(dual, &mut mates, group, n_pairs);
        }
    }
    mates
}

/// Pairs of free neighbours, the most compact ones first.
fn candidates<const D: usize>(
    dual: &Dual<D>,
    mates: &[Option<ElementId>],
) -> Vec<(Reverse<u32>, ElementId, ElementId)> {
    let free = |group: ElementId| mates[group.index()].is_none();
    let partners = |a: ElementId| dual.links(a).iter().map(|link| link.to).filter(move |&b| a < b && free(b));
    let pairs = dual.groups().filter(|&a| free(a)).flat_map(|a| partners(a).map(move |b| (a, b)));
    let mut candidates: Vec<_> = pairs.map(|(a, b)| (Reverse(dual.compactness(&[a, b])), a, b)).collect();
    candidates.sort_unstable();
    candidates
}

/// Gives a free group a partner, by new partners for at most so many pairs.
fn exchange<const D: usize>(dual: &Dual<D>, mates: &mut [Option<ElementId>], group: ElementId, n_pairs: usize) {
    let mut chain = vec![group];
    if mates[group.index()].is_none() && extend(dual, mates, &mut chain, n_pairs) {
        for couple in chain.chunks_exact(2) {
            marry(mates, couple[0], couple[1]);
        }
    }
}

/// Whether a chain can be continued to a free group through at most so many pairs; it then is.
fn extend<const D: usize>(
    dual: &Dual<D>,
    mates: &[Option<ElementId>],
    chain: &mut Vec<ElementId>,
    n_pairs: usize,
) -> bool {
    let last = chain[chain.len() - 1];
    for next in dual.links(last).iter().map(|link| link.to) {
        if chain.contains(&next) {
            continue;
        }
        chain.push(next);
        match mates[next.index()] {
            None => return true,
            Some(mate) if n_pairs > 0 => {
                chain.push(mate);
                if extend(dual, mates, chain, n_pairs - 1) {
                    return true;
                }
                chain.pop();
            }
            Some(_) => {}
        }
        chain.pop();
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;
    use crate::mesh::{NodeId, neighbours};

    fn dual(nodes: &[Vector<2>], elements: &[[u32; 4]]) -> Dual<2> {
        let elements: Vec<_> = elements.iter().map(|nodes| nodes.map(NodeId)).collect();
        Dual::new((nodes, &elements), &neighbours::<2>(&elements))
    }

    /// A strip of four triangles, the two in the middle a square.
    fn strip() -> Dual<2> {
        let nodes = [[-2.0, 0.5], [0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0], [3.0, 0.5]].map(Vector::<2>::from);
        dual(&nodes, &[[0, 1, 2, 0], [1, 3, 2, 0], [3, 4, 2, 0], [3, 5, 4, 0]])
    }

    #[test]
    fn the_most_compact_pair_is_taken_first() {
        let best = candidates(&strip(), &[None; 4])[0];
        assert_eq!((best.1, best.2), (ElementId(1), ElementId(2)));
    }

    #[test]
    fn a_pair_parts_if_both_then_find_a_partner() {
        assert_eq!(pair(&strip(), vec![None; 4]), [1, 0, 3, 2].map(|mate| Some(ElementId(mate))));
    }

    #[test]
    fn given_pairs_stay_and_an_odd_one_out_is_alone() {
        let given = vec![None, Some(ElementId(2)), Some(ElementId(1)), None];
        assert_eq!(candidates(&strip(), &given), []);
        let nodes = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(Vector::<2>::from);
        assert_eq!(pair(&dual(&nodes, &[[0, 1, 2, 0]]), vec![None]), [None]);
    }
}
