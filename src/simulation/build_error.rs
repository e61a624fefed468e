//! Reasons why a checked scene could not be built.

/// Reason why a checked scene could not be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// Mesh with more cells than a process can hold.
    #[error(
        "mesh.size: the mesh would have about {cells:.2e} cells, more than {limit:.0e}; \
         raise mesh.size or add mesh.grading"
    )]
    TooLarge {
        /// Cells of the mesh.
        cells: f64,
        /// Greatest number of cells.
        limit: f64,
    },
    /// Gel with more edges along an axis than can be numbered.
    #[error("mesh.size: the gel is {edges:.2e} edges long, more than {limit:.0e}; raise mesh.size")]
    TooFine {
        /// Length of the gel over the edge length.
        edges: f64,
        /// Greatest number of edges.
        limit: f64,
    },
    /// Run with more ticks than are exact.
    #[error(
        "scene.end_time: {ticks:.2e} ticks are more than {limit:.0e}, the most that stay exact; \
         shorten the run, coarsen the mesh or raise integrator.cfl"
    )]
    TooLong {
        /// Ticks up to the end time.
        ticks: f64,
        /// Greatest number of exact ticks.
        limit: f64,
    },
    /// Element without a finite stable step.
    #[error(
        "gel: the stable step of an element is {step:e} s; density, moduli and sizes are out of range: bring \
         gel.density, its moduli and mesh.size nearer to those of a gel"
    )]
    NoStep {
        /// Stable step, s.
        step: f64,
    },
    /// Load without a facet to act on.
    #[error(
        "{key}: no facet of the surface of the gel is on that face and, with all its corners, in that box; \
         widen {key}.within"
    )]
    Unloaded {
        /// Key `load[i]`.
        key: String,
    },
    /// Body whose centre is in the gel at the start.
    #[error("{body}.position: at the start the centre of that body is in the gel; move it out")]
    Swallowed {
        /// Body: `projectile` or `fragment[i]`.
        body: String,
    },
    /// Gel and body that overlap at the start.
    #[error("{body}.position: at the start the surface of the gel is {depth:.3e} m inside that body; move it out")]
    Overlap {
        /// Body: `projectile` or `fragment[i]`.
        body: String,
        /// Depth of the deepest node, m.
        depth: f64,
    },
}
