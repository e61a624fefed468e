//! Erosion: removes gel from the mesh, which flies on as drops without further contact.

use super::candidate::Known;
use super::history::inherited;
use super::model::Gelatin;
use super::source_mesh::{Made, Past};
use crate::fem::Potential;
use crate::integrator::NoStep;
use crate::math::Vector;
use crate::mesh::{ElementId, Facet, Mesh, NodeId, neighbours, outer, sorted};
use crate::remesh::{self, Moved, Neighbours, Same};
use crate::state::Birth;

/// Mesh that remains after an erosion.
struct Left<const D: usize> {
    /// Remaining mesh; rest shapes and history variables of its elements are set later.
    birth: Birth<D>,
    across: Neighbours,
    same: Vec<Option<Same>>,
    velocity: Vec<Vector<D>>,
    /// Eroded mass, kg.
    gone: f64,
}

impl<const D: usize> Gelatin<D> {
    /// Erodes gel thinner than `below`, m, and the parts that detach, each at most the fraction `most` of the gel;
    /// returns true if elements were removed. Nothing is removed if the rest could not be stepped.
    pub fn shed(&mut self, below: f64, most: f64) -> bool {
        let old = self.present();
        let moved = Moved { mesh: &old.mesh, position: &self.engine.state().position };
        let across = self.across.get_or_insert_with(|| neighbours::<D>(&old.mesh.elements));
        let thin = remesh::sheets(&moved, (&self.engine.gel().surface.facets, across), below);
        self.let_go(&old, &thin, most).unwrap_or(false)
    }

    /// Erodes these elements and [the parts that detach](remesh::with_what_hangs_on); returns true if elements were
    /// removed.
    ///
    /// Their mass, momentum and energy are booked in the ledger. The remaining mesh continues as after a remeshing
    /// without new elements. Nothing is removed if a node would be left without mass.
    ///
    /// # Errors
    /// [`NoStep`] if the remaining mesh could not be stepped; nothing is removed then.
    pub fn let_go(&mut self, old: &Birth<D>, gone: &[bool], most: f64) -> Result<bool, NoStep> {
        // As at most exchanges.
        if !gone.contains(&true) {
            return Ok(false);
        }
        let across = self.across.get_or_insert_with(|| neighbours::<D>(&old.mesh.elements));
        let mass: Vec<f64> = old.corner_mass.iter().map(|corners| corners[..=D].iter().sum()).collect();
        let gone = &remesh::with_what_hangs_on(across, &mass, gone, most);
        if !gone.contains(&true) {
            return Ok(false);
        }
        let state = self.engine.state();
        let left = Left::of(old, self.engine.last_tick(), (&state.position, &state.velocity), gone);
        if left.birth.mass.iter().any(|mass| *mass <= 0.0) {
            return Ok(false);
        }
        let carried = self.energy_of(old, gone);
        let before = (state.ledger.momentum.remesh, state.ledger.angular_momentum.remesh);
        let Left { mut birth, across, same, velocity, gone } = left;
        let kept: Vec<ElementId> = same.iter().flatten().map(|same| same.element).collect();
        let patches = self.engine.gel().potential.patches().left(&kept);
        let shapes = self.recipe.shapes(&birth.mesh.elements, &birth.position);
        let known = Known { patches, shapes, across };
        let past = Past::new((&self.engine.gel().potential, old, &state.memory), &state.position);
        let Birth { mesh: Mesh { rest, elements, .. }, position, .. } = &birth;
        let made = Made { position, rest, elements, same: &same, sources: &[], is_kept: false };
        let Some((references, memory)) = inherited(&past, &state.position, (&made, &known.patches)) else {
            return Ok(false);
        };
        birth.references = references;
        self.go_on(birth, (memory, velocity), known)?;
        self.engine.count_drops(gone);
        let ledger = self.engine.ledger_mut();
        // What the rest of a patch stores otherwise is the doing of the mesh.
        ledger.energy.splash -= carried;
        ledger.momentum.splash += ledger.momentum.remesh.value() - before.0.value();
        ledger.angular_momentum.splash += ledger.angular_momentum.remesh.value() - before.1.value();
        ledger.energy.remesh += carried;
        (ledger.momentum.remesh, ledger.angular_momentum.remesh) = before;
        Ok(true)
    }

