//! Shape of a rigid body: one of the bodies with a signed distance.

use super::bodies::{Dome, ExpandingProfile, HalfSpace, ProfileBody, RoundedCuboid, Sphere};
use super::signed_distance::{Gap, SharpEnd, SignedDistance};
use super::trimesh::TriangulatedBody;
use crate::math::{Tensor3, Vector3};
use std::sync::Arc;

/// Shape of a rigid body.
#[derive(Debug, Clone, PartialEq)]
pub enum ShapeGeometry {
    /// Sphere.
    Sphere(Sphere),
    /// Convex body with a profile about an axis.
    Profile(Arc<ProfileBody>),
    /// Profile body that expands, at its opening at the start.
    Expanding(Arc<ExpandingProfile>),
    /// Cuboid with rounded edges.
    Plate(RoundedCuboid),
    /// Body bounded by a closed triangulated surface.
    Solid(Arc<TriangulatedBody>),
    /// Half-space.
    HalfSpace(HalfSpace),
    /// Plate with a spherical cap in its initial form.
    Dome(Dome),
}

impl ShapeGeometry {
    /// Ends that may be sharper than the mesh: ends on the axis of a profile, or tips of a triangulated body.
    #[must_use]
    pub fn poles(&self) -> &[SharpEnd] {
        match self {
            Self::Profile(profile) => profile.poles(),
            Self::Expanding(expanding) => expanding.forms()[0].poles(),
            Self::Solid(solid) => solid.tips(),
            Self::Sphere(_) | Self::Plate(_) | Self::HalfSpace(_) | Self::Dome(_) => &[],
        }
    }

    /// Returns true if the body is convex and nowhere sharper than its edges. Then φ is convex, and the depth alone
    /// decides the contact of a facet.
    #[must_use]
    pub fn is_blunt(&self) -> bool {
        matches!(self, Self::Sphere(_) | Self::Plate(_) | Self::HalfSpace(_))
    }

    fn body(&self) -> &dyn SignedDistance {
        match self {
            Self::Sphere(sphere) => sphere,
            Self::Profile(profile) => &**profile,
            Self::Expanding(expanding) => &**expanding,
            Self::Plate(plate) => plate,
            Self::Solid(solid) => &**solid,
            Self::HalfSpace(half_space) => half_space,
            Self::Dome(dome) => dome,
        }
    }
}

impl SignedDistance for ShapeGeometry {
    fn gap(&self, point: &Vector3) -> Gap {
        self.body().gap(point)
    }
    fn reach(&self, direction: &Vector3) -> f64 {
        self.body().reach(direction)
    }
    fn volume(&self) -> Option<f64> {
        self.body().volume()
    }
    fn area_of_section(&self) -> Option<f64> {
        self.body().area_of_section()
    }
    fn specific_inertia(&self) -> Option<Tensor3> {
        self.body().specific_inertia()
    }
    fn specific_inertia_of_section(&self) -> Option<f64> {
        self.body().specific_inertia_of_section()
    }
    fn inner_radius(&self) -> f64 {
        self.body().inner_radius()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ProfileOutline, ProfileSweep};
    use super::*;

    /// A pointed bullet: tangent ogive, mantle, boat-tail, base, the two rims at the rear rounded.
    fn bullet() -> ShapeGeometry {
        let (radius, length) = (0.7_f64, 1.4_f64);
        let ogive = (length * length + radius * radius) / (2.0 * radius);
        let outline =
            ProfileOutline::at_tip().arc(radius, length, ogive).line(radius, 2.2).line(0.5, 2.6).line(0.0, 2.6);
        ShapeGeometry::Profile(Arc::new(ProfileBody::new(&outline.rounded(0.1).unwrap(), ProfileSweep::Revolution)))
    }

