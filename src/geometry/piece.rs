use crate::math::Vector;

/// A point (ρ, z) of the half-plane through the axis of a body of revolution, m.
pub(super) type Point = Vector<2>;

/// A smooth piece of a profile, run through with the inside of the body on its left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    pub start: Point,
    pub end: Point,
    pub curve: Curve,
}

/// What a piece is cut from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Curve {
    /// A line and its unit normal out of the body.
    Line { normal: Point },
    /// A circle that bulges out of the body; the piece turns by less than half of it.
    Circle { centre: Point, radius: f64 },
}

/// a × b, positive where b is to the left of a.
pub(super) fn cross(a: &Point, b: &Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// The normal to the right of a course: out of the body.
fn to_the_right(course: &Point) -> Point {
    Point::new(course[1], -course[0]) / course.norm()
}

impl Piece {
    pub fn line(start: Point, end: Point) -> Self {
        Self { start, end, curve: Curve::Line { normal: to_the_right(&(end - start)) } }
    }

    /// The arc of this radius, at least half of the chord, whose centre is to the left of the chord.
    pub fn arc((start, end): (Point, Point), radius: f64) -> Self {
        let chord = end - start;
        let height = (radius * radius - 0.25 * chord.norm_squared()).max(0.0).sqrt();
        let centre = (start + end) / 2.0 - to_the_right(&chord) * height;
        Self { start, end, curve: Curve::Circle { centre, radius } }
    }

    pub fn moved(&self, by: &Point) -> Self {
        let curve = match self.curve {
            Curve::Circle { centre, radius } => Curve::Circle { centre: centre + by, radius },
            line @ Curve::Line { .. } => line,
        };
        Self { start: self.start + by, end: self.end + by, curve }
    }

    /// Signed distance from the whole line or circle, and the normal of that at its point nearest to `p`.
    pub fn gap(&self, p: &Point) -> (f64, Point) {
        match self.curve {
            Curve::Line { normal } => (normal.dot(&(p - self.start)), normal),
            Curve::Circle { centre, radius } => {
                let arm = p - centre;
                let length = arm.norm();
                // In the centre every direction is as good: that of the start.
                let normal = if length > 0.0 { arm / length } else { (self.start - centre) / radius };
                (length - radius, normal)
            }
        }
    }

    /// Whether the point of the line or circle that is nearest to `p` belongs to the piece.
    pub fn faces(&self, p: &Point) -> bool {
        match self.curve {
            Curve::Line { .. } => {
                let course = self.end - self.start;
                (p - self.start).dot(&course) >= 0.0 && (p - self.end).dot(&course) <= 0.0
            }
            Curve::Circle { centre, .. } => {
                let arm = p - centre;
                cross(&(self.start - centre), &arm) >= 0.0 && cross(&arm, &(self.end - centre)) >= 0.0
            }
        }
    }

    /// The part from `start` to `end`, and about its length, m: negative if they are in the wrong order.
    pub fn between(&self, start: Point, end: Point) -> (Self, f64) {
        let ahead = match self.curve {
            Curve::Line { normal } => cross(&normal, &(end - start)),
            Curve::Circle { centre, radius } => cross(&(start - centre), &(end - centre)) / radius,
        };
        (Self { start, end, curve: self.curve }, ahead)
    }

    /// The point a `fraction` of the way along, and dz/d`fraction` there.
    pub fn at(&self, fraction: f64) -> (Point, f64) {
        match self.curve {
            Curve::Line { .. } => (self.start + (self.end - self.start) * fraction, self.end[1] - self.start[1]),
            Curve::Circle { centre, .. } => {
                let (from, angle) = (self.start - centre, self.angle());
                let (sin, cos) = libm::sincos(angle * fraction);
                let arm = from * cos + Point::new(-from[1], from[0]) * sin;
                (centre + arm, arm[0] * angle)
            }
        }
    }

    /// Angle that the normal turns by, rad.
    pub fn angle(&self) -> f64 {
        match self.curve {
            Curve::Line { .. } => 0.0,
            Curve::Circle { centre, .. } => {
                let (from, to) = (self.start - centre, self.end - centre);
                libm::atan2(cross(&from, &to), from.dot(&to))
            }
        }
    }
}
