//! Pictures of a film, drawn from the files of a finished run.

use super::picture::{Camera, MeshPicture, OpaquePicture};
use super::report;
use super::saved_run::{SavedRun, SavedRunError};
use crate::scene::Scene;
use std::path::Path;

/// Width and height of a picture of the film, pixels: even numbers, as video formats need them.
const MOVIE_SIZE: [usize; 2] = [960, 800];

/// Returns the frames of a run as pictures in order of time, coloured by speed on one scale.
///
/// # Errors
/// [`SavedRunError`] if a file is missing or is not one of a run.
pub fn movie_pictures(folder: &Path, scene: &Scene) -> Result<Vec<OpaquePicture>, SavedRunError> {
    let run = SavedRun::open(folder, scene)?;
    let mut camera: Option<Camera> = None;
    let picture = |frame| {
        let frame = frame?;
        let camera = camera.get_or_insert_with(|| Camera::of(&frame, scene));
        Ok(MeshPicture::take_sized(&frame, scene, camera, MOVIE_SIZE))
    };
    let pictures = run.frames(0..run.n_frames())?.map(picture).collect::<Result<Vec<MeshPicture>, SavedRunError>>()?;
    if pictures.is_empty() {
        return Err(SavedRunError::Content {
            path: folder.join("frames"),
            found: "no frames".to_owned(),
            expected: "those of a run with output.frames > 0",
        });
    }
    Ok(report::speed_pictures(&pictures))
}
