//! Properties of a plane remesh of any body.

use super::plane::propose;
use super::test_meshes::{held, moved, rings, square};
use super::*;
use crate::math::Vector;
use crate::mesh::{Mesh, NodeId, Simplex, least_angle, signed_volume};
use proptest::prelude::*;
use std::collections::HashSet;
use std::f64::consts::{PI, TAU};

const ANY: AcceptanceLimits = AcceptanceLimits { measure: 1.0, quality: 0.0 };
const SAME_AREA: AcceptanceLimits = AcceptanceLimits { measure: 1e-12, quality: 0.0 };
const ALL_NODES: RemeshRules = RemeshRules { good: 0.5, poor: 0.3, sag: 0.0, slide: 0.0, rests: true, most: 100_000 };

type SizeFunction = fn(&Vector<2>) -> f64;
type PlaneMap = fn(&Vector<2>) -> Vector<2>;

fn at(x: f64, y: f64) -> Vector<2> {
    Vector::<2>::new(x, y)
}

fn sheared(x: &Vector<2>) -> Vector<2> {
    at(x[0] + 1.5 * x[1], x[1])
}

fn stretched(x: &Vector<2>) -> Vector<2> {
    at(3.0 * x[0], x[1] / 3.0)
}

/// Indentation in the middle of the top.
fn indented(x: &Vector<2>) -> Vector<2> {
    at(x[0], x[1] - 0.4 * (-((x[0] - 0.5) / 0.12).powi(2)).exp() * x[1].powi(2))
}

/// Half turn of the middle: elements there are inverted.
fn twirled(x: &Vector<2>) -> Vector<2> {
    let d = x - at(0.5, 0.5);
    let (sin, cos) = (3.0 * (-(d.norm() / 0.15).powi(2)).exp()).sin_cos();
    at(0.5 + d[0] * cos - d[1] * sin, 0.5 + d[0] * sin + d[1] * cos)
}

fn uneven(x: &Vector<2>) -> f64 {
    (0.02 + 0.2 * (x - at(0.5, 1.0)).norm()).min(0.1)
}

fn worst_angle(x: &[Vector<2>], elements: &[Simplex]) -> f64 {
    elements.iter().map(|e| if signed_volume(x, e) > 0.0 { least_angle(x, e) } else { 0.0 }).fold(180.0, f64::min)
}

fn remeshed(old: &DeformedMesh<'_, 2>, size: impl Fn(&Vector<2>) -> f64, rules: &RemeshRules) -> ProposedMesh<2> {
    let sizes: Vec<f64> = old.position.iter().map(size).collect();
    propose(old, &sizes, rules, &|x| *x).unwrap()
}

fn settled(new: &ProposedMesh<2>) -> Mesh<2> {
    Mesh::new(new.position.clone(), new.elements.clone())
}

/// Number of elements that survive node by node.
fn surviving(old: &DeformedMesh<'_, 2>, new: &ProposedMesh<2>) -> usize {
    let was = |node: NodeId| match new.origin[node.index()] {
        NodeOrigin::Kept(node) => Some(node),
        NodeOrigin::Surface(..) | NodeOrigin::Inside => None,
    };
    let ours: HashSet<[Option<NodeId>; 3]> = old.mesh.elements.iter().map(|e| [e[0], e[1], e[2]].map(Some)).collect();
    new.elements.iter().filter(|e| ours.contains(&[e[0], e[1], e[2]].map(was))).count()
}

fn find(x: &[Vector<2>], point: &Vector<2>) -> Option<usize> {
    x.iter().position(|x| x == point)
}

/// Cases: name, mesh, map and target size.
fn cases() -> Vec<(&'static str, Mesh<2>, PlaneMap, SizeFunction)> {
    vec![
        ("sheared", square(16), sheared, |_| 1.0 / 16.0),
        ("stretched", square(16), stretched, |_| 1.0 / 16.0),
        ("indented", square(32), indented, |_| 1.0 / 32.0),
        ("twirled", square(32), twirled, |_| 1.0 / 32.0),
        ("refined", square(16), |x| *x, |_| 1.0 / 50.0),
        ("graded", square(16), |x| *x, uneven),
        ("coarsened", square(48), |x| *x, |_| 0.1),
        ("two rings", rings(2, 0.25), sheared, |_| 0.25),
    ]
}

