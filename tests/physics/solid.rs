//! Bodies with a surface of triangles: their distance, volume and inertia, and the surfaces that are refused.

#![allow(dead_code, reason = "the bodies are shared with the tests of whole scenes")]

use crate::solid_bodies as bodies;
use ballistic_gel::geometry::{RoundedCuboid, SignedDistance, SurfaceError, TriangleSurface, TriangulatedBody};
use ballistic_gel::math::{Tensor3, Vector3};
use bodies::{Triangles, angle, cuboid, cylinder, fork, moved, reversed, sphere, turned};
use nalgebra::Rotation3;
use parry3d_f64::math::Vector as Point;
use parry3d_f64::query::PointQuery as _;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};
use std::f64::consts::PI;

fn solid(triangles: &Triangles) -> TriangulatedBody {
    TriangulatedBody::new(TriangleSurface::new(triangles).unwrap(), 1.0).unwrap()
}

/// A bullet with a point.
fn bullet() -> Triangles {
    turned(&[(0.0, -2.0), (0.3, -1.5), (0.6, -0.5), (0.7, 0.5), (0.7, 2.0), (0.5, 2.5), (0.0, 2.5)], 24)
}

fn bodies() -> [Triangles; 5] {
    [bullet(), angle(), cuboid([1.0, 2.0, 0.5]), sphere(1.0, 12), fork()]
}

/// Points all around and within a body, denser near it.
fn points(size: f64) -> impl Iterator<Item = Vector3> {
    (0..3000).map(move |i| {
        let t = f64::from(i);
        let direction = Vector3::new((t * 0.711).sin(), (t * 1.37).cos(), (t * 0.239).sin());
        direction * (size * (0.05 + 2.0 * (t / 3000.0).powi(2)))
    })
}

/// The distance by another implementation.
struct Referee(TriMesh);

impl Referee {
    fn of(solid: &TriangulatedBody) -> Self {
        let points = solid.points().iter().map(|p| Point::new(p.x, p.y, p.z)).collect();
        Self(TriMesh::with_flags(points, solid.triangles().to_vec(), TriMeshFlags::ORIENTED).unwrap())
    }

    fn distance(&self, p: &Vector3) -> f64 {
        let p = Point::new(p.x, p.y, p.z);
        let found = self.0.project_local_point(p, false);
        let distance = (p - found.point).length();
        if found.is_inside { -distance } else { distance }
    }
}

fn longest(triangles: &Triangles) -> f64 {
    let all = || triangles.iter().flatten();
    let (lower, upper) = all().fold((triangles[0][0], triangles[0][0]), |(l, u), p| (l.inf(p), u.sup(p)));
    (upper - lower).max()
}

#[test]
fn the_distance_is_that_of_another_implementation_near_the_surface_and_a_bound_far_from_it() {
    for body in bodies() {
        let (solid, cell) = (solid(&body), longest(&body) / 16.0);
        let referee = Referee::of(&solid);
        let (mut near, mut far) = (0, 0);
        for p in points(longest(&body)) {
            let (found, truth) = (solid.gap(&p), referee.distance(&p));
            assert!((found.normal.norm() - 1.0).abs() < 1e-12);
            if truth < 2.0 * cell {
                near += 1;
                assert!((found.distance - truth).abs() < 1e-12, "{p}: {} {truth}", found.distance);
            } else {
                far += 1;
                assert!(found.distance <= truth + 1e-12 && found.distance > 0.0, "{p}: {} {truth}", found.distance);
                // In the grid, which reaches a cell further than the body.
                let in_grid = [Vector3::x(), Vector3::y(), Vector3::z()]
                    .iter()
                    .all(|axis| p.dot(axis) < solid.reach(axis) && -p.dot(axis) < solid.reach(&-axis));
                assert!(!in_grid || found.distance > truth - 3.0_f64.sqrt() * cell, "{p}: {} {truth}", found.distance);
            }
        }
        assert!(near > 300 && far > 1000, "{near} {far}");
    }
}

