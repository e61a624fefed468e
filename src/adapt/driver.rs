//! Remeshing driver: replaces a distorted mesh, and continues the run on the new one (method 4, A12).
//!
//! The integrator ends a mesh at a tick at which an element is distorted or a remeshing is due, and the driver follows.
//! First the elements that hinder are remade by local operations. Where these do not suffice, or are not asked for, the
//! immersed method makes a mesh in the plane and about an axis: an attempt makes a candidate of the target sizes, tests
//! its quality and its area, transfers mass, momentum and history variables to it, and tests its stable steps; the first
//! candidate that passes continues the run. Where all are refused, gel is eroded (its energy is the account `eroded`) and
//! all this is repeated; at last the run continues on the old mesh. The change of energy by a remeshing is the account
//! `remesh`.

use super::adaptive_gel::{AdaptiveGel, MeshProperties};
use super::attempt::{MeshGenerator, SIZE_FACTORS, generate_mesh};
use super::candidate::{CandidateMesh, OldMeshData, RemeshInput, generate_candidate, old_mesh_data};
use super::erosion::{MAX_ERODED_FRACTION, MAX_EROSIONS, erode_thin_gel};
use super::erosion_on_failure::erode_on_failure;
use super::local_edits::{EditedGel, candidate_of, edit_mesh};
use super::preview::{RemeshTrial, try_remesh};
use super::record::RemeshRecord;
use super::refusal::{FailedRemesh, RemeshRefusal};
use super::settings::{AdaptSettings, RemeshMethod};
use super::sizes::target_sizes;
use crate::fem::Potential;
use crate::integrator::{BalanceTotals, StepError, UnusableStep};
use crate::remesh::DeformedMesh;
use crate::state::{DynamicState, MeshInstance};
use std::time::Instant;

/// Gel whose mesh can be replaced.
pub(crate) trait RemeshDriver {
    /// Continues with a better mesh, or with the old one, perhaps eroded, where no candidate is accepted.
    ///
    /// # Errors
    /// [`StepError`] if the energy of the run has diverged, if a mesh failed as soon as it had begun, or if not even the
    /// old mesh can be stepped.
    fn remesh(&mut self) -> Result<(), StepError>;

    /// Tries a remeshing now by each method, for its pictures, without changing the gel; `None` in space, where there is
    /// one method alone, and for a scene without remeshing.
    fn try_remesh(&self) -> Option<RemeshTrial>;
}

impl RemeshDriver for AdaptiveGel<2> {
    fn remesh(&mut self) -> Result<(), StepError> {
        remesh_with(self, Some(generate_mesh))
    }

    fn try_remesh(&self) -> Option<RemeshTrial> {
        Some(try_remesh(self, self.definition.remesh.as_ref()?))
    }
}

impl RemeshDriver for AdaptiveGel<3> {
    fn remesh(&mut self) -> Result<(), StepError> {
        remesh_with(self, None)
    }

    fn try_remesh(&self) -> Option<RemeshTrial> {
        None
    }
}

/// Thickness, as a fraction of the least edge, below which gel is eroded when every new mesh is refused, regardless
/// of the scene. Opposite walls may pinch gel to no thickness (1e-10 m has occurred), and remeshing does not thicken
/// gel.
const PINCH_FRACTION: f64 = 0.01;
/// Ratio of the energy to the energy provided, above which a run has diverged.
const RUNAWAY_RATIO: f64 = 10.0;

/// Greatest gain of energy by a whole new mesh, as a fraction of the energy provided.
const MAX_ENERGY_GAIN: f64 = 0.01;

/// Failed replacement of a mesh.
struct FailedReplacement {
    /// Reasons why each candidate was refused.
    reasons: Vec<RemeshRefusal>,
    /// Data of the old mesh.
    data: OldMeshData,
}

/// Elements from which a remeshing is shared among threads, in two dimensions and in space. Assumed, between what was
/// measured: a tenth more time of `fbi-bb` (4 000, in the plane), a quarter less of `fbi-bb-3d` (24 000).
const MIN_SHARED_ELEMENTS: [usize; 2] = [32_768, 2_048];

/// Remeshes on the threads of the gel: see [`find_next_mesh`].
fn remesh_with<const D: usize>(gel: &mut AdaptiveGel<D>, generator: Option<MeshGenerator<D>>) -> Result<(), StepError> {
    let is_shared = gel.engine.gel().potential.len() >= MIN_SHARED_ELEMENTS[D - 2];
    match gel.engine.pool().filter(|_| is_shared) {
        Some(pool) => pool.run(|| find_next_mesh(gel, generator)),
        None => find_next_mesh(gel, generator),
    }
}

