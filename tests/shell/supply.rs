//! The crates that the command brings along, and the steps that every change must pass.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Lines of `cargo tree`, in its `format`, one for each crate along the `edges` of dependency.
fn crates(edges: &str, format: &str) -> BTreeSet<String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let arguments = ["tree", "--offline", "--locked", "--prefix", "none", "--edges", edges, "--format", format];
    let output = Command::new(cargo).args(arguments).current_dir(root()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "cargo tree: {said}");
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect()
}

#[test]
fn the_command_builds_no_codec_that_it_does_not_use() {
    let built: BTreeSet<String> =
        crates("normal,build", "{p}").iter().filter_map(|line| line.split(' ').next()).map(str::to_owned).collect();
    assert!(built.contains("zip") && built.contains("flate2"), "{built:?}");
    for codec in ["aes", "bzip2", "deflate64", "hmac", "lzma-rust2", "pbkdf2", "ppmd-rust", "sha1", "zstd", "zstd-sys"]
    {
        assert!(!built.contains(codec), "{codec} is built for the command, which deflates and no more");
    }
}

#[test]
fn tests_ask_no_crate_of_the_command_for_features_with_which_it_would_be_compiled_again() {
    let format = "{p} features: {f}";
    let (command, all) = (crates("no-dev", format), crates("all", format));
    let changed: Vec<_> = command.difference(&all).collect();
    assert!(command.len() > 50 && changed.is_empty(), "list what the tests add to these in Cargo.toml: {changed:#?}");
}

/// A folder with a cargo that fails at `clippy`, and a cargo-deny that is content, as the script keeps it.
#[cfg(unix)]
fn fakes() -> tempfile::TempDir {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let script = std::fs::read_to_string(root().join(".ci/run")).unwrap();
    let version = script.lines().find_map(|line| line.strip_prefix("DENY_VERSION=")).unwrap();
    let deny = folder.path().join(format!("cargo-deny-{version}/bin/cargo-deny"));
    std::fs::create_dir_all(deny.parent().unwrap()).unwrap();
    for (file, text) in [(folder.path().join("cargo"), "[ \"$1\" != clippy ]"), (deny, "echo \"deny: $*\"")] {
        std::fs::write(&file, format!("#!/bin/sh\n{text}\n")).unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o755)).unwrap();
    }
    folder
}

#[cfg(unix)]
#[test]
fn a_failed_step_of_a_change_fails_the_whole_after_all_have_run() {
    let fakes = fakes();
    let path = format!("{}:{}", fakes.path().display(), std::env::var("PATH").unwrap());
    let run = |skip: &str| {
        let mut script = Command::new(root().join(".ci/run"));
        // These steps fetch their tools, which no fake cargo stands in for.
        let skip = format!("page site platforms wheel python notebooks bundled bits importers {skip}");
        script.env("PATH", &path).env("BALLISTIC_GEL_TOOLS", fakes.path()).env("SKIP", skip);
        let output = script.output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    let (status, said) = run("docs");
    assert_eq!(status, Some(1), "{said}");
    for line in
        ["tests: passed, ", "format: passed, ", "clippy: failed with status 1, ", "docs: skipped, ", "deny: passed, "]
    {
        assert!(said.lines().any(|own| own.starts_with(line)), "{line}: {said}");
    }
    assert!(said.contains("deny: check bans licenses sources"), "{said}");
    assert_eq!(run("clippy studies partners").0, Some(0));
}
