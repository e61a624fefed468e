//! Plane cuts through the mesh that open its inside to view.

use crate::math::Vector3;

/// Corner of a polygon: position, m, and speed, m/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PolygonCorner {
    pub(super) at: Vector3,
    pub(super) speed: f64,
}

/// Cut plane y = const; points on the plane count as behind it.
#[derive(Debug, Clone, Copy)]
pub(super) struct CutPlane {
    pub(super) y: f64,
    /// Tolerance of points on the plane, m.
    pub(super) tolerance: f64,
}

impl CutPlane {
    fn is_behind(&self, corner: &PolygonCorner) -> bool {
        corner.at.y >= self.y - self.tolerance
    }

    fn crossing(&self, a: &PolygonCorner, b: &PolygonCorner) -> PolygonCorner {
        let t = ((self.y - a.at.y) / (b.at.y - a.at.y)).clamp(0.0, 1.0);
        let mut at = a.at + t * (b.at - a.at);
        at.y = self.y;
        PolygonCorner { at, speed: a.speed + t * (b.speed - a.speed) }
    }

    /// Returns the part of a convex polygon behind the plane (Sutherland–Hodgman clipping).
    pub(super) fn clip(&self, polygon: &[PolygonCorner]) -> Vec<PolygonCorner> {
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (i, b) in polygon.iter().enumerate() {
            let a = &polygon[(i + polygon.len() - 1) % polygon.len()];
            if self.is_behind(a) != self.is_behind(b) {
                kept.push(self.crossing(a, b));
            }
            if self.is_behind(b) {
                kept.push(*b);
            }
        }
        kept
    }

    /// Returns the section of a tetrahedron: empty, a triangle or a quadrilateral. A face on the plane belongs to the
    /// tetrahedron before it.
    pub(super) fn section(&self, corners: &[PolygonCorner; 4]) -> Vec<PolygonCorner> {
        let (behind, before): (Vec<&PolygonCorner>, Vec<&PolygonCorner>) =
            corners.iter().partition(|corner| self.is_behind(corner));
        match (behind.as_slice(), before.as_slice()) {
            ([a], others) | (others, [a]) => others.iter().map(|b| self.crossing(a, b)).collect(),
            ([a, b], [c, d]) => [(a, c), (a, d), (b, d), (b, c)].map(|(p, q)| self.crossing(p, q)).to_vec(),
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: f64, y: f64, z: f64) -> PolygonCorner {
        PolygonCorner { at: Vector3::new(x, y, z), speed: y }
    }

    const PLANE: CutPlane = CutPlane { y: 0.0, tolerance: 1e-9 };

    #[test]
    fn sections_lie_on_the_plane_and_carry_the_speed_there() {
        let one = [corner(0.0, -1.0, 0.0), corner(1.0, 1.0, 0.0), corner(0.0, 1.0, 1.0), corner(0.0, 1.0, 0.0)];
        let two = [corner(0.0, -1.0, 0.0), corner(1.0, -1.0, 0.0), corner(0.0, 1.0, 1.0), corner(0.0, 1.0, 0.0)];
        assert_eq!((PLANE.section(&one).len(), PLANE.section(&two).len()), (3, 4));
        for point in PLANE.section(&one).iter().chain(&PLANE.section(&two)) {
            assert!(point.at.y.abs() < 1e-15 && point.speed.abs() < 1e-15);
        }
    }

    #[test]
    fn a_face_on_the_plane_is_shown_once() {
        let face = [corner(0.0, 0.0, 0.0), corner(1.0, 1e-18, 0.0), corner(0.0, -1e-18, 1.0)];
        let section = |y: f64| PLANE.section(&[face[0], face[1], face[2], corner(0.2, y, 0.2)]).len();
        assert_eq!((section(-1.0), section(1.0)), (3, 0));
    }

    #[test]
    fn clipping_keeps_the_part_behind() {
        let square = [corner(0.0, -1.0, 0.0), corner(1.0, -1.0, 0.0), corner(1.0, 1.0, 0.0), corner(0.0, 1.0, 0.0)];
        let kept = PLANE.clip(&square);
        assert!(kept.len() == 4 && kept.iter().all(|corner| corner.at.y >= 0.0));
    }
}
