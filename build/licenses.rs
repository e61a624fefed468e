//! Licences of every crate that ends up in the library, for the archive's `documentation/licenses/`.

use crate::library::literal;
use serde_json::Value;
use std::collections::BTreeMap;
use std::env;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// SPDX texts for packages that come without one: identifier and file of `build/licenses/`.
const STANDARD_TEXTS: [(&str, &str); 2] =
    [("MIT", include_str!("licenses/MIT.txt")), ("Apache-2.0", include_str!("licenses/Apache-2.0.txt"))];

/// Writes the index of licences and the Rust source that names every licence file: (path in the archive, bytes).
/// `messages` are those of cargo about the library of a release. A development build names the licences of the crates that it links,
/// without their texts.
pub fn collect(messages: Option<&str>, out: &Path) -> Result<(), String> {
    let mut packages = if let Some(messages) = messages { linked(messages, out)? } else { named()? };
    packages.push(standard_library(out)?);
    let mut source = String::from(
        "/// Licences: path below `documentation/licenses/`, and bytes.\npub static LICENSES: &[(&str, &[u8])] = &[\n",
    );
    for (name, text) in [("license.html", index(&packages)?), ("linked-crates.txt", list(&packages))] {
        let file = written(out.join(name), &text)?;
        let _ = writeln!(source, "({name:?}, include_bytes!({})),", literal(&file));
    }
    for package in &packages {
        for file in &package.files {
            let path = package.path_of(file);
            let _ = writeln!(source, "({path:?}, include_bytes!({})),", literal(file));
        }
    }
    source.push_str("];\n");
    written(out.join("licenses.rs"), &source).map(drop)
}

fn written(file: PathBuf, text: &str) -> Result<PathBuf, String> {
    fs::write(&file, text).map_err(|e| format!("cannot write {}: {e}", file.display()))?;
    Ok(file)
}

struct Package {
    /// Name and version, `serde-1.0.0`.
    name: String,
    license: String,
    /// Texts of the licence: at least one in a release.
    files: Vec<PathBuf>,
}

impl Package {
    /// Path of a licence file below `documentation/licenses/`.
    fn path_of(&self, file: &Path) -> String {
        format!("{}/{}", self.name, file.file_name().unwrap_or_default().to_string_lossy())
    }
}

/// The packages that a development build links, this crate first: it alone with the texts of its licence.
fn named() -> Result<Vec<Package>, String> {
    let own = own_package()?;
    let folder = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").ok_or("CARGO_MANIFEST_DIR is not set: run by cargo")?);
    let files = |name: &str| if name.starts_with(&own) { license_files(&folder) } else { Ok(vec![]) };
    let package = |(name, license): (String, String)| Ok(Package { files: files(&name)?, name, license });
    let packages: Result<Vec<Package>, String> = names()?.into_iter().map(package).collect();
    packages.map(|packages| own_first(packages, &own))
}

/// Name of this crate as packages have it before their version.
fn own_package() -> Result<String, String> {
    Ok(format!("{}-", env::var("CARGO_PKG_NAME").map_err(|e| format!("CARGO_PKG_NAME: {e}"))?))
}

/// Sorts packages by name after this crate.
fn own_first(mut packages: Vec<Package>, own: &str) -> Vec<Package> {
    packages.sort_by_key(|package| (!package.name.starts_with(own), package.name.clone()));
    packages
}

/// The packages that the library of a release links, this crate first.
fn linked(messages: &str, out: &Path) -> Result<Vec<Package>, String> {
    let folders: BTreeMap<String, PathBuf> = messages.lines().filter_map(built).collect();
    let mut packages = Vec::new();
    for (name, license) in names()? {
        let folder = folders.get(&name).ok_or_else(|| format!("cargo did not say where it found {name}"))?;
        let mut files = license_files(folder)?;
        if files.is_empty() {
            files.push(standard_text(&name, &license, &authors(folder)?, out)?);
        }
        packages.push(Package { name, license, files });
    }
    Ok(own_first(packages, &own_package()?))
}

