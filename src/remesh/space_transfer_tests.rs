//! Conservation of a field transfer in space.

use super::test_bodies::{
    TestBody, TestRandom, check_conserved, check_inverted, check_nothing, check_reach, check_sizes, even, scatter,
};
use super::*;
use crate::math::Vector3;
use crate::mesh::{NodeId, Simplex};

/// Rotation with stretch and shear.
fn affine(xi: &Vector3) -> Vector3 {
    Vector3::new(
        0.9 * xi.x - 0.5 * xi.y + 0.2 * xi.z + 0.7,
        0.6 * xi.x + 1.1 * xi.y - 0.3 * xi.z - 0.4,
        0.1 * xi.x + 0.3 * xi.y + 0.8 * xi.z + 0.1,
    )
}

fn wavy(x: &Vector3) -> Vector3 {
    Vector3::new((4.0 * x.x + x.y).sin(), (3.0 * x.y - 2.0 * x.z).cos(), (2.0 * x.z + x.x).sin())
}

fn cells([i, j, k]: [usize; 3]) -> [Vec<f64>; 3] {
    [even(i), even(j), even(k)]
}

fn body(n: [usize; 3], random: &mut TestRandom) -> TestBody<3> {
    TestBody::new(&cells(n), (1.0, random), (BodySymmetry::Spatial, &affine))
}

fn uneven(body: TestBody<3>, random: &mut TestRandom) -> TestBody<3> {
    let mass: Vec<f64> = scatter(&body.mesh, random).iter().map(|m| 0.01 * (0.5 + m)).collect();
    body.with_masses(&mass)
}

/// Body on other cells, with their node positions in ξ.
fn remeshed(
    body: &TestBody<3>,
    n: [usize; 3],
    random: &mut TestRandom,
) -> (Vec<Vector3>, ProposedMesh<3>, TransferredFields<3>) {
    let (xi, new) = body.other(&cells(n), (1.0, random), &affine);
    let after = transfer(&body.moved(), &body.carried(), &new);
    (xi, new, after)
}

#[test]
fn a_mesh_that_is_the_same_keeps_every_bit() {
    let mut random = TestRandom::new(1);
    let mut body = body([4, 3, 3], &mut random).with_velocity(wavy);
    body.mesh.held[3] = [false, true, false];
    body.velocity[3].y = 0.0;
    let mut new = body.again();
    new.elements.reverse();
    // Turned about a corner, about the middles of two edges, and left.
    for (nodes, way) in new.elements.iter_mut().zip([0, 1, 2].into_iter().cycle()) {
        let [a, b, c, d] = *nodes;
        *nodes = [[b, c, a, d], [c, d, a, b], [a, b, c, d]][way];
    }
    let after = transfer(&body.moved(), &body.carried(), &new);
    assert_eq!((after.rest, after.mass), (body.mesh.rest.clone(), body.mass.clone()));
    assert_eq!((after.velocity, after.held), (body.velocity.clone(), body.mesh.held.clone()));
    assert_eq!((after.defects.unchanged, after.defects.stray_mass), (1.0, 0.0));
    assert_eq!(after.defects.after, after.defects.before);
    for (e, old) in (0..new.elements.len()).rev().enumerate() {
        let same = after.same[e].unwrap();
        assert_eq!(same.element.index(), old);
        assert_eq!(same.turned(&body.mesh.elements[old]), new.elements[e]);
        assert_eq!(same.turned(&body.corner_mass[old]), after.corner_mass[e]);
    }
}

#[test]
fn nodes_out_of_reach_of_a_change_keep_every_bit() {
    let mut random = TestRandom::new(2);
    let planes = [even(20), even(3), even(3)];
    let body = TestBody::new(&planes, (1.0, &mut random), (BodySymmetry::Spatial, &affine)).with_velocity(wavy);
    let inner = |xi: &Vector3| xi.x > 0.0 && xi.x < 0.07 && xi.yz().iter().all(|c| *c > 0.0 && *c < 0.5);
    let moved = body.xi.iter().position(inner).unwrap();
    let [same, other] = check_reach(&body, moved, Vector3::new(0.004, 0.003, -0.002));
    assert!(same > 150 && other > 20, "{same} the same, {other} not");
}

