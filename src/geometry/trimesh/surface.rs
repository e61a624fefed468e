//! Closed triangulated surface: corners are merged by position, and every edge is checked to have two triangles.

use crate::math::Vector3;

/// Closed triangulated surface, outward oriented.
#[derive(Debug, Clone, PartialEq)]
pub struct TriangleSurface {
    pub(super) points: Vec<Vector3>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Triangle across the edge opposite to each corner.
    pub(super) across: Vec<[u32; 3]>,
    turned: bool,
}

/// Defect of a list of triangles as a closed surface. Positions are in the units of the triangles.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// Fewer triangles than a tetrahedron has.
    #[error("{count} triangles")]
    TooFew {
        /// Number of triangles with three different corners.
        count: usize,
    },
    /// More triangles than the limit.
    #[error("{count} triangles")]
    TooMany {
        /// Number of triangles given.
        count: usize,
    },
    /// A corner without finite coordinates, or beyond the limit.
    #[error("a corner that is not finite, or beyond 1e15, in triangle {triangle}")]
    NotFinite {
        /// Number of the triangle, from 1.
        triangle: usize,
    },
    /// Edges with only one triangle.
    #[error("{count} open edges, one at {}", PointText(at))]
    Open {
        /// Number of such edges.
        count: usize,
        /// The middle of one.
        at: [f64; 3],
    },
    /// Edges with three triangles or more.
    #[error("{count} edges with more than two triangles, one at {}", PointText(at))]
    Branched {
        /// Number of such edges.
        count: usize,
        /// The middle of one.
        at: [f64; 3],
    },
    /// Edges between triangles of opposite orientation.
    #[error("{count} edges between triangles that face to different sides, one at {}", PointText(at))]
    Disoriented {
        /// Number of such edges.
        count: usize,
        /// The middle of one.
        at: [f64; 3],
    },
    /// A surface whose volume is within round-off of zero.
    #[error("triangles that enclose a volume of {volume:e}")]
    Flat {
        /// Enclosed volume.
        volume: f64,
    },
    /// Triangles that cross each other.
    #[error("a triangle that passes through another at {}", PointText(at))]
    Crossing {
        /// Point of a crossing.
        at: [f64; 3],
    },
    /// Parts that overlap or coincide: mass and distance there are not those of their union.
    #[error("parts that overlap or lie on each other, near {}", PointText(at))]
    Overlapping {
        /// Point inside one of the parts.
        at: [f64; 3],
    },
    /// A part of the surface that faces inwards although it is not the wall of a cavity.
    #[error("a part that is inside out, near {}", PointText(at))]
    InsideOut {
        /// Point outside the part that the part has on its inner side.
        at: [f64; 3],
    },
}

/// Text of a position: a list of three numbers.
struct PointText<'a>(&'a [f64; 3]);

impl std::fmt::Display for PointText<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "[{x:.6}, {y:.6}, {z:.6}]")
    }
}

/// Directed edge of a triangle, with the triangle and the opposite corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct DirectedEdge {
    ends: [u32; 2],
    triangle: u32,
    opposite: u8,
}

/// Greatest coordinate: beyond it volumes overflow.
const LARGEST: f64 = 1e15;
/// Volume, in sizes cubed, below which a surface is flat.
const FLAT: f64 = 1e-9;

impl TriangleSurface {
    /// Greatest number of triangles: half a gigabyte, and 7 s to check those of a ball.
    pub const MOST_TRIANGLES: usize = 500_000;

    /// Builds the surface of these triangles. Corners at one position are merged, degenerate triangles are dropped, and
    /// a surface that is inside out as a whole is reversed.
    ///
    /// # Errors
    /// [`SurfaceError`] if it is not closed, not consistently oriented, or encloses nothing.
    pub fn new(corners: &[[Vector3; 3]]) -> Result<Self, SurfaceError> {
        if corners.len() > Self::MOST_TRIANGLES {
            return Err(SurfaceError::TooMany { count: corners.len() });
        }
        let finite = |triangle: &[Vector3; 3]| triangle.iter().flatten().all(|x| x.abs() <= LARGEST);
        if let Some(i) = corners.iter().position(|triangle| !finite(triangle)) {
            return Err(SurfaceError::NotFinite { triangle: i + 1 });
        }
        let (points, mut triangles) = merge_corners(corners);
        triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        if triangles.len() < 4 {
            return Err(SurfaceError::TooFew { count: triangles.len() });
        }
        let across = match_edges(&points, &triangles)?;
        let mut surface = Self { points, triangles, across, turned: false };
        let (volume, size) = (surface.volume(), surface.size());
        if volume.abs() <= FLAT * size * size * size {
            return Err(SurfaceError::Flat { volume });
        }
        if volume < 0.0 {
            surface.turn();
        }
        Ok(surface)
    }

