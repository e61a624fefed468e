use super::piece::{Curve, Piece, Point, cross};

/// A convex profile in the making: lines and arcs from the tip of a body of revolution, on its axis at z = 0, to its rear
/// on the axis; ρ is the distance from the axis, z that behind the tip.
///
/// # Examples
/// ```
/// use ballistic_gel::geometry::{Outline, Profile, SignedDistance, Sweep};
///
/// let bowl = Outline::at_tip().arc(1.0, 1.0, 1.0).line(0.0, 1.0);
/// let bowl = Profile::new(&bowl.rounded(0.1).expect("the rim has room"), Sweep::Revolution);
/// assert!((bowl.reach(&nalgebra::Vector3::z()) - 3.0 / 8.0).abs() < 0.01);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    at: Point,
    pub(super) pieces: Vec<Piece>,
}

/// Sine of an angle, or fraction of a radius, that is round-off: below it two pieces join smoothly.
const SMOOTH: f64 = 1e-9;

impl Outline {
    /// Nothing but the tip.
    #[must_use]
    pub fn at_tip() -> Self {
        Self { at: Point::zeros(), pieces: Vec::new() }
    }

    /// Goes on straight to (ρ, z), m; nothing if it is there already.
    #[must_use]
    pub fn line(self, rho: f64, z: f64) -> Self {
        self.to(Point::new(rho, z), Piece::line)
    }

    /// Goes on to (ρ, z), m, along an arc of this radius, m, that bulges outwards.
    ///
    /// # Panics
    /// If (ρ, z) is further away than the diameter of the arc.
    #[must_use]
    pub fn arc(self, rho: f64, z: f64, radius: f64) -> Self {
        let chord = (Point::new(rho, z) - self.at).norm();
        assert!(chord <= 2.0 * radius * (1.0 + SMOOTH), "an arc reaches no further than its diameter");
        self.to(Point::new(rho, z), |start, end| Piece::arc((start, end), radius))
    }

    fn to(mut self, end: Point, piece: impl FnOnce(Point, Point) -> Piece) -> Self {
        if end != self.at {
            self.pieces.push(piece(self.at, end));
            self.at = end;
        }
        self
    }

    /// The outline with every rim rounded by an arc of this radius, m, tangent to both sides; the ends on the axis stay as
    /// they are. `None` if there is no room for it.
    #[must_use]
    pub fn rounded(&self, radius: f64) -> Option<Self> {
        let room = SMOOTH * radius;
        let mut pieces = Vec::with_capacity(2 * self.pieces.len());
        let mut start = self.pieces.first()?.start;
        for (i, piece) in self.pieces.iter().enumerate() {
            let rim = self.pieces.get(i + 1).filter(|next| radius > 0.0 && is_rim(piece, next));
            let rounding = match rim {
                Some(next) => Some(rounding((piece, next), radius)?),
                None => None,
            };
            let (rest, length) = piece.between(start, rounding.map_or(piece.end, |arc| arc.start));
            if length < -room {
                return None;
            }
            pieces.extend((length > room).then_some(rest));
            pieces.extend(rounding);
            start = rounding.map_or(piece.end, |arc| arc.end);
        }
        // Where a piece that ends on the axis is used up, the rounding beside it ends there.
        pieces.first_mut()?.start = self.pieces[0].start;
        pieces.last_mut()?.end = self.at;
        Some(Self { at: self.at, pieces })
    }
}

fn is_rim(piece: &Piece, next: &Piece) -> bool {
    let ((_, before), (_, after)) = (piece.gap(&piece.end), next.gap(&next.start));
    cross(&before, &after) > SMOOTH
}

/// The arc of this radius that touches both pieces from inside: Newton's method for the point at that depth below both.
fn rounding((piece, next): (&Piece, &Piece), radius: f64) -> Option<Piece> {
    const MOST_ITERATIONS: usize = 50;
    let mut centre = piece.end;
    for _ in 0..MOST_ITERATIONS {
        let ((d, m), (e, n)) = (piece.gap(&centre), next.gap(&centre));
        let (d, e, turn) = (d + radius, e + radius, cross(&m, &n));
        if d.abs().max(e.abs()) <= SMOOTH * radius {
            let (start, end) = (centre + m * radius, centre + n * radius);
            return (turn > SMOOTH).then_some(Piece { start, end, curve: Curve::Circle { centre, radius } });
        }
        centre -= Point::new(d * n[1] - e * m[1], e * m[0] - d * n[0]) / turn;
    }
    None
}
