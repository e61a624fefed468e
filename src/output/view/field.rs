//! Fields of a frame that the view of the report can show as colours.

use crate::scene::{OutputField, Scene};
use crate::simulation::MeshFrame;

/// Scale of the colours of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FieldScale {
    /// Linear, from zero.
    FromZero,
    /// Linear, from the least to the greatest value.
    Linear,
    /// Logarithmic, over the three decades below the greatest value.
    Logarithmic,
    /// Linear and symmetric about zero.
    Signed,
}

impl FieldScale {
    /// Returns the name of the scale in the data of the page.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::FromZero => "from-zero",
            Self::Linear => "linear",
            Self::Logarithmic => "logarithmic",
            Self::Signed => "signed",
        }
    }
}

/// Values of a field on a frame.
pub(super) enum FieldValues<'a> {
    /// One value per node.
    Nodes(Vec<f64>),
    /// One value per element.
    Cells(&'a [f64]),
}

/// Field with its name, unit and scale.
pub(super) struct ViewField {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) scale: FieldScale,
    values: ViewValues,
}

/// Source of the values of a field.
#[derive(Clone, Copy)]
enum ViewValues {
    /// Function of every frame.
    Frame(fn(&MeshFrame) -> FieldValues<'_>),
    /// Field that the scene asks for, by its place in the frame.
    Asked(usize),
}

/// Returns the fields of the view, in the order of its list: those of every frame, then those that the scene asks for.
pub(super) fn fields(scene: &Scene) -> Vec<ViewField> {
    let asked = scene.output.fields.iter().enumerate().map(|(i, field)| {
        let scale = match field {
            OutputField::Pressure => FieldScale::Signed,
            OutputField::VonMises | OutputField::StrainRate => FieldScale::Logarithmic,
            OutputField::ViscousStrain | OutputField::Damage | OutputField::Layer => FieldScale::FromZero,
        };
        let unit = if field.unit() == "-" { "" } else { field.unit() };
        ViewField { name: field.title(), unit, scale, values: ViewValues::Asked(i) }
    });
    let always = OF_EVERY_FRAME.iter().map(|&(name, unit, scale, values)| ViewField {
        name,
        unit,
        scale,
        values: ViewValues::Frame(values),
    });
    let is_new = |field: &ViewField| OF_EVERY_FRAME.iter().all(|(name, ..)| *name != field.name);
    always.chain(asked.filter(is_new)).collect()
}

/// Name, unit, scale and values of a field of every frame.
type FrameEntry = (&'static str, &'static str, FieldScale, fn(&MeshFrame) -> FieldValues<'_>);

/// Fields of every frame.
const OF_EVERY_FRAME: [FrameEntry; 6] = [
    ("Speed", "m/s", FieldScale::Logarithmic, |f| norms(&f.velocities)),
    ("Displacement", "m", FieldScale::FromZero, |f| norms(&f.displacements)),
    ("Stored energy density", "J/m³", FieldScale::Logarithmic, |f| cells(&f.cells.energy_density)),
    ("Volume ratio J", "", FieldScale::Linear, |f| cells(&f.cells.jacobian)),
    ("Damage", "", FieldScale::FromZero, |f| cells(&f.cells.damage)),
    ("Time step", "s", FieldScale::Logarithmic, |f| cells(&f.cells.step)),
];

fn norms(vectors: &[crate::math::Vector3]) -> FieldValues<'_> {
    FieldValues::Nodes(vectors.iter().map(nalgebra::Matrix::norm).collect())
}

fn cells(values: &[f64]) -> FieldValues<'_> {
    FieldValues::Cells(values)
}

impl ViewField {
    /// Returns the value of the field at each node; the value of a node is the mean over the elements around it.
    pub(super) fn nodal(&self, frame: &MeshFrame) -> Vec<f64> {
        let mut values = match self.values {
            ViewValues::Asked(i) => frame.fields.get(i).map_or_else(Vec::new, |field| field.points.clone()),
            ViewValues::Frame(values) => match values(frame) {
                FieldValues::Nodes(values) => values,
                FieldValues::Cells(values) => nodal_means(frame, values),
            },
        };
        values.resize(frame.points.len(), f64::NAN);
        values
    }
}

/// Returns the mean of the element values around each node.
fn nodal_means(frame: &MeshFrame, values: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; frame.points.len()];
    let mut counts = vec![0.0; frame.points.len()];
    for (nodes, value) in frame.cells.nodes.iter().zip(values) {
        for node in &nodes[..=frame.dimension] {
            sums[*node as usize] += value;
            counts[*node as usize] += 1.0;
        }
    }
    sums.iter().zip(counts).map(|(sum, count)| sum / count).collect()
}
