//! Prints the steps of one remeshing by the immersed method as JSON, for figure 6 of the paper: `remesh-steps`.

use ballistic_gel::mesh::{NodeId, Simplex};
use ballistic_gel::scene::{self, Override, RemeshMethod};
use ballistic_gel::simulation::{CouplingMode, RemeshPreview, Simulation};
use serde_json::{Value, json};

/// A disc of 30 m/s into `ball-square`, which is remeshed when it could hardly go on.
const SETTINGS: [(&str, &str); 3] =
    [("projectile.velocity", "[0, 0, -30]"), ("remesh.quality", "0.05"), ("remesh.min_volume_ratio", "0.0")];

fn main() {
    let overrides = SETTINGS.map(|(key, value)| Override { key: key.to_owned(), value: value.to_owned() });
    let text = scene::resolve(scene::builtin("ball-square").expect("a built-in scene"), &overrides);
    let scene = scene::read(&text.expect("keys of the scene")).expect("values of the scene");
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("the scene is built");
    let shown = simulation.preview_remeshing(0.0, scene.scene.end_time).expect("the mesh is stepped");
    println!("{}", steps(&shown.expect("the mesh is remeshed")));
}

/// Returns points and triangles of each mesh, m, and the fields on it.
fn steps(shown: &RemeshPreview) -> Value {
    let RemeshPreview { frame, trial } = shown;
    let steps = trial.steps.as_ref().expect("the immersed method makes a mesh");
    let immersed = trial.successors.iter().find(|(method, _)| *method == RemeshMethod::Immersed);
    let made = immersed.and_then(|(_, made)| made.as_ref().ok()).expect("the new mesh is accepted");
    assert_eq!(made.attempt, 1, "the mesh is that of the steps");
    json!({
        "old": {
            "points": frame.points.iter().map(|p| [p.x, p.z]).collect::<Vec<_>>(),
            "triangles": frame.cells.nodes.iter().map(|nodes| &nodes[..3]).collect::<Vec<_>>(),
            "quality": trial.shapes, "curvature": trial.bend,
        },
        "quadtree": steps.cells.iter().map(|cell| [cell.middle[0], cell.middle[1], cell.edge]).collect::<Vec<_>>(),
        "background": {
            "points": steps.background.points.iter().map(|p| [p[0], p[1]]).collect::<Vec<_>>(),
            "triangles": steps.background.triangles, "distance": steps.distance,
        },
        "new": {
            "points": made.points.iter().map(|p| [p[0], p[1]]).collect::<Vec<_>>(),
            "triangles": made.elements.iter().map(corners).collect::<Vec<_>>(),
            "velocity": made.velocity.iter().map(|v| v[1]).collect::<Vec<_>>(),
        },
    })
}

fn corners(element: &Simplex) -> [usize; 3] {
    [element[0], element[1], element[2]].map(NodeId::index)
}
