//! Ladder of runs: each knob, a setting that trades accuracy for speed, is turned both ways.

use super::importer::CouplingVariant;
use ballistic_gel::geometry::SignedDistance;
use ballistic_gel::scene::{
    CellLattice, ContactLaw, Dimension, ElementKind, GelShape, GradingSpec, OctreeSpec, Override, RemeshMethod,
    RemeshSpec, Scene, ScheduleKind,
};

/// Run of the ladder.
#[derive(Debug, Clone)]
pub struct LadderRung {
    /// Knob of the run; empty for the unmodified scene.
    pub knob: &'static str,
    /// Refinement: 0 for the unmodified scene, negative towards coarse.
    pub refinement: f64,
    /// Overrides of the scene.
    pub overrides: Vec<Override>,
    /// Coupling variant of the importer.
    pub importer: CouplingVariant,
    /// Size of all cells relative to the scene, in a mesh family with a limit of refinement.
    pub relative_size: Option<f64>,
    /// Expected cost, relative to the unmodified scene.
    pub expected_cost: f64,
}

/// Name of the knob that refines all of the mesh.
pub const MESH: &str = "mesh";
/// Name of the knob that refines a remeshed version of a scene whose own mesh cannot follow.
pub const REMESHED: &str = "mesh, remeshed";
/// Remeshing criterion of the remeshed family.
const REMESH_CRITERION: (&str, f64) = ("remesh.quality", 0.3);

/// Refinement of the coarsest meshes.
const COARSEST: i32 = -2;
const COARSEST_REMESHED: i32 = -4;

impl LadderRung {
    /// Returns the rung of the unmodified scene.
    pub fn unmodified() -> Self {
        Self {
            knob: "",
            refinement: 0.0,
            overrides: vec![],
            importer: CouplingVariant::default(),
            relative_size: Some(1.0),
            expected_cost: 1.0,
        }
    }

    /// Describes the overrides as on the command line.
    pub fn label(&self) -> String {
        let set = self.overrides.iter().map(|o| format!("{}={}", o.key, o.value));
        let who =
            (self.importer != CouplingVariant::Integrated).then(|| format!("coupling.mode={}", self.importer.as_str()));
        let all: Vec<String> = set.chain(who).collect();
        if all.is_empty() { "as it comes".to_owned() } else { all.join(" ") }
    }
}

/// Returns all rungs except the unmodified scene; `steps` counts the refinements of all edges by √2.
pub fn ladder(scene: &Scene, steps: u32, has_failed: HasFailed) -> Vec<LadderRung> {
    let knobs = [
        contact_size_rungs,
        grading_rungs,
        time_rungs,
        schedule_rungs,
        element_rungs,
        contact_rungs,
        bulk_rungs,
        dimension_rungs,
        remeshing_rungs,
        coupling_rungs,
    ];
    let turned = knobs.into_iter().flat_map(|knob| knob(scene));
    mesh_rungs(scene, steps, has_failed).into_iter().chain(turned).collect()
}

/// Lists the knobs of a scene except its mesh.
pub fn knobs(scene: &Scene) -> Vec<&'static str> {
    let all = ladder(scene, 1, HasFailed::No).into_iter().map(|rung| rung.knob);
    let mut knobs: Vec<_> = all.filter(|knob| !knob.starts_with(MESH)).collect();
    knobs.dedup();
    knobs
}

/// Outcome of the unmodified scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HasFailed {
    /// The run stopped early.
    Yes,
    /// The run reached its end time.
    No,
}

fn new_override(key: &str, value: impl std::fmt::Debug) -> Override {
    Override { key: key.to_owned(), value: format!("{value:?}") }
}

