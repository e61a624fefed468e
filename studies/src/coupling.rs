//! What the communication step costs, by the way in which the importer moves the projectile.

mod master;
mod picture;
mod table;

use super::run::scene;
use ballistic_gel::scene::Scene;
use master::Master;
use std::path::Path;

/// Communication steps, s; all divide the end times.
const STEPS: [f64; 10] = [1e-3, 5e-4, 2.5e-4, 1e-4, 5e-5, 2.5e-5, 1e-5, 5e-6, 2.5e-6, 1e-6];

/// What a run of a master differs by from the integrated one.
struct Row {
    master: Master,
    /// Communication step, s.
    step: f64,
    /// Error of the final velocity along the first one, and of the energy that is left, and the sum of the power-bond
    /// residuals: relative to the speed and the energy at the start.
    errors: [f64; 3],
    /// Times that steps were computed, per step.
    tries: f64,
}

const ERRORS: [&str; 3] = ["velocity", "energy", "residual"];

/// All runs of a scene.
struct Sheet {
    scene: String,
    /// Smallest step of an element at the end, s.
    element_step: f64,
    rows: Vec<Row>,
}

/// Errors of `ball-bounce` and `sphere-block` against the communication step, as tables, CSV and picture.
pub fn study() {
    let ball = scene("ball-bounce", &[("mesh.size", "2e-3".to_owned()), ("scene.end_time", "25e-3".to_owned())]);
    let sphere = scene("sphere-block", &[("mesh.lattice", "kuhn".to_owned())]);
    let sheets = [ball, sphere].map(|scene| sheet(&scene));
    for sheet in &sheets {
        table::print(sheet);
    }
    table::print_orders(&sheets);
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    std::fs::write(docs.join("coupling.csv"), table::csv(&sheets)).expect("docs/coupling.csv");
    std::fs::write(docs.join("pictures/coupling.svg"), picture::svg(&sheets)).expect("docs/pictures/coupling.svg");
}

fn sheet(scene: &Scene) -> Sheet {
    let reference = master::run(scene, Master::Integrated, 1);
    let start = scene.projectile.velocity[2];
    let energy = 0.5 * scene.projectile.mass.expect("a mass in the scene") * start * start;
    let runs = Master::ALL.into_iter().flat_map(|master| STEPS.map(|step| (master, step)));
    let rows = runs.map(|(master, step)| {
        let outcome = master::run(scene, master, (scene.scene.end_time / step).round() as u32);
        let same = outcome.digest == reference.digest;
        assert!(same || master != Master::Integrated, "the state depends on the communication step {step} s");
        let unbooked = (outcome.brought - outcome.residual) / energy;
        assert!(unbooked.abs() < 1e-10, "{}: residual and ledger differ by {unbooked:e}", master.name());
        let errors = [
            (outcome.velocity - reference.velocity).z / start.abs(),
            (outcome.energy - reference.energy) / energy,
            outcome.residual / energy,
        ];
        Row { master, step, errors, tries: outcome.tries }
    });
    Sheet { scene: scene.scene.name.clone(), element_step: reference.element_step, rows: rows.collect() }
}
