//! Reader of the grids that this crate writes for ParaView: the arrays of a `.vtu` file by name.

use crate::math::Vector3;
use flate2::read::ZlibDecoder;
use std::cell::Cell;
use std::io::Read;

/// Marker between the header of a file and its arrays.
const APPENDED: &[u8] = b"<AppendedData encoding=\"raw\">\n_";

/// Grid of the gel at one time.
pub(super) struct GelGrid {
    pub(super) time: f64,
    pub(super) points: Vec<Vector3>,
    pub(super) velocities: Vec<Vector3>,
    pub(super) displacements: Vec<Vector3>,
    /// Node indices of all elements, one after the other.
    pub(super) nodes: Vec<u32>,
    pub(super) steps: Vec<f64>,
    pub(super) jacobians: Vec<f64>,
    pub(super) energy_densities: Vec<f64>,
    pub(super) damage: Vec<f64>,
    /// Values of each wanted field at the nodes and in the elements.
    pub(super) fields: Vec<(Vec<f64>, Vec<f64>)>,
    /// Nodes of an element.
    pub(super) corners: usize,
}

/// Header and arrays of a file.
struct GridFile<'a> {
    header: String,
    arrays: &'a [u8],
    /// Bytes that its arrays may still have when inflated; `None` once they had more.
    left: Cell<Option<u64>>,
}

/// Parses a file of the gel with these fields, whose arrays have at most `most` bytes when inflated.
///
/// # Errors
/// The content found instead of a file of this crate.
pub(super) fn parse(bytes: &[u8], fields: &[&str], most: u64) -> Result<GelGrid, String> {
    let no_grid = || "no grid of a gel".to_owned();
    let start = bytes.windows(APPENDED.len()).position(|window| window == APPENDED).ok_or_else(no_grid)?;
    let header = String::from_utf8_lossy(&bytes[..start]).into_owned();
    let file = GridFile { header, arrays: &bytes[start + APPENDED.len()..], left: Cell::new(Some(most)) };
    let grid = read_grid(&file, fields);
    match file.left.get() {
        Some(_) => grid.ok_or_else(no_grid),
        None => Err(format!("arrays that inflate to more than {most} bytes")),
    }
}

/// Reads the grid of a file; `None` if an array is missing, cut short or too long.
fn read_grid(file: &GridFile, fields: &[&str]) -> Option<GelGrid> {
    let doubles = |name: &str| file.numbers(name, |bytes: [u8; 8]| f64::from_le_bytes(bytes));
    let floats = |name: &str| file.numbers(name, |bytes: [u8; 4]| f64::from(f32::from_le_bytes(bytes)));
    let nodes = file.numbers("connectivity", |bytes: [u8; 4]| u32::from_le_bytes(bytes))?;
    let (points, steps) = (vectors(&doubles("Points")?), floats("step")?);
    let corners = nodes.len().checked_div(steps.len())?;
    let is_whole = (3..=4).contains(&corners) && nodes.len() == corners * steps.len();
    let is_within = nodes.iter().all(|node| (*node as usize) < points.len());
    let [velocities, displacements] = [vectors(&floats("velocity")?), vectors(&floats("displacement")?)];
    let [jacobians, energy_densities] = [floats("jacobian")?, floats("energy_density")?];
    let damage = file.cell_floats("damage").unwrap_or_else(|| vec![0.0; steps.len()]);
    let fields: Option<Vec<(Vec<f64>, Vec<f64>)>> =
        fields.iter().map(|name| floats(name).zip(file.cell_floats(name))).collect();
    let fields = fields?;
    let of_nodes = [velocities.len(), displacements.len()].into_iter().chain(fields.iter().map(|field| field.0.len()));
    let of_cells = [jacobians.len(), energy_densities.len(), damage.len()];
    let of_cells = of_cells.into_iter().chain(fields.iter().map(|field| field.1.len()));
    let is_complete = of_nodes.into_iter().all(|n| n == points.len()) && of_cells.into_iter().all(|n| n == steps.len());
    let time = *doubles("TimeValue")?.first()?;
    (is_whole && is_within && is_complete).then_some(GelGrid {
        time,
        points,
        velocities,
        displacements,
        nodes,
        steps,
        jacobians,
        energy_densities,
        damage,
        fields,
        corners,
    })
}

impl GridFile<'_> {
    /// Returns the numbers of the first array of a name, of `N` bytes each.
    fn numbers<const N: usize, T>(&self, name: &str, read: fn([u8; N]) -> T) -> Option<Vec<T>> {
        self.numbers_in(&self.header, name, read)
    }

    /// Returns the array of the elements of a name.
    fn cell_floats(&self, name: &str) -> Option<Vec<f64>> {
        let section = self.header.split_once("<CellData>")?.1;
        self.numbers_in(section, name, |bytes: [u8; 4]| f64::from(f32::from_le_bytes(bytes)))
    }

    fn numbers_in<const N: usize, T>(&self, section: &str, name: &str, read: fn([u8; N]) -> T) -> Option<Vec<T>> {
        let rest = section.split_once(&format!("Name=\"{name}\""))?.1;
        let offset: usize = rest.split_once("offset=\"")?.1.split('"').next()?.parse().ok()?;
        let bytes = self.inflate(self.arrays.get(offset..)?)?;
        Some(bytes.as_chunks::<N>().0.iter().map(|number| read(*number)).collect())
    }

    /// Returns the bytes of a compressed array: the number of blocks, their size, that of a smaller last one, and the
    /// compressed size of each; then the blocks as zlib streams. `None` if it is cut short, or longer than what is
    /// left.
    fn inflate(&self, array: &[u8]) -> Option<Vec<u8>> {
        let (numbers, _) = array.as_chunks::<8>();
        let number = |i: usize| Some(u64::from_le_bytes(*numbers.get(i)?) as usize);
        let blocks = number(0)?;
        let (mut bytes, mut rest) = (vec![], array.get(blocks.checked_add(3)?.checked_mul(8)?..)?);
        for block in 0..blocks {
            let (stream, after) = rest.split_at_checked(number(3 + block)?)?;
            let left = self.left.get()?;
            let length = ZlibDecoder::new(stream).take(left + 1).read_to_end(&mut bytes).ok()?;
            self.left.set(left.checked_sub(length as u64));
            rest = after;
        }
        self.left.get().map(|_| bytes)
    }
}

fn vectors(numbers: &[f64]) -> Vec<Vector3> {
    numbers.as_chunks::<3>().0.iter().map(|vector| Vector3::from(*vector)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::{Compression, write::ZlibEncoder};
    use std::io::Write;

    #[test]
    fn an_array_that_inflates_beyond_the_limit_is_refused_before_it_is_inflated() {
        let mut encoder = ZlibEncoder::new(vec![], Compression::fast());
        encoder.write_all(&vec![0; 1 << 20]).unwrap();
        let stream = encoder.finish().unwrap();
        assert!(stream.len() < 1 << 14);
        let sizes = [1, 1 << 18, 0, stream.len() as u64].map(u64::to_le_bytes).concat();
        let header = b"<DataArray Name=\"connectivity\" offset=\"0\"/>\n<AppendedData encoding=\"raw\">\n_".as_slice();
        let file = [header, &sizes, &stream].concat();
        let refused = |most| parse(&file, &[], most).err().unwrap();
        assert_eq!(refused(1 << 16), "arrays that inflate to more than 65536 bytes");
        assert_eq!(refused(1 << 20), "no grid of a gel", "the other arrays are missing");
    }
}
