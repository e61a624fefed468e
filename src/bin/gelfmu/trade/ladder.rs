//! Which runs make the curve: every knob of a scene that buys speed, turned both ways.

use super::importer::Importer;
use ballistic_gel::geometry::SignedDistance;
use ballistic_gel::scene::{
    ContactLaw, Dimension, ElementKind, GelShape, Grading, Lattice, Override, Remesh, RemeshMethod, Scene,
    ScheduleKind, Tree,
};

/// A run that is asked for.
#[derive(Debug, Clone)]
pub struct Rung {
    /// What is turned; nothing for the scene as it comes.
    pub knob: &'static str,
    /// How far towards fine: the scene as it comes is at 0, coarser is below.
    pub place: f64,
    /// What is written over the scene.
    pub overrides: Vec<Override>,
    /// Who moves the projectile.
    pub importer: Importer,
    /// Edges of all cells relative to those of the scene, in a family that refinement extrapolates.
    pub size: Option<f64>,
    /// Guess of the cost, in runs of the scene as it comes.
    pub guess: f64,
}

/// The name of the knob that refines all of the mesh.
pub const MESH: &str = "mesh";
/// The same with a mesh that is exchanged, of a scene whose own mesh cannot follow.
pub const REMESHED: &str = "mesh, exchanged";
/// What `remesh` is where a scene has none.
const EXCHANGED: (&str, f64) = ("remesh.quality", 0.3);

/// Places of the coarsest meshes.
const COARSEST: i32 = -2;
const COARSEST_EXCHANGED: i32 = -4;

impl Rung {
    /// The scene as it comes.
    pub fn base() -> Self {
        Self { knob: "", place: 0.0, overrides: vec![], importer: Importer::default(), size: Some(1.0), guess: 1.0 }
    }

    /// What was turned, as on the command line.
    pub fn label(&self) -> String {
        let set = self.overrides.iter().map(|o| format!("{}={}", o.key, o.value));
        let who = (self.importer != Importer::Integrated).then(|| format!("coupling.mode={}", self.importer.as_str()));
        let all: Vec<String> = set.chain(who).collect();
        if all.is_empty() { "as it comes".to_owned() } else { all.join(" ") }
    }
}

/// All runs beside that of the scene as it comes; `steps` is how often edges are refined by √2 beyond it.
pub fn ladder(scene: &Scene, steps: u32, has_failed: HasFailed) -> Vec<Rung> {
    let knobs = [contact_size, grading, time, schedule, element, contact, bulk, dimension, remeshing, coupling];
    let turned = knobs.into_iter().flat_map(|knob| knob(scene));
    meshes(scene, steps, has_failed).into_iter().chain(turned).collect()
}

/// The knobs of a scene beside its mesh.
pub fn knobs(scene: &Scene) -> Vec<&'static str> {
    let all = ladder(scene, 1, HasFailed::No).into_iter().map(|rung| rung.knob);
    let mut knobs: Vec<_> = all.filter(|knob| !knob.starts_with(MESH)).collect();
    knobs.dedup();
    knobs
}

/// How the scene as it comes ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HasFailed {
    /// It stopped early.
    Yes,
    /// It reached its end.
    No,
}

fn set(key: &str, value: impl std::fmt::Debug) -> Override {
    Override { key: key.to_owned(), value: format!("{value:?}") }
}

