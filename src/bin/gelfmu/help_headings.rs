//! Headings of the options in the help of the commands.

/// Heading of the options of every command in its help.
pub const GLOBAL: &str = "Global options";
/// Heading of the options of a run for its accuracy.
pub const ACCURACY: &str = "Accuracy";
/// Heading of the options for the files that a command writes.
pub const RESULTS: &str = "Results";
/// Heading of the options of a run for the way in which it computes.
pub const COMPUTATION: &str = "Computation";

/// Heading of the options for the projectile and its path in the help.
pub const SHOT: &str = "Projectile";
/// Heading of the options for the block in the help.
pub const GEL: &str = "Gel";