#[test]
fn new_meshes_are_good_fill_the_body_and_keep_its_parts() {
    for (name, mesh, map, size) in cases() {
        let position = moved(&mesh, map);
        let old = DeformedMesh { mesh: &mesh, position: &position };
        let new = remeshed(&old, size, &RemeshRules::default());
        let found = check_acceptance(&old, &new, &SAME_AREA);
        let best = worst_angle(&position, &mesh.elements).min(20.0);
        let worst = worst_angle(&new.position, &new.elements);
        assert!(found.is_ok() && worst >= best.max(15.0), "{name}: {found:?}, {worst}°");
    }
}

#[test]
fn a_mesh_that_was_just_made_is_made_again_to_the_bit() {
    for (name, mesh, map, size) in cases() {
        let position = moved(&mesh, map);
        let new = remeshed(&DeformedMesh { mesh: &mesh, position: &position }, size, &RemeshRules::default());
        let mesh = settled(&new);
        let again = remeshed(&DeformedMesh { mesh: &mesh, position: &mesh.rest }, size, &RemeshRules::default());
        assert!(again.elements == new.elements && again.position == new.position, "{name}");
        assert!(again.origin.iter().enumerate().all(|(n, o)| *o == NodeOrigin::Kept(NodeId(n as u32))), "{name}");
    }
}

#[test]
fn what_did_not_change_stays_as_it_is() {
    let mesh = square(16);
    let position = moved(&mesh, |x| x + at(0.002 * (7.0 * x[1]).sin(), 0.003 * x[0]));
    let new = remeshed(&DeformedMesh { mesh: &mesh, position: &position }, |_| 1.0 / 16.0, &RemeshRules::default());
    assert_eq!(new.elements.len(), mesh.elements.len());
    assert!(new.elements.iter().zip(&mesh.elements).all(|(e, was)| e[..3] == was[..3]));
    assert_eq!(new.position, position);
}

#[test]
fn elements_far_from_a_distortion_stay() {
    let mesh = square(32);
    let position = moved(&mesh, twirled);
    let old = DeformedMesh { mesh: &mesh, position: &position };
    let new = remeshed(&old, |_| 1.0 / 32.0, &RemeshRules::default());
    let far =
        mesh.elements.iter().filter(|e| e[..3].iter().all(|n| (mesh.rest[n.index()] - at(0.5, 0.5)).norm() > 0.4));
    let (stays, far) = (surviving(&old, &new), far.count());
    assert!(far > 1000 && stays >= far, "{stays} of {far}");
}

#[test]
fn origins_say_where_nodes_come_from() {
    let (mut edges, mut inside) = (0, 0);
    for (name, mesh, map, size) in cases() {
        let position = moved(&mesh, map);
        let new = remeshed(&DeformedMesh { mesh: &mesh, position: &position }, size, &RemeshRules::default());
        let facets: Vec<[NodeId; 2]> = mesh.facets.iter().map(|f| [f[0], f[1]]).collect();
        for (x, origin) in new.position.iter().zip(&new.origin) {
            match *origin {
                NodeOrigin::Kept(node) => assert_eq!(*x, position[node.index()]),
                NodeOrigin::Surface([a, b, c], [r, s, none]) => {
                    assert!(facets.contains(&[a, b]) && s > 0.0 && s < 1.0, "{name}: {a:?} {b:?} {s}");
                    assert!(c == b && none == 0.0 && r == 1.0 - s);
                    assert!((x - r * position[a.index()] - s * position[b.index()]).norm() < 1e-15);
                }
                NodeOrigin::Inside => {}
            }
        }
        edges += new.origin.iter().filter(|o| matches!(o, NodeOrigin::Surface(..))).count();
        inside += new.origin.iter().filter(|o| **o == NodeOrigin::Inside).count();
    }
    assert!(edges > 100 && inside > 1000, "{edges} {inside}");
}

#[test]
fn corners_and_the_ends_of_what_is_held_stay() {
    let mut mesh = held(48);
    // A part of the free top is held as well: it ends between the corners.
    let pinned = |x: &Vector<2>| x[1] == 1.0 && (0.24..0.76).contains(&x[0]);
    (0..mesh.rest.len()).filter(|&n| pinned(&mesh.rest[n])).for_each(|n| mesh.held[n] = [true; 2]);
    let new = remeshed(&DeformedMesh { mesh: &mesh, position: &mesh.rest }, |_| 0.13, &RemeshRules::default());
    assert!(new.position.len() < mesh.rest.len() / 10);
    for corner in [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(0.25, 1.0), at(0.75, 1.0)] {
        assert!(find(&new.position, &corner).is_some(), "{corner}");
    }
}