/// Four digits, as one writes it.
fn length(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

fn rung(knob: &'static str, place: f64, overrides: Vec<Override>, guess: f64) -> Rung {
    Rung { knob, place, overrides, guess, ..Rung { size: None, ..Rung::base() } }
}

/// Updates of elements and steps of size f, relative to those of size 1.
fn cost_of(scene: &Scene, f: f64) -> f64 {
    let dimension = if scene.scene.dimension == Dimension::Spatial { 3 } else { 2 };
    f.powi(-dimension - 1)
}

/// All of the mesh finer and coarser by √2, its grading with it; a scene that has failed also with a mesh that is exchanged. From that
/// on to cells four times as long: a limit needs two meshes of twice and four times the edges of the finest.
fn meshes(scene: &Scene, steps: u32, has_failed: HasFailed) -> Vec<Rung> {
    let refined = |knob: &'static str, coarsest: i32, extra: Option<Override>| {
        let all = (coarsest..=steps.cast_signed()).map(f64::from).filter(move |place| *place != 0.0 || knob != MESH);
        all.map(move |place| {
            let f = 2f64.powf(-0.5 * place);
            let overrides = extra.clone().into_iter().chain(scaled(scene, f)).collect();
            // The mesh of the scene itself is no finer than one that is exchanged.
            let place = if knob == MESH { place } else { place + 0.25 };
            Rung { size: Some(f), ..rung(knob, place, overrides, cost_of(scene, f)) }
        })
    };
    let is_exchanged = scene.remesh.is_some();
    let exchanged = has_failed == HasFailed::Yes && !is_exchanged;
    let exchanged = exchanged.then(|| refined(REMESHED, COARSEST_EXCHANGED, Some(set(EXCHANGED.0, EXCHANGED.1))));
    let graded = if exchanged.is_none() { graded(scene, steps) } else { vec![] };
    let coarsest = if is_exchanged { COARSEST_EXCHANGED } else { COARSEST };
    refined(MESH, coarsest, None).chain(exchanged.into_iter().flatten()).chain(graded).collect()
}

/// Every edge, everywhere, so many times as long: where cells grow, they do so in as many cells.
fn scaled(scene: &Scene, f: f64) -> Vec<Override> {
    if f == 1.0 {
        return vec![];
    }
    let mut all = vec![set("mesh.size", length(f * scene.mesh.size))];
    if let Some(Grading { growth, largest, .. }) = scene.mesh.grading {
        all.push(set("mesh.grading.growth", length(growth.powf(f))));
        all.push(set("mesh.grading.largest", length(f * largest)));
    }
    if let Some(Tree { slope, .. }) = scene.mesh.tree {
        all.push(set("mesh.tree.slope", length(f * slope)));
    }
    if let Some(Remesh { smallest, tip, growth, .. }) = &scene.remesh {
        all.extend(smallest.map(|smallest| set("remesh.smallest", length(f * smallest))));
        all.extend(tip.map(|tip| set("remesh.tip", length(f * tip))));
        all.push(set("remesh.growth", length((f * growth).min(1.0))));
    }
    all
}

/// Cells that grow away from where the projectile enters, in a scene whose cells do not: by two from one to the next, beyond 2.5
/// radii, up to that length.
fn graded(scene: &Scene, steps: u32) -> Vec<Rung> {
    let free = scene.mesh.grading.is_none() && scene.mesh.tree.is_none();
    let shape = matches!(scene.gel.shape, GelShape::Block { .. } | GelShape::Cylinder { bore: None, .. });
    let radius = scene.shape(0).inner_radius();
    if !(free && shape && radius.is_finite()) {
        return vec![];
    }
    let core = length(2.5 * radius);
    let one = |place: i32| {
        let f = 2f64.powf(-0.5 * f64::from(place));
        let size = length(f * scene.mesh.size);
        let grading = format!("{{core = {core:?}, growth = 2.0, largest = {:?}}}", core.max(size));
        let grading = Override { key: "mesh.grading".to_owned(), value: grading };
        let overrides = scaled(scene, f).into_iter().chain([grading]).collect();
        rung("mesh, graded", f64::from(place) - 0.5, overrides, 0.4 * cost_of(scene, f))
    };
    (-2..=steps.cast_signed()).map(one).collect()
}

/// The edge at the projectile alone, cells far away as they are.
fn contact_size(scene: &Scene) -> Vec<Rung> {
    let size = scene.mesh.size;
    let one = |place: f64, f: f64, coarsest: Option<usize>| {
        let tree = coarsest.map(|coarsest| set("mesh.tree.coarsest", coarsest));
        let smallest = scene.remesh.as_ref().and_then(|remesh| remesh.smallest);
        let smallest = smallest.map(|smallest| set("remesh.smallest", length(f * smallest)));
        let edge = set("mesh.size", length(f * size));
        rung("contact size", place, [edge].into_iter().chain(tree).chain(smallest).collect(), 1.0 / f)
    };
    match (scene.mesh.grading, scene.mesh.tree) {
        (Some(_), _) => vec![one(-1.0, 1.5, None), one(1.0, 0.667, None)],
        (None, Some(tree)) if tree.coarsest >= 4 => {
            vec![one(-1.0, 2.0, Some(tree.coarsest / 2)), one(1.0, 0.5, Some(2 * tree.coarsest))]
        }
        (None, Some(_) | None) => vec![],
    }
}