/// Remeshes: candidates, then erosion and further candidates, then the old mesh. There is no generator in space.
fn find_next_mesh<const D: usize>(
    gel: &mut AdaptiveGel<D>,
    generator: Option<MeshGenerator<D>>,
) -> Result<(), StepError> {
    let Some(settings) = gel.definition.remesh else { return Ok(()) };
    let begun = Instant::now();
    if gel.engine.state().birth.is_none() {
        gel.first_mesh = Some(gel.current_mesh());
    }
    if let Some(diverged) = check_divergence(gel) {
        return Err(diverged);
    }
    // Another mesh would fail at once, too, for the same elements, unless they are eroded.
    if let Some(failure) = gel.engine.early_failure().cloned()
        && !erode_on_failure(gel, &[])
    {
        return Err(failure);
    }
    // Thin sheets are eroded, whatever their share of the gel; they stay if the rest had no stable step without them.
    if let Some(below) = settings.erosion_thickness {
        erode_thin_gel(gel, below, 1.0);
    }
    let mut outcome = replace_mesh(gel, generator, &settings, begun);
    if outcome.is_err() && erode_thin_gel(gel, PINCH_FRACTION * settings.least, MAX_ERODED_FRACTION) {
        outcome = replace_mesh(gel, generator, &settings, begun);
    }
    for _ in 0..MAX_EROSIONS {
        match &outcome {
            Err(failed) if erode_on_failure(gel, &failed.reasons) => {
                outcome = replace_mesh(gel, generator, &settings, begun);
            }
            _ => break,
        }
    }
    let Err(FailedReplacement { reasons, data }) = outcome else { return Ok(()) };
    let time = gel.engine.now();
    gel.failed_remeshes.push(FailedRemesh { time, why: reasons });
    // The failure of this mesh at its last tick, unless erosion has removed the failed elements.
    if let Some(failure) = gel.engine.failure() {
        return Err(failure.clone());
    }
    keep_mesh(gel, data).map_err(|UnusableStep { step, .. }| StepError::NoUsableMesh { time, step })
}

/// Error of a run whose energy far exceeds the initial energy and the work done on it. Without this check a
/// diverging run refuses new meshes at length: a ball of 23 m/s once reached 1e223 m.
fn check_divergence<const D: usize>(gel: &AdaptiveGel<D>) -> Option<StepError> {
    let time = gel.engine.now();
    let BalanceTotals { energies, ledger, initial_energy, .. } = gel.engine.totals(time);
    let provided = ledger.energy.provided(initial_energy);
    let part = energies.discrete() / provided;
    (provided > gel.definition.energy_round_off(gel.mass()) && part > RUNAWAY_RATIO)
        .then_some(StepError::Diverged { time, part })
}

/// Continues with a better mesh of the current gel; `begun` is when the remeshing began.
///
/// # Errors
/// [`FailedReplacement`] if every candidate was refused.
fn replace_mesh<const D: usize>(
    gel: &mut AdaptiveGel<D>,
    generator: Option<MeshGenerator<D>>,
    settings: &AdaptSettings,
    begun: Instant,
) -> Result<(), FailedReplacement> {
    let old = gel.current_mesh();
    let position = gel.engine.state().position.clone();
    let moved = DeformedMesh { mesh: &old.mesh, position: &position };
    // Neighbours are those of the mesh that is installed next.
    let adjacency = gel.adjacency.take();
    let data = old_mesh_data(gel, &moved, adjacency);
    let mut reasons = vec![];
    let edit_input = RemeshInput { old: &old, moved: &moved, data: &data, size: &[] };
    let mut edited = (settings.method == RemeshMethod::Local).then(|| edit_mesh(gel, &old, settings));
    if let Some(edited) = edited.take_if(|edited| edited.is_sufficient(gel)) {
        match install_edited(gel, &edit_input, edited, begun) {
            Ok(()) => return Ok(()),
            Err(why) => reasons.push(why),
        }
    }
    if let Some(generator) = generator {
        match install_first(gel, &edit_input, settings, generator, begun) {
            Ok(()) => return Ok(()),
            Err(why) => reasons.extend(why),
        }
    }
    match edited {
        Some(edited) if edited.is_upright() => match install_edited(gel, &edit_input, edited, begun) {
            Ok(()) => return Ok(()),
            Err(why) => reasons.push(why),
        },
        Some(edited) => reasons.push(edited.refusal()),
        None => {}
    }
    Err(FailedReplacement { reasons, data })
}

