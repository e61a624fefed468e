use super::super::run::scene;
use super::slivers::{is_flat, with_slivers};
use ballistic_gel::math::Vector;
use ballistic_gel::mesh::{Mesh, NodeId, edges};
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};

/// A mesh of the block, and the physics of its scene.
pub struct Case {
    /// What the mesh is called.
    pub name: &'static str,
    /// The scene.
    pub scene: Scene,
    /// The mesh, held at the bottom.
    pub mesh: Mesh<3>,
    /// Fraction of the elements that are as small as the smallest, or flat.
    pub fine: f64,
    /// The depth that finer meshes tend to, mm, where it is known.
    pub depth: Option<f64>,
}

/// Of `sphere-block`, by the study of that name.
const DEPTH: f64 = 14.535;

/// Uniform and graded at the speed of the scenes; uniform and with slivers at a tenth of it, at which slivers last: at 5 m/s
/// one is turned inside out after 0.5 ms, at 1.5 m/s none is.
pub fn cases() -> impl Iterator<Item = Case> {
    const GRADED: [(&str, &str); 4] = [
        ("uniform", "sphere-block"),
        ("1:4", "sphere-graded-4"),
        ("1:8", "sphere-graded-8"),
        ("1:16", "sphere-graded-16"),
    ];
    let slow = || scene("sphere-block", &[("projectile.velocity", "[0.0, 0.0, -0.5]".to_owned())]);
    let fast = |(name, builtin)| Case { depth: Some(DEPTH), ..Case::of(name, scene(builtin, &[])) };
    let uniform = std::iter::once_with(move || Case::of("uniform, 0.5 m/s", slow()));
    GRADED.into_iter().map(fast).chain(uniform).chain(std::iter::once_with(move || slivers(slow())))
}

impl Case {
    /// The mesh of a scene.
    fn of(name: &'static str, scene: Scene) -> Self {
        let mesh = mesh(&scene);
        let fine = fine(&mesh);
        Self { name, scene, mesh, fine, depth: None }
    }
}

/// A tenth of the elements of a scene made flat.
fn slivers(scene: Scene) -> Case {
    let mesh = with_slivers(mesh(&scene), 0.1);
    let flat = mesh.elements.iter().filter(|e| is_flat(&mesh.rest, e)).count();
    let fine = flat as f64 / mesh.elements.len() as f64;
    Case { name: "slivers, 0.5 m/s", scene, mesh, fine, depth: None }
}

/// The mesh of a spatial block that is held at the bottom.
fn mesh(scene: &Scene) -> Mesh<3> {
    let frame = Simulation::new(scene, CouplingMode::Integrated, 1).expect("a scene that can be built").frame();
    let elements = frame.cells.nodes.iter().map(|nodes| nodes.map(NodeId)).collect();
    let mut mesh = Mesh::new(frame.points, elements);
    let bottom = mesh.rest.iter().map(|x| x.z).fold(f64::INFINITY, f64::min);
    mesh.held = mesh.rest.iter().map(|x| [x.z == bottom; 3]).collect();
    mesh
}

/// Fraction of the elements of the finest cells: their longest edge is that of the cell, a half longer or more elsewhere.
fn fine(mesh: &Mesh<3>) -> f64 {
    let longest: Vec<f64> = mesh.elements.iter().map(|nodes| longest_edge(&mesh.rest, nodes)).collect();
    let least = longest.iter().copied().fold(f64::INFINITY, f64::min);
    longest.iter().filter(|edge| **edge < 1.4 * least).count() as f64 / longest.len() as f64
}

fn longest_edge(x: &[Vector<3>], nodes: &[NodeId; 4]) -> f64 {
    let from_first = edges(x, nodes);
    let [a, b, c] = [0, 1, 2].map(|i| Vector::<3>::from(from_first.column(i)));
    [a, b, c, b - a, c - b, a - c].iter().map(Vector::<3>::norm).fold(0.0, f64::max)
}
