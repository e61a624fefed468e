//! An exchange of the mesh, shown step by step before it is made.

use super::candidate::{Candidate, Refused, Way, in_plane};
use super::gel_definition::Sizes;
use super::model::Gelatin;
use super::observe::Frame;
use crate::math::Vector;
use crate::mesh::{Simplex, shape_quality};
use crate::remesh::{self, Defects, Moved, Neighbours, Quality, RemeshError, Rules, Steps};
use crate::scene::RemeshMethod;
use crate::state::Birth;
use std::fmt::{self, Display, Formatter};

/// An exchange of the mesh that was tried in vain: the old one went on, or the run ended with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// When, s.
    pub time: f64,
    /// Why, attempt by attempt.
    pub why: Vec<Refused>,
}

impl Display for Refusal {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let mut reasons: Vec<String> = self.why.iter().map(ToString::to_string).collect();
        reasons.dedup();
        write!(f, "No other mesh was taken at {:.6e} s: {}", self.time, reasons.join("; "))
    }
}

/// An exchange of the mesh that was made.
#[derive(Debug, Clone, PartialEq)]
pub struct Renewal {
    /// When, s.
    pub time: f64,
    /// Which of the attempts succeeded, from 1.
    pub attempt: usize,
    /// What the new mesh was judged to be.
    pub quality: Quality,
    /// Mass that was laid down where nothing lay over it, as a share of all.
    pub mass: f64,
    /// Momentum that appeared before any correction and that no held node gave, N·s.
    pub momentum: f64,
    /// Kinetic energy before and after, J.
    pub kinetic: [f64; 2],
    /// What kinetic and stored energy changed by, J.
    pub energy: f64,
    /// Elements of the new mesh.
    pub elements: usize,
    /// Part of them that are old ones.
    pub unchanged: f64,
    /// How long it took, all attempts, s.
    pub seconds: f64,
}

impl Renewal {
    pub(super) fn of<const D: usize>(candidate: &Candidate<D>, time: f64, attempt: usize) -> Self {
        let Candidate { birth, quality, defects, .. } = candidate;
        Self {
            time,
            attempt,
            quality: *quality,
            mass: defects.relative_mass(),
            momentum: defects.momentum_defect().norm(),
            kinetic: [defects.before.kinetic, defects.after.kinetic],
            energy: 0.0,
            elements: birth.mesh.elements.len(),
            unchanged: defects.unchanged,
            seconds: 0.0,
        }
    }
}

/// An exchange of the mesh with all its steps, by either method.
#[derive(Debug, Clone, PartialEq)]
pub struct Rehearsal {
    /// The mesh that ends.
    pub frame: Frame,
    /// Quality of each of its elements, q = 4√3 A/Σl².
    pub shapes: Vec<f64>,
    /// How far displacement and velocity bend at each of its elements, rad.
    pub bend: Vec<f64>,
    /// Target sizes of its nodes, m.
    pub size: Vec<f64>,
    /// The steps to the immersed mesh.
    pub steps: Result<Steps, RemeshError>,
    /// The mesh that each method makes of it.
    pub successors: [(RemeshMethod, Result<Successor, Refused>); 2],
}

/// A mesh that can replace another one.
#[derive(Debug, Clone, PartialEq)]
pub struct Successor {
    /// Where its nodes are, m.
    pub points: Vec<Vector<2>>,
    /// Its elements.
    pub elements: Vec<Simplex>,
    /// The velocities of its nodes, m/s.
    pub velocity: Vec<Vector<2>>,
    /// Which of the attempts made it, from 1.
    pub attempt: usize,
    /// What it was judged to be.
    pub quality: Quality,
    /// What the transfer changed.
    pub defects: Defects<2>,
    /// Energy stored in the old mesh and in this one, J.
    pub stored: [f64; 2],
}

impl Gelatin<2> {
    /// What an exchange would do now.
    pub fn rehearsed(&self, frame: Frame, sizes: &Sizes) -> Rehearsal {
        let old = self.present();
        let position = self.engine.state().position.clone();
        let moved = Moved { mesh: &old.mesh, position: &position };
        let worn = self.worn(&moved, self.across.clone());
        let size = self.sizes(&moved, (sizes, &worn.0));
        let successors = [RemeshMethod::Immersed, RemeshMethod::Retained]
            .map(|method| (method, self.successor((&old, &moved, &worn), &size, method)));
        Rehearsal {
            shapes: old.mesh.elements.iter().map(|element| shape_quality(&position, element)).collect(),
            bend: self.bends(&moved),
            steps: remesh::immerse(&moved, &size, &Rules::default()),
            frame,
            size,
            successors,
        }
    }

    /// The mesh of the first attempt that is not refused; why the last was, if all are.
    fn successor(
        &self,
        (old, moved, worn): (&Birth<2>, &Moved<'_, 2>, &(Neighbours, Vec<f64>)),
        size: &[f64],
        method: RemeshMethod,
    ) -> Result<Successor, Refused> {
        let mut refused = None;
        for (way, attempt) in Way::of(method, self.flows()).into_iter().zip(1..) {
            match self.candidate((old, moved, worn), (size, in_plane), way) {
                Ok(candidate) => return Ok(self.shown(candidate, moved, attempt)),
                Err(why) => refused = Some(why),
            }
        }
        Err(refused.expect("a method has attempts"))
    }

    fn shown(&self, candidate: Candidate<2>, moved: &Moved<'_, 2>, attempt: usize) -> Successor {
        let Candidate { birth, memory, velocity, quality, defects, known, .. } = candidate;
        let before = self.engine.gel().stored_energy(moved.position, &self.engine.state().memory);
        let stored = [before, self.gel_of(&birth, known.patches).stored_energy(&birth.position, &memory)];
        Successor { points: birth.position, elements: birth.mesh.elements, velocity, attempt, quality, defects, stored }
    }
}
