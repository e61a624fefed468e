//! Claims of `gelfmu run --measured`, `gelfmu report` and `gelfmu movie`: what they write, and what they refuse before they begin.

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// A quick run of the shot of `fbi-bb`.
const RUN: [&str; 7] =
    ["run", "fbi-bb", "--direct", "--json", "--set=mesh.size=2e-3", "--set=scene.end_time=1.5e-4", "--out=shot"];

fn gelfmu(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelfmu"));
    // Without a PATH there is no ffmpeg.
    command.args(arguments).current_dir(folder).env("PATH", folder).output().unwrap()
}

fn run_with(folder: &Path, more: &[&str]) -> Output {
    gelfmu(folder, &[RUN.as_slice(), more].concat())
}

fn err(said: &Output) -> String {
    crate::lines::joined(&String::from_utf8_lossy(&said.stderr))
}

#[test]
fn measured_curves_stand_in_summary_and_report() {
    let folder = tempfile::tempdir().unwrap();
    let table = "time_ms,depth_mm,velocity <b>,velocity_m_per_s\n0.05,8.0,1,160\n0.1,14.0,2,140\n5,80,3,0\n";
    fs::write(folder.path().join("lab.csv"), table).unwrap();
    let said = run_with(folder.path(), &["--measured=lab.csv"]);
    assert_eq!(said.status.code(), Some(0), "{}", err(&said));
    assert!(err(&said).contains("column velocity <b>: not matched, and not used"), "{}", err(&said));
    assert!(err(&said).contains("column depth_mm: depth (mm), 3 values"), "{}", err(&said));
    let printed: Value = serde_json::from_slice(&said.stdout).unwrap();
    let text = fs::read_to_string(folder.path().join("shot/summary.json")).unwrap();
    let written: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(printed, written);
    let curves = written["measured"]["curves"].as_array().unwrap();
    assert_eq!((curves.len(), &curves[0]["quantity"]), (2, &Value::from("depth")));
    let residual = &curves[1]["residual"];
    assert_eq!((residual["points"].as_u64(), residual["outside"].as_u64()), (Some(2), Some(1)));
    assert!(residual["rms"].as_f64().unwrap() <= residual["greatest"].as_f64().unwrap().abs());
    assert!(text.starts_with("{\n  \"format\": 2,\n  \"scene\": \"fbi-bb\""), "the order of the keys stays");
    let page = fs::read_to_string(folder.path().join("shot/report.html")).unwrap();
    assert!(page.contains("Compared with the laboratory") && page.contains("velocity &lt;b&gt;"));
    let mut reader = quick_xml::Reader::from_str(&page);
    while reader.read_event().unwrap() != quick_xml::events::Event::Eof {}
}

#[test]
fn an_unreadable_table_is_refused_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("bad.csv"), "time_s,velocity\n0,1\n1,fast\n").unwrap();
    fs::write(folder.path().join("huge.csv"), "time_s,force_kN\n0,1e308\n").unwrap();
    let refusals = [
        ("none.csv", "found no readable file"),
        ("bad.csv", "line 3: column `velocity`: found \"fast\", expected a number with a decimal point"),
        ("huge.csv", "line 2: column `force_kN`: found \"1e308\", expected a number that is finite in N"),
    ];
    for (file, words) in refusals {
        let said = run_with(folder.path(), &["--measured", file]);
        assert_eq!(said.status.code(), Some(2), "{}", err(&said));
        assert!(err(&said).contains(words) && err(&said).contains(file), "{}", err(&said));
        assert!(!folder.path().join("shot").exists(), "{file}");
    }
}

