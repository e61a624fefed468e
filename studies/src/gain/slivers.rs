use ballistic_gel::math::Vector;
use ballistic_gel::mesh::{ElementId, Mesh, NodeId, NodeIncidence, Simplex, least_angle, signed_volume};

/// Angle of a sliver at the edges of its base, degrees.
const ANGLE: f64 = 1.0;
/// A neighbour that is flattened along with it may be so much flatter.
const FLATTEST: f64 = 0.2;

/// Whether two faces of an element lie nearly on each other.
pub fn is_flat(x: &[Vector<3>], element: &Simplex) -> bool {
    least_angle(x, element) < 2.0 * ANGLE
}

/// The mesh with inner nodes moved until this share of its elements is flat: each to just above the middle of the circle
/// inscribed in the face that one of its elements turns to it.
pub fn with_slivers(mut mesh: Mesh<3>, share: f64) -> Mesh<3> {
    let star = NodeIncidence::new(mesh.rest.len(), mesh.elements.iter().map(|e| &e[..]));
    let enough = (share * mesh.elements.len() as f64) as usize;
    let mut flat = 0;
    let nodes = scattered_inner_nodes(&mesh);
    // A second round finds room where the first element of a node would have crushed another.
    for (turn, node) in nodes.iter().chain(&nodes).enumerate() {
        if flat >= enough {
            break;
        }
        let around = star.of(*node);
        let before = count_flat(&mesh, around);
        let chosen = around[turn % around.len()];
        let was = mesh.rest[node.index()];
        mesh.rest[node.index()] = above_base(&mesh, *node, chosen);
        let sound = |e: &ElementId| is_sound(&mesh, *e);
        if around.iter().all(sound) && count_flat(&mesh, around) > before {
            flat += count_flat(&mesh, around) - before;
        } else {
            mesh.rest[node.index()] = was;
        }
    }
    mesh
}

/// The nodes that are not on the boundary, neighbours far apart in the list.
fn scattered_inner_nodes(mesh: &Mesh<3>) -> Vec<NodeId> {
    /// A prime beyond any number of nodes here.
    const STRIDE: usize = 1_000_003;
    let n = mesh.rest.len();
    let mut inner = vec![true; n];
    for node in mesh.facets.iter().flatten() {
        inner[node.index()] = false;
    }
    // As they lie in space: how they are numbered depends on the steps of their elements.
    let mut all: Vec<usize> = (0..n).collect();
    all.sort_by(|a, b| mesh.rest[*a].iter().partial_cmp(mesh.rest[*b].iter()).expect("positions are numbers"));
    (0..n).map(|i| all[i * STRIDE % n]).filter(|i| inner[*i]).map(|i| NodeId(i as u32)).collect()
}

fn count_flat(mesh: &Mesh<3>, elements: &[ElementId]) -> usize {
    elements.iter().filter(|e| is_flat(&mesh.rest, &mesh.elements[e.index()])).count()
}

fn is_sound(mesh: &Mesh<3>, element: ElementId) -> bool {
    let nodes = &mesh.elements[element.index()];
    signed_volume(&mesh.rest, nodes) > 0.0 && least_angle(&mesh.rest, nodes) > FLATTEST
}

/// Where the faces of an element meet its base, opposite a node, at [`ANGLE`].
fn above_base(mesh: &Mesh<3>, node: NodeId, element: ElementId) -> Vector<3> {
    let base: Vec<NodeId> = mesh.elements[element.index()].into_iter().filter(|n| *n != node).collect();
    let [a, b, c] = [0, 1, 2].map(|i| mesh.rest[base[i].index()]);
    let [along_a, along_b, along_c] = [(b - c).norm(), (c - a).norm(), (a - b).norm()];
    let around = along_a + along_b + along_c;
    let middle = (a * along_a + b * along_b + c * along_c) / around;
    let normal = (b - a).cross(&(c - a));
    let radius = normal.norm() / around;
    let up = normal.normalize() * normal.dot(&(mesh.rest[node.index()] - a)).signum();
    middle + up * radius * ANGLE.to_radians().tan()
}