#[test]
fn rest_positions_of_an_affine_map_are_exact() {
    let mut random = TestRandom::new(3);
    let body = body([4, 4, 4], &mut random);
    let (xi, new, after) = remeshed(&body, [5, 3, 4], &mut random);
    for (rest, xi) in after.rest.iter().zip(&xi) {
        assert!((rest - xi).amax() < 1e-13);
    }
    assert!(new.origin.contains(&NodeOrigin::Inside));
    assert!(
        new.origin
            .iter()
            .any(|origin| matches!(origin, NodeOrigin::Surface(_, weights) if weights.iter().all(|w| *w > 0.0)))
    );
    assert_eq!((after.defects.misses, after.defects.massless, after.defects.unchanged), (0, 0, 0.0));
}

#[test]
fn mass_and_momentum_are_kept_over_ten_meshes() {
    let mut random = TestRandom::new(4);
    let mut body = uneven(body([5, 4, 4], &mut random), &mut random).with_velocity(wavy);
    let (start, centre) = (body.books(), body.first_moment());
    for n in 0..10 {
        let (xi, new, after) = remeshed(&body, [3 + n % 4, 6 - n % 3, 4 + n % 2], &mut random);
        check_conserved(&after.defects, 1e-13);
        assert_eq!((after.defects.massless, after.defects.misses, after.defects.stray_mass), (0, 0, 0.0));
        body = body.after(xi, new, after);
    }
    let end = body.books();
    assert!((end.mass / start.mass - 1.0).abs() < 1e-13);
    assert!((end.momentum - start.momentum).norm() < 1e-13 * start.mass);
    assert!((body.first_moment() - centre).norm() < 1e-13 * start.mass);
    assert!((end.angular - start.angular).norm() < 1e-12 * start.mass);
}

#[test]
fn meshes_of_very_different_sizes_take_over_from_one_another() {
    let mut random = TestRandom::new(12);
    let layered = vec![0.0, 1e-6, 0.3, 0.5, 1.0];
    let body = body([4, 4, 4], &mut random).with_velocity(wavy);
    let meshes = [
        cells([2, 2, 2]),
        cells([9, 10, 8]),
        [layered.clone(), even(3), even(2)],
        [even(4), even(3), layered],
        cells([1, 1, 1]),
    ];
    check_sizes(body, &meshes, &mut random, &affine);
}

#[test]
fn a_uniform_body_stays_uniform_over_ten_meshes() {
    let mut random = TestRandom::new(11);
    let mut body = body([4, 4, 3], &mut random);
    for n in 0..10 {
        let (xi, new, after) = remeshed(&body, [3 + n % 3, 4 - n % 2, 5 - n % 3], &mut random);
        body = body.after(xi, new, after);
        for (element, corners) in body.mesh.elements.iter().zip(&body.corner_mass) {
            let wanted = 0.25 * body.mesh.measure(element);
            assert!(corners.iter().all(|corner| (corner - wanted).abs() < 1e-14), "{corners:?} {wanted}");
        }
    }
}

#[test]
fn a_uniform_velocity_stays_uniform() {
    let mut random = TestRandom::new(5);
    let v = Vector3::new(3.0, -2.0, 1.0);
    let body = uneven(body([4, 3, 4], &mut random), &mut random).with_velocity(|_| v);
    let (_, _, after) = remeshed(&body, [3, 5, 4], &mut random);
    for velocity in &after.velocity {
        assert!((velocity - v).amax() < 1e-13 * v.norm(), "{velocity}");
    }
}

