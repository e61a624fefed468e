//! Files that a scene names.

use super::stl;
use super::{BodyShape, ProjectileSpec, Scene, SceneError, StlContent, StlSpec, body_name};
use crate::geometry::{SurfaceError, TriangleSurface, TriangulatedBody};
use std::io;
use std::sync::Arc;

/// Function that returns the bytes of a file by its name in the scene, or an error.
pub type FileSource<'a> = dyn Fn(&str) -> io::Result<Vec<u8>> + 'a;

/// File function for scenes that name no files.
///
/// # Errors
/// Always.
pub fn no_files(_name: &str) -> io::Result<Vec<u8>> {
    Err(io::Error::new(io::ErrorKind::Unsupported, "this scene is read without the folder that it is in"))
}

impl Scene {
    /// Names of the files that the scene needs, with their keys.
    #[must_use]
    pub fn files(&self) -> Vec<(String, &str)> {
        let named = |(i, body)| stl_of(body).map(|stl| (body_name(i) + FILE, stl.file.as_str()));
        self.bodies().enumerate().filter_map(named).collect()
    }
}

const FILE: &str = ".shape.stl.file";
const SCALE: &str = ".shape.stl.scale";

fn stl_of(body: &ProjectileSpec) -> Option<&StlSpec> {
    match &body.shape {
        BodyShape::Stl(stl) => Some(stl),
        BodyShape::Sphere { .. }
        | BodyShape::Cylinder { .. }
        | BodyShape::Capsule { .. }
        | BodyShape::Bullet(_)
        | BodyShape::Mushroom(_)
        | BodyShape::Plate { .. }
        | BodyShape::Chisel(_)
        | BodyShape::HalfSpace { .. }
        | BodyShape::Dome { .. } => None,
    }
}

/// Reads the files that a scene names, builds the solids that are made of triangles, and sets the paths of expansions.
pub(super) fn attach_files(scene: &mut Scene, files: &FileSource<'_>) -> Result<(), SceneError> {
    for (i, body) in scene.bodies_mut().enumerate() {
        if let (Some(expansion), BodyShape::Bullet(bullet)) = (&mut body.expansion, &body.shape) {
            expansion.set_path(bullet.radius);
        }
        match &mut body.shape {
            BodyShape::Stl(stl) => {
                let named = |e: SceneError| SceneError { key: body_name(i) + &e.key, ..e };
                stl.content = Some(read_stl(stl, files).map_err(named)?);
            }
            // Lengths that make no solid are refused with their keys, later.
            BodyShape::Chisel(chisel) => chisel.build(),
            _ => {}
        }
    }
    Ok(())
}

/// Reads and checks an STL file; the keys of errors are relative to the table of the body.
fn read_stl(stl: &StlSpec, files: &FileSource<'_>) -> Result<StlContent, SceneError> {
    const PATH: &str = "the path of an STL file, relative to the folder of the scene";
    const LENGTH: &str = "a length from 1e-9 to 1e9, m per unit of the file, such as 1e-3";
    if !(1e-9..=1e9).contains(&stl.scale) {
        return Err(SceneError::value(SCALE, format!("{:?}", stl.scale), LENGTH));
    }
    let bytes = files(&stl.file).map_err(|e| SceneError::value(FILE, format!("{:?}: {e}", stl.file), PATH))?;
    let named = |found: &str| format!("{:?} with {found}", stl.file);
    let corners = stl::triangles(&bytes).map_err(|e| SceneError::value(FILE, named(&e.found), e.expected))?;
    let solid = TriangleSurface::new(&corners).and_then(|surface| TriangulatedBody::new(surface, stl.scale));
    let solid = solid.map_err(|e| SceneError::value(FILE, named(&e.to_string()), remedy(&e)))?;
    Ok(StlContent { digest: xxhash_rust::xxh3::xxh3_128(&bytes), solid: Arc::new(solid) })
}

/// Expected property of the surface and a remedy. Coordinates are in the units of the file.
fn remedy(error: &SurfaceError) -> String {
    match error {
        SurfaceError::TooFew { .. } => "a closed surface: four triangles or more".to_owned(),
        SurfaceError::TooMany { .. } => {
            format!("at most {}: thin the surface out, the mesh of the gel is coarser", TriangleSurface::MOST_TRIANGLES)
        }
        SurfaceError::NotFinite { .. } => "finite coordinates: export the file again".to_owned(),
        SurfaceError::Open { .. } => {
            "a closed surface, every edge shared by two triangles: close the holes and join double corners".to_owned()
        }
        SurfaceError::Branched { .. } => {
            "every edge shared by two triangles: take away inner walls, or join the bodies".to_owned()
        }
        SurfaceError::Disoriented { .. } => {
            "triangles that all face outwards, their corners counter-clockwise: make the normals consistent".to_owned()
        }
        SurfaceError::Flat { .. } => "a body that encloses a volume".to_owned(),
        SurfaceError::Crossing { .. } => {
            "a surface that does not pass through itself: unite overlapping bodies".to_owned()
        }
        SurfaceError::Overlapping { .. } => {
            "one surface around the whole, no wall inside: unite the parts, or turn what is to be a cavity".to_owned()
        }
        SurfaceError::InsideOut { .. } => "parts that all face outwards: turn that one".to_owned(),
    }
}