#[test]
fn a_film_is_a_gif_or_without_ffmpeg_left_as_pictures() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(run_with(folder.path(), &["--set=output.frames=3"]).status.code(), Some(0));
    assert_eq!(gelfmu(folder.path(), &["movie", "shot"]).status.code(), Some(0));
    let gif = fs::read(folder.path().join("shot.gif")).unwrap();
    assert!(gif.starts_with(b"GIF89a") && gif.ends_with(b"\x3b") && gif.len() > 10_000, "{} bytes", gif.len());
    let film = || gelfmu(folder.path(), &["movie", "shot", "--out", "shot.mp4"]);
    let said = film();
    assert_eq!(said.status.code(), Some(0), "{}", err(&said));
    assert!(err(&said).contains("ffmpeg is not installed"), "{}", err(&said));
    let pictures = fs::read_dir(folder.path().join("shot.frames")).unwrap().count();
    assert_eq!(pictures, 3);
    let picture = fs::read(folder.path().join("shot.frames/00002.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
    assert!(err(&film()).contains("expected a new name, or --force"), "an earlier film stays");
    let scene = folder.path().join("shot/scene.toml");
    let own = fs::read_to_string(&scene).unwrap();
    fs::write(&scene, own.replacen("title = \"", "title = \"Mine: ", 1)).unwrap();
    assert_eq!(gelfmu(folder.path(), &["movie", "shot", "--force"]).status.code(), Some(0), "another title");
    fs::write(&scene, own.replacen("-179.8]", "-150.0]", 1)).unwrap();
    for (command, code) in [(["movie", "shot", "--force"].as_slice(), 2), (&["report", "shot"], 1)] {
        let said = gelfmu(folder.path(), command);
        assert_eq!(said.status.code(), Some(code), "{}", err(&said));
        let words = "shot/scene.toml: found another scene (fbi-bb) than that of these results, expected the file as the run wrote";
        assert!(err(&said).contains(words), "{}", err(&said));
    }
    fs::write(&scene, own).unwrap();
    #[cfg(unix)]
    {
        let history = folder.path().join("shot/history.csv");
        fs::remove_file(&history).unwrap();
        assert!(Command::new("mkfifo").arg(&history).status().unwrap().success());
        for command in [["movie", "shot", "--force"].as_slice(), &["report", "shot"]] {
            let refused = err(&gelfmu(folder.path(), command));
            assert!(refused.contains("cannot read shot/history.csv: found a device or a pipe"), "{refused}");
        }
    }
    let said = gelfmu(folder.path(), &["movie", "nothing"]);
    assert_eq!(said.status.code(), Some(2));
    assert!(err(&said).contains("found no scene.toml in nothing, expected a folder written by gelfmu run"));
}

#[test]
fn a_report_is_made_of_the_files_of_a_run_and_with_a_laboratorys_curve_afterwards() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let run = ["run", "fbi-bb", "--fidelity", "draft", "--set=scene.end_time=1e-3", "--direct", "--quiet"];
    assert!(gelfmu(folder.path(), &[&run[..], &["--out", "shot", "--no-report"]].concat()).status.success());
    assert!(!place("shot/report.html").exists());
    assert!(gelfmu(folder.path(), &["report", "shot"]).status.success());
    let page = fs::read_to_string(place("shot/report.html")).unwrap();
    assert!(page.contains("id=\"view-data\"") && page.contains("Speed of the projectile by depth"));
    assert!(gelfmu(folder.path(), &[&run[..], &["--out", "whole"]].concat()).status.success());
    let plots = |page: &str| page.matches("<figure class=\"plot\">").count();
    assert_eq!(plots(&page), plots(&fs::read_to_string(place("whole/report.html")).unwrap()), "that of the run itself");

    fs::write(place("lab.csv"), "depth_mm,velocity_m_per_s\n0,180\n5,150\n").unwrap();
    for _ in 0..2 {
        assert!(gelfmu(folder.path(), &["report", "shot", "--measured", "lab.csv"]).status.success());
    }
    let page = fs::read_to_string(place("shot/report.html")).unwrap();
    assert_eq!(page.matches("Compared with the laboratory").count(), 1);
    let summary: Value =
        serde_json::from_slice(&fs::read(place("shot/summary.json")).unwrap()).expect("one key for the comparison");
    assert_eq!(summary["measured"]["curves"].as_array().map(Vec::len), Some(1));
    // A tool that sorts the keys leaves `measured` among the others.
    fs::write(place("shot/summary.json"), format!("{summary:#}")).unwrap();
    assert!(gelfmu(folder.path(), &["report", "shot", "--measured", "lab.csv"]).status.success());
    let again: Value = serde_json::from_slice(&fs::read(place("shot/summary.json")).unwrap()).unwrap();
    assert_eq!(again, summary);
    assert!(gelfmu(folder.path(), &["report", "shot"]).status.success());

    let of_format = |format: Value| {
        let mut other = summary.clone();
        (other["format"], other["version"]) = (format, "9.1.0".into());
        fs::write(place("shot/summary.json"), other.to_string()).unwrap();
        err(&gelfmu(folder.path(), &["report", "shot"]))
    };
    for (format, words) in [(1.into(), "found format 1, written by gelfmu 9.1.0"), (Value::Null, "found no format")] {
        let said = of_format(format);
        assert!(
            said.contains(words) && said.contains("format 2") && said.contains("gelfmu run FOLDER/scene.toml"),
            "{said}"
        );
    }

    let said = gelfmu(folder.path(), &["report", "nowhere"]);
    assert_eq!(said.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&said.stderr).contains("found no scene.toml in nowhere"));
    // A folder that is not of a run is left alone.
    fs::create_dir(place("mine")).unwrap();
    fs::write(place("mine/scene.toml"), fs::read(place("shot/scene.toml")).unwrap()).unwrap();
    assert_eq!(gelfmu(folder.path(), &["report", "mine"]).status.code(), Some(1));
    assert!(!place("mine/report.html").exists());
}