    /// Returns true if the triangles were given facing inwards.
    #[must_use]
    pub fn was_turned(&self) -> bool {
        self.turned
    }

    /// Reverses the orientation.
    fn turn(&mut self) {
        self.triangles.iter_mut().chain(&mut self.across).for_each(|corners| corners.swap(1, 2));
        self.turned = true;
    }

    /// Corners of each triangle.
    pub(super) fn corners(&self) -> impl ExactSizeIterator<Item = [Vector3; 3]> + '_ {
        self.triangles.iter().map(|triangle| triangle.map(|i| self.points[i as usize]))
    }

    /// Diagonal of the bounding box.
    pub(super) fn size(&self) -> f64 {
        let (lower, upper) = self.bounds();
        (upper - lower).norm()
    }

    /// Lower and upper corner of the bounding box.
    pub(super) fn bounds(&self) -> (Vector3, Vector3) {
        let first = self.points[0];
        self.points.iter().fold((first, first), |(lower, upper), p| (lower.inf(p), upper.sup(p)))
    }

    /// Enclosed volume, negative if inside out.
    pub(super) fn volume(&self) -> f64 {
        let from = self.points[0];
        self.corners().map(|[a, b, c]| (a - from).dot(&(b - from).cross(&(c - from)))).sum::<f64>() / 6.0
    }
}

/// Merges corners by position: the distinct positions and, for each triangle, the indices of its corners.
fn merge_corners(corners: &[[Vector3; 3]]) -> (Vec<Vector3>, Vec<[u32; 3]>) {
    // Adding zero makes −0 a 0.
    let bits = |p: &Vector3| [p.x + 0.0, p.y + 0.0, p.z + 0.0].map(f64::to_bits);
    let mut places: Vec<[u64; 3]> = corners.iter().flatten().map(bits).collect();
    places.sort_unstable();
    places.dedup();
    let number = |p: &Vector3| places.partition_point(|place| *place < bits(p)) as u32;
    let triangles = corners.iter().map(|triangle| triangle.each_ref().map(number)).collect();
    (places.iter().map(|place| Vector3::from(place.map(f64::from_bits))).collect(), triangles)
}

/// Finds the triangle across each edge; each edge must have one triangle in either direction.
fn match_edges(points: &[Vector3], triangles: &[[u32; 3]]) -> Result<Vec<[u32; 3]>, SurfaceError> {
    let ends = |t: &[u32; 3], i: usize| [t[(i + 1) % 3], t[(i + 2) % 3]];
    let edge =
        |n: usize, t: &[u32; 3], i: usize| DirectedEdge { ends: ends(t, i), triangle: n as u32, opposite: i as u8 };
    let mut edges: Vec<DirectedEdge> =
        triangles.iter().enumerate().flat_map(|(n, t)| (0..3).map(move |i| edge(n, t, i))).collect();
    // Both directions of an edge are adjacent in this order.
    edges.sort_unstable_by_key(|e| ([e.ends[0].min(e.ends[1]), e.ends[0].max(e.ends[1])], *e));
    let same = |a: &DirectedEdge, b: &DirectedEdge| a.ends == b.ends || a.ends == [b.ends[1], b.ends[0]];
    let (mut open, mut branched, mut disoriented) = (vec![], vec![], vec![]);
    let mut across = vec![[0; 3]; triangles.len()];
    for group in edges.chunk_by(same) {
        match group {
            [a, b] if a.ends != b.ends => {
                across[a.triangle as usize][usize::from(a.opposite)] = b.triangle;
                across[b.triangle as usize][usize::from(b.opposite)] = a.triangle;
            }
            [a, _] => disoriented.push(a.ends),
            [a] => open.push(a.ends),
            _ => branched.push(group[0].ends),
        }
    }
    let middle = |[a, b]: [u32; 2]| ((points[a as usize] + points[b as usize]) / 2.0).into();
    let first = |edges: &[[u32; 2]]| edges.first().map(|edge| (edges.len(), middle(*edge)));
    if let Some((count, at)) = first(&open) {
        return Err(SurfaceError::Open { count, at });
    }
    if let Some((count, at)) = first(&branched) {
        return Err(SurfaceError::Branched { count, at });
    }
    first(&disoriented).map_or(Ok(across), |(count, at)| Err(SurfaceError::Disoriented { count, at }))
}