#[test]
fn normals_are_the_gradient_of_the_distance() {
    let step = 1e-6;
    for body in bodies() {
        let (solid, band) = (solid(&body), longest(&body) / 8.0);
        let exact = points(longest(&body)).filter(|p| solid.gap(p).distance < 0.9 * band);
        let slopes = exact.filter_map(|p| {
            let gap = solid.gap(&p);
            let probe = |i: usize, s: f64| solid.gap(&(p + Vector3::ith(i, s))).distance;
            let slope = Vector3::from_fn(|i, _| (probe(i, step) - probe(i, -step)) / (2.0 * step));
            // A ridge of the distance has no gradient: there the two one-sided slopes differ.
            let kink = (0..3).any(|i| (probe(i, step) + probe(i, -step) - 2.0 * gap.distance).abs() > 1e-9);
            (!kink).then_some((slope, gap.normal))
        });
        let checked = slopes.inspect(|(slope, normal)| assert!((slope - normal).norm() < 1e-6)).count();
        assert!(checked > 300, "only {checked} points were smooth");
    }
}

#[test]
fn on_edges_and_corners_the_normal_is_a_unit_vector_outwards() {
    let body = solid(&cuboid([1.0, 2.0, 0.5]));
    for p in body.points().iter().chain(&[Vector3::new(0.5, 0.3, 0.25), Vector3::new(0.5, 0.3, 0.1)]) {
        for p in [*p, p * (1.0 + 1e-16)] {
            let gap = body.gap(&p);
            assert!(gap.distance.abs() < 1e-15 && (gap.normal.norm() - 1.0).abs() < 1e-15);
            assert!(gap.normal.dot(&p) > 0.0 && body.gap(&(p + 0.01 * gap.normal)).distance > 0.005);
        }
    }
}

#[test]
fn a_sphere_of_triangles_comes_near_the_sphere_with_the_square_of_its_facets() {
    let errors = [8, 16, 32, 64].map(|n| {
        let body = solid(&moved(&sphere(2.0, n), Vector3::new(0.3, -0.2, 0.9)));
        let inertia = (body.specific_inertia().unwrap() - Tensor3::identity() * 1.6).norm() / 1.6;
        let distance = points(2.0).map(|p| (body.gap(&p).distance - (p.norm() - 2.0), p.norm()));
        let distance = distance.filter(|(_, r)| *r < 2.03).fold(0.0_f64, |most, (error, _)| most.max(error.abs()));
        assert!((body.centre() - Vector3::new(0.3, -0.2, 0.9)).norm() < 1e-14);
        assert!((body.inner_radius() - 2.0).abs() <= distance * 1.5 && (body.reach(&Vector3::z()) - 2.0).abs() < 1e-14);
        [(body.volume().unwrap() / (32.0 / 3.0 * PI) - 1.0).abs(), inertia, distance / 2.0]
    });
    for pair in errors.windows(2) {
        for (coarse, fine) in pair[0].iter().zip(&pair[1]) {
            assert!((3.2..4.8).contains(&(coarse / fine)), "{errors:?}");
        }
    }
    assert!(errors[3][0] < 3e-3 && errors[3][2] < 2e-3, "{errors:?}");
}

#[test]
fn a_cuboid_of_triangles_is_a_plate() {
    let size = [1.0, 2.0, 0.5];
    let (body, plate) = (solid(&cuboid(size)), RoundedCuboid::new(size, 0.0));
    assert!((body.volume().unwrap() - plate.volume().unwrap()).abs() < 1e-15);
    assert!((body.specific_inertia().unwrap() - plate.specific_inertia().unwrap()).norm() < 1e-15);
    assert!((body.inner_radius() - plate.inner_radius()).abs() < 1e-3);
    let near = points(2.0).filter(|p| plate.gap(p).distance < 2.0 / 8.0);
    let same = near.inspect(|p| assert!((body.gap(p).distance - plate.gap(p).distance).abs() < 1e-15)).count();
    assert!(same > 300, "{same}");
    for direction in points(1.0).take(100).map(|p| p.normalize()) {
        assert!((body.reach(&direction) - plate.reach(&direction)).abs() < 1e-15);
    }
}

