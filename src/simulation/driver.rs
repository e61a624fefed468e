//! Remeshing driver: replaces a distorted mesh, and continues the run on the new one.

use super::RestoreError;
use super::candidate::{self, Known, Mesher, Refused, Way, symmetry};
use super::gel_definition::{Recipe, Sizes};
use super::history::inherited;
use super::model::Gelatin;
use super::observe::Frame;
use super::preview::{Refusal, Rehearsal, Renewal};
use super::sensors::seats;
use super::source_mesh::{Made, Past};
use crate::fem::{Memory, Potential, Simplices};
use crate::integrator::{NoStep, StepError, Totals};
use crate::math::Vector;
use crate::mesh::{ElementId, Mesh, Patches, neighbours};
use crate::remesh::{self, Moved, Neighbours, Same};
use crate::state::{Birth, State};
use std::sync::Arc;
use std::time::Instant;

/// Gel whose mesh can be replaced.
pub(super) trait Renew {
    /// Continues with a better mesh, or with the old one where no candidate is accepted.
    ///
    /// # Errors
    /// [`StepError`] if not even the old mesh can be stepped.
    fn renew(&mut self) -> Result<(), StepError>;

    /// Preview of a remeshing now, in the plane and where the scene has remeshing; `frame` is the current mesh.
    fn rehearsal(&self, frame: Frame) -> Option<Rehearsal>;
}

impl Renew for Gelatin<2> {
    fn renew(&mut self) -> Result<(), StepError> {
        self.renew_by(candidate::in_plane)
    }

    fn rehearsal(&self, frame: Frame) -> Option<Rehearsal> {
        Some(self.rehearsed(frame, self.recipe.remesh.as_ref()?))
    }
}

impl Renew for Gelatin<3> {
    fn renew(&mut self) -> Result<(), StepError> {
        self.renew_by(candidate::in_space)
    }

    fn rehearsal(&self, _: Frame) -> Option<Rehearsal> {
        None
    }
}

/// Thickness, as a fraction of the least edge, below which gel is eroded where no mesh is accepted, whatever the
/// scene says. Opposite walls may pinch gel to no thickness (1e-10 m has occurred), and no mesh thickens it.
const PINCHED: f64 = 0.01;
/// Greatest fraction of the gel that one such erosion may remove, detached parts included; heavier parts stay.
pub(super) const MOST_BROKEN: f64 = 0.01;

/// Greatest number of erosions at one time in search of an acceptable mesh. Each removes the elements for which the
/// last mesh was refused, or which could not be stepped.
pub(super) const MOST_BREAKS: usize = 32;

/// Ratio of the energy to the energy provided, above which a run has diverged.
const RUNAWAY: f64 = 10.0;

/// Neighbours and element qualities of a distorted mesh.
type Worn = (Neighbours, Vec<f64>);

impl<const D: usize> Gelatin<D> {
    fn renew_by(&mut self, mesher: Mesher<D>) -> Result<(), StepError> {
        let Some(sizes) = self.recipe.remesh.clone() else { return Ok(()) };
        let begun = Instant::now();
        if self.engine.state().birth.is_none() {
            self.first = Some(self.present());
        }
        if let Some(diverged) = self.diverged() {
            return Err(diverged);
        }
        // A mesh that fails as soon as it is made: so does the next one with what is in it.
        if let Some(failure) = self.engine.early_failure().cloned()
            && !self.break_off(&[])
        {
            return Err(failure);
        }
        // What cannot be stepped without its sheets goes on with them.
        if let Some(below) = sizes.rules.thinnest {
            self.shed(below, 1.0);
        }
        let mut taken = self.exchange(mesher, (&sizes, begun));
        if taken.is_err() && self.shed(PINCHED * sizes.least, MOST_BROKEN) {
            taken = self.exchange(mesher, (&sizes, begun));
        }
        for _ in 0..MOST_BREAKS {
            match &taken {
                Err((refused, _)) if self.break_off(refused) => taken = self.exchange(mesher, (&sizes, begun)),
                _ => break,
            }
        }
        let Err((refused, worn)) = taken else { return Ok(()) };
        let time = self.engine.now();
        self.refusals.push(Refusal { time, why: refused });
        // Of the gel as it is now: what failed may have been shed.
        if let Some(failure) = self.engine.failure() {
            return Err(failure.clone());
        }
        self.keep(&self.present(), worn).map_err(|NoStep { step, .. }| StepError::Worn { time, step })
    }

