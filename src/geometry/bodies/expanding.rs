use super::piece::{PieceCurve, ProfileGap, ProfilePoint, cross};
use super::profile::{ProfileBody, gap_of_revolution};
use crate::geometry::{Gap, SharpEnd, SignedDistance};
use crate::math::{Tensor3, Vector3, hypotenuse};
use std::f64::consts::PI;

/// Profile body between two forms, unopened and opened: a bullet that expands.
///
/// At the opening e it is the Minkowski mean (1 − e) A + e B of the two forms about their centres of mass, whose support
/// function is the mean h = (1 − e) h_A + e h_B of theirs (Schneider 2014, Convex Bodies, 1.7 and 3.1). The surface point
/// with normal n moves straight on, by h_B(n) − h_A(n) along n while e goes from 0 to 1, and its normal stays.
#[derive(Debug, Clone, PartialEq)]
pub struct ExpandingProfile {
    unopened: ProfileBody,
    opened: ProfileBody,
    arcs: Vec<MeanArc>,
    greatest_travel: f64,
    opening_at_start: f64,
    /// Radius of a ball that fits into the body at any opening, m: inner radii are superadditive under the mean.
    inner_radius: f64,
}

/// Range of normals within which both profiles are arcs about one centre; corners are arcs of radius 0. The lines between
/// arcs have no range: their normal is the end of one arc's range and the start of the next.
#[derive(Debug, Clone, Copy, PartialEq)]
struct MeanArc {
    normals: [ProfilePoint; 2],
    centre: [ProfilePoint; 2],
    radius: [f64; 2],
}

/// Arc of one profile, by the angles of its normals from the tip's, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
struct NormalArc {
    angles: [f64; 2],
    centre: ProfilePoint,
    radius: f64,
}

/// Signed distance at a point of the half-plane, its gradient, and the arc that decides.
struct MeanGap<'a> {
    gap: ProfileGap,
    arc: &'a MeanArc,
}

/// Least range of normals that is kept, rad: the next arc is as far to this fraction of its size.
const LEAST_RANGE: f64 = 1e-9;

impl ExpandingProfile {
    /// Builds the body between two forms of revolution, with its opening at the start.
    #[must_use]
    pub fn new(unopened: ProfileBody, opened: ProfileBody, opening_at_start: f64) -> Self {
        let arcs = mean_arcs(&normal_arcs(&unopened), &normal_arcs(&opened));
        let greatest_travel = arcs.iter().map(MeanArc::greatest_travel).fold(0.0, f64::max);
        let inner_radius = unopened.inner_radius().min(opened.inner_radius());
        Self { unopened, opened, arcs, greatest_travel, opening_at_start, inner_radius }
    }

    /// Unopened form, and opened form.
    #[must_use]
    pub fn forms(&self) -> [&ProfileBody; 2] {
        [&self.unopened, &self.opened]
    }

    /// Opening at the start.
    #[must_use]
    pub fn opening_at_start(&self) -> f64 {
        self.opening_at_start
    }

    /// Greatest distance that a point of the surface moves along its normal from unopened to opened, m.
    #[must_use]
    pub fn greatest_travel(&self) -> f64 {
        self.greatest_travel
    }

    /// Signed distance φ and ∇φ at a point of the body's frame, at an opening.
    #[must_use]
    pub fn gap_at(&self, opening: f64, point: &Vector3) -> Gap {
        gap_of_revolution(point, |p| self.nearest(opening, p).gap)
    }

    /// Sensitivity −∂φ/∂e at a point of the body's frame, m: h_B(n) − h_A(n), the rate at which the opening reduces the
    /// distance.
    #[must_use]
    pub fn growth(&self, opening: f64, point: &Vector3) -> f64 {
        let rho = hypotenuse(point.x, point.y);
        let MeanGap { gap, arc } = self.nearest(opening, &ProfilePoint::new(rho, point.z));
        arc.travel(&gap.normal)
    }

