//! A mesh that may replace a worn one: sized, made, judged, and with all that it carries.

use super::gel_definition::{Recipe, Sizes};
use super::history;
use super::model::Gelatin;
use super::source_mesh::{Made, Past};
use crate::contact::{Body, BodyState};
use crate::fem::{Memory, Potential, Section};
use crate::geometry::Pole;
use crate::integrator::NoStep;
use crate::math::{Vector, Vector3, embed, restrict};
use crate::mesh::{ElementId, Mesh, Patches, neighbours, outer};
use crate::remesh::{
    self, Acceptance, Carried, Defects, Moved, Neighbours, Pairing, Proposal, Quality, Range, Rejected, RemeshError,
    Rules, Symmetry, Transferred,
};
use crate::scene::RemeshMethod;
use crate::state::Birth;
use std::f64::consts::FRAC_PI_2;

/// A mesh that may replace another one, and the velocities of its nodes.
#[derive(Debug)]
pub(super) struct Candidate<const D: usize> {
    pub birth: Birth<D>,
    /// What its elements remember.
    pub memory: Vec<Memory<D>>,
    pub velocity: Vec<Vector<D>>,
    /// What it was judged to be.
    pub quality: Quality,
    /// What the transfer changed.
    pub defects: Defects<D>,
    /// What follows from the mesh.
    pub known: Known,
    /// The elements that are not old ones.
    pub made: Vec<ElementId>,
}

/// What follows from a mesh and the places of its nodes, and is found once.
#[derive(Debug, Clone)]
pub(super) struct Known {
    pub patches: Patches,
    /// Quality of each element, infinite of those that are too good to matter.
    pub shapes: Vec<f64>,
    /// Neighbours of each element.
    pub across: Neighbours,
}

/// Why a mesh may not replace another one.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Refused {
    /// There is none.
    #[error(transparent)]
    Made(#[from] RemeshError),
    /// It is not good enough.
    #[error(transparent)]
    Judged(#[from] Rejected),
    /// Some of it is made of nothing.
    #[error("{nodes} nodes of the new mesh have no mass: no old element lies under theirs")]
    Massless {
        /// How many.
        nodes: usize,
    },
    /// Some of it is lost, or made of nothing.
    #[error("the new mesh would have a mass of {after:e} kg instead of {before:e} kg")]
    Mass {
        /// Mass of the old mesh, kg.
        before: f64,
        /// That of the new one, kg.
        after: f64,
    },
    /// Velocities that nodes of hardly any mass cannot carry.
    #[error(
        "the gel would move with {after:.3e} J instead of {before:.3e} J: a node of the new mesh has hardly any mass"
    )]
    Gains {
        /// Kinetic energy of the old mesh, J.
        before: f64,
        /// That of the new one, J.
        after: f64,
    },
    /// An element that cannot have been anything at rest.
    #[error("an element of the new mesh has no shape at rest: the old ones under it are inverted")]
    Restless,
    /// It cannot be stepped.
    #[error("in the new mesh {0}")]
    Steps(NoStep),
}

/// A way to make a mesh, one attempt after the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Way {
    /// Nodes of the boundary are left out where it is within so many chords of the chord without them, and in space go along it, off it
    /// by so many target lengths at most; and whether the gel has a surface at rest.
    Retained { sag: f64, slide: f64, rests: bool },
    /// With this part of the sizes.
    Immersed { part: f64 },
}

/// What makes a mesh of a dimension, new points of its surface where they are cleared of bodies: also by how much it may change
/// the area or volume of the body.
pub(super) type Mesher<const D: usize> =
    fn(Way, &Moved<'_, D>, &[f64], Cleared<'_, D>) -> Result<(Proposal<D>, f64), RemeshError>;
/// The place nearest to a point that is in no body.
pub(super) type Cleared<'a, const D: usize> = &'a dyn Fn(&Vector<D>) -> Vector<D>;

/// What the area or volume of the body may change by when nodes of its boundary are left out.
const MEASURE: f64 = 1e-5;
/// The same of a gel that flows. The wall of a wide cavity in cells that grow goes beyond the other: at 210 m/s nodes were left out no
/// more then, a tenth of a micrometre apart on the axis, and the step fell to a thousandth.
const MEASURE_IN_FLOW: f64 = 1e-4;
/// An immersed mesh may be worse shaped than the old one, but no worse than this: what cutting leaves is above it except in corners that
/// the sizes do not resolve (`smooth_bodies_of_any_size_and_place_are_cut_out_whole`).
const FAIR: f64 = 0.1;