    fn cylinder(edge_radius: f64) -> ShapeGeometry {
        let outline = ProfileOutline::at_tip().line(0.7, 0.0).line(0.7, 2.2).line(0.0, 2.2);
        ShapeGeometry::Profile(Arc::new(ProfileBody::new(
            &outline.rounded(edge_radius).unwrap(),
            ProfileSweep::Revolution,
        )))
    }

    /// Truncated cone on its base, all rims sharp.
    fn stub() -> ShapeGeometry {
        let outline = ProfileOutline::at_tip().line(0.3, 0.0).line(0.9, 1.1).line(0.0, 1.1);
        ShapeGeometry::Profile(Arc::new(ProfileBody::new(&outline, ProfileSweep::Revolution)))
    }

    /// All shapes; the unbounded ones come last.
    fn shapes() -> [ShapeGeometry; 9] {
        [
            ShapeGeometry::Sphere(Sphere { radius: 1.3 }),
            cylinder(0.0),
            cylinder(0.2),
            bullet(),
            stub(),
            ShapeGeometry::Plate(RoundedCuboid::new([2.0, 1.2, 0.7], 0.0)),
            ShapeGeometry::Plate(RoundedCuboid::new([2.0, 1.2, 0.7], 0.2)),
            ShapeGeometry::HalfSpace(HalfSpace::new(Vector3::new(0.3, -0.4, 1.2))),
            ShapeGeometry::Dome(Dome::new(0.5, 0.9)),
        ]
    }

    fn points() -> impl Iterator<Item = Vector3> {
        (0..400).map(|i| {
            let t = f64::from(i);
            Vector3::new((t * 0.711).sin(), (t * 1.37).cos(), (t * 0.239).sin()) * (0.1 + 0.006 * t)
        })
    }

    #[test]
    fn normals_are_the_gradient_of_the_distance() {
        let step = 1e-6;
        for shape in shapes() {
            let slopes = points().filter_map(|p| {
                let gap = shape.gap(&p);
                let probe = |i: usize, s: f64| shape.gap(&(p + Vector3::ith(i, s))).distance;
                let slope = Vector3::from_fn(|i, _| (probe(i, step) - probe(i, -step)) / (2.0 * step));
                // A ridge of the distance has no gradient: there the two one-sided slopes differ.
                let kink = (0..3).any(|i| (probe(i, step) + probe(i, -step) - 2.0 * gap.distance).abs() > 1e-9);
                (!kink).then_some((slope, gap.normal))
            });
            let checked = slopes.inspect(|(slope, normal)| assert!((slope - normal).norm() < 1e-6)).count();
            assert!(checked > 350, "{shape:?}: only {checked} points were smooth");
        }
    }

    #[test]
    fn distance_vanishes_on_the_surface_it_points_to() {
        for shape in shapes() {
            for p in points() {
                let gap = shape.gap(&p);
                assert!(shape.gap(&(p - gap.normal * gap.distance)).distance.abs() < 1e-12);
            }
        }
    }

    #[test]
    fn reach_is_the_greatest_extent_of_the_inside() {
        for shape in &shapes()[..7] {
            for direction in points().map(|p| p.normalize()).take(50) {
                let reach = shape.reach(&direction);
                let inside = points().filter(|p| shape.gap(p).distance <= 0.0).map(|p| p.dot(&direction));
                assert!(inside.fold(f64::MIN, f64::max) <= reach + 1e-12);
            }
        }
        let plate = RoundedCuboid::new([2.0, 1.2, 0.7], 0.2);
        let corner = plate.reach(&Vector3::repeat(3.0_f64.recip().sqrt()));
        assert!((corner - ((0.8 + 0.4 + 0.15) / 3.0_f64.sqrt() + 0.2)).abs() < 1e-15);
        let cylinder = cylinder(0.2);
        assert!((cylinder.reach(&Vector3::z()) - 1.1).abs() < 1e-14);
        assert!((cylinder.reach(&Vector3::x()) - 0.7).abs() < 1e-14);
    }
}
