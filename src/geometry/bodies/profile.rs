use super::outline::ProfileOutline;
use super::piece::{PieceCurve, ProfileGap, ProfilePiece, ProfilePoint};
use crate::geometry::{Gap, SharpEnd, SignedDistance};
use crate::math::{Tensor3, Vector3, hypotenuse};
use std::f64::consts::PI;

/// Convex body with a profile about the z axis, its tip towards −z and its centre of mass at the origin.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfileBody {
    pieces: Vec<ProfilePiece>,
    corners: Vec<ProfileCorner>,
    poles: [SharpEnd; 2],
    inertia: Tensor3,
    inertia_of_section: f64,
    inner_radius: f64,
}

/// Sweep that turns a profile into the body whose centre of mass is the origin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProfileSweep {
    /// Body of revolution: the profile swept about its axis.
    Revolution,
    /// Prism: the profile and its mirror image swept along y; the shape of a planar body.
    Prism,
}

/// Joint of two pieces, or end of a piece on the axis, with the sum of the adjacent normals.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ProfileCorner {
    at: ProfilePoint,
    outward: ProfilePoint,
}

impl ProfileBody {
    /// Builds the body with this outline.
    ///
    /// # Panics
    /// If the outline does not end on the axis or encloses nothing.
    #[must_use]
    pub fn new(outline: &ProfileOutline, sweep: ProfileSweep) -> Self {
        let pieces = &outline.pieces;
        assert!(pieces.last().is_some_and(|last| last.end[0] == 0.0), "an outline ends on the axis");
        let across = |p: &ProfilePoint| match sweep {
            ProfileSweep::Revolution => p[0] * p[0],
            ProfileSweep::Prism => p[0],
        };
        let mass = contour_integral(pieces, across);
        assert!(mass > 0.0, "an outline encloses something");
        let centre = contour_integral(pieces, |p| across(p) * p[1]) / mass;
        let pieces: Vec<ProfilePiece> =
            pieces.iter().map(|piece| piece.moved(&ProfilePoint::new(0.0, -centre))).collect();
        let turned = contour_integral(&pieces, |p| p[0] * p[0]);
        let corners = corners(&pieces);
        let mut profile = Self {
            poles: [0, corners.len() - 1]
                .map(|end| SharpEnd { end: Vector3::new(0.0, 0.0, corners[end].at[1]), inner: Vector3::zeros() }),
            corners,
            inertia: inertia(&pieces, turned),
            inertia_of_section: inertia_of_section(&pieces),
            pieces,
            inner_radius: 0.0,
        };
        profile.inner_radius = profile.greatest_depth();
        profile
    }

    /// Polyline (ρ, z) of the profile from tip to rear, m; consecutive points on an arc are at most `turn` radians
    /// apart.
    #[must_use]
    pub fn polyline(&self, turn: f64) -> Vec<(f64, f64)> {
        let ends = self.pieces.iter().flat_map(|piece| {
            let n = (piece.angle() / turn).ceil().max(1.0) as usize;
            (1..n).map(move |i| piece.at(i as f64 / n as f64).0).chain([piece.end])
        });
        std::iter::once(self.pieces[0].start).chain(ends).map(|p| (p[0], p[1])).collect()
    }

    /// Pieces of the profile from tip to rear.
    pub(super) fn pieces(&self) -> &[ProfilePiece] {
        &self.pieces
    }

    /// Tip and rear; their inner point is the centre of mass.
    #[must_use]
    pub fn poles(&self) -> &[SharpEnd; 2] {
        &self.poles
    }

    /// φ and ∇φ in the half-plane: those of the nearest piece that faces the point, or of the nearest corner.
    fn nearest(&self, p: &ProfilePoint) -> ProfileGap {
        let facing = self.pieces.iter().filter(|piece| piece.faces(p));
        let piece = least_by(facing, |piece| piece.distance(p).abs());
        let corner = least_by(self.corners.iter(), |corner| (p - corner.at).norm_squared());
        let (corner, square) = corner.expect("the tip is a corner");
        match piece {
            Some((piece, distance)) if distance <= square.sqrt() => piece.gap(p),
            _ => corner.gap(p),
        }
    }

