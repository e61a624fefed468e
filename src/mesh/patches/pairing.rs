//! Groups joined two by two.

use super::dual::Dual;
use std::cmp::Reverse;

/// Links that an exchange of partners may make or break: 2 n + 1 to free n pairs and wed n + 1.
const MOST_EXCHANGED: usize = 5;

/// Joins two groups.
pub(super) fn marry(mates: &mut [Option<u32>], a: u32, b: u32) {
    mates[a as usize] = Some(b);
    mates[b as usize] = Some(a);
}

/// The mate of each group, some of which are given: first the most compact unions of free neighbours, the lower groups first
/// among equals; then partners are exchanged along chains free – pair – … – pair – free as long as one leaves fewer alone.
pub(super) fn pair<const D: usize>(dual: &Dual<D>, mut mates: Vec<Option<u32>>) -> Vec<Option<u32>> {
    for (_, a, b) in candidates(dual, &mates) {
        if mates[a as usize].is_none() && mates[b as usize].is_none() {
            marry(&mut mates, a, b);
        }
    }
    for n_pairs in 1..=MOST_EXCHANGED {
        for group in 0..dual.len() as u32 {
            exchange(dual, &mut mates, group, n_pairs);
        }
    }
    mates
}

/// Pairs of free neighbours, the most compact ones first.
fn candidates<const D: usize>(dual: &Dual<D>, mates: &[Option<u32>]) -> Vec<(Reverse<u32>, u32, u32)> {
    let free = |group: u32| mates[group as usize].is_none();
    let partners = |a: u32| dual.links(a).iter().map(|link| link.to).filter(move |&b| a < b && free(b));
    let pairs = (0..dual.len() as u32).filter(|&a| free(a)).flat_map(|a| partners(a).map(move |b| (a, b)));
    let mut candidates: Vec<_> = pairs.map(|(a, b)| (Reverse(dual.compactness(&[a, b])), a, b)).collect();
    candidates.sort_unstable();
    candidates
}

/// Gives a free group a partner, by new partners for at most so many pairs.
fn exchange<const D: usize>(dual: &Dual<D>, mates: &mut [Option<u32>], group: u32, n_pairs: usize) {
    let mut chain = vec![group];
    if mates[group as usize].is_none() && extend(dual, mates, &mut chain, n_pairs) {
        for couple in chain.chunks_exact(2) {
            marry(mates, couple[0], couple[1]);
        }
    }
}

/// Whether a chain can be continued to a free group through at most so many pairs; it then is.
fn extend<const D: usize>(dual: &Dual<D>, mates: &[Option<u32>], chain: &mut Vec<u32>, n_pairs: usize) -> bool {
    let last = chain[chain.len() - 1];
    for next in dual.links(last).iter().map(|link| link.to) {
        if chain.contains(&next) {
            continue;
        }
        chain.push(next);
        match mates[next as usize] {
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
