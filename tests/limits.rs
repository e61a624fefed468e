//! What the command does with files without end, output that cannot be written, and text that a terminal obeys.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

#[path = "command/lines.rs"]
mod lines;

use ballistic_gel::scene;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelfmu"));
    command.args(arguments).current_dir(folder);
    command
}

fn gelfmu(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

fn err(said: &Output) -> String {
    lines::joined(&String::from_utf8_lossy(&said.stderr))
}

#[track_caller]
fn refused(said: &Output, words: &[&str]) {
    let text = err(said);
    assert_eq!(said.status.code(), Some(2), "{text}");
    assert!(words.iter().all(|word| text.contains(word)), "{words:?} in {text}");
}

/// A coarse scene that is run in a moment.
fn coarse() -> String {
    scene::builtin("ball-square").unwrap().replace("size = 1.25e-3", "size = 1e-2")
}

#[cfg(target_os = "linux")]
#[test]
fn results_that_cannot_be_printed_are_an_error_and_a_closed_pipe_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for arguments in [["scenes"].as_slice(), &["schema"], &["scenes", "fbi-bb", "--json"], &["--help"], &["--version"]]
    {
        let said = command(folder.path(), arguments).stdout(full()).output().unwrap();
        assert_eq!(said.status.code(), Some(1), "{arguments:?}: {}", err(&said));
        assert!(err(&said).contains("cannot write to standard output: No space left"), "{}", err(&said));
        let mut child =
            command(folder.path(), arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let said = child.wait_with_output().unwrap();
        assert_eq!((said.status.code(), err(&said).as_str()), (Some(0), ""), "{arguments:?}");
    }
}

#[cfg(unix)]
#[test]
fn files_without_end_are_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    assert!(Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
    fs::write(at("lines.toml"), vec![b'\n'; 100_000_000]).unwrap();
    fs::write(at("loads.toml"), "[[load]]\n".repeat(1_000_000)).unwrap();
    let begun = Instant::now();
    for (scene, words) in [
        ("/dev/zero", "found a device or a pipe, expected a regular file"),
        ("pipe", "found a device or a pipe, expected a regular file"),
        ("lines.toml", "found 100000000 bytes, expected at most 1048576"),
        ("loads.toml", "found 9000000 bytes, expected at most 1048576"),
    ] {
        refused(&gelfmu(folder.path(), &["check", scene]), &[scene, words]);
    }
    for (file, words) in
        [("/dev/zero", "a device or a pipe"), ("pipe", "a device or a pipe"), ("huge.stl", "137438953472 bytes")]
    {
        fs::File::create(at("huge.stl")).unwrap().set_len(1 << 37).unwrap();
        let set = format!("projectile.shape={{stl={{file=\"{file}\", scale=1e-3}}}}");
        refused(&gelfmu(folder.path(), &["check", "sphere-block", "--set", &set]), &[file, words]);
        let said = gelfmu(folder.path(), &["run", "sphere-block", "--measured", file, "--quiet"]);
        refused(&said, &[&format!("--measured {file}"), words]);
    }
    assert!(!at("gelfmu-out").exists(), "refused before anything is computed");
    assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
}

/// The longest text that is read is read in a moment, whatever is in it.
#[test]
fn the_longest_scene_is_refused_in_a_moment() {
    let most = scene::MOST_BYTES;
    for line in ["\n", "[[load]]\n", "[[fragment]]\n", "[a.b.c]\n", "a = 1\n", "[[load]]\npressure = 1\n", "#\n", "["] {
        let begun = Instant::now();
        let text = line.repeat(most / line.len());
        assert!(scene::read(&text).is_err(), "{line:?}");
        assert!(begun.elapsed() < Duration::from_secs(5), "{line:?}: {:?}", begun.elapsed());
    }
    let error = scene::read(&"\n".repeat(most + 1)).unwrap_err().to_string();
    assert!(
        error.starts_with("found 1048577 bytes, expected the text of a scene, of at most 1048576 bytes"),
        "{error}"
    );
}

#[test]
fn no_text_of_a_file_reaches_the_terminal_as_a_command() {
    let folder = tempfile::tempdir().unwrap();
    let evil = "\\u001b]0;owned\\u0007\\u009b2J";
    let title = coarse().replacen("[scene]", &format!("[scene]\ntitle = \"{evil}\""), 1);
    let is_wanted = |line: &&str| !line.starts_with("title = \"") || line.contains("owned");
    let title = title.lines().filter(is_wanted).collect::<Vec<_>>().join("\n");
    let key = format!("{}\n[\"{evil}\"]\n", coarse());
    let raw = format!("{}\nx = \u{1b}[2J\n", coarse());
    let word = format!("{}\n[contact]\nlaw = \"{evil}\"\n", coarse().split("\n[contact]").next().unwrap());
    for (name, text) in [("title", title), ("key", key), ("raw", raw), ("word", word)] {
        fs::write(folder.path().join(name), text).unwrap();
        for arguments in [["check", name].as_slice(), &["check", name, "--json"], &["run", name, "--direct"]] {
            let said = gelfmu(folder.path(), arguments);
            assert_eq!(said.status.code(), Some(2), "{name}: {}", err(&said));
            let all = err(&said) + &String::from_utf8_lossy(&said.stdout);
            assert!(!all.contains(|c: char| c.is_control() && c != '\n'), "{name}: {all:?}");
        }
    }
    refused(
        &gelfmu(folder.path(), &["check", "title"]),
        &["scene.title", "one line of text without control characters"],
    );
}

/// A limit of the size of files has a signal that ends a process; here it is an error of the write, in words.
#[cfg(target_os = "linux")]
#[test]
fn a_limit_of_file_sizes_is_an_error_in_words() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.toml"), coarse()).unwrap();
    let script = "ulimit -f 16; exec \"$0\" \"$@\"";
    let mut command = Command::new("bash");
    command.args(["-c", script, env!("CARGO_BIN_EXE_gelfmu")]).current_dir(folder.path());
    let many = ["--set", "scene.communication_step=1e-6", "--no-frames"];
    let said = command.args(["run", "a.toml", "--direct", "--out", "out"]).args(many).output().unwrap();
    assert_eq!(said.status.code(), Some(1), "{} {}", said.status, err(&said));
    assert!(err(&said).contains("cannot write out/history.csv: File too large"), "{}", err(&said));
    assert!(fs::read_to_string(folder.path().join("out/gelfmu.jsonl")).unwrap().ends_with("{\"state\":\"failed\"}\n"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_nothing_of_a_new_scene() {
    let folder = tempfile::tempdir().unwrap();
    let new = ["new", "--projectile", "bb", "--out", "bb.toml"];
    let mut limited = Command::new("bash");
    limited.args(["-c", "ulimit -f 1; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_gelfmu")]).args(new);
    let said = limited.current_dir(folder.path()).output().unwrap();
    assert_eq!(said.status.code(), Some(1), "{}", err(&said));
    assert!(err(&said).contains("cannot write bb.toml: File too large"), "{}", err(&said));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    assert_eq!(gelfmu(folder.path(), &new).status.code(), Some(0), "the repeat");
    refused(&gelfmu(folder.path(), &new), &["--out bb.toml: found a file of this name, which is not replaced"]);
}

#[test]
fn a_misspelt_name_is_answered_with_the_one_that_is_near() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, words) in [
        (["check", "sphere-blok"].as_slice(), "(did you mean `sphere-block`?), expected one of fbi-bb"),
        (&["check", "spere-blok"], "(did you mean `sphere-block`?)"),
        (&["scenes", "l-baem"], "found no built-in scene of this name (did you mean `l-beam`?)"),
        (
            &["check", "l-beam", "--set", "mesh.siez=1"],
            "found the unknown key `siez` (did you mean `size`?), expected one of",
        ),
        (&["check", "l-beam", "--set", "gell.density=1"], "found the unknown key `gell` (did you mean `gel`?)"),
        (&["check", "fbi-bb", "--set", "gel.preset=gelatine-10"], "(did you mean `gelatin-10`?)"),
        (&["check", "l-beam", "--set", "contact.law=moreu"], "(did you mean `moreau`?)"),
    ] {
        refused(&gelfmu(folder.path(), arguments), &[words]);
    }
    assert!(!err(&gelfmu(folder.path(), &["check", "l-beam", "--set", "mesh.speed=1"])).contains("did you mean"));
}

