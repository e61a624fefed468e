//! Properties of an immersed mesh of any body.

use super::super::test_meshes::{held, moved, rings, square};
use super::super::{
    AcceptanceLimits, DeformedMesh, MeshQuality, MeshRejected, NodeOrigin, ProposedMesh, RemeshError, check_acceptance,
    graded,
};
use super::*;
use crate::math::Vector;
use crate::mesh::{boundary, least_angle, signed_volume};
use proptest::prelude::*;
use std::f64::consts::TAU;

fn at(x: f64, y: f64) -> Vector<2> {
    Vector::<2>::new(x, y)
}

/// Mesh with these sizes and its acceptance; the area may change by as much as cutting allows.
fn made(old: &DeformedMesh<'_, 2>, sizes: &[f64]) -> (ImmersionSteps, Result<MeshQuality, MeshRejected>) {
    let steps = immerse(old, sizes).unwrap();
    let limits = AcceptanceLimits { measure: rounding(old, sizes) + 1e-12, quality: 0.0 };
    let found = check_acceptance(old, &steps.proposal, &limits);
    (steps, found)
}

fn area(points: &[Vector<2>], triangles: &[[usize; 3]]) -> f64 {
    let corners = |t: &[usize; 3]| t.map(|p| points[p]);
    let double = |[a, b, c]: [Vector<2>; 3]| (b - a).perp(&(c - a));
    0.5 * triangles.iter().map(|t| double(corners(t))).sum::<f64>()
}

/// Map that turns a square by an angle.
fn turned(angle: f64) -> impl Fn(&Vector<2>) -> Vector<2> {
    let (s, c) = angle.sin_cos();
    move |x| at(c * x[0] - s * x[1] + 3.0, s * x[0] + c * x[1] - 7.0)
}

/// Disc of radius 1 with waves along its edge.
fn wavy(x: &Vector<2>, waves: f64, height: f64) -> Vector<2> {
    let d = 2.0 * x - at(1.0, 1.0);
    let (square, round) = (d[0].abs().max(d[1].abs()), d.norm());
    let radius = 1.0 + height * (waves * d[1].atan2(d[0])).cos();
    if round == 0.0 { d } else { d * (square / round * radius) }
}

#[test]
fn straight_bodies_keep_their_area_and_are_well_shaped_however_they_lie() {
    for n in [4, 7, 16, 33, 80] {
        for angle in [0.0, 0.1, 0.3, 0.785, 1.2] {
            let mesh = square(n);
            let position = moved(&mesh, turned(angle));
            let (steps, found) =
                made(&DeformedMesh { mesh: &mesh, position: &position }, &vec![1.0 / n as f64; position.len()]);
            let found = found.unwrap();
            let ProposedMesh { position: x, elements, .. } = &steps.proposal;
            let least = elements.iter().map(|nodes| least_angle(x, nodes)).fold(180.0, f64::min);
            assert!(found.least > 0.35 && least > 13.0, "{n} cells turned by {angle}: {found:?}, {least}°");
            assert!(found.change.abs() < 1e-13, "{n} cells turned by {angle}: {found:?}");
        }
    }
}

#[test]
fn holes_and_parts_are_kept() {
    let mesh = rings(2, 0.25);
    let (_, found) = made(&DeformedMesh { mesh: &mesh, position: &mesh.rest }, &vec![0.2; mesh.rest.len()]);
    let found = found.unwrap();
    assert_eq!((found.parts, found.loops), (2, 4));
    assert!(found.change.abs() < 1e-12);
}

#[test]
fn a_round_boundary_changes_its_area_by_the_square_of_the_size() {
    let mesh = square(64);
    let position = moved(&mesh, |x| wavy(x, 5.0, 0.2));
    let old = DeformedMesh { mesh: &mesh, position: &position };
    let change = |size: f64| made(&old, &vec![size; position.len()]).1.unwrap().change;
    let [coarse, fine] = [change(0.2), change(0.05)];
    assert!(coarse.abs() > 4.0 * fine.abs(), "{coarse} and {fine}");
    assert!(coarse < 0.0 && coarse > -0.03 && fine > -2e-3, "{coarse} and {fine}");
}

