//! Licences of every crate that ends up in the library, for the archive's `documentation/licenses/`.

use crate::library::literal;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::env;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Copies the licence files into the build and writes the Rust source that lists them: (path in the archive, bytes).
pub fn collect(wanted: bool, out: &Path) -> Result<(), String> {
    let mut source = String::from(
        "/// Licences: path below `documentation/licenses/`, and bytes.\npub static LICENSES: &[(&str, &[u8])] = &[\n",
    );
    if wanted {
        let packages = linked()?;
        let table = out.join("linked-crates.txt");
        fs::write(&table, list(&packages)).map_err(|e| format!("cannot write {}: {e}", table.display()))?;
        let _ = writeln!(source, "(\"linked-crates.txt\", include_bytes!({})),", literal(&table));
        for package in &packages {
            for file in &package.files {
                let name = file.file_name().unwrap_or_default().to_string_lossy();
                let _ = writeln!(source, "(\"{}/{name}\", include_bytes!({})),", package.folder(), literal(file));
            }
        }
    }
    source.push_str("];\n");
    let file = out.join("licenses.rs");
    fs::write(&file, source).map_err(|e| format!("cannot write {}: {e}", file.display()))
}

struct Package {
    name: String,
    version: String,
    license: String,
    files: Vec<PathBuf>,
}

impl Package {
    fn folder(&self) -> String {
        format!("{}-{}", self.name, self.version)
    }
}

/// The packages that the library links, this crate first.
fn linked() -> Result<Vec<Package>, String> {
    let metadata = metadata()?;
    let nodes: BTreeMap<&str, &Value> =
        items(&metadata["resolve"]["nodes"]).filter_map(|n| Some((n["id"].as_str()?, n))).collect();
    let root = metadata["resolve"]["root"].as_str().ok_or("cargo metadata names no root package")?;
    let macros: BTreeSet<&str> =
        items(&metadata["packages"]).filter(|p| is_macro(p)).filter_map(|p| p["id"].as_str()).collect();
    let mut reached = BTreeSet::new();
    let mut open = vec![root];
    while let Some(id) = open.pop() {
        if !macros.contains(id) && reached.insert(id) {
            open.extend(items(&nodes[id]["deps"]).filter(|d| normal(d)).filter_map(|d| d["pkg"].as_str()));
        }
    }
    let mut packages: Vec<Package> = items(&metadata["packages"])
        .filter(|p| p["id"].as_str().is_some_and(|id| reached.contains(id)))
        .map(package)
        .collect::<Result<_, String>>()?;
    packages.sort_by(|a, b| {
        (a.name != "ballistic-gel", &a.name, &a.version).cmp(&(b.name != "ballistic-gel", &b.name, &b.version))
    });
    Ok(packages)
}

fn metadata() -> Result<Value, String> {
    let cargo = env::var_os("CARGO").ok_or("CARGO is not set: run by cargo")?;
    let target = env::var("TARGET").map_err(|e| format!("TARGET: {e}"))?;
    let output = Command::new(cargo)
        .args(["metadata", "--format-version", "1", "--offline", "--locked", "--no-default-features"])
        .args(["--filter-platform", &target])
        .output()
        .map_err(|e| format!("cannot run cargo metadata: {e}"))?;
    if !output.status.success() {
        return Err(format!("cargo metadata: {}", String::from_utf8_lossy(&output.stderr)));
    }
    serde_json::from_slice(&output.stdout).map_err(|e| format!("cargo metadata: {e}"))
}

fn items(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn normal(dependency: &Value) -> bool {
    items(&dependency["dep_kinds"]).any(|kind| kind["kind"].is_null())
}

/// Whether a package only runs inside the compiler.
fn is_macro(package: &Value) -> bool {
    items(&package["targets"]).any(|target| items(&target["kind"]).any(|kind| kind == "proc-macro"))
}

fn package(value: &Value) -> Result<Package, String> {
    let text = |key: &str| value[key].as_str().unwrap_or_default().to_string();
    let manifest = PathBuf::from(text("manifest_path"));
    let folder = manifest.parent().ok_or_else(|| format!("{} has no folder", manifest.display()))?;
    Ok(Package {
        name: text("name"),
        version: text("version"),
        license: text("license"),
        files: license_files(folder)?,
    })
}

/// The files of a folder that say under which licence it is.
pub fn license_files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("cannot read {}: {e}", folder.display()))?;
    let mut files: Vec<PathBuf> =
        entries.filter_map(|e| Some(e.ok()?.path())).filter(|p| p.is_file() && is_license(p)).collect();
    files.sort();
    Ok(files)
}

fn is_license(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_uppercase();
    ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE", "COPYRIGHT"].iter().any(|start| name.starts_with(start))
}

fn list(packages: &[Package]) -> String {
    let mut text = String::from("Crates linked into the library, with their licences (SPDX).\n\n");
    for package in packages {
        let _ = writeln!(text, "{} {}: {}", package.name, package.version, package.license);
    }
    text
}