/// How fast cells grow, the finest as they are.
fn grading(scene: &Scene) -> Vec<Rung> {
    let one = |place: f64, f: f64| {
        let grading = scene.mesh.grading.map(|g| set("mesh.grading.growth", length(1.0 + f * (g.growth - 1.0))));
        let tree = scene.mesh.tree.map(|tree| set("mesh.tree.slope", length(f * tree.slope)));
        let remesh = scene.remesh.as_ref().map(|remesh| set("remesh.growth", length((f * remesh.growth).min(1.0))));
        let all: Vec<Override> = grading.into_iter().chain(tree).chain(remesh).collect();
        (!all.is_empty()).then(|| rung("grading", place, all, 1.0 / f))
    };
    [one(-2.0, 2.0), one(-1.0, 1.5), one(1.0, 0.667)].into_iter().flatten().collect()
}

fn time(scene: &Scene) -> Vec<Rung> {
    let own = scene.integrator.cfl();
    let one = |place: f64, cfl: f64| rung("cfl", place, vec![set("integrator.cfl", length(cfl))], own / cfl);
    let faster = (own < 1.0).then(|| one(-1.0, 1.0));
    faster.into_iter().chain([one(1.0, 0.5 * own), one(2.0, 0.25 * own)]).collect()
}

fn schedule(scene: &Scene) -> Vec<Rung> {
    let bins = scene.integrator.schedule == ScheduleKind::Bins;
    bins.then(|| rung("schedule", 1.0, vec![set("integrator.schedule", "global")], 4.0)).into_iter().collect()
}

fn element(scene: &Scene) -> Vec<Rung> {
    let (other, place) = match scene.mesh.element {
        ElementKind::Plain => ("patch", 0.125),
        ElementKind::Patch => ("plain", -0.125),
    };
    let round = scene.scene.dimension == Dimension::Spatial && matches!(scene.gel.shape, GelShape::Cylinder { .. });
    let plain = scene.mesh.tree.is_none() && scene.mesh.lattice == Lattice::Centred && !round;
    let lattice = plain.then(|| rung("lattice", -1.0, vec![set("mesh.lattice", "kuhn")], 0.5));
    // An element that meets the limit by chance on one mesh misses it on a finer one.
    let sizes = [-1.0, 0.0, 1.0].map(|finer: f64| (place + finer, 2f64.powf(-0.5 * finer)));
    let one = |(place, f): (f64, f64)| {
        let other = set("mesh.element", other);
        rung("element", place, [other].into_iter().chain(scaled(scene, f)).collect(), cost_of(scene, f))
    };
    sizes.map(one).into_iter().chain(lattice).collect()
}

fn contact(scene: &Scene) -> Vec<Rung> {
    if scene.contact.law != ContactLaw::Moreau || scene.contact.restitution > 0.0 {
        return vec![];
    }
    let one = |place: f64, e: f64| rung("restitution", place, vec![set("contact.restitution", e)], 1.0);
    vec![one(-2.0, 1.0), one(-1.0, 0.5)]
}

/// Slower pressure waves: a gel that is softer in volume than it should be takes longer steps.
fn bulk(scene: &Scene) -> Vec<Rung> {
    let own = scene.gel.bulk_modulus;
    let one =
        |place: f64, f: f64| rung("bulk modulus", place, vec![set("gel.bulk_modulus", length(f * own))], f.sqrt());
    // Poisson's ratio is positive from K = 2/3 G on.
    let stiff = |f: f64| f * own > 0.7 * scene.gel.shear_modulus;
    [(-2.0, 0.25), (-1.0, 0.5), (1.0, 2.0)]
        .into_iter()
        .filter(|turned| stiff(turned.1))
        .map(|(place, f)| one(place, f))
        .collect()
}

