//! Use of files by files, and circles in it.

use crate::code;
use std::collections::{BTreeMap, BTreeSet};

/// Source files by their module path.
pub struct SourceTree(BTreeMap<Vec<String>, SourceFile>);

/// Paths that a file names, and items that it defines for others.
struct SourceFile {
    paths: Vec<Vec<String>>,
    items: BTreeSet<String>,
}

/// Module path of the command, whose `crate` is its own.
const COMMAND: [&str; 2] = ["bin", "gelfmu"];

impl SourceTree {
    /// Reads files, each as its path below `src/` and its text.
    pub fn new(files: impl IntoIterator<Item = (String, String)>) -> Self {
        let module = |path: String| {
            let path = path.trim_end_matches(".rs").trim_end_matches("/mod").to_owned();
            path.split('/').map(str::to_owned).collect()
        };
        let file = |text: String| {
            let code = code::without_tests(&code::without_comments(&text));
            SourceFile { paths: code::paths(&code), items: code::items(&code).collect() }
        };
        Self(files.into_iter().map(|(path, text)| (module(path), file(text))).collect())
    }

    /// Returns the files of each room that are in a circle: each uses the next one, and so on back to it.
    pub fn circles(&self) -> Vec<Vec<String>> {
        let mut rooms = BTreeMap::<&str, BTreeMap<&[String], BTreeSet<&[String]>>>::new();
        for (file, source) in &self.0 {
            rooms.entry(&file[0]).or_default().insert(file, self.used_by(file, source));
        }
        let circles = rooms.into_values().map(|uses| in_circles(uses).iter().map(|file| file.join("::")).collect());
        circles.filter(|circle: &Vec<String>| !circle.is_empty()).collect()
    }

    /// Returns the other files of its room whose items a file names.
    fn used_by(&self, file: &[String], source: &SourceFile) -> BTreeSet<&[String]> {
        let paths = source.paths.iter().filter_map(|path| self.resolve(file, path));
        paths.filter(|used| *used != file && used[0] == file[0]).collect()
    }

    /// Returns the file that defines what a path in a file names; re-exports are followed by the name of the item.
    fn resolve(&self, file: &[String], path: &[String]) -> Option<&[String]> {
        let ups = path.iter().take_while(|name| *name == "super").count();
        let own = path.first().is_some_and(|name| name == "crate");
        let (mut module, mut rest) = if own {
            let is_command = file.starts_with(&COMMAND.map(str::to_owned));
            (COMMAND.iter().filter(|_| is_command).map(|name| (*name).to_owned()).collect(), &path[1..])
        } else if ups > 0 {
            (file[..file.len().checked_sub(ups)?].to_vec(), &path[ups..])
        } else {
            return None;
        };
        while let Some(name) = rest.first() {
            module.push(name.clone());
            if !self.0.contains_key(&module) {
                module.pop();
                break;
            }
            rest = &rest[1..];
        }
        let (item, room) = (rest.first()?, module.first()?);
        let here = self.0.get_key_value(&module).filter(|(_, source)| source.items.contains(item));
        let there = || self.0.iter().find(|(file, source)| file[0] == *room && source.items.contains(item));
        here.or_else(there).map(|(file, _)| file.as_slice())
    }
}

/// Removes what uses nothing that is left, and what nothing left uses, until only circles are left.
fn in_circles<'a>(mut uses: BTreeMap<&'a [String], BTreeSet<&'a [String]>>) -> Vec<&'a [String]> {
    loop {
        let left: BTreeSet<&[String]> = uses.keys().copied().collect();
        for used in uses.values_mut() {
            used.retain(|file| left.contains(file));
        }
        let named: BTreeSet<&[String]> = uses.values().flatten().copied().collect();
        uses.retain(|file, used| !used.is_empty() && named.contains(file));
        if uses.len() == left.len() {
            return uses.into_keys().collect();
        }
    }
}
