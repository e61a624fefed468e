//! Reader of the grids that this crate writes for ParaView: the arrays of a `.vtu` file by name.

use crate::math::Vector3;
use flate2::read::ZlibDecoder;
use std::io::Read;

/// Marker between the header of a file and its arrays.
const APPENDED: &[u8] = b"<AppendedData encoding=\"raw\">\n_";

/// Grid of the gel at one time.
pub(super) struct GelGrid {
    pub(super) time: f64,
    pub(super) points: Vec<Vector3>,
    pub(super) velocities: Vec<Vector3>,
    /// Node indices of all elements, one after the other.
    pub(super) nodes: Vec<u32>,
    pub(super) steps: Vec<f64>,
    /// Nodes of an element.
    pub(super) corners: usize,
}

/// Header and arrays of a file.
struct GridFile<'a> {
    header: String,
    arrays: &'a [u8],
}

/// Parses a file of the gel; `None` if it is not one of this crate.
pub(super) fn parse(bytes: &[u8]) -> Option<GelGrid> {
    let start = bytes.windows(APPENDED.len()).position(|window| window == APPENDED)?;
    let header = String::from_utf8_lossy(&bytes[..start]).into_owned();
    let file = GridFile { header, arrays: &bytes[start + APPENDED.len()..] };
    let doubles = |name: &str| file.numbers(name, |bytes: [u8; 8]| f64::from_le_bytes(bytes));
    let floats = |name: &str| file.numbers(name, |bytes: [u8; 4]| f64::from(f32::from_le_bytes(bytes)));
    let nodes = file.numbers("connectivity", |bytes: [u8; 4]| u32::from_le_bytes(bytes))?;
    let (points, steps) = (vectors(&doubles("Points")?), floats("step")?);
    let corners = nodes.len().checked_div(steps.len())?;
    let is_whole = (3..=4).contains(&corners) && nodes.len() == corners * steps.len();
    let is_within = nodes.iter().all(|node| (*node as usize) < points.len());
    let velocities = vectors(&floats("velocity")?);
    let time = *doubles("TimeValue")?.first()?;
    let is_grid = is_whole && is_within && velocities.len() == points.len();
    is_grid.then_some(GelGrid { time, points, velocities, nodes, steps, corners })
}

impl GridFile<'_> {
    /// Returns the numbers of an array of `N` bytes each.
    fn numbers<const N: usize, T>(&self, name: &str, read: fn([u8; N]) -> T) -> Option<Vec<T>> {
        let rest = self.header.split_once(&format!("Name=\"{name}\""))?.1;
        let offset: usize = rest.split_once("offset=\"")?.1.split('"').next()?.parse().ok()?;
        let bytes = inflate(self.arrays.get(offset..)?)?;
        Some(bytes.as_chunks::<N>().0.iter().map(|number| read(*number)).collect())
    }
}

/// Returns the bytes of a compressed array: the number of blocks, their size, that of a smaller last one, and the
/// compressed size of each; then the blocks as zlib streams. `None` if it is cut short.
fn inflate(array: &[u8]) -> Option<Vec<u8>> {
    let (numbers, _) = array.as_chunks::<8>();
    let number = |i: usize| Some(u64::from_le_bytes(*numbers.get(i)?) as usize);
    let blocks = number(0)?;
    let (mut bytes, mut rest) = (vec![], array.get(blocks.checked_add(3)?.checked_mul(8)?..)?);
    for block in 0..blocks {
        let (stream, after) = rest.split_at_checked(number(3 + block)?)?;
        ZlibDecoder::new(stream).read_to_end(&mut bytes).ok()?;
        rest = after;
    }
    Some(bytes)
}

fn vectors(numbers: &[f64]) -> Vec<Vector3> {
    numbers.as_chunks::<3>().0.iter().map(|vector| Vector3::from(*vector)).collect()
}