    /// Error of a run whose energy far exceeds the initial energy and the work done on it. Without this check a
    /// diverging run refuses new meshes at length: a ball of 23 m/s once reached 1e223 m.
    fn diverged(&self) -> Option<StepError> {
        let time = self.engine.now();
        let Totals { energies, ledger, initial_energy, .. } = self.engine.totals(time);
        let provided = ledger.energy.provided(initial_energy);
        let part = energies.discrete() / provided;
        (provided > self.recipe.noise(self.gel_mass()) && part > RUNAWAY).then_some(StepError::Diverged { time, part })
    }

    /// Continues with a better mesh of the current gel; `begun` is when the remeshing began.
    ///
    /// # Errors
    /// Reasons why each candidate was refused, and the data of the old mesh.
    fn exchange(&mut self, mesher: Mesher<D>, (sizes, begun): (&Sizes, Instant)) -> Result<(), (Vec<Refused>, Worn)> {
        let old = self.present();
        let position = self.engine.state().position.clone();
        let moved = Moved { mesh: &old.mesh, position: &position };
        // Whatever mesh goes on tells it again.
        let across = self.across.take();
        let worn = self.worn(&moved, across);
        let size = self.sizes(&moved, (sizes, &worn.0));
        let mut refused = vec![];
        let ways = match D {
            3 if self.flows() => Way::FLOWING,
            3 => Way::SOLID,
            _ => Way::of(sizes.rules.method, self.flows()),
        };
        for (way, attempt) in ways.into_iter().zip(1..) {
            let candidate = match self.candidate((&old, &moved, &worn), (&size, mesher), way) {
                Ok(candidate) => candidate,
                Err(why) => {
                    refused.push(why);
                    continue;
                }
            };
            let renewal = Renewal::of(&candidate, self.engine.now(), attempt);
            let booked = self.engine.state().ledger.energy.remesh;
            let made = candidate.made_with_masses();
            if let Err(why) = self.go_on(candidate.birth, (candidate.memory, candidate.velocity), candidate.known) {
                refused.push(Refused::Steps(why));
                continue;
            }
            self.engine.count_exchange();
            if self.flows() {
                self.engine.refund(&made, booked - self.engine.state().ledger.energy.remesh);
            }
            let energy = self.engine.state().ledger.energy.remesh - booked;
            self.renewals.push(Renewal { energy, seconds: begun.elapsed().as_secs_f64(), ..renewal });
            return Ok(());
        }
        Err((refused, worn))
    }

    /// Continues with the old mesh and new patches, as after a remeshing that leaves every element unchanged.
    fn keep(&mut self, old: &Birth<D>, (across, shapes): Worn) -> Result<(), NoStep> {
        let state = self.engine.state();
        let mut birth = Birth { tick: self.engine.last_tick(), position: state.position.clone(), ..old.clone() };
        let patches = self.recipe.patches((&birth.mesh, &birth.position), &across);
        let past = Past::new((&self.engine.gel().potential, old, &state.memory), &state.position);
        let Mesh { rest, elements, .. } = &birth.mesh;
        let same: Vec<_> = (0..elements.len() as u32).map(|element| Some(Same::in_order(ElementId(element)))).collect();
        let made = Made { position: &birth.position, rest, elements, same: &same, sources: &[], is_kept: true };
        let (velocity, mut memory) = (state.velocity.clone(), state.memory.clone());
        if let Some((references, recalled)) = inherited(&past, &state.position, (&made, &patches)) {
            (birth.references, memory) = (references, recalled);
        }
        self.go_on(birth, (memory, velocity), Known { patches, shapes, across })
    }

