//! Writes the inputs that fuzzing begins with into `corpus/`: after a change of the layout of a state those before are of no use.

#[path = "../../tests/fmi2/host.rs"]
#[allow(dead_code, clippy::wildcard_imports, reason = "the tests of the interface use more of it")]
mod host;
mod small;

use ballistic_gel::scene;
use std::fs;
use std::path::{Path, PathBuf};

/// Corners of a tetrahedron, m, and its outward faces.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.01]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]];

fn main() -> std::io::Result<()> {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    let folder = |name: &str| -> std::io::Result<PathBuf> {
        let folder = corpus.join(name);
        fs::create_dir_all(&folder)?;
        Ok(folder)
    };
    let scenes = folder("scene")?;
    for (name, text) in scene::builtins() {
        fs::write(scenes.join(name.to_owned() + ".toml"), without_comments(text))?;
    }
    fs::write(scenes.join("small.toml"), small::TEXT)?;
    fs::write(scenes.join("stl.toml"), include_str!("stl.toml"))?;
    fs::write(scenes.join("expansion.toml"), include_str!("../../tests/physics/expansion.toml"))?;
    let stl = folder("stl")?;
    fs::write(stl.join("tetrahedron.stl"), binary())?;
    fs::write(stl.join("tetrahedron-ascii.stl"), ascii())?;
    let (states, snapshots) = (folder("state")?, folder("snapshot")?);
    for (name, time) in [("early", 1e-6), ("late", 1e-4)] {
        let mut bytes = vec![];
        small::stepped(time).save().write(&mut |run| bytes.extend_from_slice(run));
        fs::write(states.join(name), bytes)?;
    }
    let mut host = host::Host::with(small::TEXT);
    host.start();
    let bytes = host.bytes();
    fs::write(snapshots.join("start"), &bytes[36..bytes.len() - 4])
}

/// The lines of a scene that say something.
fn without_comments(text: &str) -> String {
    let lines = text.lines().map(|line| line.split(" #").next().unwrap_or(line));
    let told = lines.filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
    told.map(|line| line.to_owned() + "\n").collect()
}

fn binary() -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((FACES.len() as u32).to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        bytes.extend(face.iter().flat_map(|corner| CORNERS[*corner]).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

fn ascii() -> String {
    let vertex = |corner: &usize| {
        let [x, y, z] = CORNERS[*corner];
        format!("vertex {x} {y} {z}\n")
    };
    let facet = |face: &[usize; 3]| {
        let corners: String = face.iter().map(vertex).collect();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    let facets: String = FACES.iter().map(facet).collect();
    format!("solid tetrahedron\n{facets}endsolid tetrahedron\n")
}