    /// Greatest depth, m, by ternary search along the axis: the deepest point is on the axis, where the depth of a
    /// convex body is concave.
    fn greatest_depth(&self) -> f64 {
        let depth = |z: f64| -self.nearest(&ProfilePoint::new(0.0, z)).distance;
        let [mut low, mut high] = self.poles.map(|pole| pole.end.z);
        for _ in 0..128 {
            let third = (high - low) / 3.0;
            if depth(low + third) < depth(high - third) { low += third } else { high -= third }
        }
        depth(0.5 * (low + high))
    }
}

/// Signed distance and its gradient at a point, by those in its half-plane through the axis.
pub(super) fn gap_of_revolution(point: &Vector3, in_half_plane: impl FnOnce(&ProfilePoint) -> ProfileGap) -> Gap {
    let rho = hypotenuse(point.x, point.y);
    let outward = if rho > 0.0 { Vector3::new(point.x / rho, point.y / rho, 0.0) } else { Vector3::x() };
    let ProfileGap { distance, normal } = in_half_plane(&ProfilePoint::new(rho, point.z));
    Gap { distance, normal: outward * normal[0] + Vector3::z() * normal[1] }
}

/// First of these items with the least value, and its value.
fn least_by<T>(items: impl Iterator<Item = T>, value: impl Fn(&T) -> f64) -> Option<(T, f64)> {
    let valued = items.map(|item| {
        let of = value(&item);
        (item, of)
    });
    valued.reduce(|least, next| if next.1 < least.1 { next } else { least })
}

impl ProfileCorner {
    /// Signed distance and its gradient: points whose nearest point is a convex corner are outside.
    fn gap(&self, p: &ProfilePoint) -> ProfileGap {
        let arm = p - self.at;
        let distance = arm.norm();
        if distance == 0.0 {
            return ProfileGap { distance: 0.0, normal: self.outward.normalize() };
        }
        let sign = 1.0_f64.copysign(arm.dot(&self.outward));
        ProfileGap { distance: sign * distance, normal: arm * (sign / distance) }
    }
}

/// Corners of the profile: the tip, the joints and the rear.
fn corners(pieces: &[ProfilePiece]) -> Vec<ProfileCorner> {
    let start = |piece: &ProfilePiece| piece.gap(&piece.start).normal;
    let end = |piece: &ProfilePiece| piece.gap(&piece.end).normal;
    let joints = pieces.windows(2).map(|two| ProfileCorner { at: two[0].end, outward: end(&two[0]) + start(&two[1]) });
    let tip = ProfileCorner { at: pieces[0].start, outward: ProfilePoint::new(0.0, -1.0) };
    let rear = ProfileCorner { at: pieces[pieces.len() - 1].end, outward: ProfilePoint::new(0.0, 1.0) };
    [tip].into_iter().chain(joints).chain([rear]).collect()
}

/// Contour integral ∮ f(ρ, z) dz along the profile, by five-point Gauss quadrature: exact on lines to degree nine, and
/// to rounding on an arc in sixteen parts.
fn contour_integral(pieces: &[ProfilePiece], f: impl Fn(&ProfilePoint) -> f64) -> f64 {
    let rule = gauss_rule();
    let mut sum = 0.0;
    for piece in pieces {
        let parts = match piece.curve {
            PieceCurve::Line { .. } => 1,
            PieceCurve::Circle { .. } => 16,
        };
        for (i, (at, weight)) in (0..parts).flat_map(|i| rule.map(|node| (i, node))) {
            let (p, slope) = piece.at((f64::from(i) + at) / f64::from(parts));
            sum += weight / f64::from(parts) * slope * f(&p);
        }
    }
    sum
}