/// The mass of a new mesh is that of the old one to this part. Rounding leaves 2e-14 of all that a run with a hundred exchanges has.
const SAME_MASS: f64 = 1e-12;
/// A mesh may have so many times the kinetic energy of the old one at most: finer ones hold a few per cent more of short waves.
const MOST_GAINED: f64 = 1.1;
/// A node is light with less than this part of an even share of what its elements weigh. One of a seventh in front of the nose of
/// `bullet-yaw` was thrown at twice the bullet's speed, and its step fell to a thousandth; of 15 runs of random scenes in the plane and in
/// space (49, 162, 178, 190, 191 and two speeds beside each) three stopped without this, and none with it; one, with other last digits.
const LIGHT: f64 = 0.25;
/// No better than this need a mesh in the plane be, if the old one was: a needle of 10°.
const WORN: f64 = 0.3;
/// What the splitting of long edges may leave in space where nothing makes it better.
const SPLIT: f64 = 0.2;

impl<const D: usize> Candidate<D> {
    /// The elements that are not old ones, and their masses, kg.
    pub fn made_with_masses(&self) -> Vec<(ElementId, f64)> {
        self.made.iter().map(|e| (*e, self.birth.corner_mass[e.index()].iter().sum())).collect()
    }
}

impl Way {
    /// The attempts of a method in the plane, for a gel that flows or not.
    pub fn of(method: RemeshMethod, flows: bool) -> [Self; 3] {
        match method {
            RemeshMethod::Retained => [0.06, 0.02, 0.0].map(|sag| Self::Retained { sag, slide: 0.0, rests: !flows }),
            RemeshMethod::Immersed => [1.0, 0.7, 0.5].map(|part| Self::Immersed { part }),
        }
    }

    /// The attempts in space of a gel that does not flow: points of its surface go along it only where nothing else is taken.
    pub const SOLID: [Self; 3] = [
        Self::Retained { sag: 0.06, slide: 0.0, rests: true },
        Self::Retained { sag: 0.02, slide: 0.05, rests: true },
        Self::Retained { sag: 0.2, slide: 0.1, rests: true },
    ];

    /// The attempts in space of a gel that flows. Nothing tells any more how flat its surface was at rest, and a cavity in cells of a
    /// quarter of the ball's radius is flat to no more than 0.13 of a cell. Where no point slides, an element of the calibration shot is
    /// inverted after 11 µs.
    pub const FLOWING: [Self; 3] = [
        Self::Retained { sag: 0.2, slide: 0.1, rests: false },
        Self::Retained { sag: 0.06, slide: 0.05, rests: false },
        Self::Retained { sag: 0.0, slide: 0.0, rests: false },
    ];

    /// The worst shape that a mesh made so may have, if the old one has this worst shape.
    fn worst<const D: usize>(self, old: f64) -> f64 {
        match self {
            Self::Retained { .. } => old.min(if D == 3 { SPLIT } else { WORN }),
            Self::Immersed { .. } => old.min(FAIR),
        }
    }
}

/// The mesh that is made so in the plane; new points of an immersed one stay where the old boundary was.
pub(super) fn in_plane(
    way: Way,
    moved: &Moved<'_, 2>,
    size: &[f64],
    cleared: Cleared<'_, 2>,
) -> Result<(Proposal<2>, f64), RemeshError> {
    match way {
        Way::Retained { sag, rests, .. } => {
            Ok((remesh::propose(moved, size, &Rules { sag, rests, ..Rules::default() }, cleared)?, MEASURE))
        }
        Way::Immersed { part } => {
            let size: Vec<f64> = size.iter().map(|size| part * size).collect();
            let steps = remesh::immerse(moved, &size, &Rules::default())?;
            Ok((steps.proposal, MEASURE + remesh::rounding(moved, &size)))
        }
    }
}

/// The mesh that is made so in space; an immersed one, which a scene cannot ask for, is none.
pub(super) fn in_space(
    way: Way,
    moved: &Moved<'_, 3>,
    size: &[f64],
    cleared: Cleared<'_, 3>,
) -> Result<(Proposal<3>, f64), RemeshError> {
    match way {
        Way::Retained { sag, slide, rests } => {
            let rules = Rules { sag, slide, rests, ..Rules::default() };
            Ok((remesh::propose_in_space(moved, size, &rules, cleared)?, MEASURE))
        }
        Way::Immersed { .. } => Err(RemeshError::PlaneOnly),
    }
}