/// Continues with the first mesh of a generator that is accepted; `begun` is when the remeshing began.
///
/// # Errors
/// Reasons why each attempt was refused.
fn install_first<const D: usize>(
    gel: &mut AdaptiveGel<D>,
    input: &RemeshInput<'_, D>,
    settings: &AdaptSettings,
    generator: MeshGenerator<D>,
    begun: Instant,
) -> Result<(), Vec<RemeshRefusal>> {
    let size = target_sizes(gel, input.moved, settings, &input.data.adjacency);
    let input = RemeshInput { size: &size, ..*input };
    let mut reasons = vec![];
    // In the place of operations that fail a finer mesh seldom succeeds, where one of these sizes does not.
    let n_attempts = if settings.method == RemeshMethod::Local { 1 } else { SIZE_FACTORS.len() };
    for (size_factor, number) in SIZE_FACTORS.into_iter().zip(1..).take(n_attempts) {
        let installed = generate_candidate(gel, &input, generator, size_factor)
            .and_then(|candidate| install_candidate(gel, candidate, number, begun));
        match installed {
            Ok(()) => return Ok(()),
            Err(why) => reasons.push(why),
        }
    }
    Err(reasons)
}

/// Continues with a candidate mesh of this attempt, from 1; `begun` is when the remeshing began. The energy that operations or
/// the averages of a two-network gel took returns to the motion of the new elements.
///
/// # Errors
/// [`RemeshRefusal`] if the mesh has no valid step, or is a whole new one with too much energy.
fn install_candidate<const D: usize>(
    gel: &mut AdaptiveGel<D>,
    candidate: CandidateMesh<D>,
    attempt: usize,
    begun: Instant,
) -> Result<(), RemeshRefusal> {
    let mut record = record_of(&candidate, gel.engine.now(), attempt);
    let booked = gel.engine.state().ledger.energy.remesh;
    let (new_elements, is_edited) = (candidate.new_elements_with_masses(), candidate.edits.is_some());
    let CandidateMesh { birth, memory, velocity, properties, .. } = candidate;
    let engine = gel.engine_on_mesh(birth, memory, velocity).map_err(RemeshRefusal::Steps)?;
    let gained = engine.state().ledger.energy.remesh - booked;
    let limit = greatest_gain(gel);
    // After operations only the old mesh is left, which is distorted: they are not refused.
    if gained > limit && !is_edited {
        return Err(RemeshRefusal::Energy { gained, limit });
    }
    gel.install_engine(engine, properties);
    gel.engine.count_remesh();
    if gel.has_networks() || is_edited {
        gel.engine.return_energy(&new_elements, booked - gel.engine.state().ledger.energy.remesh);
    }
    record.energy = gel.engine.state().ledger.energy.remesh - booked;
    record.seconds = begun.elapsed().as_secs_f64();
    gel.remesh_records.push(record);
    Ok(())
}

/// Greatest energy that a whole new mesh may gain, J.
fn greatest_gain<const D: usize>(gel: &AdaptiveGel<D>) -> f64 {
    let BalanceTotals { provided, .. } = gel.engine.totals(gel.engine.now());
    let round_off = gel.definition.energy_round_off(gel.mass());
    (MAX_ENERGY_GAIN * provided.total()).max(round_off)
}

/// Continues with the mesh after local operations; `begun` is when the remeshing began.
fn install_edited<const D: usize>(
    gel: &mut AdaptiveGel<D>,
    input: &RemeshInput<'_, D>,
    edited: EditedGel<D>,
    begun: Instant,
) -> Result<(), RemeshRefusal> {
    let candidate = candidate_of(gel, input, edited)?;
    install_candidate(gel, candidate, 1, begun)
}

/// Continues with the old mesh, as after a remeshing that leaves every element unchanged.
fn keep_mesh<const D: usize>(gel: &mut AdaptiveGel<D>, data: OldMeshData) -> Result<(), UnusableStep> {
    let OldMeshData { adjacency, qualities } = data;
    let old = gel.current_mesh();
    let DynamicState { position, velocity, memory, .. } = gel.engine.state().clone();
    let birth = MeshInstance { tick: gel.engine.last_tick(), position, ..(*old).clone() };
    gel.install_mesh(birth, memory, velocity, MeshProperties { qualities, adjacency })
}

/// Record of a candidate on which the run continues.
fn record_of<const D: usize>(candidate: &CandidateMesh<D>, time: f64, attempt: usize) -> RemeshRecord {
    let CandidateMesh { birth, quality, defects, edits, .. } = candidate;
    RemeshRecord {
        time,
        attempt,
        quality: *quality,
        mass: defects.relative_mass(),
        momentum: defects.momentum_defect().norm(),
        kinetic: [defects.before.kinetic, defects.after.kinetic],
        energy: 0.0,
        elements: birth.mesh.elements.len(),
        unchanged: defects.unchanged,
        edits: edits.unwrap_or_default(),
        seconds: 0.0,
    }
}