/// Rounds a length to four digits.
fn round_length(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

fn single_rung(knob: &'static str, refinement: f64, overrides: Vec<Override>, expected_cost: f64) -> LadderRung {
    LadderRung {
        knob,
        refinement,
        overrides,
        expected_cost,
        ..LadderRung { relative_size: None, ..LadderRung::unmodified() }
    }
}

/// Estimates the element updates of a mesh of size f, relative to size 1.
fn mesh_cost(scene: &Scene, f: f64) -> f64 {
    let dimension = if scene.scene.dimension == Dimension::Spatial { 3 } else { 2 };
    f.powi(-dimension - 1)
}

/// Returns rungs with the whole mesh finer and coarser by √2, including the grading.
///
/// A scene that has failed gets a remeshed family, too. Remeshed families reach down to cells four times as long, since
/// their limit needs meshes of twice and four times the finest edges.
fn mesh_rungs(scene: &Scene, steps: u32, has_failed: HasFailed) -> Vec<LadderRung> {
    let refined = |knob: &'static str, coarsest: i32, extra: Option<Override>| {
        let all = (coarsest..=steps.cast_signed())
            .map(f64::from)
            .filter(move |refinement| *refinement != 0.0 || knob != MESH);
        all.map(move |refinement| {
            let f = 2f64.powf(-0.5 * refinement);
            let overrides = extra.clone().into_iter().chain(scale_mesh(scene, f)).collect();
            // A remeshed mesh counts as finer than the scene's own.
            let refinement = if knob == MESH { refinement } else { refinement + 0.25 };
            LadderRung { relative_size: Some(f), ..single_rung(knob, refinement, overrides, mesh_cost(scene, f)) }
        })
    };
    let is_remeshed = scene.remesh.is_some();
    let needs_remeshing = has_failed == HasFailed::Yes && !is_remeshed;
    let remeshed = needs_remeshing
        .then(|| refined(REMESHED, COARSEST_REMESHED, Some(new_override(REMESH_CRITERION.0, REMESH_CRITERION.1))));
    let graded = if remeshed.is_none() { graded_rungs(scene, steps) } else { vec![] };
    let coarsest = if is_remeshed { COARSEST_REMESHED } else { COARSEST };
    refined(MESH, coarsest, None).chain(remeshed.into_iter().flatten()).chain(graded).collect()
}

/// Scales every edge of the mesh by f; the number of cells in a graded zone stays.
fn scale_mesh(scene: &Scene, f: f64) -> Vec<Override> {
    if f == 1.0 {
        return vec![];
    }
    let mut all = vec![new_override("mesh.size", round_length(f * scene.mesh.size))];
    if let Some(GradingSpec { growth, largest, .. }) = scene.mesh.grading {
        all.push(new_override("mesh.grading.growth", round_length(growth.powf(f))));
        all.push(new_override("mesh.grading.largest", round_length(f * largest)));
    }
    if let Some(OctreeSpec { slope, .. }) = scene.mesh.tree {
        all.push(new_override("mesh.tree.slope", round_length(f * slope)));
    }
    if let Some(RemeshSpec { smallest, tip_size: tip, growth, .. }) = &scene.remesh {
        all.extend(smallest.map(|smallest| new_override("remesh.smallest", round_length(f * smallest))));
        all.extend(tip.map(|tip| new_override("remesh.tip_size", round_length(f * tip))));
        all.push(new_override("remesh.growth", round_length((f * growth).min(1.0))));
    }
    all
}

/// Returns rungs of a graded mesh for a scene with a uniform one: from 2.5 radii of the projectile on, cells double up
/// to a size of 2.5 radii.
fn graded_rungs(scene: &Scene, steps: u32) -> Vec<LadderRung> {
    let free = scene.mesh.grading.is_none() && scene.mesh.tree.is_none();
    let shape = matches!(scene.gel.shape, GelShape::Block { .. } | GelShape::Cylinder { bore: None, .. });
    let radius = scene.shape(0).inner_radius();
    if !(free && shape && radius.is_finite()) {
        return vec![];
    }
    let core = round_length(2.5 * radius);
    let rung = |refinement: i32| {
        let f = 2f64.powf(-0.5 * f64::from(refinement));
        let size = round_length(f * scene.mesh.size);
        let grading = format!("{{core = {core:?}, growth = 2.0, largest = {:?}}}", core.max(size));
        let grading = Override { key: "mesh.grading".to_owned(), value: grading };
        let overrides = scale_mesh(scene, f).into_iter().chain([grading]).collect();
        single_rung("mesh, graded", f64::from(refinement) - 0.5, overrides, 0.4 * mesh_cost(scene, f))
    };
    (-2..=steps.cast_signed()).map(rung).collect()
}

/// Returns rungs with a finer and a coarser mesh at the projectile only.
fn contact_size_rungs(scene: &Scene) -> Vec<LadderRung> {
    let size = scene.mesh.size;
    let rung = |refinement: f64, f: f64, coarsest: Option<usize>| {
        let tree = coarsest.map(|coarsest| new_override("mesh.tree.coarsest", coarsest));
        let smallest = scene.remesh.as_ref().and_then(|remesh| remesh.smallest);
        let smallest = smallest.map(|smallest| new_override("remesh.smallest", round_length(f * smallest)));
        let edge = new_override("mesh.size", round_length(f * size));
        single_rung("contact size", refinement, [edge].into_iter().chain(tree).chain(smallest).collect(), 1.0 / f)
    };
    match (scene.mesh.grading, scene.mesh.tree) {
        (Some(_), _) => vec![rung(-1.0, 1.5, None), rung(1.0, 0.667, None)],
        (None, Some(tree)) if tree.coarsest >= 4 => {
            vec![rung(-1.0, 2.0, Some(tree.coarsest / 2)), rung(1.0, 0.5, Some(2 * tree.coarsest))]
        }
        (None, Some(_) | None) => vec![],
    }
}