/// The authors that the manifest of a package names.
fn authors(folder: &Path) -> Result<String, String> {
    let manifest = folder.join("Cargo.toml");
    let text = fs::read_to_string(&manifest).map_err(|e| format!("cannot read {}: {e}", manifest.display()))?;
    let table: toml::Table = text.parse().map_err(|e| format!("{}: {e}", manifest.display()))?;
    let authors = table.get("package").and_then(|package| package.get("authors")?.as_array());
    let names: Vec<&str> = authors.into_iter().flatten().filter_map(toml::Value::as_str).collect();
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    Ok(if names.is_empty() { format!("the authors of {name}") } else { names.join(", ") })
}

/// The standard text of the first licence of an SPDX expression of which there is one, with the holders of the copyright.
fn standard_text(name: &str, license: &str, holders: &str, out: &Path) -> Result<PathBuf, String> {
    let known = |id: &str| STANDARD_TEXTS.into_iter().find(|(known, _)| *known == id);
    let mut ids = license.split(|c: char| c.is_whitespace() || "()/".contains(c));
    let (id, text) = ids.find_map(known).ok_or_else(|| {
        format!("{name} comes without a text of its licence, {license}: put its SPDX text into build/licenses/ and build/licenses.rs")
    })?;
    let folder = out.join("licenses").join(name);
    fs::create_dir_all(&folder).map_err(|e| format!("cannot make {}: {e}", folder.display()))?;
    let notice = "The package states its licence without a text of it: this is the standard text of SPDX.\n\n";
    let text = text.replace("<year> <copyright holders>", holders);
    written(folder.join(format!("{id}.txt")), &format!("{notice}{text}"))
}

/// The standard library of Rust, with the notices that the installation of the compiler holds.
fn standard_library(out: &Path) -> Result<Package, String> {
    let (version, sysroot) = (rustc("--version")?, rustc("--print=sysroot")?);
    let version = version.split(' ').nth(1).unwrap_or_default();
    let folder = Path::new(&sysroot).join("share/doc/rust");
    let files = ["COPYRIGHT-library.html", "licenses/Apache-2.0.txt", "licenses/MIT.txt"].map(|name| folder.join(name));
    let mut files: Vec<PathBuf> = files.into_iter().filter(|file| file.is_file()).collect();
    let (name, mut license) = (format!("rust-standard-library-{version}"), "MIT OR Apache-2.0".to_string());
    if files.is_empty() {
        files.push(standard_text(&name, &license, "The Rust Project Contributors", out)?);
        let _ = write!(
            license,
            " (its notices are not in this Rust installation; see https://github.com/rust-lang/rust/tree/{version})"
        );
    }
    Ok(Package { name, license, files })
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
        let _ = writeln!(text, "{}: {}", package.name, package.license);
    }
    text
}

/// `license.html`, where FMI 2.0.5 looks for it: the licences of this crate, and an index of all texts.
fn index(packages: &[Package]) -> Result<String, String> {
    let own = packages.first().ok_or("cargo names no package of the library")?;
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Licences</title></head><body>\n\
         <h1>Licences</h1>\n<p>{} is licensed under {}, at your option. So is this FMU, but for what it links, which is listed \
         below.</p>\n",
        escaped(&own.name),
        escaped(&own.license)
    );
    for file in &own.files {
        let text = fs::read_to_string(file).map_err(|e| format!("cannot read {}: {e}", file.display()))?;
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let _ = writeln!(page, "<h2>{}</h2>\n<pre>{}</pre>", escaped(&name), escaped(&text));
    }
    page += "<h2>Linked packages</h2>\n";
    if packages.iter().any(|package| package.files.is_empty()) {
        page += "<p>The texts of their licences are in the FMUs of a released program.</p>\n";
    }
    page += "<ul>\n";
    for package in packages {
        let links: Vec<String> = package.files.iter().map(|file| link(&package.path_of(file))).collect();
        let (name, license) = (escaped(&package.name), escaped(&package.license));
        let texts = if links.is_empty() { String::new() } else { format!(": {}", links.join(", ")) };
        let _ = writeln!(page, "<li><b>{name}</b>, {license}{texts}</li>");
    }
    Ok(page + "</ul>\n</body></html>\n")
}

fn link(path: &str) -> String {
    let name = path.rsplit('/').next().unwrap_or(path);
    format!("<a href=\"{}\">{}</a>", escaped(path).replace('+', "%2B"), escaped(name))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