#[test]
fn a_corner_at_rest_stays_a_node_when_it_is_pulled_straight() {
    let mesh = square(24);
    // The upper right corner is pushed in until the sides that meet there are one line.
    let position = moved(&mesh, |x| x - 0.5 * x[0].powi(8) * x[1].powi(8) * at(1.0, 1.0));
    let old = DeformedMesh { mesh: &mesh, position: &position };
    let new = remeshed(&old, |_| 0.2, &RemeshRules::default());
    assert!(find(&new.position, &at(0.5, 0.5)).is_some());
    check_acceptance(&old, &new, &AcceptanceLimits { measure: 0.01, quality: 0.0 }).unwrap();
}

#[test]
fn a_round_boundary_loses_nodes_but_little_area() {
    let mesh = square(64);
    let position = moved(&mesh, |x| star(&(2.0 * x - at(1.0, 1.0)), |_| 1.0));
    let old = DeformedMesh { mesh: &mesh, position: &position };
    let new = remeshed(&old, |_| 0.25, &RemeshRules::default());
    let found = check_acceptance(&old, &new, &AcceptanceLimits { measure: 0.03, quality: 0.3 });
    assert!(found.is_ok() && settled(&new).facets.len() < 80, "{found:?} {}", settled(&new).facets.len());
}

#[test]
fn a_boundary_that_crosses_itself_is_an_error() {
    let mesh = square(8);
    let through = moved(&mesh, |x| if *x == at(0.5, 1.0) { at(0.5, -0.3) } else { *x });
    let sizes = vec![0.125; mesh.rest.len()];
    let found = propose(&DeformedMesh { mesh: &mesh, position: &through }, &sizes, &RemeshRules::default(), &|x| *x);
    assert!(matches!(found, Err(RemeshError::Crossing { .. })), "{found:?}");
    let touching = moved(&mesh, |x| if *x == at(0.5, 1.0) { at(0.5625, 0.0) } else { *x });
    let found = propose(&DeformedMesh { mesh: &mesh, position: &touching }, &sizes, &RemeshRules::default(), &|x| *x);
    assert!(matches!(found, Err(RemeshError::Blocked { .. })), "{found:?}");
    let meeting = moved(&mesh, |x| if *x == at(0.5, 1.0) { at(0.5, 0.0) } else { *x });
    let found = propose(&DeformedMesh { mesh: &mesh, position: &meeting }, &sizes, &RemeshRules::default(), &|x| *x);
    assert!(matches!(found, Err(RemeshError::Blocked { .. } | RemeshError::Coincident { .. })), "{found:?}");
}

/// Falling splash: a long bow of the wall, of which only the tip enters the gel.
#[test]
fn a_tip_that_is_pushed_through_another_wall_is_cut_off() {
    let mesh = rings(2, 0.25);
    // Each ring has a tip drawn out of its wall into the other ring.
    for (node, tip) in [(at(4.0, 1.5), at(2.97, 1.52)), (at(3.0, 1.5), at(3.13, 1.52))] {
        let beside = |x: &Vector<2>| if x[0] > 3.5 { x - at(0.9, 0.0) } else { *x };
        let position = moved(&mesh, |x| if *x == node { tip } else { beside(x) });
        let old = DeformedMesh { mesh: &mesh, position: &position };
        let new = remeshed(&old, |_| 0.25, &RemeshRules::default());
        assert_eq!(find(&new.position, &tip), None);
        let found = check_acceptance(&old, &new, &SAME_AREA).unwrap();
        assert!((found.parts, found.loops) == (2, 4) && new.cleared > 0.0 && new.cleared < 0.06, "{found:?}");
    }
}

/// Hole of a ring, pushed through its wall: closing the gap would create gel.
#[test]
fn a_gap_that_is_pushed_through_a_wall_is_not_filled() {
    let mesh = rings(1, 0.5);
    let position = moved(&mesh, |x| if *x == at(2.0, 1.5) { at(3.1, 1.5) } else { *x });
    let sizes = vec![0.8; mesh.rest.len()];
    let found = propose(&DeformedMesh { mesh: &mesh, position: &position }, &sizes, &RemeshRules::default(), &|x| *x);
    assert!(matches!(found, Err(RemeshError::Crossing { .. })), "{found:?}");
}

