//! VTK unstructured grids (`.vtu`): an XML header, then the arrays as raw little-endian bytes.

use super::body::BodySurface;
use crate::math::Vector3;
use crate::simulation::MeshFrame;
use std::fmt::Write;

/// VTK cell types.
const TRIANGLE: u8 = 5;
const TETRAHEDRON: u8 = 10;

/// Returns a file of the gel: velocity and displacement of the nodes; step, level, J and energy density of the
/// elements.
pub(super) fn gel_file(frame: &MeshFrame) -> Vec<u8> {
    let corners = frame.dimension + 1;
    let cells = frame.cells.nodes.iter().map(|nodes| &nodes[..corners]);
    let kind = if corners == 4 { TETRAHEDRON } else { TRIANGLE };
    let mut file = VtuBuilder::new(frame.points.len(), frame.cells.nodes.len());
    file.section("FieldData", &[DataArray::time(frame.time)]);
    file.geometry(&frame.points, cells, kind);
    file.section(
        "PointData",
        &[DataArray::vectors("velocity", &frame.velocities), DataArray::vectors("displacement", &frame.displacements)],
    );
    file.section(
        "CellData",
        &[
            DataArray::scalars("step", &frame.cells.step),
            DataArray::bytes("step_level", step_levels(&frame.cells.step)),
            DataArray::scalars("jacobian", &frame.cells.jacobian),
            DataArray::scalars("energy_density", &frame.cells.energy_density),
        ],
    );
    file.finish()
}

/// Returns a file of the body surfaces.
pub(super) fn bodies_file(surfaces: &[BodySurface], time: f64) -> Vec<u8> {
    let (mut points, mut triangles, mut velocities) = (vec![], vec![], vec![]);
    for surface in surfaces {
        let first = points.len() as u32;
        triangles.extend(surface.triangles.iter().map(|corners| corners.map(|i| first + i)));
        points.extend_from_slice(&surface.points);
        velocities.resize(points.len(), surface.velocity);
    }
    let mut file = VtuBuilder::new(points.len(), triangles.len());
    file.section("FieldData", &[DataArray::time(time)]);
    file.geometry(&points, triangles.iter().map(<[u32; 3]>::as_slice), TRIANGLE);
    file.section("PointData", &[DataArray::vectors("velocity", &velocities)]);
    file.finish()
}

/// Returns the number of halvings from the largest step to each step.
fn step_levels(steps: &[f64]) -> Vec<u8> {
    let largest = steps.iter().copied().fold(0.0, f64::max);
    steps.iter().map(|step| (largest / step).log2().round().clamp(0.0, 255.0) as u8).collect()
}

/// Data array of a file: attributes and bytes.
struct DataArray {
    attributes: String,
    bytes: Vec<u8>,
}

impl DataArray {
    fn time(time: f64) -> Self {
        let attributes = "type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\"".to_string();
        Self { attributes, bytes: time.to_le_bytes().to_vec() }
    }

    fn points(points: &[Vector3]) -> Self {
        let attributes = "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"".to_string();
        Self { attributes, bytes: points.iter().flat_map(|p| p.iter()).flat_map(|x| x.to_le_bytes()).collect() }
    }

    fn vectors(name: &str, values: &[Vector3]) -> Self {
        let attributes = format!("type=\"Float32\" Name=\"{name}\" NumberOfComponents=\"3\"");
        Self {
            attributes,
            bytes: values.iter().flat_map(|v| v.iter()).flat_map(|x| (*x as f32).to_le_bytes()).collect(),
        }
    }

    fn scalars(name: &str, values: &[f64]) -> Self {
        let attributes = format!("type=\"Float32\" Name=\"{name}\"");
        Self { attributes, bytes: values.iter().flat_map(|x| (*x as f32).to_le_bytes()).collect() }
    }

    fn integers(name: &str, values: impl Iterator<Item = u32>) -> Self {
        let attributes = format!("type=\"Int32\" Name=\"{name}\"");
        Self { attributes, bytes: values.flat_map(u32::to_le_bytes).collect() }
    }

    fn bytes(name: &str, bytes: Vec<u8>) -> Self {
        Self { attributes: format!("type=\"UInt8\" Name=\"{name}\""), bytes }
    }
}

/// Builder of a `.vtu` file.
struct VtuBuilder {
    sizes: String,
    field: String,
    piece: String,
    appended: Vec<u8>,
}

impl VtuBuilder {
    fn new(points: usize, cells: usize) -> Self {
        let sizes = format!("NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\"");
        Self { sizes, field: String::new(), piece: String::new(), appended: Vec::new() }
    }

    fn geometry<'a>(&mut self, points: &[Vector3], cells: impl Iterator<Item = &'a [u32]> + Clone, kind: u8) {
        let ends = cells.clone().scan(0, |end, cell| {
            *end += cell.len() as u32;
            Some(*end)
        });
        let kinds = vec![kind; cells.clone().count()];
        self.section("Points", &[DataArray::points(points)]);
        self.section(
            "Cells",
            &[
                DataArray::integers("connectivity", cells.flatten().copied()),
                DataArray::integers("offsets", ends),
                DataArray::bytes("types", kinds),
            ],
        );
    }

    /// Appends a section of arrays, each array preceded by its length in bytes. An array is addressed by its offset
    /// from the first array.
    fn section(&mut self, name: &str, arrays: &[DataArray]) {
        let mut text = format!("<{name}>\n");
        for DataArray { attributes, bytes } in arrays {
            let offset = self.appended.len();
            writeln!(text, "<DataArray {attributes} format=\"appended\" offset=\"{offset}\"/>")
                .expect("a string grows");
            self.appended.extend((bytes.len() as u64).to_le_bytes());
            self.appended.extend(bytes);
        }
        writeln!(text, "</{name}>").expect("a string grows");
        if name == "FieldData" { self.field += &text } else { self.piece += &text }
    }

    fn finish(self) -> Vec<u8> {
        let Self { sizes, field, piece, appended } = self;
        let head = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n<UnstructuredGrid>\n{field}<Piece {sizes}>\n{piece}</Piece>\n</UnstructuredGrid>\n\
             <AppendedData encoding=\"raw\">\n_"
        );
        [head.as_bytes(), &appended, b"\n</AppendedData>\n</VTKFile>\n"].concat()
    }
}