    /// Kinetic and stored energy of these elements of the current mesh, J; that of a patch is shared by volume.
    fn energy_of(&self, old: &Birth<D>, gone: &[bool]) -> f64 {
        let (velocity, potential) = (&self.engine.state().velocity, &self.engine.gel().potential);
        let moving = |e: usize| -> f64 {
            let nodes = old.mesh.elements[e][..=D].iter().zip(&old.corner_mass[e]);
            nodes.map(|(node, mass)| 0.5 * mass * velocity[node.index()].norm_squared()).sum()
        };
        let kinetic: f64 = (0..gone.len()).filter(|e| gone[*e]).map(moving).sum();
        let energy = self.engine.measure_at(self.engine.now()).energy;
        let stored = potential.patches().iter().zip(energy).map(|(patch, energy)| {
            let volume =
                |ids: &mut dyn Iterator<Item = &ElementId>| -> f64 { ids.map(|id| potential.volume(*id)).sum() };
            let whole = volume(&mut patch.iter());
            energy * volume(&mut patch.iter().filter(|id| gone[id.index()])) / whole
        });
        kinetic + stored.sum::<f64>()
    }
}

impl<const D: usize> Left<D> {
    fn of(
        old: &Birth<D>,
        tick: crate::state::Tick,
        (position, velocity): (&[Vector<D>], &[Vector<D>]),
        gone: &[bool],
    ) -> Self {
        let kept: Vec<usize> = (0..gone.len()).filter(|e| !gone[*e]).collect();
        let mut mass = old.mass.clone();
        let mut lost = 0.0;
        for e in (0..gone.len()).filter(|e| gone[*e]) {
            for (node, corner) in old.mesh.elements[e][..=D].iter().zip(&old.corner_mass[e]) {
                mass[node.index()] -= corner;
                lost += corner;
            }
        }
        let mut number = vec![None; position.len()];
        kept.iter().flat_map(|e| &old.mesh.elements[*e][..=D]).for_each(|node| number[node.index()] = Some(0));
        let nodes: Vec<usize> = (0..number.len()).filter(|n| number[*n].is_some()).collect();
        nodes.iter().zip(0..).for_each(|(n, new)| number[*n] = Some(new));
        let renamed = |node: NodeId| NodeId(number[node.index()].unwrap_or(0));
        let elements: Vec<_> = kept.iter().map(|e| old.mesh.elements[*e].map(renamed)).collect();
        let of_nodes = |all: &[Vector<D>]| nodes.iter().map(|n| all[*n]).collect::<Vec<_>>();
        let same = |e: &usize| Some(Same::in_order(ElementId(*e as u32)));
        let across = neighbours::<D>(&elements);
        let facets = outer::<D>(&elements, &across);
        let held = nodes.iter().map(|n| old.mesh.held[*n]).collect();
        let marks = marks_of(old, &facets, &nodes);
        let birth = Birth {
            tick,
            mesh: Mesh { rest: of_nodes(&old.mesh.rest), elements, facets, held, marks },
            position: of_nodes(position),
            mass: nodes.iter().map(|n| mass[*n]).collect(),
            corner_mass: kept.iter().map(|e| old.corner_mass[*e]).collect(),
            references: vec![],
            steps: vec![],
        };
        Self { birth, across, same: kept.iter().map(same).collect(), velocity: of_nodes(velocity), gone: lost }
    }
}

/// Load markers of the remaining facets; `nodes` are their nodes' old numbers. No load acts on facets that were
/// inside.
fn marks_of<const D: usize>(old: &Birth<D>, facets: &[Facet], nodes: &[usize]) -> Vec<u8> {
    if old.mesh.marks.is_empty() {
        return vec![];
    }
    let mut known: Vec<(Facet, u8)> =
        old.mesh.facets.iter().map(|facet| sorted::<D>(*facet)).zip(old.mesh.marks.iter().copied()).collect();
    known.sort_unstable();
    let was = |facet: &Facet| sorted::<D>(facet.map(|node| NodeId(nodes[node.index()] as u32)));
    let found =
        |facet: &Facet| known.binary_search_by_key(&was(facet), |(facet, _)| *facet).map_or(0, |at| known[at].1);
    facets.iter().map(found).collect()
}
