use super::piece::{PieceCurve, ProfilePiece, ProfilePoint, cross};

/// Outline of a convex body: lines and arcs from the tip, on the axis at z = 0, to the rear on the axis. ρ is the
/// distance from the axis, z the distance behind the tip.
///
/// # Examples
/// ```
/// use ballistic_gel::geometry::{ProfileBody, ProfileOutline, ProfileSweep, SignedDistance};
///
/// let bowl = ProfileOutline::at_tip().arc(1.0, 1.0, 1.0).line(0.0, 1.0);
/// let bowl = ProfileBody::new(&bowl.rounded(0.1).expect("the rim has room"), ProfileSweep::Revolution);
/// assert!((bowl.reach(&nalgebra::Vector3::z()) - 3.0 / 8.0).abs() < 0.01);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ProfileOutline {
    at: ProfilePoint,
    pub(super) pieces: Vec<ProfilePiece>,
}

/// Round-off limit, as the sine of an angle or as a fraction of a radius: below it two pieces join smoothly.
const SMOOTH: f64 = 1e-9;

impl ProfileOutline {
    /// Starts an outline at the tip.
    #[must_use]
    pub fn at_tip() -> Self {
        Self { at: ProfilePoint::zeros(), pieces: Vec::new() }
    }

    /// Appends a line to (ρ, z), m; appends nothing if the outline already ends there.
    #[must_use]
    pub fn line(self, rho: f64, z: f64) -> Self {
        self.to(ProfilePoint::new(rho, z), ProfilePiece::line)
    }

    /// Appends an arc to (ρ, z), m, with this radius, m; it bulges outwards.
    ///
    /// # Panics
    /// If (ρ, z) is further away than the diameter of the arc.
    #[must_use]
    pub fn arc(self, rho: f64, z: f64, radius: f64) -> Self {
        let chord = (ProfilePoint::new(rho, z) - self.at).norm();
        assert!(chord <= 2.0 * radius * (1.0 + SMOOTH), "an arc reaches no further than its diameter");
        self.to(ProfilePoint::new(rho, z), |start, end| ProfilePiece::arc(start, end, radius))
    }

    /// Appends a piece, unless the outline already ends at `end`.
    fn to(mut self, end: ProfilePoint, piece: impl FnOnce(ProfilePoint, ProfilePoint) -> ProfilePiece) -> Self {
        if end != self.at {
            self.pieces.push(piece(self.at, end));
            self.at = end;
        }
        self
    }

    /// Rounds every rim by an arc of this radius, m, tangent to both sides; the ends on the axis stay. `None` if a
    /// rounding has no room.
    #[must_use]
    pub fn rounded(&self, radius: f64) -> Option<Self> {
        let room = SMOOTH * radius;
        let mut pieces = Vec::with_capacity(2 * self.pieces.len());
        let mut start = self.pieces.first()?.start;
        for (i, piece) in self.pieces.iter().enumerate() {
            let rim = self.pieces.get(i + 1).filter(|next| radius > 0.0 && is_rim(piece, next));
            let rounding = match rim {
                Some(next) => Some(rounding(piece, next, radius)?),
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
        // Where rounding consumes a piece that ends on the axis, the adjacent rounding ends there instead.
        pieces.first_mut()?.start = self.pieces[0].start;
        pieces.last_mut()?.end = self.at;
        Some(Self { at: self.at, pieces })
    }
}

/// Returns true if two consecutive pieces meet in a convex edge.
fn is_rim(piece: &ProfilePiece, next: &ProfilePiece) -> bool {
    let (before, after) = (piece.gap(&piece.end).normal, next.gap(&next.start).normal);
    cross(&before, &after) > SMOOTH
}

/// Arc of this radius tangent to both pieces from inside. Newton's method finds the centre, at depth `radius` below
/// both.
fn rounding(piece: &ProfilePiece, next: &ProfilePiece, radius: f64) -> Option<ProfilePiece> {
    const MOST_ITERATIONS: usize = 50;
    let mut centre = piece.end;
    for _ in 0..MOST_ITERATIONS {
        let (own, other) = (piece.gap(&centre), next.gap(&centre));
        let (m, n) = (own.normal, other.normal);
        let (d, e, turn) = (own.distance + radius, other.distance + radius, cross(&m, &n));
        if d.abs().max(e.abs()) <= SMOOTH * radius {
            let (start, end) = (centre + m * radius, centre + n * radius);
            return (turn > SMOOTH).then_some(ProfilePiece {
                start,
                end,
                curve: PieceCurve::Circle { centre, radius },
            });
        }
        centre -= ProfilePoint::new(d * n[1] - e * m[1], e * m[0] - d * n[0]) / turn;
    }
    None
}