#[test]
fn a_report_shows_case_author_and_logo_where_they_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let page = || fs::read_to_string(place("shot/report.html")).unwrap();
    assert!(run_with(folder.path(), &["--set=output.frames=3"]).status.success());
    let bare = page();
    assert!(!bare.contains("<dt>Case</dt>") && !bare.contains("class=\"logo\"") && bare.contains("<dt>Date</dt>"));
    let script = "<svg xmlns=\"http://www.w3.org/2000/svg\"><script>alert(1)</script></svg>";
    fs::write(place("logo.svg"), script).unwrap();
    let options = ["--case", "17 & 4", "--author", "A. <N>", "--logo", "logo.svg"];
    assert!(gelfmu(folder.path(), &[&["report", "shot"][..], &options].concat()).status.success());
    let full = page();
    for part in ["<dt>Case</dt><dd>17 &amp; 4</dd>", "<dd>A. &lt;N&gt;</dd>", "case 17 \\000026  4 · A. "] {
        assert!(full.contains(part), "{part}");
    }
    assert!(full.contains("src=\"data:image/svg+xml;base64,") && !full.contains("alert(1)"), "an image runs no script");
    let mut reader = quick_xml::Reader::from_str(&full);
    while reader.read_event().unwrap() != quick_xml::events::Event::Eof {}

    fs::write(place("large.png"), [b"\x89PNG\r\n\x1a\n".as_slice(), &vec![0; 1 << 20]].concat()).unwrap();
    fs::write(place("page.html"), "<html></html>").unwrap();
    for (file, found) in [
        ("none.png", "no readable file"),
        ("shot", "a folder, a device or a pipe"),
        ("large.png", "a larger file"),
        ("page.html", "a text that is no SVG"),
    ] {
        for command in [&["report", "shot"][..], &["run", "fbi-bb", "--out=other"]] {
            let said = gelfmu(folder.path(), &[command, &["--logo", file]].concat());
            assert_eq!(said.status.code(), Some(2), "{}", err(&said));
            let words = format!("--logo {file}: found {found}");
            assert!(
                err(&said).contains(&words) && err(&said).contains("expected a PNG, JPEG or SVG"),
                "{}",
                err(&said)
            );
        }
        assert!(!place("other").exists(), "the logo is read before the run");
    }
    assert_eq!(page(), full, "a refused logo leaves the report");
}

#[test]
fn the_first_things_of_a_report_are_the_answer_the_wound_and_the_doubts() {
    let folder = tempfile::tempdir().unwrap();
    let run =
        ["run", "fbi-bb", "--fidelity", "draft", "--set=scene.end_time=1e-3", "--direct", "--quiet", "--out", "shot"];
    assert!(gelfmu(folder.path(), &run).status.success());
    let page = fs::read_to_string(folder.path().join("shot/report.html")).unwrap();
    let parts = [
        "<dl class=\"answer\">",
        "<dt>Not perforated, greatest depth</dt>",
        "<dt>Widest temporary cavity</dt>",
        "<dt>Most energy to the gel</dt>",
        "<figure class=\"wound\">",
        "<figure class=\"section\">",
        "How far to trust these figures",
        "not validated for",
        "gelfmu run scene.toml --out again",
        "Along the path of the projectile",
        "<th scope=\"row\">Mass</th><td>0.343 g</td><td class=\"si\">0.000343 kg</td><td>scene</td>",
    ];
    let places: Vec<usize> = parts.iter().map(|part| page.find(part).unwrap_or_else(|| panic!("{part}"))).collect();
    assert!(places.is_sorted(), "{places:?}");
}

#[test]
fn several_runs_are_compared_on_one_page_with_the_values_in_which_their_scenes_differ() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let run =
        ["run", "fbi-bb", "--fidelity", "draft", "--set=scene.end_time=5e-4", "--direct", "--quiet", "--no-frames"];
    for (out, more) in [("slow", "--set=projectile.velocity[3]=-150"), ("fast", "--set=projectile.velocity[3]=-200")] {
        assert!(gelfmu(folder.path(), &[&run[..], &[more, "--out", out]].concat()).status.success());
    }
    let both = ["report", "slow", "fast"];
    for (more, words) in [
        (&[][..], "found 2 folders, expected one, or --out FILE.html"),
        (&["--out", "all.html", "--measured", "lab.csv"], "found --measured with 2 folders, expected one folder"),
        (&["nowhere", "--out", "all.html"], "found no scene.toml in nowhere"),
    ] {
        let said = gelfmu(folder.path(), &[&both[..], more].concat());
        assert_eq!(said.status.code(), Some(2), "{}", err(&said));
        assert!(err(&said).contains(words) && !place("all.html").exists(), "{}", err(&said));
    }
    let all = [&both[..], &["--out", "all.html", "--case", "9"]].concat();
    assert!(gelfmu(folder.path(), &all).status.success());
    let page = fs::read_to_string(place("all.html")).unwrap();
    let mut reader = quick_xml::Reader::from_str(&page);
    while reader.read_event().unwrap() != quick_xml::events::Event::Eof {}
    let row = "<th scope=\"row\">projectile.velocity</th><td><code>[0.0,0.0,-150.0]</code></td><td><code>[0.0,0.0,-200.0]</code></td>";
    for part in ["<h1>2 runs compared</h1>", "<dd>9</dd>", row, "further values are the same", "not validated for"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("<th scope=\"row\">gel.density"), "only what differs");
    assert!(page.matches("<figure class=\"plot\">").count() >= 4);
    let again = gelfmu(folder.path(), &all);
    assert!(err(&again).contains("--out all.html: found something of this name"), "{}", err(&again));
    assert!(gelfmu(folder.path(), &[&all[..], &["--force"]].concat()).status.success());
}