#[test]
fn tips_are_corners_sharper_than_that_of_a_cube() {
    let tips = |body: &Triangles| solid(body).tips().len();
    assert_eq!([sphere(1.0, 16), cuboid([1.0, 2.0, 0.5]), cylinder(1.0, 4.0, 48)].map(|body| tips(&body)), [0; 3]);
    let cone = |half_angle: f64, flat: f64| {
        let behind = -2.0 - (1.0 - flat) / half_angle.to_radians().tan();
        let profile = [(0.0, behind), (flat, behind), (1.0, -2.0), (1.0, 2.0), (0.0, 2.0)];
        turned(&profile[usize::from(flat == 0.0)..], 32)
    };
    for (half_angle, flat, expected) in
        [(25.0, 0.0, 1), (33.0, 0.0, 1), (25.0, 0.02, 1), (37.0, 0.0, 0), (25.0, 0.5, 0)]
    {
        let body = cone(half_angle, flat);
        assert_eq!(tips(&body), expected, "{half_angle} {flat}");
    }
    let pointed = solid(&cone(25.0, 0.0));
    assert!((pointed.tips()[0].end + Vector3::z() * pointed.reach(&-Vector3::z())).norm() < 1e-12);
}

/// A ball with a thin thorn: the thorn is small, and a tip.
#[test]
fn a_small_thorn_on_a_large_body_is_a_tip() {
    let mut ball: Vec<(f64, f64)> = (3..=24).map(|i| f64::from(i) * PI / 24.0).map(|a| (a.sin(), -a.cos())).collect();
    ball.last_mut().unwrap().0 = 0.0;
    let body = solid(&turned(&[&[(0.0, -1.5), (0.1, -1.1)], &ball[..]].concat(), 32));
    assert_eq!(body.tips().len(), 1);
    assert!((body.tips()[0].end.z + 1.5 + body.centre().z).abs() < 1e-12);
}

/// The half-angle is 25° below a rounded end, and the thorn a tenth of the ball's radius: each is a tip at one scale only.
#[test]
fn a_tip_is_sharp_at_a_coarse_or_at_a_fine_scale() {
    let round = 0.1;
    let end: Vec<(f64, f64)> = (0..=8)
        .map(|i| 65.0_f64.to_radians() * f64::from(i) / 8.0)
        .collect::<Vec<_>>()
        .iter()
        .map(|a| (round * a.sin(), -round * a.cos()))
        .collect();
    let rear = (1.0 - end[8].0) / 25.0_f64.to_radians().tan() + end[8].1;
    let blunted = solid(&turned(&[&end[..], &[(1.0, rear), (1.0, rear + 4.0), (0.0, rear + 4.0)]].concat(), 32));
    let mut ball: Vec<(f64, f64)> = (1..=24).map(|i| f64::from(i) * PI / 24.0).map(|a| (a.sin(), -a.cos())).collect();
    ball.last_mut().unwrap().0 = 0.0;
    let thorn = solid(&turned(&[&[(0.0, -1.1), (0.03, -0.9995)], &ball[..]].concat(), 32));
    for (body, deep) in [(blunted, [false, true]), (thorn, [true, false])] {
        let [tip] = body.tips() else { panic!("{:?}", body.tips()) };
        assert_eq!(tip.inner, Vector3::zeros());
        let sharp = |s: f64| -body.gap(&(tip.end * (1.0 - s / tip.end.norm()))).distance < 0.57 * s;
        assert_eq!([0.125, 1.0].map(|part| sharp(part * body.inner_radius())), deep);
    }
}

#[test]
fn the_line_from_a_tip_inwards_stays_inside_of_a_hollow_body() {
    let body = solid(&fork());
    let referee = Referee::of(&body);
    assert!(referee.distance(&Vector3::zeros()) > 0.2, "its centre of mass is between the prongs");
    assert_eq!(body.tips().len(), 4);
    for tip in body.tips() {
        let line = tip.inner - tip.end;
        let inside = (1..=200).all(|i| referee.distance(&(tip.end + line * (f64::from(i) / 200.0))) < 0.0);
        assert!(inside && line.norm() > 0.99 * body.inner_radius(), "{tip:?}");
        assert!(line.z > 0.9 * line.norm(), "along the prong: {tip:?}");
    }
}

