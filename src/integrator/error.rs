//! Errors that end a simulation.

use serde::{Deserialize, Serialize};

/// Failure of a step (method A11). The state is that of the last consistent tick.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// An element stayed inverted.
    #[error(
        "element {element} is inverted at {time:.6e} s: J = {} after two consecutive steps of it, expected J > 0. \
         The mesh cannot follow the deformation: add a `remesh` table to the scene, or use a smaller mesh.size near \
         the impact, a lower speed, or a stiffer gel",
        fixed(*jacobian, 3)
    )]
    Inverted {
        /// The element.
        element: usize,
        /// Time, s.
        time: f64,
        /// det F at that time.
        jacobian: f64,
    },
    /// A force is not finite.
    #[error(
        "element {element} has a force that is not finite at {time:.6e} s: the integration is unstable; lower \
         integrator.cfl"
    )]
    NotFinite {
        /// The element.
        element: usize,
        /// Time, s.
        time: f64,
    },
    /// The stable step fell below a thousandth of the smallest at the start.
    #[error(
        "the stable step of element {element} fell to {step:.3e} s at {time:.6e} s, below a thousandth of the smallest \
         initial step. The element or a neighbour is crushed or flat (least J there {}): use a smaller mesh.size near \
         the impact or a lower speed",
        fixed(*jacobian, 3)
    )]
    StepCollapsed {
        /// The element.
        element: usize,
        /// Time, s.
        time: f64,
        /// Stable step, s.
        step: f64,
        /// Least det F of its group at that time.
        jacobian: f64,
    },
    /// A body slips between surface nodes.
    #[error(
        "{} leaks through the surface of element {element} at {time:.6e} s: the facet at \
         ({}, {}, {}) m is {depth:.3e} m inside the body, more than the element size or the \
         body's inner radius. The facet is stretched over the body: use a smaller mesh.size near the impact, a \
         lower speed, or a blunter body",
        body_name(*body), fixed(at[0], 4), fixed(at[1], 4), fixed(at[2], 4)
    )]
    Leak {
        /// Index of the body.
        body: usize,
        /// The element that the facet bounds.
        element: usize,
        /// Time, s.
        time: f64,
        /// Depth of the facet in the body, m.
        depth: f64,
        /// Position, m.
        at: [f64; 3],
    },
    /// A body spins too fast for the shortest step.
    #[error(
        "{0} spins at {rate:.3e} rad/s at {time:.6e} s: it turns by {2:.3e} rad in a tick, expected at most {most} \
         rad. Lower {1}.external_torque or {1}.angular_velocity",
        body_name(*body), variable_prefix(*body), turn
    )]
    Spun {
        /// Index of the body.
        body: usize,
        /// Time, s.
        time: f64,
        /// |ω|, rad/s.
        rate: f64,
        /// Angle in a tick, rad.
        turn: f64,
        /// Greatest angle in a tick that can be followed, rad.
        most: f64,
    },
    /// Neither a new mesh nor the old one can go on.
    #[error(
        "at {time:.6e} s the mesh is distorted, no new mesh was accepted, and the old mesh cannot go on: its stable \
         step is {step:.3e} s. Use a smaller mesh.size near the impact or a lower speed"
    )]
    NoUsableMesh {
        /// Time, s.
        time: f64,
        /// The stable step, s.
        step: f64,
    },
    /// The method has created more energy than there can be.
    #[error(
        "at {time:.6e} s the energy of gel and bodies is {part:.1e} times the energy provided (initial energy and \
         later input): the integration has diverged. Use a smaller mesh.size near the impact, a lower speed, or a \
         lower integrator.cfl"
    )]
    Diverged {
        /// Time, s.
        time: f64,
        /// Energy, relative to the energy at the start and the input since.
        part: f64,
    },
}

/// Formats a number with a count of decimals, with an exponent if it is too great to be read without one.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    if value.abs() < 1e6 { format!("{value:.decimals$}") } else { format!("{value:.decimals$e}") }
}

/// Returns the name of a body in prose.
fn body_name(body: usize) -> String {
    if body == 0 { "the projectile".to_owned() } else { format!("fragment {body}") }
}

/// Returns the prefix of the variables of a body.
fn variable_prefix(body: usize) -> String {
    if body == 0 { "projectile".to_owned() } else { format!("fragment[{body}]") }
}

impl StepError {
    /// Returns the time of the failure, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        match self {
            Self::Inverted { time, .. }
            | Self::NotFinite { time, .. }
            | Self::StepCollapsed { time, .. }
            | Self::Leak { time, .. }
            | Self::Spun { time, .. }
            | Self::NoUsableMesh { time, .. }
            | Self::Diverged { time, .. } => *time,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_show_huge_numbers_with_an_exponent() {
        assert_eq!([-0.0614, -1.38e83].map(|jacobian| fixed(jacobian, 3)), ["-0.061", "-1.380e83"]);
        let error = StepError::Inverted { element: 7, time: 1e-3, jacobian: -1.38e83 };
        assert!(error.to_string().contains("J = -1.380e83 after two"), "{error}");
    }
}
