//! Report of a folder of results, made from its files alone.

use ballistic_gel::output::{ReportIdentity, SCENE, report_page};
use ballistic_gel::scene::Scene;
use std::path::Path;

/// Returns the page of a run; its scene is not checked, as a test may have one that no run accepts.
pub fn page_of(folder: &Path) -> String {
    let text = std::fs::read_to_string(folder.join(SCENE)).expect("a scene in every folder");
    let scene: Scene = toml::from_str(&text).expect("the scene that was written");
    report_page(folder, &scene, &ReportIdentity::default()).expect("the files of a run")
}
