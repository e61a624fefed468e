//! Unstructured grids of VTK: an XML head and the arrays as raw little-endian bytes behind it.

use super::body::Solid;
use crate::math::Vector3;
use crate::simulation::Frame;
use std::fmt::Write;

/// Cell types of VTK.
const TRIANGLE: u8 = 5;
const TETRAHEDRON: u8 = 10;

/// A file of the gel: velocity and displacement of the nodes; step, level, J and energy density of the elements.
pub(super) fn gel(frame: &Frame) -> Vec<u8> {
    let corners = frame.dimension + 1;
    let cells = frame.cells.nodes.iter().map(|nodes| &nodes[..corners]);
    let kind = if corners == 4 { TETRAHEDRON } else { TRIANGLE };
    let mut file = Grid::new(frame.points.len(), frame.cells.nodes.len());
    file.section("FieldData", &[Array::time(frame.time)]);
    file.geometry(&frame.points, cells, kind);
    file.section(
        "PointData",
        &[Array::vectors("velocity", &frame.velocities), Array::vectors("displacement", &frame.displacements)],
    );
    file.section(
        "CellData",
        &[
            Array::scalars("step", &frame.cells.step),
            Array::bytes("step_level", step_levels(&frame.cells.step)),
            Array::scalars("jacobian", &frame.cells.jacobian),
            Array::scalars("energy_density", &frame.cells.energy_density),
        ],
    );
    file.finish()
}

/// A file of the surfaces of the bodies.
pub(super) fn bodies(solids: &[Solid], time: f64) -> Vec<u8> {
    let (mut points, mut triangles, mut velocities) = (vec![], vec![], vec![]);
    for solid in solids {
        let first = points.len() as u32;
        triangles.extend(solid.triangles.iter().map(|corners| corners.map(|i| first + i)));
        points.extend_from_slice(&solid.points);
        velocities.resize(points.len(), solid.velocity);
    }
    let mut file = Grid::new(points.len(), triangles.len());
    file.section("FieldData", &[Array::time(time)]);
    file.geometry(&points, triangles.iter().map(<[u32; 3]>::as_slice), TRIANGLE);
    file.section("PointData", &[Array::vectors("velocity", &velocities)]);
    file.finish()
}

/// How many halvings each step is below the largest one.
fn step_levels(steps: &[f64]) -> Vec<u8> {
    let largest = steps.iter().copied().fold(0.0, f64::max);
    steps.iter().map(|step| (largest / step).log2().round().clamp(0.0, 255.0) as u8).collect()
}

/// An array of a file: its attributes and bytes.
struct Array {
    attributes: String,
    bytes: Vec<u8>,
}

impl Array {
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

/// A file in the making.
struct Grid {
    sizes: String,
    field: String,
    piece: String,
    appended: Vec<u8>,
}

impl Grid {
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
        self.section("Points", &[Array::points(points)]);
        self.section(
            "Cells",
            &[
                Array::integers("connectivity", cells.flatten().copied()),
                Array::integers("offsets", ends),
                Array::bytes("types", kinds),
            ],
        );
    }

    /// Appends arrays, each behind its length in bytes; an array is found by its offset from the first of them.
    fn section(&mut self, name: &str, arrays: &[Array]) {
        let mut text = format!("<{name}>\n");
        for Array { attributes, bytes } in arrays {
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