#[test]
fn a_rotation_stays_one_and_keeps_its_angular_momentum() {
    let mut random = TestRandom::new(6);
    let rate = Vector3::new(0.3, -1.0, 0.5);
    let body = body([4, 4, 4], &mut random).with_velocity(|x| rate.cross(&(x - Vector3::new(0.2, 0.1, 0.4))));
    let (_, new, after) = remeshed(&body, [5, 4, 3], &mut random);
    let ConservationDefects { before, raw, after: end, .. } = after.defects;
    assert!((raw.momentum - before.momentum).norm() < 1e-13);
    let lost = (raw.angular - before.angular).norm() / before.angular.norm();
    assert!(lost > 1e-6 && lost < 0.1, "{lost}");
    assert!((end.angular - before.angular).norm() < 1e-12 * before.angular.norm());
    assert!((end.momentum - before.momentum).norm() < 1e-13);
    // The field is linear: the transfer reproduces it, and the correction adds a rotation.
    let added = |i: usize, j: usize| {
        let [x, v] = [&new.position, &after.velocity].map(|field| field[i] - field[j]);
        v - rate.cross(&x)
    };
    for i in 1..new.position.len() {
        let x = new.position[i] - new.position[0];
        assert!(added(i, 0).dot(&x).abs() < 1e-13 && added(i, 0).norm() < 0.1 * x.norm());
    }
    assert!(added(1, 0).norm() > 1e-6);
}

#[test]
fn momentum_absorbed_by_held_nodes_is_accounted_for() {
    let mut random = TestRandom::new(7);
    let mut body = body([4, 3, 3], &mut random).with_velocity(wavy);
    let held = |xi: &Vector3| [xi.x == 0.0 || xi.z == 0.0, xi.z == 0.0, xi.z == 0.0];
    for (i, xi) in body.xi.iter().enumerate() {
        body.mesh.held[i] = held(xi);
        (0..3).filter(|axis| body.mesh.held[i][*axis]).for_each(|axis| body.velocity[i][axis] = 0.0);
    }
    let (xi, _, after) = remeshed(&body, [3, 4, 4], &mut random);
    for ((xi, found), v) in xi.iter().zip(&after.held).zip(&after.velocity) {
        assert_eq!(*found, held(xi));
        assert!((0..3).all(|axis| !found[axis] || v[axis] == 0.0));
    }
    let defects = after.defects;
    check_conserved(&defects, 1e-13);
    assert!(defects.held_momentum.norm() > 1e-6);
    assert!((defects.after.angular + defects.held_angular - defects.before.angular).norm() < 1e-13);
    assert!((defects.raw.angular + defects.held_angular - defects.before.angular).norm() > 1e-6);
}

#[test]
fn mass_cut_off_by_a_dropped_boundary_node_is_deposited_nearby() {
    let mut random = TestRandom::new(8);
    for bulge in [0.02, -0.02] {
        let bulged = |xi: &Vector3| xi + Vector3::new(0.0, 0.0, bulge * xi.z * xi.x * (1.0 - xi.x));
        let body =
            TestBody::new(&cells([4, 3, 3]), (0.0, &mut random), (BodySymmetry::Spatial, &bulged)).with_velocity(wavy);
        let (xi, new) = body.other(&cells([2, 3, 3]), (0.0, &mut random), &bulged);
        let after = transfer(&body.moved(), &body.carried(), &new);
        assert!((after.defects.relative_mass() > 1e-4) == (bulge > 0.0) && after.defects.relative_mass() < 0.01);
        check_conserved(&after.defects, 1e-13);
        assert!((after.defects.after.angular - after.defects.before.angular).norm() < 1e-13);
        assert_eq!((after.defects.misses, after.defects.massless), (0, 0));
        let body = body.after(xi, new, after);
        assert!((body.books().mass - 1.0).abs() < 1e-13);
    }
}

#[test]
fn an_element_inside_out_gives_its_mass_to_its_neighbours() {
    let body = body([4, 4, 4], &mut TestRandom::new(10)).with_velocity(wavy);
    check_inverted(body, Vector3::new(0.3, 0.3, 0.2));
}

#[test]
fn nothing_at_all_can_be_transferred() {
    check_nothing::<3>(BodySymmetry::Spatial);
}

