//! Whether the map is still true: the order of the modules, where `unsafe` is, how long files and functions are.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

#[path = "architecture/circles.rs"]
mod circles;
#[path = "architecture/code.rs"]
mod code;

use std::fs;
use std::path::{Path, PathBuf};

/// The modules from bottom to top: each uses only those before it.
const ORDER: [&str; 17] = [
    "math",
    "geometry",
    "constitutive",
    "mesh",
    "remesh",
    "fem",
    "ledger",
    "contact",
    "state",
    "integrator",
    "adapt",
    "reduced",
    "scene",
    "simulation",
    "output",
    "fmi2",
    "bin",
];
/// Where `unsafe` may be: the C interfaces of the FMU and of its partners.
const INTERFACES: [&str; 3] = ["src/fmi2/abi", "src/fmi2/abi.rs", "partners/src/fmi.rs"];
const LONGEST_FILE: usize = 500;
const LONGEST_FUNCTION: usize = 60;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every Rust file below a folder of the crate, in order of name.
fn rust_files(folder: &str) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> =
        fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    let below = |path: PathBuf| {
        let name = path.strip_prefix(root()).unwrap().to_str().unwrap().to_string();
        if path.is_dir() { rust_files(&name) } else { vec![PathBuf::from(name)] }
    };
    let files = entries.into_iter().flat_map(below);
    files.filter(|path| path.extension().is_some_and(|extension| extension == "rs")).collect()
}

fn text(file: &Path) -> String {
    fs::read_to_string(root().join(file)).unwrap()
}

/// The module of a file below `src/`; none for the root of the crate.
fn module(file: &Path) -> Option<String> {
    let first = file.components().nth(1)?.as_os_str().to_str()?.trim_end_matches(".rs").to_string();
    (first != "lib").then_some(first)
}

fn rank(module: &str) -> Option<usize> {
    ORDER.iter().position(|known| *known == module)
}

#[test]
fn modules_use_only_those_below_them() {
    for file in rust_files("src") {
        let Some(own) = module(&file) else { continue };
        let height = rank(&own);
        assert!(
            height.is_some(),
            "{}: module {own} has no place in the order of tests/architecture.rs",
            file.display()
        );
        for used in code::used_modules(&code::without_comments(&text(&file))) {
            let below = rank(&used).is_none_or(|rank| Some(rank) <= height);
            assert!(below, "{}: {own} uses {used}, which stands above it", file.display());
        }
    }
}

#[test]
fn unsafe_code_is_in_the_interfaces_alone() {
    let outside = |file: &PathBuf| !INTERFACES.iter().any(|interface| file.starts_with(interface));
    for file in ["src", "partners", "studies"].into_iter().flat_map(rust_files).filter(outside) {
        let (code, place) = (code::without_comments(&text(&file)), file.display());
        assert!(!code::words(&code).any(|word| word == "unsafe"), "{place}: unsafe belongs to {INTERFACES:?}");
    }
}

#[test]
fn files_and_functions_are_short() {
    for file in ["src", "tests", "partners", "studies"].into_iter().flat_map(rust_files) {
        let text = text(&file);
        let lines = text.lines().count();
        assert!(lines <= LONGEST_FILE, "{}: {lines} lines, at most {LONGEST_FILE}", file.display());
        for (name, length) in code::functions(&code::without_comments(&text)) {
            let place = file.display();
            assert!(length <= LONGEST_FUNCTION, "{place}: {name} has {length} lines, at most {LONGEST_FUNCTION}");
        }
    }
}

#[test]
fn the_map_names_every_room() {
    let map = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    for room in ORDER {
        assert!(map.contains(&format!("\n| `{room}` |")), "ARCHITECTURE.md has no row for {room}");
    }
}

/// Words that tell nothing of the thing that a doc comment documents.
const OPENINGS: [&str; 11] =
    ["What", "Whether", "Of", "That", "Those", "Which", "The same", "As", "Where", "How", "Who"];

#[test]
fn doc_comments_open_with_the_name_of_their_thing() {
    let mut faults = vec![];
    for file in rust_files("src") {
        let text = text(&file);
        for (number, line) in code::first_doc_lines(&text) {
            let opens = |opening: &&&str| line.strip_prefix(**opening).is_some_and(|rest| rest.starts_with([' ', ',']));
            if OPENINGS.iter().find(opens).is_some() {
                faults.push(format!("{}:{number}: {line}", file.display()));
            }
        }
    }
    assert!(faults.is_empty(), "{} doc comments:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn names_of_types_are_unique() {
    let mut places = std::collections::BTreeMap::<String, Vec<String>>::new();
    for file in rust_files("src") {
        let code = code::without_tests(&code::without_comments(&text(&file)));
        // One type of a name for each of some platforms is one type.
        for name in code::types(&code).into_iter().collect::<std::collections::BTreeSet<_>>() {
            places.entry(name).or_default().push(file.display().to_string());
        }
    }
    let twice: Vec<String> = places
        .iter()
        .filter(|(_, places)| places.len() > 1)
        .map(|(name, places)| format!("{name}: {}", places.join(", ")))
        .collect();
    assert!(twice.is_empty(), "{} names:\n{}", twice.len(), twice.join("\n"));
}

#[test]
fn no_room_has_a_circle_of_files() {
    let path = |file: &PathBuf| file.strip_prefix("src").unwrap().to_str().unwrap().to_owned();
    let files = rust_files("src").into_iter().map(|file| (path(&file), text(&file)));
    let circles = circles::SourceTree::new(files).circles();
    let list = |circle: &Vec<String>| format!("{} files: {}", circle.len(), circle.join(", "));
    assert!(circles.is_empty(), "circles of files:\n{}", circles.iter().map(list).collect::<Vec<_>>().join("\n"));
}

#[test]
fn circles_of_files_are_found() {
    let room = |c: &str| {
        let files = [("a/mod.rs", "pub use b::B;"), ("a/b.rs", "use super::c::C;\npub struct B;"), ("a/c.rs", c)];
        circles::SourceTree::new(files.map(|(path, code)| (path.to_owned(), code.to_owned()))).circles()
    };
    assert!(room("pub struct C; // super::B").is_empty());
    assert_eq!(room("use super::{super::x, B};\npub struct C;"), [["a::b", "a::c"]]);
    assert_eq!(room("pub struct C { b: super::b::B }"), [["a::b", "a::c"]]);
}

const SAMPLE: &str = r#"
use crate::mesh::Mesh; // not crate::fmi2
use crate::{math::{Vector, det}, state};
/* crate::output and unsafe */
fn short(a: [u8; 2]) -> char { let _ = "unsafe { crate::bin"; '{' }
fn declared();
impl X {
    fn long<'a>(&'a self) -> String {
        format!("}}{}", '"')
    }
}
"#;

#[test]
fn code_is_told_from_comments_and_strings() {
    let code = code::without_comments(SAMPLE);
    assert_eq!(code::used_modules(&code), ["mesh", "math", "state"]);
    assert!(!code::words(&code).any(|word| word == "unsafe"));
    assert!(code::words(&code::without_comments("'a' unsafe {}")).any(|word| word == "unsafe"));
    assert_eq!(code::functions(&code), [("short".to_string(), 1), ("long".to_string(), 3)]);
}
