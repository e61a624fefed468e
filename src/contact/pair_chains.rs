//! Chains of pairs: pairs of sets, linked in the chains of both.

/// End of a chain.
pub(super) const END: u32 = u32::MAX;

/// Pairs of sets with what is known of each; a set may be paired with itself.
#[derive(Debug)]
pub(super) struct PairChains<T> {
    pairs: Vec<ChainedPair<T>>,
    /// First pair of the chain of each set.
    first: Vec<u32>,
    /// Pairs that were removed.
    unused: Vec<u32>,
}

/// Pair of sets with the next pairs of both.
#[derive(Debug)]
struct ChainedPair<T> {
    sets: [u32; 2],
    next: [u32; 2],
    known: T,
}

impl<T> PairChains<T> {
    /// Creates the empty chains of a number of sets.
    pub fn new(n_sets: usize) -> Self {
        Self { pairs: vec![], first: vec![END; n_sets], unused: vec![] }
    }

    /// Returns the first pair of a set, or [`END`].
    pub fn first(&self, set: usize) -> u32 {
        self.first[set]
    }

    /// Returns the pair after one in the chain of a set, or [`END`].
    #[inline]
    pub fn next(&self, pair: u32, set: usize) -> u32 {
        let pair = &self.pairs[pair as usize];
        pair.next[usize::from(pair.sets[0] as usize != set)]
    }

    /// Returns the sets of a pair.
    #[inline]
    pub fn sets(&self, pair: u32) -> [usize; 2] {
        let [a, b] = self.pairs[pair as usize].sets;
        [a as usize, b as usize]
    }

    /// Returns what is known of a pair.
    #[inline]
    pub fn known(&self, pair: u32) -> &T {
        &self.pairs[pair as usize].known
    }

    /// Returns what is known of a pair, to be changed.
    pub fn known_mut(&mut self, pair: u32) -> &mut T {
        &mut self.pairs[pair as usize].known
    }

    /// Returns the index that the next added pair will have.
    pub fn next_index(&self) -> u32 {
        self.unused.last().copied().unwrap_or(self.pairs.len() as u32)
    }

    /// Adds a pair; returns its index.
    pub fn add(&mut self, sets: [usize; 2], known: T) -> u32 {
        let index = self.next_index();
        let pair = ChainedPair { sets: sets.map(|set| set as u32), next: sets.map(|set| self.first[set]), known };
        for set in sets {
            self.first[set] = index;
        }
        if self.unused.pop().is_some() {
            self.pairs[index as usize] = pair;
        } else {
            self.pairs.push(pair);
        }
        index
    }

    /// Removes a pair from both chains.
    pub fn remove(&mut self, pair: u32) {
        let sets = self.sets(pair);
        self.unlink(pair, sets[0]);
        if sets[0] != sets[1] {
            self.unlink(pair, sets[1]);
        }
        self.unused.push(pair);
    }

    /// Removes a pair from the chain of a set.
    fn unlink(&mut self, pair: u32, set: usize) {
        let next = self.next(pair, set);
        if self.first[set] == pair {
            self.first[set] = next;
            return;
        }
        let mut before = self.first[set];
        while self.next(before, set) != pair {
            before = self.next(before, set);
        }
        let before = &mut self.pairs[before as usize];
        before.next[usize::from(before.sets[0] as usize != set)] = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_is_in_the_chains_of_both_sets_until_it_is_removed() {
        let mut chains = PairChains::new(4);
        let added: Vec<u32> = [[0, 1], [1, 2], [2, 2], [3, 1]].map(|pair| chains.add(pair, ())).to_vec();
        let chain = |chains: &PairChains<()>, set: usize| {
            let first = Some(chains.first(set)).filter(|pair| *pair != END);
            let mut all: Vec<u32> =
                std::iter::successors(first, |pair| Some(chains.next(*pair, set)).filter(|next| *next != END))
                    .collect();
            all.sort_unstable();
            all
        };
        assert_eq!([0, 1, 2, 3].map(|of| chain(&chains, of)), [vec![0], vec![0, 1, 3], vec![1, 2], vec![3]]);
        chains.remove(added[1]);
        chains.remove(added[2]);
        assert_eq!([0, 1, 2, 3].map(|of| chain(&chains, of)), [vec![0], vec![0, 3], vec![], vec![3]]);
        let again = chains.add([2, 0], ());
        assert!(again < 4 && chain(&chains, 2) == [again] && chains.sets(again) == [2, 0]);
    }
}