/// Returns rungs with a different growth of cells; the finest cells stay.
fn grading_rungs(scene: &Scene) -> Vec<LadderRung> {
    let rung = |refinement: f64, f: f64| {
        let grading =
            scene.mesh.grading.map(|g| new_override("mesh.grading.growth", round_length(1.0 + f * (g.growth - 1.0))));
        let tree = scene.mesh.tree.map(|tree| new_override("mesh.tree.slope", round_length(f * tree.slope)));
        let remesh = scene
            .remesh
            .as_ref()
            .map(|remesh| new_override("remesh.growth", round_length((f * remesh.growth).min(1.0))));
        let all: Vec<Override> = grading.into_iter().chain(tree).chain(remesh).collect();
        (!all.is_empty()).then(|| single_rung("grading", refinement, all, 1.0 / f))
    };
    [rung(-2.0, 2.0), rung(-1.0, 1.5), rung(1.0, 0.667)].into_iter().flatten().collect()
}

/// Returns rungs with a different fraction of the stable time step.
fn time_rungs(scene: &Scene) -> Vec<LadderRung> {
    let own = scene.integrator.cfl();
    let rung = |refinement: f64, cfl: f64| {
        single_rung("cfl", refinement, vec![new_override("integrator.cfl", round_length(cfl))], own / cfl)
    };
    let faster = (own < 1.0).then(|| rung(-1.0, 1.0));
    faster.into_iter().chain([rung(1.0, 0.5 * own), rung(2.0, 0.25 * own)]).collect()
}

/// Returns a rung with one global stable step instead of binned local time steps.
fn schedule_rungs(scene: &Scene) -> Vec<LadderRung> {
    let bins = scene.integrator.schedule == ScheduleKind::Bins;
    bins.then(|| single_rung("schedule", 1.0, vec![new_override("integrator.schedule", "global")], 4.0))
        .into_iter()
        .collect()
}

/// Returns rungs with the other kind of element on three mesh sizes, and with the Kuhn lattice if possible.
fn element_rungs(scene: &Scene) -> Vec<LadderRung> {
    let (other, refinement) = match scene.mesh.element {
        ElementKind::Plain => ("patch", 0.125),
        ElementKind::Patch => ("plain", -0.125),
    };
    let round = scene.scene.dimension == Dimension::Spatial && matches!(scene.gel.shape, GelShape::Cylinder { .. });
    let plain = scene.mesh.tree.is_none() && scene.mesh.lattice == CellLattice::Centred && !round;
    let lattice = plain.then(|| single_rung("lattice", -1.0, vec![new_override("mesh.lattice", "kuhn")], 0.5));
    // Three sizes tell an accurate element from one that meets the limit by chance on one mesh.
    let sizes = [-1.0, 0.0, 1.0].map(|finer: f64| (refinement + finer, 2f64.powf(-0.5 * finer)));
    let rung = |(refinement, f): (f64, f64)| {
        let other = new_override("mesh.element", other);
        single_rung(
            "element",
            refinement,
            [other].into_iter().chain(scale_mesh(scene, f)).collect(),
            mesh_cost(scene, f),
        )
    };
    sizes.map(rung).into_iter().chain(lattice).collect()
}

/// Returns rungs with different coefficients of restitution.
fn contact_rungs(scene: &Scene) -> Vec<LadderRung> {
    if scene.contact.law != ContactLaw::Moreau || scene.contact.restitution > 0.0 {
        return vec![];
    }
    let rung = |refinement: f64, e: f64| {
        single_rung("restitution", refinement, vec![new_override("contact.restitution", e)], 1.0)
    };
    vec![rung(-2.0, 1.0), rung(-1.0, 0.5)]
}

/// Returns rungs with a different bulk modulus: slower pressure waves allow longer steps.
fn bulk_rungs(scene: &Scene) -> Vec<LadderRung> {
    let own = scene.gel.bulk_modulus;
    let rung = |refinement: f64, f: f64| {
        single_rung("bulk modulus", refinement, vec![new_override("gel.bulk_modulus", round_length(f * own))], f.sqrt())
    };
    // Poisson's ratio is positive from K = 2/3 G on.
    let stiff = |f: f64| f * own > 0.7 * scene.gel.shear_modulus;
    [(-2.0, 0.25), (-1.0, 0.5), (1.0, 2.0)]
        .into_iter()
        .filter(|turned| stiff(turned.1))
        .map(|(refinement, f)| rung(refinement, f))
        .collect()
}

