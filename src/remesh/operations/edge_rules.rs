//! Rules of the lengths of edges, by what the gel remembers of its shape.

use super::editable_mesh::ReferenceConfiguration;

/// Lengths at which edges are split and collapsed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EdgeRules {
    /// Edge, in target lengths, above which it is split.
    pub long: f64,
    /// Edge, in target lengths, above which no operation but a split makes one that is longer than those before.
    pub longest: f64,
    /// Longest edge, in target lengths, of an element that is too small.
    pub short: f64,
    /// Distance from a body, in usual lengths, up to which edges are split.
    pub near: f64,
    /// Hindrance that splits stay below.
    pub split_hindrance: f64,
    /// Factor by which the split of a surface edge may raise a hindrance above the limit.
    pub surface_rise: f64,
    /// True if nodes are moved also where another operation helps: a move takes little energy. Moves are many to try.
    pub moves_freely: bool,
    /// True if the middle of a split surface edge may stay in a body.
    pub keeps_chords: bool,
}

impl EdgeRules {
    /// Rules of a gel with a rest map: few edges are split, so that collapses do not undo them, and none for being short.
    const REST: Self = Self {
        long: 1.6,
        longest: f64::INFINITY,
        short: 0.0,
        near: 2.0,
        split_hindrance: 0.6,
        surface_rise: 1.05,
        moves_freely: true,
        keeps_chords: false,
    };

    /// Rules of a gel that flows: edges follow the target lengths everywhere. A split of the surface at a body that is pushed out
    /// of it flattens the elements beneath, and the operations after it mend these.
    const PRESENT: Self = Self {
        long: 1.4,
        longest: 1.4,
        short: 0.9,
        near: f64::INFINITY,
        split_hindrance: 1.3,
        surface_rise: 8.0,
        moves_freely: false,
        keeps_chords: true,
    };

    /// Rules for these rest positions.
    pub fn of(configuration: ReferenceConfiguration) -> Self {
        match configuration {
            ReferenceConfiguration::Rest => Self::REST,
            ReferenceConfiguration::Present => Self::PRESENT,
        }
    }
}
