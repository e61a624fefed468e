//! Erosion: removes gel from the mesh, which flies on as drops without further contact.

use super::adaptive_gel::{AdaptiveGel, MeshProperties};
use super::history::inherited;
use super::source_mesh::{SourceMesh, TargetMesh};
use crate::constitutive::ElasticAverage;
use crate::fem::Potential;
use crate::integrator::UnusableStep;
use crate::math::Vector;
use crate::mesh::{ElementId, ElementPatches, Facet, Mesh, NodeId, boundary_from_neighbours, face_neighbours, sorted};
use crate::remesh::{self, DeformedMesh, ElementNeighbours, UnchangedElement};
use crate::state::MeshInstance;

/// Greatest fraction of the gel that one erosion as a last resort may remove, detached parts included; heavier parts
/// stay.
pub(super) const MAX_ERODED_FRACTION: f64 = 0.01;

/// Greatest number of erosions at one time in search of an acceptable mesh. Each removes the elements for which the
/// last mesh was refused, or which could not be stepped.
pub(super) const MAX_EROSIONS: usize = 32;

/// Mesh that remains after an erosion.
struct RemainingMesh<const D: usize> {
    /// Remaining mesh; rest shapes and history variables of its elements are set later.
    birth: MeshInstance<D>,
    adjacency: ElementNeighbours,
    same: Vec<Option<UnchangedElement>>,
    velocity: Vec<Vector<D>>,
    /// Eroded mass, kg.
    eroded_mass: f64,
}

/// Erodes gel thinner than `thickness`, m, and the parts that detach; returns true if elements were removed. Each
/// part is at most the fraction `max_fraction` of the gel. Nothing is removed if the rest could not be stepped.
pub(super) fn erode_thin_gel<const D: usize>(gel: &mut AdaptiveGel<D>, thickness: f64, max_fraction: f64) -> bool {
    let old = gel.current_mesh();
    let moved = DeformedMesh { mesh: &old.mesh, position: &gel.engine.state().position };
    let adjacency = gel.adjacency.get_or_insert_with(|| face_neighbours::<D>(&old.mesh.elements));
    let thin = remesh::thin_elements(&moved, (&gel.engine.gel().surface.facets, adjacency), thickness);
    erode(gel, &old, &thin, max_fraction).unwrap_or(false)
}

/// Erodes these elements and [the parts that detach](remesh::with_detached_parts); returns true if elements were
/// removed.
///
/// Their mass, momentum and energy are booked in the ledger. The remaining mesh continues as after a remeshing
/// without new elements. Nothing is removed if a node would be left without mass.
///
/// # Errors
/// [`UnusableStep`] if the remaining mesh could not be stepped; nothing is removed then.
pub(super) fn erode<const D: usize>(
    gel: &mut AdaptiveGel<D>,
    old: &MeshInstance<D>,
    eroded: &[bool],
    max_fraction: f64,
) -> Result<bool, UnusableStep> {
    // The usual case.
    if !eroded.contains(&true) {
        return Ok(false);
    }
    let adjacency = gel.adjacency.get_or_insert_with(|| face_neighbours::<D>(&old.mesh.elements));
    let mass: Vec<f64> = old.corner_mass.iter().map(|corners| corners[..=D].iter().sum()).collect();
    let eroded = &remesh::with_detached_parts(adjacency, &mass, eroded, max_fraction);
    if !eroded.contains(&true) {
        return Ok(false);
    }
    let state = gel.engine.state();
    let remaining = RemainingMesh::of(old, gel.engine.last_tick(), &state.position, &state.velocity, eroded);
    if remaining.birth.mass.iter().any(|mass| *mass <= 0.0) {
        return Ok(false);
    }
    let eroded_energy = energy_of_elements(gel, old, eroded);
    let before = (state.ledger.momentum.remesh, state.ledger.angular_momentum.remesh);
    let RemainingMesh { mut birth, adjacency, same, velocity, eroded_mass } = remaining;
    let kept: Vec<ElementId> = same.iter().flatten().map(|same| same.element).collect();
    birth.patches = gel.engine.gel().potential.patches().restricted_to(&kept);
    let qualities = gel.definition.element_qualities(&birth.mesh.elements, &birth.position);
    let properties = MeshProperties { qualities, adjacency };
    let source = SourceMesh::after_loss(&gel.engine.gel().potential, old, &state.memory, &state.position, eroded);
    let MeshInstance { mesh: Mesh { rest, elements, .. }, position, .. } = &birth;
    let target = TargetMesh { position, rest, elements, same: &same, sources: &[], rule: ElasticAverage::default() };
    let Some((references, memory)) = inherited(&source, &state.position, &target, &birth.patches) else {
        return Ok(false);
    };
    birth.references = references;
    gel.install_mesh(birth, memory, velocity, properties)?;
    gel.engine.count_eroded_mass(eroded_mass);
    let ledger = gel.engine.ledger_mut();
    // The change of stored energy in the rest of a patch is booked as remeshing.
    ledger.energy.eroded -= eroded_energy;
    ledger.momentum.eroded += ledger.momentum.remesh.value() - before.0.value();
    ledger.angular_momentum.eroded += ledger.angular_momentum.remesh.value() - before.1.value();
    ledger.energy.remesh += eroded_energy;
    (ledger.momentum.remesh, ledger.angular_momentum.remesh) = before;
    Ok(true)
}

