//! Printed texts for people: order of the figures, lines of 80 columns, suggestions, help and units.

use serde_json::Value;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

use crate::lines::joined;
use ballistic_gel::scene;

/// A run that takes a moment.
const SMALL: [&str; 7] =
    ["run", "ball-square", "--direct", "--set", "mesh.size=1e-2", "--set", "projectile.velocity=[0, 0, -1]"];

/// Exit status and texts of one call of the command.
struct Said {
    status: Option<i32>,
    out: String,
    err: String,
}

fn gelfmu_in(folder: &Path, arguments: &[&str]) -> Said {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelfmu"));
    let output = command.args(arguments).current_dir(folder).env_remove("NO_COLOR").env_remove("GELFMU_UNITS").output();
    let output = output.expect("the command starts");
    let text = |bytes| String::from_utf8(bytes).expect("the command prints UTF-8");
    Said { status: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
}

fn gelfmu(arguments: &[&str]) -> Said {
    gelfmu_in(folder().path(), arguments)
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder can be made")
}

/// Every line is at most 80 columns wide.
#[track_caller]
pub fn assert_narrow(text: &str) {
    for line in text.lines() {
        let columns = line.chars().count();
        assert!(columns <= 80, "{columns} columns: {line}");
    }
}

#[test]
fn a_run_for_people_ends_with_its_figures_and_the_files() {
    let folder = folder();
    let said = gelfmu_in(folder.path(), &[&SMALL[..], &["--out", "here"]].concat());
    assert_eq!(said.status, Some(0), "{}", said.err);
    assert!(joined(&said.err).contains("(by the library, into here)"), "{}", said.err);
    for text in ["reached at 2.000 ms", "greatest depth", "digest", "\nhere\n  report.html ", "  series.pvd "] {
        assert!(said.out.contains(text), "{text} in {}", said.out);
    }
    let place = |name: &str| said.out.find(name).unwrap_or_else(|| panic!("{name} in {}", said.out));
    assert!(
        place("│ greatest depth") < place("│ peak force") && place("│ peak force") < place("│ mesh"),
        "{}",
        said.out
    );
    assert_narrow(&said.out);
    assert_narrow(&said.err);
    let quiet = gelfmu_in(folder.path(), &[&SMALL[..], &["--out", "there", "--quiet"]].concat());
    assert_eq!((quiet.status, quiet.out.as_str(), quiet.err.as_str()), (Some(0), "", ""));
}

#[test]
fn scenes_lists_every_builtin_scene_with_its_title() {
    let said = gelfmu(&["scenes"]);
    assert_eq!(said.status, Some(0));
    assert_narrow(&said.out);
    for (name, text) in scene::builtins() {
        let title = scene::read(text).unwrap().scene.title;
        let start = title.split(' ').take(5).collect::<Vec<_>>().join(" ");
        assert!(said.out.lines().any(|line| line.contains(name) && line.contains(&start)), "{name}: {}", said.out);
    }
    let rows: Value = serde_json::from_str(&gelfmu(&["scenes", "--json"]).out).unwrap();
    assert_eq!(rows.as_array().map(Vec::len), Some(scene::builtins().count()));
    assert_eq!(rows[0]["dimension"], "axisymmetric");
}

#[test]
fn nothing_printed_to_a_pipe_is_wider_than_eighty_columns() {
    let folder = folder();
    let calls: [&[&str]; 8] = [
        &["projectiles"],
        &["new", "--projectile", "9mm-fmj", "--block", "10x10x10cm", "--out", "my.toml"],
        &["check", "my.toml"],
        &["scenes", "nothing"],
        &["projectiles", "nothing"],
        &["run", "nothing"],
        &["run", "--set", "mesch.size=1"],
        &["report", "nothing"],
    ];
    for arguments in calls {
        let said = gelfmu_in(folder.path(), arguments);
        assert_narrow(&said.out);
        assert_narrow(&said.err);
    }
    // A program that asks for JSON gets each message as one line.
    let said = gelfmu(&["scenes", "nothing", "--json"]);
    assert!(said.err.lines().count() == 1 && said.err.len() > 80, "{}", said.err);
}

#[test]
fn help_has_eighty_columns_where_there_is_no_terminal() {
    let listed = gelfmu(&["--help"]).out;
    let commands = listed.split("Commands:\n").nth(1).unwrap_or_default().lines();
    let names = commands.take_while(|line| !line.is_empty()).filter(|line| !line.starts_with("   "));
    let names: Vec<&str> = names.filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.len() > 10, "{listed}");
    assert_narrow(&listed);
    for name in names {
        assert_narrow(&gelfmu(&["help", name]).out);
    }
}

#[test]
fn a_part_of_a_name_is_answered_with_the_names_that_have_it() {
    let hint = |arguments: &[&str]| {
        let said = gelfmu(arguments);
        assert_eq!(said.status, Some(2), "{}", said.err);
        joined(&said.err)
    };
    let nine = "(did you mean `9mm-fmj`, `9mm-115-jhp`, `9mm-fmj-115gr`?";
    assert!(hint(&["new", "--projectile", "9mm"]).contains(&format!("{nine}), expected one of bb")));
    assert!(hint(&["projectiles", "9mm"]).contains(nine));
    let run = hint(&["run", "9mm"]);
    let command = "`gelfmu new --projectile 9mm-fmj --out shot.toml` writes the scene of a shot with this projectile)";
    assert!(run.contains(nine) && run.contains(command), "{run}");
    let hollow_points = "(did you mean `45acp-230-xtp`, `45acp-200-xtp`, ";
    assert!(hint(&["new", "--projectile", "45acp-jhp"]).contains(hollow_points));
    assert!(hint(&["run", "45acp-jhp"]).contains(hollow_points));
    assert!(hint(&["check", "fbi-bb", "--set", "projectile.library=45acp-jhp"]).contains(hollow_points));
    assert!(hint(&["scenes", "graded"]).contains("`sphere-graded-4`, `sphere-graded-8`, `sphere-graded-16`?"));
}