/// Nodes in 0…1 and weights of five-point Gauss quadrature.
fn gauss_rule() -> [(f64, f64); 5] {
    let root = 2.0 * (10.0_f64 / 7.0).sqrt();
    let [inner, outer] = [5.0 - root, 5.0 + root].map(|s| s.sqrt() / 6.0);
    let weight = |s: f64| (322.0 + s * 70.0_f64.sqrt()) / 1800.0;
    let (inside, outside) = (weight(13.0), weight(-13.0));
    [(0.5 - outer, outside), (0.5 - inner, inside), (0.5, 64.0 / 225.0), (0.5 + inner, inside), (0.5 + outer, outside)]
}

/// Inertia tensor per mass: I_z = ½∮ρ⁴ dz/∮ρ² dz, Iₓ = ½I_z + ∮ρ²z² dz/∮ρ² dz.
fn inertia(pieces: &[ProfilePiece], turned: f64) -> Tensor3 {
    let axial = 0.5 * contour_integral(pieces, |p| p[0] * p[0] * p[0] * p[0]) / turned;
    let across = 0.5 * axial + contour_integral(pieces, |p| p[0] * p[0] * p[1] * p[1]) / turned;
    Tensor3::from_diagonal(&Vector3::new(across, across, axial))
}

/// Inertia of the section per mass: I = ∮(ρ³/3 + ρz²) dz/∮ρ dz.
fn inertia_of_section(pieces: &[ProfilePiece]) -> f64 {
    contour_integral(pieces, |p| p[0] * (p[0] * p[0] / 3.0 + p[1] * p[1])) / contour_integral(pieces, |p| p[0])
}

impl SignedDistance for ProfileBody {
    /// Distance in the half-plane (ρ, z): the nearest point of a body of revolution lies in the half-plane of the query
    /// point.
    fn gap(&self, point: &Vector3) -> Gap {
        gap_of_revolution(point, |p| self.nearest(p))
    }

    /// Support function: the maximum over the corners and the arcs that have the direction as a normal.
    fn reach(&self, direction: &Vector3) -> f64 {
        let across = hypotenuse(direction.x, direction.y);
        let direction = ProfilePoint::new(across, direction.z);
        let corners = self.corners.iter().map(|corner| corner.at.dot(&direction));
        let arcs = self.pieces.iter().filter_map(|piece| match piece.curve {
            PieceCurve::Circle { centre, radius } => {
                piece.faces(&(centre + direction * radius)).then(|| centre.dot(&direction) + radius)
            }
            PieceCurve::Line { .. } => None,
        });
        corners.chain(arcs).fold(f64::NEG_INFINITY, f64::max)
    }

    /// V = π ∮ρ² dz.
    fn volume(&self) -> Option<f64> {
        Some(PI * contour_integral(&self.pieces, |p| p[0] * p[0]))
    }

    /// A = 2 ∮ρ dz.
    fn area_of_section(&self) -> Option<f64> {
        Some(2.0 * contour_integral(&self.pieces, |p| p[0]))
    }

    fn specific_inertia(&self) -> Option<Tensor3> {
        Some(self.inertia)
    }

    fn specific_inertia_of_section(&self) -> Option<f64> {
        Some(self.inertia_of_section)
    }

