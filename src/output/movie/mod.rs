//! Pictures of a film, drawn from the files of a finished run: the frames, and the poses of the bodies in the history.

mod grid;

use super::picture::{Camera, MeshPicture};
use super::report;
use crate::contact::DomeMotion;
use crate::math::{Vector, Vector3};
use crate::scene::Scene;
use crate::simulation::{BodyKinematics, BodyPose, FrameCells, MeshFrame};
use grid::GelGrid;
use std::collections::{BTreeMap, HashMap};
use std::io;
use std::path::{Path, PathBuf};

/// Width and height of a picture of the film, pixels: even numbers, as video formats need them.
const MOVIE_SIZE: [usize; 2] = [960, 800];

/// Error of drawing a film.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MovieError {
    /// A file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// A file has another content than gelfmu writes.
    #[error("{}: found {found}, expected {expected}", path.display())]
    Content {
        /// Path of the file.
        path: PathBuf,
        /// Content.
        found: &'static str,
        /// Remedy.
        expected: &'static str,
    },
}

/// Rows of `history.csv`: values by the name of the column.
struct HistoryTable {
    columns: HashMap<String, usize>,
    rows: Vec<Vec<f64>>,
}

/// Returns the frames of a run as PNG files in order of time, coloured by speed on one scale.
///
/// # Errors
/// [`MovieError`] if a file is missing or is not one of a run.
pub fn movie_pictures(folder: &Path, scene: &Scene) -> Result<Vec<Vec<u8>>, MovieError> {
    let history = HistoryTable::read(&folder.join("history.csv"))?;
    let mut camera: Option<Camera> = None;
    let mut pictures = vec![];
    for number in 0.. {
        let path = folder.join(format!("frames/frame_{number:05}.vtu"));
        if !path.is_file() {
            break;
        }
        let bytes = std::fs::read(&path).map_err(|source| MovieError::Read { path: path.clone(), source })?;
        let content = MovieError::Content {
            path,
            found: "no grid of a gel",
            expected: "a frame as gelfmu run writes it; run the scene again",
        };
        let frame = mesh_frame(grid::parse(&bytes).ok_or(content)?, scene, &history);
        let camera = camera.get_or_insert_with(|| Camera::of(&frame, scene));
        pictures.push(MeshPicture::take_sized(&frame, scene, camera, MOVIE_SIZE));
    }
    if pictures.is_empty() {
        return Err(MovieError::Content {
            path: folder.join("frames"),
            found: "no frames",
            expected: "those of a run with output.frames > 0",
        });
    }
    Ok(report::speed_pictures(&pictures))
}

impl HistoryTable {
    fn read(path: &Path) -> Result<Self, MovieError> {
        let text =
            std::fs::read_to_string(path).map_err(|source| MovieError::Read { path: path.to_path_buf(), source })?;
        let mut lines = text.lines();
        let names = lines.next().unwrap_or_default().split(',');
        let columns = names.enumerate().map(|(i, name)| (name.to_owned(), i)).collect();
        let cell = |cell: &str| cell.parse().unwrap_or(f64::NAN);
        Ok(Self { columns, rows: lines.map(|line| line.split(',').map(cell).collect()).collect() })
    }

    /// Returns the row nearest to a time, s.
    fn row(&self, time: f64) -> Option<&[f64]> {
        let distance = |row: &&Vec<f64>| (row.first().copied().unwrap_or(f64::INFINITY) - time).abs();
        self.rows.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).map(Vec::as_slice)
    }

    fn value(&self, row: &[f64], name: &str) -> f64 {
        self.columns.get(name).and_then(|column| row.get(*column)).copied().unwrap_or(0.0)
    }

    /// Returns the pose of the body whose columns begin with `prefix`.
    fn pose(&self, row: &[f64], prefix: &str) -> BodyPose {
        let value = |name: &str| self.value(row, &format!("{prefix}{name}"));
        let vector = |before: &str, after: &str| {
            Vector3::from(["x", "y", "z"].map(|axis| value(&format!("{before}_{axis}_{after}"))))
        };
        let size = [value("bulge_height_m"), value("bulge_radius_m")];
        let still = DomeMotion { size: size.into(), rate: Vector::<2>::zeros(), acceleration: Vector::<2>::zeros() };
        BodyPose {
            kinematics: BodyKinematics {
                position: vector("position", "m"),
                velocity: vector("velocity", "m_per_s"),
                orientation: ["w", "x", "y", "z"].map(|part| value(&format!("orientation_{part}"))),
                angular_velocity: vector("angular_velocity", "rad_per_s"),
            },
            bulge: (size[1] > 0.0).then_some(still),
            active: prefix.is_empty() || value("active") > 0.0,
        }
    }
}

/// Returns the frame of a grid with the bodies of the history.
fn mesh_frame(grid: GelGrid, scene: &Scene, history: &HistoryTable) -> MeshFrame {
    let row = history.row(grid.time).unwrap_or_default();
    let prefixes = (0..=scene.fragment.len()).map(|i| if i == 0 { String::new() } else { format!("fragment{i}_") });
    let nodes: Vec<[u32; 4]> = grid
        .nodes
        .chunks(grid.corners)
        .map(|corners| std::array::from_fn(|i| corners.get(i).copied().unwrap_or(0)))
        .collect();
    let n = nodes.len();
    MeshFrame {
        time: grid.time,
        dimension: grid.corners - 1,
        mass: 0.0,
        velocities: grid.velocities,
        displacements: vec![Vector3::zeros(); grid.points.len()],
        points: grid.points,
        cells: FrameCells {
            facets: boundary(&nodes, grid.corners),
            nodes,
            step: grid.steps,
            jacobian: vec![1.0; n],
            energy_density: vec![0.0; n],
            damage: vec![0.0; n],
        },
        fields: vec![],
        bodies: prefixes.map(|prefix| history.pose(row, &prefix)).collect(),
    }
}

/// Returns the faces of tetrahedra that belong to one element alone; none in two dimensions, where elements are drawn.
fn boundary(nodes: &[[u32; 4]], corners: usize) -> Vec<[u32; 3]> {
    let mut faces = BTreeMap::<[u32; 3], u8>::new();
    for &[a, b, c, d] in nodes.iter().filter(|_| corners == 4) {
        for mut face in [[a, b, c], [a, b, d], [a, c, d], [b, c, d]] {
            face.sort_unstable();
            *faces.entry(face).or_default() += 1;
        }
    }
    faces.into_iter().filter(|(_, count)| *count == 1).map(|(face, _)| face).collect()
}