#[test]
fn two_levels_of_a_scene_have_folders_of_their_own() {
    let folder = folder();
    let short = ["--direct", "--quiet", "--no-frames", "--no-report", "--set", "scene.end_time=1e-4"];
    let run = |scene: &str, more: &[&str]| {
        let said = gelfmu_in(folder.path(), &[&["run", scene], &short[..], more].concat());
        assert_eq!(said.status, Some(0), "{}", said.err);
    };
    run("sphere-block", &["--fidelity", "draft"]);
    run("sphere-block", &["--set", "scene.fidelity=coarse"]);
    let own = "gelfmu-out/sphere-block-draft/scene.toml";
    let text = std::fs::read_to_string(folder.path().join(own)).unwrap();
    assert!(text.contains("fidelity = \"draft\""), "{text}");
    run(own, &[]);
    let mut names: Vec<_> =
        std::fs::read_dir(folder.path().join("gelfmu-out")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["sphere-block", "sphere-block-coarse", "sphere-block-draft"], "no suffix for the own level");
}

#[test]
fn global_options_have_a_heading_of_their_own_in_every_help() {
    for command in ["run", "new", "pack", "report", "schema"] {
        for help in ["-h", "--help"] {
            let text = gelfmu(&[command, help]).out;
            let (own, global) = text.split_once("\nGlobal options:\n").unwrap_or_else(|| panic!("{text}"));
            for option in ["--json", "--quiet", "--color", "--colour", "--help"] {
                assert!(global.contains(option) && !own.contains(option), "{command}: {option}: {text}");
            }
        }
    }
    let run = gelfmu(&["run", "-h"]).out;
    for heading in ["\nAccuracy:\n", "\nResults:\n", "\nComputation:\n"] {
        assert!(run.contains(heading), "{run}");
    }
    assert!(gelfmu(&["check", "l-beam", "--colour", "always"]).out.contains('\u{1b}'));
}

#[test]
fn a_manual_page_of_each_command_is_written() {
    let folder = folder();
    let said = gelfmu_in(folder.path(), &["man", "--out", "man/man1"]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    for page in ["gelfmu.1", "gelfmu-run.1", "gelfmu-new.1"] {
        assert!(folder.path().join("man/man1").join(page).is_file(), "{page}");
    }
    assert!(said.out.ends_with("    man -l man/man1/gelfmu.1\n"), "{}", said.out);
}

#[test]
fn units_of_the_united_states_are_those_of_every_printed_figure() {
    let folder = folder();
    let us = |arguments: &[&str]| {
        let said = gelfmu_in(folder.path(), &[arguments, &["--units", "us"]].concat());
        assert_eq!(said.status, Some(0), "{}", said.err);
        assert_narrow(&said.out);
        joined(&said.out)
    };
    let listed = us(&["projectiles"]);
    let bullet = listed.lines().find(|line| line.contains("9mm-fmj ")).unwrap();
    assert!(bullet.contains("124.0 gr  1150 ft/s"), "{bullet}");
    let new = us(&["new", "--projectile", "9mm-fmj", "--out", "my.toml"]);
    assert!(new.contains("124.0 gr at 1150.0 ft/s with 2° of yaw, into 5.9 x 5.9 x 15.7 in."), "{new}");
    let checked = us(&["check", "fbi-bb"]);
    assert!(checked.contains("projectile: 0.1720 in wide, 5.3 gr at 589.9 ft/s, 4.089 ft·lbf"), "{checked}");
    let arguments = [&SMALL[..], &["--out", "here", "--units", "us"]].concat();
    let run = gelfmu_in(folder.path(), &arguments);
    assert!(run.out.contains(" in at ") && run.out.contains(" ft/s") && run.out.contains(" lbf"), "{}", run.out);
    assert!(!run.out.contains(" mm at ") && !run.out.contains(" m/s"), "{}", run.out);
    // Files and JSON keep SI.
    let json = gelfmu_in(folder.path(), &[&SMALL[..], &["--out", "there", "--json"]].concat()).out;
    let figures = |text: &str| {
        let value: Value = serde_json::from_str(text).unwrap();
        (value["peak_depth"].clone(), value["final_velocity"].clone(), value["digest"].clone())
    };
    let written = std::fs::read_to_string(folder.path().join("here/summary.json")).unwrap();
    assert_eq!(figures(&written), figures(&json));
}

#[test]
fn the_environment_gives_the_units_and_the_option_counts_more() {
    let listed = |units: &str, arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gelfmu"));
        let output = command.arg("projectiles").args(arguments).env("GELFMU_UNITS", units).output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    assert!(listed("us", &[]).1.contains(" ft/s") && listed("si", &[]).1.contains(" m/s"));
    assert!(!listed("us", &["--units", "si"]).1.contains("ft/s"));
    assert_eq!(listed("cubits", &[]).0, Some(2));
}
