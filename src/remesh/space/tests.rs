use super::super::{DeformedMesh, NodeOrigin, ProposedMesh, RemeshRules};
use super::propose;
use super::tet_mesh::{TetMesh, Tetrahedron};
use crate::math::Vector;
use crate::mesh::{BlockSpec, CellSplit, Mesh, NodeId, block, boundary, shape_quality, signed_volume, uniform};
use std::time::Instant;

fn cube(n: usize, split: CellSplit) -> Mesh<3> {
    let axis = || uniform(0.0, 1.0, 1.0 / n as f64);
    block(BlockSpec { planes: [axis(), axis(), axis()], split, faces: vec![] })
}

/// Star of `n` tetrahedra around an edge from point n to n + 1, two of four such points nearer to it; `more` adds
/// tetrahedra, also of the points n + 2 and n + 3 beside it.
pub(super) fn around_an_edge(n: u32, more: &[Tetrahedron]) -> TetMesh {
    let at = |k: u32| {
        let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / f64::from(n)).sin_cos();
        Vector::<3>::new(cos, sin, 0.0) * if n == 4 && k % 2 == 1 { 2.0 } else { 1.0 }
    };
    let others = [[0.0, 0.0, -1.2], [0.0, 0.0, 1.2], [0.0, 4.0, 4.0], [0.0, 5.0, 4.0]].map(Vector::<3>::from);
    let rest: Vec<_> = (0..n).map(at).chain(others).collect();
    let around = (0..n).map(|k| [k, (k + 1) % n, n, n + 1]);
    let elements = around.chain(more.iter().copied()).map(|tet| tet.map(NodeId)).collect();
    let mesh = Mesh::new(rest, elements);
    TetMesh::new(&DeformedMesh { mesh: &mesh, position: &mesh.rest }, &vec![1.0; mesh.rest.len()])
}

fn volume(x: &[Vector<3>], elements: &[crate::mesh::Simplex]) -> f64 {
    elements.iter().map(|e| signed_volume(x, e)).sum()
}

fn worst(x: &[Vector<3>], elements: &[crate::mesh::Simplex]) -> f64 {
    elements.iter().map(|e| shape_quality(x, e)).fold(f64::INFINITY, f64::min)
}

/// Checks all properties of a new mesh and returns its least quality.
fn check(old: &DeformedMesh<'_, 3>, new: &ProposedMesh<3>, tolerance: f64) -> f64 {
    assert!(new.elements.iter().all(|e| signed_volume(&new.position, e) > 0.0));
    let [before, after] = [volume(old.position, &old.mesh.elements), volume(&new.position, &new.elements)];
    assert!((after / before - 1.0).abs() < tolerance, "volume {before} {after}");
    let facets = boundary::<3>(&new.elements);
    let mut nodes: Vec<u32> = facets.iter().flatten().map(|n| n.0).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let mut edges: Vec<[u32; 2]> = facets
        .iter()
        .flat_map(|f| (0..3).map(|k| [f[k].0, f[(k + 1) % 3].0]))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    assert!(edges.chunk_by(|a, b| a == b).all(|same| same.len() == 2), "every edge of the surface has two facets");
    edges.dedup();
    assert_eq!(nodes.len() + facets.len(), edges.len() + 2, "the surface is a sphere");
    for (origin, x) in new.origin.iter().zip(&new.position) {
        if let NodeOrigin::Kept(node) = origin {
            assert_eq!(*x, old.position[node.index()]);
        }
    }
    worst(&new.position, &new.elements)
}

#[test]
fn a_good_mesh_of_the_right_size_stays() {
    for split in [CellSplit::Centred, CellSplit::Kuhn] {
        let mesh = cube(5, split);
        let old = DeformedMesh { mesh: &mesh, position: &mesh.rest };
        let new = propose(&old, &vec![0.2; mesh.rest.len()], &RemeshRules::default(), &|x| *x).unwrap();
        assert_eq!(new.elements, mesh.elements);
        assert_eq!(new.position, mesh.rest);
    }
}

#[test]
fn finer_and_coarser_meshes_have_the_sizes_asked_for() {
    let mesh = cube(6, CellSplit::Centred);
    let old = DeformedMesh { mesh: &mesh, position: &mesh.rest };
    for (size, least, most) in [(0.08, 4.0, 14.0), (0.35, 0.05, 0.6)] {
        let new = propose(&old, &vec![size; mesh.rest.len()], &RemeshRules::default(), &|x| *x).unwrap();
        let quality = check(&old, &new, 1e-12);
        let ratio = new.elements.len() as f64 / mesh.elements.len() as f64;
        println!("size {size}: {ratio} times the elements, quality {quality}");
        assert!(ratio > least && ratio < most && quality > 0.34, "{ratio} {quality}");
    }
}

