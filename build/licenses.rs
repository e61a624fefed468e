//! Licences of every crate that ends up in the library, for the archive's `documentation/licenses/`.

use crate::library::literal;
use serde_json::Value;
use std::collections::BTreeSet;
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
    let linked = names()?;
    let metadata: Value = serde_json::from_str(&cargo(&["metadata", "--format-version", "1"])?)
        .map_err(|e| format!("cargo metadata: {e}"))?;
    let packages = items(&metadata["packages"]).map(package).collect::<Result<Vec<Package>, String>>()?;
    let mut packages: Vec<Package> = packages.into_iter().filter(|p| linked.contains(&p.folder())).collect();
    packages.sort_by_key(|p| (p.name != "ballistic-gel", p.folder()));
    Ok(packages)
}

/// `name-version` of every package that the library links; what only runs inside the compiler is left out.
fn names() -> Result<BTreeSet<String>, String> {
    let target = env::var("TARGET").map_err(|e| format!("TARGET: {e}"))?;
    let tree = cargo(&["tree", "--edges", "normal,no-proc-macro", "--prefix", "none", "--target", &target])?;
    let name =
        |line: &str| Some(line.split_once(" v")?.0.to_string() + "-" + line.split_once(" v")?.1.split(' ').next()?);
    Ok(tree.lines().filter_map(name).collect())
}

fn cargo(arguments: &[&str]) -> Result<String, String> {
    let cargo = env::var_os("CARGO").ok_or("CARGO is not set: run by cargo")?;
    let output = Command::new(cargo)
        .args(arguments)
        .args(["--offline", "--locked", "--no-default-features"])
        .output()
        .map_err(|e| format!("cannot run cargo {}: {e}", arguments[0]))?;
    if !output.status.success() {
        return Err(format!("cargo {}: {}", arguments[0], String::from_utf8_lossy(&output.stderr)));
    }
    String::from_utf8(output.stdout).map_err(|e| format!("cargo {}: {e}", arguments[0]))
}

fn items(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn package(value: &Value) -> Result<Package, String> {
    let text = |key: &str| value[key].as_str().unwrap_or_default().to_string();
    let (name, version, license) = (text("name"), text("version"), text("license"));
    let manifest = PathBuf::from(text("manifest_path"));
    let folder = manifest.parent().ok_or_else(|| format!("{} has no folder", manifest.display()))?;
    Ok(Package { name, version, license, files: license_files(folder)? })
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