impl<const D: usize> Gelatin<D> {
    /// Target sizes of the nodes: fine where displacement and velocity bend and where a body is near; those of the scene, if they
    /// are not to adapt.
    pub fn sizes(&self, moved: &Moved<'_, D>, (sizes, across): (&Sizes, &Neighbours)) -> Vec<f64> {
        if !sizes.rules.adaptive {
            return vec![sizes.usual; moved.position.len()];
        }
        let range = Range { least: sizes.least, greatest: sizes.longest };
        // Sizes are halved or doubled at most.
        let angle = sizes.rules.bend.to_radians();
        let asked = [0.5 * angle, 2.0 * angle].map(|angle| angle.min(FRAC_PI_2));
        let displacement = displacement(moved);
        let bends = remesh::bends_within(moved, &[&displacement, &self.engine.state().velocity], (across, asked));
        let mut size = remesh::curved(moved, &bends, angle, &range);
        let bodies = self.active_bodies();
        for (size, x) in size.iter_mut().zip(moved.position) {
            let gaps = bodies.iter().map(|(body, at)| body.gap(at, &embed(x)).distance);
            let gap = gaps.fold(f64::INFINITY, f64::min).max(0.0);
            *size = size.min(sizes.usual + sizes.rules.growth * gap);
        }
        let mut size = remesh::thinned(moved, (&self.engine.gel().surface.facets, across), size, sizes.least);
        if let Some(tip) = sizes.rules.tip {
            let ends = ends(&bodies);
            for (size, x) in size.iter_mut().zip(moved.position) {
                let near = ends.iter().map(|end| (embed(x) - end).norm()).fold(f64::INFINITY, f64::min);
                *size = size.min(tip + sizes.rules.growth * near);
            }
        }
        remesh::graded(moved, size, sizes.rules.growth)
    }

    /// The bodies that take part, where they are now.
    fn active_bodies(&self) -> Vec<(&Body, BodyState)> {
        let time = self.engine.now();
        let all = self.engine.bodies().iter().zip(&self.engine.state().bodies);
        all.map(|(body, last)| (body, last.at(body, time))).filter(|(_, at)| at.active).collect()
    }

    /// How far displacement and velocity bend at each element, rad.
    pub fn bends(&self, moved: &Moved<'_, D>) -> Vec<f64> {
        remesh::bends(moved, &[&displacement(moved), &self.engine.state().velocity])
    }

    /// The neighbours of each element of the mesh that there is, if these are not `known`, and its quality where the nodes are.
    pub fn worn(&self, moved: &Moved<'_, D>, known: Option<Neighbours>) -> (Neighbours, Vec<f64>) {
        let across = known.unwrap_or_else(|| neighbours::<D>(&moved.mesh.elements));
        (across, self.recipe.shapes(&moved.mesh.elements, moved.position))
    }