/// No node of the grid is inside the plate: a cell is thicker.
#[test]
fn the_greatest_ball_inside_a_thin_body_is_found() {
    for thickness in [0.05, 0.01] {
        let found = solid(&cuboid([1.0, 0.9, thickness])).inner_radius();
        assert!((found / (0.5 * thickness) - 1.0).abs() < 0.02, "{thickness}: {found}");
    }
}

#[test]
fn inertia_and_volume_scale_with_the_unit_of_the_file() {
    let surface = || TriangleSurface::new(&angle()).unwrap();
    let (one, small) =
        (TriangulatedBody::new(surface(), 1.0).unwrap(), TriangulatedBody::new(surface(), 1e-3).unwrap());
    // Volume and centre of two cuboids, 3 × 1 and 1 × 1.
    assert!((one.volume().unwrap() - 6.0).abs() < 1e-14 && (small.volume().unwrap() - 6e-9).abs() < 1e-23);
    assert!((one.centre() - Vector3::new(1.25, 0.75, 0.75)).norm() < 1e-14);
    let ratio = small.specific_inertia().unwrap() * 1e6 - one.specific_inertia().unwrap();
    assert!(ratio.norm() < 1e-14 && one.specific_inertia().unwrap()[(0, 1)] > 0.0);
    assert!((small.gap(&Vector3::new(0.0, 0.0, 0.8e-3)).distance - 0.05e-3).abs() < 1e-18);
}

#[test]
fn a_surface_inside_out_is_turned_and_a_cavity_is_left() {
    let turned = TriangleSurface::new(&reversed(&angle())).unwrap();
    assert!(turned.was_turned() && !TriangleSurface::new(&angle()).unwrap().was_turned());
    let body = TriangulatedBody::new(turned, 1.0).unwrap();
    let plain = solid(&angle());
    assert!(
        body.volume().unwrap() > 0.0
            && points(3.0).all(|p| (body.gap(&p).distance - plain.gap(&p).distance).abs() < 1e-14)
    );
    let hollow = solid(&[cuboid([2.0; 3]), reversed(&cuboid([1.0; 3]))].concat());
    let wall = hollow.gap(&Vector3::new(0.48, 0.1, 0.2)).distance;
    assert!((hollow.volume().unwrap() - 7.0).abs() < 1e-14 && (wall - 0.02).abs() < 1e-15, "{wall}");
}

fn refused(triangles: &Triangles) -> SurfaceError {
    TriangleSurface::new(triangles).and_then(|surface| TriangulatedBody::new(surface, 1.0)).unwrap_err()
}

#[test]
fn an_open_branched_or_degenerate_surface_is_refused_with_the_place() {
    let cube = cuboid([2.0; 3]);
    let open = refused(&cube[1..].to_vec());
    assert!(matches!(open, SurfaceError::Open { count: 3, .. }) && open.to_string().contains("at [-1.0"), "{open}");
    let mut twisted = cube.clone();
    twisted[3].swap(0, 1);
    assert!(matches!(refused(&twisted), SurfaceError::Disoriented { count: 3, .. }));
    let beside = [cube.clone(), moved(&cube, Vector3::new(2.0, 2.0, 0.0))].concat();
    let branched = refused(&beside);
    assert!(matches!(branched, SurfaceError::Branched { count: 1, at: [1.0, 1.0, 0.0] }), "{branched}");
    assert_eq!(refused(&vec![]), SurfaceError::TooFew { count: 0 });
    let mut nowhere = cube.clone();
    nowhere[4][1].y = f64::NAN;
    assert_eq!(refused(&nowhere), SurfaceError::NotFinite { triangle: 5 });
    assert!(matches!(refused(&cuboid([1.0, 1.0, 1e-10])), SurfaceError::Flat { .. }));
    let most = TriangleSurface::MOST_TRIANGLES + 1;
    assert_eq!(refused(&vec![cube[0]; most]), SurfaceError::TooMany { count: most });
}

