//! Whose files are whose: folders of results, input files, and what happens to them when a command fails.

use ballistic_gel::output::{FolderClaim, FolderRefusal, FolderState, OutputError, RUN, ResultFolder, TakeoverPolicy};
use ballistic_gel::scene;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use tempfile::TempDir;

const MANIFEST: &str = "gelfmu.jsonl";
/// A run that takes a moment.
const SMALL: [&str; 6] =
    ["--direct", "--set", "mesh.size=1e-2", "--set", "projectile.velocity=[0, 0, -1]", "--set=output.frames=4"];

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelfmu"));
    command.args(arguments).current_dir(folder).env_remove("NO_COLOR");
    command
}

fn gelfmu(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

fn small(folder: &Path, more: &[&str]) -> Output {
    gelfmu(folder, &[&["run", "ball-square"], SMALL.as_slice(), more].concat())
}

fn err(said: &Output) -> String {
    crate::lines::joined(&String::from_utf8_lossy(&said.stderr))
}

#[track_caller]
fn done(said: &Output) {
    assert_eq!(said.status.code(), Some(0), "{}", err(said));
}

/// The command ends with bad input and these words.
#[track_caller]
fn refused(said: &Output, words: &[&str]) {
    let text = err(said);
    assert_eq!(said.status.code(), Some(2), "{text}");
    for word in words {
        assert!(text.contains(word), "{word} in {text}");
    }
}

/// Every file below a folder, by its path from there.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = PathBuf::from(path.file_name().unwrap());
        if path.is_dir() {
            all.insert(name.join("(folder)"), vec![]);
            all.extend(contents(&path).into_iter().map(|(inner, bytes)| (name.join(inner), bytes)));
        } else {
            all.insert(name, fs::read(&path).unwrap());
        }
    }
    all
}

/// A folder of a user: a scene that names a file, and a note.
fn own_folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene::builtin("ball-square").unwrap().replace("size = 1.25e-3", "size = 1e-2");
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    fs::write(folder.path().join("summary.json"), "my own summary").unwrap();
    folder
}

fn lines(folder: &Path) -> Vec<Value> {
    let text = fs::read_to_string(folder.join(MANIFEST)).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn last_state(folder: &Path) -> String {
    let mut states = lines(folder).into_iter().filter_map(|line| line["state"].as_str().map(str::to_owned));
    states.next_back().unwrap()
}

#[test]
fn a_folder_that_gelfmu_has_not_made_is_refused_even_with_force() {
    let folder = own_folder();
    let before = contents(folder.path());
    let cases: [&[&str]; 3] = [
        &["run", "scene.toml", "--direct", "--out", ".", "--force"],
        &["run", "scene.toml", "--out", ".", "--force"],
        &["run", "ball-square", "--direct", "--fidelity", "coarse", "--set", "mesh.size=1e-2", "--out", ".", "--force"],
    ];
    for arguments in cases {
        let said = gelfmu(folder.path(), arguments);
        assert_eq!(said.status.code(), Some(2), "{arguments:?}: {}", err(&said));
        assert_eq!(contents(folder.path()), before, "{arguments:?}");
    }
    let said = gelfmu(folder.path(), cases[0]);
    refused(
        &said,
        &["--out .: found \"summary.json\" and no gelfmu.jsonl", "earlier release", "remove this one yourself"],
    );
    fs::remove_file(folder.path().join("summary.json")).unwrap();
    refused(
        &gelfmu(folder.path(), cases[0]),
        &["found a folder that is not empty and was not made by gelfmu", "\"scene.toml\""],
    );
}

#[test]
fn the_manifest_lists_every_file_and_how_the_run_ended() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    done(&small(folder.path(), &["--out", "out"]));
    let listed: Vec<PathBuf> = lines(&out).iter().filter_map(|line| line["file"].as_str().map(PathBuf::from)).collect();
    for (name, _) in contents(&out).iter().filter(|(name, _)| !name.ends_with("(folder)")) {
        assert!(name == Path::new(MANIFEST) || listed.contains(name), "{} is not listed", name.display());
    }
    let head = &lines(&out)[0];
    assert_eq!((&head["results_of"], &head["version"]), (&"run".into(), &env!("CARGO_PKG_VERSION").into()));
    assert_eq!(last_state(&out), "complete");
    let said = gelfmu(folder.path(), &["run", "ball-square", "--direct", "--no-frames", "--out", "stopped"]);
    assert_eq!(said.status.code(), Some(1), "the mesh fails: {}", err(&said));
    assert_eq!(last_state(&folder.path().join("stopped")), "failed");
}

