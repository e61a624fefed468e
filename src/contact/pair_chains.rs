//! Chains of pairs: pairs of clusters, linked in the chains of both.

/// End of a chain.
pub(super) const END: u32 = u32::MAX;

/// Pairs of clusters with what is known of each; a cluster may be paired with itself.
#[derive(Debug)]
pub(super) struct PairChains<T> {
    pairs: Vec<ChainedPair<T>>,
    /// First pair of the chain of each cluster.
    first: Vec<u32>,
    /// Pairs that were removed.
    unused: Vec<u32>,
}

/// Pair of clusters with the next pairs of both.
#[derive(Debug)]
struct ChainedPair<T> {
    clusters: [usize; 2],
    next: [u32; 2],
    known: T,
}

impl<T> PairChains<T> {
    /// Creates the empty chains of a number of clusters.
    pub fn new(n_clusters: usize) -> Self {
        Self { pairs: vec![], first: vec![END; n_clusters], unused: vec![] }
    }

    /// Returns the first pair of a cluster, or [`END`].
    pub fn first(&self, cluster: usize) -> u32 {
        self.first[cluster]
    }

    /// Returns the pair after one in the chain of a cluster, or [`END`].
    pub fn next(&self, pair: u32, cluster: usize) -> u32 {
        let pair = &self.pairs[pair as usize];
        pair.next[usize::from(pair.clusters[0] != cluster)]
    }

    /// Returns the clusters of a pair.
    pub fn clusters(&self, pair: u32) -> [usize; 2] {
        self.pairs[pair as usize].clusters
    }

    /// Returns what is known of a pair.
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
    pub fn add(&mut self, clusters: [usize; 2], known: T) -> u32 {
        let index = self.next_index();
        let pair = ChainedPair { clusters, next: clusters.map(|cluster| self.first[cluster]), known };
        for cluster in clusters {
            self.first[cluster] = index;
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
        let clusters = self.clusters(pair);
        self.unlink(pair, clusters[0]);
        if clusters[0] != clusters[1] {
            self.unlink(pair, clusters[1]);
        }
        self.unused.push(pair);
    }

    /// Removes a pair from the chain of a cluster.
    fn unlink(&mut self, pair: u32, cluster: usize) {
        let next = self.next(pair, cluster);
        if self.first[cluster] == pair {
            self.first[cluster] = next;
            return;
        }
        let mut before = self.first[cluster];
        while self.next(before, cluster) != pair {
            before = self.next(before, cluster);
        }
        let before = &mut self.pairs[before as usize];
        before.next[usize::from(before.clusters[0] != cluster)] = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_is_in_the_chains_of_both_clusters_until_it_is_removed() {
        let mut chains = PairChains::new(4);
        let added: Vec<u32> = [[0, 1], [1, 2], [2, 2], [3, 1]].map(|pair| chains.add(pair, ())).to_vec();
        let chain = |chains: &PairChains<()>, cluster: usize| {
            let first = Some(chains.first(cluster)).filter(|pair| *pair != END);
            let mut all: Vec<u32> =
                std::iter::successors(first, |pair| Some(chains.next(*pair, cluster)).filter(|next| *next != END))
                    .collect();
            all.sort_unstable();
            all
        };
        assert_eq!([0, 1, 2, 3].map(|of| chain(&chains, of)), [vec![0], vec![0, 1, 3], vec![1, 2], vec![3]]);
        chains.remove(added[1]);
        chains.remove(added[2]);
        assert_eq!([0, 1, 2, 3].map(|of| chain(&chains, of)), [vec![0], vec![0, 3], vec![], vec![3]]);
        let again = chains.add([2, 0], ());
        assert!(again < 4 && chain(&chains, 2) == [again] && chains.clusters(again) == [2, 0]);
    }
}