#[test]
fn frames_and_report_can_be_left_out_and_the_figures_stay() {
    let folder = tempfile::tempdir().unwrap();
    let run = |out: &str, more: &[&str]| {
        let all = ["run", "fbi-bb", "--direct", "--quiet", "--json", "--out", out];
        let quick = ["--set=mesh.size=2e-3", "--set=scene.end_time=1.5e-4"];
        let said = gelfmu(folder.path(), &[all.as_slice(), &quick, more].concat());
        assert_eq!(said.status.code(), Some(0), "{}", err(&said));
        let figures: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
        figures
    };
    let has = |out: &str, file: &str| folder.path().join(out).join(file).exists();
    let all = run("all", &[]);
    assert!(has("all", "frames") && has("all", "series.pvd") && has("all", "report.html"));
    let bare = run("bare", &["--no-frames", "--no-report"]);
    assert!(!has("bare", "frames") && !has("bare", "series.pvd") && !has("bare", "report.html"));
    for (key, value) in all.as_object().unwrap() {
        let clock = ["wall_seconds", "cpu_seconds", "serial_seconds", "parallel_seconds", "updates_per_second"];
        let timed = clock.contains(&key.as_str());
        assert!(timed || bare[key] == *value, "{key}: {value} with frames, {} without", bare[key]);
    }
    assert!(all["greatest_cavity_diameter"].is_number(), "a shot, whose cavity is looked at without frames, too");
    run("page", &["--no-frames"]);
    let page = fs::read_to_string(folder.path().join("page/report.html")).unwrap();
    assert!(!page.contains("data:image/png") && page.contains("<svg "));
}