#[test]
fn force_replaces_files_of_ours_alone() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    done(&small(folder.path(), &["--out", "out"]));
    fs::write(out.join("notes.txt"), "mine").unwrap();
    fs::write(out.join("frames/frame_mine.vtu"), "mine").unwrap();
    refused(&small(folder.path(), &["--out", "out"]), &["--force to replace them"]);
    done(&small(folder.path(), &["--out", "out", "--force", "--set=output.frames=2", "--no-report"]));
    let after = contents(&out);
    assert_eq!(after[Path::new("notes.txt")], b"mine");
    assert_eq!(after[Path::new("frames/frame_mine.vtu")], b"mine");
    assert!(!after.contains_key(Path::new("frames/frame_00003.vtu")), "a frame of the run before");
    assert!(!after.contains_key(Path::new("report.html")), "the report of the run before");
    assert!(after.contains_key(Path::new("summary.json")) && !out.join(".gelfmu-new").exists());
    assert_eq!(last_state(&out), "complete");
}

#[test]
fn a_foreign_file_with_the_name_of_a_result_refuses_the_run_before_it_starts() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    done(&small(folder.path(), &["--out", "out", "--set=output.frames=2"]));
    fs::write(out.join("frames/frame_00007.vtu"), "mine").unwrap();
    let before = contents(&out);
    let said = small(folder.path(), &["--out", "out", "--force", "--set=output.frames=9"]);
    refused(&said, &["frame_00007.vtu, which gelfmu has not made"]);
    assert_eq!(contents(&out), before);
}

#[test]
fn an_input_of_the_run_is_never_a_target() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    done(&small(folder.path(), &["--out", "out"]));
    fs::hard_link(out.join("scene.toml"), folder.path().join("link.toml")).unwrap();
    let before = contents(&out);
    for input in ["out/scene.toml", "./out/../out/scene.toml", "link.toml"] {
        let said = gelfmu(folder.path(), &["run", input, "--direct", "--out", "out", "--force"]);
        refused(&said, &["scene.toml, which is read, among the files that would be replaced"]);
        assert_eq!(contents(&out), before, "{input}");
    }
    let said = gelfmu(folder.path(), &["pack", "--scene", "link.toml", "--out", "out/scene.toml"]);
    refused(&said, &["--out out/scene.toml: found the file that is read"]);
    let said = gelfmu(folder.path(), &["pack", "--out", "out/history.csv"]);
    refused(&said, &["--out out/history.csv: found a file that is no FMU"]);
    assert_eq!(contents(&out), before);
}

#[test]
fn a_failed_start_leaves_everything_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    done(&small(folder.path(), &["--out", "out"]));
    let before = contents(folder.path());
    let too_fine = ["--set=mesh.size=1e-6"];
    for out in ["out", "new/and/deep"] {
        let said = small(folder.path(), &[&["--out", out, "--force"], too_fine.as_slice()].concat());
        assert_eq!(said.status.code(), Some(2), "{}", err(&said));
        assert_eq!(contents(folder.path()), before, "{out}");
        let mut through_fmu = command(folder.path(), &["run", "ball-square", "--out", out, "--force"]);
        let said = through_fmu.env("TMPDIR", "/nowhere/at/all").output().unwrap();
        assert_ne!(said.status.code(), Some(0), "no place to unpack the FMU, or no FMU in this build");
        assert_eq!(contents(folder.path()), before, "{out}");
    }
}

#[test]
fn two_runs_in_one_folder_are_one_run_and_one_refusal() {
    let folder = tempfile::tempdir().unwrap();
    for attempt in 0..4 {
        let out = format!("out{attempt}");
        let arguments = [&["run", "ball-square", "--quiet", "--out", &out], SMALL.as_slice()].concat();
        let start = || command(folder.path(), &arguments).stderr(Stdio::piped()).spawn().unwrap();
        let both = [start(), start()].map(|child: Child| child.wait_with_output().unwrap());
        let mut codes = both.each_ref().map(|said| said.status.code());
        codes.sort_unstable();
        assert_eq!(codes, [Some(0), Some(2)], "{} {}", err(&both[0]), err(&both[1]));
        assert_eq!(last_state(&folder.path().join(&out)), "complete");
    }
}

/// A claim as `gelfmu run` makes it.
fn claim(folder: &Path, policy: TakeoverPolicy) -> Result<ResultFolder, OutputError> {
    let needs = ["a".to_owned()];
    ResultFolder::claim(folder, &FolderClaim { command: RUN, policy, needs: &needs, inputs: &[], is_of_fmu: false })
}

#[track_caller]
fn refusal(claim: Result<ResultFolder, OutputError>) -> FolderRefusal {
    match claim.unwrap_err() {
        OutputError::Refused { refusal, .. } => refusal,
        other => panic!("{other}"),
    }
}

