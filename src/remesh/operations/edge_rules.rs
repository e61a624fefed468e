//! Rules of the lengths of edges, by the configuration in which operations are judged.
//!
//! Beside each number stands its evidence; [`super::improvement`] says what the prototype is.

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
    /// Rules in the rest configuration: few edges are split, so that collapses do not undo them, and none collapsed for
    /// being short.
    const REST: Self = Self {
        // With splits at 2, and meshes that end at an edge of 2.5, coarse cells held the ball of `sphere-deep` in space
        // by stretched facets: at 20 m/s it turned at 40.1, 42.6 and 45.5 mm on 6.25, 5 and 4 mm. With 1.6 and 2 it
        // turned at 43.4, 44.9 and 46.8 mm. With 1.4 and 1.6 meshes about an axis were remade three times as often.
        long: 1.6,
        longest: f64::INFINITY,
        short: 0.0,
        // Assumed, not measured.
        near: 2.0,
        // Without a margin below 1 splits and collapses undid each other, at a cost of 22 % of the kinetic energy in
        // the prototype. The value is the prototype's.
        split_hindrance: 0.6,
        // Assumed, not measured; the prototype's value.
        surface_rise: 1.05,
        // Without moves beside other operations the defect of random scenes doubled.
        moves_freely: true,
        keeps_chords: false,
    };

    /// Rules in the present configuration, of a gel that flows: edges follow the target lengths everywhere. A split of
    /// the surface at a body that is pushed out of it flattens the elements beneath, and the operations after it mend
    /// these.
    const PRESENT: Self = Self {
        // With facets split at 1.6 only, they lay as chords in the ball on coarse meshes: on cells of R/4 it came 62 mm
        // deep instead of 79.
        long: 1.4,
        // The length at which a split would follow; assumed, not measured.
        longest: 1.4,
        // Assumed, not measured.
        short: 0.9,
        near: f64::INFINITY,
        // Both assumed, not measured.
        split_hindrance: 1.3,
        surface_rise: 8.0,
        // Some hundred moves are possible around an element in space; they are tried where no other operation helps.
        moves_freely: false,
        keeps_chords: true,
    };

    /// Selects the rules of a configuration.
    pub fn of(configuration: ReferenceConfiguration) -> Self {
        match configuration {
            ReferenceConfiguration::Rest => Self::REST,
            ReferenceConfiguration::Present => Self::PRESENT,
        }
    }
}