    /// A new mesh with all that it carries; `worn` is what is known of the old one.
    ///
    /// # Errors
    /// [`Refused`] if there is none that may replace the old one.
    pub fn candidate(
        &self,
        (old, moved, (across, shapes)): (&Birth<D>, &Moved<'_, D>, &(Neighbours, Vec<f64>)),
        (size, mesher): (&[f64], Mesher<D>),
        way: Way,
    ) -> Result<Candidate<D>, Refused> {
        let bodies = self.active_bodies();
        let (proposal, measure) = mesher(way, moved, size, &|x| cleared(&bodies, x))?;
        let worst = shapes.iter().copied().fold(f64::INFINITY, f64::min);
        let measure = if self.flows() { measure.max(MEASURE_IN_FLOW) } else { measure };
        let acceptance = Acceptance { measure, quality: way.worst::<D>(worst) };
        let pairing = Pairing::of(&old.mesh, &proposal);
        let shapes = pairing.carried(shapes, |e| self.recipe.shape(&proposal.position, &proposal.elements[e]));
        let across = remesh::neighbours_after::<D>(&proposal.elements, &pairing, across);
        let facets = outer::<D>(&proposal.elements, &across);
        let known = remesh::Known { shapes: &shapes, facets: &facets };
        let quality = remesh::judge_known(moved, &proposal, (&acceptance, &known))?;
        let new = self.transferred((old, moved), (&proposal, pairing));
        bearable(&new.defects)?;
        let marks = remesh::marks(&old.mesh, (&facets, &new.rest), &proposal.origin);
        let (rest, held) = (new.rest.clone(), new.held.clone());
        let mesh = Mesh { rest, elements: proposal.elements.clone(), facets, held, marks };
        let patches = self.recipe.patches((&mesh, &proposal.position), &across);
        let past = (&self.engine.gel().potential, old, self.engine.state().memory.as_slice());
        let past = Past::new(past, moved.position);
        let inherited = history::inherited(&past, moved.position, (&Made::by(&proposal, &new), &patches));
        let (references, memory) = inherited.ok_or(Refused::Restless)?;
        let made = (0..).map(ElementId).zip(&new.same).filter(|(_, same)| same.is_none()).map(|(e, _)| e).collect();
        let Transferred { mass, corner_mass, velocity, defects, .. } = new;
        let tick = self.engine.last_tick();
        let (position, steps) = (proposal.position, vec![]);
        let birth = Birth { tick, mesh, position, mass, corner_mass, references, steps };
        let known = Known { patches, shapes, across };
        Ok(Candidate { birth, memory, velocity, quality, defects, known, made })
    }

    /// Whether the gel is one that flows.
    pub fn flows(&self) -> bool {
        self.engine.gel().potential.remembers()
    }

    /// What a new mesh takes over; where a node of it is in a corner in which the density is below nothing, or has hardly any mass, once
    /// more without such corners.
    fn transferred(
        &self,
        (old, moved): (&Birth<D>, &Moved<'_, D>),
        (proposal, pairing): (&Proposal<D>, Pairing),
    ) -> Transferred<D> {
        let carried = self.carried(old);
        let new = remesh::transfer_paired(moved, &carried, (proposal, pairing.clone()));
        let is_light = || remesh::lightest(&proposal.elements, &new) < LIGHT;
        if new.defects.massless == 0 && !is_light() {
            return new;
        }
        remesh::transfer_paired(moved, &Carried { is_level: true, ..carried }, (proposal, pairing))
    }

    fn carried<'a>(&'a self, old: &'a Birth<D>) -> Carried<'a, D> {
        Carried {
            symmetry: symmetry(&self.recipe),
            mass: &old.mass,
            corner_mass: &old.corner_mass,
            velocity: &self.engine.state().velocity,
            is_level: false,
        }
    }
}

fn displacement<const D: usize>(moved: &Moved<'_, D>) -> Vec<Vector<D>> {
    moved.position.iter().zip(&moved.mesh.rest).map(|(x, rest)| x - rest).collect()
}

/// Ends of bodies on their axes, and their corners, m.
fn ends(bodies: &[(&Body, BodyState)]) -> Vec<Vector3> {
    let of = |(body, at): &(&Body, BodyState)| -> Vec<Vector3> {
        let place = |pole: &Pole| at.position + at.orientation.transform_vector(&pole.end);
        body.shape.poles().iter().map(place).collect()
    };
    bodies.iter().flat_map(of).collect()
}

/// The place on the surface of a body for one inside it: a new point of a facet that is drawn over a body would have to be
/// pushed out of it later.
fn cleared<const D: usize>(bodies: &[(&Body, BodyState)], x: &Vector<D>) -> Vector<D> {
    bodies.iter().fold(*x, |x, (body, at)| {
        let gap = body.gap(at, &embed(&x));
        x - restrict::<D>(&gap.normal) * gap.distance.min(0.0)
    })
}

/// Whether a mesh to which a transfer did this may replace another one.
fn bearable<const D: usize>(defects: &Defects<D>) -> Result<(), Refused> {
    if defects.massless > 0 {
        return Err(Refused::Massless { nodes: defects.massless });
    }
    let (before, after) = (defects.before.mass, defects.after.mass);
    if after.is_nan() || (after - before).abs() > SAME_MASS * before {
        return Err(Refused::Mass { before, after });
    }
    let (before, after) = (defects.before.kinetic, defects.after.kinetic);
    if after.is_nan() || after > MOST_GAINED * before {
        return Err(Refused::Gains { before, after });
    }
    Ok(())
}

/// What a section is of.
pub(super) fn symmetry(recipe: &Recipe) -> Symmetry {
    match recipe.section {
        Section::Planar { .. } => Symmetry::Planar,
        Section::Axisymmetric => Symmetry::Axisymmetric,
        Section::Spatial => Symmetry::Spatial,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::remesh::Books;

    #[test]
    fn a_mesh_that_has_not_the_mass_of_the_old_one_is_refused() {
        let (momentum, angular) = (Vector::<2>::zeros(), Vector3::zeros());
        let books = |mass: f64| Books { mass, momentum, angular, kinetic: 1.0 };
        let defects = |mass: f64| Defects {
            before: books(20.0),
            raw: books(mass),
            after: books(mass),
            held_momentum: momentum,
            held_angular: angular,
            stray_mass: 0.0,
            unchanged: 1.0,
            misses: 0,
            massless: 0,
        };
        assert_eq!(bearable(&defects(20.0 + 1e-12)), Ok(()));
        for after in [20.0 - 1e-4, 20.0 + 1e-10, 0.0] {
            assert_eq!(bearable(&defects(after)), Err(Refused::Mass { before: 20.0, after }));
        }
        assert!(matches!(bearable(&defects(f64::NAN)), Err(Refused::Mass { .. })));
    }
}