    fn inner_radius(&self) -> f64 {
        self.inner_radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Sphere;

    fn revolution(outline: &ProfileOutline) -> ProfileBody {
        ProfileBody::new(outline, ProfileSweep::Revolution)
    }

    /// A long secant ogive with a flat tip, mantle, boat-tail and base.
    fn pointed() -> ProfileOutline {
        ProfileOutline::at_tip().line(0.1, 0.0).arc(1.0, 3.0, 9.0).line(1.0, 4.5).line(0.8, 5.5).line(0.0, 5.5)
    }

    fn outlines() -> [ProfileOutline; 4] {
        let capsule = ProfileOutline::at_tip().arc(1.0, 1.0, 1.0).line(1.0, 4.0).arc(0.0, 5.0, 1.0);
        let cone = ProfileOutline::at_tip().line(1.0, 2.0).line(0.0, 2.0);
        [pointed(), pointed().rounded(0.1).unwrap(), capsule, cone]
    }

    fn close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} is not {b} within {tolerance}");
    }

    /// Points of the half-plane around and inside a body, with signed distances computed from the polygon.
    fn sampled(profile: &ProfileBody) -> Vec<(ProfilePoint, f64)> {
        let polygon: Vec<ProfilePoint> =
            profile.polyline(1e-3).into_iter().map(|(rho, z)| ProfilePoint::new(rho, z)).collect();
        let distance = |p: &ProfilePoint| {
            let to_edge = |edge: &[ProfilePoint]| {
                let along = edge[1] - edge[0];
                let t = ((p - edge[0]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                (p - edge[0] - along * t).norm()
            };
            let above = |edge: &&[ProfilePoint]| {
                let [(r, z), (s, w)] = [(edge[0][0], edge[0][1]), (edge[1][0], edge[1][1])];
                (z <= p[1]) != (w <= p[1]) && r + (s - r) * (p[1] - z) / (w - z) > p[0]
            };
            let inside = polygon.windows(2).filter(above).count() % 2 == 1;
            let size = polygon.windows(2).map(to_edge).fold(f64::INFINITY, f64::min);
            if inside { -size } else { size }
        };
        let place = |i: u32| ProfilePoint::new(f64::from(i % 29) * 0.067, f64::from(i / 29) * 0.3 - 4.0);
        (0..29 * 27).map(place).map(|p| (p, distance(&p))).collect()
    }

    #[test]
    fn distances_are_those_to_a_fine_polygon() {
        for outline in outlines() {
            let profile = revolution(&outline);
            for (p, expected) in sampled(&profile) {
                close(profile.gap(&Vector3::new(0.6 * p[0], -0.8 * p[0], p[1])).distance, expected, 2e-6);
            }
        }
    }

    #[test]
    fn where_arc_and_line_join_smoothly_the_inside_is_inside() {
        let capsule = revolution(&outlines()[2]);
        for i in 0..2000 {
            let p = ProfilePoint::new(0.999 * f64::from(i) / 2000.0, capsule.pieces[1].start[1]);
            close(capsule.nearest(&p).distance, p[0] - 1.0, 1e-15);
        }
    }

    #[test]
    fn a_capsule_is_at_a_constant_distance_from_its_axis() {
        let capsule = revolution(&outlines()[2]);
        for i in 1..500 {
            let t = f64::from(i);
            let p = Vector3::new((0.7 * t).sin(), (1.3 * t).sin(), 3.5 * (0.21 * t).sin());
            let from_axis = p - Vector3::z() * p.z.clamp(-1.5, 1.5);
            let gap = capsule.gap(&p);
            close(gap.distance, from_axis.norm() - 1.0, 1e-14);
            assert!((gap.normal - from_axis.normalize()).norm() < 1e-14);
        }
    }

    #[test]
    fn a_ball_and_a_rod_made_of_pieces_have_their_closed_forms() {
        let ball = ProfileOutline::at_tip().arc(2.0, 2.0, 2.0).line(2.0, 4.0).line(0.0, 4.0).rounded(2.0).unwrap();
        let (made, sphere) = (revolution(&ball), Sphere { radius: 2.0 });
        assert!((made.specific_inertia().unwrap() - sphere.specific_inertia().unwrap()).norm() < 1e-14);
        close(made.volume().unwrap(), sphere.volume().unwrap(), 1e-13);
        close(made.area_of_section().unwrap(), sphere.area_of_section().unwrap(), 1e-13);
        close(made.inner_radius(), 2.0, 1e-14);
        close(
            ProfileBody::new(&ball, ProfileSweep::Prism).inertia_of_section,
            sphere.specific_inertia_of_section().unwrap(),
            1e-14,
        );
        let (r, l) = (1.5, 5.0);
        let rod = ProfileOutline::at_tip().line(r, 0.0).line(r, l).line(0.0, l);
        let made = revolution(&rod);
        let (across, axial) = (r * r / 4.0 + l * l / 12.0, r * r / 2.0);
        let expected = Tensor3::from_diagonal(&Vector3::new(across, across, axial));
        assert!((made.specific_inertia().unwrap() - expected).norm() < 1e-14);
        close(ProfileBody::new(&rod, ProfileSweep::Prism).inertia_of_section, (4.0 * r * r + l * l) / 12.0, 1e-14);
        close(made.reach(&Vector3::new(0.48, -0.64, 0.6)), 0.8 * r + 0.6 * 0.5 * l, 1e-14);
    }

    #[test]
    fn a_cone_has_the_textbook_mass_centre_and_inertia() {
        let (r, h) = (1.0, 2.0);
        let cone = revolution(&outlines()[3]);
        close(cone.volume().unwrap(), PI * r * r * h / 3.0, 1e-15);
        close(cone.corners[0].at[1], -0.75 * h, 1e-15);
        let across = 3.0 / 20.0 * r * r + 3.0 / 80.0 * h * h;
        let expected = Vector3::new(across, across, 0.3 * r * r);
        assert!((cone.inertia - Tensor3::from_diagonal(&expected)).norm() < 1e-15);
        // A triangle about its centroid: (base² + 12 (h/6)²)/24 + … = b²/24 + h²/18 per unit mass.
        let wedge = ProfileBody::new(&outlines()[3], ProfileSweep::Prism);
        close(wedge.corners[0].at[1], -2.0 / 3.0 * h, 1e-15);
        close(wedge.inertia_of_section, 4.0 * r * r / 24.0 + h * h / 18.0, 1e-15);
        close(wedge.inner_radius(), 2.0 * r * h / (2.0 * r + 2.0 * r.hypot(h)), 1e-12);
    }

    #[test]
    fn integrals_are_the_sums_over_what_the_distance_calls_inside() {
        const N: u32 = 500;
        for outline in &outlines()[..2] {
            let (body, section) = (revolution(outline), ProfileBody::new(outline, ProfileSweep::Prism));
            let sums = |profile: &ProfileBody, weight: fn(f64) -> f64| {
                let cell =
                    |i: u32| ((f64::from(i % N) + 0.5) / f64::from(N), f64::from(i / N) / f64::from(N) * 8.0 - 4.0);
                let inside = (0..N * N)
                    .map(cell)
                    .filter(|(rho, z)| profile.nearest(&ProfilePoint::new(*rho, *z)).distance <= 0.0);
                inside.fold([0.0; 4], |[m, z1, z2, r2], (r, z)| {
                    let w = weight(r) * 8.0 / f64::from(N * N);
                    [m + w, z1 + w * z, z2 + w * z * z, r2 + w * r * r]
                })
            };
            let [volume, first, second, radial] = sums(&body, |r| 2.0 * PI * r);
            close(volume / body.volume().unwrap(), 1.0, 2e-3);
            close(first / volume, 0.0, 2e-3);
            close((0.5 * radial + second) / volume / body.inertia[(0, 0)], 1.0, 2e-3);
            close(radial / volume / body.inertia[(2, 2)], 1.0, 4e-3);
            let [area, first, second, radial] = sums(&section, |_| 1.0);
            close(first / area, 0.0, 2e-3);
            close((second + radial) / area / section.inertia_of_section, 1.0, 2e-3);
        }
    }

    #[test]
    fn rounding_touches_both_sides_and_needs_room() {
        let profile = revolution(&pointed().rounded(0.1).unwrap());
        assert_eq!(
            profile.pieces.len(),
            9,
            "a tip, an ogive, a mantle, a tail, a base, and a rounding between each two"
        );
        for corner in &profile.corners[1..profile.corners.len() - 1] {
            close(corner.outward.norm(), 2.0, 1e-9);
        }
        assert!(pointed().rounded(0.2).is_none());
        assert_eq!(pointed().rounded(0.0), Some(pointed()));
    }
}
