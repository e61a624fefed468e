//! A worn mesh and the one that replaces it: sized, proposed, judged, and taken or refused.

use super::model::Gelatin;
use super::recipe::{Recipe, Sizes};
use super::{RestoreError, history};
use crate::algebra::{Vector, embed, restrict};
use crate::avi::NoStep;
use crate::contact::{Body, BodyState};
use crate::element::{Potential, Section, Simplices};
use crate::mesh::{ElementId, Mesh, boundary, shape_quality};
use crate::remesh::{self, Acceptance, Carried, Moved, Proposal, Range, RemeshError, Rules, Symmetry, Transferred};
use crate::state::{Birth, State};
use std::sync::Arc;

/// What can be given another mesh.
pub(super) trait Renew {
    /// Goes on with a better mesh, or with the old one where there is none.
    ///
    /// # Errors
    /// [`NoStep`] if not even the old mesh can go on.
    fn renew(&mut self) -> Result<(), NoStep>;
}

/// How much of the boundary's nodes may be left out, one attempt after the other: chords of the chord without them.
const SAGS: [f64; 3] = [0.06, 0.02, 0.0];
/// What the area or volume of the body may change by when nodes of its boundary are left out.
const MEASURE: f64 = 1e-5;

impl Renew for Gelatin<2> {
    fn renew(&mut self) -> Result<(), NoStep> {
        self.renew_by(|old, size, rules, _| remesh::propose(old, size, rules))
    }
}

impl Renew for Gelatin<3> {
    fn renew(&mut self) -> Result<(), NoStep> {
        self.renew_by(remesh::propose_in_space)
    }
}

