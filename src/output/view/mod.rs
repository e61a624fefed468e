//! Data of the view in three dimensions: frames in a compact form that a script of the report unpacks.

mod codec;
mod field;
mod outline;
mod part;

pub(super) use codec::packed_text;
pub(super) use outline::{SectionOutline, SectionPoint};

use super::bounds::AxisAlignedBox;
use crate::scene::Scene;
use crate::simulation::MeshFrame;
use codec::ValueRange;
use field::{FieldScale, ViewField, fields};
use part::{PartKind, ViewPart};
use serde_json::{Value, json};

/// Limit of the bytes of all frames: base64 makes 4 MB of them, and the page stays well below 10 MB.
const MAX_BYTES: usize = 3_000_000;
/// Fraction of the values that a range covers: a few extreme values must not use up the colours.
const COVERED_FRACTION: f64 = 0.999;
/// Ratio of the ends of a logarithmic range.
const LOGARITHMIC_RATIO: f64 = 1e-3;

/// Frame of the view.
#[derive(Debug)]
pub(super) struct ViewFrame {
    /// Time, s.
    pub(super) time: f64,
    /// Description of the parts in the bytes.
    parts: Value,
    /// Height y of the plane of the section, m.
    plane: f64,
    /// Compressed bytes of the parts.
    bytes: Vec<u8>,
}

impl ViewFrame {
    /// Encodes a frame.
    pub(super) fn of(frame: &MeshFrame, scene: &Scene) -> Self {
        let fields = fields(scene);
        let nodal: Vec<Vec<f64>> = fields.iter().map(|field| field.nodal(frame)).collect();
        let (mut parts, mut bytes) = (vec![], vec![]);
        for part in part::parts(frame, scene) {
            let values: Vec<(Vec<f64>, ValueRange)> = match part.kind {
                PartKind::Body => vec![],
                PartKind::Surface | PartKind::Section => {
                    fields.iter().zip(&nodal).map(|(field, nodal)| part_values(&part, field, nodal)).collect()
                }
            };
            let extent = AxisAlignedBox::around(part.points.iter().map(|point| point.at));
            bytes.extend(codec::part_bytes(&part, &extent, &values));
            parts.push(json!({
                "kind": part.kind.name(),
                "points": part.points.len(),
                "triangles": part.triangles.len(),
                "edges": part.edges.len(),
                "low": extent.lower.as_slice(),
                "high": extent.upper.as_slice(),
                "ranges": values.iter().map(|(_, range)| json!([range.low, range.high])).collect::<Vec<_>>(),
            }));
        }
        let plane = part::shot_plane(frame, scene);
        Self { time: frame.time, parts: Value::Array(parts), plane, bytes: codec::deflate(&bytes) }
    }
}

/// Returns the values of a field at the points of a part, and their range.
fn part_values(part: &ViewPart, field: &ViewField, nodal: &[f64]) -> (Vec<f64>, ValueRange) {
    let value = |point: &part::PartPoint| {
        let [a, b] = point.nodes.map(|node| nodal[node as usize]);
        a + point.share * (b - a)
    };
    let values: Vec<f64> = part.points.iter().map(value).collect();
    let range = value_range(&values, field.scale);
    (values, range)
}

fn value_range(values: &[f64], scale: FieldScale) -> ValueRange {
    let mut known: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    known.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| {
        let place = (share * known.len().saturating_sub(1) as f64).round() as usize;
        known.get(place).copied().unwrap_or(0.0)
    };
    let (least, greatest) = (at(1.0 - COVERED_FRACTION), at(COVERED_FRACTION));
    let (low, high) = match scale {
        FieldScale::FromZero => (0.0, greatest.max(0.0)),
        FieldScale::Linear => (least, greatest),
        FieldScale::Logarithmic => (greatest.max(f64::MIN_POSITIVE / LOGARITHMIC_RATIO) * LOGARITHMIC_RATIO, greatest),
        FieldScale::Signed => (-least.abs().max(greatest.abs()), least.abs().max(greatest.abs())),
    };
    let high = if high > low { high } else { low + low.abs().max(f64::MIN_POSITIVE) };
    ValueRange { low, high, logarithmic: scale == FieldScale::Logarithmic }
}

/// Returns the data of the view as JSON without the reserved characters of XML; `None` without a frame that fits into
/// the page. Frames are thinned evenly until all fit. The view opens at the time `moment`, s.
pub(super) fn data(scene: &Scene, moment: f64, frames: &[ViewFrame]) -> Option<String> {
    let kept = thinned(frames);
    if kept.is_empty() {
        return None;
    }
    let frames: Vec<Value> = kept
        .iter()
        .map(|frame| {
            let bytes = codec::base64_text(&frame.bytes);
            json!({ "time": frame.time, "plane": frame.plane, "parts": frame.parts, "bytes": bytes })
        })
        .collect();
    let field = |field: &ViewField| json!({ "name": field.name, "unit": field.unit, "scale": field.scale.name() });
    let fields: Vec<Value> = fields(scene).iter().map(field).collect();
    let data = json!({
        "dimension": scene.scene.dimension,
        "moment": moment,
        "mirrored": scene.gel.symmetry.mirrored(),
        "fields": fields,
        "frames": frames,
    });
    Some(data.to_string().replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026"))
}

/// Returns the frames at the least interval at which all fit into the page; the last frame is one of them.
fn thinned(frames: &[ViewFrame]) -> Vec<&ViewFrame> {
    let last = frames.len().saturating_sub(1);
    let every = |stride: usize| -> Vec<&ViewFrame> {
        frames.iter().enumerate().filter(|(i, _)| (last - i).is_multiple_of(stride)).map(|(_, frame)| frame).collect()
    };
    let fits = |kept: &Vec<&ViewFrame>| kept.iter().map(|frame| frame.bytes.len()).sum::<usize>() <= MAX_BYTES;
    (1..=frames.len()).map(every).find(fits).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_thinned_evenly_until_they_fit_and_the_last_one_stays() {
        let frame = |i: usize, bytes: usize| ViewFrame {
            time: i as f64,
            parts: Value::Null,
            plane: 0.0,
            bytes: vec![0; bytes],
        };
        let kept = |bytes: usize| {
            let frames: Vec<ViewFrame> = (0..9).map(|i| frame(i, bytes)).collect();
            thinned(&frames).iter().map(|frame| frame.time).collect::<Vec<f64>>()
        };
        assert_eq!(kept(10).len(), 9);
        assert_eq!(kept(MAX_BYTES / 4), [2.0, 5.0, 8.0]);
        assert_eq!((kept(MAX_BYTES), kept(MAX_BYTES + 1)), (vec![8.0], vec![]));
    }

    #[test]
    fn ranges_are_finite_and_have_a_width() {
        for values in [&[][..], &[0.0, 0.0], &[f64::NAN, 3.0], &[-2.0, 5.0], &[1e300, -1e300]] {
            for scale in [FieldScale::FromZero, FieldScale::Linear, FieldScale::Logarithmic, FieldScale::Signed] {
                let range = value_range(values, scale);
                assert!(
                    range.low.is_finite() && range.high.is_finite() && range.low < range.high,
                    "{values:?} {scale:?}"
                );
            }
        }
        let signed = value_range(&[-2.0, 5.0], FieldScale::Signed);
        assert_eq!((signed.low, signed.high), (-5.0, 5.0));
    }
}