#[test]
fn a_self_intersecting_surface_is_refused_with_the_place() {
    let cube = cuboid([2.0; 3]);
    let overlapping = [cube.clone(), moved(&cuboid([1.0; 3]), Vector3::new(1.0, 0.1, 0.2))].concat();
    let SurfaceError::Crossing { at: [x, ..] } = refused(&overlapping) else { panic!("{}", refused(&overlapping)) };
    assert!((x - 1.0).abs() < 1e-12, "{x}");
    // Bodies that only touch do not cross.
    let touching = solid(&[cube.clone(), moved(&cuboid([1.0; 3]), Vector3::new(1.5, 0.1, 0.2))].concat());
    assert!((touching.volume().unwrap() - 9.0).abs() < 1e-14);
}

#[test]
fn a_part_that_faces_inwards_is_refused() {
    let apart = [cuboid([2.0; 3]), moved(&reversed(&cuboid([1.0; 3])), Vector3::new(4.0, 0.0, 0.0))].concat();
    assert!(matches!(refused(&apart), SurfaceError::InsideOut { at: [x, ..] } if x > 2.0), "{}", refused(&apart));
}

#[test]
fn parts_that_overlap_without_crossing_are_refused_with_the_place() {
    let cube = cuboid([2.0; 3]);
    let beside = |part: &Triangles, by: [f64; 3]| [cube.clone(), moved(part, by.into())].concat();
    let within = |p: [f64; 3], half: f64, middle: [f64; 3]| (0..3).all(|i| (p[i] - middle[i]).abs() <= half + 1e-6);
    // Flush on four sides, by a half and by a thousandth; one inside the other, large and below a cell, off its lines.
    let tiny = cuboid([0.05; 3]);
    for (body, half, middle) in [
        (beside(&cube, [1.0, 0.0, 0.0]), 1.0, [0.5, 0.0, 0.0]),
        (beside(&cube, [0.0, 0.0, 1.998]), 1.0, [0.0, 0.0, 0.999]),
        (beside(&cuboid([1.0; 3]), [0.0; 3]), 1.0, [0.0; 3]),
        (beside(&tiny, [0.06, 0.05, 0.07]), 0.6, [0.0; 3]),
    ] {
        let error = refused(&body);
        let SurfaceError::Overlapping { at } = error else { panic!("{error}") };
        assert!(within(at, half, middle), "{error}");
    }
}

#[test]
fn a_part_inside_out_is_refused_also_where_others_are_around_it() {
    let slab = |axis: usize, side: f64| {
        let size = std::array::from_fn(|i| if i == axis { 0.5 } else { 3.0 });
        moved(&cuboid(size), Vector3::ith(axis, 2.0 * side))
    };
    let slabs: Triangles = (0..3).flat_map(|axis| [slab(axis, -1.0), slab(axis, 1.0)].concat()).collect();
    assert!((solid(&slabs).volume().unwrap() - 27.0).abs() < 1e-12);
    let error = refused(&[slabs, reversed(&cuboid([1.0; 3]))].concat());
    assert!(matches!(error, SurfaceError::InsideOut { at } if at.iter().all(|x| x.abs() <= 0.5)), "{error}");
}

/// In single precision, and with faces and edges on the lines of the grid or at any angle to them.
#[test]
fn a_surface_of_winding_number_one_is_accepted_at_any_orientation() {
    let hollow = [cuboid([2.0; 3]), reversed(&cuboid([1.0; 3]))].concat();
    for body in bodies().into_iter().chain([hollow, cylinder(1.0, 2.0, 48)]) {
        let volume = solid(&body).volume().unwrap();
        for i in 0..12 {
            let axis = Vector3::new(f64::from(i % 2), f64::from(i % 3), 1.0);
            let turn = Rotation3::new(axis * (0.5 * PI * f64::from(i) / 4.0));
            let single = |p: &Vector3| (turn * p + Vector3::repeat(0.1)).map(|x| f64::from(x as f32));
            let turned: Triangles = body.iter().map(|triangle| triangle.each_ref().map(single)).collect();
            assert!((solid(&turned).volume().unwrap() / volume - 1.0).abs() < 1e-5);
        }
    }
}