/// What makes a mesh for a body: from target sizes of its nodes, and where new points of its surface are clear of bodies.
type Mesher<const D: usize> =
    fn(&Moved<'_, D>, &[f64], &Rules, &dyn Fn(&Vector<D>) -> Vector<D>) -> Result<Proposal<D>, RemeshError>;

impl<const D: usize> Gelatin<D> {
    fn renew_by(&mut self, mesher: Mesher<D>) -> Result<(), NoStep> {
        let Some(sizes) = self.recipe.remesh else { return Ok(()) };
        let old = self.present();
        if self.engine.state().birth.is_none() {
            self.first = Some(Arc::clone(&old));
        }
        let position = self.engine.state().position.clone();
        let moved = Moved { mesh: &old.mesh, position: &position };
        let size = self.sizes(&moved, &sizes);
        let worst = old.mesh.elements.iter().map(|element| shape_quality(&position, element));
        let acceptance = Acceptance { measure: MEASURE, quality: worst.fold(f64::INFINITY, f64::min) };
        for sag in SAGS {
            let proposed = self.propose((&old, &moved), (&size, mesher), (sag, &acceptance));
            if proposed.is_some_and(|(birth, velocity)| self.go_on(birth, velocity).is_ok()) {
                self.engine.count_exchange();
                return Ok(());
            }
        }
        self.keep(&old)
    }

    fn carried<'a>(&'a self, old: &'a Birth<D>) -> Carried<'a, D> {
        Carried {
            symmetry: symmetry(&self.recipe),
            mass: &old.mass,
            corner_mass: &old.corner_mass,
            velocity: &self.engine.state().velocity,
        }
    }

    /// Target sizes of the nodes: fine where displacement and velocity bend and where a body is near.
    fn sizes(&self, moved: &Moved<'_, D>, sizes: &Sizes) -> Vec<f64> {
        let state = self.engine.state();
        let displacement: Vec<Vector<D>> =
            moved.position.iter().zip(&moved.mesh.rest).map(|(x, rest)| x - rest).collect();
        let range = Range { least: sizes.least, greatest: sizes.longest };
        let mut size = remesh::curved(moved, &[&displacement, &state.velocity], sizes.rules.bend.to_radians(), &range);
        let bodies = self.active_bodies();
        for (size, x) in size.iter_mut().zip(moved.position) {
            let gaps = bodies.iter().map(|(body, at)| body.gap(at, &embed(x)).distance);
            let gap = gaps.fold(f64::INFINITY, f64::min).max(0.0);
            *size = size.min(sizes.usual + sizes.rules.growth * gap);
        }
        remesh::graded(moved, size, sizes.rules.growth)
    }

    /// The bodies that take part, where they are now.
    fn active_bodies(&self) -> Vec<(&Body, BodyState)> {
        let time = self.engine.now();
        let all = self.engine.bodies().iter().zip(&self.engine.state().bodies);
        all.map(|(body, last)| (body, last.at(body, time))).filter(|(_, at)| at.active).collect()
    }

    /// The place on the surface of a body for one inside it: a new point of a facet that is drawn over a body would have to be
    /// pushed out of it later.
    fn cleared(&self, x: &Vector<D>) -> Vector<D> {
        self.active_bodies().iter().fold(*x, |x, (body, at)| {
            let gap = body.gap(at, &embed(&x));
            x - restrict::<D>(&gap.normal) * gap.distance.min(0.0)
        })
    }

    /// A new mesh and the velocities of its nodes, unless it is refused.
    fn propose(
        &self,
        (old, moved): (&Birth<D>, &Moved<'_, D>),
        (size, mesher): (&[f64], Mesher<D>),
        (sag, acceptance): (f64, &Acceptance),
    ) -> Option<(Birth<D>, Vec<Vector<D>>)> {
        let rules = Rules { sag, ..Rules::default() };
        let proposal = mesher(moved, size, &rules, &|x| self.cleared(x)).ok()?;
        let j = remesh::judge(moved, &proposal, acceptance);
        eprintln!("t {:.4e} sag {sag}: {:?}", self.engine.now(), j);
        j.ok()?;
        let new = remesh::transfer(moved, &self.carried(old), &proposal);
        if new.defects.massless > 0 {
            return None;
        }
        let potential = &self.engine.gel().potential;
        let references = history::references((potential, old), moved.position, (&proposal, &new))?;
        let facets = boundary::<D>(&proposal.elements);
        let Transferred { rest, mass, corner_mass, velocity, held, .. } = new;
        let mesh = Mesh { rest, elements: proposal.elements, facets, held };
        let tick = self.engine.last_tick();
        Some((Birth { tick, mesh, position: proposal.position, mass, corner_mass, references }, velocity))
    }

    /// Goes on with the old mesh.
    fn keep(&mut self, old: &Birth<D>) -> Result<(), NoStep> {
        let state = self.engine.state();
        let birth = Birth { tick: self.engine.last_tick(), position: state.position.clone(), ..old.clone() };
        let velocity = state.velocity.clone();
        self.go_on(birth, velocity)
    }

    fn go_on(&mut self, birth: Birth<D>, velocity: Vec<Vector<D>>) -> Result<(), NoStep> {
        let birth = Arc::new(birth);
        let gel = self.gel_of(&birth);
        let nodes = birth.position.iter().copied().zip(velocity).collect();
        self.engine = self.engine.renewed(gel, nodes, Some(Arc::clone(&birth)))?;
        self.dress(&birth);
        Ok(())
    }
}

impl<const D: usize> Gelatin<D> {
    pub fn gel_of(&self, birth: &Birth<D>) -> crate::avi::Gel<D, Simplices<D>> {
        let simplices = self.recipe.simplices(&birth.mesh).with_references(&birth.references);
        self.recipe.gel(simplices, (&birth.mesh, &birth.position), birth.mass.clone())
    }

    /// Continues from a state of this run.
    ///
    /// # Errors
    /// If it is none; nothing is changed then.
    pub fn go_back(&mut self, state: &State<D>) -> Result<(), RestoreError> {
        let wrong = |what| RestoreError::Inconsistent { what };
        let own = &self.engine.state().birth;
        let is_here = match (own, &state.birth) {
            (Some(own), Some(its)) => Arc::ptr_eq(own, its) || own == its,
            (own, its) => own.is_none() && its.is_none(),
        };
        if is_here {
            return self.engine.restore(state).map_err(wrong);
        }
        if self.recipe.remesh.is_none() {
            return Err(wrong("its mesh was exchanged, and that of this scene never is"));
        }
        let first = if own.is_none() { Some(self.present()) } else { self.first.clone() };
        let birth = state.birth.as_ref().or(first.as_ref()).map(Arc::clone).ok_or(RestoreError::Foreign)?;
        if !self.recipe.holds(&birth) {
            return Err(wrong("an element of its mesh is on the axis or beyond it"));
        }
        let other = self.engine.on_mesh(self.gel_of(&birth), &birth.position, state.birth.clone());
        let mut other = other.map_err(|NoStep { .. }| wrong("its mesh cannot be stepped"))?;
        other.restore(state).map_err(wrong)?;
        self.engine = other.with_pool(self.engine.take_pool());
        self.first = first;
        self.dress(&birth);
        Ok(())
    }

    /// Takes over what is kept of a mesh beside the engine.
    pub fn dress(&mut self, birth: &Birth<D>) {
        self.facets.clone_from(&birth.mesh.facets);
        self.engine.set_wear(self.recipe.wear(&self.engine.gel().potential, &birth.position));
    }

    /// The mesh of the engine as it was when it was new.
    pub fn present(&self) -> Arc<Birth<D>> {
        if let Some(birth) = &self.engine.state().birth {
            return Arc::clone(birth);
        }
        let gel = self.engine.gel();
        let rest = gel.potential.rest().to_vec();
        let elements = gel.potential.elements().to_vec();
        let held = (0..rest.len()).map(|node| gel.held(node)).collect();
        let mesh = Mesh { rest, elements, facets: self.facets.clone(), held };
        let corner_mass = corner_masses(&gel.potential, &self.recipe);
        Arc::new(Birth {
            tick: 0,
            position: mesh.rest.clone(),
            mass: gel.mass.clone(),
            corner_mass,
            references: vec![],
            mesh,
        })
    }
}

fn symmetry(recipe: &Recipe) -> Symmetry {
    match recipe.section {
        Section::Planar { .. } => Symmetry::Planar,
        Section::Axisymmetric => Symmetry::Axisymmetric,
        Section::Spatial => Symmetry::Spatial,
    }
}

/// Those of the elements at rest.
fn corner_masses<const D: usize>(potential: &Simplices<D>, recipe: &Recipe) -> Vec<[f64; 4]> {
    let mass = |element| recipe.density * potential.volume(ElementId(element));
    let masses: Vec<f64> = (0..potential.len() as u32).map(mass).collect();
    remesh::corner_masses(potential.rest(), potential.elements(), &masses, symmetry(recipe))
}
