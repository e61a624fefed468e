use crate::math::Vector;

/// Point (ρ, z) of the half-plane through the axis of a body of revolution, m.
pub(super) type ProfilePoint = Vector<2>;

/// Signed distance to a profile in the half-plane, and its gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ProfileGap {
    /// Signed distance, m: negative inside the body.
    pub distance: f64,
    /// Unit normal out of the body.
    pub normal: ProfilePoint,
}

/// Smooth piece of a profile, traversed with the inside of the body on its left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ProfilePiece {
    pub start: ProfilePoint,
    pub end: ProfilePoint,
    pub curve: PieceCurve,
}

/// Carrier curve of a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PieceCurve {
    /// Line with its unit normal out of the body.
    Line { normal: ProfilePoint },
    /// Circle that bulges out of the body; the piece spans less than half of it.
    Circle { centre: ProfilePoint, radius: f64 },
}

/// Cross product a × b, positive if b is to the left of a.
pub(super) fn cross(a: &ProfilePoint, b: &ProfilePoint) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Unit normal to the right of a direction of travel: out of the body.
fn right_normal(course: &ProfilePoint) -> ProfilePoint {
    ProfilePoint::new(course[1], -course[0]) / course.norm()
}

impl ProfilePiece {
    /// Builds the line from `start` to `end`.
    pub fn line(start: ProfilePoint, end: ProfilePoint) -> Self {
        Self { start, end, curve: PieceCurve::Line { normal: right_normal(&(end - start)) } }
    }

    /// Builds the arc of this radius, at least half the chord, whose centre is to the left of the chord.
    pub fn arc(start: ProfilePoint, end: ProfilePoint, radius: f64) -> Self {
        let chord = end - start;
        let height = (radius * radius - 0.25 * chord.norm_squared()).max(0.0).sqrt();
        let centre = (start + end) / 2.0 - right_normal(&chord) * height;
        Self { start, end, curve: PieceCurve::Circle { centre, radius } }
    }

    /// Translates the piece.
    pub fn moved(&self, by: &ProfilePoint) -> Self {
        let curve = match self.curve {
            PieceCurve::Circle { centre, radius } => PieceCurve::Circle { centre: centre + by, radius },
            line @ PieceCurve::Line { .. } => line,
        };
        Self { start: self.start + by, end: self.end + by, curve }
    }

    /// Signed distance from the whole line or circle, and its normal at the point nearest to `p`.
    pub fn gap(&self, p: &ProfilePoint) -> ProfileGap {
        let normal = match self.curve {
            PieceCurve::Line { normal } => normal,
            PieceCurve::Circle { centre, radius } => {
                let arm = p - centre;
                let length = arm.norm();
                // At the centre all directions are equivalent: take that of the start.
                if length > 0.0 { arm / length } else { (self.start - centre) / radius }
            }
        };
        ProfileGap { distance: self.distance(p), normal }
    }

    /// Signed distance from the whole line or circle, m.
    pub fn distance(&self, p: &ProfilePoint) -> f64 {
        match self.curve {
            PieceCurve::Line { normal } => normal.dot(&(p - self.start)),
            PieceCurve::Circle { centre, radius } => (p - centre).norm() - radius,
        }
    }

    /// Returns true if the point of the line or circle nearest to `p` belongs to the piece.
    pub fn faces(&self, p: &ProfilePoint) -> bool {
        match self.curve {
            PieceCurve::Line { .. } => {
                let course = self.end - self.start;
                (p - self.start).dot(&course) >= 0.0 && (p - self.end).dot(&course) <= 0.0
            }
            PieceCurve::Circle { centre, .. } => {
                let arm = p - centre;
                cross(&(self.start - centre), &arm) >= 0.0 && cross(&arm, &(self.end - centre)) >= 0.0
            }
        }
    }

    /// Part from `start` to `end`, and its approximate length, m: negative if the two are in the wrong order.
    pub fn between(&self, start: ProfilePoint, end: ProfilePoint) -> (Self, f64) {
        let ahead = match self.curve {
            PieceCurve::Line { normal } => cross(&normal, &(end - start)),
            PieceCurve::Circle { centre, radius } => cross(&(start - centre), &(end - centre)) / radius,
        };
        (Self { start, end, curve: self.curve }, ahead)
    }

    /// Point at a `fraction` of the length, and dz/d`fraction` there.
    pub fn at(&self, fraction: f64) -> (ProfilePoint, f64) {
        match self.curve {
            PieceCurve::Line { .. } => (self.start + (self.end - self.start) * fraction, self.end[1] - self.start[1]),
            PieceCurve::Circle { centre, .. } => {
                let (from, angle) = (self.start - centre, self.angle());
                let (sin, cos) = libm::sincos(angle * fraction);
                let arm = from * cos + ProfilePoint::new(-from[1], from[0]) * sin;
                (centre + arm, arm[0] * angle)
            }
        }
    }

    /// Angle by which the normal turns along the piece, rad.
    pub fn angle(&self) -> f64 {
        match self.curve {
            PieceCurve::Line { .. } => 0.0,
            PieceCurve::Circle { centre, .. } => {
                let (from, to) = (self.start - centre, self.end - centre);
                libm::atan2(cross(&from, &to), from.dot(&to))
            }
        }
    }
}