    /// Support function at an opening: the greatest extent along a unit vector of the body's frame, m.
    #[must_use]
    pub fn reach_at(&self, opening: f64, direction: &Vector3) -> f64 {
        let direction = ProfilePoint::new(hypotenuse(direction.x, direction.y), direction.z);
        self.arcs.iter().map(|arc| arc.at(opening).reach(&direction)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Tip and rear at an opening; their inner point is the centre of mass.
    #[must_use]
    pub fn poles(&self, opening: f64) -> [SharpEnd; 2] {
        [-1.0, 1.0].map(|side| {
            let end = Vector3::z() * (side * self.reach_at(opening, &(Vector3::z() * side)));
            SharpEnd { end, inner: Vector3::zeros() }
        })
    }

    /// Polyline (ρ, z) of the profile at an opening, m, from tip to rear; consecutive points on an arc are at most `turn`
    /// radians apart.
    #[must_use]
    pub fn polyline(&self, opening: f64, turn: f64) -> Vec<(f64, f64)> {
        let [tip, rear] = self.poles(opening).map(|pole| (0.0, pole.end.z));
        let along = self.arcs.iter().flat_map(|arc| {
            let [from, to] = arc.normals;
            let angle = libm::atan2(cross(&from, &to), from.dot(&to));
            let PlacedArc { centre, radius, .. } = arc.at(opening);
            let n = if radius > 0.0 { (angle / turn).ceil().max(1.0) as usize } else { 1 };
            (0..=n).map(move |i| {
                let (sin, cos) = libm::sincos(angle * i as f64 / n as f64);
                let at = centre + radius * (from * cos + ProfilePoint::new(-from[1], from[0]) * sin);
                (at[0].max(0.0), at[1])
            })
        });
        let mut points: Vec<(f64, f64)> = std::iter::once(tip).chain(along).chain([rear]).collect();
        points.dedup_by(|a, b| (a.0 - b.0).abs() + (a.1 - b.1).abs() <= LEAST_RANGE * (rear.1 - tip.1));
        // The ends are on the axis, also where they are those of an arc.
        let last = points.len() - 1;
        (points[0].0, points[last].0) = (0.0, 0.0);
        points
    }

    /// φ and ∇φ in the half-plane: the distance of a convex body is the greatest n·p − h(n) over its normals n.
    fn nearest(&self, opening: f64, p: &ProfilePoint) -> MeanGap<'_> {
        let gaps = self.arcs.iter().map(|arc| MeanGap { gap: arc.at(opening).gap(p), arc });
        let greatest = gaps.reduce(|best, next| if next.gap.distance > best.gap.distance { next } else { best });
        greatest.expect("a profile has normals")
    }
}

/// Distance and extent at the opening at the start; volume and inertia of the unopened form.
impl SignedDistance for ExpandingProfile {
    fn gap(&self, point: &Vector3) -> Gap {
        self.gap_at(self.opening_at_start, point)
    }
    fn reach(&self, direction: &Vector3) -> f64 {
        self.reach_at(self.opening_at_start, direction)
    }
    fn volume(&self) -> Option<f64> {
        self.unopened.volume()
    }
    fn area_of_section(&self) -> Option<f64> {
        self.unopened.area_of_section()
    }
    fn specific_inertia(&self) -> Option<Tensor3> {
        self.unopened.specific_inertia()
    }
    fn specific_inertia_of_section(&self) -> Option<f64> {
        self.unopened.specific_inertia_of_section()
    }
    fn inner_radius(&self) -> f64 {
        self.inner_radius
    }
}

/// Arc at an opening.
struct PlacedArc {
    normals: [ProfilePoint; 2],
    centre: ProfilePoint,
    radius: f64,
}

impl MeanArc {
    /// Arc at an opening.
    fn at(&self, opening: f64) -> PlacedArc {
        let Self { normals, centre: [a, b], radius: [r, s] } = self;
        PlacedArc { normals: *normals, centre: a + (b - a) * opening, radius: r + (s - r) * opening }
    }

    /// h_B − h_A along a normal of the range, m.
    fn travel(&self, normal: &ProfilePoint) -> f64 {
        let [a, b] = self.centre;
        normal.dot(&(b - a)) + self.radius[1] - self.radius[0]
    }