    /// Continues the run on a mesh with these properties.
    pub(super) fn go_on(
        &mut self,
        birth: Birth<D>,
        (memory, velocity): (Vec<Memory<D>>, Vec<Vector<D>>),
        known: Known,
    ) -> Result<(), NoStep> {
        let Known { patches, shapes, across } = known;
        let gel = self.gel_of(&birth, patches);
        let nodes = birth.position.iter().copied().zip(velocity).collect();
        self.engine = self.engine.renewed((gel, Some(memory)), nodes, Some(birth))?;
        self.dress(&self.present(), (&shapes, across));
        Ok(())
    }
}

impl<const D: usize> Gelatin<D> {
    /// Derived properties of a mesh of this gel: patches, element qualities and neighbours. `position` is where the
    /// nodes of the new mesh are.
    pub fn known(&self, mesh: &Mesh<D>, position: &[Vector<D>], across: Neighbours) -> Known {
        let shapes = self.recipe.shapes(&mesh.elements, position);
        Known { patches: self.recipe.patches((mesh, position), &across), shapes, across }
    }

    /// Gel of the integrator on this mesh.
    pub fn gel_of(&self, birth: &Birth<D>, patches: Patches) -> crate::integrator::Gel<D, Simplices<D>> {
        let simplices = self.recipe.simplices(&birth.mesh, patches).with_references(&birth.references);
        self.recipe.gel(simplices, (&birth.mesh, &birth.position), birth.mass.clone())
    }

    /// Continues from a state of this run.
    ///
    /// # Errors
    /// [`RestoreError`] if the state is not one of this run; nothing is changed then.
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
        let across = neighbours::<D>(&birth.mesh.elements);
        let Known { patches, shapes, across } = self.known(&birth.mesh, &birth.position, across);
        let other = self.engine.on_mesh(self.gel_of(&birth, patches), &birth.position, state.birth.clone());
        let mut other = other.map_err(|NoStep { .. }| wrong("its mesh cannot be stepped"))?;
        other.restore(state).map_err(wrong)?;
        self.engine = other.with_pool(self.engine.take_pool());
        self.first = first;
        self.dress(&birth, (&shapes, across));
        Ok(())
    }

    /// Takes over the data that is kept beside the engine; `shapes` are the qualities of the elements when the mesh
    /// was new.
    pub fn dress(&mut self, birth: &Birth<D>, (shapes, across): (&[f64], Neighbours)) {
        self.across = Some(across);
        self.facets.clone_from(&birth.mesh.facets);
        self.marks.clone_from(&birth.mesh.marks);
        self.seats = seats(&self.engine, &self.recipe);
        self.engine.set_wear(self.recipe.wear(&self.engine.gel().potential, &birth.position, shapes));
    }

    /// Mesh of the engine as it was when it was new.
    pub fn present(&self) -> Arc<Birth<D>> {
        if let Some(birth) = &self.engine.state().birth {
            return Arc::clone(birth);
        }
        let gel = self.engine.gel();
        let rest = gel.potential.rest().to_vec();
        let elements = gel.potential.elements().to_vec();
        let held = (0..rest.len()).map(|node| gel.held(node)).collect();
        let mesh = Mesh { rest, elements, facets: self.facets.clone(), held, marks: self.marks.clone() };
        let corner_mass = corner_masses(&gel.potential, &self.recipe);
        Arc::new(Birth {
            tick: 0,
            position: mesh.rest.clone(),
            mass: gel.mass.clone(),
            corner_mass,
            references: vec![],
            steps: vec![],
            mesh,
        })
    }
}

/// Masses of the corners of the elements at rest, kg.
fn corner_masses<const D: usize>(potential: &Simplices<D>, recipe: &Recipe) -> Vec<[f64; 4]> {
    let mass = |element| recipe.density * potential.volume(ElementId(element));
    let masses: Vec<f64> = (0..potential.len() as u32).map(mass).collect();
    remesh::corner_masses(potential.rest(), potential.elements(), &masses, symmetry(recipe))
}