/// Returns a rung that models an axisymmetric gel in three dimensions, on cells twice as long that grow by half.
fn dimension_rungs(scene: &Scene) -> Vec<LadderRung> {
    let about = scene.scene.dimension == Dimension::Axisymmetric && scene.remesh.is_none();
    let GelShape::Cylinder { radius, bore: None, .. } = scene.gel.shape else { return vec![] };
    if !about {
        return vec![];
    }
    let size = round_length(2.0 * scene.mesh.size);
    let core = scene.mesh.grading.map_or(10.0 * size, |grading| grading.core);
    let grading = format!("{{core = {core:?}, growth = 1.5, largest = {:?}}}", round_length(radius / 6.0));
    let grading = Override { key: "mesh.grading".to_owned(), value: grading };
    // Single linear tetrahedra lock.
    let patch = new_override("mesh.element", "patch");
    vec![single_rung(
        "dimension",
        -1.0,
        vec![new_override("scene.dimension", "spatial"), patch, new_override("mesh.size", size), grading],
        15.0,
    )]
}

/// Returns rungs with different remeshing criteria.
fn remeshing_rungs(scene: &Scene) -> Vec<LadderRung> {
    let rung =
        |refinement: f64, key: &str, value: f64| single_rung("remesh", refinement, vec![new_override(key, value)], 1.0);
    let Some(remesh) = &scene.remesh else { return vec![] };
    let flat = scene.scene.dimension != Dimension::Spatial;
    let cut = flat && remesh.method == RemeshMethod::Local && remesh.erosion_thickness.is_none();
    let cut = cut.then(|| single_rung("remesh", -3.0, vec![new_override("remesh.method", "immersed")], 1.0));
    let quality = [(-1.0, 0.667), (1.0, 1.333)]
        .map(|(refinement, f)| rung(refinement, "remesh.quality", round_length(f * remesh.quality)));
    let bend = (remesh.adaptive && remesh.curvature_angle < 120.0).then(|| rung(-2.0, "remesh.curvature_angle", 180.0));
    quality.into_iter().chain(bend).chain(cut).collect()
}

/// Returns rungs with a longer communication step and with other coupling variants.
fn coupling_rungs(scene: &Scene) -> Vec<LadderRung> {
    let own = scene.scene.communication_step;
    let rung = |refinement: f64, f: f64| {
        single_rung("coupling", refinement, vec![new_override("scene.communication_step", round_length(f * own))], 1.0)
    };
    let owned = |refinement: f64, importer| LadderRung { importer, ..single_rung("coupling", refinement, vec![], 1.0) };
    let mut all = vec![rung(-1.0, 10.0)];
    if !scene.projectile.fixed {
        all.extend([owned(-2.0, CouplingVariant::Corrected), owned(-3.0, CouplingVariant::Prescribed)]);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{HasFailed, LadderRung, MESH, REMESHED, ladder};
    use ballistic_gel::scene::{self, Scene};

    fn scene(name: &str) -> Scene {
        scene::read(scene::builtin(name).unwrap()).unwrap()
    }

    fn rungs(name: &str, has_failed: HasFailed) -> Vec<LadderRung> {
        ladder(&scene(name), 3, has_failed)
    }

    #[test]
    fn every_rung_of_every_builtin_scene_is_a_scene() {
        for (name, text) in scene::builtins() {
            for rung in rungs(name, HasFailed::No) {
                let read = scene::resolve(text, &rung.overrides).and_then(|text| scene::read(&text));
                let coarse = rung.refinement < 0.0;
                assert!(read.is_ok() || coarse, "{name}: {}: {}", rung.label(), read.unwrap_err());
            }
        }
    }

    #[test]
    fn cells_are_refined_everywhere_or_where_the_projectile_is() {
        let all = rungs("ball-bounce", HasFailed::No);
        let find = |knob: &str, refinement: f64| {
            all.iter().find(|r| r.knob == knob && r.refinement == refinement).unwrap().label()
        };
        let finer = "mesh.size=0.0005 mesh.grading.growth=1.072 mesh.grading.largest=0.003";
        assert_eq!(find(MESH, 2.0), finer);
        assert_eq!(find("contact size", 1.0), "mesh.size=0.000667");
    }

    #[test]
    fn a_failed_scene_without_remeshing_gets_a_remeshed_family() {
        let count = |has_failed| rungs("ball-square", has_failed).iter().filter(|rung| rung.knob == REMESHED).count();
        assert_eq!((count(HasFailed::No), count(HasFailed::Yes)), (0, 8));
    }
}