/// Kinetic and stored energy of these elements of the current mesh, J; that of a patch is shared by volume.
fn energy_of_elements<const D: usize>(gel: &AdaptiveGel<D>, old: &MeshInstance<D>, eroded: &[bool]) -> f64 {
    let (velocity, potential) = (&gel.engine.state().velocity, &gel.engine.gel().potential);
    let moving = |e: usize| -> f64 {
        let nodes = old.mesh.elements[e][..=D].iter().zip(&old.corner_mass[e]);
        nodes.map(|(node, mass)| 0.5 * mass * velocity[node.index()].norm_squared()).sum()
    };
    let kinetic: f64 = (0..eroded.len()).filter(|e| eroded[*e]).map(moving).sum();
    let energy = gel.engine.measure_at(gel.engine.now()).energy;
    let stored = potential.patches().iter().zip(energy).map(|(patch, energy)| {
        let volume = |ids: &mut dyn Iterator<Item = &ElementId>| -> f64 { ids.map(|id| potential.volume(*id)).sum() };
        let whole = volume(&mut patch.iter());
        energy * volume(&mut patch.iter().filter(|id| eroded[id.index()])) / whole
    });
    kinetic + stored.sum::<f64>()
}

impl<const D: usize> RemainingMesh<D> {
    fn of(
        old: &MeshInstance<D>,
        tick: crate::state::Tick,
        position: &[Vector<D>],
        velocity: &[Vector<D>],
        eroded: &[bool],
    ) -> Self {
        let kept: Vec<usize> = (0..eroded.len()).filter(|e| !eroded[*e]).collect();
        let mut mass = old.mass.clone();
        let mut lost = 0.0;
        for e in (0..eroded.len()).filter(|e| eroded[*e]) {
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
        let same = |e: &usize| Some(UnchangedElement::in_order(ElementId(*e as u32)));
        let adjacency = face_neighbours::<D>(&elements);
        let facets = boundary_from_neighbours::<D>(&elements, &adjacency);
        let held = nodes.iter().map(|n| old.mesh.held[*n]).collect();
        let marks = remaining_markers(old, &facets, &nodes);
        let birth = MeshInstance {
            tick,
            mesh: Mesh { rest: of_nodes(&old.mesh.rest), elements, facets, held, marks },
            position: of_nodes(position),
            mass: nodes.iter().map(|n| mass[*n]).collect(),
            corner_mass: kept.iter().map(|e| old.corner_mass[*e]).collect(),
            references: vec![],
            patches: ElementPatches::alone(kept.len()),
            parts: kept.iter().filter_map(|e| old.parts.get(*e).copied()).collect(),
            steps: vec![],
        };
        Self {
            birth,
            adjacency,
            same: kept.iter().map(same).collect(),
            velocity: of_nodes(velocity),
            eroded_mass: lost,
        }
    }
}

/// Load markers of the remaining facets; `nodes` are their nodes' old numbers. No load acts on facets that were
/// inside, but the air of a cavity that they adjoin.
fn remaining_markers<const D: usize>(old: &MeshInstance<D>, facets: &[Facet], nodes: &[usize]) -> Vec<u8> {
    if old.mesh.marks.is_empty() {
        return vec![];
    }
    let mut properties: Vec<(Facet, u8)> =
        old.mesh.facets.iter().map(|facet| sorted::<D>(*facet)).zip(old.mesh.marks.iter().copied()).collect();
    properties.sort_unstable();
    let was = |facet: &Facet| sorted::<D>(facet.map(|node| NodeId(nodes[node.index()] as u32)));
    let found = |facet: &Facet| {
        properties.binary_search_by_key(&was(facet), |(facet, _)| *facet).ok().map(|at| properties[at].1)
    };
    remesh::spread_cavity_mark::<D>(facets, &facets.iter().map(found).collect::<Vec<_>>())
}
