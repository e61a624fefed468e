//! Locations of the dotted keys in a scene text.

use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Keys of a text with their locations, in no particular order.
pub(super) struct KeyLocations<'a> {
    text: &'a str,
    entries: Vec<KeyEntry>,
}

struct KeyEntry {
    key: String,
    name: Range<usize>,
    value: Range<usize>,
}

impl<'a> KeyLocations<'a> {
    pub(super) fn of(text: &'a str, table: &DeTable<'_>) -> Self {
        let mut places = Self { text, entries: Vec::new() };
        places.collect("", table);
        places
    }

    fn collect(&mut self, prefix: &str, table: &DeTable<'_>) {
        for (name, value) in table {
            let key = join(prefix, name.get_ref());
            self.entries.push(KeyEntry { key: key.clone(), name: name.span(), value: value.span() });
            self.collect_inner(&key, value);
        }
    }

    fn collect_inner(&mut self, key: &str, value: &Spanned<DeValue<'_>>) {
        match value.get_ref() {
            DeValue::Table(inner) => self.collect(key, inner),
            DeValue::Array(items) => {
                for (i, item) in items.iter().enumerate() {
                    let DeValue::Table(inner) = item.get_ref() else { continue };
                    let key = numbered(key, i);
                    self.entries.push(KeyEntry { key: key.clone(), name: item.span(), value: item.span() });
                    self.collect(&key, inner);
                }
            }
            _ => {}
        }
    }

    /// Key with the smallest name or value around `span`; empty if there is none.
    pub(super) fn key_at(&self, span: &Range<usize>) -> &str {
        let around = |r: &Range<usize>| r.start <= span.start && span.end <= r.end;
        let hits = self.entries.iter().filter(|e| around(&e.name) || around(&e.value));
        hits.min_by_key(|e| if around(&e.name) { e.name.len() } else { e.value.len() }).map_or("", |e| &e.key)
    }

    /// Line, from 1, on which `key` is set, or on which its table begins.
    pub(super) fn line_of(&self, key: &str) -> Option<usize> {
        let holds =
            |e: &&KeyEntry| key.strip_prefix(&e.key).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
        let nearest = self.entries.iter().filter(holds).max_by_key(|e| e.key.len())?;
        Some(line_at(self.text, nearest.name.start))
    }

    /// Names inside the table `key`, in the order of the text.
    pub(super) fn names_in(&self, key: &str) -> Vec<&str> {
        let parent = |e: &KeyEntry| e.key.rsplit_once('.').is_some_and(|(table, _)| table == key);
        let mut inner: Vec<&KeyEntry> = self.entries.iter().filter(|e| parent(e)).collect();
        inner.sort_unstable_by_key(|e| e.name.start);
        inner.into_iter().map(|e| &self.text[e.name.clone()]).collect()
    }
}

/// Dotted key of `name` inside the table `prefix`.
pub(super) fn join(prefix: &str, name: &str) -> String {
    if prefix.is_empty() { name.to_owned() } else { format!("{prefix}.{name}") }
}

/// Key of table number `i`, from 0, of a list: `fragment[1]` is the first.
pub(crate) fn numbered(key: &str, i: usize) -> String {
    format!("{key}[{}]", i + 1)
}

/// Line, from 1, of a byte of the text.
pub(super) fn line_at(text: &str, byte: usize) -> usize {
    1 + text.as_bytes().iter().take(byte).filter(|&&b| b == b'\n').count()
}