/// Square with displaced boundary nodes, remeshed.
fn displaced(mesh: &Mesh<2>, places: &[(Vector<2>, Vector<2>)], rules: &RemeshRules) -> ProposedMesh<2> {
    let place = |x: &Vector<2>| places.iter().find(|(from, _)| from == x).map_or(*x, |(_, to)| *to);
    let position = moved(mesh, place);
    let old = DeformedMesh { mesh, position: &position };
    let new = propose(&old, &vec![0.125; position.len()], rules, &|x| *x).unwrap();
    let found = check_acceptance(&old, &new, &AcceptanceLimits { measure: 0.01, quality: 0.1 });
    assert!(found.is_ok(), "{found:?}");
    new
}

/// Returns for each place true if it is still a node.
fn stayed(new: &ProposedMesh<2>, places: &[(Vector<2>, Vector<2>)]) -> Vec<bool> {
    places.iter().map(|(_, to)| find(&new.position, to).is_some()).collect()
}

/// A pit folded over by the tip looks like a needle; without the pit the tip would stand in the gel.
#[test]
fn a_tip_that_folds_over_a_pit_and_through_its_wall_goes_with_the_pit() {
    let folded = |places: &[(Vector<2>, Vector<2>)], rests: bool| {
        stayed(&displaced(&square(8), places, &RemeshRules { rests, ..RemeshRules::default() }), &places[..2])
    };
    let tip = [(at(0.625, 1.0), at(0.4, 0.98)), (at(0.5, 1.0), at(0.5, 0.95))];
    for rests in [false, true] {
        assert_eq!(folded(&tip, rests), [false; 2]);
    }
    // A gel with a surface at rest keeps its corners; a two-network gel has none.
    let corner = [(at(1.0, 1.0), at(0.775, 0.98)), (at(0.875, 1.0), at(0.875, 0.95)), (at(1.0, 0.875), at(1.125, 1.0))];
    assert!(folded(&corner, true)[0]);
    assert_eq!(folded(&corner, false), [false; 2]);
}

#[test]
fn a_tip_that_goes_in_and_out_of_a_wall_goes_with_all_between() {
    let places = [(0.75, at(0.34, 0.972)), (0.625, at(0.62, 0.965)), (0.5, at(0.6, 0.93)), (0.375, at(0.45, 0.95))];
    let places = places.map(|(x, to)| (at(x, 1.0), to));
    assert_eq!(stayed(&displaced(&square(8), &places, &RemeshRules::default()), &places), [false; 4]);
}

#[test]
fn a_node_that_is_beyond_the_axis_is_cut_off() {
    for place in [at(-0.05, 1.05), at(-0.02, 1.01)] {
        let new = displaced(&held(8), &[(at(0.125, 1.0), place)], &RemeshRules::default());
        assert!(new.position.iter().all(|x| x[0] >= 0.0));
    }
}

#[test]
fn what_cannot_be_meshed_with_is_refused() {
    let mesh = square(4);
    let with = |size: f64, place: f64| {
        let position = moved(&mesh, |x| if *x == at(0.5, 0.5) { at(place, 0.5) } else { *x });
        propose(
            &DeformedMesh { mesh: &mesh, position: &position },
            &vec![size; mesh.rest.len()],
            &RemeshRules::default(),
            &|x| *x,
        )
    };
    assert!(matches!(with(0.0, 0.5), Err(RemeshError::Size { .. })));
    assert!(matches!(with(0.25, f64::NAN), Err(RemeshError::NotFinite { .. })));
    assert!(matches!(with(1e-9, 0.5), Err(RemeshError::TooMany { .. })));
    let short = propose(&DeformedMesh { mesh: &mesh, position: &mesh.rest }, &[1.0], &RemeshRules::default(), &|x| *x);
    assert!(matches!(short, Err(RemeshError::Counts { sizes: 1, .. })));
}