/// A gel about an axis in three dimensions, on cells that grow by half from one to the next and are twice as long.
fn dimension(scene: &Scene) -> Vec<Rung> {
    let about = scene.scene.dimension == Dimension::Axisymmetric && scene.remesh.is_none();
    let GelShape::Cylinder { radius, bore: None, .. } = scene.gel.shape else { return vec![] };
    if !about {
        return vec![];
    }
    let size = length(2.0 * scene.mesh.size);
    let core = scene.mesh.grading.map_or(10.0 * size, |grading| grading.core);
    let grading = format!("{{core = {core:?}, growth = 1.5, largest = {:?}}}", length(radius / 6.0));
    let grading = Override { key: "mesh.grading".to_owned(), value: grading };
    // Tetrahedra by themselves lock.
    let patch = set("mesh.element", "patch");
    vec![rung("dimension", -1.0, vec![set("scene.dimension", "spatial"), patch, set("mesh.size", size), grading], 15.0)]
}

fn remeshing(scene: &Scene) -> Vec<Rung> {
    let one = |place: f64, key: &str, value: f64| rung("remesh", place, vec![set(key, value)], 1.0);
    let Some(remesh) = &scene.remesh else { return vec![] };
    let flat = scene.scene.dimension != Dimension::Spatial;
    let cut = flat && remesh.method == RemeshMethod::Retained && remesh.thinnest.is_none();
    let cut = cut.then(|| rung("remesh", -3.0, vec![set("remesh.method", "immersed")], 1.0));
    let quality =
        [(-1.0, 0.667), (1.0, 1.333)].map(|(place, f)| one(place, "remesh.quality", length(f * remesh.quality)));
    let bend = (remesh.adaptive && remesh.bend < 120.0).then(|| one(-2.0, "remesh.bend", 180.0));
    quality.into_iter().chain(bend).chain(cut).collect()
}

fn coupling(scene: &Scene) -> Vec<Rung> {
    let own = scene.scene.communication_step;
    let one = |place: f64, f: f64| rung("coupling", place, vec![set("scene.communication_step", length(f * own))], 1.0);
    let owned = |place: f64, importer| Rung { importer, ..rung("coupling", place, vec![], 1.0) };
    let mut all = vec![one(-1.0, 10.0)];
    if !scene.projectile.fixed {
        all.extend([owned(-2.0, Importer::Corrected), owned(-3.0, Importer::Prescribed)]);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{HasFailed, MESH, REMESHED, Rung, ladder};
    use ballistic_gel::scene::{self, Scene};

    fn scene(name: &str) -> Scene {
        scene::read(scene::builtin(name).unwrap()).unwrap()
    }

    fn rungs(name: &str, has_failed: HasFailed) -> Vec<Rung> {
        ladder(&scene(name), 3, has_failed)
    }

    #[test]
    fn every_rung_of_every_builtin_scene_is_a_scene() {
        for (name, text) in scene::builtins() {
            for rung in rungs(name, HasFailed::No) {
                let read = scene::resolve(text, &rung.overrides).and_then(|text| scene::read(&text));
                let coarse = rung.place < 0.0;
                assert!(read.is_ok() || coarse, "{name}: {}: {}", rung.label(), read.unwrap_err());
            }
        }
    }

    #[test]
    fn cells_are_refined_everywhere_or_where_the_projectile_is() {
        let all = rungs("ball-bounce", HasFailed::No);
        let find = |knob: &str, place: f64| all.iter().find(|r| r.knob == knob && r.place == place).unwrap().label();
        let finer = "mesh.size=0.0005 mesh.grading.growth=1.072 mesh.grading.largest=0.003";
        assert_eq!(find(MESH, 2.0), finer);
        assert_eq!(find("contact size", 1.0), "mesh.size=0.000667");
    }

    #[test]
    fn a_scene_whose_mesh_cannot_follow_is_refined_with_meshes_that_are_exchanged() {
        let count = |has_failed| rungs("ball-square", has_failed).iter().filter(|rung| rung.knob == REMESHED).count();
        assert_eq!((count(HasFailed::No), count(HasFailed::Yes)), (0, 8));
    }
}