#[test]
fn a_node_has_an_even_share_of_a_uniform_body_and_less_in_a_corner_without_density() {
    let mut random = TestRandom::new(13);
    let mut body = body([4, 3, 3], &mut random);
    let (_, new, after) = remeshed(&body, [3, 4, 4], &mut random);
    assert!((least_relative_mass(&new.elements, &after) - 1.0).abs() < 1e-12);
    // The mass of every element around an interior node moves to its other corners.
    let inner = (0..body.xi.len()).find(|i| body.xi[*i].iter().all(|c| *c > 0.1 && *c < 0.9)).unwrap();
    for (element, corners) in body.mesh.elements.iter().zip(&mut body.corner_mass) {
        if let Some(k) = element.iter().position(|node| node.index() == inner) {
            let whole: f64 = corners.iter().sum();
            *corners = [0.95 * whole / 3.0; 4];
            corners[k] = 0.05 * whole;
        }
    }
    body.mass = nodal_masses::<3>(body.xi.len(), &body.mesh.elements, &body.corner_mass);
    let after = transfer(&body.moved(), &body.carried(), &new);
    assert!(least_relative_mass(&new.elements, &after) < 0.9);
    let body = body.with_velocity(wavy);
    let after = transfer(&body.moved(), &NodalFields { is_level: true, ..body.carried() }, &new);
    check_conserved(&after.defects, 1e-13);
    assert!(after.mass.iter().all(|mass| *mass > 0.0));
}

#[test]
fn an_element_that_weighs_less_than_nothing_is_light_though_its_nodes_are_not() {
    let mut random = TestRandom::new(14);
    let body = body([3, 3, 3], &mut random);
    let (_, new, mut after) = remeshed(&body, [4, 3, 3], &mut random);
    let (nodes, mass) = (new.elements[0], after.mass.clone());
    for (corner, node) in after.corner_mass[0].iter_mut().zip(&nodes) {
        // Other elements around the node compensate the negative mass.
        *corner = -0.01 * mass[node.index()];
    }
    assert_eq!(least_relative_mass(&new.elements, &after), 0.0);
}

/// Self-overlapping body: overlapping new elements share the mass, and nothing is taken where nothing overlaps.
#[test]
fn overlapping_new_elements_share_the_mass_they_cover() {
    let mut random = TestRandom::new(19);
    let body = body([4, 3, 3], &mut random).with_velocity(wavy);
    let (xi, once) = body.other(&cells([5, 3, 2]), (1.0, &mut random), &affine);
    let single = transfer(&body.moved(), &body.carried(), &once);
    let (n, mut twice) = (xi.len(), once.clone());
    twice.position.extend_from_within(..);
    twice.origin.extend_from_within(..);
    let again = |nodes: &Simplex| nodes.map(|node| NodeId(node.0 + n as u32));
    let is_left = |nodes: &&Simplex| nodes.iter().all(|node| xi[node.index()].x < 0.7);
    for part in [false, true] {
        let mut new = twice.clone();
        new.elements.extend(once.elements.iter().filter(|nodes| !part || is_left(nodes)).map(again));
        let after = transfer(&body.moved(), &body.carried(), &new);
        check_conserved(&after.defects, 1e-13);
        assert!(after.defects.stray_mass < 1e-13 * after.defects.before.mass, "{:e}", after.defects.stray_mass);
        let most = after.velocity.iter().map(Vector3::norm).fold(0.0, f64::max);
        assert!(most < 1.8, "{most}");
        for (i, whole) in single.mass.iter().enumerate().filter(|_| !part) {
            assert!((after.mass[i] - 0.5 * whole).abs() < 1e-14 && (after.mass[i + n] - 0.5 * whole).abs() < 1e-14);
            assert!((after.velocity[i] - single.velocity[i]).norm() < 1e-11, "node {i}");
        }
        let mut covered = vec![0.0; body.mesh.elements.len()];
        after.sources.iter().for_each(|source| covered[source.old.index()] += source.part);
        assert!(covered.iter().all(|covered| (covered - 1.0_f64).abs() < 1e-9), "{covered:?}");
    }
}