#[test]
#[ignore = "a measurement: cargo test --lib --release local::tests::speed -- --ignored --nocapture"]
fn speed() {
    for (n, amount) in [(24, 0.0), (24, 1.0), (24, 2.5), (44, 2.5)] {
        let mesh = cube(n, CellSplit::Centred);
        let position: Vec<Vector<3>> = mesh.rest.iter().map(|x| swirled(x, amount)).collect();
        let old = DeformedMesh { mesh: &mesh, position: &position };
        let start = Instant::now();
        let new = propose(&old, &vec![1.0 / n as f64; mesh.rest.len()], &RemeshRules::default(), &|x| *x).unwrap();
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "{} tetrahedra, worst {:.2} -> {:.2}: {seconds:.3} s, {:.0} tetrahedra/s",
            mesh.elements.len(),
            worst(&position, &mesh.elements),
            worst(&new.position, &new.elements),
            new.elements.len() as f64 / seconds
        );
    }
}

/// Swirl about the vertical through the middle that leaves the outer region in place.
fn swirled(x: &Vector<3>, angle: f64) -> Vector<3> {
    let d = [x[0] - 0.5, x[2] - 0.5];
    let wall = |s: f64| (16.0 * s * s * (1.0 - s) * (1.0 - s)).min(1.0);
    let turn = angle * wall(x[0]) * wall(x[2]) * wall(x[1]);
    let (s, c) = turn.sin_cos();
    Vector::<3>::new(0.5 + c * d[0] - s * d[1], x[1], 0.5 + s * d[0] + c * d[1])
}

#[test]
fn a_mesh_that_is_stirred_stays_good() {
    let mut mesh = cube(8, CellSplit::Centred);
    let mut remeshes = 0;
    for step in 0..120 {
        let position: Vec<Vector<3>> = mesh.rest.iter().map(|x| swirled(x, 0.05)).collect();
        let old = DeformedMesh { mesh: &mesh, position: &position };
        let before = worst(&position, &mesh.elements);
        if before > 0.3 {
            mesh.rest = position;
            continue;
        }
        let new = propose(&old, &vec![0.125; mesh.rest.len()], &RemeshRules::default(), &|x| *x).unwrap();
        let after = check(&old, &new, 1e-9);
        println!("step {step}: {before:.3} -> {after:.3}, {} -> {}", mesh.elements.len(), new.elements.len());
        assert!(after > 0.34);
        remeshes += 1;
        mesh = Mesh::new(new.position, new.elements);
    }
    assert!(remeshes > 3);
}

/// Surface pressed down by a ball from above.
fn pressed(x: &Vector<3>, depth: f64) -> Vector<3> {
    let d = x - Vector::<3>::new(0.5, 0.5, 1.0);
    let r2 = d[0] * d[0] + d[1] * d[1];
    let below = (1.0 - x[2]).min(1.0);
    let down = depth * (-r2 / 0.03).exp() * (1.0 - below).powi(2);
    Vector::<3>::new(x[0], x[1], x[2] - down)
}

#[test]
fn a_surface_that_is_drawn_down_keeps_its_corners_and_its_volume() {
    let mut mesh = cube(8, CellSplit::Centred);
    let mut position = mesh.rest.clone();
    let mut last = f64::NAN;
    for _ in 0..12 {
        position = position.iter().map(|x| pressed(x, 0.06)).collect();
        let old = DeformedMesh { mesh: &mesh, position: &position };
        let before = worst(&position, &mesh.elements);
        let new = propose(&old, &vec![0.125; mesh.rest.len()], &RemeshRules::default(), &|x| *x).unwrap();
        last = check(&old, &new, 1e-5);
        println!("{before:.3} -> {last:.3}, {} -> {}", mesh.elements.len(), new.elements.len());
        let rest = new.origin.iter().zip(&new.position).map(|(origin, x)| match origin {
            NodeOrigin::Kept(node) => mesh.rest[node.index()],
            NodeOrigin::Surface(nodes, weights) => {
                (0..3).map(|k| mesh.rest[nodes[k].index()] * weights[k]).sum::<Vector<3>>()
            }
            NodeOrigin::Inside => *x,
        });
        let facets = boundary::<3>(&new.elements);
        let held = vec![[false; 3]; new.position.len()];
        mesh = Mesh { rest: rest.collect(), held, facets, elements: new.elements, marks: vec![] };
        position = new.position;
    }
    assert!(last > 0.34);
    for corner in 0..8 {
        let wanted = Vector::<3>::from_fn(|axis, _| f64::from(corner >> axis & 1));
        assert!(mesh.rest.contains(&wanted));
    }
}

