//! Slices of the block with estimated cracks, as a laboratory lays them out: equal rays whose lengths add up to the
//! total crack length.

use crate::output::penetration::CrackSlice;
use crate::output::saved_run::SavedShot;
use crate::scene::{Dimension, GelShape, Scene};
use std::f64::consts::TAU;
use std::fmt::Write;

/// Number of rays in a slice.
const RAYS: usize = 6;
/// Limit of the number of drawn slices; of more every second, third … is drawn.
const MAX_SLICES: usize = 40;
/// Columns of the drawing, width of a column, side of a slice and height of a row, in units of the drawing.
const COLUMNS: usize = 8;
const COLUMN: f64 = 120.0;
const SIDE: f64 = 108.0;
const ROW: f64 = 156.0;
/// Least part of the half side that the longest ray spans. In a wider block only the middle is drawn.
const MIN_REACH: f64 = 0.3;
/// Margin around the longest ray, as a factor.
const MARGIN: f64 = 1.08;

/// Section of the gel across the shot line, m, seen from that line: half widths and centre.
#[derive(Debug, Clone, Copy, PartialEq)]
enum SliceOutline {
    /// Rectangular slice of a block.
    Rectangle { half: [f64; 2], centre: [f64; 2] },
    /// Round slice of a cylinder.
    Circle { radius: f64, centre: [f64; 2] },
}

impl SliceOutline {
    /// Returns the outline of a block or a cylinder; `None` for other shapes and for a plane scene, which has no
    /// second side.
    fn of(scene: &Scene) -> Option<Self> {
        let [x, y, _] = scene.projectile.position;
        let centre = [-x, -y];
        match &scene.gel.shape {
            GelShape::Block { size } if scene.scene.dimension == Dimension::Spatial => {
                Some(Self::Rectangle { half: [0.5 * size[0], 0.5 * size[1]], centre })
            }
            GelShape::Cylinder { radius, .. } if scene.scene.dimension != Dimension::Planar => {
                Some(Self::Circle { radius: *radius, centre })
            }
            _ => None,
        }
    }

    /// Returns the half side of the square about the shot line that holds the outline, m.
    fn reach(&self) -> f64 {
        let (half, centre) = match self {
            Self::Rectangle { half, centre } => (*half, centre),
            Self::Circle { radius, centre } => ([*radius; 2], centre),
        };
        (half[0] + centre[0].abs()).max(half[1] + centre[1].abs())
    }

    /// Returns the SVG element around the shot line at (`x`, `y`) with `scale` units per metre.
    fn svg(&self, [x, y]: [f64; 2], scale: f64) -> String {
        match self {
            Self::Rectangle { half, centre } => format!(
                "<rect class=\"gel\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
                x + scale * (centre[0] - half[0]),
                y - scale * (centre[1] + half[1]),
                2.0 * scale * half[0],
                2.0 * scale * half[1]
            ),
            Self::Circle { radius, centre } => format!(
                "<circle class=\"gel\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"{:.1}\"/>",
                x + scale * centre[0],
                y - scale * centre[1],
                scale * radius
            ),
        }
    }
}

/// Slices and scale of the drawing.
struct SliceDrawing<'a> {
    slices: Vec<&'a CrackSlice>,
    /// Outline of the gel; `None` where a square about the shot line is cut out.
    outline: Option<SliceOutline>,
    /// Half side of the drawn square, m.
    half_side: f64,
}

/// Returns the figure of the slices; empty without a crack.
pub(super) fn figure(scene: &Scene, shot: &SavedShot) -> String {
    let Some(last) = shot.cracks.iter().rposition(|slice| slice.crack_length > 0.0) else { return String::new() };
    let stride = (last + 1).div_ceil(MAX_SLICES);
    let slices: Vec<&CrackSlice> = shot.cracks[..=last].iter().step_by(stride).collect();
    let longest = slices.iter().map(|slice| ray_end(slice)).fold(0.0, f64::max);
    let outline = SliceOutline::of(scene).filter(|outline| longest >= MIN_REACH * outline.reach());
    let half_side = outline.map_or(longest / MIN_REACH.sqrt(), |outline| outline.reach().max(MARGIN * longest));
    if !(half_side.is_finite() && half_side > 0.0) {
        return String::new();
    }
    let drawing = SliceDrawing { slices, outline, half_side };
    format!(
        "<figure class=\"slices\"><figcaption>Slices of 1 cm with estimated cracks</figcaption>\n{}<p>{}</p></figure>\n",
        drawing.svg(),
        drawing.note(stride)
    )
}