    /// Greatest |h_B − h_A| over the range, m; an upper bound where the centre moves along a normal of it.
    fn greatest_travel(&self) -> f64 {
        let [a, b] = self.centre;
        let path = b - a;
        let is_along = |way: ProfilePoint| is_within(&self.normals, &way);
        let straight =
            (is_along(path) || is_along(-path)).then(|| path.norm() + (self.radius[1] - self.radius[0]).abs());
        self.normals.iter().map(|normal| self.travel(normal).abs()).chain(straight).fold(0.0, f64::max)
    }
}

impl PlacedArc {
    /// Greatest n·p − h(n) over the normals of the arc, and that normal.
    fn gap(&self, p: &ProfilePoint) -> ProfileGap {
        let arm = p - self.centre;
        if is_within(&self.normals, &arm) {
            let length = arm.norm();
            if length > 0.0 {
                return ProfileGap { distance: length - self.radius, normal: arm / length };
            }
        }
        let [from, to] = self.normals;
        let (before, after) = (from.dot(&arm), to.dot(&arm));
        let (extent, normal) = if before >= after { (before, from) } else { (after, to) };
        ProfileGap { distance: extent - self.radius, normal }
    }

    /// Greatest extent of the arc along a unit vector, m.
    fn reach(&self, direction: &ProfilePoint) -> f64 {
        if is_within(&self.normals, direction) {
            return self.centre.dot(direction) + self.radius;
        }
        let end = |normal: &ProfilePoint| (self.centre + normal * self.radius).dot(direction);
        end(&self.normals[0]).max(end(&self.normals[1]))
    }
}

/// Returns true if a vector points between two normals, less than π apart.
fn is_within([from, to]: &[ProfilePoint; 2], way: &ProfilePoint) -> bool {
    cross(from, way) >= 0.0 && cross(way, to) >= 0.0
}

/// Angle of a normal from that of the tip, −z, to that of the rear, z, rad.
fn angle_of(normal: &ProfilePoint) -> f64 {
    libm::atan2(normal[0].max(0.0), -normal[1])
}

/// Unit normal at an angle from that of the tip, rad.
fn normal_at(angle: f64) -> ProfilePoint {
    let (sin, cos) = libm::sincos(angle);
    ProfilePoint::new(sin, -cos)
}

/// Arcs and corners of a profile, with ranges of normals that follow on each other from the tip's to the rear's.
fn normal_arcs(profile: &ProfileBody) -> Vec<NormalArc> {
    let (mut arcs, mut from, mut at) = (vec![], 0.0_f64, profile.pieces()[0].start);
    let corner = |centre: ProfilePoint, angles: [f64; 2]| NormalArc { angles, centre, radius: 0.0 };
    for piece in profile.pieces() {
        let start = angle_of(&piece.gap(&piece.start).normal).max(from);
        arcs.push(corner(at, [from, start]));
        from = start;
        if let PieceCurve::Circle { centre, radius } = piece.curve {
            let end = angle_of(&piece.gap(&piece.end).normal).max(start);
            arcs.push(NormalArc { angles: [start, end], centre, radius });
            from = end;
        }
        at = piece.end;
    }
    arcs.push(corner(at, [from, PI]));
    arcs.retain(|arc| arc.angles[1] > arc.angles[0]);
    arcs
}

/// Ranges of normals within which both profiles are single arcs.
fn mean_arcs(unopened: &[NormalArc], opened: &[NormalArc]) -> Vec<MeanArc> {
    let mut ends: Vec<f64> = [unopened, opened].into_iter().flatten().flat_map(|arc| arc.angles).collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup_by(|next, end| *next - *end <= LEAST_RANGE);
    let arc_at = |arcs: &[NormalArc], angle: f64| {
        *arcs.iter().find(|arc| angle <= arc.angles[1]).expect("the ranges of a profile end at the normal of its rear")
    };
    let arc = |ends: &[f64]| {
        let middle = 0.5 * (ends[0] + ends[1]);
        let [a, b] = [unopened, opened].map(|arcs| arc_at(arcs, middle));
        let normals = [normal_at(ends[0]), normal_at(ends[1])];
        MeanArc { normals, centre: [a.centre, b.centre], radius: [a.radius, b.radius] }
    };
    ends.windows(2).map(arc).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{ProfileOutline, ProfileSweep};

    fn body(outline: &ProfileOutline) -> ProfileBody {
        ProfileBody::new(outline, ProfileSweep::Revolution)
    }

    /// Hollow-point bullet with a flat tip, and its mushroom.
    fn bullet() -> ExpandingProfile {
        let unopened =
            ProfileOutline::at_tip().line(2.5, 0.0).arc(5.7, 8.0, 14.0).line(5.7, 15.0).line(0.0, 15.0).rounded(0.8);
        let opened = ProfileOutline::at_tip().line(9.0, 0.0).line(9.0, 5.0).line(5.7, 9.0).line(0.0, 9.0).rounded(2.0);
        ExpandingProfile::new(body(&unopened.unwrap()), body(&opened.unwrap()), 0.0)
    }

    fn points() -> impl Iterator<Item = Vector3> {
        (0..2000).map(|i| {
            let t = f64::from(i);
            Vector3::new((t * 0.711).sin(), (t * 1.37).cos(), (t * 0.239).sin()) * (0.01 + 0.008 * t)
        })
    }

    #[test]
    fn the_ends_of_the_opening_are_the_two_forms() {
        let bullet = bullet();
        for (opening, form) in [0.0, 1.0].into_iter().zip(bullet.forms()) {
            for p in points() {
                let (own, expected) = (bullet.gap_at(opening, &p), form.gap(&p));
                assert!((own.distance - expected.distance).abs() < 1e-7, "{opening} {p}: {own:?} {expected:?}");
                let direction = p.normalize();
                assert!((bullet.reach_at(opening, &direction) - form.reach(&direction)).abs() < 1e-7);
            }
            for (own, expected) in bullet.poles(opening).iter().zip(form.poles()) {
                assert!((own.end - expected.end).norm() < 1e-7);
            }
        }
    }

    #[test]
    fn the_distance_vanishes_on_the_surface_and_its_gradient_is_the_normal() {
        let (bullet, step) = (bullet(), 1e-6);
        for opening in [0.2, 0.7] {
            let mut smooth = 0;
            for p in points() {
                let gap = bullet.gap_at(opening, &p);
                assert!((gap.normal.norm() - 1.0).abs() < 1e-12);
                let foot = p - gap.normal * gap.distance;
                assert!(bullet.gap_at(opening, &foot).distance.abs() < 1e-7, "{p}");
                let at = |i: usize, s: f64| bullet.gap_at(opening, &(p + Vector3::ith(i, s))).distance;
                let slope = Vector3::from_fn(|i, _| (at(i, step) - at(i, -step)) / (2.0 * step));
                if (0..3).all(|i| (at(i, step) + at(i, -step) - 2.0 * gap.distance).abs() < 1e-9) {
                    smooth += 1;
                    assert!((slope - gap.normal).norm() < 1e-5, "{p}: {slope} {}", gap.normal);
                }
            }
            assert!(smooth > 1500, "{smooth}");
        }
    }

    #[test]
    fn the_surface_moves_as_fast_as_the_distance_shrinks() {
        let (bullet, step) = (bullet(), 1e-6);
        for opening in [0.1, 0.5, 0.9] {
            let mut smooth = 0;
            for p in points() {
                let at = |e: f64| bullet.gap_at(e, &p).distance;
                let bend = at(opening + step) + at(opening - step) - 2.0 * at(opening);
                if bend.abs() > 1e-9 {
                    continue;
                }
                smooth += 1;
                let (growth, slope) =
                    (bullet.growth(opening, &p), (at(opening - step) - at(opening + step)) / (2.0 * step));
                assert!((growth - slope).abs() < 1e-4, "{opening} {p}: {growth} {slope}");
                assert!(growth.abs() <= bullet.greatest_travel() * (1.0 + 1e-12));
            }
            assert!(smooth > 1500, "{smooth}");
        }
    }

    #[test]
    fn the_polyline_is_on_the_surface_from_the_tip_to_the_rear() {
        let bullet = bullet();
        for opening in [0.0, 0.4, 1.0] {
            let line = bullet.polyline(opening, 0.1);
            for (rho, z) in &line {
                assert!(bullet.gap_at(opening, &Vector3::new(*rho, 0.0, *z)).distance.abs() < 1e-7);
            }
            assert!(line.windows(2).all(|two| two[1].1 >= two[0].1 - 1e-9), "{line:?}");
            assert_eq!((line[0].0, line.last().unwrap().0), (0.0, 0.0));
        }
    }
}
