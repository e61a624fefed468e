//! Reasons why a new mesh was refused.

use crate::integrator::UnusableStep;
use crate::remesh::{MeshRejected, RemeshError};
use std::fmt::{self, Display, Formatter};

/// Reason why a candidate mesh was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RemeshRefusal {
    /// Mesh generation failed.
    #[error(transparent)]
    Made(#[from] RemeshError),
    /// Mesh quality is not acceptable.
    #[error(transparent)]
    Judged(#[from] MeshRejected),
    /// Local operations have left inverted elements.
    #[error("{elements} elements are inverted, and no local operation remakes them")]
    Inverted {
        /// Number of inverted elements.
        elements: usize,
    },
    /// Nodes of the new mesh have no mass.
    #[error("{nodes} nodes of the new mesh have no mass: no old element overlaps their elements")]
    Massless {
        /// Number of massless nodes.
        nodes: usize,
    },
    /// Total mass is not conserved.
    #[error("the mass of the new mesh is {after:e} kg, expected {before:e} kg")]
    Mass {
        /// Mass of the old mesh, kg.
        before: f64,
        /// Mass of the new mesh, kg.
        after: f64,
    },
    /// Kinetic energy has increased: nodes of hardly any mass have excessive velocities.
    #[error(
        "the kinetic energy on the new mesh is {after:.3e} J, on the old mesh {before:.3e} J: a new node has almost \
         no mass"
    )]
    Gains {
        /// Kinetic energy of the old mesh, J.
        before: f64,
        /// Kinetic energy of the new mesh, J.
        after: f64,
    },
    /// Energy has increased beyond what the motion around the new elements could return.
    #[error("the energy on the new mesh is {gained:.3e} J greater than on the old one, expected at most {limit:.3e} J")]
    Energy {
        /// Gain of kinetic and stored energy, J.
        gained: f64,
        /// Greatest gain that is accepted, J.
        limit: f64,
    },
    /// Element without a valid rest shape.
    #[error("an element of the new mesh has no reference shape: the old elements under it are inverted")]
    Restless,
    /// Element without a finite stable step.
    #[error("in the new mesh {0}")]
    Steps(UnusableStep),
}

/// Failed remeshing: the old mesh was kept, or the run ended with it.
#[derive(Debug, Clone, PartialEq)]
pub struct FailedRemesh {
    /// Time, s.
    pub time: f64,
    /// Reasons, attempt by attempt.
    pub why: Vec<RemeshRefusal>,
}

impl Display for FailedRemesh {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let mut reasons: Vec<String> = self.why.iter().map(ToString::to_string).collect();
        reasons.dedup();
        write!(f, "No new mesh was accepted at {:.6e} s: {}", self.time, reasons.join("; "))
    }
}