#[test]
fn sixty_remeshes_of_a_body_that_flows_keep_it_good() {
    // The stream function ψ = sin 2πx sin πz/2 draws the middle of the top down, and the sides up.
    let flow = |x: &Vector<2>| {
        let ([s, c], [t, d]) =
            ([(TAU * x[0]).sin(), (TAU * x[0]).cos()], [(PI * x[1] / 2.0).sin(), (PI * x[1] / 2.0).cos()]);
        0.02 * at(-0.25 * s * d, c * t)
    };
    let mut mesh = square(16);
    let size = |x: &Vector<2>| (0.02 + 0.3 * (x[0] - 0.5).abs()).min(0.0625);
    let (mut area, mut angle) = (0.0_f64, 180.0_f64);
    for _ in 0..60 {
        let position = moved(&mesh, |x| x + flow(x));
        let old = DeformedMesh { mesh: &mesh, position: &position };
        let new = remeshed(&old, size, &RemeshRules::default());
        let found = check_acceptance(&old, &new, &AcceptanceLimits { measure: 1e-3, quality: 0.1 });
        let found = found.unwrap();
        area += found.change.abs();
        angle = angle.min(worst_angle(&new.position, &new.elements));
        mesh = settled(&new);
    }
    assert!(area < 1e-2 && angle > 10.0, "{area} {angle}");
}

/// Triangles per second of a new mesh of about 100 000, all of them new or all of them kept; run with `--release`.
#[test]
#[ignore = "a measurement, not a claim"]
fn speed() {
    let mesh = square(160);
    for (name, map) in [("all new", sheared as PlaneMap), ("a dent", indented), ("nothing new", |x| *x)] {
        let position = moved(&mesh, map);
        let old = DeformedMesh { mesh: &mesh, position: &position };
        let sizes = vec![1.0 / 160.0; position.len()];
        let fine = vec![1.0 / 230.0; position.len()];
        for size in [&sizes, &fine] {
            let timed = || {
                let start = std::time::Instant::now();
                (propose(&old, size, &RemeshRules::default(), &|x| *x).unwrap(), start.elapsed().as_secs_f64())
            };
            let (new, first) = timed();
            let seconds = (0..4).map(|_| timed().1).fold(first, f64::min);
            let n = new.elements.len();
            let shares = surviving(&old, &new) as f64 / mesh.elements.len() as f64;
            println!("{name}: {n} triangles, {shares:.4} stay, {seconds:.3} s, {:.0} triangles/s", n as f64 / seconds);
        }
    }
}

/// Star: a point of the square of ±1 moves along its ray; the boundary goes to `radius`, a function of the angle.
fn star(x: &Vector<2>, radius: impl Fn(f64) -> f64) -> Vector<2> {
    let (square, round) = (x[0].abs().max(x[1].abs()), x.norm());
    if round == 0.0 { *x } else { x * (square / round * radius(x[1].atan2(x[0]).rem_euclid(TAU))) }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn stars_of_any_size_are_filled(
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
        let position = moved(&mesh, |x| star(&(2.0 * x - at(1.0, 1.0)), radius));
        let old = DeformedMesh { mesh: &mesh, position: &position };
        let asked: Vec<f64> = (0..position.len()).map(|n| seeds[n % seeds.len()]).collect();
        let size = graded(&old, asked, growth);
        let filled = propose(&old, &size, &ALL_NODES, &|x| *x).unwrap();
        prop_assert!(check_acceptance(&old, &filled, &SAME_AREA).is_ok(), "{:?}", check_acceptance(&old, &filled, &SAME_AREA));
        let fewer = propose(&old, &size, &RemeshRules::default(), &|x| *x).unwrap();
        let limits = AcceptanceLimits { measure: 0.02, quality: 0.0 };
        prop_assert!(check_acceptance(&old, &fewer, &limits).is_ok(), "{:?}", check_acceptance(&old, &fewer, &limits));
    }

    #[test]
    fn nodes_anywhere_give_a_mesh_or_an_error(
        places in prop::collection::vec((-1.0_f64..1.0, -1.0_f64..1.0), 41),
        inside in any::<bool>(),
    ) {
        let mesh = square(4);
        let is_inside = |x: &Vector<2>| x.iter().all(|x| *x > 0.0 && *x < 1.0);
        let place = |(n, x): (usize, &Vector<2>)| {
            if inside && !is_inside(x) { *x } else { at(places[n].0, places[n].1) }
        };
        let position: Vec<Vector<2>> = mesh.rest.iter().enumerate().map(place).collect();
        let old = DeformedMesh { mesh: &mesh, position: &position };
        let new = propose(&old, &vec![0.2; position.len()], &RemeshRules::default(), &|x| *x);
        if inside {
            // However the nodes inside are entangled, the body is filled.
            let found = check_acceptance(&old, &new.unwrap(), &SAME_AREA);
            prop_assert!(found.is_ok(), "{found:?}");
        } else if let Ok(new) = new {
            let _ = check_acceptance(&old, &new, &ANY);
        }
    }
}
