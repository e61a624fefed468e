//! Disks that are full, folders that cannot be written, and a run that is killed.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

const COARSE: [&str; 6] = ["run", "ball-square", "--direct", "--quiet", "--set", "mesh.size=5e-3"];
/// Rows and frames enough to stop in the middle of them.
const MANY: [&str; 4] = ["--set", "scene.communication_step=1e-6", "--set", "output.frames=2000"];

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn gelfmu(more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gelfmu")).args(COARSE).args(more).output().unwrap()
}

/// Every row of the history but for a last one that was cut off has all columns; their number.
fn whole_rows(folder: &Path) -> usize {
    let history = std::fs::read_to_string(folder.join("history.csv")).unwrap();
    let whole = history.rsplit_once('\n').map_or("", |(whole, _)| whole);
    let rows: Vec<&str> = whole.lines().filter(|line| !line.starts_with('#')).collect();
    let columns = rows[0].split(',').count();
    assert!(rows.iter().all(|row| row.split(',').count() == columns), "{history}");
    rows.len() - 1
}

#[test]
fn a_folder_that_cannot_be_written_is_named_before_anything_is_computed() {
    for folder in ["/proc/gel", "/dev/null/gel", "/dev/full"] {
        let Output { status, stderr, .. } = gelfmu(&["--out", folder]);
        let said = text(&stderr);
        assert!(!status.success() && said.contains(folder), "{status}: {said}");
        assert!(!said.contains("panicked"), "{said}");
    }
}

/// A file that may not grow is what a full disk looks like to who writes it.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_ends_the_run_in_words_and_leaves_what_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let script = "trap '' XFSZ; ulimit -f 128; exec \"$0\" \"$@\"";
    let mut command = Command::new("bash");
    command.args(["-c", script, env!("CARGO_BIN_EXE_gelfmu")]).args(COARSE);
    command.args([
        "--set",
        "scene.communication_step=1e-6",
        "--set",
        "output.frames=2",
        "--out",
        out.to_str().unwrap(),
    ]);
    let Output { status, stderr, .. } = command.output().unwrap();
    let said = text(&stderr);
    assert!(!status.success() && said.contains("cannot write") && said.contains("space left"), "{status}: {said}");
    assert!(whole_rows(&out) > 10);
}

#[test]
#[cfg(target_os = "linux")]
fn a_run_that_is_killed_leaves_whole_rows_and_frames() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelfmu"));
    command.args(COARSE).args(MANY).args(["--out", out.to_str().unwrap()]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let frames = out.join("frames");
    while std::fs::read_dir(&frames).map_or(0, Iterator::count) < 20 {
        assert!(child.try_wait().unwrap().is_none(), "the run ended before it was killed");
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(whole_rows(&out) > 5);
    let series = std::fs::read_to_string(out.join("series.pvd")).unwrap();
    assert!(series.trim_end().ends_with("</VTKFile>"), "{series}");
    let named: Vec<&str> = series.split("file=\"").skip(1).filter_map(|part| part.split('"').next()).collect();
    assert!(named.len() > 5, "{series}");
    for file in named {
        let bytes = std::fs::read(out.join(file)).unwrap();
        assert!(bytes.trim_ascii_end().ends_with(b"</VTKFile>"), "{file} is cut off");
    }
}