impl SliceDrawing<'_> {
    fn svg(&self) -> String {
        let columns = self.slices.len().min(COLUMNS);
        let height = ROW * self.slices.len().div_ceil(COLUMNS) as f64;
        let mut text = format!(
            "<svg viewBox=\"0 0 {:.0} {height:.0}\" style=\"max-width: {:.1}%\" role=\"img\" aria-label=\"Estimated total crack \
             length of each slice of the gel\" xmlns=\"http://www.w3.org/2000/svg\">\n",
            COLUMN * columns as f64,
            100.0 * columns as f64 / COLUMNS as f64
        );
        for (i, slice) in self.slices.iter().enumerate() {
            text += &self.cell(slice, [(i % COLUMNS) as f64 * COLUMN, (i / COLUMNS) as f64 * ROW]);
        }
        text + "</svg>\n"
    }

    /// Returns a slice with its label, in the cell whose upper left corner is given.
    fn cell(&self, slice: &CrackSlice, [left, top]: [f64; 2]) -> String {
        let (x, y) = (left + 0.5 * COLUMN, top + 0.5 * SIDE + 4.0);
        let scale = 0.5 * SIDE / self.half_side;
        let cut = SliceOutline::Rectangle { half: [self.half_side; 2], centre: [0.0; 2] };
        let mut text = self.outline.unwrap_or(cut).svg([x, y], scale);
        let [hole, end] = [0.5 * slice.tear_diameter, ray_end(slice)].map(|radius| scale * radius);
        if end > hole {
            let ray = |i: usize| {
                let (sin, cos) = (TAU * (i as f64 / RAYS as f64 + 0.25)).sin_cos();
                let [from, to] = [hole, end].map(|radius| format!("{:.1},{:.1}", x + radius * cos, y - radius * sin));
                format!("M{from}L{to}")
            };
            write!(text, "<path class=\"crack\" d=\"{}\"/>", (0..RAYS).map(ray).collect::<String>())
                .expect("a string grows");
        }
        let length = match 1e3 * slice.crack_length {
            length if length >= 9.95 => format!("{length:.0} mm"),
            length if length.is_finite() => format!("{length:.1} mm"),
            _ => "–".to_owned(),
        };
        let (depth, value) = (y + 0.5 * SIDE + 15.0, y + 0.5 * SIDE + 31.0);
        text + &format!(
            "<circle class=\"hole\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{hole:.1}\"/>\
             <text x=\"{x:.0}\" y=\"{depth:.0}\">{}–{} cm</text><text class=\"length\" x=\"{x:.0}\" y=\"{value:.0}\">{length}</text>\n",
            centimetres(slice.depth_from),
            centimetres(slice.depth_to)
        )
    }

    /// Returns the explanation below the figure.
    fn note(&self, stride: usize) -> String {
        let drawn = match stride {
            1 => String::new(),
            _ => format!(" Of each {stride} slices the first is drawn."),
        };
        let unknown = if self.slices.iter().any(|slice| slice.crack_length.is_nan()) {
            " A slice with – lies in the crater of the entry, down to a depth d, or had no cavity."
        } else {
            ""
        };
        let cut = match self.outline {
            Some(_) => String::new(),
            None => format!(" Each square shows {:.0} mm around the line of flight.", 2e3 * self.half_side),
        };
        format!(
            "An estimate: the simulation models no crack. The total crack length of a slice, below its depth, is π (D − d), with \
             the widest diameter D of the temporary cavity in it and the width d of the projectile across its line of flight, the \
             hole in the middle. The factor of 1 and d are assumed and compared with no measured cracks. Number and directions \
             of the rays are those of the drawing: {RAYS} equal rays have the length together.{unknown}{cut}{drawn}"
        )
    }
}

/// Returns the distance of the end of a ray from the shot line, m; the edge of the hole without cracks.
fn ray_end(slice: &CrackSlice) -> f64 {
    0.5 * slice.tear_diameter + slice.crack_length.max(0.0) / RAYS as f64
}

/// Formats a depth, m, in centimetres.
fn centimetres(depth: f64) -> String {
    format!("{:.1}", 100.0 * depth).trim_end_matches(".0").to_owned()
}
