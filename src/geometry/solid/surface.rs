//! A closed surface of triangles: which corners are one, and whether every edge is shared by two triangles.

use crate::math::Vector3;

/// A closed surface of triangles, outward oriented.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    pub(super) points: Vec<Vector3>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Triangle across the edge opposite to each corner.
    pub(super) across: Vec<[u32; 3]>,
    turned: bool,
}

/// Triangles that enclose nothing, or not as they should. Places are in the units that the triangles were given in.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// Fewer triangles than a tetrahedron has.
    #[error("{count} triangles")]
    TooFew {
        /// Triangles with three different corners.
        count: usize,
    },
    /// More triangles than are taken.
    #[error("{count} triangles")]
    TooMany {
        /// Triangles given.
        count: usize,
    },
    /// A corner that is not a place.
    #[error("a corner that is not finite, or beyond 1e15, in triangle {triangle}")]
    NotFinite {
        /// The triangle, from 1.
        triangle: usize,
    },
    /// Edges of one triangle only.
    #[error("{count} open edges, one at {}", Place(at))]
    Open {
        /// Such edges.
        count: usize,
        /// The middle of one.
        at: [f64; 3],
    },
    /// Edges of three triangles or more.
    #[error("{count} edges with more than two triangles, one at {}", Place(at))]
    Branched {
        /// Such edges.
        count: usize,
        /// The middle of one.
        at: [f64; 3],
    },
    /// Edges whose triangles face to different sides.
    #[error("{count} edges between triangles that face to different sides, one at {}", Place(at))]
    Disoriented {
        /// Such edges.
        count: usize,
        /// The middle of one.
        at: [f64; 3],
    },
    /// A surface as flat as its round-off.
    #[error("triangles that enclose a volume of {volume:e}")]
    Flat {
        /// The volume.
        volume: f64,
    },
    /// Triangles that pass through each other.
    #[error("a triangle that passes through another at {}", Place(at))]
    Crossing {
        /// Where.
        at: [f64; 3],
    },
    /// Parts that have a place in common, or lie on each other: mass and distance there are not those of their union.
    #[error("parts that overlap or lie on each other, near {}", Place(at))]
    Overlapping {
        /// A point inside of one.
        at: [f64; 3],
    },
    /// A part of the surface that faces inwards although it is not the wall of a cavity.
    #[error("a part that is inside out, near {}", Place(at))]
    InsideOut {
        /// A point outside of it that it has for inside.
        at: [f64; 3],
    },
}

/// A place as a list of three numbers.
struct Place<'a>(&'a [f64; 3]);

impl std::fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "[{x:.6}, {y:.6}, {z:.6}]")
    }
}

/// An edge in the direction of its triangle, the triangle and the corner opposite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    ends: [u32; 2],
    triangle: u32,
    opposite: u8,
}

/// Beyond, volumes leave the numbers.
const LARGEST: f64 = 1e15;
/// A surface of this volume, in sizes cubed, is a sheet.
const FLAT: f64 = 1e-9;

impl Surface {
    /// The most triangles that are taken: half a gigabyte, and 7 s to look at those of a ball.
    pub const MOST_TRIANGLES: usize = 500_000;

    /// The surface of these triangles. Corners at the same place are one; triangles with two corners at one place are left
    /// out; a surface that is inside out as a whole is turned.
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
        let (points, mut triangles) = joined(corners);
        triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        if triangles.len() < 4 {
            return Err(SurfaceError::TooFew { count: triangles.len() });
        }
        let across = closed(&points, &triangles)?;
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

    /// Whether the triangles as given faced inwards.
    #[must_use]
    pub fn was_turned(&self) -> bool {
        self.turned
    }

    fn turn(&mut self) {
        self.triangles.iter_mut().chain(&mut self.across).for_each(|corners| corners.swap(1, 2));
        self.turned = true;
    }

    /// The corners of each triangle.
    pub(super) fn corners(&self) -> impl ExactSizeIterator<Item = [Vector3; 3]> + '_ {
        self.triangles.iter().map(|triangle| triangle.map(|i| self.points[i as usize]))
    }

    /// Length of the diagonal of its box.
    pub(super) fn size(&self) -> f64 {
        let (lower, upper) = self.bounds();
        (upper - lower).norm()
    }

    /// The corners of its box.
    pub(super) fn bounds(&self) -> (Vector3, Vector3) {
        let first = self.points[0];
        self.points.iter().fold((first, first), |(lower, upper), p| (lower.inf(p), upper.sup(p)))
    }

    /// Volume enclosed, negative if inside out.
    pub(super) fn volume(&self) -> f64 {
        let from = self.points[0];
        self.corners().map(|[a, b, c]| (a - from).dot(&(b - from).cross(&(c - from)))).sum::<f64>() / 6.0
    }
}

/// Places and, for each triangle, the numbers of its corners; equal places have one number.
fn joined(corners: &[[Vector3; 3]]) -> (Vec<Vector3>, Vec<[u32; 3]>) {
    // Adding zero makes −0 a 0.
    let bits = |p: &Vector3| [p.x + 0.0, p.y + 0.0, p.z + 0.0].map(f64::to_bits);
    let mut places: Vec<[u64; 3]> = corners.iter().flatten().map(bits).collect();
    places.sort_unstable();
    places.dedup();
    let number = |p: &Vector3| places.partition_point(|place| *place < bits(p)) as u32;
    let triangles = corners.iter().map(|triangle| triangle.each_ref().map(number)).collect();
    (places.iter().map(|place| Vector3::from(place.map(f64::from_bits))).collect(), triangles)
}

/// The triangle across each edge; each edge must have one in either direction.
fn closed(points: &[Vector3], triangles: &[[u32; 3]]) -> Result<Vec<[u32; 3]>, SurfaceError> {
    let ends = |t: &[u32; 3], i: usize| [t[(i + 1) % 3], t[(i + 2) % 3]];
    let edge = |n: usize, t: &[u32; 3], i: usize| Edge { ends: ends(t, i), triangle: n as u32, opposite: i as u8 };
    let mut edges: Vec<Edge> =
        triangles.iter().enumerate().flat_map(|(n, t)| (0..3).map(move |i| edge(n, t, i))).collect();
    // Both directions of an edge stand together.
    edges.sort_unstable_by_key(|e| ([e.ends[0].min(e.ends[1]), e.ends[0].max(e.ends[1])], *e));
    let same = |a: &Edge, b: &Edge| a.ends == b.ends || a.ends == [b.ends[1], b.ends[0]];
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
