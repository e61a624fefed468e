//! Licences of every crate that ends up in the library, for the archive's `documentation/licenses/`.

use crate::library::literal;
use serde_json::Value;
use std::collections::BTreeMap;
use std::env;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Writes the list of linked crates and the Rust source that names every licence file: (path in the archive, bytes).
/// `messages` is what cargo said when it built the library.
pub fn collect(messages: Option<&str>, out: &Path) -> Result<(), String> {
    let mut source = String::from(
        "/// Licences: path below `documentation/licenses/`, and bytes.\npub static LICENSES: &[(&str, &[u8])] = &[\n",
    );
    if let Some(messages) = messages {
        let mut packages = linked(messages)?;
        packages.push(standard_library()?);
        let table = out.join("linked-crates.txt");
        fs::write(&table, list(&packages)).map_err(|e| format!("cannot write {}: {e}", table.display()))?;
        let _ = writeln!(source, "(\"linked-crates.txt\", include_bytes!({})),", literal(&table));
        for package in &packages {
            for file in &package.files {
                let name = file.file_name().unwrap_or_default().to_string_lossy();
                let _ = writeln!(source, "(\"{}/{name}\", include_bytes!({})),", package.name, literal(file));
            }
        }
    }
    source.push_str("];\n");
    let file = out.join("licenses.rs");
    fs::write(&file, source).map_err(|e| format!("cannot write {}: {e}", file.display()))
}

struct Package {
    /// Name and version, `serde-1.0.0`.
    name: String,
    license: String,
    files: Vec<PathBuf>,
}

/// The packages that the library links, this crate first.
fn linked(messages: &str) -> Result<Vec<Package>, String> {
    let folders: BTreeMap<String, PathBuf> = messages.lines().filter_map(built).collect();
    let own = format!("{}-", env::var("CARGO_PKG_NAME").map_err(|e| format!("CARGO_PKG_NAME: {e}"))?);
    let mut packages = Vec::new();
    for (name, license) in names()? {
        let folder = folders.get(&name).ok_or_else(|| format!("cargo did not say where it found {name}"))?;
        packages.push(Package { files: license_files(folder)?, name, license });
    }
    packages.sort_by_key(|package| (!package.name.starts_with(&own), package.name.clone()));
    Ok(packages)
}

/// The standard library of Rust, with the notices that the installation of the compiler holds.
fn standard_library() -> Result<Package, String> {
    let (version, sysroot) = (rustc("--version")?, rustc("--print=sysroot")?);
    let version = version.split(' ').nth(1).unwrap_or_default();
    let folder = Path::new(&sysroot).join("share/doc/rust");
    let files = ["COPYRIGHT-library.html", "licenses/Apache-2.0.txt", "licenses/MIT.txt"].map(|name| folder.join(name));
    let files: Vec<PathBuf> = files.into_iter().filter(|file| file.is_file()).collect();
    let elsewhere = format!(
        " (its notices are not in this Rust installation; see https://github.com/rust-lang/rust/tree/{version})"
    );
    let license = "MIT OR Apache-2.0".to_string() + if files.is_empty() { &elsewhere } else { "" };
    Ok(Package { name: format!("rust-standard-library-{version}"), license, files })
}

/// What the compiler answers.
fn rustc(question: &str) -> Result<String, String> {
    let rustc = env::var_os("RUSTC").ok_or("RUSTC is not set: run by cargo")?;
    let output = Command::new(rustc).arg(question).output().map_err(|e| format!("cannot run rustc: {e}"))?;
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_string())
}

/// `name-version` and licence of every package that the library links; what only runs inside the compiler is left out.
fn names() -> Result<BTreeMap<String, String>, String> {
    let target = env::var("TARGET").map_err(|e| format!("TARGET: {e}"))?;
    let cargo = env::var_os("CARGO").ok_or("CARGO is not set: run by cargo")?;
    let output = Command::new(cargo)
        .args(["tree", "--edges", "normal,no-proc-macro", "--prefix", "none", "--no-dedupe", "--format", "{p}|{l}"])
        .args(["--offline", "--locked", "--no-default-features", "--target", &target])
        .output()
        .map_err(|e| format!("cannot run cargo tree: {e}"))?;
    if !output.status.success() {
        return Err(format!("cargo tree: {}", String::from_utf8_lossy(&output.stderr)));
    }
    Ok(String::from_utf8_lossy(&output.stdout).lines().filter_map(name_and_license).collect())
}

/// From `serde v1.0.0 (folder)|MIT`.
fn name_and_license(line: &str) -> Option<(String, String)> {
    let (package, license) = line.rsplit_once('|')?;
    let (name, version) = package.split_once(" v")?;
    let version = version.split(' ').next()?;
    Some((format!("{name}-{version}"), license.to_string()))
}

/// `name-version` and folder of a crate that cargo built; its id ends with `#name@version`, or with `/name#version`.
fn built(message: &str) -> Option<(String, PathBuf)> {
    let message: Value = serde_json::from_str(message).ok()?;
    let manifest = Path::new(message["manifest_path"].as_str()?);
    let (source, version) = message["package_id"].as_str()?.rsplit_once('#')?;
    let named = version.split_once('@').or_else(|| Some((source.rsplit_once('/')?.1, version)));
    let (name, version) = named?;
    Some((format!("{name}-{version}"), manifest.parent()?.to_path_buf()))
}

/// The files of a folder that say under which licence it is.
pub fn license_files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("cannot read {}: {e}", folder.display()))?;
    let mut files: Vec<PathBuf> =
        entries.filter_map(|e| Some(e.ok()?.path())).filter(|p| is_license(p) && is_text(p)).collect();
    files.sort();
    Ok(files)
}

fn is_license(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_uppercase();
    ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE", "COPYRIGHT"].iter().any(|start| name.starts_with(start))
}

/// Whether a file holds more than where its text is: some crates pack a link as the path that it leads to.
fn is_text(path: &Path) -> bool {
    fs::read_to_string(path).is_ok_and(|text| text.trim().contains(char::is_whitespace))
}

fn list(packages: &[Package]) -> String {
    let mut text = String::from("Crates linked into the library, with their licences (SPDX).\n\n");
    for package in packages {
        let missing = if package.files.is_empty() { ", without a text of it in the package" } else { "" };
        let _ = writeln!(text, "{}: {}{missing}", package.name, package.license);
    }
    text
}
