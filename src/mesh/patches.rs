//! Disjoint patches of elements: what shares one volume change, and one clock.

use super::ElementId;

/// Disjoint patches: patch p is the elements `members[start[p]..start[p + 1]]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Patches {
    start: Vec<u32>,
    members: Vec<ElementId>,
}

impl Patches {
    /// Every element its own patch.
    #[must_use]
    pub fn alone(n_elements: usize) -> Self {
        Self { start: (0..=n_elements as u32).collect(), members: (0..n_elements as u32).map(ElementId).collect() }
    }

    /// Number of patches.
    #[must_use]
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The elements of a patch.
    #[must_use]
    pub fn of(&self, patch: usize) -> &[ElementId] {
        &self.members[self.start[patch] as usize..self.start[patch + 1] as usize]
    }

    /// Elements of the largest patch.
    #[must_use]
    pub fn largest(&self) -> usize {
        (0..self.len()).map(|p| self.of(p).len()).max().unwrap_or(0)
    }
}
