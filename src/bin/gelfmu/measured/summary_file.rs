//! `summary.json` of a run, changed in one key: all other keys stay as the file has them.

use crate::failure::RunError;
use crate::results;
use ballistic_gel::output::{MOST_TABLE_BYTES, read_limited_text};
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;
use serde_json::value::RawValue;
use std::fmt;
use std::path::{Path, PathBuf};

/// Content of `summary.json`.
pub struct SummaryFile {
    path: PathBuf,
    keys: OrderedKeys,
    pub value: Value,
}

/// Keys of a JSON object in the order of the file, with the texts of their values.
struct OrderedKeys(Vec<(String, Box<RawValue>)>);

impl SummaryFile {
    /// Reads the file in the folder of a run.
    pub fn read(folder: &Path) -> Result<Self, RunError> {
        let path = folder.join("summary.json");
        let failed = |source| RunError::File { verb: "read", path: path.clone(), source };
        let text = read_limited_text(&path, MOST_TABLE_BYTES).map_err(failed)?;
        let parsed = serde_json::from_str(&text).and_then(|keys| Ok((keys, serde_json::from_str(&text)?)));
        let (keys, value) = parsed.map_err(|error| failed(error.into()))?;
        Ok(Self { path, keys, value })
    }

    /// Sets a key: in its place, or as the last one if it is new.
    pub fn set(&mut self, key: &str, value: &Value) {
        // As far in as a value of the object is.
        let text = format!("{value:#}").replace('\n', "\n  ");
        let value = RawValue::from_string(text).expect("a value is written as JSON");
        match self.keys.0.iter_mut().find(|(known, _)| known == key) {
            Some((_, old)) => *old = value,
            None => self.keys.0.push((key.to_owned(), value)),
        }
    }

    /// Writes the file; the old content stays until the new one is complete.
    pub fn write(&self) -> Result<(), RunError> {
        let text = serde_json::to_string_pretty(&self.keys).expect("texts of JSON can be written");
        results::replace(&self.path, format!("{text}\n").as_bytes())
    }
}

impl Serialize for OrderedKeys {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(key, value)| (key, value)))
    }
}

impl<'de> Deserialize<'de> for OrderedKeys {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(OrderedVisitor)
    }
}

/// Visitor of an object that keeps the order of its keys.
struct OrderedVisitor;

impl<'de> Visitor<'de> for OrderedVisitor {
    type Value = OrderedKeys;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the object of a summary")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<OrderedKeys, A::Error> {
        std::iter::from_fn(|| map.next_entry().transpose()).collect::<Result<_, _>>().map(OrderedKeys)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tool may have sorted the keys, as `jq -S` does, so that `measured` is not the last.
    #[test]
    fn the_other_keys_stay_in_their_order_and_to_the_digit_wherever_measured_stands() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("summary.json");
        let rewritten = |text: &str| {
            std::fs::write(&path, text).unwrap();
            let mut summary = SummaryFile::read(folder.path()).unwrap();
            summary.set("measured", &serde_json::json!({ "file": "lab.csv" }));
            summary.write().unwrap();
            std::fs::read_to_string(&path).unwrap()
        };
        let [before, new, after] = [
            "  \"end_time\": 1.50e-4,\n",
            "  \"measured\": {\n    \"file\": \"lab.csv\"\n  }",
            "  \"a\": [\n    0.1,\n    null\n  ]",
        ];
        let sorted = rewritten(&format!("{{\n{before}  \"measured\": 1,\n{after}\n}}\n"));
        assert_eq!(sorted, format!("{{\n{before}{new},\n{after}\n}}\n"));
        assert_eq!(rewritten(&sorted), sorted);
        assert_eq!(rewritten(&format!("{{\n{before}{after}\n}}\n")), format!("{{\n{before}{after},\n{new}\n}}\n"));
    }

    #[test]
    fn a_summary_that_is_cut_short_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("summary.json"), "{\n  \"scene\": \"fbi-bb\"").unwrap();
        let error = SummaryFile::read(folder.path()).err().unwrap().to_string();
        assert!(error.contains("summary.json") && error.contains("EOF"), "{error}");
    }
}