#[test]
fn a_point_that_was_pushed_along_the_surface_slides_back_and_the_volume_stays() {
    let mesh = cube(4, CellSplit::Kuhn);
    let middle = mesh.rest.iter().position(|x| *x == Vector::<3>::new(0.5, 0.5, 1.0)).unwrap();
    let mut position = mesh.rest.clone();
    position[middle] += Vector::<3>::new(0.23, 0.1, 0.0);
    let old = DeformedMesh { mesh: &mesh, position: &position };
    let made = |slide: f64| {
        let rules = RemeshRules { sag: 0.0, slide, ..RemeshRules::default() };
        check(&old, &propose(&old, &vec![0.25; position.len()], &rules, &|x| *x).unwrap(), 1e-12)
    };
    let [held, slid] = [0.0, 0.1].map(made);
    println!("least quality {held:.3} where it is held, {slid:.3} where it slides");
    assert!(slid > 1.2 * held, "{held} {slid}");
}

/// Pyramid on a plane of symmetry with a point pushed over an edge of the plane's facets: the edge of the resulting
/// kite is removed, whichever way its facets face.
#[test]
fn on_a_plane_of_symmetry_facets_that_are_turned_over_are_joined_anew() {
    let at = |x: f64, y: f64, z: f64| Vector::<3>::new(x, y, z);
    let points = |over: f64| {
        let kite = vec![at(0.0, 0.0, 0.0), at(0.0, 1.0, 0.0), at(0.0, 0.5, 0.8), at(0.0, 0.5, -0.8)];
        [kite, vec![at(0.0, 0.5, over), at(0.8, 0.5, 0.0)]].concat()
    };
    let elements = [[0, 1, 4, 5], [1, 2, 4, 5], [2, 0, 4, 5], [1, 0, 3, 5]].map(|nodes| nodes.map(NodeId));
    let mut mesh = Mesh::<3>::new(points(0.3), elements.to_vec());
    assert!(mesh.elements.iter().all(|e| signed_volume(&mesh.rest, e) > 0.0));
    for over in [0.01, -0.02] {
        let position = points(over);
        for (is_held, is_mended) in [(true, true), (false, over > 0.0)] {
            mesh.held = (0..6).map(|point| [is_held && point < 5, false, false]).collect();
            let old = DeformedMesh { mesh: &mesh, position: &position };
            let new = propose(&old, &[1.0; 6], &RemeshRules::default(), &|x| *x).unwrap();
            let kept = volume(&new.position, &new.elements) / volume(&position, &elements);
            assert_eq!(new.elements.len() == 4 && worst(&new.position, &new.elements) > 0.3, is_mended);
            assert!((kept - 1.0).abs() < 1e-14 || !is_mended, "{kept}");
        }
    }
}

/// Tetrahedron with a point on one of its faces, pushed over an edge of that face: no operation that preserves the
/// topology makes the element between them upright.
#[test]
fn what_is_flat_at_the_surface_is_cut_off() {
    let at = |x: f64, y: f64, z: f64| Vector::<3>::new(x, y, z);
    let points = |over: f64| {
        vec![at(0.0, 0.0, 0.0), at(0.0, 1.0, 0.0), at(0.0, 0.5, 1.0), at(0.0, 0.5, over), at(0.8, 0.5, 0.4)]
    };
    let elements = [[0, 1, 3, 4], [1, 2, 3, 4], [2, 0, 3, 4]].map(|nodes| nodes.map(NodeId));
    let mut mesh = Mesh::<3>::new(points(0.3), elements.to_vec());
    assert!(mesh.elements.iter().all(|e| signed_volume(&mesh.rest, e) > 0.0));
    mesh.held = vec![[true, false, false]; 5];
    (mesh.held[3], mesh.held[4]) = ([true; 3], [false; 3]);
    for over in [0.01, -0.02] {
        let position = points(over);
        let old = DeformedMesh { mesh: &mesh, position: &position };
        let made =
            |sag: f64| propose(&old, &[1.0; 5], &RemeshRules { sag, ..RemeshRules::default() }, &|x| *x).unwrap();
        let new = made(0.06);
        assert_eq!(new.elements.len(), 2);
        assert!(new.elements.iter().all(|e| signed_volume(&new.position, e) > 0.0));
        assert!((new.cleared - signed_volume(&position, &elements[0])).abs() < 1e-15);
        assert_eq!(made(0.0).elements.len(), 3);
    }
}
