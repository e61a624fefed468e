//! Remeshing in pictures, step by step (figure 6 of the paper), with figures.

mod drawing;
mod figures;
mod page;
mod panels;

use super::files::OutputError;
use super::folder::ResultFolder;
use crate::scene::Scene;
use crate::simulation::RemeshPreview;
pub use figures::RemeshFigures;

/// Writes the pictures of a remeshing, and `index.html` with pictures and figures in order.
///
/// # Errors
/// [`OutputError`] if a file cannot be written.
pub fn draw(folder: &mut ResultFolder, scene: &Scene, preview: &RemeshPreview) -> Result<RemeshFigures, OutputError> {
    let panels = panels::panels(preview, scene);
    for (panel, number) in panels.iter().zip(1..) {
        for (view, picture) in [("whole", &panel.whole), ("close", &panel.close)] {
            folder.write(&page::picture_file(number, panel.text.name, view), picture)?;
        }
    }
    let figures = RemeshFigures::of(preview);
    folder.write("index.html", page::page(scene, &panels, &figures).as_bytes())?;
    Ok(figures)
}