#[test]
fn every_step_is_what_it_says() {
    let mesh = square(16);
    let position = moved(&mesh, |x| wavy(x, 3.0, 0.3));
    let old = DeformedMesh { mesh: &mesh, position: &position };
    let (steps, found) = made(&old, &vec![0.09; position.len()]);
    found.unwrap();
    let whole: f64 = steps.cells.iter().map(|cell| cell.edge * cell.edge).sum();
    let edge = whole.sqrt();
    assert!((area(&steps.background.points, &steps.background.triangles) / whole - 1.0).abs() < 1e-12);
    assert!((area(&steps.immersed.points, &steps.immersed.triangles) / whole - 1.0).abs() < 1e-12);
    let halvings = (edge / 0.09).log2();
    assert!((halvings - halvings.round()).abs() < 1e-12, "the finest cells have the size asked for: {edge}");
    for (p, distance) in steps.background.points.iter().zip(&steps.distance) {
        let edges = mesh.facets.iter().map(|f| [f[0], f[1]].map(|n| &position[n.index()]));
        let nearest = edges.map(|ends| super::super::triangle::clearance(ends, p)).fold(f64::MAX, f64::min);
        let inside = mesh.elements.iter().any(|e| {
            let [a, b, c] = [0, 1, 2].map(|k| &position[e[k].index()]);
            super::super::triangle::barycentric([a, b, c], p).iter().all(|s| *s >= 0.0)
        });
        assert!((distance.abs() - nearest).abs() < 1e-12 && (*distance < 0.0) == inside, "{distance} at {p}");
    }
    let far = steps.immersed.distance.iter().filter(|d| **d != 0.0).map(|d| d.abs()).fold(f64::MAX, f64::min);
    assert!(far >= 0.3 * 0.09, "a point is left {far} m from the boundary");
}

#[test]
fn all_of_the_new_boundary_comes_from_the_old_one() {
    let mesh = square(24);
    let position = moved(&mesh, |x| wavy(x, 4.0, 0.25));
    let old = DeformedMesh { mesh: &mesh, position: &position };
    let (steps, _) = made(&old, &vec![0.07; position.len()]);
    let new = &steps.proposal;
    let mut n_edges = 0;
    for node in boundary::<2>(&new.elements).iter().flat_map(|f| [f[0], f[1]]) {
        let x = new.position[node.index()];
        match new.origin[node.index()] {
            NodeOrigin::Kept(old) => assert_eq!(x, position[old.index()]),
            NodeOrigin::Surface([a, b, _], [u, v, _]) => {
                n_edges += 1;
                assert!((x - u * position[a.index()] - v * position[b.index()]).norm() < 1e-15);
            }
            NodeOrigin::Inside => panic!("the node at {x} is on no old edge"),
        }
    }
    assert!(n_edges > 50);
}

#[test]
fn corners_ends_of_what_is_held_and_the_axis_stay() {
    let mut mesh = held(48);
    let pinned = |x: &Vector<2>| x[1] == 1.0 && (0.24..0.76).contains(&x[0]);
    (0..mesh.rest.len()).filter(|&n| pinned(&mesh.rest[n])).for_each(|n| mesh.held[n] = [true; 2]);
    for size in [0.13, 0.031] {
        let (steps, found) = made(&DeformedMesh { mesh: &mesh, position: &mesh.rest }, &vec![size; mesh.rest.len()]);
        found.unwrap();
        for corner in [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(0.25, 1.0), at(0.75, 1.0)] {
            assert!(steps.proposal.position.contains(&corner), "{corner}");
        }
        for facet in boundary::<2>(&steps.proposal.elements) {
            let ends = [facet[0], facet[1]].map(|n| steps.proposal.position[n.index()]);
            let on_axis = ends.iter().all(|x| x[0] < 1e-3);
            assert!(!on_axis || ends.iter().all(|x| x[0] == 0.0), "{ends:?}");
        }
    }
}

#[test]
fn a_corner_pulled_straight_stays_a_node() {
    let mesh = square(24);
    let position = moved(&mesh, |x| x - 0.5 * x[0].powi(8) * x[1].powi(8) * at(1.0, 1.0));
    let (steps, found) = made(&DeformedMesh { mesh: &mesh, position: &position }, &vec![0.1; position.len()]);
    found.unwrap();
    assert!(steps.proposal.position.contains(&at(0.5, 0.5)));
}