#[test]
fn a_folder_is_held_by_one_run_and_taken_over_after_a_killed_one() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut first = claim(&out, TakeoverPolicy::Refuse).unwrap();
    first.write("a", b"first").unwrap();
    first.begin().unwrap();
    assert_eq!(refusal(claim(&out, TakeoverPolicy::Replace)), FolderRefusal::Busy);
    first.mark(FolderState::Complete).unwrap();
    drop(first);
    assert_eq!(refusal(claim(&out, TakeoverPolicy::Refuse)), FolderRefusal::Occupied);
    // What a killed run leaves: a half-written line, and the hidden folder.
    let half = fs::read_to_string(out.join(MANIFEST)).unwrap() + "{\"file\":\"b";
    fs::write(out.join(MANIFEST), half).unwrap();
    fs::create_dir(out.join(".gelfmu-new")).unwrap();
    fs::write(out.join(".gelfmu-new/b"), "half").unwrap();
    let mut second = claim(&out, TakeoverPolicy::Replace).unwrap();
    second.write("c", b"second").unwrap();
    assert_eq!(fs::read(out.join("a")).unwrap(), b"first", "the results are there until there are new ones");
    second.begin().unwrap();
    drop(second);
    let names: Vec<PathBuf> = contents(&out).into_keys().collect();
    assert_eq!(names, [Path::new("c"), Path::new(MANIFEST)]);
    assert_eq!(last_state(&out), "failed", "it has not said how it ended");
}

#[test]
fn a_claim_is_handed_to_an_fmu_alone_and_once() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut held = claim(&out, TakeoverPolicy::Refuse).unwrap();
    held.hand_over().unwrap();
    assert_eq!(
        refusal(claim(&out, TakeoverPolicy::Replace)),
        FolderRefusal::Busy,
        "another run of the same process number"
    );
    let of_fmu =
        FolderClaim { command: RUN, policy: TakeoverPolicy::Replace, needs: &[], inputs: &[], is_of_fmu: true };
    let adopted = ResultFolder::claim(&out, &of_fmu).unwrap();
    assert_eq!(refusal(ResultFolder::claim(&out, &of_fmu)), FolderRefusal::Busy);
    drop((adopted, held));
    assert!(contents(folder.path()).is_empty());
}

#[test]
fn a_manifest_without_a_line_is_that_of_a_run_that_was_killed_at_its_start() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    fs::write(out.join(MANIFEST), "").unwrap();
    let mut next = claim(&out, TakeoverPolicy::Refuse).unwrap();
    next.write("a", b"next").unwrap();
    next.begin().unwrap();
    next.mark(FolderState::Complete).unwrap();
    drop(next);
    assert_eq!(refusal(claim(&out, TakeoverPolicy::Refuse)), FolderRefusal::Occupied);
    assert!(claim(&out, TakeoverPolicy::Replace).is_ok(), "it is ours");
}

#[test]
fn a_claim_that_comes_to_nothing_is_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("one/two");
    let mut first = claim(&out, TakeoverPolicy::Refuse).unwrap();
    first.write("inner/a", b"first").unwrap();
    drop(first);
    assert!(contents(folder.path()).is_empty());
    let mut first = claim(&out, TakeoverPolicy::Refuse).unwrap();
    first.write("a", b"first").unwrap();
    first.begin().unwrap();
    first.mark(FolderState::Complete).unwrap();
    drop(first);
    let before = contents(&out);
    let mut second = claim(&out, TakeoverPolicy::Replace).unwrap();
    second.write("a", b"second").unwrap();
    drop(second);
    assert_eq!(contents(&out), before);
}

#[cfg(unix)]
#[test]
fn links_in_a_folder_of_ours_are_not_followed() {
    let folder = tempfile::tempdir().unwrap();
    let (out, other) = (folder.path().join("out"), folder.path().join("other"));
    let mut first = claim(&out, TakeoverPolicy::Refuse).unwrap();
    first.write("frames/f", b"first").unwrap();
    first.begin().unwrap();
    drop(first);
    fs::rename(out.join("frames"), &other).unwrap();
    std::os::unix::fs::symlink(&other, out.join("frames")).unwrap();
    assert_eq!(refusal(claim(&out, TakeoverPolicy::Replace)), FolderRefusal::InTheWay { file: out.join("frames") });
    assert_eq!(fs::read(other.join("f")).unwrap(), b"first");
    fs::write(out.join(MANIFEST), "my own list\n").unwrap();
    assert_eq!(refusal(claim(&out, TakeoverPolicy::Replace)), FolderRefusal::Damaged { line: 1 });
}
