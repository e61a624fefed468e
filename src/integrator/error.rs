//! Why a simulation cannot go on.

use serde::{Deserialize, Serialize};

/// Why a step could not be completed (numerics A11). The state is that of the last consistent tick.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// An element stayed turned inside out.
    #[error(
        "element {element} is inverted at {time:.6e} s: J = {} at two of its own ticks in a row. \
         The mesh cannot follow the deformation: exchange it on the way, with a `remesh` table in the scene, or use a smaller \
         mesh.size near the impact, a lower speed, or a stiffer gel",
        fixed(*jacobian, 3)
    )]
    Inverted {
        /// The element.
        element: usize,
        /// When, s.
        time: f64,
        /// det F then.
        jacobian: f64,
    },
    /// A force is not a number.
    #[error(
        "element {element} gave a force that is not finite at {time:.6e} s. Its nodes have run away: lower integrator.cfl"
    )]
    NotFinite {
        /// The element.
        element: usize,
        /// When, s.
        time: f64,
    },
    /// The stable step fell below a thousandth of what it was.
    #[error(
        "the step of element {element} fell to {step:.3e} s at {time:.6e} s, below a thousandth of the smallest at the start. \
         It, or one around its nodes, is crushed or flat (least J beside it {}): use a smaller mesh.size near the \
         impact or a lower speed",
        fixed(*jacobian, 3)
    )]
    StepCollapsed {
        /// The element.
        element: usize,
        /// When, s.
        time: f64,
        /// Its step, s.
        step: f64,
        /// Least det F of its group then.
        jacobian: f64,
    },
    /// A body slips between surface nodes.
    #[error(
        "{} leaks through the surface of element {element} at {time:.6e} s: its facet at \
         ({}, {}, {}) m is {depth:.3e} m inside, more than the element size or the \
         body's inner radius. The facet has been stretched over the body: use a smaller mesh.size near the impact, a \
         lower speed, or a blunter body",
        name(*body), fixed(at[0], 4), fixed(at[1], 4), fixed(at[2], 4)
    )]
    Leak {
        /// Which body.
        body: usize,
        /// The element that the facet bounds.
        element: usize,
        /// When, s.
        time: f64,
        /// How deep, m.
        depth: f64,
        /// Where, m.
        at: [f64; 3],
    },
    /// A body spins faster than it can be followed.
    #[error(
        "{0} spins at {rate:.3e} rad/s at {time:.6e} s, by {2:.3e} rad in the shortest step there is: more than {most} cannot be \
         followed. Lower {1}.external_torque or {1}.angular_velocity",
        name(*body), variable(*body), turn
    )]
    Spun {
        /// Which body.
        body: usize,
        /// When, s.
        time: f64,
        /// |ω|, rad/s.
        rate: f64,
        /// Angle in a tick, rad.
        turn: f64,
        /// The greatest that can be followed, rad.
        most: f64,
    },
    /// No new mesh can go on, nor can the old one.
    #[error(
        "at {time:.6e} s the mesh is worn, and neither a new one nor this one can go on: the stable step would be {step:.3e} s. \
         Use a smaller mesh.size near the impact or a lower speed"
    )]
    Worn {
        /// When, s.
        time: f64,
        /// The stable step, s.
        step: f64,
    },
    /// The method has made more energy than there can be.
    #[error(
        "at {time:.6e} s gel and bodies have {part:.1e} times the energy that there was and came in: the method has made it, and what \
         follows would mean nothing. Use a smaller mesh.size near the impact, a lower speed, or a lower integrator.cfl"
    )]
    Diverged {
        /// When, s.
        time: f64,
        /// Energy, of what there was at the start and came in since.
        part: f64,
    },
}

/// A number with so many decimals, with an exponent instead where it is too great to be read so.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    if value.abs() < 1e6 { format!("{value:.decimals$}") } else { format!("{value:.decimals$e}") }
}

/// A body in words.
fn name(body: usize) -> String {
    if body == 0 { "the projectile".to_owned() } else { format!("fragment {body}") }
}

/// What the variables of a body begin with.
fn variable(body: usize) -> String {
    if body == 0 { "projectile".to_owned() } else { format!("fragment[{body}]") }
}

impl StepError {
    /// When, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        match self {
            Self::Inverted { time, .. }
            | Self::NotFinite { time, .. }
            | Self::StepCollapsed { time, .. }
            | Self::Leak { time, .. }
            | Self::Spun { time, .. }
            | Self::Worn { time, .. }
            | Self::Diverged { time, .. } => *time,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_run_away_is_told_in_few_digits() {
        assert_eq!([-0.0614, -1.38e83].map(|jacobian| fixed(jacobian, 3)), ["-0.061", "-1.380e83"]);
        let error = StepError::Inverted { element: 7, time: 1e-3, jacobian: -1.38e83 };
        assert!(error.to_string().contains("J = -1.380e83 at two"), "{error}");
    }
}