#[test]
fn the_same_body_gives_the_same_bits() {
    let mesh = square(16);
    let position = moved(&mesh, |x| wavy(x, 3.0, 0.3));
    let old = DeformedMesh { mesh: &mesh, position: &position };
    let sizes: Vec<f64> = position.iter().map(|x| 0.03 + 0.1 * x.norm()).collect();
    let [one, two] = [0, 1].map(|_| made(&old, &sizes).0);
    assert!(one == two && one.proposal.elements.iter().all(|e| signed_volume(&one.proposal.position, e) > 0.0));
}

#[test]
fn invalid_target_sizes_and_non_finite_positions_are_refused() {
    let mesh = square(4);
    let with = |size: f64, place: f64| {
        let position = moved(&mesh, |x| if *x == at(0.5, 0.5) { at(place, 0.5) } else { *x });
        immerse(&DeformedMesh { mesh: &mesh, position: &position }, &vec![size; mesh.rest.len()])
    };
    assert!(matches!(with(0.0, 0.5), Err(RemeshError::Size { .. })));
    assert!(matches!(with(0.25, f64::NAN), Err(RemeshError::NotFinite { .. })));
    assert!(matches!(with(1e-9, 0.5), Err(RemeshError::TooMany { .. })));
    let short = immerse(&DeformedMesh { mesh: &mesh, position: &mesh.rest }, &[1.0]);
    assert!(matches!(short, Err(RemeshError::Counts { sizes: 1, .. })));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn smooth_bodies_of_any_size_and_place_are_cut_out_whole(
        (waves, height) in (0_u32..7, 0.0_f64..0.12),
        (x, y, angle) in (-3.0_f64..3.0, -3.0_f64..3.0, 0.0_f64..TAU),
        seeds in prop::collection::vec(0.04_f64..0.2, 81),
        growth in 0.05_f64..0.5,
    ) {
        let mesh = square(32);
        let (s, c) = angle.sin_cos();
        let place = |p: &Vector<2>| at(c * p[0] - s * p[1] + x, s * p[0] + c * p[1] + y);
        let position = moved(&mesh, |p| place(&wavy(p, f64::from(waves), height)));
        let old = DeformedMesh { mesh: &mesh, position: &position };
        let size = graded(&old, (0..position.len()).map(|n| seeds[n % seeds.len()]).collect(), growth);
        let (_, found) = made(&old, &size);
        prop_assert!(found.is_ok_and(|found| found.least > 0.05), "{:?}", found);
    }

    #[test]
    fn ragged_bodies_give_a_mesh_that_is_upright_and_closed_or_is_refused(
        radii in prop::collection::vec(0.3_f64..1.0, 3..24),
        seeds in prop::collection::vec(0.05_f64..0.5, 81),
        growth in 0.05_f64..0.6,
    ) {
        let mesh = square(8);
        let n = radii.len();
        let radius = |angle: f64| {
            let place = angle / TAU * n as f64;
            let (i, share) = (place as usize % n, place.fract());
            radii[i] * (1.0 - share) + radii[(i + 1) % n] * share
        };
        let star = |x: &Vector<2>| {
            let d = 2.0 * x - at(1.0, 1.0);
            let (square, round) = (d[0].abs().max(d[1].abs()), d.norm());
            if round == 0.0 { d } else { d * (square / round * radius(d[1].atan2(d[0]).rem_euclid(TAU))) }
        };
        let position = moved(&mesh, star);
        let old = DeformedMesh { mesh: &mesh, position: &position };
        let size = graded(&old, (0..position.len()).map(|n| seeds[n % seeds.len()]).collect(), growth);
        let (steps, found) = made(&old, &size);
        let upright = |e: &crate::mesh::Simplex| signed_volume(&steps.proposal.position, e) > 0.0;
        prop_assert!(steps.proposal.elements.iter().all(upright));
        let too_coarse = matches!(found, Err(MeshRejected::Measure { .. } | MeshRejected::Parts { .. } | MeshRejected::Loops { .. }));
        prop_assert!(found.is_ok() || too_coarse, "{:?}", found);
    }
}
