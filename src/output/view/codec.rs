//! Compact form of a part: quantised numbers, differences, zlib.

use super::part::ViewPart;
use crate::math::Vector3;
use crate::output::bounds::AxisAlignedBox;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;
use std::io::Write;

/// Steps of a quantised position and of a quantised field value.
const POSITION_STEPS: f64 = 65535.0;
const VALUE_STEPS: f64 = 255.0;

/// Range of the values of a field: the quantised 0 and 255 are its ends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct ValueRange {
    pub(super) low: f64,
    pub(super) high: f64,
    /// True if the logarithm of a value is quantised.
    pub(super) logarithmic: bool,
}

impl ValueRange {
    /// Returns the quantised value; values beyond the ends, and unknown values, take an end.
    fn quantise(&self, value: f64) -> u8 {
        let place = if self.logarithmic {
            (value.max(f64::MIN_POSITIVE) / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        (place * VALUE_STEPS).round().clamp(0.0, VALUE_STEPS) as u8
    }
}

/// Returns the bytes of a part: x, y and z in 16 bits within a box, triangles and edges in 32 bits, and the fields in 8
/// bits; each number is the difference to the number before.
pub(super) fn part_bytes(part: &ViewPart, extent: &AxisAlignedBox, fields: &[(Vec<f64>, ValueRange)]) -> Vec<u8> {
    let mut bytes = vec![];
    let size = extent.upper - extent.lower;
    for axis in 0..3 {
        let places = part.points.iter().map(|point| quantised_place(&point.at, extent, &size, axis));
        let differences = differences(places, u16::wrapping_sub);
        bytes.extend(differences.into_iter().flat_map(u16::to_le_bytes));
    }
    let corners = part.triangles.iter().flatten().chain(part.edges.iter().flatten()).copied();
    bytes.extend(differences(corners, u32::wrapping_sub).into_iter().flat_map(u32::to_le_bytes));
    for (values, range) in fields {
        bytes.extend(differences(values.iter().map(|value| range.quantise(*value)), u8::wrapping_sub));
    }
    bytes
}

fn quantised_place(at: &Vector3, extent: &AxisAlignedBox, size: &Vector3, axis: usize) -> u16 {
    let place = (at[axis] - extent.lower[axis]) / size[axis].max(f64::MIN_POSITIVE);
    (place * POSITION_STEPS).round().clamp(0.0, POSITION_STEPS) as u16
}

fn differences<T: Copy + Default>(numbers: impl Iterator<Item = T>, subtract: fn(T, T) -> T) -> Vec<T> {
    let mut before = T::default();
    numbers.map(|number| subtract(number, std::mem::replace(&mut before, number))).collect()
}

/// Returns a text of bytes in the zlib format, marked as the data of a link: `base64,…`.
pub(in crate::output) fn packed_text(bytes: &[u8]) -> String {
    base64_text(&deflate(bytes))
}

/// Returns bytes as a marked text.
pub(super) fn base64_text(bytes: &[u8]) -> String {
    format!("base64,{}", STANDARD.encode(bytes))
}

/// Returns bytes in the zlib format, which a browser calls deflate.
pub(super) fn deflate(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).expect("a buffer grows");
    encoder.finish().expect("a buffer grows")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::view::part::{PartKind, PartPoint};
    use flate2::read::ZlibDecoder;
    use std::io::Read;

    #[test]
    fn a_part_is_its_quantised_numbers_as_differences() {
        let point = |x: f64, z: f64| PartPoint { nodes: [0; 2], share: 0.0, at: Vector3::new(x, 0.0, z) };
        let points = vec![point(0.0, -1.0), point(1.0, 1.0), point(0.5, 0.0)];
        let part = ViewPart { kind: PartKind::Section, points, triangles: vec![[0, 2, 1]], edges: vec![[1, 0]] };
        let extent = AxisAlignedBox::around(part.points.iter().map(|point| point.at));
        let range = ValueRange { low: 1.0, high: 100.0, logarithmic: true };
        let bytes = part_bytes(&part, &extent, &[(vec![0.0, 10.0, f64::NAN], range)]);
        let words: Vec<u16> = bytes[..18].as_chunks::<2>().0.iter().map(|word| u16::from_le_bytes(*word)).collect();
        assert_eq!(words, [0, 65535, 32769, 0, 0, 0, 0, 65535, 32769]);
        let corners: Vec<u32> = bytes[18..38].as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
        assert_eq!(corners, [0, 2, u32::MAX, 0, u32::MAX]);
        assert_eq!(bytes[38..], [0, 128, 128], "a value below the range and an unknown value take its lower end");
        let mut back = vec![];
        ZlibDecoder::new(deflate(&bytes).as_slice()).read_to_end(&mut back).expect("zlib");
        assert_eq!(back, bytes);
    }
}
